"""The traditional, weakly compressible SPH of Zheng, Ma & Duan (2014, Sec. 2.1, Eqs. 3 to 9).

Walls. The paper puts two layers of ghost particles behind a wall (its Sec. 2.4.1, after Lee et al. 2008), so that sums
over pairs are complete beside it. These kernels take them as particles of the kind WALL: the layer on the wall,
and two layers behind it at the distances s and 2 s that continue the fluid's lattice, also around corners outside
the tank. With fluid one spacing in front of the wall, support is then complete up to 3 s, and for h = 1.8 s
(support 3.6 s, the paper's) what is missing is only air. Wall particles move with the wall, their
masses are those of fluid, and `wall_pressure` gives them the pressure of the fluid before them. One layer, as
the projection methods have it, would do for neither sum.

Every kernel takes arrays of owned and ghost particles (n_all) and writes owned ones (n_owned). Kind ABSENT is left out.
"""

import math

import numpy as np

from parisph.base.fields import ABSENT, FLUID, WALL
from parisph.kernels.jit import inlined, kernel
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
    """Return the density [kg/m^3] that has the pressure p [Pa] by `linear_pressure`."""
    return density + np.asarray(p) / sound**2


def longest_step(h: float, sound: float, speed: float, omega: float, acceleration: float) -> float:
    """Return the longest stable step [s] (Monaghan 1992).

    It is the least of 0.4 h/(c0 (1 + 0.6 omega) + speed) and 0.25 sqrt(h/a).
    For water at rest, symplectic steps four times as long are stable; the rest is for impacts.

    h : [m]; speed, acceleration : the largest of the fluid [m/s, m/s^2]; omega : of the artificial viscosity
    """
    by_sound = COURANT * h / (sound * (1.0 + 0.6 * omega) + speed)
    return min(by_sound, FORCE * math.sqrt(h / acceleration)) if acceleration > 0.0 else by_sound


@kernel
def density_rate(out: np.ndarray, u: np.ndarray, x: np.ndarray, mass: np.ndarray, kind: np.ndarray, h: float,
                 indptr: np.ndarray, indices: np.ndarray, axes: tuple[int, ...]) -> None:
    """Rate of density D rho_i/Dt = sum_j m_j u_ij . grad_i W_ij of owned fluid, from Eqs. 1, 4b and 7.

    Eq. 7 prints m_j/rho_i behind rho_i, which is the same.

    out : (n_owned,) output [kg/m^dim/s], zero for walls; u, x : (n_all, dim), walls with their own velocity
    mass : (n_all,) [kg, in 2D kg/m]; h : smoothing length [m] of the cubic spline with support 2 h
    """
    dim = len(axes)
    for i in range(len(indptr) - 1):
        out[i] = 0.0
        if kind[i] != FLUID:
            continue
        for k in range(indptr[i], indptr[i + 1]):
            j = indices[k]
            if kind[j] == ABSENT:
                continue
            r2, ur = _pair(i, j, u, x, axes)
            out[i] += mass[j] * ur * cubic_spline_slope(math.sqrt(r2), h, dim)


@kernel
def acceleration(out: np.ndarray, u: np.ndarray, x: np.ndarray, p: np.ndarray, rho: np.ndarray, mass: np.ndarray,
                 kind: np.ndarray, h: float, sound: float, omega: float, xi: float, indptr: np.ndarray,
                 indices: np.ndarray, axes: tuple[int, ...]) -> None:
    """Acceleration of owned fluid by pressure and artificial viscosity (Eqs. 6 and 8), without g.

    a_i = -sum_j m_j (p_i/rho_i^2 + p_j/rho_j^2 + Pi_ij) grad_i W_ij
    Pi_ij = (-omega c0 mu + xi mu^2)/rho_mean, mu = h u_ij . r_ij/(r_ij^2 + 0.01 h^2), for pairs that approach, else 0

    Walls have their part in the viscosity. The paper takes omega = 0.3 and xi = 0. Momentum is conserved between fluid
    particles.

    out : (n_owned, dim) output [m/s^2], zero for walls
    p, rho : (n_all,) [Pa, kg/m^dim], of walls from `wall_pressure`; sound : c0 [m/s]; others as in `density_rate`
    """
    dim = len(axes)
    for i in range(len(indptr) - 1):
        out[i, :] = 0.0
        if kind[i] != FLUID:
            continue
        own = p[i] / rho[i] ** 2
        for k in range(indptr[i], indptr[i + 1]):
            j = indices[k]
            if kind[j] == ABSENT:
                continue
            r2, ur = _pair(i, j, u, x, axes)
            mu = min(h * ur / (r2 + 0.01 * h * h), 0.0)
            viscous = (xi * mu - omega * sound) * mu * 2.0 / (rho[i] + rho[j])
            c = -mass[j] * (own + p[j] / rho[j] ** 2 + viscous) * cubic_spline_slope(math.sqrt(r2), h, dim)
            for a in range(dim):
                out[i, a] += c * (x[i, a] - x[j, a])


