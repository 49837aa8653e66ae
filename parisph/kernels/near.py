"""Neighbours of one particle in consecutive columns, for vector instructions.

near[a, k] is coordinate a of neighbour k relative to the particle. Loops over k have no branches, so that the compiler
processes LANES neighbours at a time. Columns are padded to a multiple of LANES with points so FAR away that their
weight is exactly zero, so that no scalar loop remains.
"""

import math
from typing import NamedTuple

import numpy as np

from parisph.kernels.jit import inlined, subkernel
from parisph.kernels.records import Cloud
from parisph.kernels.roles import outside
from parisph.kernels.smoothing import cubic_spline, cubic_spline_slope, quartic_weight

LANES = 8    # two vectors: with 4, loops unrolled by two leave a slow remainder (5 % of rows and densities)
FAR = 8.0  # in units of the radius of the weight

# Other weights of least squares: the cubic spline W whose support is the radius, and its slope -W'/r.
SPLINE, SPLINE_SLOPE = -1, -2


class Form(NamedTuple):
    """A linear fit by weighted least squares.

    radius : of the weight [m]; power : of the weight (`weights`)
    floor : value of det/(trace/dim)^dim of the neighbours' moment below which they are too few or too flat
    """

    radius: float
    power: int
    floor: float


@subkernel
def room_for(indptr: np.ndarray) -> int:
    """Return the number of columns that any row needs, including the particle itself."""
    longest = 0
    for i in range(len(indptr) - 1):
        longest = max(longest, indptr[i + 1] - indptr[i])
    return (longest + LANES) // LANES * LANES


# About half a spacing, squared. The weight 1/r^2 of a closer pair would exceed all others, and its pressure difference
# over its distance would be unbounded.
CLOSE = 0.0625    # tuned 0.03125 to 0.125: square of the distance in radii below which the weight 1/r^2 stays; judged


@inlined
def gather(near: np.ndarray, member: np.ndarray, first: int, i: int, cloud: Cloud, radius: float) -> np.int64:
    """Write the neighbours of i that stencils use, in units of the radius; return their number.

    near : (dim, columns from `room_for`); member : int32, their indices, from `first` on
    """
    x, axes = cloud.x, cloud.axes
    # unsigned indices, so that numba adds no test for negative ones
    n, start, scale, cx, cy = np.uint32(0), np.uint32(first), 1.0 / radius, x[i, 0], x[i, 1]
    cz = x[i, 2] if len(axes) == 3 else 0.0
    for k in range(np.uint32(cloud.indptr[i]), np.uint32(cloud.indptr[i + 1])):
        j = np.uint32(cloud.indices[k])
        member[np.uint32(start + n)] = j  # the next one overwrites it if j is not used
        near[0, n], near[1, n] = (x[j, 0] - cx) * scale, (x[j, 1] - cy) * scale
        if len(axes) == 3:
            near[2, n] = (x[j, 2] - cz) * scale
        n += np.uint32(not outside(cloud.role[j]))
    return np.int64(n)


@inlined
def gather_within(near: np.ndarray, member: np.ndarray, first: int, i: int, cloud: Cloud, radius: float,
                  reach: float) -> np.int64:
    """Write the neighbours as `gather` does, but only those within the reach."""
    x, axes = cloud.x, cloud.axes
    n, start, scale, cx, cy = np.uint32(0), np.uint32(first), 1.0 / radius, x[i, 0], x[i, 1]
    cz = x[i, 2] if len(axes) == 3 else 0.0
    limit2 = reach * reach
    for k in range(np.uint32(cloud.indptr[i]), np.uint32(cloud.indptr[i + 1])):
        j = np.uint32(cloud.indices[k])
        dx, dy = x[j, 0] - cx, x[j, 1] - cy
        r2 = dx * dx + dy * dy
        member[np.uint32(start + n)] = j
        near[0, n], near[1, n] = dx * scale, dy * scale
        if len(axes) == 3:
            dz = x[j, 2] - cz
            r2 += dz * dz
            near[2, n] = dz * scale
        n += np.uint32((not outside(cloud.role[j])) & (r2 < limit2))
    return np.int64(n)


@inlined
def fill_up(near: np.ndarray, n: int, axes: tuple[int, ...]) -> int:
    """Pad n columns with points of zero weight; return the number of columns in use."""
    m = (n + LANES - 1) // LANES * LANES
    for k in range(n, m):
        for a in range(len(axes)):
            near[a, k] = FAR
    return m


@inlined
def weigh(weighted: np.ndarray, near: np.ndarray, power: int, m: int, axes: tuple[int, ...]) -> None:
    """Write the least-squares weight of each neighbour (`weights`) and its products with the coordinates.

    weighted : (1 + dim, columns): w, then w near[a]
    """
    weights(weighted, near, power, m, axes)
    for a in range(len(axes)):
        for k in range(m):
            weighted[1 + a, k] = weighted[0, k] * near[a, k]


