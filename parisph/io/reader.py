"""Read a run: `run = open_run(DIR)`, then fields and probes as numpy arrays. Needs no MPI."""

import json
import os
from pathlib import Path
from typing import Any

import numpy as np

from parisph.base.errors import CaseError, StoreError
from parisph.base.text import named, shown
from parisph.case import stored
from parisph.io import series, snapshot
from parisph.io.files import read_json
from parisph.io.folder import check_unchanged
from parisph.io.folder import summary as summary_of
from parisph.io.layout import INDEX, PEAKS


class Run:
    """A finished or running run, read from its folder. Made by `open_run`. Every method raises
    StoreError for files that cannot be read, and CaseError for an unknown probe.

    Attributes
    ----------
    folder : pathlib.Path
    case : dict, the resolved case
    identity : str, the identity of the run, which is in all its files
    times : (n,) times [s] of the snapshots
    probe_names : list of str
    """

    def __init__(self, folder: str | os.PathLike):
        self.folder = Path(folder)
        if not (self.folder / "case.json").exists():
            raise StoreError(f"{folder} is not the folder of a run: it has no case.json")
        self.case = _case(self.folder / "case.json")
        self.identity = str(self.case.get("run", ""))
        found = snapshot.listed(self.folder / INDEX, self.identity)
        if found is None:    # without an index of this run the files themselves say which snapshots there are
            found = snapshot.find(self.folder, self.identity)
            if not found and snapshot.run_of_index(self.folder / INDEX) not in (None, self.identity):
                raise StoreError(f"{self.folder / 'case.json'} is of another run than the snapshots beside it")
        self._files, self.times = list(found), np.array(list(found.values()))
        self.probe_names = sorted(path.stem for path in (self.folder / "probes").glob("*.csv"))

    @property
    def summary(self) -> dict | None:
        """The content of summary.json; None while the run goes on, or if it was killed."""
        path, sealed = self.folder / "summary.json", "schema" in self.case    # early runs have neither schema nor digest
        if not path.exists():
            return None
        content = read_json(path, must_be_sealed=sealed)
        if content.pop("run", None if sealed else self.identity) != self.identity:
            raise StoreError(f"{path} is of another run")
        content.pop("files", None)    # digests, for reading the time series
        return content

    def __len__(self) -> int:
        """Number of snapshots."""
        return len(self.times)

    def snapshot(self, which: int | float = -1) -> dict[str, Any]:
        """Return the particles of a snapshot, given by its number (int; negative from the end) or the nearest time [s] (float).

        dict of arrays by the names of the field registry: x (n, dim) [m], u [m/s], p [Pa], role, kind,
        id, ..., sorted by id; and `time` [s], `step`.
        """
        number = self.number(which)
        return snapshot.read(self.folder / self._files[number], self.times[number], str(self.case.get("run", "")))

    def peak(self, name: str) -> dict[str, Any] | None:
        """Return the particles at the greatest value of a probe, as from `snapshot`, with that value as `peak`.

        None if the run has not kept them, which needs a probe with peak=True.
        """
        self._probe_path(name)
        path = self.folder / PEAKS / f"{name}.vtkhdf"
        if not path.exists():
            return None
        found, about = snapshot.read(path, run=self.identity), snapshot.read_attributes(path)
        if about.get("probe") != name:
            raise StoreError(f"{path} is not the flow at the peak of {name}: another file has been copied over it")
        return {**found, "peak": float(about["peak"])}

    def number(self, which: int | float) -> int:
        """Return the number of a snapshot given by number (int) or time (float)."""
        if len(self) == 0:
            raise StoreError(f"{self.folder} has no snapshots")
        if isinstance(which, (int, np.integer)):
            if not -len(self) <= which < len(self):
                raise StoreError(f"{self.folder} has {len(self)} snapshots, there is no number {which}")
            return int(which) % len(self)
        return int(np.argmin(np.abs(self.times - which)))

    def probe(self, name: str) -> np.ndarray:
        """Return a probe's series as a structured array with columns time [s], step and the probe's own."""
        return self._series(self._probe_path(name))

    def units(self, name: str) -> dict[str, str]:
        """Return the unit of each column of a probe as a dict."""
        path = self._probe_path(name)
        try:
            return series.units(path)
        except (OSError, UnicodeDecodeError) as error:
            raise StoreError(f"cannot read {path}: {getattr(error, 'strerror', None) or 'it is not text'}") from None

    @property
    def steps(self) -> np.ndarray:
        """One line per step as a structured array: time, step, dt, iterations, ... (see steps.csv)."""
        return self._series(self.folder / "steps.csv", each_step=True)

    @property
    def about(self) -> dict[str, Any]:
        """How the run was made: dict of versions, method, PETSc options, ranks, from its first snapshot."""
        if len(self) == 0:
            return {}
        found = snapshot.read_attributes(self.folder / self._files[0])
        return {name: value for name, value in found.items() if name not in ("case", "time", "step", "dim")}

    def _series(self, path, each_step=False):
        found = series.table(*series.read_own(path, self.identity, each_step))
        check_unchanged(path, summary_of(self.folder), str(path.relative_to(self.folder)))    # last, as it says less
        return found

    def _probe_path(self, name):
        if name not in self.probe_names:
            raise CaseError(f"{self.folder} has no probe {shown(name)} (it has: {named(', '.join(self.probe_names)) or 'none'})")
        return self.folder / "probes" / f"{name}.csv"


def _case(path):
    """Return the content of case.json as a dict. Raises StoreError if it is not a case."""
    content = read_json(path)
    try:
        stored.from_json(json.dumps(content), read_only=True)
    except CaseError as error:
        raise StoreError(f"{path} is damaged, or is not the case of a run: {str(error).splitlines()[0][:200]}") from None
    return content


def open_run(folder: str | os.PathLike) -> Run:
    """Return the Run in `folder`, for notebooks and pictures. Raises StoreError if there is none."""
    return Run(folder)
