"""Checkpoints: all data needed to continue a run on any number of ranks, in one plain HDF5 file.

Layout: /particles/<field> (n, ...) for every field that migrates with its particle; /flows/<number>/<field> (n, ...)
of flows that may be at a peak of a probe; attributes of the root: format, version, time, step, dt, case (JSON), state
(JSON), versions and options; after the HDF5 part a digest (parisph.io.digest), which is checked before HDF5 opens the
file. The file gets its final name only when it is complete.
"""

import json
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import h5py
import numpy as np

from parisph.base.arrays import Array
from parisph.base.communicator import Communicator
from parisph.base.errors import StoreError
from parisph.base.fields import CORE
from parisph.base.paths import AnyPath
from parisph.base.reading import read_text
from parisph.io import digest, slabs
from parisph.io.files import on_first, together
from parisph.io.slabs import Slab
from parisph.parallel.particles import Particles

FORMAT, VERSION = "parisph checkpoint", 2    # 1: without a digest, and with phi in Pa
WITHOUT_VOLUMES = "6d557b4"    # the last commit that restarts from files without volumes of particles
KEEP = 2  # the last, and the one before in case a disk loses the last
_NAME = re.compile(r"([0-9]{8}|[1-9][0-9]{8,})\.h5")    # as `write` names them; copies have other names


@dataclass(frozen=True)
class Share:
    """This rank's share of a flow: {field: rows [offset, offset + n)}, of `total` rows of all ranks."""

    arrays: dict[str, Array]
    offset: int
    total: int


@dataclass(frozen=True)
class Checkpoint:
    """The content of a checkpoint, with this rank's share of the particles.

    time [s], step, dt [s] : of the run at the checkpoint; case : as JSON
    state : given by the driver (probes, time stepping, ...)
    arrays : {field: rows [offset, offset + n) of this rank}; total : number of rows of all ranks
    flows : the Share of each stored earlier flow, with some of the fields
    """

    time: float
    step: int
    dt: float
    case: str
    state: dict[str, Any]
    dim: int
    arrays: dict[str, Array]
    offset: int
    total: int
    flows: Sequence[Share] = ()


class EarlierFlow(Protocol):
    """Particles of an earlier flow. arrays : {field: rows of this rank}; offset : number of the first"""

    arrays: dict[str, Array]
    offset: int
    n_global: int


def write(comm: Communicator, folder: AnyPath, particles: Particles, time: float, step: int, dt: float, case: str,
          state: Mapping[str, Any], attributes: Mapping[str, str | float], earlier: Sequence[str] = (),
          flows: Sequence[EarlierFlow] = ()) -> Path:
    """Write folder/NNNNNNNN.h5 (the step's number), and return the path. Collective.

    The last two checkpoints of the run are kept. The state lists them, so that a restart knows the files of the run. No
    other file is removed.

    particles : their migrating fields are written
    time [s], step, dt [s] : dt is that of the next step
    state : content for JSON, of rank 0; attributes : further ones of the root of the file
    earlier : file names of the run's checkpoints so far, oldest first; all except the last are removed
    flows : earlier flows to write too

    Raises StoreError on every rank; earlier checkpoints are then unchanged.
    """
    path = Path(folder) / f"{step:08d}.h5"
    earlier = [name for name in earlier if name != path.name]
    state = {**state, "checkpoints": [*earlier, path.name]}
    start, total = particles.offset, particles.n_global
    arrays = [
        Slab(f"particles/{name}", np.ascontiguousarray(getattr(particles, name)), start, total,
             {"unit": particles.fields[name].unit})
        for name in particles.fields.migrating
    ]
    arrays += [Slab(f"flows/{number}/{name}", np.ascontiguousarray(data), flow.offset, flow.n_global)
               for number, flow in enumerate(flows) for name, data in flow.arrays.items()]

    def decorate(file: h5py.File) -> None:
        file.attrs.update({
            **attributes, "format": FORMAT, "version": VERSION, "time": float(time), "step": int(step),
            "dt": float(dt), "dim": particles.dim, "particles": total, "ranks": comm.size,
            "case": case, "state": json.dumps(state, default=_plain_number),
        })

    slabs.write(comm, path, arrays, decorate)
    on_first(comm, f"remove old checkpoints from {folder}", lambda: _remove(folder, earlier[: 1 - KEEP]))
    return path


def read(comm: Communicator, path: AnyPath) -> Checkpoint:
    """Return a Checkpoint with this rank's share of the particles (as of numpy.array_split). Collective.

    The number of ranks may differ from that of the run that wrote it.

    Raises StoreError on every rank if the file is missing, damaged, of another version, or not a checkpoint. It names
    the newest sound checkpoint in the same folder, if there is one, and the command to use it.
    """
    path = Path(path)
    try:
        return _read(comm, path)
    except StoreError as error:    # on every rank
        raise StoreError(f"{error}{_advice(comm, path)}") from None


def _read(comm: Communicator, path: Path) -> Checkpoint:
    # files of a run without an identity may have no digest
    early = comm.bcast(_identity_beside(path) == "" if comm.rank == 0 else None)
    digest.check_together(comm, path, early)
    loaded = together(comm, f"read {path}", lambda: _read_share(path, comm.rank, comm.size, early))
    on_first(comm, f"read {path}", lambda: _check_place(path, loaded))
    return loaded


