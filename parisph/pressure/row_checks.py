"""Checks of the arrays of a linear system, before any communication."""

import numpy as np

from parisph.base.errors import ParisphError, SolverDiverged


def row_fault(indptr: np.ndarray, indices: np.ndarray, values: np.ndarray, n: int, total: int) -> ParisphError | None:
    """Return the error of this rank's CSR rows, or None.

    Parameters
    ----------
    indptr : (n + 1,) int, indices : (nnz,) int, values : (nnz,) float
        CSR rows with global columns.
    n, total : int
        Rows of this rank and of all ranks.
    """
    if np.shape(indptr) != (n + 1,) or np.shape(indices) != np.shape(values) or np.ndim(values) != 1:
        return ParisphError(f"the pressure rows do not fit together: {n} right-hand sides, indptr {np.shape(indptr)}, "
                            f"indices {np.shape(indices)}, values {np.shape(values)}")
    if indptr[0] != 0 or indptr[-1] != len(values) or (n and np.diff(indptr).min() < 1):
        return ParisphError("the pressure rows are not a CSR matrix with an entry in each row")
    if len(indices) and not 0 <= indices.min() <= indices.max() < total:
        return ParisphError(f"a pressure row refers to column {indices.min()} or {indices.max()} of {total}")
    if not _finite(values):
        entry = int(np.flatnonzero(~np.isfinite(values))[0])
        row = int(np.searchsorted(indptr, entry, side="right")) - 1
        return SolverDiverged(f"the pressure matrix holds {values[entry]} in owned row {row}")
    return None


def vector_fault(name: str, vector: np.ndarray | None, n: int) -> ParisphError | None:
    """Return the error of an owned array of n numbers (None is fine), or None."""
    if vector is None:
        return None
    if np.shape(vector) != (n,):
        return ParisphError(f"the {name} of the pressure equation has shape {np.shape(vector)}, not ({n},)")
    if not _finite(vector):
        row = int(np.flatnonzero(~np.isfinite(vector))[0])
        return SolverDiverged(f"the {name} of the pressure equation holds {vector[row]} in owned row {row}")
    return None


def guess_fault(guess: np.ndarray | None, n: int) -> ParisphError | None:
    """Return the error of a guess (n,), or of several (k, n), or None (of no guess, too)."""
    faults = (vector_fault("guess", one, n) for one in (guess if np.ndim(guess) == 2 else [guess]))
    return next((fault for fault in faults if fault is not None), None)


def _finite(numbers):
    # One pass without a temporary array; the second test is needed only after an overflow.
    return bool(np.isfinite(np.dot(numbers, numbers)) or np.isfinite(numbers).all())
