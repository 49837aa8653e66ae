"""Types of arrays for annotations: numpy's own name alone does not say of what. Docstrings give the shapes."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]    # of any type, and of records
Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Flags = NDArray[np.bool_]


def sizes(vectors: Floats) -> Floats:
    """Return the length of each of some vectors (n, dim): (n,).

    As np.linalg.norm along the last axis, which takes several times as long for vectors of two or three components.
    """
    total = np.square(vectors[:, 0])
    for axis in range(1, vectors.shape[1]):
        total += np.square(vectors[:, axis])
    lengths: Floats = np.sqrt(total, out=total)
    return lengths
