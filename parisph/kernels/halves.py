"""Half cells beside walls: does any fluid represent them?

A wall particle replaces a neighbour one spacing away, so fluid beside a wall is at rest in the kernel sums one spacing
in front of it. Fluid that starts there represents the half cell at the wall as well, 3/2 cells in all. Fluid that
arrives later represents one cell, and its equilibrium is half a spacing from the wall: a wall particle would be one too
many.
"""

import math

import numpy as np

from parisph.base.fields import FLUID, WALL
from parisph.kernels.jit import inlined, kernel
from parisph.kernels.records import Cloud

# Fluid this near a wall represents the half cell there; farther away a second layer has room.
LAYER = 1.5     # tuned 0.75 to 3: spacings from a wall to the end of the first layer; judged
# For fluid compressed along the wall:
FAR_BEFORE = 2.0    # tuned 1 to 4: spacings to the end of the fluid that represents half cells; judged
PRESSED = 2.0       # tuned 1 to 4: most half cells that compressed fluid represents; judged


@inlined
def deeper(corner: int) -> float:
    """Return how much farther away the layers of fluid are from a node in a corner of 3D than in one of 2D, else 1.

    The first particle is sqrt(3) spacings away where three walls meet, and sqrt(2) where two do.
    """
    return math.sqrt(1.5) if corner else 1.0


@kernel
def wall_share(share: np.ndarray, cloud: Cloud, cells: np.ndarray, most: float, before: float) -> None:
    """Write the part of the half cells at owned wall particles that fluid in front represents, 1 for fluid.

    share_i = min(most, sum_j (1 - t_ij/s) b_j), b_j = min(1, max(0, 2 (cells_j - 1))), over the fluid within `before`
    [spacings] of the wall, in corners of 3D within `deeper` times that, with the distance t_ij < s along the wall.

    share : (n_owned,) output; cells : (n_all,), number of its cells that a particle represents
    """
    x, normal, spacing = cloud.x, cloud.normal, cloud.spacing
    for i in range(len(share)):
        share[i] = 1.0
        if cloud.kind[i] != WALL:
            continue
        total = 0.0
        for k in range(cloud.indptr[i], cloud.indptr[i + 1]):
            j = cloud.indices[k]
            if cloud.kind[j] != FLUID:
                continue
            away, r2 = 0.0, 0.0
            for a in range(len(cloud.axes)):
                away += (x[j, a] - x[i, a]) * normal[i, a]
                r2 += (x[j, a] - x[i, a]) ** 2
            along = math.sqrt(max(r2 - away * away, 0.0)) / spacing
            if len(cloud.axes) == 3:
                away /= deeper(cloud.corner[i])
            if 0.0 < away < before * spacing and along < 1.0:
                total += (1.0 - along) * min(max(2.0 * (cells[j] - 1.0), 0.0), 1.0)
        share[i] = min(total, most)
