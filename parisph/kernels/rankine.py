"""ISPH_R rows: the pressure equation in its Rankine-source weak form.

Zheng, Ma & Duan (2014), Eqs. 21-23 and 33: with phi = ln(r/R)/2 pi the mean of p over the circle of radius R around
particle I, minus p_I, equals (R^2/4) lap p + O(R^4). The mean is taken over K points, where p is interpolated by linear
moving least squares.

This interpolant does not pass through the particles: it adds its own second moment to that of the circle, 3.1 R^2 in 2D
and 4.4 R^2 in 3D at R = s/2. The row is therefore normalised by its result for a parabola, M = sum_J A_IJ |x_J -
x_I|^2, instead of R^2. As printed, the Laplacian is too large by M/R^2 at every resolution: 4.14 in 2D and 5.41 in 3D
on the lattice.
"""

import math
from typing import NamedTuple

import numpy as np

from parisph.base.fields import INNER
from parisph.kernels.circle import Circle, fill_basis, fit_around, sum_over_points
from parisph.kernels.harmonic import basis_size
from parisph.kernels.jit import inlined, kernel
from parisph.kernels.mls import moment_count
from parisph.kernels.moments import cholesky, cholesky_solve
from parisph.kernels.near import dot, dot4, fill_up, gather, room_for
from parisph.kernels.records import Cloud, DivergenceRows, Rows
from parisph.kernels.smoothing import quartic_weight

# A jitter of 1.2 spacings gives -0.03. Making the row of a particle in a drop isotropic can give any value.
NEGATIVE = 0.1  # tuned 0.05 to 0.2: negative weight over the sum, up to which a row is made isotropic; judged
# A row beyond this gave a drop at the lid fourteen times the pressure of all the water.
UNSOUND = 0.5   # tuned 0.25 to 1: negative weight over the sum, above which a row is dropped; measured
WIDER = 1.238   # tuned 1 to 1.238: radius of the change that makes a row isotropic, over that of the weight; judged


def directions(dim: int, count: int | None = None) -> np.ndarray:
    """Return unit vectors spread evenly over the circle or the sphere: (K, dim).

    2D: `count` (default 8) points. 3D: the 12 corners of the icosahedron, whose mean integrates polynomials up to
    degree five exactly. With six points in 2D rows cost a fifth less and errors change by less than 1 %, but rows on a
    square lattice change with a quarter turn. With four, rows cost a third less; errors of small sloshing with 200, 800
    and 3200 particles are then .045, .0154 and .0102 instead of .040, .0165 and .0113.
    """
    if dim == 2:
        angle = 2.0 * np.pi * np.arange(count or 8) / (count or 8)
        return np.stack([np.cos(angle), np.sin(angle)], axis=1)
    golden = 0.5 * (1.0 + math.sqrt(5.0))
    corner = [(0.0, a, b * golden) for a in (-1.0, 1.0) for b in (-1.0, 1.0)]
    points = np.array([np.roll(c, shift) for shift in range(3) for c in corner])
    return points / np.linalg.norm(points[0])


@kernel
def rankine_rows(rows: Rows, flux: DivergenceRows, cloud: Cloud, u: np.ndarray, circle: Circle,
                 normalised: bool) -> None:
    """Fill the rows of inner particles, and the flux divergence of u through the circle.

    A row with too few neighbours becomes the mean of those that reach the circle, with measure 0. Other measures are
    M/(2 dim), or R^2/(2 dim) as printed [m^2].

    u : (n_all, dim) [m/s]; normalised : whether by M
    """
    unit, radius, role, indptr, axes = circle.unit, circle.radius, cloud.role, cloud.indptr, cloud.axes
    dim, points, size, room = len(axes), len(unit), basis_size(axes), room_for(indptr)
    at = np.ascontiguousarray(unit.T) * (circle.size / radius)
    centre = np.zeros_like(at)
    basis, w = np.empty((size + 1, room)), np.empty((points, room))
    moments, fit = np.empty((moment_count(axes), points)), np.empty((dim + 1, points))
    mean = np.empty((dim + 1, room))
    matrix, right = np.empty((size, size)), np.empty(size)
    for i in range(len(indptr) - 1):
        if role[i] != INNER:
            continue
        n = gather(basis, rows.columns, indptr[i], i, cloud, radius)
        m = fill_up(basis, n, axes)
        fill_basis(basis, m, axes)
        spanned = fit_around(fit, moments, w, basis, at, centre, m, axes)
        sum_over_points(mean, fit, w, basis, unit, m, axes)
        if normalised and n > size:
            _make_isotropic(mean, basis, w, m, matrix, right, axes)
        rows.count[i] = n
        total, spread, sound = _mean_over_circle(mean, basis, m, circle)
        if spanned and sound:
            rows.measure[i] = (spread if normalised else circle.size * circle.size) / (2.0 * dim * total)
            _store(rows, flux, i, total, mean, cloud, u, circle)
        else:
            _store_mean(rows, flux, i, cloud, circle.size + circle.radius)


