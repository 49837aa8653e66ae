"""Packing: the fluid of a scene moves away from crowded places until it lies evenly up to slopes.

Each particle then gets the volume of all places nearest to it.
"""

import math
from collections.abc import Iterable

import numpy as np

from parisph.base.fields import FLUID, INNER
from parisph.kernels.cells import nearest_points
from parisph.kernels.density import KernelTable, completed_density
from parisph.kernels.jit import kernel
from parisph.kernels.nearest_walls import keep_off
from parisph.kernels.records import Cloud, Walls
from parisph.kernels.shifting import fick_shift

STEPS = 100       # tuned 50 to 200: steps of the packing; judged
STRENGTH = 0.3    # tuned 0.15 to 0.6: strength of a shift of the packing, in h^2; judged
# Lengths in spacings.
CAP = 0.1         # tuned 0.05 to 0.2: longest shift of the packing, in spacings; judged
GUARD = 0.5       # least distance of fluid from a wall: half a cell
LEVEL = 2.1       # tuned 1.05 to 4.2: distance from the surface within which moves are level, to keep it flat; judged
FLAT = 0.5        # tuned 0.25 to 1: rise of the surface within LEVEL above which particles rest; judged


def packing_move(cloud: Cloud, walls: Walls, weight: np.ndarray, area: np.ndarray, table: KernelTable) -> np.ndarray:
    """Return the move (n_owned, dim) [m] of the inner fluid in one of STEPS steps.

    It is a shift down the gradient of the completed density. Particles of other roles stay, and so does a lattice in
    front of flat walls.

    weight, area, table : (n_all,), (n_all, dim), as for density.completed_density. Elements above the water level, and
        nodes more than a spacing above it, should not count, so that the surface has no gradient at the walls.
    """
    n, s = len(cloud.indptr) - 1, cloud.spacing
    gradient, move = np.empty((2, n, len(cloud.axes)))
    completed_density(np.empty(n), gradient, cloud, walls, weight, area, table)
    fick_shift(move, cloud, gradient, np.full(n, STRENGTH * table.h**2), CAP * s, 0.0)
    level_off(move, cloud, LEVEL * s, FLAT * s)
    keep_off(move, cloud, walls, GUARD * s)
    return move


@kernel
def level_off(move: np.ndarray, cloud: Cloud, reach: float, flat: float) -> None:
    """Remove the vertical part, along the last axis, of moves (n_owned, dim) near a level surface; near others, all of
    it.

    reach : distance [m] to fluid that is not inner, within which the surface is near; flat : rise of a level surface
        [m]
    """
    x, dim = cloud.x, len(cloud.axes)
    for i in range(len(cloud.indptr) - 1):
        low, high = math.inf, -math.inf
        for k in range(cloud.indptr[i], cloud.indptr[i + 1]):
            j = cloud.indices[k]
            if cloud.kind[j] == FLUID and cloud.role[j] != INNER:
                r2 = 0.0
                for a in range(dim):
                    r2 += (x[j, a] - x[i, a]) ** 2
                if r2 < reach * reach:
                    low, high = min(low, x[j, dim - 1]), max(high, x[j, dim - 1])
        if high >= low:
            move[i, dim - 1] = 0.0
        if high - low > flat:
            move[i, :] = 0.0


def volumes(x: np.ndarray, samples: Iterable[tuple[np.ndarray, np.ndarray]], spacing: float) -> np.ndarray:
    """Return the volume (n,) [m^dim] of the places nearest to each fluid particle x (n, dim) [m].

    The volumes of owned particles are correct if x includes ghosts and the places cover all those nearest to owned
    particles.

    samples : chunks of places (m, dim) [m] and the volumes (m,) around them (geometry.quadrature.samples)
    """
    found = np.zeros(len(x))
    for places, volume in samples:
        if len(places):
            found += np.bincount(nearest_points(x, places, spacing), volume, len(x))
    return found
