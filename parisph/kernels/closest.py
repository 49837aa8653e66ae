"""The least distance of two fluid particles."""

import math

from parisph.base.fields import FLUID
from parisph.kernels.jit import kernel
from parisph.kernels.records import Cloud


@kernel
def least_distance(cloud: Cloud) -> float:
    """Return the least distance [m] of an owned fluid particle to another in its list, or infinity."""
    x, kind, indptr, indices = cloud.x, cloud.kind, cloud.indptr, cloud.indices
    least = math.inf
    for i in range(len(indptr) - 1):
        if kind[i] != FLUID:
            continue
        for k in range(indptr[i], indptr[i + 1]):
            j = indices[k]
            if kind[j] == FLUID and j != i:
                r2 = 0.0
                for a in range(len(cloud.axes)):
                    r2 += (x[j, a] - x[i, a]) ** 2
                least = min(least, r2)
    return math.sqrt(least)
