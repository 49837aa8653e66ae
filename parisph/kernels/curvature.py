"""Known second differences of the pressure, in wall rows and in the pressure gradient.

Beside a boundary a stencil is one-sided, and the curvature of p is an error of first order in its slope. Its divergence
leaves a residual in each step, and the mean level drifts. The body force B per unit mass and the Laplacian of p
determine a part of the second differences of p around a particle:

    p_J - p_I = (linear and harmonic terms) + rho/2 (B_J - B_I) . r + L r^2/(2 dim),   r = x_J - x_I.

With L = lap p - rho div B, the rest is harmonic up to terms of third order in r, and linear if the water rests. The
divergence of Euler's equation gives L = rho (div (F - B) - tr((grad u)^2)), with all forces F.
"""

from typing import NamedTuple

import numpy as np

from parisph.base.fields import INNER, SURFACE, WET
from parisph.kernels.circle import fill_basis
from parisph.kernels.harmonic import basis_size, inflation
from parisph.kernels.jit import inlined, kernel
from parisph.kernels.moments import cholesky, cholesky_solve, invert, normal_matrix
from parisph.kernels.near import Form, dot, fill_up, gather, room_for, weights
from parisph.kernels.records import Cloud, Rows
from parisph.kernels.smoothing import quartic_weight


class Bending(NamedTuple):
    """The known part of the second differences of the pressure.

    laplacian : (n_all,), L [Pa/m^2]; pull : (n_all, dim), rho B [Pa/m], or (0, dim) if it is uniform
    """

    laplacian: np.ndarray
    pull: np.ndarray


@kernel
def continue_laplacian(laplacian: np.ndarray, cloud: Cloud, radius: float) -> None:
    """Write the weighted mean over inner neighbours, 0 without them, at owned surface particles and wet walls.

    A mean of first order is enough, because it is multiplied by r^2. With a fit of velocities beside the wall instead,
    the impact pressure of the dam break (H/s = 40, three starts) errs by .07 to .12, with the mean by .04 to .05.

    laplacian : (n_all,) [Pa/m^2]; radius : of the weight [m]
    """
    role, indptr, indices = cloud.role, cloud.indptr, cloud.indices
    for i in range(len(indptr) - 1):
        if role[i] != WET and role[i] != SURFACE:
            continue
        total, weight = 0.0, 0.0
        for k in range(indptr[i], indptr[i + 1]):
            j = indices[k]
            if role[j] == INNER:
                w = quartic_weight(_square_distance(i, j, cloud), radius * radius)
                total += w * laplacian[j]
                weight += w
        laplacian[i] = total / weight if weight > 0.0 else 0.0


@kernel
def add_at_walls(right: np.ndarray, rows: Rows, cloud: Cloud, bending: Bending) -> None:
    """Subtract the wall rows' result for the known part of the pressure from the right-hand side (n_owned,) [Pa].

    Harmonic rows then become exact for quadratic pressure, and all rows for water at rest in a linear force.
    """
    for i in range(len(cloud.indptr) - 1):
        if cloud.role[i] != WET:
            continue
        for k in range(cloud.indptr[i], cloud.indptr[i] + rows.count[i]):
            right[i] -= rows.values[k] * _known(i, rows.columns[k], cloud, bending)


@kernel
def add_at_surface(right: np.ndarray, rows: Rows, cloud: Cloud, bending: Bending) -> None:
    """Subtract the surface rows' result for the known part of the pressure from the right-hand side (n_owned,) [Pa].

    With the values S w_J, S = a/(a + d) (`surface_rows`), and the known part q: p_I = S mean(p_J - q_J) - (1 - S) q(a),
    since p = 0 at the distance a outwards. q(a) follows from L and the mean pull of the neighbours.
    """
    count, columns, values, _ = rows
    x, indptr, dim, pull = cloud.x, cloud.indptr, len(cloud.axes), bending.pull
    mean, force = np.empty(dim), np.empty(dim)
    for i in range(len(indptr) - 1):
        if cloud.role[i] != SURFACE or count[i] == 0:
            continue
        share, known = 0.0, 0.0
        mean[:] = 0.0
        force[:] = 0.0
        for k in range(indptr[i], indptr[i] + count[i]):
            j = columns[k]
            share += values[k]
            known += values[k] * _known(i, j, cloud, bending)
            for a in range(dim):
                mean[a] += values[k] * (x[j, a] - x[i, a])
                if len(pull) > 0:
                    force[a] += values[k] * (pull[j, a] - pull[i, a])
        square, by_pull = 0.0, 0.0
        for a in range(dim):
            square += (mean[a] / share) ** 2
            by_pull += 0.5 * force[a] * mean[a] / share**2
        away = share / (1.0 - share)    # a/d
        outside = away * away * (by_pull + bending.laplacian[i] * square / (2.0 * dim))
        right[i] -= known + (1.0 - share) * outside


