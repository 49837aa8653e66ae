"""Viscous acceleration div(nu grad u), with no-slip and free-slip walls.

Walls are one layer of particles on the wall itself, so a particle beside one has neighbours on one side only. The form
of Morris reflects them. The corrected form is a quadratic fit: no-slip walls give their velocity as data, and only
free-slip walls need reflections. With the mean viscosity nu_ij of a pair, a Laplacian of nu_ij (u_j - u_i) is div(nu
grad u), exact for linear nu and linear u if the Laplacian is exact for quadratics.
"""

import math
from typing import NamedTuple

import numpy as np

from parisph.base.fields import FLUID, INNER, WALL
from parisph.kernels.across import Across, differences, gather_across, room_across
from parisph.kernels.gradient import ACROSS
from parisph.kernels.jit import inlined, kernel, subkernel
from parisph.kernels.moments import cholesky, cholesky_solve
from parisph.kernels.records import Cloud, Walls
from parisph.kernels.smoothing import cubic_spline_slope, quartic_weight

# For the largest viscosity, h = 1.3 s and radius = 2.6 s. Eigenvalues between no-slip walls allow, in 2D (3D), 0.6
# (0.57) for morris and 0.83 (0.7) for corrected on a lattice, and 0.47 and 0.62 in 2D with jitter 1.2.
STABLE = 0.4    # tuned 0.2 to 0.8: largest nu dt/s^2 of an explicit step; measured

STRETCH = 3.0       # scale of squares in units of the radius, to make them as large as the coordinates


class Flowing(NamedTuple):
    """Velocities and viscosities for the viscous force.

    u : (n_all, dim) [m/s], of a no-slip wall its own velocity, of a free-slip wall that of `gradient.wall_velocity`
    nu : (n_all,) [m^2/s], of walls that of the fluid there
    no_slip : (n_all,), of walls 1 for no-slip, 0 for free-slip; a corner of both is no-slip
    """

    u: np.ndarray
    nu: np.ndarray
    no_slip: np.ndarray


@kernel
def morris(out: np.ndarray, cloud: Cloud, walls: Walls, flowing: Flowing, h: float) -> None:
    """Write the viscous acceleration of owned fluid by the form of Morris et al. (1997, Eq. 22), at one density.

    a_i = sum_j V (nu_i + nu_j) (r_ij . grad_i W_ij)/(r_ij^2 + 0.01 h^2) (u_i - u_j)

    j runs over fluid, walls and reflections in walls. The reflection of fluid in a no-slip wall moves with 2 u_wall -
    u_j, in a free-slip wall with the reflected velocity. Momentum is conserved between fluid particles.

    out : (n_owned, dim) output [m/s^2], 0 for walls; ABSENT particles do not count
    h : smoothing length [m] of the cubic spline, with support 2 h
    """
    across = room_across(cloud)
    for i in range(len(out)):
        out[i, :] = 0.0
        if cloud.kind[i] == FLUID:
            _add_morris(out, i, across, cloud, walls, flowing, h)


@kernel
def corrected(out: np.ndarray, cloud: Cloud, walls: Walls, flowing: Flowing, radius: float, h: float) -> None:
    """Write the viscous acceleration of owned fluid by a quadratic fit (generalised finite differences).

    The Laplacian is exact for quadratic velocities on any particles, also beside walls. The form of `morris` is used
    where the neighbours do not span the quadratics, and at particles that are not INNER, where a one-sided fit has no
    boundary condition. `surface_stress.stress_free` gives surface particles one.

    radius : of the quartic weight of the fit [m]; the others as in `morris`
    """
    dim = len(cloud.axes)
    size = dim + dim * (dim + 1) // 2
    across = room_across(cloud)
    fit = Quadratics(np.empty((size, across.near.shape[1])), np.empty(across.near.shape[1]), np.empty((size, size)))
    for i in range(len(out)):
        out[i, :] = 0.0
        if cloud.kind[i] != FLUID:
            continue
        if cloud.role[i] == INNER:
            n = gather_flow(across, i, cloud, walls, flowing, False, radius)
            if _fit_laplacian(out, i, fit, across, n, radius, cloud.axes):
                continue
        _add_morris(out, i, across, cloud, walls, flowing, h)


@subkernel
def gather_flow(across: Across, i: int, cloud: Cloud, walls: Walls, flowing: Flowing, everywhere: bool,
                radius: float) -> int:
    """Write the columns of `gather_across`, with du = nu_ij (u_j - u_i) and the mean viscosity of each pair."""
    n = gather_across(across, i, cloud, walls, flowing.no_slip, everywhere, radius)
    differences(across, n, i, flowing.u)
    for k in range(n):
        mean = 0.5 * (flowing.nu[i] + flowing.nu[across.member[k]])
        for a in range(len(cloud.axes)):
            across.du[a, k] *= mean
    return n


