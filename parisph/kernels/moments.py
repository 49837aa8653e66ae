"""Moments of weighted least squares, and their small linear systems.

SFDI (Zheng et al. 2017, Eq. 29) is first-order weighted least squares with the weight W/r^2, Eq. 28 the same with the
weight W, and the wall rows are its normal component. One moment kernel serves all three, in 2D and 3D.
"""

import numpy as np

from parisph.kernels.jit import inlined, subkernel
from parisph.kernels.near import CLOSE, dot4
from parisph.kernels.records import Cloud
from parisph.kernels.roles import outside
from parisph.kernels.smoothing import quartic_weight

# With smaller pivots the neighbours do not span the basis: the system amplifies rounding errors and disorder.
PIVOT_FLOOR = 2.0e-3    # tuned 0.001 to 0.004: pivot over the largest diagonal entry, least of a sound fit; judged

# In this unit the moments up to the fourth are of order one. In units of the radius, good neighbours would fall below
# PIVOT_FLOOR.
QUADRATIC_UNIT = 0.3    # tuned 0.15 to 0.6: unit of length of quadratic fits, in radii; judged


@inlined
def cholesky(a: np.ndarray, n: int) -> bool:
    """Factorise the leading n x n block of a (lower triangle) in place; return False if it is degenerate.

    a = L D L^T without square roots: the diagonal becomes 1/D, the entries below it L D.
    """
    largest, sound = 0.0, True
    for k in range(n):
        largest = max(largest, a[k, k])
    for k in range(n):
        pivot = a[k, k]
        for m in range(k):
            pivot -= a[k, m] * a[k, m] * a[m, m]
        sound &= pivot > PIVOT_FLOOR * largest
        a[k, k] = 1.0 / pivot
        for row in range(k + 1, n):
            value = a[row, k]
            for m in range(k):
                value -= a[row, m] * a[k, m] * a[m, m]
            a[row, k] = value
    return sound


@inlined
def cholesky_solve(a: np.ndarray, b: np.ndarray, n: int) -> None:
    """Solve in place with the factor of `cholesky`: b becomes the solution."""
    for k in range(n):
        value = b[k]
        for m in range(k):
            value -= a[k, m] * b[m]
        b[k] = value * a[k, k]
    for k in range(n - 1, -1, -1):
        value = b[k]
        for m in range(k + 1, n):
            value -= a[m, k] * a[k, k] * b[m]
        b[k] = value


@inlined
def solve_columns(a: np.ndarray, b: np.ndarray, n: int, m: int) -> None:
    """Do the same as `cholesky_solve` for the first n entries of m columns of b, several columns at a time."""
    for k in range(n):
        for r in range(k):
            factor = a[k, r]
            for c in range(m):
                b[k, c] -= factor * b[r, c]
        factor = a[k, k]
        for c in range(m):
            b[k, c] *= factor
    for k in range(n - 1, -1, -1):
        for r in range(k + 1, n):
            factor = a[r, k] * a[k, k]
            for c in range(m):
                b[k, c] -= factor * b[r, c]


@inlined
def normal_matrix(matrix: np.ndarray, basis: np.ndarray, w: np.ndarray, size: int, m: int) -> None:
    """Write the lower triangle of sum_k w[0, k] b_k b_k^T of the first rows of a basis over m columns.

    basis, matrix : rows, or columns, are padded to a multiple of four, as four products are summed at a time
    """
    for r in range(size):
        for s in range(0, r + 1, 4):
            matrix[r, s], matrix[r, s + 1], matrix[r, s + 2], matrix[r, s + 3] = dot4(basis, r, w, basis, s, m)


