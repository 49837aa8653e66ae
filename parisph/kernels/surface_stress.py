"""Viscous acceleration and pressure at a stress-free surface."""

import math

import numpy as np

from parisph.base.fields import SURFACE
from parisph.kernels.across import room_across
from parisph.kernels.jit import inlined, kernel, subkernel
from parisph.kernels.moments import cholesky_solve, invert
from parisph.kernels.records import Cloud, Walls
from parisph.kernels.smoothing import quartic_weight
from parisph.kernels.viscous import STRETCH, Flowing, Quadratics, factor_quadratics, gather_flow

FLAT = 1e-4         # isotropic part added to the moment of surface neighbours, over its trace, to make it invertible
TURNS = 4           # inverse iterations; each reduces the tangential part by a factor of FLAT
ASTRAY = 0.7        # tuned 0.35 to 1: cosine of two normals below which neighbours lie in no plane; judged
# Variance by unit errors of the velocities, in units of 1/radius^2: 3 to 6 on a lattice with a flat surface, 21 on that
# of a drop, and up to 17 with jitter 0.8. Without a bound, particles jittered by 1.2 have growing velocity modes.
POOR = 22.0    # tuned 11 to 44: variance of a slope along the surface above which a fit is too poor; measured


@kernel
def stress_free(out: np.ndarray, tension: np.ndarray, cloud: Cloud, walls: Walls, flowing: Flowing,
                radius: float) -> None:
    """Replace the viscous acceleration of surface particles by that at a surface without stress.

    With the normal n out of the fluid and its unit tangents t, t . (grad u + (grad u)^T) . n = 0, and p = 2 rho nu n .
    grad u . n. The acceleration is that of the quadratic fit whose slope along n follows from those along the surface:
    d u_t/dn = -d u_n/dt, and d u_n/dn = -div_t u, as the fluid is incompressible. The slopes along the surface are
    those of the plain fit. The acceleration of a rigid rotation is zero.

    Where neighbours do not span the quadratics well, `out` stays unchanged, and the tension is 0.

    out : (n_owned, dim) [m/s^2], rows of owned surface particles are written
    tension : (n_owned,) output, 2 nu n . grad u . n [m^2/s^2], 0 for all other particles; others as in
        `viscous.corrected`
    """
    axes, across = cloud.axes, room_across(cloud)
    dim, size = len(axes), len(axes) + len(axes) * (len(axes) + 1) // 2
    fit = Quadratics(np.empty((size, across.near.shape[1])), np.empty(across.near.shape[1]), np.empty((size, size)))
    found, lift = np.empty((dim, size)), np.empty(size)
    mean, away, slope = np.empty(dim), np.empty(dim), np.empty(dim)
    for i in range(len(out)):
        tension[i] = 0.0
        if cloud.role[i] != SURFACE:
            continue
        n = gather_flow(across, i, cloud, walls, flowing, False, radius)
        if not _fit(found, fit, across, n, axes) or not _inward(mean, fit, across, n, axes):
            continue
        _outward(away, mean, i, cloud, radius)
        if _variance_along(lift, fit.work, away, axes) > (dim - 1) * POOR:
            continue
        tension[i] = 2.0 * _slope_without_stress(slope, found, away, axes) / radius
        _lay_down(out, i, found, lift, away, slope, radius, axes)


@subkernel
def _fit(found, fit, across, n, axes):
    """Fit quadratics through 0 to du = nu_ij (u_j - u_i); False if degenerate. found[a] are the coefficients of u_a."""
    size = len(fit.work)
    if not factor_quadratics(fit, across.near, n, axes):
        return False
    for a in range(len(axes)):
        for r in range(size):
            total = 0.0
            for k in range(n):
                total += fit.weight[k] * fit.basis[r, k] * across.du[a, k]
            found[a, r] = total
        cholesky_solve(fit.work, found[a], size)
    return True


@inlined
def _inward(mean, fit, across, n, axes):
    """Write the direction of the mean neighbour; return False if it has none."""
    for a in range(len(axes)):
        mean[a] = 0.0
        for k in range(n):
            mean[a] += fit.weight[k] * across.near[a, k]
    return _normalise(mean, axes)


