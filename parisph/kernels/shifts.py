"""The shifts of particles in the literature, other than the Fick shift of `shifting`.

`shifting.fick_shift` is that of Lind et al. (2012) with D = C h^2, without their tensile term, and with beta = 0
near a free surface, on which particles stay. Walls and mirror images count as neighbours in all shifts, so that
a lattice in a tank is not shifted.
"""

import math

import numpy as np

from parisph.base.fields import FLUID, INNER, SURFACE, WET
from parisph.kernels.jit import inlined, kernel
from parisph.kernels.mirrors import gather_around
from parisph.kernels.near import room_for
from parisph.kernels.shifting import limit_length
from parisph.kernels.smoothing import cubic_spline, cubic_spline_slope, quartic_weight

TENSILE, POWER = 0.2, 4     # R and n of the tensile term (Monaghan 2000; Lind et al. 2012, Eq. 27)
CLOSEST = 1e-3              # of the radius: nearer neighbours count as if they were so far away


@kernel
def xu_shift(shift: np.ndarray, x: np.ndarray, kind: np.ndarray, corner: np.ndarray, normal: np.ndarray,
             role: np.ndarray, radius: float, strength: np.ndarray, cap: float, indptr: np.ndarray, indices: np.ndarray,
             axes: tuple[int, ...]) -> None:
    """Shift of Xu, Stansby & Laurence (2009, Eqs. 25 and 26), for fluid without a free surface.

    dr_i = strength sum_j (mean_i/r_ij)^2 n_ij, mean_i = sum_j r_ij/N_i, with n_ij from j to i, and strength = C U dt,
    in which C is 0.01 to 0.1 and U the largest speed. |dr| <= cap.

    shift : (n_owned, dim) output [m]; zero for all that is not INNER
    x, normal : (n_all, dim); kind, corner, role : (n_all,); radius : of the neighbours that count [m]
    strength : (n_owned,) [m]; cap : [m]
    """
    dim = len(axes)
    member, image, walls = np.empty(dim, np.int64), np.empty(dim), np.empty(room_for(indptr), np.int32)
    near = np.empty((dim, room_for(indptr) * 2**dim))
    for i in range(len(indptr) - 1):
        shift[i, :] = 0.0
        if kind[i] != FLUID or role[i] != INNER:
            continue
        m = gather_around(near, walls, member, image, i, x, kind, corner, normal, radius, indptr, indices, axes)
        total, count = 0.0, 0
        for k in range(m):
            r2 = _square(near, k, axes)
            if 0.0 < r2 < 1.0:
                q = max(math.sqrt(r2), CLOSEST)
                total += q
                count += 1
                for a in range(dim):
                    shift[i, a] -= near[a, k] / q**3
        if count:
            for a in range(dim):
                shift[i, a] *= strength[i] * (total / count) ** 2
        limit_length(shift, i, cap, axes)


@kernel
def tensile_gradient(out: np.ndarray, x: np.ndarray, kind: np.ndarray, corner: np.ndarray, normal: np.ndarray, h: float,
                     spacing: float, full: float, indptr: np.ndarray, indices: np.ndarray,
                     axes: tuple[int, ...]) -> None:
    """Concentration gradient with the term against the pairing of particles (Lind et al. 2012, Eqs. 23 and 27) [1/m].

    grad C_i = sum_j V_j (1 + 0.2 (W_ij/W(s))^4) grad_i W_ij, in place of `shifting.concentration`, in the
    same scale: without that term both are equal.

    out : (n_owned, dim) output, zero for walls; h : of the cubic spline [m]; spacing : s [m]; full : of `lattice_sum`
    """
    dim = len(axes)
    member, image, walls = np.empty(dim, np.int64), np.empty(dim), np.empty(room_for(indptr), np.int32)
    near = np.empty((dim, room_for(indptr) * 2**dim))
    at_spacing = cubic_spline(spacing, h, dim)
    for i in range(len(indptr) - 1):
        out[i, :] = 0.0
        if kind[i] != FLUID:
            continue
        m = gather_around(near, walls, member, image, i, x, kind, corner, normal, h, indptr, indices, axes)
        for k in range(m):
            r = h * math.sqrt(_square(near, k, axes))
            ratio = cubic_spline(r, h, dim) / at_spacing
            c = -h / full * cubic_spline_slope(r, h, dim) * (1.0 + TENSILE * ratio**POWER)
            for a in range(dim):
                out[i, a] += c * near[a, k]


