"""First derivatives from a local fit by harmonic polynomials.

Where lap f = 0 the quadratic terms of f are harmonic, so that a fit by (X, Y, X^2 - Y^2, XY) is of
second order. It needs far fewer neighbours than a full quadratic fit, which suits the one-sided
stencils at walls and at the surface.
"""

import numpy as np

from parisph.kernels.jit import subkernel
from parisph.kernels.moments import cholesky, cholesky_solve
from parisph.kernels.roles import outside
from parisph.kernels.smoothing import quartic_weight


@subkernel
def basis_size(axes: tuple[int, ...]) -> int:
    """Return the number of harmonic polynomials of degree 1 and 2: 4 in 2D, 8 in 3D."""
    dim = len(axes)
    return dim + dim * (dim + 1) // 2 - 1


@subkernel
def fill_basis(b: np.ndarray, i: int, j: int, x: np.ndarray, radius: float, axes: tuple[int, ...]) -> None:
    """Write the harmonic polynomials at neighbour j, in units of the radius."""
    dim = len(axes)
    n = dim
    for a in range(dim):
        b[a] = (x[j, a] - x[i, a]) / radius
    for a in range(dim - 1):
        b[n] = b[a] * b[a] - b[a + 1] * b[a + 1]
        n += 1
    for a in range(dim):
        for c in range(a):
            b[n] = b[a] * b[c]
            n += 1


@subkernel
def coefficients(out: np.ndarray, i: int, x: np.ndarray, role: np.ndarray, radius: float, most: float,
                 work: np.ndarray, b: np.ndarray, indptr: np.ndarray, indices: np.ndarray,
                 axes: tuple[int, ...]) -> bool:
    """Write c_j so that d f/dx_a (x_i) = sum_j c[j, a] (f_j - f_i) for harmonic f.

    out : (at least the number of neighbours of i, dim), in the order of the list of i [1/m]
    most : by how much the terms of degree 2 may raise the variance of the first derivatives: the mean over directions
        of the ratio to a linear fit, for noise of variance 1/w, trace(M (A^-1)_11)/dim, with A = sum w b b^T and its
        linear block M = A_11; infinite for no limit
    work : (basis, basis), b : (basis,) scratch.
    Returns False, with out undefined, when the neighbours do not span the basis, or not well enough for `most`.
    """
    dim, n = len(axes), basis_size(axes)
    radius2 = radius * radius
    work[:n, :n] = 0.0
    found = 0
    for k in range(indptr[i], indptr[i + 1]):
        w = _weight(i, indices[k], x, role, radius2, axes)
        if w == 0.0:
            continue
        found += 1
        fill_basis(b, i, indices[k], x, radius, axes)
        for r in range(n):
            for c in range(r + 1):
                work[r, c] += w * b[r] * b[c]
    if found < n + 1:
        return False
    for a in range(dim):
        for c in range(a + 1):
            out[a, c] = out[c, a] = work[a, c]
    if not cholesky(work, n):
        return False
    if most < np.inf and _inflation(out, work, b, n, axes) > most:
        return False
    for k in range(indptr[i], indptr[i + 1]):
        row = k - indptr[i]
        w = _weight(i, indices[k], x, role, radius2, axes)
        if w == 0.0:
            out[row, :] = 0.0
            continue
        fill_basis(b, i, indices[k], x, radius, axes)
        cholesky_solve(work, b, n)
        for a in range(dim):
            out[row, a] = w * b[a] / radius
    return True


@subkernel
def _inflation(moment, work, b, n, axes):
    """Return by how much the terms of degree 2 raise the variance of the slope, as a mean over directions.

    moment : (dim, dim), of the linear terms alone; work : the factor of all
    """
    dim, raised = len(axes), 0.0
    for a in range(dim):
        b[:n] = 0.0
        b[a] = 1.0
        cholesky_solve(work, b, n)
        for c in range(dim):
            raised += b[c] * moment[a, c] / dim
    return raised


@subkernel
def _weight(i, j, x, role, radius2, axes):
    if outside(role[j]):
        return 0.0
    r2 = 0.0
    for a in range(len(axes)):
        r2 += (x[j, a] - x[i, a]) ** 2
    return quartic_weight(r2, radius2)


@subkernel
def scratch(indptr: np.ndarray, axes: tuple[int, ...]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return scratch arrays (coefficients, work, b) for `coefficients`, large enough for any row."""
    longest = 1
    for i in range(len(indptr) - 1):
        longest = max(longest, indptr[i + 1] - indptr[i])
    n = basis_size(axes)
    return np.empty((longest, len(axes))), np.empty((n, n)), np.empty(n)