@inlined
def _make_isotropic(mean, basis, w, m, matrix, right, axes):
    """Remove the harmonic second moment from a row by the smallest weighted change. Overwrites w[0] and w[1].

    The mean over the circle of X^2 - Y^2 and of XY is zero. On disordered particles the moving least squares leave a
    remainder, an error of order one in the Laplacian that does not vanish with refinement. Rows whose neighbours do not
    span the harmonic polynomials stay unchanged. The change is scaled down if it would make a weight less than
    -NEGATIVE times the row's sum: with the minimum number of neighbours, all particles of a drop would have the same
    row. It leaves the sum NEGATIVE times what it was: as many neighbours as conditions have no row but zero, and then
    rounding would be the row.
    """
    size = basis_size(axes)
    total = 0.0
    for k in range(m):
        total += mean[0, k]
        w[0, k] = quartic_weight(basis[size, k], WIDER * WIDER)
    for r in range(size):
        right[r] = dot(mean, 0, basis, r, m)
        for s in range(0, r + 1, 4):  # four at a time, also beyond the lower triangle
            matrix[r, s], matrix[r, s + 1], matrix[r, s + 2], matrix[r, s + 3] = dot4(basis, r, w, basis, s, m)
    if cholesky(matrix, size):
        cholesky_solve(matrix, right, size)
        added = 0.0
        for k in range(m):
            change = 0.0
            for r in range(size):
                change -= right[r] * basis[r, k]
            w[1, k] = w[0, k] * change
            added += w[1, k]
        part = min(1.0, (NEGATIVE - 1.0) * total / added) if added < -(1.0 - NEGATIVE) * total else 1.0
        for k in range(m):
            room, taken = mean[0, k] + NEGATIVE * total, w[1, k] + NEGATIVE * added
            if room + taken < 0.0:
                part = min(part, max(-room / taken, 0.0))
        for k in range(m):
            mean[0, k] += part * w[1, k]


@inlined
def _mean_over_circle(mean, basis, m, circle):
    """Return the means over the circle of neighbours' weights [-] and of their r^2 [m^2], and whether the row is sound.

    It is unsound if it extrapolates from neighbours on one side: their weights, or its result for a parabola, then are
    not positive, or it has a large negative weight.
    """
    points, total, spread, lowest = len(circle.unit), 0.0, 0.0, 0.0
    for k in range(m):
        total += mean[0, k]
        lowest = min(lowest, mean[0, k])
        spread += mean[0, k] * basis[len(basis) - 1, k]
    total /= points
    spread *= circle.radius * circle.radius / points
    return total, spread, total > 0.0 and spread > 0.0 and lowest > -UNSOUND * points * total


@inlined
def _store(rows, flux, i, total, mean, cloud, u, circle):
    """Write a row and a stencil from the sums over the circle, and sum the flux of u."""
    first, points, dim = cloud.indptr[i], len(circle.unit), len(cloud.axes)
    scale, outflow = 1.0 / (points * total), dim / (circle.size * points)
    change, ux, uy = 0.0, u[i, 0], u[i, 1]
    uz = u[i, 2] if len(cloud.axes) == 3 else 0.0
    for k in range(rows.count[i]):
        t = np.uint32(first + k)    # unsigned, as in `near.gather`
        j = np.uint32(rows.columns[t])
        rows.values[t] = mean[0, k] * scale
        fx, fy = mean[1, k] * outflow, mean[2, k] * outflow
        flux.flux[t, 0], flux.flux[t, 1] = fx, fy
        change += fx * (u[j, 0] - ux) + fy * (u[j, 1] - uy)
        if len(cloud.axes) == 3:
            fz = mean[3, k] * outflow
            flux.flux[t, 2] = fz
            change += fz * (u[j, 2] - uz)
    flux.div[i] = change


