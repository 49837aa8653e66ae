"""Friction on walls that fluid slips along, by laws of the wall for turbulent flow, in any dimension."""

import math

import numpy as np

from parisph.base.fields import FLUID
from parisph.kernels.jit import inlined, kernel
from parisph.kernels.mirrors import height, near_planes
from parisph.kernels.solids import element_normal, nearest_walls

FACTOR, POWER = 8.3, 1.0 / 7.0    # u+ = 8.3 y+^(1/7)
KARMAN, ROUGH = 0.41, 8.5         # u+ = ln(y/k)/.41 + 8.5
# Fluid up to NEAR spacings from a wall feels its friction, and less and less up to FAR: of disordered particles that is
# one layer in the mean, without pulses of those that come and go.
NEAR, FAR = 1.0, 1.5
CURVED = 0.97     # cosine of an angle between elements below which a convex edge is that of a curved wall
CLOSEST = 0.1     # spacings; what is nearer to a wall, or behind it, is taken to be as far away


@inlined
def wall_stress(speed: float, y: float, viscosity: float, roughness: float) -> float:
    """Return the stress over the density [m^2/s^2] for a speed [m/s] along a wall at a distance y [m] > 0 from it.

    Smooth: u+ = y+ or 8.3 y+^(1/7), which gives more (they meet at y+ = 11.8; Werner & Wengle 1993). Rough: u+ =
    ln(y/k)/.41 + 8.5 (Nikuradse 1933), if that gives more. viscosity [m^2/s]; roughness : k [m]
    """
    found = 0.0
    if viscosity > 0.0:
        turbulent = (speed / FACTOR * (viscosity / y) ** POWER) ** (2.0 / (1.0 + POWER))
        found = max(viscosity * speed / y, turbulent)
    if roughness > 0.0:
        rough = speed / (math.log(max(y / roughness, 1.0)) / KARMAN + ROUGH)
        found = max(found, rough * rough)
    return found


@inlined
def _rub(out, i, p, away, y, u, w, wall_u, volume, spacing, dt, viscosity, roughness, axes):
    """Add the friction of a wall at the distance y to out[i]. away[p] : its normal; wall_u[w] : its velocity."""
    dim, through, speed2 = len(axes), 0.0, 0.0
    for a in range(dim):
        through += (u[i, a] - wall_u[w, a]) * away[p, a]
    for a in range(dim):
        speed2 += (u[i, a] - wall_u[w, a] - through * away[p, a]) ** 2
    if not (speed2 > 0.0 and y < FAR * spacing):
        return
    share = min((FAR - y / spacing) / (FAR - NEAR), 1.0)
    speed, area = math.sqrt(speed2), spacing ** (dim - 1)
    rate = share * wall_stress(speed, max(y, CLOSEST * spacing), viscosity, roughness) / speed * area / volume[i]
    rate /= 1.0 + dt * rate    # a step cannot turn the velocity round
    for a in range(dim):
        out[i, a] -= rate * (u[i, a] - wall_u[w, a] - through * away[p, a])


@kernel
def rub_planes(out: np.ndarray, beside: np.ndarray, u: np.ndarray, wall_u: np.ndarray, volume: np.ndarray,
               x: np.ndarray, kind: np.ndarray, corner: np.ndarray, normal: np.ndarray, no_slip: np.ndarray,
               spacing: float, dt: float, viscosity: float, roughness: float, indptr: np.ndarray, indices: np.ndarray,
               axes: tuple[int, ...]) -> None:
    """Add the friction of a tank's walls, but of those that fluid sticks to, to out (n_owned, dim) [m/s^2].

    The force on a particle is the stress on s^(dim-1) of the wall, whatever its volume: a layer of particles gets what
    the wall below it does.

    beside : fluid with walls in its lists, and indptr, indices : of these walls, of `mirrors.beside_walls`
    wall_u : (n_all, dim), of the walls themselves
    volume : (n_all,) [m^dim]; dt : step [s], at whose end friction is taken
    """
    dim = len(axes)
    member, away = np.empty(dim, np.int64), np.empty((dim, dim))
    for i in beside:
        for p in range(near_planes(member, i, x, kind, corner, normal, indptr, indices, axes)):
            w = member[p]
            if no_slip[w]:
                continue
            for a in range(dim):
                away[p, a] = normal[w, a]
            _rub(out, i, p, away, height(i, w, x, normal, axes), u, w, wall_u, volume, spacing, dt, viscosity,
                 roughness, axes)


@kernel
def rub_elements(out: np.ndarray, u: np.ndarray, wall_u: np.ndarray, sticks: np.ndarray, volume: np.ndarray,
                 x: np.ndarray, kind: np.ndarray, corners: np.ndarray, spacing: float, dt: float, viscosity: float,
                 roughness: float, element_indptr: np.ndarray, element_indices: np.ndarray,
                 axes: tuple[int, ...]) -> None:
    """Add the friction of elements to out (n_owned, dim) [m/s^2], as `rub_planes`.

    Fluid past an edge that points into it has no wall below it, and feels none.

    wall_u : (M, dim) [m/s], of the elements; sticks : (M,) bool, those that fluid sticks to
    """
    dim = len(axes)
    away, member = np.empty((dim, dim + 1)), np.empty(dim, np.int64)
    p, foot, n = np.empty(dim), np.empty(dim), np.empty(dim)
    for i in range(len(element_indptr) - 1):
        if kind[i] != FLUID or element_indptr[i] == element_indptr[i + 1]:
            continue
        for w in range(nearest_walls(away, member, p, foot, n, i, x, corners, element_indptr, element_indices, axes)):
            e = member[w]
            element_normal(n, e, corners, axes)
            cosine = 0.0
            for a in range(dim):
                cosine += n[a] * away[w, a]
            if cosine > CURVED and not sticks[e]:
                _rub(out, i, w, away, away[w, dim], u, e, wall_u, volume, spacing, dt, viscosity, roughness, axes)
