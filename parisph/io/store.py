"""The writer of a run's folder (parisph.io.layout lists its files)."""

import json
import logging
import math
import os
from collections.abc import Mapping, Sequence
from importlib import metadata
from pathlib import Path
from typing import Any

import h5py

import parisph
from parisph.base.communicator import Communicator
from parisph.base.errors import CaseError, StoreError
from parisph.base.log import logger
from parisph.base.paths import AnyPath
from parisph.io import checkpoint, snapshot
from parisph.io import folder as folders
from parisph.io.files import on_first, write_json
from parisph.io.layout import BEFORE, INDEX, PEAKS
from parisph.io.lock import Lock
from parisph.io.series import SeriesFile, read_own, units
from parisph.io.snapshot import Written
from parisph.io.wall_cells import WallCells
from parisph.parallel.particles import Particles


class Store:
    """Writes the folder of one run. All methods are collective unless stated otherwise.

    Made by `Store.create` or `Store.resume`. Disk errors raise StoreError on every rank.

    run : identity of the run, which is written to all its files
    about : how the run is made; written to all later files
    times : [s], of the snapshots written so far (on rank 0 only)
    walls : triangles of the walls for snapshots (io.wall_cells), None for none
    notes : (level of the log, text) of changes to the folder before the run continues, for the log of rank 0
    """

    def __init__(self, comm: Communicator, folder: AnyPath, case: str, about: Mapping[str, str | float],
                 fields: Sequence[str], lock: Lock | None = None) -> None:
        self.comm, self.folder, self.lock = comm, Path(folder), lock
        self.times: list[float] = []
        self.walls: WallCells | None = None
        self.notes: list[tuple[int, str]] = []
        snapshot.check_fields(fields)
        self._fields = tuple(fields)
        self._names: list[str] = []
        self._checkpoints: list[str] = []
        self._series: dict[str, SeriesFile] = {}
        self._keep_to: int | None = None
        self._here = False
        self.about = dict(about)
        self._set_run(case, comm.bcast(os.urandom(8).hex() if comm.rank == 0 else None))

    @classmethod
    def create(cls, comm: Communicator, folder: AnyPath, case: str, about: Mapping[str, str | float] | None = None,
               fields: Sequence[str] = ("u", "p", "role"), lock: Lock | None = None) -> "Store":
        """Start a run in `folder`. Collective.

        folder : created if it does not exist
        case : the resolved case as JSON text; about : how the run is made (see `provenance`)
        fields : of snapshots; id, kind and role are always written
        lock : io.lock.Lock on rank 0, which is renewed while the run goes on; None for none

        Raises StoreError on every rank: a field is unknown, the folder holds a run, or cannot be written.
        """
        store = cls(comm, folder, case, about or {}, fields, lock)
        on_first(comm, f"start a run in {folder}", store._start)
        return store

    @classmethod
    def resume(cls, comm: Communicator, folder: AnyPath, case: str, time: float, step: int,
               about: Mapping[str, str | float] | None = None, fields: Sequence[str] = ("u", "p", "role"),
               lock: Lock | None = None, run: str | None = None, series: Sequence[str] = (),
               checkpoints: Sequence[str] = ()) -> "Store":
        """Continue to write a run from a checkpoint at `time` [s] and `step`. Collective.

        In the folder of the same run, files from after the checkpoint are moved to replaced/N: snapshots, peaks,
        checkpoints, the summary, and copies of the time series, which `add_series` cuts back to `step`. A missing
        case.json is written again. Nothing else is changed. In an empty folder a new run begins at the checkpoint.

        run : identity of the checkpoint's run, by default that in `case`
        series : names of the time series that will be added; they are checked before any change
        checkpoints : file names of the run's checkpoints, listed in the state of the last; unused in an empty folder
        Other parameters as for `create`.

        Raises StoreError on every rank: as for `create`, a file is damaged, or the folder holds another run.
        """
        store = cls(comm, folder, case, about or {}, fields, lock)
        store._keep_to = step
        run = json.loads(case).get("run", "") if run is None else run
        on_first(comm, f"resume a run in {folder}", lambda: store._continue(run, time, step, series))
        store._set_run(case, comm.bcast(store.run))
        store._checkpoints = comm.bcast(list(checkpoints) if store._here else [])
        on_first(comm, f"write {folder}/case.json", lambda: folders.write_case(store.folder, store._case, store.run))
        return store

    def add_series(self, name: str, columns: Mapping[str, str], title: str = "", until: float = math.inf) -> None:
        """Open the time series DIR/<name>.csv ("steps", "probes/P2", ...).

        columns : {name: unit, "" for none}; the columns time [s] and step are added in front
        until : in a resumed run, last time [s] of lines that are kept
        """
        def add() -> None:
            path = self.folder / f"{name}.csv"
            path.parent.mkdir(exist_ok=True)
            self._keep_columns(path, columns)
            self._series[name] = SeriesFile(path, columns, f"{title}{self._missing(path)}", self._keep_to, self.run,
                                        until)
        on_first(self.comm, f"write {self.folder / name}.csv", add)

    def append(self, time: float, step: int, values: Mapping[str, Sequence[Any]] | None) -> None:
        """Add a line to time series. Raises StoreError if this run has lost the lock of the folder.

        values : {name: values of the further columns}, of rank 0; others may pass None
        """
        self.append_all([(time, step, values)])

    def append_all(self, lines: Sequence[tuple[float, int, Mapping[str, Sequence[Any]] | None]]) -> None:
        """Do `append` for several (time, step, values), with one message between the ranks."""
        def add() -> None:
            if self.lock is not None:
                self.lock.check()
            for time, step, values in lines:
                for name, line in (values or {}).items():
                    self._series[name].append(time, step, line)
        on_first(self.comm, f"write time series in {self.folder}", add)

    def snapshot(self, particles: Particles, time: float, step: int) -> None:
        """Write the particles at `time` [s]; a snapshot of the same time is replaced."""
        name = self.comm.bcast(self._next_name(time) if self.comm.rank == 0 else None)
        snapshot.write(self.comm, self.folder / name, particles, time, step, self._fields, self.about, self.walls)

        def enter() -> None:
            if self.times[-1:] == [time]:
                self._names.pop(), self.times.pop()
            self._names.append(name)
            self.times.append(time)
            snapshot.write_index(self.folder / INDEX, self._names, self.times, self.run)
        on_first(self.comm, f"write {self.folder / INDEX}", enter)

    def peak(self, particles: Written, time: float, step: int, name: str, value: float, keep: bool) -> None:
        """Write the particles at the greatest value of a probe; the file of an earlier peak is replaced.

        name, value : of the probe, at `time` [s]
        keep : whether the earlier file becomes peaks/before/NAME.vtkhdf, because a restart from the last checkpoint
            needs it
        """
        path = self.folder / PEAKS / f"{name}.vtkhdf"

        def make_room() -> None:
            folders.make_inside(path.parent)
            if keep and path.exists():
                folders.make_inside(self.folder / BEFORE)
                os.replace(path, self.folder / BEFORE / path.name)
        on_first(self.comm, f"write {path}", make_room)
        snapshot.write(self.comm, path, particles, time, step, self._fields,
                       {**self.about, "probe": name, "peak": float(value)}, self.walls)

    def checkpoint(self, particles: Particles, time: float, step: int, dt: float, state: Mapping[str, Any],
                   flows: Sequence[checkpoint.EarlierFlow] = ()) -> Path:
        """Write a checkpoint and return its path; the last two are kept. See checkpoint.write."""
        path = checkpoint.write(self.comm, self.folder / "checkpoints", particles, time, step, dt, self._case,
                                state, self.about, self._checkpoints, flows)
        self._checkpoints = [*(name for name in self._checkpoints if name != path.name), path.name][-checkpoint.KEEP:]
        return path

    def summary(self, content: Mapping[str, Any]) -> None:
        """Write summary.json from the dict of rank 0 (files.write_json), with the digests of the time series."""
        def write() -> None:
            files = folders.digests(self.folder, [f"{name}.csv" for name in self._series])
            write_json(self.folder / "summary.json", {"run": self.run, **content, "files": files})
        on_first(self.comm, f"write {self.folder}/summary.json", write)

    def close(self) -> None:
        """Close the time series."""
        def close() -> None:
            while self._series:
                self._series.popitem()[1].close()
        on_first(self.comm, f"close time series in {self.folder}", close)

    def _set_run(self, case: str, run: str) -> None:
        """Set the identity of the run, and the case that is written to its files."""
        self.run = run
        self._case = json.dumps({"run": run,
                                 **{name: value for name, value in json.loads(case).items() if name != "run"}})
        self.about.update(case=self._case, run=run)

    def _start(self) -> None:
        try:
            folders.check_free(self.folder)
        except CaseError as error:
            raise StoreError(str(error)) from None
        folders.prepare(self.folder)
        folders.write_case(self.folder, self._case, self.run)

    def _continue(self, run: str, time: float, step: int, series: Sequence[str]) -> None:
        """Continue in the folder of the run, or begin in an empty one."""
        there = folders.identity(self.folder)
        if there is None and not folders.content(self.folder):
            self._start()
            return
        if there not in (None, run):
            raise StoreError(f"{self.folder} holds another run: choose another folder with -o")
        self.run, self._here = run, True
        cut = [path for path in (self.folder / f"{name}.csv" for name in series)
               if path.exists() and _last_step(path, run) > step]
        summary = folders.summary(self.folder)
        for name in series:
            folders.check_unchanged(self.folder / f"{name}.csv", summary, f"{name}.csv")
        folders.prepare(self.folder, series)
        late = [*self._take_stock(time), *self._late_peaks(time)]
        late += [path for path in checkpoint.paths(self.folder / "checkpoints") if int(path.stem) > step]
        late.append(self.folder / "summary.json")
        results = [path for path in (*late[:-1], *cut) if path.exists()]
        snapshot.write_index(self.folder / INDEX, self._names, self.times, run)    # before files that it names move
        ended, case = late[-1].exists(), [self.folder / "case.json"] * folders.is_edited(self.folder)
        aside = folders.move_aside(self.folder, late, copied=[*cut, *case])
        self._put_peaks_back(time)
        self._note(there is None, step, aside, bool(results), ended, bool(case))

    def _note(self, without_case: bool, step: int, aside: Path | None, results: bool, ended: bool,
              edited: bool) -> None:
        """Note missing files, and the folder of the moved results.

        results, ended : whether there are results after the checkpoint, and whether there was a summary
        edited : whether a copy of case.json is kept
        """
        if without_case:
            self.notes.append((logging.WARNING,
                               f"{self.folder / 'case.json'} is missing: it is written again from the checkpoint"))
        if step < 0:
            self.notes.append((logging.WARNING, f"no checkpoint found in {self.folder / 'checkpoints'}: "
                                                "the run begins again at t = 0 s"))
        if edited:
            self.notes.append((logging.INFO, f"{self.folder / 'case.json'} has no digest, as after an edit: it is "
                                             f"written again, and a copy is in {aside}"))
        if results or ended:
            self.notes.append((logging.INFO, f"results that are computed again were moved to {aside}" if results else
                               f"only the earlier summary was moved to {aside}; no other result is replaced"))

    def _take_stock(self, time: float) -> list[Path]:
        """Find the run's snapshots up to `time` [s], and return the later ones.

        The snapshots decide; the index only saves time. Unreadable files and files of other runs stay.
        """
        listed = snapshot.listed(self.folder / INDEX, self.run) or {}
        kept: list[tuple[float, str]] = []
        late: list[tuple[float, str]] = []
        for path in sorted((self.folder / "snapshots").glob("*.vtkhdf")):
            name = f"snapshots/{path.name}"
            at = listed.get(name)
            # before a file is added or moved, read its own time
            if at is None or at > time or path.is_symlink():
                at = snapshot.time_of_own(path, self.run)
            if at is not None:
                (kept if at <= time else late).append((at, name))
        kept.sort()
        self._names, self.times = [name for _, name in kept], [at for at, _ in kept]
        return [self.folder / name for _, name in late]

    def _late_peaks(self, time: float) -> list[Path]:
        """Return the files of the run's peaks after `time` [s]."""
        paths = sorted((self.folder / PEAKS).glob("*.vtkhdf"))
        times = [snapshot.time_of_own(path, self.run) for path in paths]
        return [path for path, at in zip(paths, times) if at is not None and at > time]

    def _put_peaks_back(self, time: float) -> None:
        """Restore the peaks of the checkpoint of `time` [s] in place of later ones that were moved away."""
        for path in sorted((self.folder / BEFORE).glob("*.vtkhdf")):
            place, at = self.folder / PEAKS / path.name, snapshot.time_of_own(path, self.run)
            if at is not None and at <= time and not place.exists():
                os.replace(path, place)

    def _next_name(self, time: float) -> str:
        """Return the name of the next snapshot: a new one, or that of this run's snapshot of the same time."""
        if self.times[-1:] == [time]:
            return self._names[-1]
        numbers = [int(path.stem) for path in (self.folder / "snapshots").glob("*.vtkhdf") if path.stem.isdecimal()]
        return f"snapshots/{max(numbers, default=-1) + 1:06d}.vtkhdf"

    def _keep_columns(self, path: Path, columns: Mapping[str, str]) -> None:
        """Copy a time series of an older release if it has columns that a restart leaves out."""
        lost = [name for name in units(path) if name not in ("time", "step", *columns)] \
            if self._here and path.is_file() else []
        if lost:
            aside = folders.move_aside(self.folder, (), copied=[path])
            logger.info(f"{path} was written by an older parisph: it goes on without the column{'s' * (len(lost) > 1)} "
                        f"{', '.join(lost)[:200]}, and a copy with all is in {aside}")

    def _missing(self, path: Path) -> str:
        """Return a note on lost lines for the title of a time series; "" if none are lost."""
        if not self._here or not self._keep_to or self._keep_to < 0 or path.exists():
            return ""
        logger.warning(f"{path} is missing: it begins again after step {self._keep_to}, without the lines before")
        return f" (lines up to step {self._keep_to} are missing: there was no file at a restart)"


def _last_step(path: Path, run: str) -> int:
    """Return the last step in a time series of a run, -1 if it has no line. Raises StoreError if it is damaged."""
    _, lines = read_own(path, run, each_step=path.name == "steps.csv")
    return int(lines[-1][1]) if lines else -1


def provenance(method: str = "", petsc_options: str = "", **versions: str | None) -> dict[str, str]:
    """Return how a run is made, for the attributes of its files. Not collective.

    method : name; petsc_options : as text; versions : of libraries without Python metadata, as petsc="3.18.5"
    """
    found = {"hdf5": h5py.version.hdf5_version}
    for name in ("numpy", "numba", "h5py", "mpi4py", "petsc4py", "pydantic"):
        try:
            found[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            continue
    return {
        "parisph_version": parisph.__version__, "method": method, "petsc_options": petsc_options,
        "versions": json.dumps({**found, **versions}),
    }