@inlined
def eliminate(a: np.ndarray, b: np.ndarray, n: int) -> bool:
    """Solve a b = b in place by elimination with row exchange; False if degenerate, with b undefined.

    a : (n, n), any matrix, overwritten; b : (n,), becomes the solution
    """
    largest, sound = 0.0, True
    for row in range(n):
        for k in range(n):
            largest = max(largest, abs(a[row, k]))
    for k in range(n):
        best = k
        for row in range(k + 1, n):
            if abs(a[row, k]) > abs(a[best, k]):
                best = row
        for c in range(n):
            a[k, c], a[best, c] = a[best, c], a[k, c]
        b[k], b[best] = b[best], b[k]
        sound &= abs(a[k, k]) > PIVOT_FLOOR * largest
        for row in range(k + 1, n):
            factor = a[row, k] / a[k, k]
            for c in range(k, n):
                a[row, c] -= factor * a[k, c]
            b[row] -= factor * b[k]
    for k in range(n - 1, -1, -1):
        for c in range(k + 1, n):
            b[k] -= a[k, c] * b[c]
        b[k] /= a[k, k]
    return sound


@subkernel
def second_moment(m: np.ndarray, i: int, cloud: Cloud, radius2: float, power: int) -> int:
    """Write the sum of w r r^T over the neighbours of i, lengths in units of the radius; return their number.

    w is the quartic weight over r^power: power 2 for SFDI, 0 for Zheng et al. 2017 Eq. 28. Dry wall particles are
    skipped.
    """
    x, dim, found = cloud.x, len(cloud.axes), 0
    for a in range(dim):
        for b in range(dim):
            m[a, b] = 0.0
    for k in range(cloud.indptr[i], cloud.indptr[i + 1]):
        j = cloud.indices[k]
        if outside(cloud.role[j]):
            continue
        w, r2 = pair_weight(i, j, x, radius2, power, cloud.axes)
        if w == 0.0:
            continue
        found += 1
        for a in range(dim):
            for b in range(a + 1):
                m[a, b] += w * (x[j, a] - x[i, a]) * (x[j, b] - x[i, b]) / radius2
    for a in range(dim):
        for b in range(a):
            m[b, a] = m[a, b]
    return found


@subkernel
def pair_weight(i: int, j: int, x: np.ndarray, radius2: float, power: int,
                axes: tuple[int, ...]) -> tuple[float, float]:
    """Return the least-squares weight of a pair and its squared distance (0 beyond the radius)."""
    r2 = 0.0
    for a in range(len(axes)):
        r2 += (x[j, a] - x[i, a]) ** 2
    if r2 >= radius2 or r2 == 0.0:  # coincident particles have no direction
        return 0.0, r2
    w = quartic_weight(r2, radius2)
    if power == 2:
        w *= radius2 / max(r2, CLOSE * radius2)
    return w, r2


@subkernel
def invert(m: np.ndarray, inverse: np.ndarray, axes: tuple[int, ...]) -> float:
    """Invert the dim x dim moment; return det/(trace/dim)^dim, 1 for isotropic, 0 for flat."""
    dim = len(axes)
    trace = 0.0
    for a in range(dim):
        trace += m[a, a]
    if not trace > 0.0:
        return 0.0
    if dim == 2:
        det = m[0, 0] * m[1, 1] - m[0, 1] * m[1, 0]
        if not det > 0.0:
            return 0.0
        inverse[0, 0], inverse[1, 1] = m[1, 1] / det, m[0, 0] / det
        inverse[0, 1] = inverse[1, 0] = -m[0, 1] / det
        return det / (0.5 * trace) ** 2
    c00 = m[1, 1] * m[2, 2] - m[1, 2] * m[2, 1]
    c01 = m[1, 2] * m[2, 0] - m[1, 0] * m[2, 2]
    c02 = m[1, 0] * m[2, 1] - m[1, 1] * m[2, 0]
    det = m[0, 0] * c00 + m[0, 1] * c01 + m[0, 2] * c02
    if not det > 0.0:
        return 0.0
    inverse[0, 0], inverse[0, 1], inverse[0, 2] = c00 / det, c01 / det, c02 / det
    inverse[1, 1] = (m[0, 0] * m[2, 2] - m[0, 2] * m[2, 0]) / det
    inverse[1, 2] = (m[0, 2] * m[1, 0] - m[0, 0] * m[1, 2]) / det
    inverse[2, 2] = (m[0, 0] * m[1, 1] - m[0, 1] * m[1, 0]) / det
    inverse[1, 0], inverse[2, 0], inverse[2, 1] = inverse[0, 1], inverse[0, 2], inverse[1, 2]
    return det / (trace / 3.0) ** 3
