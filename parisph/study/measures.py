"""What a study measures in each run: the error of a probe, an entry of the summary, or a function of the run."""

import math
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any, Literal, Optional, Union

import numpy as np
from pydantic import Field, field_validator

from parisph.base.errors import CaseError, ParisphError
from parisph.base.text import named, of_error, shown
from parisph.case.model import Model
from parisph.io.reader import Run
from parisph.truth import comparison, norms

Name = Annotated[str, Field(max_length=80, description="name of the measure, the head of its column")]


class TruthError(Model):
    """The error of a probe against the Truth of the case, as in the `errors` of summary.json.

    norm : relative_l2 (of the wave alone if Truth.wave is set), paper (that of Z14), paper_2017 (that of Z17)
    """

    kind: Literal["truth"] = "truth"
    probe: str = Field(description="name of a probe with a truth")
    norm: Literal["relative_l2", "paper", "paper_2017"] = "relative_l2"
    name: Name = ""


class SeriesError(Model):
    """The error of a probe against two columns of a CSV file, as `parisph compare` computes it.

    file : path, relative to the study file; column, time, value, offset, scale, time_scale, shift, best_shift, rest : as
        of truth.comparison.compare; start, end : window of the reference's time [s] that is compared, None for all of it.
        `best_shift` is sought over the whole series. norm : relative_l2, or z14, that of Z14
    """

    kind: Literal["series"] = "series"
    probe: str = Field(description="name of a probe")
    file: str = Field(min_length=1, description="path of the reference, relative to the study file")
    column: Optional[str] = None
    time: Optional[str] = None
    value: Optional[str] = None
    offset: float = 0.0
    scale: float = 1.0
    time_scale: float = Field(1.0, gt=0, description="seconds for one unit of the reference's time")
    shift: float = 0.0
    best_shift: Optional[float] = Field(None, ge=0, description="largest shift of the run's time that is tried [s]")
    rest: Optional[float] = None
    start: Optional[float] = None
    end: Optional[float] = None
    norm: Literal["relative_l2", "z14"] = "relative_l2"
    name: Name = ""


class FinestError(Model):
    """The difference of a probe from that of the finest run of its curve, relative L2 (Z14 Fig 13b); none for the finest itself.

    start, end : window of time [s], None for all of it
    """

    kind: Literal["finest"] = "finest"
    probe: str = Field(description="name of a probe")
    column: Optional[str] = None
    start: Optional[float] = None
    end: Optional[float] = None
    name: Name = ""


class Quantity(Model):
    """A number of summary.json.

    entry : its name, with dots, such as energy_range.high; absolute : whether its sign is left out
    """

    kind: Literal["quantity"] = "quantity"
    entry: str = Field(min_length=1, description="entry of summary.json, with dots, such as energy_range.high")
    absolute: bool = False
    name: Name = ""


class Function(Model):
    """A function of a run: of(run) -> float, with run an io.reader.Run. In study files in Python only."""

    kind: Literal["function"] = "function"
    name: Name = Field(min_length=1, description="name of the measure")
    of: Callable[[Any], float] = Field(exclude=True, description="function of a run that returns a number")

    @field_validator("of", mode="before")
    @classmethod
    def _callable(cls, value):
        if not callable(value):
            raise ValueError(f"of = {shown(value)}: must be a function of a run that returns a number")
        return value


AnyMeasure = Annotated[
    Union[TruthError, SeriesError, FinestError, Quantity, Function], Field(discriminator="kind", description="what is measured")]


def name_of(measure: AnyMeasure) -> str:
    """Return the name of a measure: the given one, or one made of its probe or entry."""
    if measure.name:
        return measure.name
    if isinstance(measure, Quantity):
        return measure.entry
    if isinstance(measure, TruthError) and measure.norm != "relative_l2":
        return f"{measure.probe} ({measure.norm})"
    return {"series": f"{measure.probe} against {Path(getattr(measure, 'file', '')).stem}",
            "finest": f"{measure.probe} against the finest"}.get(measure.kind, measure.probe)


