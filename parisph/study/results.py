"""The results of the runs of a study: a line for each in results.json and results.csv."""

from collections.abc import Callable, Hashable, Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from parisph.base.errors import ParisphError, StoreError
from parisph.io.reader import Run, open_run
from parisph.study import measures, measuring, study_folder
from parisph.study.measures import AnyMeasure
from parisph.study.plan import Plan, PlannedRun, code_version
from parisph.study.runs import RUNS, End
from parisph.study.set_words import text

Key = TypeVar("Key", bound=Hashable)
Item = TypeVar("Item")


@dataclass
class Result:
    """The result of a run. end : how it ended; folder : of its files

    values : {column: number or None}: particles, steps, time [s], cpu_seconds (of all ranks), wall_seconds, iterations
        (mean of a step), volume_low, volume_high, energy_end and energy_high (relative to the start)
    errors : {name of a measure: number or None}; problems : {name of a measure: reason if it has none}
    """

    run: PlannedRun
    end: End
    folder: Path
    values: dict[str, float | None] = field(default_factory=dict)
    errors: dict[str, float | None] = field(default_factory=dict)
    problems: dict[str, str] = field(default_factory=dict)

    @property
    def survived(self) -> bool:
        """Whether the run has reached its end time."""
        return self.end.status == "completed"

    @property
    def reason(self) -> str:
        """Why it did not reach its end time, and the time that it reached; else why measures are missing."""
        if not self.survived:
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
        run, numerics = self.run, self.run.case.numerics
        return {
            "label": run.label, "method": run.method, "spacing": run.spacing, "time_step": run.time_step,
            "parameters": " ".join(f"{name}={text(value)}" for name, value in run.further.items()),
            "seed": run.seed, "ranks": run.ranks, "spacing_m": numerics.spacing, "time_step_s": numerics.time_step,
            **{name: self.values.get(name) for name in COLUMNS}, **self.errors,
            "survived": self.survived, "reason": self.reason, "run": f"{RUNS}/{run.folder}",
        }


COLUMNS = ("particles", "steps", "time", "cpu_seconds", "wall_seconds", "iterations", "volume_low", "volume_high",
           "energy_end", "energy_high")


def result(run: PlannedRun, end: End, plan: Plan) -> Result:
    """Return the result of a run, without its difference from the finest run. Not collective."""
    found = Result(run, end, plan.folder / RUNS / run.folder)
    try:
        files = open_run(found.folder)
        found.values = _values(files, end)
    except ParisphError as error:
        found.problems["run"] = str(error)
        return found
    for measure in plan.study.errors:
        if measure.kind != "finest":
            _measure(found, measure, files, plan.place)
    return found


def add_finest(results: Iterable[Result], plan: Plan) -> None:
    """Add the differences from the finest run of the same curve, of the same seed if possible."""
    results = [found for found in results if found.survived]
    for measure in (measure for measure in plan.study.errors if measure.kind == "finest"):
        for found in results:
            family = [other for other in results if other.run.label == found.run.label]
            finest = min(family, key=lambda other: (
                other.run.spacing, other.run.time_step or 0.0, other.run.seed != found.run.seed))
            try:
                files = open_run(found.folder), open_run(finest.folder)
            except StoreError as error:
                found.problems[measures.name_of(measure)] = str(error)
                continue
            _measure(found, measure, files[0], plan.place, files[1])


def _measure(found: Result, measure: AnyMeasure, files: Run, place: Path, finest: Run | None = None) -> None:
    name = measures.name_of(measure)
    found.errors[name] = None
    if not found.survived:    # an error over a shorter time cannot be compared
        return
    try:
        found.errors[name] = measuring.value(measure, files, place, finest)
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
    if not summary:    # it was killed
        found["steps"], found["time"] = _reached(run)
    return found


def _iterations(run: Run) -> float | None:
    """Return the mean number of iterations of all solves of a step; None for a method without solves."""
    with suppress(ParisphError):
        steps = run.steps
        counts = [steps[name] for name in ("iterations", "position_iterations") if name in (steps.dtype.names or ())]
        return float(np.mean(np.sum(counts, axis=0))) if counts and len(steps) else None
    return None


def _reached(run: Run) -> tuple[int | None, float | None]:
    with suppress(ParisphError):
        if len(steps := run.steps):
            return int(steps["step"][-1]), float(steps["time"][-1])
    return None, None


def save(results: Sequence[Result], plan: Plan) -> None:
    """Write results.json and results.csv. Raises StoreError."""
    content = {"title": plan.study.title, "case": plan.study.case, "code_version": code_version(),
               "missing": len(plan.runs) - len(results)}
    study_folder.save(plan.folder, content, [found.line() for found in results], "runs")


def grouped(items: Iterable[Item], key: Callable[[Item], Key]) -> dict[Key, list[Item]]:
    """Return {key: items with this key} in the given order."""
    found: dict[Key, list[Item]] = {}
    for item in items:
        found.setdefault(key(item), []).append(item)
    return found
