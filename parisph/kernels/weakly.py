"""Traditional, weakly compressible SPH of Zheng, Ma & Duan (2014, Sec. 2.1, Eqs. 3 to 9).

The paper puts two layers of ghost particles behind a wall (its Sec. 2.4.1, after Lee et al. 2008), which complete sums
over pairs beside it. Here the particles on the wall count, with the mass of fluid and the pressure from
`wall_pressure`, and behind them reflections in the wall (kernels.across): with fluid one spacing in front of the wall,
they continue its lattice. A reflection has the pressure of still fluid at its place.
"""

import math
from typing import NamedTuple

import numpy as np

from parisph.base.fields import FLUID, WALL
from parisph.kernels.across import differences, gather_across, room_across
from parisph.kernels.jit import inlined, kernel
from parisph.kernels.records import Cloud, Walls
from parisph.kernels.smoothing import cubic_spline, cubic_spline_slope

KAPPA = 7.0                    # exponent of the equation of state for water
COURANT, FORCE = 0.4, 0.25     # fractions of the times h/c and sqrt(h/a) (Monaghan 1992)


def tait_pressure(rho: np.ndarray, sound: float, density: float) -> np.ndarray:
    """Return p = c0^2 rho0/7 ((rho/rho0)^7 - 1) [Pa] (Eq. 3, first form). sound : c0 [m/s]; density : rho0 [kg/m^3]."""
    return sound**2 * density / KAPPA * ((np.asarray(rho) / density) ** KAPPA - 1.0)


def tait_density(p: np.ndarray, sound: float, density: float) -> np.ndarray:
    """Return the density [kg/m^3] of the pressure p [Pa] by `tait_pressure`, at least that of p = -0.9 c0^2 rho0/7."""
    ratio = 1.0 + KAPPA * np.asarray(p) / (sound**2 * density)
    return density * np.maximum(ratio, 0.1) ** (1.0 / KAPPA)


def linear_pressure(rho: np.ndarray, sound: float, density: float) -> np.ndarray:
    """Return p = c0^2 (rho - rho0) [Pa] (Eq. 3, second form)."""
    return sound**2 * (np.asarray(rho) - density)


def linear_density(p: np.ndarray, sound: float, density: float) -> np.ndarray:
    """Return the density [kg/m^3] of the pressure p [Pa] by `linear_pressure`."""
    return density + np.asarray(p) / sound**2


def longest_step(h: float, sound: float, speed: float, omega: float, acceleration: float) -> float:
    """Return the longest stable step [s] (Monaghan 1992), min(0.4 h/(c0 (1 + 0.6 omega) + speed), 0.25 sqrt(h/a)).

    For water at rest, symplectic steps four times as long are stable; the margin is for impacts.

    h : [m]; speed, acceleration : the largest of the fluid [m/s, m/s^2]; omega : of the artificial viscosity
    """
    by_sound = COURANT * h / (sound * (1.0 + 0.6 * omega) + speed)
    return min(by_sound, FORCE * math.sqrt(h / acceleration)) if acceleration > 0.0 else by_sound


class State(NamedTuple):
    """Fields of weakly compressible fluid, of owned and ghost particles.

    u : (n_all, dim) [m/s], of walls their own; p, rho : (n_all,) [Pa, kg/m^dim], of walls from `wall_pressure`
    force : (n_all, dim), the body force per unit mass [m/s^2]
    mass : of all particles [kg, in 2D kg/m]; h : smoothing length [m] of the cubic spline with support 2 h
    """

    u: np.ndarray
    p: np.ndarray
    rho: np.ndarray
    force: np.ndarray
    mass: float
    h: float


@kernel
def density_rate(out: np.ndarray, cloud: Cloud, walls: Walls, state: State) -> None:
    """Write the rate of density D rho_i/Dt = sum_j m_j u_ij . grad_i W_ij of owned fluid, from Eqs. 1, 4b and 7.

    Eq. 7 prints m_j/rho_i after rho_i, which is the same.

    out : (n_owned,) output [kg/m^dim/s], zero for walls
    """
    across, axes, h = room_across(cloud), cloud.axes, state.h
    for i in range(len(out)):
        out[i] = 0.0
        if cloud.kind[i] != FLUID:
            continue
        n = gather_across(across, i, cloud, walls, cloud.corner, True, h)
        differences(across, n, i, state.u)
        for k in range(n):
            q2, ur = _pair(across, k, h, axes)
            out[i] += state.mass * ur * cubic_spline_slope(h * math.sqrt(q2), h, len(axes))