def label_of(measure: AnyMeasure) -> str:
    """Return the label of a measure for the axis of a picture."""
    name = name_of(measure)
    if measure.name or measure.kind in ("quantity", "function"):
        return name
    return f"difference of {measure.probe} from the finest run" if measure.kind == "finest" else f"error of {name}"


def faults(measure: AnyMeasure, case, folder: Path) -> list[str]:
    """Return what is wrong with a measure of a case, one line each, before anything runs. Not collective.

    case : Case; folder : of the study file, which the paths of references are relative to
    """
    probes = {probe.name: probe for probe in case.probes}
    if isinstance(measure, (Quantity, Function)):
        return []
    if measure.probe not in probes:
        return [f"{name_of(measure)}: the case has no probe {shown(measure.probe)} (it has: {named(', '.join(probes)) or 'none'})"]
    if isinstance(measure, TruthError) and probes[measure.probe].truth is None:
        return [f"{name_of(measure)}: the probe {measure.probe} has no truth: give it one in the case file, or use SeriesError"]
    if isinstance(measure, SeriesError):
        try:
            comparison.columns_of(folder / measure.file)
            for column in filter(None, (measure.time, measure.value)):
                comparison.read_reference(folder / measure.file, measure.time or column, measure.value or column)
        except ParisphError as error:
            return [f"{name_of(measure)}: {error}"]
    return []


def value(measure: AnyMeasure, run: Run, folder: Path, finest: Run | None = None) -> float | None:
    """Return a measure of a run; None where there is none. Not collective.

    folder : of the study file; finest : the finest run of the same curve, for FinestError

    Raises
    ------
    CaseError : it cannot be computed, with the reason; StoreError : files of the run cannot be read
    """
    try:
        found = _VALUES[measure.kind](measure, run, folder, finest)
    except ParisphError:
        raise
    except KeyboardInterrupt:
        raise
    except Exception as error:    # of a function of the user, or of series that do not overlap
        raise CaseError(f"{type(error).__name__}: {of_error(error)}" if measure.kind == "function" else of_error(error)) from None
    return None if found is None or not math.isfinite(found) else float(found)


def _of_truth(measure, run, folder, finest):
    found = ((run.summary or {}).get("errors") or {}).get(measure.probe) or {}
    if found.get(measure.norm) is None:
        raise CaseError(str(found.get("reason") or f"the summary has no error of {measure.probe}"))
    return found[measure.norm]


def _of_series(measure, run, folder, finest):
    names = ("probe", "column", "time", "value", "offset", "scale", "time_scale", "shift", "best_shift", "rest")
    found = comparison.compare(run, folder / measure.file, **{name: getattr(measure, name) for name in names})
    key = "z14" if measure.norm == "z14" else "relative_l2"
    if measure.start is None and measure.end is None:
        return found.result[key]
    t, truth = _within(*found.truth, measure)
    return norms.judge(*found.found, t, truth, measure.rest, found.result["shift"])[key]


def _of_finest(measure, run, folder, finest):
    if finest is None or finest.folder == run.folder:
        return None
    ours, theirs = run.probe(measure.probe), finest.probe(measure.probe)
    column = measure.column or next(name for name in ours.dtype.names if name not in ("time", "step"))
    reference = _within(theirs["time"], theirs[column], measure)
    return norms.judge(ours["time"], ours[column], *reference)["relative_l2"]


def _of_summary(measure, run, folder, finest):
    found = run.summary
    for part in measure.entry.split("."):
        if not isinstance(found, dict) or part not in found:
            there = ", ".join(found) if isinstance(found, dict) else "nothing"
            raise CaseError(f"summary.json has no entry {measure.entry}: there is no {shown(part)} (there is: {named(there)})")
        found = found[part]
    if found is None:
        return None
    return abs(float(found)) if measure.absolute else float(found)


def _of_function(measure, run, folder, finest):
    return float(measure.of(run))


def _within(t, values, measure):
    """Return the part of a series between the start and the end of a measure [s]."""
    low = -np.inf if measure.start is None else measure.start
    high = np.inf if measure.end is None else measure.end
    inside = (t >= low) & (t <= high)
    return t[inside], values[inside]


_VALUES = {"truth": _of_truth, "series": _of_series, "finest": _of_finest, "quantity": _of_summary, "function": _of_function}
