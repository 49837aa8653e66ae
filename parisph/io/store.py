"""The writer of one run's folder (parisph.io.layout says what stands in it)."""

import json
import shutil
from importlib import metadata
from pathlib import Path

import h5py

import parisph
from parisph.base.errors import StoreError
from parisph.io import checkpoint, snapshot
from parisph.io.files import on_first, write_json, write_text
from parisph.io.layout import FILES, FOLDERS, INDEX
from parisph.io.series import Series


class Store:
    """Writes the folder of one run. All methods are collective unless they say otherwise.

    Made by `Store.create` or `Store.resume`. A failing disk raises StoreError on every rank.

    Attributes
    ----------
    folder : pathlib.Path
    about : dict of str -> str or number, how the run is made; of files that are still to be written
    times : times [s] of the snapshots written so far (known on rank 0 only)
    """

    def __init__(self, comm, folder, case, about, fields):
        self.comm, self.folder = comm, Path(folder)
        self.times = []
        snapshot.check_fields(fields)
        self._case, self._fields = case, tuple(fields)
        self.about = {**about, "case": case}
        self._names, self._series, self._keep_to = [], {}, None

    @classmethod
    def create(cls, comm, folder, case, about=None, fields=("u", "p", "role"), overwrite=False):
        """Start a run in `folder`. Collective.

        Parameters
        ----------
        comm : mpi4py communicator
        folder : made if it is not there
        case : the resolved case as JSON text
        about : dict of str -> str or number, how the run is made (see `provenance`)
        fields : names in the field registry for snapshots; id, kind and role are always written
        overwrite : whether an earlier run in the folder is removed; nothing else in it is touched

        Raises
        ------
        StoreError on every rank: an unknown field, an earlier run is there, or the folder cannot be written.
        """
        store = cls(comm, folder, case, about or {}, fields)
        on_first(comm, f"start a run in {folder}", lambda: store._start(overwrite))
        return store

    @classmethod
    def resume(cls, comm, folder, case, time, step, about=None, fields=("u", "p", "role")):
        """Go on writing a run from a checkpoint at `time` [s] and `step`. Collective.

        What the folder holds of later times is removed: snapshots, checkpoints, the summary, and
        the lines of time series (when `add_series` opens them). An empty folder is as good.
        Parameters and errors as of `create`.
        """
        store = cls(comm, folder, case, about or {}, fields)
        store._keep_to = step
        on_first(comm, f"resume a run in {folder}", lambda: store._continue(time, step))
        return store

    def add_series(self, name, columns, title=""):
        """Open the time series DIR/<name>.csv ("steps", "probes/P2", ...).

        columns : dict of column name -> unit ("" for none); time [s] and step come first by themselves.
        """
        def add():
            path = self.folder / f"{name}.csv"
            path.parent.mkdir(exist_ok=True)
            self._series[name] = Series(path, columns, title, self._keep_to)
        on_first(self.comm, f"write {self.folder / name}.csv", add)

    def append(self, time, step, values):
        """Add a line to time series: values = {name: sequence of the further columns' values}.

        Rank 0's values are written; the other ranks may pass None.
        """
        def add():
            for name, line in values.items():
                self._series[name].append(time, step, line)
        on_first(self.comm, f"write time series in {self.folder}", add)

    def snapshot(self, particles, time, step):
        """Write the particles at `time` [s]; a snapshot of the same time is replaced."""
        number = self.comm.bcast(len(self.times) - (self.times[-1:] == [time]) if self.comm.rank == 0 else None)
        name = f"snapshots/{number:06d}.vtkhdf"
        snapshot.write(self.comm, self.folder / name, particles, time, step, self._fields, self.about)

        def enter():
            self._names[number:], self.times[number:] = [name], [time]
            snapshot.write_index(self.folder / INDEX, self._names, self.times)
        on_first(self.comm, f"write {self.folder / INDEX}", enter)

    def checkpoint(self, particles, time, step, dt, state):
        """Write a checkpoint and return its path; the last two are kept. See checkpoint.write."""
        return checkpoint.write(self.comm, self.folder / "checkpoints", particles, time, step, dt, self._case, state, self.about)

    def summary(self, content):
        """Write summary.json from rank 0's dict (numpy numbers become plain, NaN null)."""
        on_first(self.comm, f"write {self.folder}/summary.json", lambda: write_json(self.folder / "summary.json", content))

    def close(self):
        """Close the time series."""
        def close():
            for series in self._series.values():
                series.close()
            self._series.clear()
        on_first(self.comm, f"close time series in {self.folder}", close)

    def _start(self, overwrite):
        if (self.folder / "case.json").exists():
            if not overwrite:
                raise StoreError(f"{self.folder} holds a run already: choose another folder, or ask to overwrite it")
            _remove_run(self.folder)
        self._make_folders()

    def _continue(self, time, step):
        _check_same_run(self.folder / "case.json", json.loads(self._case))
        self._make_folders()
        names, times = snapshot.read_index(self.folder / INDEX)
        kept = [(name, at) for name, at in zip(names, times) if at <= time]
        self._names, self.times = [name for name, _ in kept], [at for _, at in kept]
        if len(kept) < len(names):  # shorten the list before the files go, so that it never names a missing one
            snapshot.write_index(self.folder / INDEX, self._names, self.times)
        listed = {self.folder / name for name in self._names}
        for path in (self.folder / "snapshots").iterdir():
            if path not in listed:
                path.unlink()
        for path in checkpoint.paths(self.folder / "checkpoints"):
            if int(path.stem) > step:
                path.unlink()
        (self.folder / "summary.json").unlink(missing_ok=True)

    def _make_folders(self):
        for name in FOLDERS:
            (self.folder / name).mkdir(parents=True, exist_ok=True)
        for folder in (self.folder, *(self.folder / name for name in FOLDERS)):
            for path in folder.glob(".*.tmp*"):  # left by a run that was killed; MPI puts its own name behind ours
                path.unlink()
        write_text(self.folder / "case.json", json.dumps(json.loads(self._case), indent=2) + "\n")


def provenance(method="", petsc_options="", **versions):
    """Return how a run is made, for the attributes of its files. Not collective.

    method : name; petsc_options : those in force, as text; versions : of libraries that this
    module does not know (petsc, hypre, mpi), e.g. petsc="3.18.5".
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


def _check_same_run(path, case):
    """Raise StoreError if `path` is the case of another scene: resuming would remove parts of it."""
    if not path.exists():
        return
    there = json.loads(path.read_text(encoding="utf-8"))
    if any(there.get(part) != case.get(part) for part in ("title", "fluid", "walls")):
        raise StoreError(f"{path.parent} holds a run of another case ({there.get('title')!r}): choose another folder")


def _remove_run(folder):
    """Remove the files of an earlier run, by name; what else stands in the folder stays."""
    for name in FILES:
        (folder / name).unlink(missing_ok=True)
    for name in FOLDERS:
        if (folder / name).is_dir():
            shutil.rmtree(folder / name)
