"""Checkpoints: all that a run needs to go on, in one plain HDF5 file, on any number of ranks.

Layout: /particles/<field> (n, ...) for every field that migrates with its particle, each with
the attribute `checksum`; attributes of the root: format, version, time, step, dt, case (JSON),
state (JSON) and how the run was made. The file gets its name only when it is whole.
"""

import json
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np

from parisph.base.errors import StoreError, agree
from parisph.base.fields import FIELDS
from parisph.io import rows
from parisph.io.files import on_first
from parisph.io.rows import Slab

FORMAT, VERSION = "parisph checkpoint", 1
KEEP = 2  # the last and, in case a disk loses it, the one before


@dataclass(frozen=True)
class Checkpoint:
    """What stands in a checkpoint, and this rank's share of its particles.

    Attributes
    ----------
    time [s], step, dt [s] : of the run when it was written
    case : str, the case as JSON
    state : dict that the driver gave (probes, time stepping, ...)
    dim : number of dimensions
    arrays : dict of field name -> rows [offset, offset + n) of this rank
    offset, total : first row of this rank, number of rows of all
    """

    time: float
    step: int
    dt: float
    case: str
    state: dict
    dim: int
    arrays: dict
    offset: int
    total: int


def write(comm, folder, particles, time, step, dt, case, state, attributes):
    """Write folder/NNNNNNNN.h5 (the step's number), keep the last two, return the path. Collective.

    Parameters
    ----------
    particles : Particles; all its fields that migrate are written
    time [s], step, dt [s] : dt is that of the next step
    case : JSON text
    state : dict that JSON can hold; rank 0's is written
    attributes : further dict of str, int or float for the root of the file

    Raises
    ------
    StoreError on every rank; checkpoints that were there before are then untouched.
    """
    path = Path(folder) / f"{step:08d}.h5"
    n, start, total = particles.n_owned, particles.offset, particles.n_global
    names = [name for name, field in FIELDS.items() if field.migrates]
    data = {name: np.ascontiguousarray(getattr(particles, name)) for name in names}
    sums = _sum_over_ranks(comm, [_checksum(data[name], start) for name in names])
    slabs = [
        Slab(f"particles/{name}", data[name], start, total, {"unit": FIELDS[name].unit, "checksum": np.uint64(total_sum)})
        for name, total_sum in zip(names, sums)
    ]

    def decorate(file):
        file.attrs.update({
            **attributes, "format": FORMAT, "version": VERSION, "time": float(time), "step": int(step),
            "dt": float(dt), "dim": particles.dim, "particles": total, "ranks": comm.size,
            "case": case, "state": json.dumps(state, default=_plain_number),
        })

    rows.write(comm, path, slabs, decorate)
    on_first(comm, f"remove old checkpoints from {folder}", lambda: _remove_old(folder, path))
    return path


def read(comm, path):
    """Return a Checkpoint with this rank's share of the particles (as numpy.array_split cuts). Collective.

    The number of ranks may differ from that of the run that wrote it.

    Raises
    ------
    StoreError on every rank if the file is missing, foreign, of a newer version, cut short or altered;
    it names the newest sound checkpoint beside the file, if there is one, and the command that takes it.
    """
    try:
        return _read(comm, path)
    except StoreError as error:    # on every rank
        advice = comm.bcast(_advice(Path(path)) if comm.rank == 0 else None)
        raise StoreError(f"{error}{advice}") from None


def _read(comm, path):
    loaded, problem, sums, stored = None, None, [], []
    try:
        loaded, stored = _read_share(path, comm.rank, comm.size)
        sums = [_checksum(data, loaded.offset) for data in loaded.arrays.values()]
    except StoreError as error:
        problem = error
    agree(comm, problem)
    sums = _sum_over_ranks(comm, sums)
    for name, found, expected in zip(loaded.arrays, sums, stored):
        if found != expected:  # the same on every rank
            raise StoreError(f"{path} is damaged: field {name!r} does not match its checksum")
    return loaded


