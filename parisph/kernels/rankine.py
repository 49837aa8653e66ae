"""ISPH_R rows: the pressure equation in its Rankine-source weak form.

Zheng, Ma & Duan (2014), Eqs. 21-23 and 33: with phi = ln(r/R)/2 pi the mean of p over the
circle of radius R about particle I, minus p_I, equals (R^2/4) lap p + O(R^4). The mean is
taken over K points, where p is interpolated by linear moving least squares.

That interpolant does not pass through the particles: it adds its own second moment to the
circle's, about 2 R^2 at R = s/2. The row is therefore normalised by what it really does to
a parabola, M = sum_J A_IJ |x_J - x_I|^2, in place of R^2; as printed, the operator is wrong
by a factor of about three at every resolution.
"""

import math

import numpy as np

from parisph.base.fields import INNER
from parisph.kernels.harmonic import basis_size
from parisph.kernels.jit import kernel
from parisph.kernels.moments import PIVOT_FLOOR, cholesky, cholesky_solve
from parisph.kernels.roles import outside
from parisph.kernels.smoothing import quartic_weight


def directions(dim, count=None):
    """Return unit vectors spread evenly over the circle or the sphere: (K, dim).

    2D: `count` (default 8) points; 3D: the 12 corners of the icosahedron, whose mean
    integrates polynomials up to degree five exactly.
    """
    if dim == 2:
        angle = 2.0 * np.pi * np.arange(count or 8) / (count or 8)
        return np.stack([np.cos(angle), np.sin(angle)], axis=1)
    golden = 0.5 * (1.0 + math.sqrt(5.0))
    corner = [(0.0, a, b * golden) for a in (-1.0, 1.0) for b in (-1.0, 1.0)]
    points = np.array([np.roll(c, shift) for shift in range(3) for c in corner])
    return points / np.linalg.norm(points[0])


@kernel
def rankine_rows(count, columns, values, measure, flux, div, u, x, role, unit, circle, radius,
                 normalised, indptr, indices, axes):
    """Fill the rows of inner particles, and the flux divergence of u.

    With row_I(p) = p_I - sum_J values_J p_J, the equation is row_I(p) = -measure_I lap p.

    count : (n_owned,) int32, entries of each row but its diagonal
    columns, values : row I starts at indptr[I] (local column numbers)
    measure : (n_owned,) M/(2 dim), or R^2/(2 dim) as printed [m^2]; 0 for a row that its
        neighbours cannot support, which becomes a mean of them
    flux : (nnz, dim) so that div u_I = sum_J flux_J . (u_J - u_I) [1/m]
    div : (n_owned,) div u from the flux through the circle [1/s]
    unit : (K, dim) from `directions`; circle : R [m]; radius : of the moving least squares [m]
    """
    dim, points = len(axes), len(unit)
    longest = 1
    for i in range(len(indptr) - 1):
        longest = max(longest, indptr[i + 1] - indptr[i])
    near = np.empty((longest + 1, dim))  # relative positions, in units of the radius
    w = np.empty(longest + 1)
    shape = np.empty(longest + 1)
    normal_shape = np.empty((longest + 1, dim))
    c = np.empty(dim + 1)
    m = np.empty((dim + 1, dim + 1))
    moment = np.empty((basis_size(axes), basis_size(axes)))
    basis = np.empty((longest, basis_size(axes)))
    right = np.empty(basis_size(axes))
    for i in range(len(indptr) - 1):
        if role[i] != INNER:
            continue
        first = indptr[i]
        n = 0
        for k in range(first, indptr[i + 1]):
            j = indices[k]
            if not outside(role[j]):
                columns[first + n] = j
                for a in range(dim):
                    near[n, a] = (x[j, a] - x[i, a]) / radius
                n += 1
        near[n, :] = 0.0  # the particle itself comes last
        shape[:n + 1] = 0.0
        normal_shape[:n + 1, :] = 0.0
        for q in range(points):
            _add_point(shape, normal_shape, near, n + 1, unit[q], circle / radius, w, c, m, axes)
        for k in range(n):
            shape[k] /= points
        if normalised:
            _make_isotropic(shape, near, n, moment, basis, right, axes)
        spread = 0.0
        for k in range(n):
            r2 = 0.0
            for a in range(dim):
                r2 += near[k, a] ** 2
            spread += shape[k] * r2
        count[i] = n
        _finish(i, first, n, shape, normal_shape, spread, columns, values, measure, flux, div, u,
                circle, radius, points, normalised, axes)


@kernel
def _make_isotropic(shape, near, n, moment, basis, right, axes):
    """Take the harmonic second moment out of a row by the smallest weighted change.

    The mean over the circle of X^2 - Y^2 and of XY is zero. On disordered particles the moving
    least squares leave a remainder, an error of order one in the Laplacian that no refinement
    removes. Rows whose neighbours do not span the harmonic polynomials stay as they are.
    """
    dim, size = len(axes), basis_size(axes)
    moment[:, :] = 0.0
    right[:] = 0.0
    for k in range(n):
        w = _fill(basis[k], near[k], axes)
        for r in range(size):
            right[r] += shape[k] * basis[k, r]
            for s in range(r + 1):
                moment[r, s] += w * basis[k, r] * basis[k, s]
    if n <= size or not cholesky(moment, size):
        return
    cholesky_solve(moment, right, size)
    for k in range(n):
        w = _fill(basis[k], near[k], axes)
        change = 0.0
        for r in range(size):
            change += right[r] * basis[k, r]
        shape[k] -= w * change