@kernel
def surface_shift(shift: np.ndarray, gradient: np.ndarray, surface_normal: np.ndarray, close: np.ndarray,
                  role: np.ndarray, strength: np.ndarray, beta: float, level: float, cap: float,
                  axes: tuple[int, ...]) -> None:
    """Shift of Lind et al. (2012, Eqs. 24 and 25): along a free surface as inside, across it weakly.

    dr = -D (t dC/dt + beta (dC/dn - level) n) at particles of the surface and close to it, where n is the normal and
    t dC/dt the part of grad C across n; dr = -D grad C elsewhere; |dr| <= cap. beta = 0 in violent flows, 0.1 in slow
    ones; the level is dC/dn of a straight surface, so that this one is at rest.

    shift : (n_owned, dim) output [m], zero where role is not INNER or SURFACE
    gradient : (n_owned, dim), grad C [1/m]
    surface_normal : (n_owned, dim), unit vectors along grad C of the surface
    close : (n_owned,) of bool; strength : (n_owned,), D [m^2], at most h^2/2 for stability; level : [1/m]
    """
    dim = len(axes)
    for i in range(len(shift)):
        shift[i, :] = 0.0
        if role[i] != INNER and role[i] != SURFACE:
            continue
        along = 0.0
        for a in range(dim):
            along += gradient[i, a] * surface_normal[i, a]
        across = along - beta * (along - level) if close[i] else 0.0
        for a in range(dim):
            shift[i, a] = -strength[i] * (gradient[i, a] - across * surface_normal[i, a])
        limit_length(shift, i, cap, axes)


@kernel
def surface_normals(normal: np.ndarray, close: np.ndarray, gradient: np.ndarray, role: np.ndarray, x: np.ndarray,
                    kind: np.ndarray, reach: float, indptr: np.ndarray, indices: np.ndarray,
                    axes: tuple[int, ...]) -> None:
    """Direction of the surface's grad C at fluid near a free surface, for `surface_shift`.

    n_i = sum_j grad C_j/r_ij^2 over the surface particles within the reach, normalised; at a surface particle its own.

    normal : (n_owned, dim) output, unit vectors, zero where there is no surface; close : (n_owned,) output of bool
    gradient : (n_all, dim), grad C [1/m]; role, kind : (n_all,); reach : [m]
    """
    for i in range(len(indptr) - 1):
        normal[i, :] = 0.0
        close[i] = False
        if kind[i] != FLUID:
            continue
        if role[i] != INNER:
            for a in range(len(axes)):
                normal[i, a] = gradient[i, a]
        else:
            for k in range(indptr[i], indptr[i + 1]):
                _add_direction(normal, i, indices[k], gradient, role, x, kind, reach, axes)
        norm2 = _square_of(normal, i, axes)
        if norm2 > 0.0:
            close[i] = True
            for a in range(len(axes)):
                normal[i, a] /= math.sqrt(norm2)


@inlined
def _add_direction(normal, i, j, gradient, role, x, kind, reach, axes):
    if kind[j] != FLUID or role[j] == INNER:
        return
    r2 = 0.0
    for a in range(len(axes)):
        r2 += (x[j, a] - x[i, a]) ** 2
    if 0.0 < r2 < reach * reach:
        for a in range(len(axes)):
            normal[i, a] += gradient[j, a] / r2


@inlined
def _square_of(vector, i, axes):
    total = 0.0
    for a in range(len(axes)):
        total += vector[i, a] ** 2
    return total


@kernel
def pressure_shift(shift: np.ndarray, p: np.ndarray, x: np.ndarray, kind: np.ndarray, corner: np.ndarray,
                   normal: np.ndarray, role: np.ndarray, radius: float, strength: float, cap: float, indptr: np.ndarray,
                   indices: np.ndarray, axes: tuple[int, ...]) -> None:
    """Shift by the pressure gradient relative to a minimum pressure, after Sriram & Ma (2012).

    Zheng, Ma & Duan (2014, Sec. 2.2) describe it in words: particles move with a velocity from pressure gradients
    relative to the least pressure around each. With the gradient of Koshizuka & Oka (1996),
    d sum_j w_ij (p_j - p_min) r_ji/r_ij^2 / sum_j w_ij, the excess over the gradient with p_j - p_i is the shift:

    dr_i = -strength d/N_i (p_i - p_min) sum_j w_ij (r_j - r_i)/r_ij^2, strength = dt^2/(2 rho), |dr| <= cap

    It pushes particles apart, the more the higher their pressure is, and does nothing on a lattice. p_min is the least
    pressure of i and its neighbours; a constant added to p has no effect.

    shift : (n_owned, dim) output [m]; zero for all that is not INNER
    p : (n_all,) [Pa], of walls too; radius : of the quartic weight w [m]; strength : [m^3 s^2/kg]
    """
    dim = len(axes)
    member, image, walls = np.empty(dim, np.int64), np.empty(dim), np.empty(room_for(indptr), np.int32)
    near = np.empty((dim, room_for(indptr) * 2**dim))
    for i in range(len(indptr) - 1):
        shift[i, :] = 0.0
        if kind[i] != FLUID or role[i] != INNER:
            continue
        least = p[i]
        for k in range(indptr[i], indptr[i + 1]):
            r2 = 0.0
            for a in range(dim):
                r2 += (x[indices[k], a] - x[i, a]) ** 2
            if r2 < radius * radius and role[indices[k]] <= WET:
                least = min(least, p[indices[k]])
        m = gather_around(near, walls, member, image, i, x, kind, corner, normal, radius, indptr, indices, axes)
        weights = 0.0
        for k in range(m):
            r2 = _square(near, k, axes)
            w = quartic_weight(r2, 1.0) if r2 > 0.0 else 0.0
            weights += w
            for a in range(dim):
                shift[i, a] -= w * near[a, k] / max(r2, CLOSEST**2)
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
