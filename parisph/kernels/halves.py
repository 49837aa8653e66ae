"""Half cells beside walls, each counted once.

A wall particle replaces a neighbour one spacing away, so fluid beside a wall is at rest in the kernel sums one spacing
in front of it. Fluid that starts there represents the half cell at the wall as well, 3/2 cells in all. The half cell
counts at the wall as long as this fluid is beside it, and with the fluid when it has left. Fluid that arrives later
represents one cell, and its equilibrium is half a spacing from the wall.
"""

import math

import numpy as np

from parisph.base.fields import FLUID, WALL
from parisph.kernels.jit import inlined, kernel
from parisph.kernels.records import Cloud

LISTED = 2.6    # spacings that neighbour lists reach, whenever they were made (lengths.NEAR)
# Fluid this near a wall represents the half cell there; farther away a second layer has room.
LAYER = 1.5     # tuned 0.75 to 3: spacings from a wall to the end of the first layer; judged
# The first layer of water that stretches away from a wall still represents the half cells there, until another one has
# room. Dam break (H/s = 40) from a lattice: the energy rises by .27 % with 1, .15 % with .5, .10 % with .25 and .11 %
# with .125.
ROOM = 0.25     # tuned 0.125 to 1: spacings over which it takes them along; measured


@inlined
def deeper(corner: int) -> float:
    """Return how much farther away the layers of fluid are from a node in a corner of 3D than in one of 2D, else 1.

    The first particle is sqrt(3) spacings away where three walls meet, and sqrt(2) where two do.
    """
    return math.sqrt(1.5) if corner else 1.0


@inlined
def before(i: int, j: int, cloud: Cloud) -> float:
    """Return the part of wall particle i that fluid particle j is before.

    It is (1 - t/s) a, with the distance t < s along the wall. a is 1 up to LAYER in front of it, and falls to 0 one
    spacing farther, in corners of 3D at `deeper` times that. Fluid counts as far as lists reach at any time.
    """
    away, along = _place(i, j, cloud)
    if away * away + along * along > LISTED * LISTED:
        return 0.0
    if len(cloud.axes) == 3:
        away /= deeper(cloud.corner[i])
    if 0.0 < away < LAYER + 1.0 and along < 1.0:
        return (1.0 - along) * min(LAYER + 1.0 - away, 1.0)
    return 0.0


@inlined
def beside_node(i: int, j: int, cloud: Cloud, weight: float) -> float:
    """Return the part of wall particle i that fluid particle j is beside, in the first layer of a lattice.

    It is (1 - t/s) a as in `before`. With k walls at right angles through the node, whose distances have the sum
    d = sqrt(k) away, a = min(1, (k + 1 - d/s)/ROOM): 1 for the first particle of a lattice, 0 for the next ones. At
    other angles k = -log2(weight), which is 1, 2 and 3 at right ones.

    weight : of the wall particle, the part of a cell inside the fluid
    """
    away, along = _place(i, j, cloud)
    if not (away > 0.0 and along < 1.0):
        return 0.0
    walls = max(-math.log2(weight), 1.0) if cloud.corner[i] and weight > 0.0 else 1.0
    return (1.0 - along) * min(max((walls + 1.0 - math.sqrt(walls) * away) / ROOM, 0.0), 1.0)


@inlined
def _place(i, j, cloud):
    """Return the distances [spacings] of particle j from wall particle i along its normal, and across it."""
    away, r2 = 0.0, 0.0
    for a in range(len(cloud.axes)):
        away += (cloud.x[j, a] - cloud.x[i, a]) * cloud.normal[i, a]
        r2 += (cloud.x[j, a] - cloud.x[i, a]) ** 2
    return away / cloud.spacing, math.sqrt(max(r2 - away * away, 0.0)) / cloud.spacing


@kernel
def half_cells_around(found: np.ndarray, cloud: Cloud, weight: np.ndarray) -> None:
    """Write the half cells around owned fluid, over s^dim: sum_i weight_i beside_ij over wall particles; 0 for walls.

    At the start, fluid represents these (`beside_node`).

    found : (n_owned,) output; weight : (n_all,), of nodes the part of a cell inside the fluid
    """
    for j in range(len(found)):
        found[j] = _around(j, cloud, weight) if cloud.kind[j] == FLUID else 0.0


@inlined
def _around(j, cloud, weight):
    """Return the half cells around fluid particle j."""
    total = 0.0
    for k in range(cloud.indptr[j], cloud.indptr[j + 1]):
        i = cloud.indices[k]
        if cloud.kind[i] == WALL:
            total += weight[i] * beside_node(i, j, cloud, weight[i])
    return total


@kernel
def claims(share: np.ndarray, spare: np.ndarray, cloud: Cloud, beside: np.ndarray, weight: np.ndarray) -> None:
    """Write what owned fluid represents of the half cells around it, and what it carries of those that it left.

    With the half cells Q_j around a particle (`half_cells_around`), share_j = min(1, beside_j/Q_j), and spare_j =
    max(0, beside_j - Q_j). Both are 0 for walls, and for fluid that started away from walls.

    share, spare : (n_all,) outputs; beside : (n_owned,), half cells over s^dim at the start
    weight : (n_all,), of nodes the part of a cell inside the fluid
    """
    for j in range(len(cloud.indptr) - 1):
        share[j], spare[j] = 0.0, 0.0
        if cloud.kind[j] != FLUID or not beside[j] > 0.0:
            continue
        total = _around(j, cloud, weight)
        share[j] = 1.0 if total <= beside[j] else beside[j] / total
        spare[j] = max(beside[j] - total, 0.0)


@kernel
def wall_share(share: np.ndarray, cloud: Cloud, weight: np.ndarray) -> None:
    """Write the part of the half cells at owned wall particles that fluid represents: the sum of share_j beside_ij.

    Fluid pressed together along a wall represents more than one. Walls without weight count once.

    share : (n_all,), that of fluid is read (`claims`); weight : (n_all,), of nodes the part of a cell inside the fluid
    """
    for i in range(len(cloud.indptr) - 1):
        if cloud.kind[i] != WALL:
            continue
        share[i] = 1.0
        if weight[i] == 0.0:
            continue
        total = 0.0
        for k in range(cloud.indptr[i], cloud.indptr[i + 1]):
            j = cloud.indices[k]
            if cloud.kind[j] == FLUID and share[j] > 0.0:
                total += share[j] * beside_node(i, j, cloud, weight[i])
        share[i] = total
