"""Sums over the particles, for the record of a step."""

import math

import numpy as np

from parisph.base.fields import BALLISTIC, FLUID, INNER, SURFACE
from parisph.kernels.jit import kernel


@kernel
def step_sums(div: np.ndarray, role: np.ndarray, kind: np.ndarray,
              acceleration: np.ndarray) -> tuple[float, float, float, float, float]:
    """Return the sum of div^2 over inner particles, their number, that of surface and ballistic ones, the sum of
    sqrt(acceleration) over fluid, and the number of fluid particles.

    div : [1/s], acceleration : [m/s^2], all (n,)
    """
    squares = inner = surface = roots = fluid = 0.0
    for i in range(len(role)):
        if role[i] == INNER:
            squares += div[i] * div[i]
            inner += 1.0
        elif role[i] == SURFACE or role[i] == BALLISTIC:
            surface += 1.0
        if kind[i] == FLUID:
            roots += math.sqrt(acceleration[i])
            fluid += 1.0
    return squares, inner, surface, roots, fluid
