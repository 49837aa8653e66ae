"""Changes of what fluid has and walls do not, and what a step tells of it."""

import math

import numpy as np

from parisph.base.fields import BALLISTIC, FLUID, INNER, SURFACE
from parisph.kernels.jit import kernel


@kernel
def add_to_fluid(values: np.ndarray, change: np.ndarray, kind: np.ndarray) -> None:
    """Add a change (n, dim) to the values (n, dim) of the particles that are fluid."""
    for i in range(len(values)):
        if kind[i] == FLUID:
            for a in range(values.shape[1]):
                values[i, a] += change[i, a]


@kernel
def give_to_fluid(values: np.ndarray, new: np.ndarray, kind: np.ndarray) -> None:
    """Give new values (n, dim) to the particles that are fluid."""
    for i in range(len(new)):
        if kind[i] == FLUID:
            for a in range(values.shape[1]):
                values[i, a] = new[i, a]


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
