"""Density ratio beside walls, completed by the kernel's integral over the visible solid.

    alpha_i full = sum_fluid W + [ sum_nodes (A s share W + s a.(x_i - x_k) b(r)) + sum_elements Omega F(r) ] / s^dim

F(r) is the integral of W q^(dim-1) from r to 2h, and Omega the angle of an element: the sum of Omega F is the integral
over the solid behind it. `share` is the part of a wall node's cell inside the fluid, and a its area vector. The end
correction b(r) of the trapezoidal rule, s/12 |W'|/r to leading order (Euler and Maclaurin), turns the sum over a
lattice that ends at a wall into the integral up to it. Its higher orders are a polynomial of r, fitted so that alpha =
1 without a gradient for each particle of a lattice before a flat wall.

The gradient sums that of the kernel over the same solid: sum_elements Omega e G(r), with the direction e to the element
and the integral G of |W'| q^(dim-1) from r to 2h. Unlike an integral over the wall, it includes the edge of what an
element hides.
"""

import math
from typing import NamedTuple

import numpy as np

from parisph.base.fields import FLUID, WALL
from parisph.kernels.jit import axes_of, inlined, kernel
from parisph.kernels.near import dot, room_for
from parisph.kernels.records import Cloud, Walls
from parisph.kernels.smoothing import cubic_spline, cubic_spline_slope
from parisph.kernels.surface import lattice_sum

ENTRIES = 1024    # table length
ORDER = 5         # of the polynomial of the end correction
GAUSS = math.sqrt(0.6)    # three points of Gauss's rule: 0 and +-GAUSS, with the weights 8/9 and 5/9
# six points of a triangle, exact up to the fourth degree (Dunavant 1985): coordinates of two corners, and weights
OF_SIDES, NEAR_SIDES = 0.445948490915965, 0.223381589678011
OF_CORNERS, NEAR_CORNERS = 0.091576213509771, 0.109951743655322    # those near corners, before them those near sides

# Rows of the scratch for triangles: nine coordinates of corners, the part that counts, and results.
PART, MEAN, WEIGHTS, PULL, VOLUME, BELOW, ANGLE = 9, 10, 11, 12, 15, 16, 17
R, F, G, Y, BEHIND = 18, 19, 20, 21, 24    # of one point of each: distance, entries of the table, place


class KernelTable(NamedTuple):
    """Tabulated integrals of a kernel.

    values : (ENTRIES + 2, 4) at r = 0 ... 2h in equal steps: F(r) [1], b(r) [m^(-dim-1)], b'(r)/r [m^(-dim-3)], G(r)
        [1/m]
    h : [m]; full : the kernel's sum over the lattice [m^-dim]
    """

    values: np.ndarray
    h: float
    full: float


def table(spacing: float, h: float, dim: int) -> KernelTable:
    """Return the KernelTable of the cubic spline. Takes some milliseconds."""
    full = lattice_sum(spacing, h, axes_of(dim))
    r = np.linspace(0.0, 2.0 * h, ENTRIES)
    w, slope = _kernel(r, h, dim)
    beyond = _integral_to_end(w * r ** (dim - 1), r)
    pull = w * r ** (dim - 1) + (dim - 1) * _integral_to_end(w * r ** (dim - 2), r)
    coefficients = _end_correction(spacing, h, dim)
    q = r / h
    b = -spacing / 12.0 * slope * np.polyval(coefficients, q)
    with np.errstate(divide="ignore", invalid="ignore"):
        by_r = np.gradient(b, r, edge_order=2) / r
    by_r[0] = by_r[1]
    values = np.zeros((ENTRIES + 2, 4))
    values[:ENTRIES] = np.stack([beyond, b, by_r, pull], axis=1)
    values[ENTRIES - 1 :] = 0.0
    return KernelTable(values, h, full)


def _kernel(r, h, dim):
    """Return W and W'/r at distances r, arrays of its shape."""
    w, slope = np.empty(r.size), np.empty(r.size)
    _evaluate(w, slope, np.ascontiguousarray(r).ravel(), h, axes_of(dim))
    return w.reshape(r.shape), slope.reshape(r.shape)


