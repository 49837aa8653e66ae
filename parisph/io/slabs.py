"""Write arrays that are distributed over the ranks into one HDF5 file.

Rank 0 creates the file alone: groups, attributes, and datasets with their full size on the disk. Then every rank writes
its rows to their place in the file with plain system calls. HDF5's own parallel writing is not used: if a folder
disappears while the ranks open a file, some get an error and the others wait for them forever. Here no rank waits
inside a call, and an error on one is raised on all.

HDF5 must never meet a full disk: HDF5 1.10 ends the process if it cannot write the last blocks of a file when it closes
it. So the space for the whole file is reserved before.
"""

import errno
import math
import os
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from parisph.base.arrays import Array
from parisph.base.communicator import Communicator
from parisph.io import digest
from parisph.io.files import create, on_first, publish, temporary, together

METADATA = 1 << 20  # bytes for what HDF5 adds to the rows and to what `decorate` writes


@dataclass
class Slab:
    """The rows of one dataset that this rank owns.

    path : name of the dataset in the file; data : (n, ...) rows of this rank
    start, total : first row of this rank, and number of rows on all ranks
    attributes : of the dataset (rank 0's are written)
    """

    path: str
    data: Array
    start: int
    total: int
    attributes: dict[str, Any] = field(default_factory=dict)


def write(comm: Communicator, path: Path, slabs: Sequence[Slab], decorate: Callable[[h5py.File], None]) -> None:
    """Write one HDF5 file from the rows of all ranks, with its digest, and publish it under its name. Collective.

    slabs : the same paths, types and totals on every rank
    decorate : writes groups, attributes and small datasets to the open file, on rank 0

    Raises StoreError on every rank; an existing file of that name is then unchanged.
    """
    doing = f"write {path}"
    hidden = temporary(path)
    try:
        places = comm.bcast(on_first(comm, doing, lambda: _lay_out(hidden, slabs, decorate)))
        together(comm, doing, lambda: _write_own(hidden, slabs, places))
        digest.append(comm, hidden, doing)
        on_first(comm, doing, lambda: publish(path))
    except Exception:
        if comm.rank == 0:
            with suppress(OSError):    # the first cause is the one to report
                hidden.unlink(missing_ok=True)
        raise


def _lay_out(path: Path, slabs: Sequence[Slab], decorate: Callable[[h5py.File], None]) -> list[int]:
    """Make the file without the rows, and return the offset of the rows of each slab in it [bytes]."""
    with open(create(path), "wb") as file:
        os.posix_fallocate(file.fileno(), 0, _size(slabs, decorate))
    places = []
    try:
        with h5py.File(path, "w") as file:
            decorate(file)
            for slab in slabs:
                dataset = _allocate(file, slab)
                dataset.attrs.update(slab.attributes)
                places.append(dataset.id.get_offset())
    except OSError as error:
        if error.errno is not None or path.exists():
            raise
        # HDF5 does not report the cause
        raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), str(path)) from error
    # HDF5 has freed the blocks. Reserve them again, so that a full disk raises here and not on a rank amid its rows.
    handle = os.open(path, os.O_RDWR)
    try:
        os.posix_fallocate(handle, 0, os.fstat(handle).st_size)
    finally:
        os.close(handle)
    return places


def _size(slabs: Sequence[Slab], decorate: Callable[[h5py.File], None]) -> int:
    """Return the bytes of the rows of all ranks and of the content of `decorate`, with a margin."""
    with h5py.File("in memory", "w", driver="core", backing_store=False) as file:
        decorate(file)
        file.flush()
        about: int = file.id.get_filesize()
    return METADATA + about + sum(slab.total * slab.data.itemsize * math.prod(slab.data.shape[1:]) for slab in slabs)


def _allocate(file: h5py.File, slab: Slab) -> h5py.Dataset:
    """Create the dataset with its full extent in the file, without writing fill values."""
    parent, _, name = slab.path.rpartition("/")
    group = file.require_group(parent) if parent else file
    layout = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    layout.set_layout(h5py.h5d.CONTIGUOUS)
    layout.set_alloc_time(h5py.h5d.ALLOC_TIME_EARLY)
    layout.set_fill_time(h5py.h5d.FILL_TIME_NEVER)
    layout.set_obj_track_times(False)    # equal contents give equal files
    space = h5py.h5s.create_simple((slab.total, *slab.data.shape[1:]))
    kind = h5py.h5t.py_create(slab.data.dtype, logical=True)
    return h5py.Dataset(h5py.h5d.create(group.id, name.encode(), kind, space, layout))


def _write_own(path: Path, slabs: Sequence[Slab], places: Sequence[int]) -> None:
    """Write the rows of this rank to the file, and force them to the disk."""
    handle = os.open(path, os.O_WRONLY | os.O_NOFOLLOW)
    try:
        for slab, place in zip(slabs, places, strict=True):
            rows = np.ascontiguousarray(slab.data)
            if len(rows):
                _write_at(handle, place + slab.start * rows[0].nbytes, rows.reshape(-1).data.cast("B"))
        os.fsync(handle)
    finally:
        os.close(handle)


def _write_at(handle: int, place: int, data: memoryview) -> None:
    while data:
        written = os.pwrite(handle, data, place)
        place, data = place + written, data[written:]
