"""Local potential flow: a fit to the velocities of neighbours and across walls.

Waves are irrotational. The part of a velocity beyond the gradient of a harmonic function is a numerical error:
roughness, a residual divergence, or a vortex that small errors of the pressure gradient drive for many periods.
"""

from typing import NamedTuple

import numpy as np

from parisph.base.fields import BALLISTIC, DRY, FLUID, INNER, WALL, WET
from parisph.kernels import harmonic, monomials
from parisph.kernels.jit import inlined, kernel, subkernel
from parisph.kernels.near import fill_up, gather_within, room_for
from parisph.kernels.records import Cloud


class Potential(NamedTuple):
    """The potential flow closest to a velocity.

    beyond : (n_owned, dim) [m/s], the velocity of fluid minus the fit
    gradient : (n_owned, dim, dim) [1/s], velocity gradient at fluid and wet walls, relative to the tank
    square : (n_owned,) [1/s^2], the sum of the squares of its second derivatives
    """

    beyond: np.ndarray
    gradient: np.ndarray
    square: np.ndarray


@kernel
def fit_potential(out: Potential, cloud: Cloud, u: np.ndarray, across: harmonic.Slopes, radius: float) -> None:
    """Fit u = grad f around fluid and wet walls, with a harmonic polynomial f of degree 3.

    The degree is 2 where data are too few, as at walls in the edges of a box. The data are the velocities of the fluid
    within the radius, the particle itself included, and those across walls. All outputs are 0 where the data do not
    determine f.

    u : (n_all, dim) [m/s]; across : n . u of walls with one normal [m/s]; radius : of the weight [m]
    """
    kind, role, indptr, axes = cloud.kind, cloud.role, cloud.indptr, cloud.axes
    dim, room, size, less = len(axes), room_for(indptr), harmonic.terms(3, axes), harmonic.terms(2, axes)
    fit, member = harmonic.fit_of(room, axes), np.empty(room, np.int32)
    near, v = np.empty((dim, room)), np.empty((dim, room))
    weight, sums = np.empty((monomials.ROOM if dim == 3 else 1, room)), np.empty((monomials.ROOM, 4))
    unit, fluid = harmonic.UNIT * radius, _only_fluid(cloud)
    for i in range(len(indptr) - 1):
        out.square[i], out.beyond[i, :], out.gradient[i, :, :] = 0.0, 0.0, 0.0
        if role[i] == BALLISTIC or (kind[i] == WALL and role[i] != WET):
            continue
        n = gather_within(near, member, 0, i, fluid, unit, radius)
        if kind[i] == FLUID:
            member[n] = i
            for a in range(dim):
                near[a, n] = 0.0
            n += 1
        m = fill_up(near, n, axes)
        harmonic.weigh(weight, near, m, axes)
        _velocities(v, u, member, n, m, axes)
        last = harmonic.add_slopes(fit, 0, i, cloud, across, 0.0, 1.0, radius)
        data, sound = dim * n + last, False
        if data > size:
            harmonic.assemble(fit, last, size, axes)
            _add_moments(fit, weight, sums, near, v, m, (size, axes))
            sound = harmonic.solve(fit, size, less, np.inf, axes)
        if data > less and not sound:    # not a loop: the code is faster with constant sizes
            harmonic.assemble(fit, last, less, axes)
            _add_moments(fit, weight, sums, near, v, m, (less, axes))
            sound = harmonic.solve(fit, less, less, np.inf, axes)
        if sound:
            out.square[i] = _curve(out.gradient, i, fit.right, unit, axes)
            for a in range(dim if kind[i] == FLUID else 0):
                out.beyond[i, a] = u[i, a] - fit.right[a]


@subkernel
def _only_fluid(cloud):
    """Return the cloud with all fluid and no wall in stencils."""
    x, kind, _, normal, corner, volume, indptr, indices, spacing, axes = cloud
    role = np.where(kind == FLUID, np.int8(INNER), np.int8(DRY))
    return Cloud(x, kind, role, normal, corner, volume, indptr, indices, spacing, axes)