@kernel
def _evaluate(w, slope, r, h, axes):
    for k in range(len(r)):
        w[k], slope[k] = cubic_spline(r[k], h, len(axes)), cubic_spline_slope(r[k], h, len(axes))


def _integral_to_end(f, r):
    """Return the integral of f from each r to the last, by the trapezoidal rule corrected with the slopes."""
    step, slope = r[1] - r[0], np.gradient(f, r, edge_order=2)
    pieces = 0.5 * step * (f[1:] + f[:-1]) - step**2 / 12.0 * (slope[1:] - slope[:-1])
    return np.append(np.cumsum(pieces[::-1])[::-1], 0.0)


def _end_correction(spacing, h, dim):
    """Return the polynomial of q = r/h that multiplies the end correction, highest power first.

    At a distance d from a wall of a lattice of fluid, nodes and solid must replace the missing half of the lattice,
    including the gradient: exactly at d = s, 2s, ..., and by least squares elsewhere.
    """
    k = np.arange(-6, 7)
    side = k[:, None] if dim == 2 else np.stack(np.meshgrid(k, k), axis=-1).reshape(-1, 2)
    flat2 = spacing**2 * np.sum(side**2, axis=1)
    rows = np.arange(1, int(math.ceil(2.0 * h / spacing)))
    near = np.linspace(0.3 * spacing, 2.0 * h, 60)
    d = np.concatenate([spacing * rows, near])

    def lattice(z):    # kernel sum and its slope over a row of the lattice at a distance
        w, slope = _kernel(np.sqrt(flat2 + z[:, None] ** 2), h, dim)
        return w.sum(axis=1), z * slope.sum(axis=1)

    behind = [lattice(d + m * spacing) for m in range(len(rows) + 1)]
    wanted = sum(value for value, _ in behind) - 0.5 * behind[0][0] - _half_space(d, h, dim) / spacing**dim
    wanted_slope = sum(slope for _, slope in behind) - 0.5 * behind[0][1] + _plane(d, h, dim) / spacing**dim
    basis, slopes = _powers(d, flat2, spacing, h, dim)
    exact = slice(0, len(rows))
    must = np.concatenate([basis[exact], h * slopes[exact]]), np.concatenate([wanted[exact], h * wanted_slope[exact]])
    rest = slice(len(rows), None)
    may = np.concatenate([basis[rest], h * slopes[rest]]), np.concatenate([wanted[rest], h * wanted_slope[rest]])
    return _constrained(*must, *may)[::-1]


def _powers(d, flat2, spacing, h, dim):
    """Return the sums over a plane of nodes at distances d (n,) of the end correction times q^k, and their slopes."""
    def sums(z):
        r = np.sqrt(flat2 + z[:, None] ** 2)
        base = -spacing / 12.0 * z[:, None] * _kernel(r, h, dim)[1]
        return np.stack([(base * (r / h) ** k).sum(axis=1) for k in range(ORDER + 1)], axis=1)
    step = 1e-5 * h
    return sums(d), (sums(d + step) - sums(d - step)) / (2.0 * step)


def _constrained(must, value, may, wish):
    """Return the c that satisfies must c = value and minimises |may c - wish|."""
    u, sizes, vt = np.linalg.svd(must)
    rank = int(np.sum(sizes > 1e-10 * sizes[0]))
    start = vt[:rank].T @ ((u[:, :rank].T @ value) / sizes[:rank])
    free = vt[rank:].T
    return start + free @ np.linalg.lstsq(may @ free, wish - may @ start, rcond=None)[0]


def _half_space(d, h, dim):
    """Return the integral of the kernel over the half space beyond the distances d (n,)."""
    fine = np.linspace(0.0, 2.0 * h, 2001)
    return np.interp(d, fine, _integral_to_end(_plane(fine, h, dim), fine))


def _plane(d, h, dim):
    """Return the integral of the kernel over a plane (2D: line) at distances d (n,)."""
    t = np.linspace(0.0, 2.0 * h, 801)
    w = _kernel(np.sqrt(d[:, None] ** 2 + t**2), h, dim)[0]
    return np.trapz(w * (2.0 if dim == 2 else 2.0 * np.pi * t), t, axis=1)


