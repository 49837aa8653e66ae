"""The value of a measure in a run, and a check of measures before any run."""

import math
from pathlib import Path
from typing import Any

import numpy as np

from parisph.base import table
from parisph.base.arrays import Floats
from parisph.base.errors import CaseError, ParisphError
from parisph.base.text import named, of_error, shown
from parisph.case.schema import Case
from parisph.io.reader import Run
from parisph.study.measures import AnyMeasure, FinestError, Function, Quantity, SeriesError, TruthError, name_of
from parisph.truth import comparison, norms
from parisph.truth.recorded import own_columns


def faults(measure: AnyMeasure, case: Case, folder: Path) -> list[str]:
    """Return the faults of a measure of a case, one line each. Not collective. folder : of the study file"""
    probes = {probe.name: probe for probe in case.probes}
    if isinstance(measure, (Quantity, Function)):
        return []
    if measure.probe not in probes:
        return [f"{name_of(measure)}: the case has no probe {shown(measure.probe)} "
                f"(it has: {named(', '.join(probes)) or 'none'})"]
    if isinstance(measure, TruthError) and probes[measure.probe].truth is None:
        return [f"{name_of(measure)}: the probe {measure.probe} has no truth: give it one in the case file, or use "
                "SeriesError"]
    if isinstance(measure, SeriesError):
        try:
            table.names(folder / measure.file)
            for column in filter(None, (measure.time, measure.value)):
                table.read_reference(folder / measure.file, measure.time or column, measure.value or column)
        except ParisphError as error:
            return [f"{name_of(measure)}: {error}"]
    return []


def value(measure: AnyMeasure, run: Run, folder: Path, finest: Run | None = None) -> float | None:
    """Return the value of a measure in a run, None without a finite one. Not collective.

    folder : of the study file; finest : the finest run of the same curve, for FinestError

    Raises CaseError with the reason if it cannot be computed; StoreError : files of the run cannot be read
    """
    try:
        found = _found(measure, run, folder, finest)
    except ParisphError:
        raise
    except Exception as error:    # of a function of the user, or of series that do not overlap
        kind = f"{type(error).__name__}: " if measure.kind == "function" else ""
        raise CaseError(f"{kind}{of_error(error)}") from None
    return None if found is None or not math.isfinite(found) else float(found)


def _found(measure: AnyMeasure, run: Run, folder: Path, finest: Run | None) -> float | None:
    if isinstance(measure, SeriesError):
        return _of_series(measure, run, folder)
    if isinstance(measure, FinestError):
        return _of_finest(measure, run, finest)
    if isinstance(measure, Quantity):
        return _of_summary(measure, run)
    if isinstance(measure, Function):
        return float(measure.of(run))
    found = ((run.summary or {}).get("errors") or {}).get(measure.probe) or {}
    if found.get(measure.norm) is None:
        raise CaseError(str(found.get("reason") or f"the summary has no error of {measure.probe}"))
    return float(found[measure.norm])


def _of_series(measure: SeriesError, run: Run, folder: Path) -> float:
    names = ("probe", "column", "time", "value", "offset", "scale", "time_scale", "shift", "best_shift", "rest")
    found = comparison.compare(run, folder / measure.file, **{name: getattr(measure, name) for name in names})
    key = "z14" if measure.norm == "z14" else "relative_l2"
    if measure.start is None and measure.end is None:
        return float(found.result[key])
    t, truth = _within(*found.truth, measure)
    return norms.judge(*found.found, t, truth, measure.rest, found.result["shift"])[key]


def _of_finest(measure: FinestError, run: Run, finest: Run | None) -> float | None:
    if finest is None or finest.folder == run.folder:
        return None
    ours, theirs = run.probe(measure.probe), finest.probe(measure.probe)
    column = measure.column or own_columns(ours)[0]
    reference = _within(theirs["time"], theirs[column], measure)
    return norms.judge(ours["time"], ours[column], *reference)["relative_l2"]


def _of_summary(measure: Quantity, run: Run) -> float | None:
    found: Any = run.summary
    for part in measure.entry.split("."):
        if not isinstance(found, dict) or part not in found:
            there = ", ".join(found) if isinstance(found, dict) else "nothing"
            raise CaseError(f"summary.json has no entry {measure.entry}: there is no {shown(part)} "
                            f"(there is: {named(there)})")
        found = found[part]
    if found is None:
        return None
    return abs(float(found)) if measure.absolute else float(found)


def _within(t: Floats, values: Floats, measure: SeriesError | FinestError) -> tuple[Floats, Floats]:
    """Return the part of a series between the start and the end of a measure [s]."""
    low = -np.inf if measure.start is None else measure.start
    high = np.inf if measure.end is None else measure.end
    inside = (t >= low) & (t <= high)
    return t[inside], values[inside]
