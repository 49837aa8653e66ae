"""The errors that parisph raises on purpose, and how ranks agree on them."""


class ParisphError(Exception):
    """Base of every error that parisph raises on purpose."""


class CaseError(ParisphError):
    """The case, or an option of the command line, cannot be run as written."""


class SolverDiverged(ParisphError):
    """The pressure equation could not be solved by any method of the fallback chain."""


class ParticleLost(ParisphError):
    """A particle has left the domain or its position or velocity is no longer a number."""


class StoreError(ParisphError):
    """A file of the run cannot be written, or is not one that parisph wrote."""


class MissingLibrary(ParisphError, ImportError):
    """A library that parisph can be installed without is needed here, and cannot be imported."""


class Interrupted(ParisphError):
    """The run was asked to stop and did so between two steps."""


def agree(comm, error=None):
    """Raise on every rank if any rank has an error; return if none has. Collective.

    Parameters
    ----------
    comm : mpi4py communicator
    error : Exception or None
        What went wrong on this rank.

    Raises
    ------
    The class of the lowest failing rank's error (a ParisphError stays what it is,
    anything else becomes a ParisphError), with that rank's message on every rank.
    """
    if comm.size == 1:
        if error is not None:
            raise error
        return
    if not comm.allreduce(int(error is not None)):
        return
    mine = None if error is None else (_class_to_raise(error), f"rank {comm.rank}: {error}")
    kind, message = next(item for item in comm.allgather(mine) if item is not None)
    raise kind(message) from error


def _class_to_raise(error):
    return type(error) if isinstance(error, ParisphError) else ParisphError
