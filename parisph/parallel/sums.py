"""Sums of integers over the ranks, in one message."""

from typing import Any

import numpy as np


def sums(comm: Any, *numbers: int) -> list[int]:
    """Return the sums of integers over the ranks. Collective.

    One MPI call of numbers; sums of Python objects are slow. comm : mpi4py communicator
    """
    if comm.size == 1:
        return [int(number) for number in numbers]
    mine, found = np.array(numbers, np.int64), np.empty(len(numbers), np.int64)
    comm.Allreduce(mine, found)
    return [int(number) for number in found]
