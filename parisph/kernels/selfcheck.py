"""A check that the compiler translates kernels correctly."""

import numpy as np

from parisph.base.fields import FLUID, INNER, SURFACE, WALL, WET
from parisph.kernels.jit import kernel

LENGTH = 203    # several passes of the widest vector loop and a remainder


@kernel
def _mark(role, kind, alpha, limit):
    for i in range(len(role)):
        if kind[i] == FLUID:
            role[i] = SURFACE if alpha[i] < limit else INNER


def stores_hold() -> bool:
    """Return whether conditional stores change only the selected values. Not collective.

    Compilers are known to get such stores wrong (see `kernels.processor`), and the resulting flow looks plausible.
    """
    index = np.arange(LENGTH)
    kind = np.where(index * index % 7 < 3, FLUID, WALL).astype(np.int8)
    alpha = (index * 37 % 101) / 100.0
    role = np.full(LENGTH, WET, dtype=np.int8)
    _mark(role, kind, alpha, 0.5)
    return bool(np.array_equal(role, np.where(kind == FLUID, np.where(alpha < 0.5, SURFACE, INNER), WET)))
