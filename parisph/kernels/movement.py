"""Changes of what fluid has and walls do not."""

import numpy as np

from parisph.base.fields import FLUID
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
