"""Checks of geometry and memory before a case is built."""

from mpi4py import MPI

from parisph.base import memory
from parisph.base.errors import CaseError
from parisph.base.log import logger
from parisph.case import size
from parisph.case.schema import Case
from parisph.driver import precheck
from parisph.geometry import build, scene_checks


def check(case: Case, comm: MPI.Comm) -> None:
    """Raise CaseError on every rank if the geometry is faulty, or needs more memory than all machines have. Collective.

    Memory is checked only where a case runs: `parisph check` on a laptop may describe a case for a cluster. The memory
    of other programs changes, and is not counted.
    """
    precheck.check(case)
    for text in scene_checks.warnings(case) if comm.rank == 0 else ():
        logger.warning(text)
    there = _memory(comm)
    count = build.counts(case)["all"]
    need = size.memory(count, comm.size, case.dim)
    if there is not None and need > there:
        raise CaseError(
            f"numerics.spacing = {case.numerics.spacing:g}: makes {count:,} particles, "
            f"which take about {memory.amount(need)} of memory on {comm.size} rank{'s' * (comm.size > 1)}; "
            f"there is {memory.amount(there)}; use a larger spacing, or more machines")


def _memory(comm: MPI.Comm) -> int | None:
    """Return the memory [bytes] of all machines of the ranks, None if one is unknown. Collective."""
    machine = comm.Split_type(MPI.COMM_TYPE_SHARED)
    first = machine.rank == 0
    machine.Free()
    found = comm.allgather(memory.total() if first else 0)
    return None if None in found else sum(found)
