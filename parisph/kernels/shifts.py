"""Particle shifts from the literature, other than the Fick shift of `shifting`.

`shifting.fick_shift` is that of Lind et al. (2012) with D = C h^2, without their tensile term, and with beta = 0 near a
free surface, on which particles stay. Neighbours are continued across walls in all shifts, so that a lattice in a tank
is not shifted.
"""

import math

import numpy as np

from parisph.base.fields import FLUID, INNER, SURFACE, WET
from parisph.kernels.across import gather_across, room_across
from parisph.kernels.jit import inlined, kernel
from parisph.kernels.records import Cloud, Walls
from parisph.kernels.shifting import limit_length
from parisph.kernels.smoothing import cubic_spline, cubic_spline_slope, quartic_weight

TENSILE, POWER = 0.2, 4     # R and n of the tensile term (Monaghan 2000; Lind et al. 2012, Eq. 27)
CLOSEST = 1e-3              # least distance of a neighbour, in radii


@kernel
def xu_shift(shift: np.ndarray, cloud: Cloud, walls: Walls, strength: np.ndarray, radius: float, cap: float) -> None:
    """Write the shift of Xu, Stansby & Laurence (2009, Eqs. 25 and 26), for fluid without a free surface.

    dr_i = strength sum_j (mean_i/r_ij)^2 n_ij, mean_i = sum_j r_ij/N_i, with n_ij from j to i and strength = C U dt,
    where C is 0.01 to 0.1 and U the largest speed. |dr| <= cap.

    shift : (n_owned, dim) output [m], zero except at INNER particles
    strength : (n_owned,) [m]; radius : of the neighbours that count [m]; cap : [m]
    """
    axes, across = cloud.axes, room_across(cloud)
    for i in range(len(shift)):
        shift[i, :] = 0.0
        if cloud.kind[i] != FLUID or cloud.role[i] != INNER:
            continue
        total, count = 0.0, 0
        for k in range(gather_across(across, i, cloud, walls, cloud.corner, True, radius)):
            r2 = _square(across.near, k, axes)
            if 0.0 < r2 < 1.0:
                q = max(math.sqrt(r2), CLOSEST)
                total += q
                count += 1
                for a in range(len(axes)):
                    shift[i, a] -= across.near[a, k] / q**3
        if count:
            for a in range(len(axes)):
                shift[i, a] *= strength[i] * (total / count) ** 2
        limit_length(shift, i, cap, axes)


@kernel
def tensile_gradient(out: np.ndarray, cloud: Cloud, walls: Walls, h: float, full: float) -> None:
    """Write the concentration gradient with a term against pairing (Lind et al. 2012, Eqs. 23 and 27) [1/m].

    grad C_i = sum_j V_j (1 + 0.2 (W_ij/W(s))^4) grad_i W_ij.

    out : (n_owned, dim) output, zero for walls; h : of the cubic spline [m]; full : of `surface.lattice_sum`
    """
    axes, across = cloud.axes, room_across(cloud)
    dim, at_spacing = len(axes), cubic_spline(cloud.spacing, h, len(axes))
    for i in range(len(out)):
        out[i, :] = 0.0
        if cloud.kind[i] != FLUID:
            continue
        for k in range(gather_across(across, i, cloud, walls, cloud.corner, True, h)):
            r = h * math.sqrt(_square(across.near, k, axes))
            ratio = cubic_spline(r, h, dim) / at_spacing
            c = -h / full * cubic_spline_slope(r, h, dim) * (1.0 + TENSILE * ratio**POWER)
            for a in range(dim):
                out[i, a] += c * across.near[a, k]


@kernel
def surface_shift(shift: np.ndarray, cloud: Cloud, gradient: np.ndarray, surface_normal: np.ndarray, close: np.ndarray,
                  strength: np.ndarray, cap: float) -> None:
    """Write the shift of Lind et al. (2012, Eqs. 24 and 25), without its part across a free surface.

    dr = -D t dC/dt at particles of the surface and close to it, with the part t dC/dt of grad C normal to the surface
    normal (beta = 0, for violent flows); dr = -D grad C elsewhere; |dr| <= cap.

    shift : (n_owned, dim) output [m], zero where role is not INNER or SURFACE
    gradient : (n_owned, dim), grad C [1/m]
    surface_normal : (n_owned, dim), unit vectors along grad C of the surface
    close : (n_owned,) of bool; strength : (n_owned,), D [m^2], at most h^2/2 for stability; cap : [m]
    """
    dim = len(cloud.axes)
    for i in range(len(shift)):
        shift[i, :] = 0.0
        if cloud.role[i] != INNER and cloud.role[i] != SURFACE:
            continue
        along = 0.0
        for a in range(dim):
            along += gradient[i, a] * surface_normal[i, a]
        for a in range(dim):
            shift[i, a] = -strength[i] * (gradient[i, a] - (along * surface_normal[i, a] if close[i] else 0.0))
        limit_length(shift, i, cap, cloud.axes)


