"""The errors that parisph raises, and how all ranks raise the same one."""

from typing import TYPE_CHECKING

from parisph.base.communicator import Communicator

if TYPE_CHECKING:    # numpy must not be loaded before base.environment has prepared for it
    from parisph.base.arrays import Floats


class ParisphError(Exception):
    """Base class of all errors that parisph raises itself."""


class CaseError(ParisphError):
    """The case, or an option of the command line, cannot be run as written."""


class SolverDiverged(ParisphError):
    """The pressure equation could not be solved by any method of the fallback chain."""


class ParticleLost(ParisphError):
    """A particle has left the domain, or its position or velocity is not finite."""


class StoreError(ParisphError):
    """A file cannot be read or written, is damaged, or is not one that parisph wrote."""


class MissingLibrary(ParisphError, ImportError):
    """An optional library is needed here and cannot be imported."""


class BadEnvironment(ParisphError):
    """This machine, or the environment of this process, does not let parisph work. The case is not at fault."""


class Interrupted(ParisphError):
    """The run was asked to stop and did so between two steps."""


# The first class that fits gives the exit code of the process.
_CODES = ((CaseError, 2), (SolverDiverged, 3), (ParticleLost, 3), (Interrupted, 4), (KeyboardInterrupt, 4),
          (StoreError, 5))


def exit_code(error: BaseException) -> int:
    """Return the exit code of a process that ends with an exception, never 0."""
    if isinstance(error, SystemExit) and isinstance(error.code, int):
        return error.code or 1
    return next((code for kind, code in _CODES if isinstance(error, kind)), 1)


def agree(comm: Communicator, error: Exception | None = None) -> None:
    """Raise on every rank if any rank has an error; return if none has. Collective.

    error : that of this rank, None without one

    Raises the error of the lowest failing rank on every rank, with its class if that is a ParisphError, else as a
    ParisphError.
    """
    if comm.size == 1:
        if error is not None:
            raise error
        return
    if not comm.allreduce(int(error is not None)):
        return
    kind = type(error) if isinstance(error, ParisphError) else ParisphError
    mine = None if error is None else (kind, f"rank {comm.rank}: {_kind(error)}{error}")
    kind, message = next(item for item in comm.allgather(mine) if item is not None)
    raise kind(message) from error


def agree_and_sum(comm: Communicator, error: Exception | None, *numbers: float) -> "Floats":
    """Return the sums (n,) of numbers over the ranks, or raise an error on all ranks as `agree`. Collective."""
    import numpy as np

    if comm.size == 1:
        agree(comm, error)
        return np.array(numbers, float)
    mine = np.array([error is not None, *numbers], float)
    sums: Floats = np.empty_like(mine)
    comm.Allreduce(mine, sums)    # one reduction of MPI; mpi4py adds objects in Python, rank after rank
    if sums[0]:
        agree(comm, error)
    return sums[1:]


def _kind(error: BaseException) -> str:
    """Return the class name of an unexpected error, whose message alone may not be clear."""
    return "" if isinstance(error, (ParisphError, OSError)) else f"{type(error).__name__}: "


def unforeseen(error: BaseException) -> bool:
    """Return whether `agree` made this error, on this rank, from an unexpected one."""
    return type(error) is ParisphError and error.__cause__ is not None and bool(_kind(error.__cause__))
