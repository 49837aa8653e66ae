"""Pressure rows from corrected second derivatives of SPH (Fatehi & Manzari 2011)."""

import numpy as np

from parisph.base.fields import INNER
from parisph.kernels.gradient import support
from parisph.kernels.jit import inlined, kernel
from parisph.kernels.moments import eliminate
from parisph.kernels.near import SPLINE_SLOPE, dot, fill_up, gather, room_for
from parisph.kernels.records import Cloud, Rows
from parisph.kernels.row import finish_row
from parisph.kernels.schwaiger import FLAT


@kernel
def fatehi_rows(rows: Rows, cloud: Cloud, h: float) -> None:
    """Fill the rows of inner particles with a Laplacian that is exact for quadratics on any particles.

    With e = r_ij/r, r_ij = r_i - r_j, and the corrected gradient of Zheng, Ma & Duan (2014), Eq. 20d, lap p_i = B :
    sum_j 2 V e (grad_i W_ij)^T [(p_i - p_j)/r - e . grad p_i]. The symmetric tensor B makes the result exact for
    quadratic p: B : A = 1 with A = sum_j w e e^T (xi xi^T - xi . T) in the notation of `schwaiger`, where T = sum_j w
    M^-1 xi xi xi^T is the gradient of a quadratic. The system has 3 unknowns in 2D, 6 in 3D. Values may be negative. A
    row is dropped if its neighbours do not determine B.

    h : smoothing length of the cubic spline, support 2h [m]; volumes cancel
    """
    indptr, axes = cloud.indptr, cloud.axes
    dim, room, radius = len(axes), room_for(indptr), 2.0 * h
    pairs = dim * (dim + 1) // 2
    near, weighted = np.empty((dim, room)), np.empty((dim + 1, room))
    products = square, along = np.empty((pairs, room)), np.empty((pairs, room))
    moment, inverse = np.empty((dim, dim)), np.empty((dim, dim))
    third, lean, bias = np.empty((dim, pairs)), np.empty((pairs, dim)), np.empty(dim)
    matrix, tensor = np.empty((pairs, pairs)), np.empty(pairs)
    for i in range(len(indptr) - 1):
        if cloud.role[i] != INNER:
            continue
        first = indptr[i]
        n = gather(near, rows.columns, first, i, cloud, radius)
        m = fill_up(near, n, axes)
        sound = support(moment, inverse, weighted, near, SPLINE_SLOPE, n, m, axes) > FLAT
        if sound:
            _products(products, near, weighted, m, axes)
            _third_moments(third, inverse, square, weighted, m, axes)
            sound = _tensor(tensor, matrix, lean, third, products, near, m, axes)
            _bias(bias, inverse, tensor, lean, axes)
            for k in range(n):
                c = 0.0
                for p in range(pairs):
                    c += tensor[p] * along[p, k]
                for a in range(dim):
                    c -= bias[a] * weighted[1 + a, k]
                rows.values[first + k] = c
        finish_row(rows, i, first, n, 2.0 / (radius * radius), sound)


@inlined
def _products(products, near, weighted, m, axes):
    """Write xi_a xi_b and w e_a e_b of each neighbour in the order 00, 10, 11, 20, 21, 22."""
    square, along = products
    p = 0
    for a in range(len(axes)):
        for b in range(a + 1):
            for k in range(m):
                square[p, k] = near[a, k] * near[b, k]
            p += 1
    for k in range(m):
        r2 = 0.0
        for a in range(len(axes)):
            r2 += near[a, k] ** 2
        share = weighted[0, k] / r2 if r2 > 0.0 else 0.0  # a coincident neighbour has no direction
        for p in range(len(square)):
            along[p, k] = share * square[p, k]


@inlined
def _third_moments(third, inverse, square, weighted, m, axes):
    """Write T[a, p] = sum_j w (M^-1 xi)_a (xi xi)_p."""
    for p in range(len(square)):
        for a in range(len(axes)):
            third[a, p] = 0.0
        for b in range(len(axes)):
            total = dot(weighted, 1 + b, square, p, m)
            for a in range(len(axes)):
                third[a, p] += inverse[a, b] * total


@inlined
def _tensor(tensor, matrix, lean, third, products, near, m, axes):
    """Solve for B, with entries off the diagonal doubled, and write lean = sum_j w (e e)_p xi_a; False if singular."""
    square, along = products
    pairs = len(square)
    for p in range(pairs):
        for a in range(len(axes)):
            lean[p, a] = dot(along, p, near, a, m)
        for r in range(pairs):
            value = dot(along, p, square, r, m)
            for a in range(len(axes)):
                value -= lean[p, a] * third[a, r]
            matrix[r, p] = value
        tensor[p] = 0.0
    p = 0
    for a in range(len(axes)):
        p += a
        tensor[p] = 1.0  # 00, 11, 22
        p += 1
    return eliminate(matrix, tensor, pairs)


@inlined
def _bias(bias, inverse, tensor, lean, axes):
    """Write M^-1 sum_j w_j (e . B e) xi_j, the weight of the gradient in the Laplacian."""
    for a in range(len(axes)):
        bias[a] = 0.0
        for b in range(len(axes)):
            for p in range(len(tensor)):
                bias[a] += inverse[a, b] * tensor[p] * lean[p, b]
