"""First derivatives from a local fit by harmonic polynomials.

Where lap f = 0, the quadratic terms of f are harmonic, so that a fit by (X, Y, X^2 - Y^2, XY) is of second order. It
needs far fewer neighbours than a full quadratic fit, which suits one-sided stencils at walls and at the surface. The
two harmonic terms of degree 3 (seven in 3D) make it of third order.
"""

from typing import NamedTuple

import numpy as np

from parisph.kernels.jit import inlined, subkernel
from parisph.kernels.moments import PIVOT_FLOOR, cholesky, cholesky_solve, invert, normal_matrix, solve_columns
from parisph.kernels.near import LANES, dot4
from parisph.kernels.records import Cloud
from parisph.kernels.roles import outside
from parisph.kernels.smoothing import quartic_weight

# 1.04 spacings for a radius of 2.6, so that all moments are of order one. A slope across a wall weighs as much as a
# difference between values over this length. A quarter or four times this length works as well.
UNIT = 0.4    # tuned 0.1 to 1.6: unit of length of a fit with slopes, in radii; measured


class Slopes(NamedTuple):
    """Normal derivatives at walls, data of a fit.

    value : (n_all,), n . grad f; known : (n_all,) bool, where it is known
    """

    value: np.ndarray
    known: np.ndarray


class Fit(NamedTuple):
    """Data and linear system of a fit by harmonic polynomials up to degree 3.

    b : (terms + 4, columns), polynomials, then a row of data; columns and rows are padded to whole LANES
    w : (1, columns) weights
    work, right : (terms, terms + 3), (terms + 3,), moments of the polynomials (lower triangle) and of the data
    moment, rest, inverse : (dim, dim) scratch
    """

    b: np.ndarray
    w: np.ndarray
    work: np.ndarray
    right: np.ndarray
    moment: np.ndarray
    rest: np.ndarray
    inverse: np.ndarray


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
def fill_values(b: np.ndarray, m: int, degree: int, axes: tuple[int, ...]) -> None:
    """Append the harmonic polynomials of degree 2 to `degree` to the coordinates in the first rows of m columns."""
    if len(axes) == 2:
        for k in range(m):
            x, y = b[0, k], b[1, k]
            b[2, k], b[3, k] = x * x - y * y, x * y
            if degree > 2:
                b[4, k], b[5, k] = x * (x * x - 3.0 * y * y), y * (3.0 * x * x - y * y)
        return
    for k in range(m):
        x, y, z = b[0, k], b[1, k], b[2, k]
        b[3, k], b[4, k], b[5, k], b[6, k], b[7, k] = x * x - y * y, y * y - z * z, x * y, x * z, y * z
        if degree > 2:
            b[8, k], b[9, k], b[10, k] = x * y * z, x * (y * y - z * z), y * (z * z - x * x)
            b[11, k] = z * (x * x - y * y)
            b[12, k] = x * (2.0 * x * x - 3.0 * y * y - 3.0 * z * z)
            b[13, k] = y * (2.0 * y * y - 3.0 * z * z - 3.0 * x * x)
            b[14, k] = z * (2.0 * z * z - 3.0 * x * x - 3.0 * y * y)


@inlined
def fill_slopes(b: np.ndarray, k: int, place: tuple[float, float, float], direction: tuple[float, float, float],
                axes: tuple[int, ...]) -> None:
    """Write the directional derivatives of the polynomials up to degree 3 at a place to column k.

    Third coordinates are not used in 2D.
    """
    (x, y, z), (p, q, r) = place, direction
    b[0, k], b[1, k] = p, q
    if len(axes) == 2:
        b[2, k], b[3, k] = 2.0 * (x * p - y * q), y * p + x * q
        b[4, k] = 3.0 * (x * x - y * y) * p - 6.0 * x * y * q
        b[5, k] = 6.0 * x * y * p + 3.0 * (x * x - y * y) * q
    else:
        b[2, k] = r
        b[3, k], b[4, k] = 2.0 * (x * p - y * q), 2.0 * (y * q - z * r)
        b[5, k], b[6, k], b[7, k] = y * p + x * q, z * p + x * r, z * q + y * r
        b[8, k] = y * z * p + x * z * q + x * y * r
        b[9, k] = (y * y - z * z) * p + 2.0 * x * (y * q - z * r)
        b[10, k] = (z * z - x * x) * q + 2.0 * y * (z * r - x * p)
        b[11, k] = (x * x - y * y) * r + 2.0 * z * (x * p - y * q)
        b[12, k] = (6.0 * x * x - 3.0 * y * y - 3.0 * z * z) * p - 6.0 * x * (y * q + z * r)
        b[13, k] = (6.0 * y * y - 3.0 * z * z - 3.0 * x * x) * q - 6.0 * y * (z * r + x * p)
        b[14, k] = (6.0 * z * z - 3.0 * x * x - 3.0 * y * y) * r - 6.0 * z * (x * p + y * q)


