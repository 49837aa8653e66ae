"""Moments of a linear pressure on the wall particles that face a pressure tap."""

import math

import numpy as np

from parisph.kernels.jit import kernel
from parisph.kernels.moments import cholesky, cholesky_solve


@kernel
def tap_moments(x: np.ndarray, p: np.ndarray, at: np.ndarray, frame: np.ndarray, across: np.ndarray, half: np.ndarray,
                radius: float) -> np.ndarray:
    """Return sum w b b^T [-], then sum w p b [Pa], (n n + n,), with n functions b = (1, x along the wall/radius).

    The weight is w = (1 - r^2/radius^2)^2, with the distance r along the wall. Particles at least half[a] away along an
    axis across the wall do not count.

    x : (m, dim) wall particles [m]; p : (m,) [Pa]; at : (dim,) the tap [m]; radius [m]
    frame : (dim, dim), axes across and along the wall; across : (dim,) bool; half : (dim,) [m]
    """
    dim, n = len(at), 1
    for a in range(dim):
        n += not across[a]
    found, basis = np.zeros(n * n + n), np.ones(n)
    for k in range(len(x)):
        weight, on_wall, m = 1.0, True, 1
        for a in range(dim):
            away = 0.0
            for b in range(dim):
                away += frame[a, b] * (x[k, b] - at[b])
            if across[a]:
                on_wall &= abs(away) < half[a]
            else:
                basis[m] = away / radius
                weight -= basis[m] ** 2
                m += 1
        if not (on_wall and weight > 0.0):
            continue
        for r in range(n):
            for s in range(n):
                found[r * n + s] += weight * weight * basis[r] * basis[s]
            found[n * n + r] += weight * weight * basis[r] * p[k]
    return found


@kernel
def fitted_at_tap(moments: np.ndarray, n: int) -> float:
    """Return the fitted pressure [Pa] at the tap, from the sums of `tap_moments` over all ranks with n functions.

    It is the mean where the particles do not determine the fit (moments.PIVOT_FLOOR), and NaN without particles.

    moments : (n n + n,)
    """
    if not moments[0] > 0.0:
        return np.nan
    # scaled by the sizes of the functions, because close to a particle the next one has a small weight
    matrix, right, size = np.empty((n, n)), np.empty(n), np.empty(n)
    for r in range(n):
        size[r] = math.sqrt(moments[r * n + r]) if moments[r * n + r] > 0.0 else 1.0
    for r in range(n):
        right[r] = moments[n * n + r] / size[r]
        for s in range(n):
            matrix[r, s] = moments[r * n + s] / (size[r] * size[s])
    if cholesky(matrix, n):
        cholesky_solve(matrix, right, n)
    return right[0] / size[0]