@inlined
def weights(weighted: np.ndarray, near: np.ndarray, power: int, m: int, axes: tuple[int, ...]) -> None:
    """Write the least-squares weight of each neighbour to row 0.

    It is SPLINE, SPLINE_SLOPE, or the quartic weight over r^power, with power 0 or 2. With 2, a coincident neighbour
    has no weight, and 1/r^2 stops growing at a quarter of the radius.
    """
    if power < 0:
        _weights_by_spline(weighted, near, power, m, axes)
        return
    for k in range(m):
        q2 = near[0, k] ** 2 + near[1, k] ** 2
        if len(axes) == 3:
            q2 += near[2, k] ** 2
        w = quartic_weight(q2, 1.0)
        if power == 2:
            w = w / max(q2, CLOSE) if q2 > 0.0 else 0.0
        weighted[0, k] = w


@inlined
def _weights_by_spline(weighted, near, power, m, axes):
    """Write weights by the cubic spline or its slope, lengths in units of its support 2h."""
    dim = len(axes)
    for k in range(m):
        q2 = 0.0
        for a in range(dim):
            q2 += near[a, k] ** 2
        r = math.sqrt(q2)
        w = cubic_spline(r, 0.5, dim) if power == SPLINE else -cubic_spline_slope(r, 0.5, dim)
        weighted[0, k] = w


@inlined
def sum_moments(moments: np.ndarray, q: int, weighted: np.ndarray, near: np.ndarray, m: int,
                axes: tuple[int, ...]) -> float:
    """Write the sums of w, w x_a and w x_a x_b (00, 10, 11, 20, 21, 22), with w in row 0, to column q.

    Returns the number of neighbours with a weight. The sums are scalars, which stay in registers.
    """
    dim = len(axes)
    found, s, sx, sy, xx, xy, yy = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(m):
        w, x, y = weighted[0, k], near[0, k], near[1, k]
        wx, wy = w * x, w * y
        found += 1.0 if w > 0.0 else 0.0
        s += w
        sx += wx
        sy += wy
        xx += wx * x
        xy += wx * y
        yy += wy * y
    moments[0, q], moments[1, q], moments[2, q] = s, sx, sy
    moments[1 + dim, q], moments[2 + dim, q], moments[3 + dim, q] = xx, xy, yy
    if dim == 3:
        sz, xz, yz, zz = 0.0, 0.0, 0.0, 0.0
        for k in range(m):
            z = near[2, k]
            wz = weighted[0, k] * z
            sz += wz
            xz += wz * near[0, k]
            yz += wz * near[1, k]
            zz += wz * z
        moments[3, q], moments[7, q], moments[8, q], moments[9, q] = sz, xz, yz, zz
    return found


@inlined
def sum_changes(sums: np.ndarray, weighted: np.ndarray, near: np.ndarray, change: np.ndarray, c: int, m: int,
                axes: tuple[int, ...]) -> None:
    """Write the sums of w f and w f x_a, (1 + dim,), with w in row 0 and f in row c of `change`."""
    s, sx, sy, sz = 0.0, 0.0, 0.0, 0.0
    for k in range(m):
        v = weighted[0, k] * change[c, k]
        s += v
        sx += v * near[0, k]
        sy += v * near[1, k]
        if len(axes) == 3:
            sz += v * near[2, k]
    sums[0], sums[1], sums[2] = s, sx, sy
    if len(axes) == 3:
        sums[3] = sz


@inlined
def dot(p: np.ndarray, r: int, q: np.ndarray, s: int, m: int) -> float:
    """Return sum_k p[r, k] q[s, k] over the first m columns."""
    total = 0.0
    for k in range(m):
        total += p[r, k] * q[s, k]
    return total


@inlined
def dot4(p: np.ndarray, r: int, w: np.ndarray, q: np.ndarray, s: int, m: int) -> tuple[float, float, float, float]:
    """Return sum_k p[r, k] w[0, k] q[s + t, k] for t = 0, 1, 2, 3."""
    t0, t1, t2, t3 = 0.0, 0.0, 0.0, 0.0
    for k in range(m):
        v = p[r, k] * w[0, k]
        t0 += v * q[s, k]
        t1 += v * q[s + 1, k]
        t2 += v * q[s + 2, k]
        t3 += v * q[s + 3, k]
    return t0, t1, t2, t3


@inlined
def height(i: int, wall: int, x: np.ndarray, normal: np.ndarray, axes: tuple[int, ...]) -> float:
    """Return the distance of particle i from the plane of a wall particle, positive inside."""
    h = 0.0
    for a in range(len(axes)):
        h += (x[i, a] - x[wall, a]) * normal[wall, a]
    return h