@kernel
def acceleration(out: np.ndarray, cloud: Cloud, walls: Walls, state: State, sound: float, omega: float) -> None:
    """Write the acceleration of owned fluid by pressure and artificial viscosity (Eqs. 6 and 8), without g.

        a_i = -sum_j m_j (p_i/rho_i^2 + p_j/rho_j^2 + Pi_ij) grad_i W_ij
        Pi_ij = -omega c0 mu/rho_mean, mu = h u_ij . r_ij/(r_ij^2 + 0.01 h^2), for pairs that approach, else 0

    Walls contribute to the viscosity. The paper takes omega = 0.3. Momentum is conserved between fluid particles.

    out : (n_owned, dim) output [m/s^2], zero for walls; sound : c0 [m/s]
    """
    across, axes, h, rho = room_across(cloud), cloud.axes, state.h, state.rho
    for i in range(len(out)):
        out[i, :] = 0.0
        if cloud.kind[i] != FLUID:
            continue
        n, own = gather_across(across, i, cloud, walls, cloud.corner, True, h), state.p[i] / rho[i] ** 2
        differences(across, n, i, state.u)
        for k in range(n):
            j = across.member[k]
            q2, ur = _pair(across, k, h, axes)
            mu = min(ur / (h * (q2 + 0.01)), 0.0)
            viscous = -omega * sound * mu * 2.0 / (rho[i] + rho[j])
            other = _pressure(across, k, i, cloud, state) / rho[j] ** 2
            c = state.mass * (own + other + viscous) * cubic_spline_slope(h * math.sqrt(q2), h, len(axes))
            for a in range(len(axes)):
                out[i, a] += c * h * across.near[a, k]


@inlined
def _pressure(across, k, i, cloud, state):
    """Return the pressure of column k: of the neighbour, or of still fluid at its reflection."""
    j = across.member[k]
    if not across.planes[k]:
        return state.p[j]
    p = state.p[j]
    for a in range(len(cloud.axes)):
        p += state.rho[j] * state.force[j, a] * (cloud.x[i, a] + state.h * across.near[a, k] - cloud.x[j, a])
    return max(p, 0.0)


@inlined
def _pair(across, k, h, axes):
    """Return r_ij^2/h^2 and u_ij . r_ij of column k."""
    q2, ur = 0.0, 0.0
    for a in range(len(axes)):
        q2 += across.near[a, k] ** 2
        ur += h * across.near[a, k] * across.du[a, k]
    return q2, ur


@kernel
def xsph_velocity(out: np.ndarray, cloud: Cloud, state: State, epsilon: float) -> None:
    """Write the velocity with which owned fluid moves, u_i - epsilon sum_j m_j/rho_mean u_ij W_ij over fluid (Eq. 9).

    Eq. 9 prints rho_i. The mean of both densities conserves momentum (Monaghan 1989), and differs by less than the
    compression. The paper takes epsilon = 0.01.

    out : (n_owned, dim) output [m/s], of walls their own velocity
    """
    x, u, dim = cloud.x, state.u, len(cloud.axes)
    for i in range(len(out)):
        for a in range(dim):
            out[i, a] = u[i, a]
        if cloud.kind[i] != FLUID:
            continue
        for k in range(cloud.indptr[i], cloud.indptr[i + 1]):
            j, r2 = cloud.indices[k], 0.0
            if cloud.kind[j] != FLUID:
                continue
            for a in range(dim):
                r2 += (x[i, a] - x[j, a]) ** 2
            c = 2.0 * epsilon * state.mass / (state.rho[i] + state.rho[j])
            c *= cubic_spline(math.sqrt(r2), state.h, dim)
            for a in range(dim):
                out[i, a] -= c * (u[i, a] - u[j, a])


@kernel
def wall_pressure(out: np.ndarray, cloud: Cloud, state: State) -> None:
    """Write the pressure of owned wall particles at rest, extrapolated from the fluid (Adami, Hu & Adams 2012, Eq. 27).

    p_w = sum_j (p_j + rho_j g . r_wj) W_wj / sum_j W_wj over fluid j, with r_wj from j to w, is exact at rest. Fluid
    does not pull at walls, so p_w is at least 0; it is 0 without fluid nearby. The density of walls follows from the
    equation of state.

    out : (n_owned,) output [Pa]; unchanged for fluid
    """
    x, dim = cloud.x, len(cloud.axes)
    for i in range(len(out)):
        if cloud.kind[i] != WALL:
            continue
        total, weights = 0.0, 0.0
        for k in range(cloud.indptr[i], cloud.indptr[i + 1]):
            j, r2, push = cloud.indices[k], 0.0, 0.0
            if cloud.kind[j] != FLUID:
                continue
            for a in range(dim):
                r2 += (x[i, a] - x[j, a]) ** 2
                push += state.force[j, a] * (x[i, a] - x[j, a])
            w = cubic_spline(math.sqrt(r2), state.h, dim)
            total += w * (state.p[j] + state.rho[j] * push)
            weights += w
        out[i] = max(total / weights, 0.0) if weights > 0.0 else 0.0