@kernel
def surface_normals(normal: np.ndarray, close: np.ndarray, cloud: Cloud, gradient: np.ndarray, reach: float) -> None:
    """Write the direction of the surface's grad C at fluid near a free surface, for `surface_shift`.

    n_i = sum_j grad C_j/r_ij^2 over the surface particles within the reach, normalised; its own at a surface particle.

    normal : (n_owned, dim) output, unit vectors, zero away from surfaces; close : (n_owned,) output of bool
    gradient : (n_all, dim), grad C [1/m]; reach : [m]
    """
    axes = cloud.axes
    for i in range(len(normal)):
        normal[i, :] = 0.0
        close[i] = False
        if cloud.kind[i] != FLUID:
            continue
        if cloud.role[i] != INNER:
            for a in range(len(axes)):
                normal[i, a] = gradient[i, a]
        else:
            for k in range(cloud.indptr[i], cloud.indptr[i + 1]):
                _add_direction(normal, i, cloud.indices[k], cloud, gradient, reach)
        norm2 = _square_of(normal, i, axes)
        if norm2 > 0.0:
            close[i] = True
            for a in range(len(axes)):
                normal[i, a] /= math.sqrt(norm2)


@inlined
def _add_direction(normal, i, j, cloud, gradient, reach):
    if cloud.kind[j] != FLUID or cloud.role[j] == INNER:
        return
    r2 = 0.0
    for a in range(len(cloud.axes)):
        r2 += (cloud.x[j, a] - cloud.x[i, a]) ** 2
    if 0.0 < r2 < reach * reach:
        for a in range(len(cloud.axes)):
            normal[i, a] += gradient[j, a] / r2


@inlined
def _square_of(vector, i, axes):
    total = 0.0
    for a in range(len(axes)):
        total += vector[i, a] ** 2
    return total


@kernel
def pressure_shift(shift: np.ndarray, cloud: Cloud, walls: Walls, p: np.ndarray, strength: float, radius: float,
                   cap: float) -> None:
    """Write the shift by the pressure gradient relative to a minimum pressure, after Sriram & Ma (2012).

    Zheng, Ma & Duan (2014, Sec. 2.2) describe it in words: particles move with a velocity from pressure gradients
    relative to the least pressure around each. With the gradient of Koshizuka & Oka (1996), d sum_j w_ij (p_j - p_min)
    r_ji/r_ij^2 / sum_j w_ij, the excess over the gradient with p_j - p_i is the shift:

    dr_i = -strength d/N_i (p_i - p_min) sum_j w_ij (r_j - r_i)/r_ij^2, strength = dt^2/(2 rho), |dr| <= cap

    It pushes particles apart, in proportion to their excess pressure, and is zero on a lattice. p_min is the least
    pressure of i and its neighbours; a constant added to p has no effect.

    shift : (n_owned, dim) output [m], zero except at INNER particles
    p : (n_all,) [Pa], of walls too; radius : of the quartic weight w [m]; strength : [m^3 s^2/kg]
    """
    x, axes, across = cloud.x, cloud.axes, room_across(cloud)
    dim = len(axes)
    for i in range(len(shift)):
        shift[i, :] = 0.0
        if cloud.kind[i] != FLUID or cloud.role[i] != INNER:
            continue
        least = p[i]
        for k in range(cloud.indptr[i], cloud.indptr[i + 1]):
            j, r2 = cloud.indices[k], 0.0
            for a in range(dim):
                r2 += (x[j, a] - x[i, a]) ** 2
            if r2 < radius * radius and cloud.role[j] <= WET:
                least = min(least, p[j])
        weights = 0.0
        for k in range(gather_across(across, i, cloud, walls, cloud.corner, True, radius)):
            r2 = _square(across.near, k, axes)
            w = quartic_weight(r2, 1.0) if r2 > 0.0 else 0.0
            weights += w
            for a in range(dim):
                shift[i, a] -= w * across.near[a, k] / max(r2, CLOSEST**2)
        if weights > 0.0:
            for a in range(dim):
                shift[i, a] *= strength * dim / weights * (p[i] - least) / radius
        limit_length(shift, i, cap, axes)


@inlined
def _square(near, k, axes):
    q2 = 0.0
    for a in range(len(axes)):
        q2 += near[a, k] ** 2
    return q2
