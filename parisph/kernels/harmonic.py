"""First derivatives from a local fit by harmonic polynomials.

Where lap f = 0 the quadratic terms of f are harmonic, so that a fit by (X, Y, X^2 - Y^2, XY) is of
second order. It needs far fewer neighbours than a full quadratic fit, which suits the one-sided
stencils at walls and at the surface. The two harmonic terms of degree 3 (seven in 3D) make it of third order.
"""

import numpy as np

from parisph.kernels.jit import inlined, subkernel
from parisph.kernels.moments import cholesky, cholesky_solve, normal_matrix
from parisph.kernels.near import LANES
from parisph.kernels.roles import outside
from parisph.kernels.smoothing import quartic_weight


@subkernel
def basis_size(axes: tuple[int, ...]) -> int:
    """Return the number of harmonic polynomials of degree 1 and 2: 4 in 2D, 8 in 3D."""
    dim = len(axes)
    return dim + dim * (dim + 1) // 2 - 1


@inlined
def terms(degree: int, axes: tuple[int, ...]) -> int:
    """Return the number of harmonic polynomials of degree 1 to `degree`, at most 3: then 6 in 2D, 15 in 3D."""
    dim = len(axes)
    if degree == 1:
        return dim
    return basis_size(axes) + (0 if degree == 2 else 2 if dim == 2 else 7)


@inlined
def fill_values(b: np.ndarray, k: int, d: np.ndarray, degree: int, axes: tuple[int, ...]) -> None:
    """Write the harmonic polynomials up to a degree at the place d (dim,) to column k."""
    x, y = d[0], d[1]
    b[0, k], b[1, k] = x, y
    if len(axes) == 2:
        if degree > 1:
            b[2, k], b[3, k] = x * x - y * y, x * y
        if degree > 2:
            b[4, k], b[5, k] = x * (x * x - 3.0 * y * y), y * (3.0 * x * x - y * y)
    else:
        z = d[2]
        b[2, k] = z
        if degree > 1:
            b[3, k], b[4, k], b[5, k], b[6, k], b[7, k] = x * x - y * y, y * y - z * z, x * y, x * z, y * z
        if degree > 2:
            b[8, k], b[9, k], b[10, k] = x * y * z, x * (y * y - z * z), y * (z * z - x * x)
            b[11, k] = z * (x * x - y * y)
            b[12, k] = x * (2.0 * x * x - 3.0 * y * y - 3.0 * z * z)
            b[13, k] = y * (2.0 * y * y - 3.0 * z * z - 3.0 * x * x)
            b[14, k] = z * (2.0 * z * z - 3.0 * x * x - 3.0 * y * y)


@inlined
def fill_slopes(b: np.ndarray, k: int, d: np.ndarray, n: np.ndarray, degree: int, axes: tuple[int, ...]) -> None:
    """Write the derivatives of these polynomials in the direction n (dim,) at the place d (dim,) to column k."""
    x, y, p, q = d[0], d[1], n[0], n[1]
    b[0, k], b[1, k] = p, q
    if len(axes) == 2:
        if degree > 1:
            b[2, k], b[3, k] = 2.0 * (x * p - y * q), y * p + x * q
        if degree > 2:
            b[4, k] = 3.0 * (x * x - y * y) * p - 6.0 * x * y * q
            b[5, k] = 6.0 * x * y * p + 3.0 * (x * x - y * y) * q
    else:
        z, r = d[2], n[2]
        b[2, k] = r
        if degree > 1:
            b[3, k], b[4, k] = 2.0 * (x * p - y * q), 2.0 * (y * q - z * r)
            b[5, k], b[6, k], b[7, k] = y * p + x * q, z * p + x * r, z * q + y * r
        if degree > 2:
            b[8, k] = y * z * p + x * z * q + x * y * r
            b[9, k] = (y * y - z * z) * p + 2.0 * x * (y * q - z * r)
            b[10, k] = (z * z - x * x) * q + 2.0 * y * (z * r - x * p)
            b[11, k] = (x * x - y * y) * r + 2.0 * z * (x * p - y * q)
            b[12, k] = (6.0 * x * x - 3.0 * y * y - 3.0 * z * z) * p - 6.0 * x * (y * q + z * r)
            b[13, k] = (6.0 * y * y - 3.0 * z * z - 3.0 * x * x) * q - 6.0 * y * (z * r + x * p)
            b[14, k] = (6.0 * z * z - 3.0 * x * x - 3.0 * y * y) * r - 6.0 * z * (x * p + y * q)


@inlined
def fit(right: np.ndarray, work: np.ndarray, moment: np.ndarray, scratch: np.ndarray, b: np.ndarray, w: np.ndarray,
        m: int, n: int, most: float, axes: tuple[int, ...]) -> bool:
    """Write the coefficients of n polynomials to right (n,), from the m data in the columns of b, the last row of which
    holds their values; return whether the fit is sound.

    It is not where the data do not determine the coefficients, or the terms above the first degree raise the variance
    of the slope to more than `most` times that of a linear fit. b is padded to whole LANES.

    w : (1, columns) weights; work : (n, n + 3), moment : (dim, dim), scratch : (n,)
    """
    dim, last = len(axes), len(b) - 1
    columns = (m + LANES - 1) // LANES * LANES
    for k in range(m, columns):
        w[0, k], b[last, k] = 0.0, 0.0
        for r in range(n):
            b[r, k] = 0.0
    normal_matrix(work, b, w, n, columns)
    for r in range(n):
        total = 0.0
        for k in range(columns):
            total += w[0, k] * b[r, k] * b[last, k]
        right[r] = total
    for a in range(dim):
        for c in range(a + 1):
            moment[a, c] = moment[c, a] = work[a, c]
    if not cholesky(work, n):
        return False
    if most < np.inf and inflation(moment, work, scratch, n, axes) > most:
        return False
    cholesky_solve(work, right, n)
    return True


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
    radius2, column, d = radius * radius, b.reshape(n, 1), np.empty(dim)
    work[:n, :n] = 0.0
    found = 0
    for k in range(indptr[i], indptr[i + 1]):
        w = _weight(i, indices[k], x, role, radius2, axes)
        if w == 0.0:
            continue
        found += 1
        for a in range(dim):
            d[a] = (x[indices[k], a] - x[i, a]) / radius
        fill_values(column, 0, d, 2, axes)
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
    if most < np.inf and inflation(out, work, b, n, axes) > most:
        return False
    for k in range(indptr[i], indptr[i + 1]):
        row = k - indptr[i]
        w = _weight(i, indices[k], x, role, radius2, axes)
        if w == 0.0:
            out[row, :] = 0.0
            continue
        for a in range(dim):
            d[a] = (x[indices[k], a] - x[i, a]) / radius
        fill_values(column, 0, d, 2, axes)
        cholesky_solve(work, b, n)
        for a in range(dim):
            out[row, a] = w * b[a] / radius
    return True


@subkernel
def inflation(moment: np.ndarray, work: np.ndarray, b: np.ndarray, n: int, axes: tuple[int, ...]) -> float:
    """Return by how much the terms of degree 2 and 3 raise the variance of the slope, as a mean over directions.

    moment : (dim, dim), of the linear terms alone; work : the factor of all n terms; b : (n,) scratch
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
