"""Pressure rows by generalised finite differences: a weighted quadratic fit through the particle's own value."""

import numpy as np

from parisph.base.fields import INNER
from parisph.kernels.circle import fill_basis
from parisph.kernels.harmonic import basis_size
from parisph.kernels.jit import inlined, kernel
from parisph.kernels.moments import QUADRATIC_UNIT, cholesky, cholesky_solve, normal_matrix
from parisph.kernels.near import fill_up, gather_within, room_for
from parisph.kernels.records import Cloud, Rows
from parisph.kernels.row import finish_row
from parisph.kernels.smoothing import quartic_weight


@kernel
def gfd_rows(rows: Rows, cloud: Cloud, radius: float) -> None:
    """Fill the rows of inner particles with the Laplacian of a least-squares polynomial of degree 2.

    p_j - p_i is fitted by the polynomials of degree 1 and 2, 5 in 2D and 9 in 3D: x, y, x^2 - y^2, xy, r^2 in 2D. Only
    r^2 has a Laplacian, 2 dim, so one solution with the normal matrix gives the whole row. Exact for quadratics on any
    particles. Values may be negative. A row is dropped (no entries, measure 0) if fewer than 6 neighbours (3D: 10) are
    within the radius, or if they do not span the polynomials.

    radius : of the quartic weight [m]
    """
    indptr, axes = cloud.indptr, cloud.axes
    dim, room, size = len(axes), room_for(indptr), basis_size(axes) + 1
    scale = QUADRATIC_UNIT * radius
    basis, w = np.zeros((size + 3, room)), np.empty((1, room))
    matrix, right = np.empty((size, size + 3)), np.empty(size)
    for i in range(len(indptr) - 1):
        if cloud.role[i] != INNER:
            continue
        first = indptr[i]
        n = gather_within(basis, rows.columns, first, i, cloud, scale, radius)
        m = fill_up(basis, n, axes)
        fill_basis(basis, m, axes)
        found = _weigh(w, basis, size, m)
        normal_matrix(matrix, basis, w, size, m)
        sound = found > size and cholesky(matrix, size)
        for r in range(size):
            right[r] = 1.0 if r == size - 1 else 0.0
        if sound:
            cholesky_solve(matrix, right, size)
        for k in range(n):
            c = 0.0
            for r in range(size):
                c += right[r] * basis[r, k]
            rows.values[first + k] = w[0, k] * c
        finish_row(rows, i, first, n, 2.0 * dim / (scale * scale), sound)


@inlined
def _weigh(w, basis, size, m):
    """Write the weights from r^2 in the last row of the basis; return how many are not zero."""
    found, limit2 = 0, 1.0 / (QUADRATIC_UNIT * QUADRATIC_UNIT)
    for k in range(m):
        r2 = basis[size - 1, k]
        w[0, k] = quartic_weight(r2, limit2)
        found += (r2 < limit2) & (r2 > 0.0)  # a coincident neighbour adds no information
    return found
