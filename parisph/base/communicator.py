"""The methods of MPI communicators that parts without mpi4py use. A case can be described without MPI."""

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
        """Return the sum of the objects of all ranks. Collective."""

    def Allreduce(self, sendbuf: Any, recvbuf: Any) -> Any:
        """Write the sum of the arrays `sendbuf` of all ranks to `recvbuf`. Collective."""

    def allgather(self, sendobj: Any) -> list[Any]:
        """Return the objects of all ranks, in the order of ranks. Collective."""

    def bcast(self, obj: Any) -> Any:
        """Return the object of rank 0. Collective."""

    def Abort(self, errorcode: int) -> Any:
        """End all ranks, and do not return."""
