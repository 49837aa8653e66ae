"""Sums over the particles for the record of a step."""

import math

import numpy as np

from parisph.base.fields import BALLISTIC, FLUID, INNER, SURFACE
from parisph.kernels.jit import kernel


@kernel
def fluid_sizes(vectors: np.ndarray, kind: np.ndarray) -> tuple[float, float, float]:
    """Return the largest length of the vectors of fluid, the sum of their squares, and the number of fluid particles.

    All are 0 without fluid. The first two are NaN if a vector is.

    vectors : (n, dim); kind : (n,)
    """
    largest = total = count = 0.0
    for i in range(len(kind)):
        if kind[i] == FLUID:
            square = 0.0
            for a in range(vectors.shape[1]):
                square += vectors[i, a] ** 2
            largest = max(largest, square)
            total += square
            count += 1.0
    return (math.sqrt(largest) if total == total else total), total, count


@kernel
def step_sums(div: np.ndarray, role: np.ndarray, kind: np.ndarray,
              acceleration: np.ndarray, strained: np.ndarray) -> tuple[float, float, float, float, float, float]:
    """Return six sums for the record of a step.

    These are div^2 and the number of inner particles, the number of surface and ballistic particles,
    sqrt(acceleration), the number, and `strained` of fluid.

    div : [1/s], acceleration : [m/s^2], strained : [-], all (n,); strained may also be (0,), for a sum of 0
    """
    squares = inner = surface = roots = fluid = strain = 0.0
    for i in range(len(role)):
        if role[i] == INNER:
            squares += div[i] * div[i]
            inner += 1.0
        elif role[i] == SURFACE or role[i] == BALLISTIC:
            surface += 1.0
        if kind[i] == FLUID:
            roots += math.sqrt(acceleration[i])
            fluid += 1.0
            if len(strained) > 0:
                strain += strained[i]
    return squares, inner, surface, roots, fluid, strain
