"""Snapshots: the particles at one time, in VTKHDF files that ParaView, VTK and h5py read.

Layout of a file (see the VTKHDF description of VTK): an UnstructuredGrid in one piece, which VTK reads since 9.1
(PolyData: not in 9.2). /VTKHDF/Points (n, 3), one vertex cell per particle, in 3D the triangles of the walls with the
number of their body in /VTKHDF/CellData/body (parisph.io.wall_cells), /VTKHDF/PointData/<name>,
/VTKHDF/FieldData/TimeValue and Step. In 2D the third component is zero. Attributes of the root: case (JSON), method,
versions and so on. After the HDF5 part there is a digest (parisph.io.digest).
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Protocol

import h5py
import numpy as np

from parisph.base.arrays import Floats
from parisph.base.communicator import Communicator
from parisph.base.errors import StoreError
from parisph.base.fields import FIELDS
from parisph.base.log import logger
from parisph.base.paths import AnyPath
from parisph.io import digest, slabs
from parisph.io.files import read_json, write_json
from parisph.io.slabs import Slab
from parisph.io.views import Snapshot
from parisph.io.wall_cells import WallCells, cells

# Names in the file, where they differ from those of the registry.
NAMES = {"u": "velocity", "p": "pressure", "alpha": "density_ratio", "phi": "position_potential"}
ALWAYS = ("id", "kind", "role")

class Written(Protocol):
    """This rank's rows of a snapshot: Particles, or a copy of their fields.

    It has the fields as attributes, and dim; n_owned, offset : number of rows of this rank, and its first; n_global
    """

    def __getattr__(self, name: str) -> Any:
        """Return the rows of a field, or a number."""


def write(comm: Communicator, path: Path, particles: Written, time: float, step: int, fields: Iterable[str],
          attributes: Mapping[str, str | float], walls: WallCells | None = None) -> None:
    """Write the particles of all ranks to the file `path`. Collective.

    time [s], step : of the particles
    fields : names in the field registry; id, kind and role are always written
    attributes : of the root of the file
    walls : triangles between the nodes of walls, the same on all ranks; None for none

    Raises StoreError on every rank: an unknown field, or the disk fails.
    """
    start, total = particles.offset, particles.n_global
    names = check_fields(fields)
    found, triangles = cells(comm, particles.id, start, total, walls)
    arrays = [Slab("VTKHDF/Points", _three(particles.x), start, total, {"unit": "m"}), *found]
    for name in names:
        field = FIELDS[name]
        data = getattr(particles, name)
        data = _three(data) if field.shape == "vector" else data
        about = {"unit": field.unit, "meaning": field.meaning}
        arrays.append(Slab(f"VTKHDF/PointData/{NAMES.get(name, name)}", data, start, total, about))
    root = {**attributes, "dim": particles.dim, "ranks": comm.size}
    slabs.write(comm, path, arrays, lambda file: _decorate(file, total, triangles, time, step, root))


def read(path: AnyPath, time: float | None = None, run: str = "", early: bool = False) -> Snapshot:
    """Return the particles of a snapshot as a dict of arrays, by the names of the field registry.

    x (n, dim) [m], id, kind, role, all other fields in the file, as u (n, dim) [m/s] and p (n,) [Pa], and `time` [s],
    `step`. Rows are sorted by id, so that a row is the same particle in every snapshot. Not collective.

    time [s], run : expected time and identity of the run; None and "" accept any
    early : whether the run has no identity, and its files perhaps no digest (io.digest)

    Raises StoreError: the file does not match its digest, is not a snapshot, or not the expected one.
    """
    registry = {NAMES.get(name, name): name for name in FIELDS}
    with _opened(path, time, run, early) as file:
        found, step, dim = float(file.attrs["time"]), int(file.attrs["step"]), int(file.attrs["dim"])
        group = file["VTKHDF"]
        arrays = {registry.get(name, name): data[()] for name, data in group["PointData"].items()}
        arrays["x"] = group["Points"][()]
        order = np.argsort(arrays["id"], kind="stable")
    arrays = {name: data[order, :dim] if data.ndim == 2 else data[order] for name, data in arrays.items()}
    return Snapshot({"time": found, "step": step, **arrays})


def read_attributes(path: AnyPath, time: float | None = None, run: str = "", early: bool = False) -> dict[str, Any]:
    """Return the attributes at the root of a snapshot or checkpoint as a dict. Parameters and errors as of `read`."""
    with _opened(path, time, run, early) as file:
        return {name: value.item() if hasattr(value, "item") else value for name, value in file.attrs.items()}


@contextmanager
def _opened(path: AnyPath, time: float | None, run: str, early: bool) -> Iterator[h5py.File]:
    """Open a snapshot as h5py.File after a check of its digest. Raises StoreError, also if the block lacks an entry."""
    path = Path(path)
    digest.check(path, early)
    try:
        with h5py.File(path, "r") as file:
            _check_expected(path, file.attrs, time, run)
            if early and file.attrs.get("run"):
                digest.check(path)    # files of a run with an identity have one
            yield file
    except (OSError, KeyError, ValueError) as error:
        raise StoreError(f"{path} is not a snapshot of parisph: {error}") from None


def _check_expected(path: AnyPath, attributes: Mapping[str, Any], time: float | None, run: str) -> None:
    """Raise StoreError if a sound file is not of the expected time and run; KeyError if it has no time."""
    if run and attributes.get("run", "") != run:
        raise StoreError(f"{path} is of another run than its folder: it has been copied there")
    if time is not None and (found := float(attributes["time"])) != time:
        raise StoreError(f"{path} is the snapshot of {found:.12g} s, not of {time:.12g} s: "
                         "another snapshot has been copied over it")


def write_index(path: Path, files: Sequence[str], times: Sequence[float], run: str = "") -> None:
    """Write the list of a run's snapshots, which ParaView opens as a series. One rank. Raises OSError."""
    entries = [{"name": name, "time": time} for name, time in zip(files, times)]
    write_json(path, {"file-series-version": "1.0", "run": run, "files": entries})