@inlined
def _entry(table, column, r):
    """Return a table's value at r by linear interpolation, 0 beyond its end."""
    at = min(r * (ENTRIES - 1) / (2.0 * table.h), ENTRIES - 0.5)
    k = int(at)
    return table.values[k, column] + (at - k) * (table.values[k + 1, column] - table.values[k, column])


@kernel
def completed_density(ratio: np.ndarray, gradient: np.ndarray, cloud: Cloud, walls: Walls, weight: np.ndarray,
                      area: np.ndarray, table: KernelTable) -> None:
    """Write the kernel sum at owned fluid over its lattice value, completed by nodes and by the solid behind elements.

    ratio : (n_owned,), 1 at walls; gradient : (n_owned, dim) [1/m], 0 at walls; outputs
    weight : (n_all,), of fluid its initial cell over s^dim; of nodes the part of a cell inside the fluid; else 0
    area : (n_all, dim) area vector of nodes over s^(dim-1), else 0
    """
    x, indptr, indices, axes = cloud.x, cloud.indptr, cloud.indices, cloud.axes
    dim, h = len(axes), table.h
    mean = np.empty(dim)
    near, part = np.empty((dim, room_for(indptr))), np.empty((2, room_for(indptr)))
    behind = np.empty((BEHIND if dim == 3 else 0, room_for(walls.indptr)))
    for i in range(len(ratio)):
        ratio[i] = 1.0
        gradient[i, :] = 0.0
        if cloud.kind[i] != FLUID:
            continue
        first, count = indptr[i], indptr[i + 1] - indptr[i]
        for k in range(count):
            j = np.uint32(indices[first + k])
            for a in range(dim):
                near[a, k] = x[i, a] - x[j, a]
            part[0, k] = weight[j]
        total = weight[i] * cubic_spline(0.0, h, dim)
        for k in range(count):
            r2 = 0.0
            for a in range(dim):
                r2 += near[a, k] ** 2
            r = math.sqrt(r2)
            total += part[0, k] * cubic_spline(r, h, dim)
            part[1, k] = part[0, k] * cubic_spline_slope(r, h, dim)
        for a in range(dim):
            mean[a] = dot(part, 1, near, a, count)
        if walls.indptr[i] < walls.indptr[i + 1]:
            total += _nodes(mean, i, near, cloud, area, table)
            total = _solid(total, mean, behind, i, cloud, walls, table)
        ratio[i] = total / table.full
        for a in range(dim):
            gradient[i, a] = mean[a] / table.full


@inlined
def _nodes(mean, i, near, cloud, area, table):
    """Return the end correction by the nodes around particle i, and add its gradient to `mean`.

    near : (dim, neighbours) [m]
    """
    total = 0.0
    for k in range(cloud.indptr[i + 1] - cloud.indptr[i]):
        j = cloud.indices[cloud.indptr[i] + k]
        if cloud.kind[j] == WALL:
            r2, before, size2 = 0.0, 0.0, 0.0
            for a in range(len(cloud.axes)):
                r2 += near[a, k] ** 2
                before += near[a, k] * area[j, a]
                size2 += area[j, a] ** 2
            if size2 == 0.0 or r2 >= 4.0 * table.h * table.h:    # its part is zero
                continue
            r = math.sqrt(r2)
            slope, b = before * _entry(table, 2, r), _entry(table, 1, r)
            total += before * b
            for a in range(len(cloud.axes)):
                mean[a] += slope * near[a, k] + b * area[j, a]
    return total


@inlined
def _solid(total, mean, behind, i, cloud, walls, table):
    """Return a sum plus the integral of the kernel over the solid behind the elements that particle i sees, in cells.

    The integral of the kernel's gradient with respect to the particle's position is added to `mean`.

    behind : (BEHIND, elements) scratch in 3D
    """
    cell = cloud.spacing ** len(cloud.axes)
    if len(cloud.axes) == 3:
        return total + _behind_triangles(mean, behind, _gather_triangles(behind, i, cloud.x, walls, table), table, cell)
    for k in range(walls.indptr[i], walls.indptr[i + 1]):
        e = walls.indices[k]
        if walls.present[e] > 0.0:
            here, own = _behind_segment(i, cloud.x, e, walls.corners, table)
            total += walls.present[e] * here / cell
            mean[0] += walls.present[e] * own[0] / cell
            mean[1] += walls.present[e] * own[1] / cell
    return total