@inlined
def _velocities(v, u, member, n, m, axes):
    """Write the velocities of n places to the first of m columns, and 0 to the others."""
    for k in range(n):
        j = np.uint32(member[k])
        for a in range(len(axes)):
            v[a, k] = u[j, a]
    for k in range(n, m):
        for a in range(len(axes)):
            v[a, k] = 0.0


@inlined
def _add_moments(fit, weight, sums, near, v, m, degree):
    """Add the moments of m velocities. degree : number of polynomials, in 2D of those that count, and the axes"""
    size, axes = degree
    if len(axes) == 3:
        monomials.add_moments(fit.work, fit.right, weight, sums, near, v, m, size)
    else:
        _add_plane_moments(fit, weight, near, v, m)


@inlined
def _add_plane_moments(fit, weight, near, v, m):
    """Add the moments of m velocities in 2D from nine sums: u - i v is a polynomial of x + i y."""
    work, right = fit.work, fit.right
    s, sx, sy, sd, se, sr, rx, ry, rr, r0, r1, r2, r3, r4, r5 = _sums(weight, near, v, m)
    work[0, 0] += s
    work[1, 1] += s
    work[2, 0] += 2.0 * sx
    work[2, 1] -= 2.0 * sy
    work[2, 2] += 4.0 * sr
    work[3, 0] += sy
    work[3, 1] += sx
    work[3, 3] += sr
    work[4, 0] += sd
    work[4, 1] -= se
    work[4, 2] += 6.0 * rx
    work[4, 3] -= 3.0 * ry
    work[4, 4] += 9.0 * rr
    work[5, 0] += se
    work[5, 1] += sd
    work[5, 2] += 6.0 * ry
    work[5, 3] += 3.0 * rx
    work[5, 5] += 9.0 * rr
    right[0] += r0
    right[1] += r1
    right[2] += 2.0 * r2
    right[3] += r3
    right[4] += r4
    right[5] += r5


@inlined
def _sums(weight, near, v, m):
    """Return nine weighted sums over m places, and six over velocities, as scalars, which stay in registers."""
    s, sx, sy, sd, se, sr, rx, ry, rr = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    r0, r1, r2, r3, r4, r5 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(m):
        w, x, y, p, q = weight[0, k], near[0, k], near[1, k], v[0, k], v[1, k]
        square, d, e = x * x + y * y, 3.0 * (x * x - y * y), 6.0 * x * y
        s += w
        sx += w * x
        sy += w * y
        sd += w * d
        se += w * e
        sr += w * square
        rx += w * square * x
        ry += w * square * y
        rr += w * square * square
        r0 += w * p
        r1 += w * q
        r2 += w * (x * p - y * q)
        r3 += w * (y * p + x * q)
        r4 += w * (d * p - e * q)
        r5 += w * (e * p + d * q)
    return s, sx, sy, sd, se, sr, rx, ry, rr, r0, r1, r2, r3, r4, r5


@inlined
def _curve(gradient, i, c, unit, axes):
    """Write the second derivatives from the coefficients of degree 2; return the sum of their squares."""
    if len(axes) == 2:
        gradient[i, 0, 0], gradient[i, 0, 1] = 2.0 * c[2] / unit, c[3] / unit
        gradient[i, 1, 0], gradient[i, 1, 1] = gradient[i, 0, 1], -gradient[i, 0, 0]
    else:
        gradient[i, 0, 0], gradient[i, 1, 1] = 2.0 * c[3] / unit, 2.0 * (c[4] - c[3]) / unit
        gradient[i, 2, 2] = -2.0 * c[4] / unit
        gradient[i, 0, 1], gradient[i, 0, 2], gradient[i, 1, 2] = c[5] / unit, c[6] / unit, c[7] / unit
        gradient[i, 1, 0], gradient[i, 2, 0], gradient[i, 2, 1] = c[5] / unit, c[6] / unit, c[7] / unit
    total = 0.0
    for a in range(len(axes)):
        for e in range(len(axes)):
            total += gradient[i, a, e] ** 2
    return total