@kernel
def _fill(b, point, axes):
    """Write the harmonic polynomials of a point; return its weight, radius 1.25 of the unit."""
    dim = len(axes)
    n, r2 = dim, 0.0
    for a in range(dim):
        b[a] = point[a]
        r2 += point[a] ** 2
    for a in range(dim - 1):
        b[n] = b[a] * b[a] - b[a + 1] * b[a + 1]
        n += 1
    for a in range(dim):
        for c in range(a):
            b[n] = b[a] * b[c]
            n += 1
    return quartic_weight(r2, 1.5625)


@kernel
def _finish(i, first, n, shape, normal_shape, spread, columns, values, measure, flux, div, u, circle,
            radius, points, normalised, axes):
    """Scale the row to a unit diagonal, and sum the flux of u."""
    dim = len(axes)
    total = 0.0
    for k in range(n):
        total += shape[k]
    spread *= radius * radius
    div[i] = 0.0
    sound = total > 0.05 and spread > 0.1 * circle * circle
    for k in range(n):
        values[first + k] = shape[k] / total if sound else 1.0 / n
        for a in range(dim):
            flux[first + k, a] = normal_shape[k, a] * dim / (circle * points) if sound else 0.0
            div[i] += flux[first + k, a] * (u[columns[first + k], a] - u[i, a])
    scale = spread if normalised else circle * circle
    measure[i] = scale / (2.0 * dim * total) if sound else 0.0


@kernel
def _add_point(shape, normal_shape, near, n, unit, distance, w, c, m, axes):
    """Add the moving-least-squares shape functions at one point of the circle."""
    dim = len(axes)
    for r in range(dim + 1):
        for s in range(r + 1):
            m[r, s] = 0.0
    for k in range(n):
        r2 = 0.0
        for a in range(dim):
            r2 += (near[k, a] - distance * unit[a]) ** 2
        w[k] = quartic_weight(r2, 1.0)
        if w[k] == 0.0:
            continue
        m[0, 0] += w[k]
        for a in range(dim):
            d = w[k] * (near[k, a] - distance * unit[a])
            m[a + 1, 0] += d
            for b in range(a + 1):
                m[a + 1, b + 1] += d * (near[k, b] - distance * unit[b])
    _first_row_of_inverse(c, m, axes)
    for k in range(n):
        if w[k] == 0.0:
            continue
        value = c[0]
        for a in range(dim):
            value += c[a + 1] * (near[k, a] - distance * unit[a])
        value *= w[k]
        shape[k] += value
        for a in range(dim):
            normal_shape[k, a] += value * unit[a]


@kernel
def _first_row_of_inverse(c, m, axes):
    """Solve m c = e_0; where the points do not span a plane, keep the constant (Shepard): False."""
    n = len(axes) + 1
    weight = m[0, 0]
    for r in range(n):
        for s in range(r):
            for t in range(s):
                m[r, s] -= m[r, t] * m[s, t]
            m[r, s] /= m[s, s]
        for t in range(r):
            m[r, r] -= m[r, t] * m[r, t]
        if not m[r, r] > PIVOT_FLOOR * weight:
            c[:] = 0.0
            c[0] = 1.0 / weight if weight > 0.0 else 0.0
            return False
        m[r, r] = math.sqrt(m[r, r])
    c[0] = 1.0 / m[0, 0]
    for r in range(1, n):
        c[r] = 0.0
        for s in range(r):
            c[r] -= m[r, s] * c[s]
        c[r] /= m[r, r]
    for r in range(n - 1, -1, -1):
        for s in range(r + 1, n):
            c[r] -= m[s, r] * c[s]
        c[r] /= m[r, r]
    return True


@kernel
def divergence(div, u, role, count, columns, flux, indptr, axes):
    """Flux divergence of a velocity with the stored flux coefficients, at inner particles [1/s]."""
    for i in range(len(indptr) - 1):
        div[i] = 0.0
        if role[i] != INNER:
            continue
        for k in range(indptr[i], indptr[i] + count[i]):
            for a in range(len(axes)):
                div[i] += flux[k, a] * (u[columns[k], a] - u[i, a])


@kernel
def second_invariant(out, u, role, count, columns, flux, indptr, axes):
    """tr((grad u)^2) of a velocity at inner particles, from the stored flux coefficients [1/s^2].

    (dim/R) times the mean of u_b n_a over the circle is d u_b/dx_a for linear u, as it is the
    divergence for a = b.
    """
    dim = len(axes)
    g = np.empty((dim, dim))
    for i in range(len(indptr) - 1):
        out[i] = 0.0
        if role[i] != INNER:
            continue
        g[:, :] = 0.0
        for k in range(indptr[i], indptr[i] + count[i]):
            j = columns[k]
            for a in range(dim):
                for b in range(dim):
                    g[a, b] += flux[k, a] * (u[j, b] - u[i, b])
        for a in range(dim):
            for b in range(dim):
                out[i] += g[a, b] * g[b, a]
