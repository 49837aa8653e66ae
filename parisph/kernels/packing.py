"""Packing: fluid that fills a scene moves away from where it is crowded, until it lies evenly up to slopes.

Then each particle gets the volume of all places to which it is nearest.
"""

import math
from collections.abc import Iterable

import numpy as np

from parisph.base.fields import FLUID, INNER
from parisph.kernels.cells import nearest_points
from parisph.kernels.density import Table, completed_gradient
from parisph.kernels.jit import axes_of, kernel
from parisph.kernels.shifting import fick_shift
from parisph.kernels.solids import keep_off_solids

STEPS = 100
STRENGTH = 0.3    # h^2: of a shift
# Lengths in spacings.
CAP = 0.1         # the longest shift
GUARD = 0.5       # fluid comes no closer to a wall
LEVEL = 2.1       # as near to the surface particles move level only, so that it stays flat
FLAT = 0.5        # and not at all where it is not flat: it rises by more within that distance


def packing_move(x: np.ndarray, kind: np.ndarray, role: np.ndarray, weight: np.ndarray, area: np.ndarray,
                 corners: np.ndarray, present: np.ndarray, table: Table, indptr: np.ndarray, indices: np.ndarray,
                 element_indptr: np.ndarray, element_indices: np.ndarray) -> np.ndarray:
    """Return the move (n_owned, dim) [m] of the inner fluid x (n_all, dim) [m] in one of STEPS steps.

    It is a shift down the gradient of the completed density. Particles of other roles stay. Fluid that fills a
    lattice in front of flat walls stays, too.

    kind, role, weight : (n_all,); area : (n_all, dim); corners : (M, dim, dim) [m]; present : (M,); as for
        density.completed_density. Walls above the water should not count: elements above its level, and nodes
        more than a spacing above it. Then the surface has no gradient at the walls.
    indptr, indices; element_indptr, element_indices : neighbours of the owned particles that are visible, and their
        elements
    """
    dim, n = x.shape[1], len(indptr) - 1
    axes = axes_of(dim)
    gradient, move = np.empty((n, dim)), np.empty((n, dim))
    completed_gradient(gradient, x, kind, weight, area, corners, present, *table, element_indptr, element_indices,
                       indptr, indices, axes)
    strength = np.full(n, STRENGTH * table.h**2)
    fick_shift(move, gradient, role, x, kind, strength, CAP * table.spacing, 0.0, indptr, indices, axes)
    level_off(move, x, kind, role, LEVEL * table.spacing, FLAT * table.spacing, indptr, indices, axes)
    keep_off_solids(move, x, kind, corners, GUARD * table.spacing, element_indptr, element_indices, axes)
    return move


@kernel
def level_off(move: np.ndarray, x: np.ndarray, kind: np.ndarray, role: np.ndarray, reach: float, flat: float,
              indptr: np.ndarray, indices: np.ndarray, axes: tuple[int, ...]) -> None:
    """Take the vertical part, that along the last axis, from moves (n_owned, dim) of particles near a level surface.

    Beside a surface that is not level, as the side of a column of water, particles stay.

    reach : [m], within which a fluid particle that is not inner makes a surface; flat : [m], by which that may rise
    """
    last = len(axes) - 1
    for i in range(len(indptr) - 1):
        low, high = math.inf, -math.inf
        for k in range(indptr[i], indptr[i + 1]):
            j = indices[k]
            if kind[j] == FLUID and role[j] != INNER:
                r2 = 0.0
                for a in range(len(axes)):
                    r2 += (x[j, a] - x[i, a]) ** 2
                if r2 < reach * reach:
                    low, high = min(low, x[j, last]), max(high, x[j, last])
        if high >= low:
            move[i, last] = 0.0
        if high - low > flat:
            move[i, :] = 0.0


def volumes(x: np.ndarray, samples: Iterable[tuple[np.ndarray, np.ndarray]], spacing: float) -> np.ndarray:
    """Return the volume (n,) [m^dim] of the places that are nearest to each fluid particle x (n, dim) [m].

    samples : places (m, dim) [m] and the volumes (m,) around them, in parts (geometry.quadrature.samples). Give
        ghosts, too, and places as far as a rank's own particles are the nearest; the volumes of its own are then
        right.
    """
    found = np.zeros(len(x))
    for places, volume in samples:
        if len(places):
            found += np.bincount(nearest_points(x, places, spacing), volume, len(x))
    return found