@inlined
def _store_mean(rows, flux, i, cloud, reach):
    """Write the mean of the neighbours as a row (`keep_within`), and a stencil of zeros."""
    rows.measure[i] = flux.div[i] = 0.0
    first = cloud.indptr[i]
    rows.count[i] = n = keep_within(rows.columns, first, rows.count[i], i, cloud, reach)
    for k in range(first, first + n):
        rows.values[k] = 1.0 / n
        for a in range(len(cloud.axes)):
            flux.flux[k, a] = 0.0


@inlined
def keep_within(columns: np.ndarray, first: int, n: int, i: int, cloud: Cloud, reach: float) -> int:
    """Move those of n neighbours, from `first` on, that are within the reach [m] to the front; return their number.

    Lists reach farther, how far depends on when they were made, and so on the number of ranks.
    """
    kept = first
    for k in range(first, first + n):
        j, r2 = columns[k], 0.0
        for a in range(len(cloud.axes)):
            r2 += (cloud.x[j, a] - cloud.x[i, a]) ** 2
        if r2 < reach * reach:
            columns[kept] = j
            kept += 1
    return kept - first


@kernel
def divergence(out: np.ndarray, flux: DivergenceRows, cloud: Cloud, u: np.ndarray) -> None:
    """Write the divergence of u (n_all, dim) by the stored stencils, (n_owned,) [1/s], 0 outside inner particles."""
    count, columns, stencil, _ = flux
    indptr, axes = cloud.indptr, cloud.axes
    for i in range(len(indptr) - 1):
        out[i] = 0.0
        if cloud.role[i] != INNER:
            continue
        total, ux, uy = 0.0, u[i, 0], u[i, 1]
        uz = u[i, 2] if len(axes) == 3 else 0.0
        for k in range(np.uint32(indptr[i]), np.uint32(indptr[i] + count[i])):
            j = np.uint32(columns[k])
            total += stencil[k, 0] * (u[j, 0] - ux) + stencil[k, 1] * (u[j, 1] - uy)
            if len(axes) == 3:
                total += stencil[k, 2] * (u[j, 2] - uz)
        out[i] = total


class Invariants(NamedTuple):
    """Invariants of the velocity gradient G = grad u at inner particles, (n_owned,) each, 0 elsewhere.

    square : tr(G^2) [1/s^2]; div : tr(G), the flux divergence [1/s]
    rate : sqrt(2 G:G) [1/s], the rate of relative motion of neighbours: a shear rate, or twice an angular velocity
    """

    square: np.ndarray
    rate: np.ndarray
    div: np.ndarray


@kernel
def gradient_invariants(out: Invariants, flux: DivergenceRows, cloud: Cloud, u: np.ndarray) -> None:
    """Write the invariants of the gradient of u (n_all, dim) [m/s] by the stored stencils.

    (dim/R) times the mean of u_b n_a over the circle is d u_b/dx_a for linear u.
    """
    square, rate, div = out
    count, columns, stencil, _ = flux
    indptr, axes = cloud.indptr, cloud.axes
    dim = len(axes)
    for i in range(len(indptr) - 1):
        square[i], rate[i], div[i] = 0.0, 0.0, 0.0
        if cloud.role[i] != INNER:
            continue
        # scalars stay in registers
        xx, xy, yx, yy, xz, yz, zx, zy, zz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for k in range(np.uint32(indptr[i]), np.uint32(indptr[i] + count[i])):
            j = np.uint32(columns[k])
            fx, fy, dx, dy = stencil[k, 0], stencil[k, 1], u[j, 0] - u[i, 0], u[j, 1] - u[i, 1]
            xx += fx * dx
            xy += fx * dy
            yx += fy * dx
            yy += fy * dy
            if dim == 3:
                fz, dz = stencil[k, 2], u[j, 2] - u[i, 2]
                xz += fx * dz
                yz += fy * dz
                zx += fz * dx
                zy += fz * dy
                zz += fz * dz
        square[i] = xx * xx + yy * yy + zz * zz + 2.0 * (xy * yx + xz * zx + yz * zy)
        rate[i] = math.sqrt(2.0 * (xx * xx + yy * yy + zz * zz + xy * xy + yx * yx + xz * xz + zx * zx + yz * yz
                                   + zy * zy))
        div[i] = xx + yy + zz
