"""Write arrays that are distributed over the ranks into one HDF5 file.

Rank 0 creates the file alone: groups, attributes, and datasets with their full size on the disk.
Errors such as a full disk or missing permissions therefore occur there, in serial code, before any
rank has entered a collective call. Then every rank opens the file with MPI-IO and writes its rows
independently; a rank without rows writes nothing.

HDF5 itself must never run into a full disk: HDF5 1.10 ends the process if it cannot write the last
blocks of a file when it closes the file. The space is therefore reserved before.
"""

import math
import os
from contextlib import suppress
from dataclasses import dataclass, field

import h5py
import numpy as np

from parisph.base.errors import StoreError
from parisph.io import digest
from parisph.io.files import create, on_first, publish, temporary, together

METADATA = 1 << 20  # bytes for groups and attributes; a case with a tabulated motion has many


@dataclass
class Slab:
    """The rows of one dataset that this rank owns.

    Attributes
    ----------
    path : name of the dataset in the file
    data : (n, ...) this rank's rows
    start, total : first row of this rank, and number of rows on all ranks
    attributes : dict of the dataset's attributes (rank 0's are written)
    """

    path: str
    data: np.ndarray
    start: int
    total: int
    attributes: dict = field(default_factory=dict)


def write(comm, path, slabs, decorate):
    """Write one HDF5 file from the rows of all ranks, with its digest, and publish it under its name. Collective.

    Parameters
    ----------
    path : pathlib.Path of the file
    slabs : list of Slab, the same paths, types and totals on every rank
    decorate : function of the open h5py.File, run on rank 0: groups, attributes, small datasets

    Raises
    ------
    StoreError on every rank; an existing file of that name is then unchanged.
    """
    _check_h5py(comm)
    doing = f"write {path}"
    hidden = temporary(path)
    try:
        on_first(comm, doing, lambda: _lay_out(hidden, slabs, decorate))
        _fill(comm, doing, hidden, slabs)
        digest.append(comm, hidden, doing)
        on_first(comm, doing, lambda: publish(path))
    except Exception:
        if comm.rank == 0:
            with suppress(OSError):    # what went wrong first is what is raised
                hidden.unlink(missing_ok=True)
        raise


def _check_h5py(comm):
    if comm.size > 1 and not h5py.get_config().mpi:
        raise StoreError(
            "the installed h5py cannot write from several ranks: install a build with MPI "
            "(Debian: python3-h5py-mpi, and set H5PY_ALWAYS_USE_MPI=1), or run on one rank"
        )


def _lay_out(path, slabs, decorate):
    with open(create(path), "wb") as file:
        os.posix_fallocate(file.fileno(), 0, _size(slabs))
    with h5py.File(path, "w") as file:
        decorate(file)
        for slab in slabs:
            dataset = _allocate(file, slab)
            dataset.attrs.update(slab.attributes)
    # HDF5 has freed the blocks again. Reserve them for good, so that a full disk is an error here, and
    # not on some rank in the middle of its rows.
    handle = os.open(path, os.O_RDWR)
    try:
        os.posix_fallocate(handle, 0, os.fstat(handle).st_size)
    finally:
        os.close(handle)


def _size(slabs):
    """Return the bytes of the rows of all ranks, plus a generous estimate for metadata."""
    return METADATA + sum(slab.total * slab.data.itemsize * math.prod(slab.data.shape[1:]) for slab in slabs)


def _allocate(file, slab):
    """Create the dataset with its full extent in the file, without writing fill values."""
    parent, _, name = slab.path.rpartition("/")
    group = file.require_group(parent) if parent else file
    layout = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    layout.set_layout(h5py.h5d.CONTIGUOUS)
    layout.set_alloc_time(h5py.h5d.ALLOC_TIME_EARLY)
    layout.set_fill_time(h5py.h5d.FILL_TIME_NEVER)
    space = h5py.h5s.create_simple((slab.total, *slab.data.shape[1:]))
    kind = h5py.h5t.py_create(slab.data.dtype, logical=True)
    return h5py.Dataset(h5py.h5d.create(group.id, name.encode(), kind, space, layout))


def _fill(comm, doing, path, slabs):
    how = {"driver": "mpio", "comm": comm} if comm.size > 1 else {}
    file = together(comm, doing, lambda: h5py.File(path, "r+", **how))
    try:
        together(comm, doing, lambda: _write_own(file, slabs))
        together(comm, doing, file.flush)  # with MPI-IO: each node sends its rows to the disk
    finally:
        together(comm, doing, file.close)


def _write_own(file, slabs):
    for slab in slabs:
        if len(slab.data):
            file[slab.path][slab.start:slab.start + len(slab.data)] = slab.data