@subkernel
def _add_morris(out, i, across, cloud, walls, flowing, h):
    """Add the pairs of `morris`."""
    dim, volume = len(cloud.axes), cloud.spacing ** len(cloud.axes)
    for k in range(gather_flow(across, i, cloud, walls, flowing, True, h)):
        q2 = 0.0
        for a in range(dim):
            q2 += across.near[a, k] ** 2
        c = -2.0 * volume * cubic_spline_slope(h * math.sqrt(q2), h, dim) * q2 / (q2 + 0.01)
        for a in range(dim):
            out[i, a] += c * across.du[a, k]


class Quadratics(NamedTuple):
    """A weighted fit of quadratics through 0 to columns.

    basis : (size, columns), X_a, then STRETCH X_a X_b in the order 00, 10, 11, 20, 21, 22; weight : (columns,)
    work : (size, size), the factor of M = sum_k w_k b_k b_k^T
    """

    basis: np.ndarray
    weight: np.ndarray
    work: np.ndarray


@subkernel
def factor_quadratics(fit: Quadratics, near: np.ndarray, n: int, axes: tuple[int, ...]) -> bool:
    """Write basis, weight and factor for n columns near (dim, columns), in units of the radius; False if degenerate."""
    size = len(fit.work)
    for k in range(n):
        _fill_basis(fit, near, k, axes)
    for r in range(size):
        for c in range(r + 1):
            total = 0.0
            for k in range(n):
                total += fit.weight[k] * fit.basis[r, k] * fit.basis[c, k]
            fit.work[r, c] = total
    return n >= size and cholesky(fit.work, size)


@subkernel
def _fit_laplacian(out, i, fit, across, n, radius, axes):
    """Add the Laplacian of the weighted quadratic fit through 0 at i; False, with nothing added, if M is degenerate.

    The fit has the coefficients M^-1 sum_j w_j b_j du_j, and the Laplacian is twice the sum of those of the squares:
    one system M y = pick gives the coefficients w_j b_j . y of all components.
    """
    dim, size = len(axes), len(fit.work)
    if not factor_quadratics(fit, across.near, n, axes):
        return False
    pick = np.zeros(size)
    row = dim
    for a in range(dim):
        row += a
        pick[row] = 2.0 * STRETCH / radius**2
        row += 1
    cholesky_solve(fit.work, pick, size)
    for k in range(n):
        c = 0.0
        for r in range(size):
            c += pick[r] * fit.basis[r, k]
        for a in range(dim):
            out[i, a] += fit.weight[k] * c * across.du[a, k]
    return True


@inlined
def _fill_basis(fit, near, k, axes):
    row, q2 = len(axes), 0.0
    for a in range(len(axes)):
        q2 += near[a, k] ** 2
        fit.basis[a, k] = near[a, k]
        for b in range(a + 1):
            fit.basis[row, k] = STRETCH * near[a, k] * near[b, k]
            row += 1
    fit.weight[k] = quartic_weight(q2, 1.0)


@kernel
def continue_to_walls(a: np.ndarray, cloud: Cloud, radius: float) -> None:
    """Extrapolate the normal part of an acceleration from the fluid to the walls, for n . (nu lap u) of Eq. 25.

    (Zheng, Ma & Duan 2014.) A wall takes the value at y = 0 of a linear fit over the distance y from it, with
    radius^2/10 added to the variance of y, as in `gradient.wall_velocity`. Corners, and walls without fluid within the
    radius, get zero.

    a : (n_all, dim) [m/s^2], of fluid given, rows of owned walls are written
    """
    dim, radius2, x, normal = len(cloud.axes), radius * radius, cloud.x, cloud.normal
    for i in range(len(cloud.indptr) - 1):
        if cloud.kind[i] != WALL:
            continue
        a[i, :] = 0.0
        if cloud.corner[i]:
            continue
        s0, s1, s2, v0, v1 = 0.0, 0.0, 0.0, 0.0, 0.0
        for k in range(cloud.indptr[i], cloud.indptr[i + 1]):
            j = cloud.indices[k]
            if cloud.kind[j] != FLUID:
                continue
            r2, y, value = 0.0, 0.0, 0.0
            for c in range(dim):
                d = x[j, c] - x[i, c]
                r2, y, value = r2 + d * d, y + d * normal[i, c], value + a[j, c] * normal[i, c]
            w = quartic_weight(r2, radius2)
            s0, s1, s2 = s0 + w, s1 + w * y, s2 + w * y * y
            v0, v1 = v0 + w * value, v1 + w * y * value
        if s0 > 0.0:
            mean = s1 / s0
            variance = s2 / s0 - mean * mean + ACROSS * radius2
            at_wall = v0 / s0 - mean * (v1 - mean * v0) / (s0 * variance)
            for c in range(dim):
                a[i, c] = at_wall * normal[i, c]