def paths(folder: AnyPath) -> list[Path]:
    """Return the checkpoint files in a folder, oldest first; empty if there is no such folder."""
    return sorted((path for path in Path(folder).glob("*.h5") if _NAME.fullmatch(path.name)),
                  key=lambda path: int(path.stem))


def _advice(comm: Communicator, damaged: Path) -> str:
    """Return how to continue without this checkpoint, as the end of a message; "" if no other is sound. Collective."""
    there = comm.bcast([path for path in paths(damaged.parent) if path.name != damaged.name]
                       if comm.rank == 0 else None)
    sound = next((path for path in reversed(there) if _is_sound(comm, path)), None)
    if sound is None:
        return ""
    place = "" if sound.name > damaged.name and sound == there[-1] else " -o DIR"
    return f"; the newest sound one beside it is {sound}: parisph restart {sound}{place}"


def _is_sound(comm: Communicator, path: Path) -> bool:
    """Return whether a checkpoint can be read. Collective."""
    try:
        _read(comm, path)
    except StoreError:    # on every rank
        return False
    return True


def _read_share(path: Path, rank: int, size: int, early: bool) -> Checkpoint:
    """Return a Checkpoint with the share of one rank, without a check of the digest. Not collective."""
    try:
        with h5py.File(path, "r") as file:
            if early and file.attrs.get("run"):
                digest.check(path)    # files of a run with an identity have one
            _check_format(path, file)
            total = int(file.attrs["particles"])
            first, last = _share(total, rank, size)
            _check_fields(path, file["particles"])
            attrs = file.attrs
            return Checkpoint(
                time=float(attrs["time"]), step=int(attrs["step"]), dt=float(attrs["dt"]), case=attrs["case"],
                state=json.loads(attrs["state"]), dim=int(attrs["dim"]), offset=first, total=total,
                arrays={name: data[first:last] for name, data in file["particles"].items()
                        if name != "phi" or int(attrs["version"]) > 1},
                flows=[_share_of(file[f"flows/{number}"], rank, size) for number in range(len(file.get("flows", ())))],
            )
    except (OSError, KeyError, ValueError) as error:
        raise StoreError(f"{path} is not a whole checkpoint of parisph: {error}") from None


def _share_of(flow: h5py.Group, rank: int, size: int) -> Share:
    total = len(flow["x"])
    first, last = _share(total, rank, size)
    return Share({name: data[first:last] for name, data in flow.items()}, first, total)


def _check_format(path: Path, file: h5py.File) -> None:
    if file.attrs.get("format") != FORMAT:
        raise StoreError(f"{path} is an HDF5 file, but not a checkpoint of parisph")
    if int(file.attrs["version"]) not in range(1, VERSION + 1):
        raise StoreError(f"{path} has version {file.attrs['version']} of the format, this parisph reads up to "
                         f"{VERSION}: it was written by a newer parisph, so update parisph")


def _check_fields(path: Path, particles: h5py.Group) -> None:
    # other fields have a default, which newer parts get from an older file
    missing = [name for name in CORE if name not in particles]
    if missing == ["volume"]:
        raise StoreError(f"{path} lacks the volumes of its particles, so this parisph cannot go on from it. The "
                         f"last that can is in a clone after: git checkout {WITHOUT_VOLUMES}\n"
                         f"To repeat the run with this one: parisph run {path.parent.parent / 'case.json'}")
    if missing:
        raise StoreError(f"{path} lacks {', '.join(missing)}, which this parisph needs: "
                         "restart it with the version that wrote it (its parisph_version says which)")


def _share(total: int, rank: int, size: int) -> tuple[int, int]:
    """Return the first row of a rank and one past its last; the first ranks may have one row more."""
    length, longer = divmod(total, size)
    first = rank * length + min(rank, longer)
    return first, first + length + (rank < longer)


def _check_place(path: Path, loaded: Checkpoint) -> None:
    """Raise StoreError if a sound checkpoint has the name of another step, or is in the folder of another run."""
    if _NAME.fullmatch(path.name) and int(path.stem) != loaded.step:
        raise StoreError(f"{path} is the checkpoint of step {loaded.step}: it has been renamed, "
                         "or another one copied over it")
    run = _identity_beside(path)
    if run is not None and path.parent.name == "checkpoints" and json.loads(loaded.case).get("run", "") != run:
        raise StoreError(f"{path} is of another run than its folder: it has been copied there")


def _identity_beside(path: Path) -> str | None:
    """Return the identity of the run in whose folder a checkpoint is, "" if it has none, None without a readable run.

    Other readers of case.json raise its faults.
    """
    try:
        content = json.loads(read_text(path.resolve().parent.parent / "case.json", math.inf))
        return str(content.get("run", ""))
    except (OSError, ValueError, AttributeError, RecursionError):
        return None


def _remove(folder: AnyPath, names: Sequence[str]) -> None:
    for name in names:
        if _NAME.fullmatch(name):    # the list comes from a file
            (Path(folder) / name).unlink(missing_ok=True)


def _plain_number(value: Any) -> Any:
    """Return a number or list for JSON in place of a number or array of numpy. Raises TypeError for another value."""
    if hasattr(value, "tolist"):
        return value.tolist()
    raise TypeError(f"the state of a checkpoint cannot hold a {type(value).__name__}")
