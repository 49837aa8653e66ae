"""Particles packed into records, and their exchange between any ranks."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from mpi4py import MPI

from parisph.base.arrays import Array, Ints
from parisph.base.fields import FIELDS
from parisph.parallel.particles import Particles

_TAG = 71


def record_type(names: Sequence[str], dim: int, extra: Sequence[tuple[str, type]] = ()) -> np.dtype[Any]:
    """Return the numpy type of one particle's record: the named fields, then extra (name, type) pairs."""
    fields = [(name, FIELDS[name].dtype, FIELDS[name].empty(0, dim).shape[1:]) for name in names]
    return np.dtype(fields + list(extra))


def pack(particles: Particles, names: Sequence[str], which: Ints,
         extra: Sequence[tuple[str, type]] = ()) -> Array:
    """Return the records of the owned particles `which` (n,), with `extra` parts undefined."""
    records = np.empty(len(which), record_type(names, particles.dim, extra))
    for name in names:
        records[name] = getattr(particles, name)[which]
    return records


def unpack(particles: Particles, names: Sequence[str], records: Array, start: int) -> None:
    """Write the named fields of records to the local particles from number `start` on."""
    for name in names:
        getattr(particles, f"{name}_all")[start:start + len(records)] = records[name]


def exchange(comm: MPI.Comm, records: Array, counts: Ints) -> tuple[Array, Ints]:
    """Send records to other ranks, in one message per receiver. Collective.

    Parameters
    ----------
    records : (n,) of any record type, the same on all ranks; sorted by destination
    counts : (ranks,) records for each rank

    Returns
    -------
    received : records, sorted by sender
    senders : (ranks,) records from each rank
    """
    counts = np.ascontiguousarray(counts, dtype=np.int64)
    senders = np.empty_like(counts)
    comm.Alltoall(counts, senders)
    received = np.empty(senders.sum(), records.dtype)
    # Counts of records, not bytes, allow messages above 2 GB.
    kind = MPI.BYTE.Create_contiguous(records.dtype.itemsize).Commit()
    requests = [comm.Irecv(message, rank, _TAG) for rank, message in _messages(received, senders, kind)]
    requests += [comm.Isend(message, rank, _TAG) for rank, message in _messages(records, counts, kind)]
    MPI.Request.Waitall(requests)
    kind.Free()
    return received, senders


def _messages(records: Array, counts: Ints, kind: MPI.Datatype) -> Iterator[tuple[int, list[Any]]]:
    """Yield (rank, message) for each rank with records, in mpi4py's form."""
    ends = np.cumsum(counts)
    for rank in np.flatnonzero(counts):
        part = records[ends[rank] - counts[rank]:ends[rank]]
        yield rank, [part.view(np.uint8), len(part), kind]