@inlined
def weigh(w: np.ndarray, near: np.ndarray, m: int, axes: tuple[int, ...]) -> None:
    """Write the weights of m places in UNITs of the radius, given in the first rows of `near`."""
    for k in range(m):
        r2 = near[0, k] ** 2 + near[1, k] ** 2
        if len(axes) == 3:
            r2 += near[2, k] ** 2
        w[0, k] = quartic_weight(r2, 1.0 / UNIT**2)


@subkernel
def fit_of(columns: int, axes: tuple[int, ...]) -> Fit:
    """Return a Fit with room for this number of columns."""
    dim, size = len(axes), terms(3, axes)
    return Fit(np.zeros((size + 4, columns)), np.empty((1, columns)), np.empty((size, size + 3)), np.empty(size + 3),
               np.empty((dim, dim)), np.empty((dim, dim)), np.empty((dim, dim)))


@inlined
def add_slopes(fit: Fit, m: int, i: int, cloud: Cloud, slopes: Slopes, lap: float, scale: float, radius: float) -> int:
    """Append a column for each known normal derivative at i and its neighbours; return the new number of columns.

    m : number of columns before; lap : increase of slopes per distance [1/m]; scale : of data
    radius : of the weight [m]; lengths are in UNITs of it
    """
    x, normal, indptr, axes, unit = cloud.x, cloud.normal, cloud.indptr, cloud.axes, UNIT * radius
    radius2, z, r, first = radius * radius, 0.0, 0.0, np.uint32(indptr[i])
    for k in range(first, np.uint32(indptr[i + 1]) + np.uint32(1)):
        j = np.uint32(i if k == first else cloud.indices[np.uint32(k - 1)])
        if not slopes.known[j]:
            continue
        dx, dy, p, q = x[j, 0] - x[i, 0], x[j, 1] - x[i, 1], normal[j, 0], normal[j, 1]
        r2, away = dx * dx + dy * dy, p * dx + q * dy
        if len(axes) == 3:
            z, r = x[j, 2] - x[i, 2], normal[j, 2]
            r2 += z * z
            away += r * z
        weight = quartic_weight(r2, radius2)
        if weight > 0.0:
            fill_slopes(fit.b, m, (dx / unit, dy / unit, z / unit), (p, q, r), axes)
            fit.w[0, m], fit.b[terms(3, axes), m] = weight, (slopes.value[j] - lap * away) * scale
            m += 1
    return m


@inlined
def assemble(fit: Fit, m: int, n: int, axes: tuple[int, ...]) -> None:
    """Write the moments of the first n polynomials and of the data over m columns."""
    b, w, work, right = fit.b, fit.w, fit.work, fit.right
    if m == 0:
        for r in range(n):
            right[r] = 0.0
            for c in range(r + 1):
                work[r, c] = 0.0
        return
    last, columns = terms(3, axes), (m + LANES - 1) // LANES * LANES
    for k in range(m, columns):
        w[0, k] = 0.0
        for r in range(last + 1):
            b[r, k] = 0.0
    normal_matrix(work, b, w, n, columns)
    for s in range(0, n, 4):
        right[s], right[s + 1], right[s + 2], right[s + 3] = dot4(b, last, w, b, s, columns)