def listed(path: Path, run: str = "") -> dict[str, float] | None:
    """Return {file name relative to the index: time [s]} of an index; None without a readable one of this run.

    The index is made for ParaView, and saves time here; the snapshots decide. Not collective.
    """
    try:
        content = read_json(path, needs_digest=True)
        entries = {str(entry["name"]): float(entry["time"]) for entry in content["files"]}
    except (StoreError, KeyError, TypeError, ValueError):
        return None
    return entries if content.get("run", "") == run else None


def run_of_index(path: Path) -> str | None:
    """Return the identity of the run of an index, None without a readable index. Not collective."""
    try:
        return str(read_json(path).get("run", ""))
    except StoreError:
        return None


def find(folder: Path, run: str = "") -> dict[str, float]:
    """Return {file name relative to the folder of a run: time [s]} from its own snapshots. Not collective."""
    found = {}
    for path in sorted((folder / "snapshots").glob("*.vtkhdf")):
        time = time_of_own(path, run)
        if time is not None:
            found[f"snapshots/{path.name}"] = time
    return dict(sorted(found.items(), key=lambda item: item[1]))


def time_of_own(path: Path, run: str) -> float | None:
    """Return the time [s] of a snapshot, None if it is damaged (with a warning), a link, or of another run."""
    if path.is_symlink() or not path.is_file():
        return None
    try:
        about = read_attributes(path, early=not run)
    except StoreError as error:
        logger.warning(f"{error}; it is left out")
        return None
    return float(about["time"]) if about.get("run", "") == run and "time" in about else None


def check_fields(fields: Iterable[str]) -> list[str]:
    """Return the names of the arrays in a snapshot of `fields`, without the positions.

    Raises StoreError for a field that is not in the registry, or not for snapshots.
    """
    known = [name for name, field in FIELDS.items() if field.written and name != "x"]
    unknown = [name for name in fields if name not in known and name != "x"]
    if unknown:
        raise StoreError(f"no field {unknown[0]!r} for snapshots (there are: {', '.join(known)})")
    return [name for name in dict.fromkeys((*ALWAYS, *fields)) if name != "x"]


def _three(vectors: Floats) -> Floats:
    """Return vectors (n, 3), the only number of components that VTK allows."""
    if vectors.shape[1] == 3:
        return vectors
    padded = np.zeros((len(vectors), 3))
    padded[:, : vectors.shape[1]] = vectors
    return padded


def _decorate(file: h5py.File, total: int, triangles: int, time: float, step: int,
              attributes: Mapping[str, Any]) -> None:
    file.attrs.update({**attributes, "time": float(time), "step": int(step)})
    group = file.create_group("VTKHDF")
    group.attrs["Version"] = np.array([1, 0], dtype=np.int64)
    # VTK asks for an ASCII string of fixed length here.
    group.attrs.create("Type", b"UnstructuredGrid", dtype=h5py.string_dtype("ascii", len("UnstructuredGrid")))
    for name, number in (("NumberOfPoints", total), ("NumberOfCells", total + triangles),
                         ("NumberOfConnectivityIds", total + 3 * triangles)):    # one entry for each piece
        group[name] = np.array([number], dtype=np.int64)
    group["FieldData/TimeValue"] = np.array([time], dtype=np.float64)
    group["FieldData/Step"] = np.array([step], dtype=np.int64)
