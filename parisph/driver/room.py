"""Whether a case fits into the memory of the machines that shall compute it; asked before anything is made."""

from mpi4py import MPI

from parisph.base import memory
from parisph.base.errors import CaseError
from parisph.case import size


def check(case, comm):
    """Raise CaseError on every rank if the particles need more memory than all machines have. Collective.

    A case is checked for this where it runs, and not when it is made: `parisph check` on a laptop
    says what a case of a cluster takes. What other programs use is not looked at: it changes.
    """
    there = _memory(comm)
    count = size.counts(case)["all"]
    need = size.memory(count, comm.size)
    if there is not None and need > there:
        raise CaseError(
            f"numerics.spacing = {case.numerics.spacing:g}: makes {count:,} particles, which take about {memory.amount(need)} of memory "
            f"on {comm.size} rank{'s' * (comm.size > 1)}; there is {memory.amount(there)}; use a larger spacing, or more machines")


def _memory(comm):
    """Return the bytes of memory of all machines that the ranks are on, None if one does not tell. Collective."""
    machine = comm.Split_type(MPI.COMM_TYPE_SHARED)
    first = machine.rank == 0
    machine.Free()
    found = comm.allgather(memory.total() if first else 0)
    return None if None in found else sum(found)
