"""CISPH1 and CISPH2 pressure rows: SPH Laplacians that own a gradient (Schwaiger 2008)."""

import numpy as np

from parisph.base.fields import INNER
from parisph.kernels.gradient import support
from parisph.kernels.jit import inlined, kernel
from parisph.kernels.near import SPLINE_SLOPE, fill_up, gather, room_for
from parisph.kernels.records import Cloud, Rows
from parisph.kernels.row import finish_row

FLAT = 0.02  # tuned 0.01 to 0.04: det/(trace/dim)^dim of Gamma below which a row is dropped, as on a line; judged


def cisph1_rows(rows: Rows, cloud: Cloud, h: float, volume: float) -> None:
    """Fill the rows of inner particles with CISPH1 (Zheng, Ma & Duan 2014, Eq. 20b with the gradient of Eq. 20c).

    With r_ij = r_i - r_j, F_ij = W'/r and grad_i W_ij = F_ij r_ij, lap p_i = tr(Gamma^-1)/n [2 sum_j V F_ij (p_j - p_i)
    + 2 grad p_i . sum_j V grad_i W_ij], Gamma = sum_j V F_ij r_ij r_ij^T, grad p_i = sum_j V (p_j - p_i) grad_i W_ij.
    The printed -2 grad p is right only for r_ij = r_j - r_i, and the sum Gamma is printed as an integral. The gradient
    is not exact for linear p on disordered particles, and so neither are these rows. Values may be negative.

    h : smoothing length of the cubic spline, support 2h [m]; volume : of a particle, at equal sizes [m^dim]
    """
    _fill(rows, cloud, h, volume, False)


def cisph2_rows(rows: Rows, cloud: Cloud, h: float) -> None:
    """Fill the rows of inner particles with CISPH2 (Zheng, Ma & Duan 2014, Eq. 20b with the gradient of Eq. 20d).

    As cisph1_rows, but grad p_i = sum_j V (p_j - p_i) L grad_i W_ij with L = [sum_j V (r_j - r_i) grad_i W_ij^T]^-1 =
    -Gamma^-1. The volumes cancel. Exact for linear p on any particles. (The paper's text has "Eq. 20c" for this method,
    too; Eq. 20d is meant.)
    """
    _fill(rows, cloud, h, 1.0, True)


@kernel
def _fill(rows, cloud, h, volume, corrected):
    """Fill the rows in units of the support, with w = -F, xi = r_j - r_i and M = sum w xi xi^T = -Gamma/V.

    If grad p_i = sum_j w_j G xi_j (p_j - p_i), then
    lap p_i = 2 tr(M^-1)/n sum_j w_j [1 - (sum_k w_k xi_k) . G xi_j] (p_j - p_i).
    """
    indptr, axes = cloud.indptr, cloud.axes
    dim, room, radius = len(axes), room_for(indptr), 2.0 * h
    near, weighted = np.empty((dim, room)), np.empty((dim + 1, room))
    moment, inverse, matrix, tilt = np.empty((dim, dim)), np.empty((dim, dim)), np.empty((dim, dim)), np.empty(dim)
    for i in range(len(indptr) - 1):
        if cloud.role[i] != INNER:
            continue
        first = indptr[i]
        n = gather(near, rows.columns, first, i, cloud, radius)
        m = fill_up(near, n, axes)
        sound = support(moment, inverse, weighted, near, SPLINE_SLOPE, n, m, axes) > FLAT
        trace = _gradient_matrix(matrix, inverse, volume / radius**dim, corrected, axes)
        _tilt(tilt, matrix, weighted, m, axes)
        for k in range(n):
            c = 1.0
            for a in range(dim):
                c -= tilt[a] * near[a, k]
            rows.values[first + k] = weighted[0, k] * c
        finish_row(rows, i, first, n, 2.0 * trace / (dim * radius * radius), sound)


@inlined
def _gradient_matrix(matrix, inverse, volume, corrected, axes):
    """Write G of the gradient stencil w_j G xi_j: M^-1 (Eq. 20d) or V (Eq. 20c). Return tr(M^-1)."""
    trace = 0.0
    for a in range(len(axes)):
        trace += inverse[a, a]
        for b in range(len(axes)):
            matrix[a, b] = inverse[a, b] if corrected else (volume if a == b else 0.0)
    return trace


@inlined
def _tilt(tilt, matrix, weighted, m, axes):
    """Write G sum_k w_k xi_k, zero among evenly spread neighbours."""
    for a in range(len(axes)):
        tilt[a] = 0.0
    for b in range(len(axes)):
        total = 0.0
        for k in range(m):
            total += weighted[1 + b, k]
        for a in range(len(axes)):
            tilt[a] += matrix[a, b] * total
