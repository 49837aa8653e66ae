"""Actions of a command on all ranks or on the first alone. An error on one rank is raised on all."""

import signal
from collections.abc import Callable
from typing import TYPE_CHECKING, TypeVar, cast

from parisph.base import environment, libraries
from parisph.base.errors import Interrupted, ParisphError, agree
from parisph.base.signals import Signals

if TYPE_CHECKING:    # a command in one process needs no MPI
    from mpi4py import MPI

Result = TypeVar("Result")


def everywhere(action: Callable[[], Result]) -> Result:
    """Return action() of each rank; an error on one is raised on all. Collective; needs MPI only under mpirun."""
    if environment.launched()[1] == 1:
        return action()
    result: Result | None = None
    error: ParisphError | None = None
    try:
        result = action()
    except ParisphError as problem:
        error = problem
    _agree(error)
    return cast(Result, result)


def on_first(action: Callable[[], Result]) -> Result:
    """Call action() on rank 0 only, and return its result on every rank. Collective; errors as in `everywhere`."""
    if environment.launched()[1] == 1:
        return action()
    comm = world()
    result: Result | None = None
    error: ParisphError | None = None
    if comm.rank == 0:
        try:
            result = action()
        except ParisphError as problem:
            error = problem
    comm.Barrier()    # signals can stop a rank that waits here, but not in the sums of `agree`
    _agree(error)
    return cast(Result, comm.bcast(result))


def stop_if_asked() -> None:
    """Raise Interrupted on every rank if any has got a signal to stop before the run. Collective."""
    seen = Signals.active().seen
    error = Interrupted(f"stopped by {signal.Signals(seen).name} before the run has begun") if seen else None
    if environment.launched()[1] > 1:
        _agree(error)
    elif error is not None:
        raise error


def world() -> "MPI.Comm":
    """Return the communicator of all ranks.

    Raises MissingLibrary without MPI or PETSc, and ParisphError if a launcher has started several ranks and MPI sees
    one: each would run the whole case into the same folder.
    """
    libraries.require(*libraries.ENGINE)
    from mpi4py import MPI

    launched = environment.launched()[1]
    if launched != MPI.COMM_WORLD.size == 1:
        raise ParisphError(
            f"{launched} processes were launched, but the MPI library of mpi4py sees one. mpirun and mpi4py "
            "belong to different MPI libraries: see parisph doctor")
    Signals.active().over(MPI.COMM_WORLD)
    return MPI.COMM_WORLD


def _agree(error: ParisphError | None) -> None:
    """Raise on every rank if any has an error. A rank with an error raises its own, without "rank 0:" in front."""
    try:
        agree(world(), error)
    except ParisphError:
        if error is not None:
            raise error from None
        raise
