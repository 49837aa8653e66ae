"""What the parts below MPI use of a communicator: mpi4py's have it, and a laptop needs no MPI to describe a case."""

from typing import Any, Protocol


class Communicator(Protocol):
    """The ranks that work together."""

    @property
    def rank(self) -> int:
        """Number of this rank."""

    @property
    def size(self) -> int:
        """Number of ranks."""

    def allreduce(self, sendobj: Any) -> Any:
        """Return the sum of what all ranks give. Collective."""

    def Allreduce(self, sendbuf: Any, recvbuf: Any) -> Any:
        """Write the sum of the arrays that all ranks give to the second. Collective."""

    def allgather(self, sendobj: Any) -> list[Any]:
        """Return what all ranks give, in the order of ranks. Collective."""

    def bcast(self, obj: Any) -> Any:
        """Return what rank 0 gives. Collective."""

    def Abort(self, errorcode: int) -> Any:
        """End all ranks, and do not return."""