@subkernel
def _outward(away, mean, i, cloud, radius):
    """Write the outward normal of the plane through i that fits its surface neighbours best.

    Inverse iteration with their moment starts from -mean: among disordered particles, the mean neighbour may deviate
    from the normal by a tenth. The result is -mean where these neighbours lie in no plane, as in spray.
    """
    axes, dim = cloud.axes, len(cloud.axes)
    moment, inverse = np.empty((dim, dim)), np.empty((dim, dim))
    trace = _surface_moment(moment, i, cloud, radius)
    for a in range(dim):
        moment[a, a] += FLAT * trace if trace > 0.0 else 1.0
        away[a] = -mean[a]
    invert(moment, inverse, axes)
    for _ in range(TURNS):
        for a in range(dim):
            moment[0, a] = away[a]
        for a in range(dim):
            away[a] = 0.0
            for b in range(dim):
                away[a] += inverse[a, b] * moment[0, b]
        _normalise(away, axes)
    cosine = 0.0
    for a in range(dim):
        cosine -= away[a] * mean[a]
    if cosine < ASTRAY:
        for a in range(dim):
            away[a] = -mean[a]


@subkernel
def _surface_moment(moment, i, cloud, radius):
    """Write the weighted sum of r r^T over the surface neighbours; return its trace."""
    x, dim, trace = cloud.x, len(cloud.axes), 0.0
    moment[:, :] = 0.0
    for k in range(cloud.indptr[i], cloud.indptr[i + 1]):
        j = cloud.indices[k]
        if cloud.role[j] != SURFACE:
            continue
        r2 = 0.0
        for a in range(dim):
            r2 += (x[j, a] - x[i, a]) ** 2
        w = quartic_weight(r2, radius * radius) / (radius * radius)
        for a in range(dim):
            for b in range(dim):
                moment[a, b] += w * (x[j, a] - x[i, a]) * (x[j, b] - x[i, b])
        trace += w * r2
    return trace


@inlined
def _normalise(v, axes):
    square = 0.0
    for a in range(len(axes)):
        square += v[a] * v[a]
    length = math.sqrt(square) if square > 0.0 else 1.0
    for a in range(len(axes)):
        v[a] /= length
    return square > 0.0


@inlined
def _slope_without_stress(slope, fit, away, axes):
    """Write the stress-free derivative of the velocity along n; return its part along n, -div_t u.

    fit : its first columns [a, b] are du_a/dx_b
    """
    dim, stretch = len(axes), 0.0
    for a in range(dim):
        stretch -= fit[a, a]
        for b in range(dim):
            stretch += away[a] * fit[a, b] * away[b]
    through = stretch
    for a in range(dim):
        slope[a] = 0.0
        for b in range(dim):
            slope[a] -= fit[b, a] * away[b]
        through -= slope[a] * away[a]
    for a in range(dim):
        slope[a] += through * away[a]
    return stretch


@subkernel
def _variance_along(lift, work, away, axes):
    """Return the variance of all slopes along the surface, the trace of the inverse of M minus its part along n.

    lift : (size,) output, M^-1 (n, 0)
    """
    dim, total = len(axes), 0.0
    for a in range(dim):
        lift[:] = 0.0
        lift[a] = 1.0
        cholesky_solve(work, lift, len(lift))
        total += lift[a]
    lift[:] = 0.0
    for a in range(dim):
        lift[a] = away[a]
    cholesky_solve(work, lift, len(lift))
    for a in range(dim):
        total -= away[a] * lift[a]
    return total


@inlined
def _lay_down(out, i, fit, lift, away, slope, radius, axes):
    """Write the Laplacian of the fit with a given slope along n.

    With the normal matrix M, the constraint n . g = slope changes the coefficients by a multiple of M^-1 (n, 0).
    """
    dim, response = len(axes), 0.0
    for a in range(dim):
        response += away[a] * lift[a]
    for a in range(dim):
        share = slope[a]
        for b in range(dim):
            share -= fit[a, b] * away[b]
        share /= response
        row = dim
        out[i, a] = 0.0
        for b in range(dim):
            row += b
            out[i, a] += 2.0 * STRETCH / radius**2 * (fit[a, row] + share * lift[row])
            row += 1