@inlined
def solve(fit: Fit, n: int, few: int, most: float, axes: tuple[int, ...]) -> bool:
    """Write the first coefficients of n polynomials to `right`; return whether the fit is sound.

    It is unsound if the data do not determine the coefficients, or if the terms above the first degree raise the
    variance of the slope to more than `most` times that of a linear fit.

    few : number of coefficients needed, at least those of degree 1
    """
    work, right, moment, rest, inverse = fit.work, fit.right, fit.moment, fit.rest, fit.inverse
    dim = len(axes)
    largest, sound = 0.0, True
    for a in range(dim):
        for c in range(a + 1):
            moment[a, c] = moment[c, a] = work[a, c]
    for k in range(n):
        largest = max(largest, work[k, k])
    # eliminate the highest degrees first: slopes need only the rest, for degree 1
    for k in range(n - 1, dim - 1, -1):
        sound &= work[k, k] > PIVOT_FLOOR * largest
        work[k, k] = 1.0 / work[k, k]
        for r in range(k):
            factor = work[k, r] * work[k, k]
            for c in range(r + 1):
                work[r, c] -= factor * work[k, c]
            right[r] -= factor * right[k]
    for a in range(dim):
        for c in range(a + 1):
            rest[a, c] = rest[c, a] = work[a, c]
    if not (sound and invert(rest, inverse, axes) > 0.0):
        return False
    raised = 0.0
    for a in range(dim):
        sound &= inverse[a, a] * moment[a, a] * PIVOT_FLOOR < 1.0
        work[a, a] = right[a]
        for c in range(dim):
            raised += inverse[a, c] * moment[a, c] / dim
    for a in range(dim):
        right[a] = 0.0
        for c in range(dim):
            right[a] += inverse[a, c] * work[c, c]
    for k in range(dim, few):
        for c in range(k):
            right[k] -= work[k, c] * right[c]
        right[k] *= work[k, k]
    return sound and raised <= most


@subkernel
def coefficients(out: np.ndarray, i: int, cloud: Cloud, radius: float, most: float, work: np.ndarray,
                 b: np.ndarray) -> bool:
    """Write c_j so that d f/dx_a (x_i) = sum_j c[j, a] (f_j - f_i) for harmonic f.

    Returns False, with out undefined, if the neighbours do not span the basis, or not well enough for `most`.

    out, work, b : of `scratch`; out [1/m] in the order of the list of i; radius : of the quartic weight [m]
    most : largest ratio of the variances of first derivatives with and without terms of degree 2, or infinity: for
        noise of variance 1/w, the mean over directions trace(M (A^-1)_11)/dim, with A = sum w b b^T and its linear
        block M = A_11
    """
    x, role, indptr, indices, axes = cloud.x, cloud.role, cloud.indptr, cloud.indices, cloud.axes
    dim, n, found, first = len(axes), basis_size(axes), 0, indptr[i]
    columns = indptr[i + 1] - first
    for row in range(columns):
        w = b[n, row] = _weight(i, indices[first + row], x, role, radius * radius, axes)
        found += w != 0.0
        for a in range(dim):
            b[a, row] = (x[indices[first + row], a] - x[i, a]) / radius
    if found < n + 1:
        return False
    fill_values(b, columns, 2, axes)
    work[:n, :n] = 0.0
    for row in range(columns):
        if b[n, row] > 0.0:
            for r in range(n):
                for c in range(r + 1):
                    work[r, c] += b[n, row] * b[r, row] * b[c, row]
    for a in range(dim):
        for c in range(a + 1):
            out[a, c] = out[c, a] = work[a, c]
    if not cholesky(work, n):
        return False
    if most < np.inf and inflation(out, work, b[n + 1], n, axes) > most:
        return False
    solve_columns(work, b, n, columns)
    for row in range(columns):
        for a in range(dim):
            out[row, a] = b[n, row] * b[a, row] / radius if b[n, row] > 0.0 else 0.0
    return True


@subkernel
def inflation(moment: np.ndarray, work: np.ndarray, b: np.ndarray, n: int, axes: tuple[int, ...]) -> float:
    """Return the factor by which terms of degree 2 and 3 raise the variance of the slope, averaged over directions.

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
    """Return arrays (out, work, b) for `coefficients`, large enough for every row."""
    longest = 1
    for i in range(len(indptr) - 1):
        longest = max(longest, indptr[i + 1] - indptr[i])
    n = basis_size(axes)
    return np.empty((max(longest, len(axes)), len(axes))), np.empty((n, n)), np.empty((n + 2, max(longest, n)))
