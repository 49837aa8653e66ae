"""Find groups of unknowns without a link to a known pressure, before the solve.

The rows of the pressure equation are weakly diagonally dominant: their entries sum to zero, except in anchored rows
(identity rows, and rows from which a neighbour with p = 0 was dropped). Such a matrix is regular if and only if every
row leads, along its entries, to an anchored row (Shivakumar & Chew 1974, on weakly chained diagonal dominance). Entries
are followed from row to column only, because the matrix is not symmetric: the row of a wall particle may contain a
fluid particle whose row does not contain the wall particle.
"""

import numpy as np
from mpi4py import MPI

from parisph.base.arrays import Array, Flags, Floats, Ints
from parisph.base.errors import ParisphError, agree, agree_and_sum
from parisph.kernels import graph

_TAG = 72
_Spans = list[tuple[int, slice]]    # ranks, each with a part of an array


def isolated_rows(comm: MPI.Comm, offset: int, indptr: Array, indices: Array, anchored: Flags) -> tuple[Flags, int]:
    """Return which rows lead to no anchored row. Collective.

    These lead only to each other. Fixing p in one row of each group makes the matrix regular.

    Parameters
    ----------
    comm : mpi4py communicator
    offset : int, global number of this rank's first row; rows are numbered contiguously, rank by rank
    indptr : (n_owned + 1,) int, indices : (nnz,) int; this rank's rows as CSR with global columns
    anchored : (n_owned,) bool, rows with a known pressure, or with a neighbour of known pressure

    Returns
    -------
    isolated : (n_owned,) bool; and their number on all ranks

    Raises
    ------
    ParisphError on all ranks: array sizes do not match, or a column is out of range.
    """
    anchored = np.asarray(anchored, bool)
    fits = indptr.shape == (anchored.size + 1,) and indptr[0] == 0 and indptr[-1] == indices.size
    error = None if fits else ParisphError(
        f"{anchored.size} anchored flags do not fit rows with indptr {indptr.shape} and {indices.size} columns")
    reached = anchored.copy()
    pending = np.flatnonzero(~anchored).astype(np.int32)
    if fits:
        pending = graph.spread(reached, pending, indptr, indices, offset)
    left, = agree_and_sum(comm, error, pending.size)
    if not left:
        return ~reached, 0
    if comm.size > 1:
        _spread_over_ranks(comm, offset, reached, pending, indptr, indices)
    return ~reached, comm.allreduce(int(np.count_nonzero(~reached)))


def highest(comm: MPI.Comm, candidates: Flags, x: Floats, force: Floats, ids: Array, rounding: float) -> Flags:
    """Return the candidate farthest against their mean body force, one on all ranks. Collective.

    Parameters
    ----------
    candidates : (n_owned,) bool
    x : (n_owned, dim) [m], force : (n_owned, dim) [m/s^2]
    ids : (n_owned,) int, which decide between equal heights
    rounding : [m], heights are rounded to it, so the choice does not depend on the number of ranks

    Returns
    -------
    chosen : (n_owned,) bool, True for one particle on one rank, or none without candidates
    """
    mean = comm.allreduce(force[candidates].sum(axis=0))
    length = float(np.linalg.norm(mean))
    up = -mean / length if length > 0.0 else np.zeros_like(mean)
    mine = np.flatnonzero(candidates)
    levels = np.round(x[mine] @ up / rounding)
    best = np.lexsort((ids[mine], -levels))[:1]
    found = comm.allgather([(-levels[k], int(ids[mine[k]])) for k in best])
    chosen = np.zeros_like(candidates)
    if any(found):
        first = min(item for part in found for item in part)
        chosen[mine[ids[mine] == first[1]]] = True
    return chosen


def _spread_over_ranks(comm: MPI.Comm, offset: int, reached: Flags, pending: Array, indptr: Array,
                       indices: Array) -> None:
    """Fetch marks from other ranks and spread them, until no rank marks another row."""
    rows, columns = graph.outside(pending, indptr, indices, offset, reached.size)
    remote, slot = np.unique(columns, return_inverse=True)
    lookup = _Lookup(comm, offset, reached.size, remote)
    while True:
        marks = lookup.pull(reached)
        reached[rows[marks[slot]]] = True
        left = pending[~reached[pending]]
        left = graph.spread(reached, left, indptr, indices, offset)
        gained = np.array([pending.size - left.size])
        pending = left
        comm.Allreduce(MPI.IN_PLACE, gained)
        if not gained[0]:
            return


class _Lookup:
    """Reads the marks of rows on other ranks; the addresses are exchanged once.

    Only ranks with rows for each other exchange messages, as an Alltoallv sends one to every rank. There are as many
    rounds as ranks between the surface and the row farthest from it.
    """

    def __init__(self, comm: MPI.Comm, offset: int, n: int, remote: Ints) -> None:
        self._comm = comm
        spans = np.empty((comm.size, 2), np.int64)
        comm.Allgather(np.array([offset, n], np.int64), spans)
        total = spans[:, 1].sum()
        bad = remote.size and not 0 <= remote[0] <= remote[-1] < total
        agree(comm, ParisphError(f"a pressure row refers to column {remote[0]} or {remote[-1]} of {total}")
              if bad else None)
        # Ranks without rows have the same first row as the next rank: take the last one.
        owner = np.searchsorted(spans[:, 0], remote, side="right") - 1
        asked = np.bincount(owner, minlength=comm.size)
        wanted = np.empty_like(asked)
        comm.Alltoall(asked, wanted)
        self._asked, self._wanted = _parts(asked), _parts(wanted)
        addresses = np.empty(wanted.sum(), np.int64)
        self._swap(remote.astype(np.int64), self._asked, addresses, self._wanted)
        self._addresses = addresses - offset
        self._marks = np.empty(remote.size, bool)

    def pull(self, reached: Flags) -> Flags:
        """Return the marks of the remote rows, in their order. Collective."""
        self._swap(reached[self._addresses], self._wanted, self._marks, self._asked)
        return self._marks

    def _swap(self, sent: Array, to: _Spans, received: Array, by: _Spans) -> None:
        requests = [self._comm.Irecv(received[part], rank, _TAG) for rank, part in by]
        requests += [self._comm.Isend(sent[part], rank, _TAG) for rank, part in to]
        MPI.Request.Waitall(requests)


def _parts(counts: Ints) -> _Spans:
    """Return (rank, slice) of each rank with entries in an array ordered by rank; counts : (ranks,)."""
    ends = np.cumsum(counts)
    return [(int(rank), slice(ends[rank] - counts[rank], ends[rank])) for rank in np.flatnonzero(counts)]
