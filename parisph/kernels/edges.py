"""Edges between walls in 3D: their direction, as seen from the nodes on them."""

import math

import numpy as np

from parisph.base.fields import WALL
from parisph.kernels.jit import subkernel
from parisph.kernels.moments import pair_weight
from parisph.kernels.records import Cloud

NEXT = 1.6      # tuned 1.2 to 2.4: spacings from a node to others that show the direction of its edge; judged
ACROSS = 0.3    # tuned 0.15 to 0.5: cosine of the normal to what is still along an edge, not at its end; judged


@subkernel
def edge_direction(along: np.ndarray, i: int, cloud: Cloud) -> bool:
    """Write the unit vector along the edge on which node i lies, in either direction; return whether there is one (3D).

    It points to the next nodes on the edge. The own normal is between those of the two walls, and so across the edge.
    In a corner, where three walls meet, it is across none of their edges, and there is no direction.

    along : (3,) output
    """
    found = 0.0
    along[:] = 0.0
    for k in range(cloud.indptr[i], cloud.indptr[i + 1]):
        j = cloud.indices[k]
        if cloud.kind[j] != WALL or not cloud.corner[j]:
            continue
        w, r2 = pair_weight(i, j, cloud.x, (NEXT * cloud.spacing) ** 2, 0, cloud.axes)
        away, side = 0.0, 0.0
        for a in range(len(cloud.axes)):
            d = cloud.x[j, a] - cloud.x[i, a]
            away += d * cloud.normal[i, a]
            side += d * (1.0 + 0.4142 * a + 0.2361 * a * a)    # any vector across no common edge
        if abs(away) < ACROSS * math.sqrt(r2):
            for a in range(len(cloud.axes)):
                along[a] += math.copysign(w, side) * (cloud.x[j, a] - cloud.x[i, a])
    for a in range(len(cloud.axes)):
        found += along[a] ** 2
    if found == 0.0:
        return False
    for a in range(len(cloud.axes)):
        along[a] /= math.sqrt(found)
    return True