@inlined
def _behind_segment(i, x, e, corners, table):
    """Return the integrals of the kernel and of its gradient over the solid behind a segment; 0 behind the segment."""
    ax, ay = corners[e, 0, 0] - x[i, 0], corners[e, 0, 1] - x[i, 1]
    bx, by = corners[e, 1, 0] - x[i, 0], corners[e, 1, 1] - x[i, 1]
    cross = ax * by - ay * bx
    tx, ty = bx - ax, by - ay
    length = math.sqrt(tx * tx + ty * ty)
    height = cross / length
    if not 1e-9 * table.h < height < 2.0 * table.h:
        return 0.0, (0.0, 0.0)
    angle = math.atan2(cross, ax * bx + ay * by)
    la, lb = math.sqrt(ax * ax + ay * ay), math.sqrt(bx * bx + by * by)
    mx, my = ax / la + bx / lb, ay / la + by / lb    # bisector of the angle
    size = math.sqrt(mx * mx + my * my)
    mx, my = mx / size, my / size
    cosine, sine = math.cos(0.5 * angle * GAUSS), math.sin(0.5 * angle * GAUSS)
    total, px, py = 0.0, 0.0, 0.0
    for c in range(3):
        ux, uy = mx, my
        if c == 1:
            ux, uy = mx * cosine - my * sine, my * cosine + mx * sine
        elif c == 2:
            ux, uy = mx * cosine + my * sine, my * cosine - mx * sine
        r = cross / (ux * ty - uy * tx)
        part = angle * (8.0 if c == 0 else 5.0) / 18.0
        total += part * _entry(table, 0, r)
        force = part * _entry(table, 3, r)
        px += force * ux
        py += force * uy
    return total, (px, py)


@inlined
def _gather_triangles(behind, i, x, walls, table):
    """Write the corners, relative to particle i, and the parts that count of the triangles in front of which it is.

    Returns their number, with copies that do not count, to fill the last vector.
    """
    n = 0
    for k in range(walls.indptr[i], walls.indptr[i + 1]):
        e = walls.indices[k]
        height = -walls.shapes.plane[e, 3]
        for a in range(3):
            height += walls.shapes.plane[e, a] * x[i, a]
        if walls.present[e] > 0.0 and 1e-9 * table.h < height < 2.0 * table.h:
            for c in range(3):
                for a in range(3):
                    behind[3 * c + a, n] = walls.corners[e, c, a] - x[i, a]
            behind[PART, n] = walls.present[e]
            n += 1
    while n % 4:    # whole vectors
        for row in range(PART):
            behind[row, n] = behind[row, n - 1]
        behind[PART, n] = 0.0
        n += 1
    return n


@inlined
def _behind_triangles(mean, behind, n, table, cell):
    """Return the integral of the kernel over the solid behind n triangles, and add that of its gradient to `mean`."""
    _add_points(behind, n, table)
    total = 0.0
    for k in range(n):
        part = behind[PART, k] * behind[ANGLE, k] / behind[WEIGHTS, k] / cell
        total += part * behind[MEAN, k]
        for a in range(3):
            mean[a] += part * behind[PULL + a, k]
    return total


