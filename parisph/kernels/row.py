"""Common form of the pressure rows of inner particles, and operations on matrix rows."""

import math

import numpy as np

from parisph.base.fields import INNER
from parisph.kernels.jit import inlined, kernel
from parisph.kernels.rankine import UNSOUND, keep_within
from parisph.kernels.records import Cloud, Rows
from parisph.kernels.roles import outside


@inlined
def finish_row(rows: Rows, i: int, first: int, n: int, scale: float, sound: bool) -> None:
    """Scale a row to a unit diagonal, from the coefficients of its Laplacian.

    lap p_i = scale sum_k values[first + k] (p_k - p_i) over n neighbours becomes row_i(p) = p_i - sum_k values p_k with
    row_i(p) = -measure lap p. A row that is not sound, or that extrapolates from neighbours on one side (a value less
    than -UNSOUND times the sum), is dropped: it has no entries, and measure 0.

    scale : [1/m^2]
    """
    values, total, lowest = rows.values, 0.0, 0.0
    for k in range(first, first + n):
        total += values[k]
        lowest = min(lowest, values[k])
    if sound and total > 0.0 and lowest >= -UNSOUND * total:
        rows.count[i], rows.measure[i] = n, 1.0 / (scale * total)
        for k in range(first, first + n):
            values[k] /= total
    else:
        rows.count[i], rows.measure[i] = 0, 0.0


@kernel
def mean_rows(rows: Rows, cloud: Cloud, reach: float) -> None:
    """Give inner particles whose row was dropped the mean of their neighbours, as `rankine.rankine_rows` does.

    A row without entries would fix p = 0 in the middle of a closed tank. The measure stays 0 and marks such rows.

    reach : of the neighbours of the mean [m] (`rankine.keep_within`)
    """
    count, columns, values, measure = rows
    role, indptr, indices = cloud.role, cloud.indptr, cloud.indices
    for i in range(len(indptr) - 1):
        if role[i] != INNER or count[i] > 0:
            continue
        n, first = 0, indptr[i]
        for k in range(first, indptr[i + 1]):
            columns[first + n] = indices[k]
            n += not outside(role[indices[k]])
        n = keep_within(columns, first, n, i, cloud, reach)
        for k in range(first, first + n):
            values[k] = 1.0 / n
        count[i], measure[i] = n, 0.0


@kernel
def looked_over(indptr: np.ndarray, columns: np.ndarray, values: np.ndarray) -> tuple[int, int, int, bool]:
    """Return properties of the rows of a CSR matrix, in one pass.

    These are the fewest entries of a row (all entries without rows), the lowest and the highest column (0 without
    entries), and whether all values are finite.

    indptr : (n + 1,), columns, values : (nnz,)
    """
    fewest = len(columns)
    for i in range(len(indptr) - 1):
        fewest = min(fewest, indptr[i + 1] - indptr[i])
    lowest = highest = columns[0] if len(columns) else 0
    finite = True
    for k in range(len(columns)):
        lowest, highest = min(lowest, columns[k]), max(highest, columns[k])
        finite &= abs(values[k]) < math.inf
    return fewest, lowest, highest, finite


@kernel
def sort_rows(indptr: np.ndarray, columns: np.ndarray, values: np.ndarray) -> None:
    """Sort the entries of each row of a CSR matrix by column, in place; a row has each column once at most.

    Most rows are in order already. In others, the position of an entry is the number of smaller columns in its row: for
    short rows, vectorised counting is faster than insertion.
    """
    longest = 0
    for i in range(len(indptr) - 1):
        longest = max(longest, indptr[i + 1] - indptr[i])
    column, value = np.empty(longest, columns.dtype), np.empty(longest)
    for i in range(len(indptr) - 1):
        first, n = indptr[i], indptr[i + 1] - indptr[i]
        ordered = True
        for k in range(first, first + n - 1):
            ordered &= columns[k] < columns[k + 1]
        if ordered:
            continue
        for k in range(n):
            column[k], value[k] = columns[first + k], values[first + k]
        for k in range(n):
            own, place = column[k], np.int32(0)
            for j in range(n):
                place += np.int32(column[j] < own)
            columns[first + place], values[first + place] = own, value[k]


@kernel
def split_rows(indptr: np.ndarray, columns: np.ndarray, values: np.ndarray, first: int,
               last: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return two CSR matrices (indptr, columns, values): columns `first` to `last`, renumbered from 0, and all others.

    Sorted rows stay sorted. The first matrix, which has most entries, is stored in the arguments to save memory.
    """
    n = len(indptr) - 1
    own_ptr, other_ptr = np.zeros(n + 1, indptr.dtype), np.zeros(n + 1, indptr.dtype)
    for i in range(n):
        own = 0
        for k in range(indptr[i], indptr[i + 1]):
            own += first <= columns[k] < last
        own_ptr[i + 1] = own_ptr[i] + own
        other_ptr[i + 1] = other_ptr[i] + indptr[i + 1] - indptr[i] - own
    other_columns, other_values = np.empty(other_ptr[n], columns.dtype), np.empty(other_ptr[n])
    own, other = 0, 0
    for k in range(indptr[n]):
        if first <= columns[k] < last:
            columns[own], values[own] = columns[k] - first, values[k]
            own += 1
        else:
            other_columns[other], other_values[other] = columns[k], values[k]
            other += 1
    return own_ptr, columns[:own], values[:own], other_ptr, other_columns, other_values
