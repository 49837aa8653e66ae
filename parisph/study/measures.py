"""The measures of a study: the error of a probe, a number of the summary, or a function of the run."""

from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any, Literal, Optional, Union

from pydantic import Field, field_validator

from parisph.base.text import shown
from parisph.case.model import Model

Name = Annotated[str, Field(max_length=80, description="name of the measure, the head of its column")]


class TruthError(Model):
    """The error of a probe against the Truth of the case, as in the `errors` of summary.json.

    norm : relative_l2 (of the wave alone if Truth.wave is set), paper (that of Z14), paper_2017 (that of Z17)
    """

    kind: Literal["truth"] = Field(default="truth", init=False)
    probe: str = Field(description="name of a probe with a truth")
    norm: Literal["relative_l2", "paper", "paper_2017"] = "relative_l2"
    name: Name = ""


class SeriesError(Model):
    """The error of a probe against two columns of a CSV file, as `parisph compare` computes it.

    file : path, relative to the study file
    column, time, value, offset, scale, time_scale, shift, best_shift, rest : as of truth.comparison.compare. The best
        shift is that of the whole series
    start, end : window of the reference's time [s], None for all of it
    norm : relative_l2, or z14, that of Z14
    """

    kind: Literal["series"] = Field(default="series", init=False)
    probe: str = Field(description="name of a probe")
    file: str = Field(min_length=1, description="path of the reference, relative to the study file")
    column: Optional[str] = None
    time: Optional[str] = None
    value: Optional[str] = None
    offset: float = 0.0
    scale: float = 1.0
    time_scale: float = Field(default=1.0, gt=0, description="seconds for one unit of the reference's time")
    shift: float = 0.0
    best_shift: Optional[float] = Field(default=None, ge=0, description="largest shift in time that is tried [s]")
    rest: Optional[float] = None
    start: Optional[float] = None
    end: Optional[float] = None
    norm: Literal["relative_l2", "z14"] = "relative_l2"
    name: Name = ""


class FinestError(Model):
    """The difference of a probe from that of the finest run of its curve, relative L2 (Z14 Fig 13b).

    The finest run has the smallest spacing, and then the shortest time step. It has no difference itself.

    start, end : window of time [s], None for all of it
    """

    kind: Literal["finest"] = Field(default="finest", init=False)
    probe: str = Field(description="name of a probe")
    column: Optional[str] = None
    start: Optional[float] = None
    end: Optional[float] = None
    name: Name = ""


class Quantity(Model):
    """A number of summary.json.

    entry : its name, with dots, such as energy_range.high; absolute : whether its sign is left out
    error : whether a smaller value is better; an error is drawn, with a fitted order
    """

    kind: Literal["quantity"] = Field(default="quantity", init=False)
    entry: str = Field(min_length=1, description="entry of summary.json, with dots, such as energy_range.high")
    absolute: bool = False
    name: Name = ""
    error: bool = True


class Function(Model):
    """A function of a run, of(run: io.reader.Run) -> float. Only in study files in Python.

    error : as of Quantity
    """

    kind: Literal["function"] = Field(default="function", init=False)
    name: Name = Field(min_length=1, description="name of the measure")
    of: Callable[[Any], float] = Field(exclude=True, description="function of a run that returns a number")
    error: bool = True

    @field_validator("of", mode="before")
    @classmethod
    def _callable(cls, value: object) -> object:
        if not callable(value):
            raise ValueError(f"of = {shown(value)}: must be a function of a run that returns a number")
        return value


AnyMeasure = Annotated[
    Union[TruthError, SeriesError, FinestError, Quantity, Function],
    Field(discriminator="kind", description="what is measured"),
]


def name_of(measure: AnyMeasure) -> str:
    """Return the name of a measure: the given one, or one made of its probe or entry."""
    if measure.name:
        return measure.name
    if isinstance(measure, Quantity):
        return measure.entry
    if isinstance(measure, TruthError):
        return measure.probe if measure.norm == "relative_l2" else f"{measure.probe} ({measure.norm})"
    if isinstance(measure, SeriesError):
        return f"{measure.probe} against {Path(measure.file).stem}"
    return f"{measure.probe} against the finest" if isinstance(measure, FinestError) else measure.kind


def label_of(measure: AnyMeasure) -> str:
    """Return the label of a measure for the axis of a picture."""
    if measure.kind == "finest" and not measure.name:
        return f"difference of {measure.probe} from the finest run"
    return name_of(measure) if measure.kind in ("quantity", "function") else f"error: {name_of(measure)}"


def is_error(measure: AnyMeasure) -> bool:
    """Return whether a smaller value of a measure is better."""
    return getattr(measure, "error", True)