@inlined
def _add_points(behind, n, table):
    """Write the means of F and e G over the points of n triangles, times the sum of weights, that sum, and the angles.

    Six points, weighted by solid angle: three are near sides, each opposite to a corner, three near corners.
    """
    b, values, scale = behind, table.values, (ENTRIES - 1) / (2.0 * table.h)
    for row in range(MEAN, BEHIND):
        for k in range(n):
            b[row, k] = 0.0
    for s in range(6):
        others, weight = (OF_SIDES, NEAR_SIDES) if s < 3 else (OF_CORNERS, NEAR_CORNERS)
        own = 1.0 - 2.0 * others
        u, v, w = own if s % 3 == 0 else others, own if s % 3 == 1 else others, own if s % 3 == 2 else others
        for k in range(n):    # the first and the last of these loops are vectorised
            y0 = u * b[0, k] + v * b[3, k] + w * b[6, k]
            y1 = u * b[1, k] + v * b[4, k] + w * b[7, k]
            y2 = u * b[2, k] + v * b[5, k] + w * b[8, k]
            b[R, k] = math.sqrt(y0 * y0 + y1 * y1 + y2 * y2)
            b[Y, k], b[Y + 1, k], b[Y + 2, k] = y0, y1, y2
        for k in range(n):
            at = min(b[R, k] * scale, ENTRIES - 0.5)
            j = np.uint32(np.int32(at))    # unsigned, so that numba adds no test
            rest = at - j
            b[F, k] = values[j, 0] + rest * (values[j + 1, 0] - values[j, 0])
            b[G, k] = values[j, 3] + rest * (values[j + 1, 3] - values[j, 3])
        for k in range(n):
            by_r = 1.0 / b[R, k]
            part = weight * by_r * by_r * by_r
            force = b[G, k] * part * by_r
            b[MEAN, k] += b[F, k] * part
            b[WEIGHTS, k] += part
            for a in range(3):
                b[PULL + a, k] += force * b[Y + a, k]
    for k in range(n):
        first, second = (b[0, k], b[1, k], b[2, k]), (b[3, k], b[4, k], b[5, k])
        b[VOLUME, k], b[BELOW, k] = _solid_angle(first, second, (b[6, k], b[7, k], b[8, k]))
    for k in range(n):
        b[ANGLE, k] = -2.0 * math.atan2(b[VOLUME, k], b[BELOW, k])


@inlined
def _solid_angle(a, b, c):
    """Return y, x such that the solid angle of a triangle, positive from the fluid's side, is -2 atan2(y, x).

    van Oosterom & Strackee 1983; a, b, c : its corners from the point
    """
    la, lb = math.sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]), math.sqrt(b[0] * b[0] + b[1] * b[1] + b[2] * b[2])
    lc = math.sqrt(c[0] * c[0] + c[1] * c[1] + c[2] * c[2])
    volume = a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2])
    volume += a[2] * (b[0] * c[1] - b[1] * c[0])
    below = la * lb * lc + (a[0] * b[0] + a[1] * b[1] + a[2] * b[2]) * lc
    below += (b[0] * c[0] + b[1] * c[1] + b[2] * c[2]) * la + (c[0] * a[0] + c[1] * a[1] + c[2] * a[2]) * lb
    return volume, below


@kernel
def node_sums(ratio: np.ndarray, gradient: np.ndarray, cloud: Cloud, walls: Walls, weight: np.ndarray,
              area: np.ndarray, share: np.ndarray, table: KernelTable) -> None:
    """Write the contribution to `completed_density` of half cells at nodes that no fluid represents.

    Where fluid has come to a wall, its first particles are half a spacing from it, and no node lies between. The sum is
    then that of the midpoint rule, whose end correction is -1/2 of the trapezoidal one.

    ratio : (n_owned,), gradient : (n_owned, dim) [1/m], outputs; other arguments as in `completed_density`
    share : (n_all,), the part of its half cell that fluid represents (halves.wall_share)
    """
    axes = cloud.axes
    dim, away = len(axes), np.empty(len(axes))
    for i in range(len(ratio)):
        ratio[i] = 0.0
        gradient[i, :] = 0.0
        if cloud.kind[i] != FLUID or walls.indptr[i] == walls.indptr[i + 1]:
            continue
        for k in range(cloud.indptr[i], cloud.indptr[i + 1]):
            j = cloud.indices[k]
            if cloud.kind[j] != WALL or share[j] == 1.0:
                continue
            lack = 1.0 - share[j]
            r2, before = 0.0, 0.0
            for a in range(dim):
                away[a] = cloud.x[i, a] - cloud.x[j, a]
                r2 += away[a] ** 2
                before += away[a] * area[j, a]
            r, half = math.sqrt(r2), lack * weight[j]
            b = 1.5 * lack * _entry(table, 1, r)
            ratio[i] += (half * cubic_spline(r, table.h, dim) + before * b) / table.full
            slope = half * cubic_spline_slope(r, table.h, dim) + 1.5 * lack * before * _entry(table, 2, r)
            for a in range(dim):
                gradient[i, a] += (slope * away[a] + b * area[j, a]) / table.full
