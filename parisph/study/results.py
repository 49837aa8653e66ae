"""The table of a study: one line for each run, as JSON and CSV."""

import csv
import io
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from parisph.base.errors import ParisphError, StoreError
from parisph.io.files import write_json, write_text
from parisph.io.reader import Run, open_run
from parisph.study import measures, measuring
from parisph.study.conduct import RUNS, End
from parisph.study.definition import Study
from parisph.study.measures import AnyMeasure
from parisph.study.plan import text
from parisph.study.prepared import Prepared, code_version


@dataclass
class Result:
    """What a run gave.

    Attributes
    ----------
    item, end : the run, and how it ended
    folder : of the run
    values : {column: number or None}: particles, steps, time [s], cpu_seconds (of all ranks together), wall_seconds,
        iterations (mean of a step), volume_low, volume_high, energy_end and energy_high (over their start)
    errors : {name of a measure: number or None}; problems : {name of a measure: why there is none}
    """

    item: Prepared
    end: End
    folder: Path
    values: dict[str, float | None] = field(default_factory=dict)
    errors: dict[str, float | None] = field(default_factory=dict)
    problems: dict[str, str] = field(default_factory=dict)

    @property
    def survived(self) -> bool:
        """Whether the run came to its end."""
        return self.end.status == "completed"

    @property
    def reason(self) -> str:
        """Why it did not, with the time that it reached; else which measures it lacks, and why."""
        if self.end.status != "completed":
            reached = self.values.get("time")
            return f"{self.end.reason}{f' (reached t = {reached:.4g} s)' if reached is not None else ''}"
        return "; ".join(f"{name}: {why}" for name, why in self.problems.items())

    def number(self, name: str) -> float | None:
        """Return a measure or a column by its name; `survived` is 1 or 0."""
        if name == "survived":
            return float(self.survived)
        return self.errors.get(name, self.values.get(name))

    def line(self) -> dict[str, Any]:
        """Return the line of the table as {column: value}."""
        point, numerics = self.item.point, self.item.case.numerics
        return {
            "label": point.label, "method": self.item.method,
            "spacing": self.item.spacing, "time_step": self.item.time_step,
            "parameters": " ".join(f"{name}={text(value)}" for name, value in point.further.items()),
            "seed": numerics.seed, "ranks": point.ranks,
            "spacing_m": numerics.spacing, "time_step_s": numerics.time_step,
            **{name: self.values.get(name) for name in COLUMNS}, **self.errors,
            "survived": self.survived, "reason": self.reason, "run": f"{RUNS}/{self.item.folder}",
        }


COLUMNS = ("particles", "steps", "time", "cpu_seconds", "wall_seconds", "iterations", "volume_low", "volume_high",
           "energy_end", "energy_high")


def result(item: Prepared, end: End, folder: Path, study: Study, place: Path) -> Result:
    """Return what a run gave, but for its difference from the finest run. Not collective.

    folder : of the study; place : folder of the study file
    """
    found = Result(item, end, folder / RUNS / item.folder)
    try:
        run = open_run(found.folder)
        found.values = _values(run, end)
    except ParisphError as error:
        found.problems["run"] = str(error)
        return found
    for measure in study.errors:
        if measure.kind != "finest":
            _measure(found, measure, run, place, None)
    return found


def add_finest(results: Iterable[Result], study: Study, place: Path) -> None:
    """Add the differences from the finest run of the same curve and seed."""
    results = [found for found in results if found.survived]
    for measure in (measure for measure in study.errors if measure.kind == "finest"):
        for found in results:
            family = [other for other in results if other.item.point.label == found.item.point.label]
            finest = min(family, key=lambda other: (
                other.item.spacing, other.item.time_step or 0.0, _seed(other) != _seed(found)))
            try:
                runs = open_run(found.folder), open_run(finest.folder)
            except StoreError as error:
                found.problems[measures.name_of(measure)] = str(error)
                continue
            _measure(found, measure, runs[0], place, runs[1])


def _seed(found: Result) -> int:
    return found.item.case.numerics.seed


def _measure(found: Result, measure: AnyMeasure, run: Run, place: Path, finest: Run | None) -> None:
    name = measures.name_of(measure)
    found.errors[name] = None
    if not found.survived:    # over another time than that of the others, an error cannot be compared with theirs
        return
    try:
        found.errors[name] = measuring.value(measure, run, place, finest)
    except ParisphError as error:
        found.problems[name] = str(error)


def _values(run: Run, end: End) -> dict[str, float | None]:
    summary = run.summary or {}
    found = {name: summary.get(name) for name in ("particles", "steps", "time", "cpu_seconds")}
    found["wall_seconds"] = summary.get("wall_seconds", end.wall)
    found["iterations"] = _iterations(run)
    volume, energy = summary.get("volume_range") or {}, summary.get("energy_range") or {}
    for name, change in (("volume_low", volume.get("low")), ("volume_high", volume.get("high")),
                         ("energy_end", summary.get("energy_drift")), ("energy_high", energy.get("high"))):
        found[name] = None if change is None else 1.0 + change
    if not summary:    # it was killed: what it has written says how far it came
        found["steps"], found["time"] = _reached(run)
    return found


def _iterations(run: Run) -> float | None:
    """Return the mean number of iterations of a step, of all its solves; None where a method solves nothing."""
    try:
        steps = run.steps
        counts = [steps[name] for name in ("iterations", "position_iterations") if name in (steps.dtype.names or ())]
        return float(np.mean(np.sum(counts, axis=0))) if counts and len(steps) else None
    except ParisphError:
        return None


def _reached(run: Run) -> tuple[int | None, float | None]:
    try:
        steps = run.steps
        return (int(steps["step"][-1]), float(steps["time"][-1])) if len(steps) else (None, None)
    except ParisphError:
        return None, None


def save(results: Sequence[Result], study: Study, folder: Path, missing: int) -> None:
    """Write results.json and results.csv of a study, each whole or not at all. Raises StoreError.

    missing : how many runs of the study have no result
    """
    lines = [found.line() for found in results]
    names = list(lines[0]) if lines else ["label"]
    for line in lines:    # a run of which nothing could be read has fewer
        names += [name for name in line if name not in names]
    out = io.StringIO()
    table = csv.DictWriter(out, names, lineterminator="\n")
    table.writeheader()
    table.writerows(lines)
    content = {"title": study.title, "case": study.case, "code_version": code_version(), "missing": missing,
               "runs": lines}
    try:
        write_json(folder / "results.json", content)
        write_text(folder / "results.csv", out.getvalue())
    except OSError as error:
        raise StoreError(f"cannot write the table in {folder}: {error.strerror}") from None
