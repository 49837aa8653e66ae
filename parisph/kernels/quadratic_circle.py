"""ISPH_R rows with quadratic moving least squares."""

import numpy as np

from parisph.base.fields import INNER
from parisph.kernels.circle import Circle, fill_basis
from parisph.kernels.harmonic import basis_size
from parisph.kernels.jit import inlined, kernel
from parisph.kernels.moments import QUADRATIC_UNIT, cholesky, cholesky_solve, normal_matrix
from parisph.kernels.near import fill_up, gather, room_for
from parisph.kernels.records import Cloud, Rows
from parisph.kernels.row import finish_row
from parisph.kernels.smoothing import quartic_weight


@kernel
def quadratic_rankine_rows(rows: Rows, cloud: Cloud, circle: Circle) -> None:
    """Fill the rows of inner particles with the mean over a circle or sphere of a quadratic fit.

    mean p - p_I = (R^2/2 dim) lap p (Zheng, Ma & Duan 2014, Eqs. 21-23 and 33), as in `rankine`, where p is
    interpolated linearly and the row needs another normalisation. A quadratic interpolant has the second moment of the
    circle itself, so the row is exact for quadratics on any particles with R as printed. Values may be negative. A row
    is dropped if the neighbours of a point do not span the polynomials of degree 2, 6 in 2D and 10 in 3D.

    circle : R is about one spacing, and the lists should reach to R + radius
    """
    indptr, axes = cloud.indptr, cloud.axes
    dim, points, room, size = len(axes), len(circle.unit), room_for(indptr), basis_size(axes) + 2
    scale = QUADRATIC_UNIT * circle.radius
    at, basis, w, mean = np.zeros((size, points)), np.zeros((size + 3, room)), np.empty((1, room)), np.empty(room)
    system = np.empty((size, size + 3)), np.empty(size)
    for q in range(points):
        for a in range(dim):
            at[a, q] = circle.unit[q, a] * circle.size / scale
    fill_basis(at, points, axes)
    at[size - 1, :], basis[size - 1, :] = 1.0, 1.0
    for i in range(len(indptr) - 1):
        if cloud.role[i] != INNER:
            continue
        first = indptr[i]
        n = gather(basis, rows.columns, first, i, cloud, scale)
        for a in range(dim):
            basis[a, n] = 0.0  # the particle itself is last
        m = fill_up(basis, n + 1, axes)
        fill_basis(basis, m, axes)
        for k in range(m):
            mean[k] = 0.0
        sound = True
        for q in range(points):
            sound &= _add_shape(mean, w, basis, at, q, system, m, axes)
        for k in range(n):
            rows.values[first + k] = mean[k]
        finish_row(rows, i, first, n, 2.0 * dim / (points * circle.size * circle.size), sound)


@inlined
def _add_shape(mean, w, basis, at, q, system, m, axes):
    """Add the shape functions at point q, w_k b(x_q) . M^-1 b_k with M = sum w b b^T; False if M is degenerate.

    system : (M, right-hand side), scratch
    """
    (matrix, right), size = system, basis_size(axes) + 2
    for k in range(m):
        r2 = 0.0
        for a in range(len(axes)):
            r2 += (basis[a, k] - at[a, q]) ** 2
        w[0, k] = quartic_weight(r2, 1.0 / (QUADRATIC_UNIT * QUADRATIC_UNIT))
    normal_matrix(matrix, basis, w, size, m)
    if not cholesky(matrix, size):
        return False
    for r in range(size):
        right[r] = at[r, q]
    cholesky_solve(matrix, right, size)
    for k in range(m):
        shape = 0.0
        for r in range(size):
            shape += right[r] * basis[r, k]
        mean[k] += w[0, k] * shape
    return True
