"""The least distance of two fluid particles."""

import math

import numpy as np

from parisph.base.fields import FLUID
from parisph.kernels.jit import kernel


@kernel
def least_distance(x: np.ndarray, kind: np.ndarray, indptr: np.ndarray, indices: np.ndarray,
                   axes: tuple[int, ...]) -> float:
    """Return the least distance [m] of an owned fluid particle from another one in its list, infinite without one.

    x : (n_all, dim) [m], of ghosts too; kind : (n_all,)
    """
    least = math.inf
    for i in range(len(indptr) - 1):
        if kind[i] != FLUID:
            continue
        for k in range(indptr[i], indptr[i + 1]):
            j = indices[k]
            if kind[j] == FLUID and j != i:
                r2 = 0.0
                for a in range(len(axes)):
                    r2 += (x[j, a] - x[i, a]) ** 2
                least = min(least, r2)
    return math.sqrt(least)
