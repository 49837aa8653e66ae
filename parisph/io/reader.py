"""Read a run: `run = open_run(DIR)`, then fields and probes as numpy arrays. Needs no MPI."""

import json
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from parisph.base.errors import CaseError, StoreError
from parisph.base.json_digest import MADE
from parisph.base.log import logger
from parisph.base.paths import AnyPath
from parisph.base.text import named, plain, shown
from parisph.case import stored
from parisph.case.schema import Case
from parisph.io import room_file, series, snapshot
from parisph.io.files import read_json
from parisph.io.folder import check_unchanged
from parisph.io.folder import summary as summary_of
from parisph.io.layout import INDEX, PEAKS
from parisph.io.views import Snapshot, Table, rows_as_html

FEW = 5    # most damaged files that an error names


class Run:
    """A finished or running run, read from its folder. Made by `open_run`.

    Every method raises StoreError for files that cannot be read, and CaseError for an unknown probe.

    case : the resolved case as in case.json; scene : the same as a Case, which cannot be run
    identity : of the run, which is in all its files; times : (n,) [s], of the snapshots
    """

    def __init__(self, folder: AnyPath) -> None:
        self.folder = Path(folder)
        if not self.folder.exists():
            raise StoreError(f"there is no folder {folder}")
        if not (self.folder / "case.json").exists():
            raise StoreError(f"{folder} is not the folder of a run: it has no case.json")
        self.case, self.scene = _case(self.folder / "case.json")
        room_file.remember(self.folder, self.scene)
        self.identity = str(self.case.get("run", ""))
        found = snapshot.listed(self.folder / INDEX, self.identity)
        if found is None:    # without an index of this run, read the snapshots themselves
            found = snapshot.find(self.folder, self.identity)
            if not found and snapshot.run_of_index(self.folder / INDEX) not in (None, self.identity):
                raise StoreError(f"{self.folder / 'case.json'} is of another run than the snapshots beside it")
        self._files, self.times = list(found), np.array(list(found.values()))
        self.probe_names = sorted(path.stem for path in (self.folder / "probes").glob("*.csv"))

    @property
    def summary(self) -> dict[str, Any] | None:
        """The content of summary.json; None while the run goes on, or if it was killed."""
        # early runs have neither schema nor digest
        path, whole = self.folder / "summary.json", "schema" in self.case
        if not path.exists():
            return None
        content = read_json(path, needs_digest=whole)
        if content.pop("run", None if whole else self.identity) != self.identity:
            raise StoreError(f"{path} is of another run")
        content.pop("files", None)    # digests, for reading the time series
        return content

    def __len__(self) -> int:
        """Number of snapshots."""
        return len(self.times)

    def __repr__(self) -> str:
        rows = {name.lower(): text for name, text in self._rows()}
        title = rows.pop("title", "")    # an edited case.json may have none
        return plain(f"<run {self.folder}: {title!r}, {', '.join(f'{name} {text}' for name, text in rows.items())}>")

    def _repr_html_(self) -> str:
        return rows_as_html(str(self.folder), [], self._rows())

    def _rows(self) -> list[tuple[str, str]]:
        """Return a short description of the run as (name, text)."""
        try:
            found = self.summary
        except StoreError:
            found = {"status": "unknown, as summary.json is damaged"}
        times = f", t = {self.times[0]:.6g} to {self.times[-1]:.6g} s" if len(self) else ""
        rows = [("Title", str(self.case.get("title", ""))),
                ("Status", str((found or {}).get("status", "")) or "goes on, or was killed"),
                ("Particles", str((found or {}).get("particles", ""))), ("Snapshots", f"{len(self)}{times}"),
                ("Probes", ", ".join(self.probe_names) or "none")]
        return [(name, text) for name, text in rows if text]

    def snapshot(self, which: int | float = -1) -> Snapshot:
        """Return the particles of a snapshot, see snapshot.read.

        which : its number (int; negative from the end), or a time [s] (float), of which the nearest snapshot is taken
        """
        number = self.number(which)
        return snapshot.read(self.folder / self._files[number], self.times[number], self.identity, self._early)

    def peak(self, name: str) -> Snapshot | None:
        """Return the particles at the greatest value of a probe, as from `snapshot`, with that value as `peak`.

        None if the run has not kept them. It keeps those of a probe with peak=True.
        """
        self._probe_path(name)
        path = self.folder / PEAKS / f"{name}.vtkhdf"
        if not path.exists():
            return None
        found = snapshot.read(path, run=self.identity, early=self._early)
        return Snapshot({**found, "peak": self._value_at_peak(path)})

    @property
    def made(self) -> dict[str, Any]:
        """How the run was made: case file, parameters, date, machine, command; empty for runs of older releases."""
        found = self.case.get(MADE)
        return found if isinstance(found, dict) else {}

    @property
    def missing(self) -> list[Path]:
        """The missing files of snapshots that the index lists."""
        return [path for path in self._paths if not path.exists()]

    def check(self) -> None:
        """Read every snapshot and peak once. Raises StoreError, which names a few damaged, missing or foreign ones."""
        checks: list[Callable[[], object]] = [
            partial(snapshot.read_attributes, path, time, self.identity, self._early)
            for path, time in zip(self._paths, self.times)]
        peaks = [self.folder / PEAKS / f"{name}.vtkhdf" for name in self.probe_names]
        checks += [partial(self._value_at_peak, path) for path in peaks if path.exists()]
        faults = []
        for one in checks:
            try:
                one()
            except StoreError as error:
                faults.append(str(error))
        if faults:
            raise StoreError(_some(faults))

    def number(self, which: int | float) -> int:
        """Return the number of a snapshot given by number (int) or time (float)."""
        if len(self) == 0:
            raise StoreError(f"{self.folder} has no snapshots")
        if isinstance(which, (int, np.integer)):
            if not -len(self) <= which < len(self):
                raise StoreError(f"{self.folder} has {len(self)} snapshots, there is no number {which}")
            return int(which) % len(self)
        return int(np.argmin(np.abs(self.times - which)))

    def probe(self, name: str) -> Table:
        """Return a probe's series as a structured array with columns time [s], step and the probe's own."""
        return self._series(self._probe_path(name))

    def units(self, name: str) -> dict[str, str]:
        """Return {column: unit} of a probe."""
        return self._units(self._probe_path(name))

    def _units(self, path: Path) -> dict[str, str]:
        try:
            return series.units(path)
        except (OSError, UnicodeDecodeError) as error:
            raise StoreError(f"cannot read {path}: {getattr(error, 'strerror', None) or 'it is not text'}") from None

    @property
    def steps(self) -> Table:
        """One line per step as a structured array: time, step, dt, iterations, ... (see steps.csv), as of a probe."""
        return self._series(self.folder / "steps.csv", each_step=True)

    @property
    def about(self) -> dict[str, Any]:
        """How the run was made: dict of versions, method, PETSc options, ranks, from its first snapshot."""
        if len(self) == 0:
            return {}
        found = snapshot.read_attributes(self.folder / self._files[0], early=self._early)
        return {name: value for name, value in found.items() if name not in ("case", "time", "step", "dim")}

    @property
    def _early(self) -> bool:
        """Whether the run has no identity, and its files no digests."""
        return not self.identity

    @property
    def _paths(self) -> list[Path]:
        return [self.folder / name for name in self._files]

    def _value_at_peak(self, path: Path) -> float:
        """Return the value of the probe at whose peak a file was written."""
        about = snapshot.read_attributes(path, run=self.identity, early=self._early)
        if about.get("probe") != path.stem:
            raise StoreError(f"{path} is not the flow at the peak of {path.stem}: another file has been copied over it")
        return float(about["peak"])

    def _series(self, path: Path, each_step: bool = False) -> Table:
        found = series.table(*series.read_own(path, self.identity, each_step))
        check_unchanged(path, summary_of(self.folder), str(path.relative_to(self.folder)))    # the least precise check
        return Table.of(found, path.stem, self._units(path))

    def _probe_path(self, name: str) -> Path:
        if name not in self.probe_names:
            raise CaseError(f"{self.folder} has no probe {shown(name)} (it has: "
                            f"{named(', '.join(self.probe_names)) or 'none'})")
        return self.folder / "probes" / f"{name}.csv"


def _case(path: Path) -> tuple[dict[str, Any], Case]:
    """Return the content of case.json, and the Case that it describes. Raises StoreError if it is not a case."""
    content = read_json(path)
    try:
        return content, stored.from_json(json.dumps(content), read_only=True)
    except CaseError as error:
        raise StoreError(f"{path} is damaged, or is not the case of a run: "
                         f"{str(error).splitlines()[0][:200]}") from None


def open_run(folder: AnyPath) -> Run:
    """Return the Run in `folder`; log a warning if snapshots are missing. Raises StoreError if there is no run."""
    run = Run(folder)
    if run.missing:
        logger.warning(f"{run.folder} lacks {len(run.missing)} of its {len(run)} snapshots; "
                       f"the first is {run.missing[0]}")
    return run


def _some(faults: Sequence[str]) -> str:
    """Return a few messages, one per line, and the number of the others."""
    return "\n".join([*faults[:FEW], *([f"and {len(faults) - FEW} more files"] if len(faults) > FEW else [])])
