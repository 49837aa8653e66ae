"""Random directed graphs as CSR rows, and which of their rows lead nowhere, by brute force."""

import numpy as np


def random_rows(n, mean, seed):
    """Return (indptr, indices): each row leads to itself and to `mean` others on average."""
    rng = np.random.default_rng(seed)
    columns = [np.append(i, rng.integers(0, n, rng.poisson(mean))) for i in range(n)]
    return to_csr(columns)


def to_csr(columns):
    """Return (indptr, indices) of a list of column lists."""
    indptr = np.concatenate([[0], np.cumsum([len(c) for c in columns])]).astype(np.int32)
    return indptr, np.concatenate([np.asarray(c, int) for c in columns]).astype(np.int32)


def leads_nowhere(indptr, indices, anchored):
    """Return which rows lead to no anchored row, by repeated multiplication."""
    n = anchored.size
    adjacency = np.zeros((n, n), bool)
    for i in range(n):
        adjacency[i, indices[indptr[i]:indptr[i + 1]]] = True
    reached = anchored.copy()
    for _ in range(n):
        reached |= adjacency @ reached
    return ~reached