def paths(folder):
    """Return the whole checkpoints of a folder, oldest first; empty if there is no such folder."""
    return sorted(path for path in Path(folder).glob("*.h5") if path.stem.isdigit())


def _advice(damaged):
    """Return how to go on without a checkpoint, as the end of a message; nothing if no other is sound. Not collective."""
    there = [path for path in paths(damaged.parent) if path.name != damaged.name]
    sound = next((path for path in reversed(there) if _is_sound(path)), None)
    if sound is None:
        return ""
    place = "" if sound.name > damaged.name and sound == there[-1] else " -o DIR"
    return f"; the newest sound one beside it is {sound}: parisph restart {sound}{place}"


def _is_sound(path):
    """Return whether a checkpoint can be read whole, with the checksums that stand in it. Not collective."""
    try:
        found, stored = _read_share(path, 0, 1)
    except (StoreError, RuntimeError):
        return False
    return [_checksum(data, 0) for data in found.arrays.values()] == stored


def _read_share(path, rank, size):
    try:
        with h5py.File(path, "r") as file:
            _check_format(path, file)
            total = int(file.attrs["particles"])
            first, last = _share(total, rank, size)
            _check_fields(path, file["particles"])
            arrays, stored = {}, []
            for name, data in file["particles"].items():
                arrays[name] = data[first:last]
                stored.append(int(data.attrs["checksum"]))
            attrs = file.attrs
            return Checkpoint(
                time=float(attrs["time"]), step=int(attrs["step"]), dt=float(attrs["dt"]), case=attrs["case"],
                state=json.loads(attrs["state"]), dim=int(attrs["dim"]), arrays=arrays, offset=first, total=total,
            ), stored
    except FileNotFoundError:
        raise StoreError(f"there is no checkpoint {path}") from None
    except (OSError, KeyError, ValueError) as error:
        raise StoreError(f"{path} is not a whole checkpoint of parisph: {error}") from None


def _check_format(path, file):
    if file.attrs.get("format") != FORMAT:
        raise StoreError(f"{path} is an HDF5 file, but not a checkpoint of parisph")
    if int(file.attrs["version"]) > VERSION:
        raise StoreError(f"{path} was written by a newer parisph (version {file.attrs['version']} of the format, this one reads {VERSION})")


def _check_fields(path, particles):
    missing = [name for name, field in FIELDS.items() if field.migrates and name not in particles]
    if missing:
        raise StoreError(f"{path} lacks {', '.join(missing)}, which this parisph needs: restart it with the version that wrote it "
                         "(its parisph_version says which)")


def _share(total, rank, size):
    """First and last row of a rank, the first ranks one row longer where it does not divide."""
    length, longer = divmod(total, size)
    first = rank * length + min(rank, longer)
    return first, first + length + (rank < longer)


def _checksum(data, start):
    """Sum of the words of data, each times an odd number of its place, modulo 2^64.

    Adds over ranks, however the rows are spread; a change of any one word changes it, and so
    does exchanging two.
    """
    words = np.ascontiguousarray(data).reshape(-1)
    words = words.view(f"u{words.itemsize}").astype(np.uint64)
    first = start * int(np.prod(data.shape[1:]))
    places = 2 * np.arange(first, first + len(words), dtype=np.uint64) + np.uint64(1)
    return int(np.sum(words * places, dtype=np.uint64))


def _sum_over_ranks(comm, sums):
    everyone = np.array(comm.allgather(sums), dtype=np.uint64)
    return [int(total) for total in np.sum(everyone, axis=0, dtype=np.uint64)]  # wraps, as it should


def _remove_old(folder, newest):
    for path in [path for path in paths(folder) if path != newest][: -(KEEP - 1)]:
        path.unlink()


def _plain_number(value):
    """JSON for numpy's numbers and arrays in the state."""
    if hasattr(value, "tolist"):
        return value.tolist()
    raise TypeError(f"the state of a checkpoint cannot hold a {type(value).__name__}")
