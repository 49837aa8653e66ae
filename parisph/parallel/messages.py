"""Particles as records of bytes, and their exchange between any ranks."""

import numpy as np
from mpi4py import MPI

from parisph.base.fields import FIELDS

_TAG = 71


def record_type(names, dim, extra=()):
    """Return the numpy type of one particle's record: the named fields, then extra (name, type) pairs."""
    fields = [(name, FIELDS[name].dtype, FIELDS[name].empty(0, dim).shape[1:]) for name in names]
    return np.dtype(fields + list(extra))


def pack(particles, names, which, extra=()):
    """Return the records of the owned particles `which` (n,), with `extra` parts left undefined."""
    records = np.empty(len(which), record_type(names, particles.dim, extra))
    for name in names:
        records[name] = getattr(particles, name)[which]
    return records


def unpack(particles, names, records, start):
    """Write the named fields of records to the local particles from number `start` on."""
    for name in names:
        getattr(particles, f"{name}_all")[start:start + len(records)] = records[name]


def exchange(comm, records, counts):
    """Send records to other ranks, one message to each that gets any. Collective.

    Parameters
    ----------
    records : (n,) of any record type, the same on all ranks; sorted by destination
    counts : (ranks,) how many of them each rank gets, in this order

    Returns
    -------
    received : records in the order of the ranks they come from
    senders : (ranks,) how many came from each
    """
    counts = np.ascontiguousarray(counts, dtype=np.int64)
    senders = np.empty_like(counts)
    comm.Alltoall(counts, senders)
    received = np.empty(senders.sum(), records.dtype)
    # Counted in records, a message of more than 2 GB needs no care.
    kind = MPI.BYTE.Create_contiguous(records.dtype.itemsize).Commit()
    requests = [comm.Irecv(message, rank, _TAG) for rank, message in _messages(received, senders, kind)]
    requests += [comm.Isend(message, rank, _TAG) for rank, message in _messages(records, counts, kind)]
    MPI.Request.Waitall(requests)
    kind.Free()
    return received, senders


def _messages(records, counts, kind):
    """Give each rank that has any its run of the records, as mpi4py wants a message."""
    ends = np.cumsum(counts)
    for rank in np.flatnonzero(counts):
        part = records[ends[rank] - counts[rank]:ends[rank]]
        yield rank, [part.view(np.uint8), len(part), kind]
