"""Extrapolations of a field in time."""

import numpy as np

from parisph.kernels.jit import kernel


@kernel
def combine(out: np.ndarray, weights: np.ndarray, first: np.ndarray, second: np.ndarray, third: np.ndarray,
            fourth: np.ndarray) -> None:
    """Write the weighted sums of four arrays (n,): out (rows, n), weights (rows, 4)."""
    for row in range(len(out)):
        for i in range(len(first)):
            out[row, i] = (weights[row, 0] * first[i] + weights[row, 1] * second[i] + weights[row, 2] * third[i]
                           + weights[row, 3] * fourth[i])