@kernel
def xsph_velocity(out: np.ndarray, u: np.ndarray, x: np.ndarray, rho: np.ndarray, mass: np.ndarray, kind: np.ndarray,
                  h: float, epsilon: float, indptr: np.ndarray, indices: np.ndarray, axes: tuple[int, ...]) -> None:
    """Velocity with which owned fluid moves, u_i - epsilon sum_j m_j/rho_mean u_ij W_ij over fluid (Eq. 9).

    Eq. 9 prints rho_i. The mean of both densities, from which it differs by less than the fluid is compressed,
    conserves momentum (Monaghan 1989). The paper takes epsilon = 0.01.

    out : (n_owned, dim) output [m/s], of walls their own velocity; the others as in `acceleration`
    """
    dim = len(axes)
    for i in range(len(indptr) - 1):
        for a in range(dim):
            out[i, a] = u[i, a]
        if kind[i] != FLUID:
            continue
        for k in range(indptr[i], indptr[i + 1]):
            j = indices[k]
            if kind[j] != FLUID:
                continue
            r2, _ = _pair(i, j, u, x, axes)
            c = epsilon * mass[j] * 2.0 / (rho[i] + rho[j]) * cubic_spline(math.sqrt(r2), h, dim)
            for a in range(dim):
                out[i, a] -= c * (u[i, a] - u[j, a])


@kernel
def wall_pressure(out: np.ndarray, x: np.ndarray, p: np.ndarray, rho: np.ndarray, force: np.ndarray,
                  wall_force: np.ndarray, kind: np.ndarray, h: float, indptr: np.ndarray, indices: np.ndarray,
                  axes: tuple[int, ...]) -> None:
    """Pressure of owned wall and ghost particles, continued from the fluid (Adami, Hu & Adams 2012, Eq. 27).

    p_w = sum_j (p_j + rho_j (g - a_w) . r_wj) W_wj / sum_j W_wj over fluid j, with r_wj from j to w: exact at rest.
    Nothing pulls at a wall, so p_w is at least 0; it is 0 where no fluid is near. The density of walls follows from the
    equation of state.

    out : (n_owned,) output [Pa]; of fluid it is not changed
    force : (n_all, dim), body force g on fluid; wall_force : (n_owned, dim), acceleration a_w of walls [m/s^2]
    """
    dim = len(axes)
    for i in range(len(indptr) - 1):
        if kind[i] != WALL:
            continue
        total, weights = 0.0, 0.0
        for k in range(indptr[i], indptr[i + 1]):
            j = indices[k]
            if kind[j] != FLUID:
                continue
            r2, push = 0.0, 0.0
            for a in range(dim):
                r2 += (x[i, a] - x[j, a]) ** 2
                push += (force[j, a] - wall_force[i, a]) * (x[i, a] - x[j, a])
            w = cubic_spline(math.sqrt(r2), h, dim)
            total += w * (p[j] + rho[j] * push)
            weights += w
        out[i] = max(total / weights, 0.0) if weights > 0.0 else 0.0


@kernel
def position_divergence(out: np.ndarray, x: np.ndarray, volume: float, kind: np.ndarray, h: float, indptr: np.ndarray,
                        indices: np.ndarray, axes: tuple[int, ...]) -> None:
    """Divergence of the positions, sum_j V r_ji . grad_i W_ij over all neighbours: dim inside, less at the surface.

    Lee et al. (2008) take 1.5 for the limit in 2D. out : (n_owned,) output, 0 for walls; volume : of a particle [m^dim]
    """
    for i in range(len(indptr) - 1):
        out[i] = 0.0
        if kind[i] != FLUID:
            continue
        for k in range(indptr[i], indptr[i + 1]):
            j = indices[k]
            if kind[j] == ABSENT:
                continue
            r2 = 0.0
            for a in range(len(axes)):
                r2 += (x[i, a] - x[j, a]) ** 2
            out[i] -= volume * r2 * cubic_spline_slope(math.sqrt(r2), h, len(axes))


@inlined
def _pair(i, j, u, x, axes):
    """Return r_ij^2 and u_ij . r_ij."""
    r2, ur = 0.0, 0.0
    for a in range(len(axes)):
        d = x[i, a] - x[j, a]
        r2 += d * d
        ur += (u[i, a] - u[j, a]) * d
    return r2, ur
