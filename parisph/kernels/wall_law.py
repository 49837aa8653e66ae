"""Friction on free-slip walls, by laws of the wall for turbulent flow, in any dimension."""

import math
from typing import NamedTuple

import numpy as np

from parisph.base.fields import FLUID
from parisph.kernels.elements import element_normal
from parisph.kernels.jit import inlined, kernel, subkernel
from parisph.kernels.nearest_walls import nearest_walls, three_places
from parisph.kernels.records import Cloud, Walls

FACTOR, POWER = 8.3, 1.0 / 7.0    # u+ = 8.3 y+^(1/7)
KARMAN, ROUGH = 0.41, 8.5         # u+ = ln(y/k)/.41 + 8.5
# Friction falls from NEAR to FAR: on average one layer of disordered particles feels it, without pulses as particles
# come and go.
NEAR = 1.0        # tuned 0.5 to 1.5: spacings from a wall with full friction; judged
FAR = 1.5         # tuned 1 to 3: spacings from a wall without friction; judged
CURVED = 0.97     # tuned 0.485 to 1: cosine to an element above which a convex edge belongs to a curved wall; judged
CLOSEST = 0.1     # tuned 0.05 to 0.2: least distance from a wall in the law, in spacings; judged


@inlined
def wall_stress(speed: float, y: float, viscosity: float, roughness: float) -> float:
    """Return the stress over density [m^2/s^2] for a speed [m/s] along a wall at a distance y [m] > 0.

    Smooth: the larger of u+ = y+ and 8.3 y+^(1/7) (they meet at y+ = 11.8; Werner & Wengle 1993). Rough: u+ =
    ln(y/k)/.41 + 8.5 (Nikuradse 1933), if its stress is larger. viscosity [m^2/s]; roughness : k [m]
    """
    found = 0.0
    if viscosity > 0.0:
        turbulent = (speed / FACTOR * (viscosity / y) ** POWER) ** (2.0 / (1.0 + POWER))
        found = max(viscosity * speed / y, turbulent)
    if roughness > 0.0:
        rough = speed / (math.log(max(y / roughness, 1.0)) / KARMAN + ROUGH)
        found = max(found, rough * rough)
    return found


class Law(NamedTuple):
    """A law of the wall: viscosity [m^2/s], roughness [m], and the step [s], for implicit friction."""

    viscosity: float
    roughness: float
    dt: float


@kernel
def rub(out: np.ndarray, cloud: Cloud, walls: Walls, u: np.ndarray, law: Law) -> None:
    """Add the friction of free-slip walls to out (n_owned, dim) [m/s^2].

    The force on a particle is the stress times s^(dim-1), independent of its volume: a layer of particles gets the
    friction of the wall below it. Fluid ahead of a convex edge has no wall below it, and no friction.
    """
    axes = cloud.axes
    away, member, places = np.empty((len(axes), len(axes) + 1)), np.empty(len(axes), np.int64), three_places(axes)
    n = places[2]
    for i in range(len(out)):
        if cloud.kind[i] != FLUID or walls.indptr[i] == walls.indptr[i + 1]:
            continue
        for w in range(nearest_walls(away, member, places, i, cloud, walls, math.inf)):
            element_normal(n, member[w], walls.corners, axes)
            cosine = 0.0
            for a in range(len(axes)):
                cosine += n[a] * away[w, a]
            if cosine > CURVED and not walls.sticks[member[w]]:
                _rub(out, i, away[w], walls.velocity[member[w]], u[i], cloud, law)


@subkernel
def _rub(out, i, away, wall_u, u, cloud, law):
    """Add the friction of one wall; away : (dim + 1,), its normal and distance; u, wall_u : (dim,)."""
    dim, through, speed2, y = len(cloud.axes), 0.0, 0.0, away[-1]
    for a in range(dim):
        through += (u[a] - wall_u[a]) * away[a]
    for a in range(dim):
        speed2 += (u[a] - wall_u[a] - through * away[a]) ** 2
    if not (speed2 > 0.0 and y < FAR * cloud.spacing):
        return
    share = min((FAR - y / cloud.spacing) / (FAR - NEAR), 1.0)
    speed, area = math.sqrt(speed2), cloud.spacing ** (dim - 1)
    stress = wall_stress(speed, max(y, CLOSEST * cloud.spacing), law.viscosity, law.roughness)
    rate = share * stress / speed * area / cloud.volume[i]
    rate /= 1.0 + law.dt * rate    # implicit, so that a step cannot reverse the velocity
    for a in range(dim):
        out[i, a] -= rate * (u[a] - wall_u[a] - through * away[a])
