"""Search for the matrix rows that lead, along their entries, to a given set of rows."""

import numpy as np

from parisph.kernels.jit import kernel, subkernel

# Sweeps before a breadth-first search takes over. Two or three, forwards and backwards, suffice for rows in cell order,
# but not for a long chain in a bad order.
_SWEEPS = 4


@kernel
def spread(reached: np.ndarray, pending: np.ndarray, indptr: np.ndarray, indices: np.ndarray,
           offset: int) -> np.ndarray:
    """Mark every pending row that leads to a marked row; return those that do not.

    reached : (n,) bool, changed in place
    pending : (m,) int32, the unmarked rows to examine
    indptr, indices : (n + 1,), (nnz,) int, CSR rows; columns outside [offset, offset + n) are ignored
    offset : column of the first row
    Returns (k,) int32, the rows that stay unmarked.
    """
    pending = pending.copy()
    for sweep in range(_SWEEPS):
        before = pending.size
        pending = _sweep(reached, pending, indptr, indices, offset)
        if pending.size == before or pending.size == 0:
            return pending
        pending = pending[::-1].copy()
    return _search(reached, pending, indptr, indices, offset)


@subkernel
def _sweep(reached, pending, indptr, indices, offset):
    n = reached.size
    kept = 0
    for i in pending:
        for k in range(indptr[i], indptr[i + 1]):
            j = indices[k] - offset
            if 0 <= j < n and reached[j]:
                reached[i] = True
                break
        if not reached[i]:
            pending[kept] = i
            kept += 1
    return pending[:kept]


@subkernel
def _search(reached, pending, indptr, indices, offset):
    """Search breadth-first over the reversed entries of the pending rows, visiting each entry once."""
    n = reached.size
    start = np.zeros(n + 1, np.int32)
    for i in pending:
        for k in range(indptr[i], indptr[i + 1]):
            j = indices[k] - offset
            if 0 <= j < n:
                start[j + 1] += 1
    for j in range(n):
        start[j + 1] += start[j]
    place = start[:-1].copy()
    source = np.empty(start[n], np.int32)
    for i in pending:
        for k in range(indptr[i], indptr[i + 1]):
            j = indices[k] - offset
            if 0 <= j < n:
                source[place[j]] = i
                place[j] += 1
    queue = np.empty(n, np.int32)
    tail = 0
    for j in range(n):
        if reached[j] and start[j + 1] > start[j]:
            queue[tail] = j
            tail += 1
    head = 0
    while head < tail:
        j = queue[head]
        head += 1
        for k in range(start[j], start[j + 1]):
            i = source[k]
            if not reached[i]:
                reached[i] = True
                queue[tail] = i
                tail += 1
    kept = 0
    for i in pending:
        if not reached[i]:
            pending[kept] = i
            kept += 1
    return pending[:kept]


@kernel
def outside(pending: np.ndarray, indptr: np.ndarray, indices: np.ndarray, offset: int,
            n: int) -> tuple[np.ndarray, np.ndarray]:
    """Return (row, column) int64 of the entries of pending rows with a column outside [offset, offset + n)."""
    count = 0
    for i in pending:
        for k in range(indptr[i], indptr[i + 1]):
            count += not 0 <= indices[k] - offset < n
    rows, columns = np.empty(count, np.int64), np.empty(count, np.int64)
    m = 0
    for i in pending:
        for k in range(indptr[i], indptr[i + 1]):
            if not 0 <= indices[k] - offset < n:
                rows[m] = i
                columns[m] = indices[k]
                m += 1
    return rows, columns
