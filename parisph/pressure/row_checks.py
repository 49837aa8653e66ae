"""Checks of the arrays of a linear system, before any communication."""

import numpy as np

from parisph.base.arrays import Array, Floats
from parisph.base.errors import ParisphError, SolverDiverged
from parisph.kernels import row


def row_fault(indptr: Array, indices: Array, values: Floats, n: int, total: int) -> ParisphError | None:
    """Return the error of this rank's CSR rows, or None.

    indptr : (n + 1,) int, indices : (nnz,) int, values : (nnz,) float; with global columns
    n, total : int, rows of this rank and of all ranks
    """
    if np.shape(indptr) != (n + 1,) or np.shape(indices) != np.shape(values) or np.ndim(values) != 1:
        return ParisphError(f"the pressure rows do not fit together: {n} right-hand sides, indptr {np.shape(indptr)}, "
                            f"indices {np.shape(indices)}, values {np.shape(values)}")
    fewest, lowest, highest, finite = row.looked_over(indptr, indices, values)
    if indptr[0] != 0 or indptr[-1] != len(values) or (n and fewest < 1):
        return ParisphError("the pressure rows are not a CSR matrix with an entry in each row")
    if len(indices) and not 0 <= lowest <= highest < total:
        return ParisphError(f"a pressure row refers to column {lowest} or {highest} of {total}")
    if not finite:
        entry = int(np.flatnonzero(~np.isfinite(values))[0])
        owned = int(np.searchsorted(indptr, entry, side="right")) - 1
        return SolverDiverged(f"the pressure matrix holds {values[entry]} in owned row {owned}")
    return None


def vector_fault(name: str, vector: Floats | None, n: int) -> ParisphError | None:
    """Return the error of an owned array (n,), which may be None, or None."""
    if vector is None:
        return None
    if np.shape(vector) != (n,):
        return ParisphError(f"the {name} of the pressure equation has shape {np.shape(vector)}, not ({n},)")
    if not _finite(vector):
        owned = int(np.flatnonzero(~np.isfinite(vector))[0])
        return SolverDiverged(f"the {name} of the pressure equation holds {vector[owned]} in owned row {owned}")
    return None


def guess_fault(guess: Floats | None, n: int) -> ParisphError | None:
    """Return the error of a guess (n,) or several (k, n), which may be None, or None."""
    guesses = guess if guess is not None and np.ndim(guess) == 2 else [guess]
    faults = (vector_fault("guess", one, n) for one in guesses)
    return next((fault for fault in faults if fault is not None), None)


def _finite(numbers: Floats) -> bool:
    # One pass without a temporary array; the second test is only for overflow.
    return bool(np.isfinite(np.dot(numbers, numbers)) or np.isfinite(numbers).all())