@kernel
def gradient(out: np.ndarray, cloud: Cloud, p: np.ndarray, bending: Bending, where: int, form: Form, most: float,
             kept: float) -> None:
    """Replace the pressure gradient by that of a harmonic fit to the unknown part of the pressure.

    Exact for quadratic pressure. Where neighbours do not span the basis, or terms of degree 2 raise the variance of the
    slope too much, the gradient of the linear fit stays, less its result for the known part. The whole known part
    counts, because only its sum is independent of the frame.

    out : (n_owned, dim) [Pa/m] of another fit; p : (n_all,) [Pa]; where : the role of the particles
    form : of the linear fit; gradients damped below its floor (`operators.LeastSquares`) stay
    most : largest ratio of variances with and without terms of degree 2 (harmonic.coefficients)
    kept : ratio up to which `out` has these terms and stays; at most `most` if it never has them
    """
    indptr, axes, radius = cloud.indptr, cloud.axes, form.radius
    dim, size, room = len(axes), basis_size(axes), room_for(indptr)
    basis, w, change = np.zeros((size + 4, room)), np.empty((1, room)), np.zeros((1, room))
    member = np.empty(room, np.int32)
    matrix, right = np.empty((size, size + 3)), np.empty(size)
    m, inverse = np.empty((dim, dim)), np.empty((dim, dim))
    for i in range(len(indptr) - 1):
        if cloud.role[i] != where:
            continue
        n = gather(basis, member, 0, i, cloud, radius)
        columns = fill_up(basis, n, axes)
        fill_basis(basis, columns, axes)
        weights(w, basis, form.power, columns, axes)
        found = _moments(matrix, m, basis, w, n, columns, axes)
        spans = found > size and cholesky(matrix, size)
        raised = inflation(m, matrix, right, size, axes) if spans else np.inf
        curve = bending.laplacian[i] * radius * radius / (2.0 * dim)
        if spans and raised <= most:
            for k in range(columns):
                change[0, k] = 0.0
            for k in range(n):
                j = member[k]
                change[0, k] = w[0, k] * (p[j] - p[i] - _by_pull(i, j, cloud, bending.pull) - curve * basis[size, k])
            for r in range(size):
                right[r] = dot(change, 0, basis, r, columns)
            cholesky_solve(matrix, right, size)
            for a in range(dim):
                out[i, a] = right[a] / radius
        elif raised > kept and found > dim and invert(m, inverse, axes) > form.floor:
            for k in range(n):
                known = w[0, k] * (_by_pull(i, member[k], cloud, bending.pull) + curve * basis[size, k]) / radius
                for a in range(dim):
                    for b in range(dim):
                        out[i, a] -= inverse[a, b] * basis[b, k] * known


@inlined
def _moments(matrix, m, basis, w, n, columns, axes):
    """Write the moments of the harmonic and of the linear fit; return how many of n neighbours have a weight."""
    found = 0
    for k in range(n):
        found += w[0, k] > 0.0
    normal_matrix(matrix, basis, w, basis_size(axes), columns)
    for a in range(len(axes)):
        for b in range(a + 1):
            m[a, b] = m[b, a] = matrix[a, b]
    return found


@inlined
def _known(i, j, cloud, bending):
    """Return the known part of p_j - p_i [Pa]."""
    bent = bending.laplacian[i] * _square_distance(i, j, cloud) / (2.0 * len(cloud.axes))
    return _by_pull(i, j, cloud, bending.pull) + bent


@inlined
def _by_pull(i, j, cloud, pull):
    """Return rho/2 (B_j - B_i) . (x_j - x_i) [Pa]."""
    found = 0.0
    if len(pull) > 0:
        for a in range(len(cloud.axes)):
            found += 0.5 * (pull[j, a] - pull[i, a]) * (cloud.x[j, a] - cloud.x[i, a])
    return found


@inlined
def _square_distance(i, j, cloud):
    r2 = 0.0
    for a in range(len(cloud.axes)):
        r2 += (cloud.x[j, a] - cloud.x[i, a]) ** 2
    return r2
