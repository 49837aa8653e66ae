"""The description of a study: its runs of a case, its measures and its requirements."""

from collections.abc import Iterable
from typing import Annotated, Any, Optional, TypeVar

from pydantic import AfterValidator, BeforeValidator, Field, field_validator, model_validator

from parisph.base.text import shown
from parisph.case.model import Model, Several
from parisph.study.measures import AnyMeasure, is_error, name_of

# Parameters with a field of their own.
OWN = {"method": "methods", "spacing": "spacings", "time_step": "time_steps", "seed": "seeds"}
# Columns of the table, besides the measures, that can have limits.
COLUMNS = (
    "cpu_seconds", "wall_seconds", "iterations", "volume_low", "volume_high", "energy_end", "energy_high", "survived",
)
Item = TypeVar("Item")


def listed(values: object) -> object:
    """Return values for a field. Raises ValueError for a single value in place of a list."""
    if isinstance(values, (str, int, float, Model)) and not isinstance(values, bool):
        raise ValueError(f"{shown(values)}: must be a list; write [{shown(values)}]")
    return values


def each_once(values: tuple[Item, ...]) -> tuple[Item, ...]:
    """Return values for a field. Raises ValueError if one is repeated."""
    for value in values:
        if values.count(value) > 1:
            raise ValueError(f"{shown(value)} is given twice: leave one of them out")
    return values


Listed = Annotated[Several[Item], BeforeValidator(listed)]    # refuses a single value in place of a list
Each = Annotated[Listed[Item], AfterValidator(each_once)]        # also refuses repeated values
Positive = Annotated[float, Field(gt=0)]
Whole = Annotated[int, Field(ge=0)]
Count = Annotated[int, Field(ge=1, le=10_000)]


class Choices(Model):
    """Values that are combined, each with every other. An empty field leaves the value of the case.

    methods : names of methods
    spacings, time_steps : of the case's parameters `spacing` and `time_step`, in their units; None is an adaptive step.
        If the case has no such parameter, they are numerics.spacing [m] and numerics.time_step [s]
    parameters : {name: value} of the case, or of numerics.NAME; the values of a list are combined, a tuple is one value
    seeds : of the jitter; results are given as mean and range over them
    ranks : numbers of MPI ranks
    """

    methods: Each[str] = ()
    spacings: Each[Positive] = Field(default=(), description="spacings, each greater than 0")
    time_steps: Each[Optional[Positive]] = Field(
        default=(), description="time steps, each greater than 0, or None to adapt it")
    parameters: dict[str, Any] = Field(default_factory=dict, description="parameters of the case by name")
    seeds: Each[Whole] = Field(default=(), description="seeds, each a whole number of at least 0")
    ranks: Each[Count] = Field(default=(), description="numbers of ranks, each at least 1")

    @field_validator("parameters")
    @classmethod
    def _known_kinds(cls, found: dict[str, Any]) -> dict[str, Any]:
        for name, value in found.items():
            if name in OWN or name.removeprefix("numerics.") in OWN:
                raise ValueError(f"{name}: give it as {OWN[name.removeprefix('numerics.')]}=[...]")
            if isinstance(value, list) and not value:
                raise ValueError(f"{name} = []: must be a value, or a list of at least one")
            for one in value if isinstance(value, list) else [value]:
                parts = one if isinstance(one, (tuple, list)) else (one,)
                if not all(part is None or isinstance(part, (bool, int, float, str)) for part in parts):
                    raise ValueError(
                        f"{name} = {shown(one)}: must be a number, a text, True, False, None, or a tuple of these")
        return found


class Variant(Choices):
    """Choices that replace those of the study; its parameters are added to those of the study.

    label : name of its curve in tables and pictures; "" for one made of the parameters that differ
    """

    label: str = Field(default="", max_length=60, description="name of the curve")


class Required(Model):
    """A limit on a measure, or on a column of the table. Of several seeds the worst counts.

    of : name of the measure, or one of COLUMNS; must, aim : required and desired limit
    least : whether they are lower limits
    where : the runs: {"method", "spacing", "time_step", "seed", "ranks", "label" or a parameter: value}
    """

    of: str = Field(min_length=1, description="name of a measure or a column")
    must: Optional[float] = None
    aim: Optional[float] = None
    least: bool = False
    where: dict[str, Any] = Field(default_factory=dict, description="which runs, by name and value")

    @model_validator(mode="after")
    def _some_limit(self) -> "Required":
        if self.must is None and self.aim is None:
            raise ValueError(f"of = {shown(self.of)}: give must= or aim=, the limit")
        return self


class OtherCodes(Model):
    """Points of other codes: a CSV file with a header and a line for each point. Cells may be empty.

    file : path, relative to the study file; code, spacing, error, cpu : names of its columns, "" for none
    of : name of the measure of `error`, by default the first one of the study
    """

    file: str = Field(min_length=1, description="path of a CSV file, relative to the study file")
    code: str = "code"
    spacing: str = "spacing"
    error: str = "error"
    cpu: str = "cpu_seconds"
    of: str = ""


class Study(Choices):
    """A study: its runs are all combinations of its choices, or of those of each of its variants.

    case : path of a case file or of a stored case, relative to the study file
    title : one line for tables and pictures
    variants : list of Variant; if empty, the choices of the study itself are combined
    errors : list of measures: TruthError, SeriesError, FinestError, Quantity, Function
    required : list of Required; others : list of OtherCodes, for the pictures
    levels : {name of a measure: errors} at which the CPU times of the methods are compared
    histories : names of probes whose series are drawn side by side, with their truth
    time_limit : longest wall time of a run [s], None for no limit
    warm_up : whether a step of each method is made first, so that no CPU time includes the compilation of kernels

    Raises CaseError with one line for each problem.
    """

    case: str = Field(kw_only=True, min_length=1, description="path of the case file, relative to the study file")
    title: str = Field(default="", max_length=200, description="one line for people")
    variants: Listed[Variant] = ()
    errors: Listed[AnyMeasure] = ()
    required: Listed[Required] = ()
    others: Listed[OtherCodes] = ()
    levels: dict[str, Several[Positive]] = Field(
        default_factory=dict,
        description="errors at which costs are compared, each greater than 0, by the name of a measure")
    histories: Listed[str] = ()
    time_limit: Optional[float] = Field(default=None, gt=0, description="longest wall time of a run [s]")
    warm_up: bool = True

    @model_validator(mode="after")
    def _names_fit(self) -> "Study":
        names = [name_of(measure) for measure in self.errors]
        for name in names:
            if names.count(name) > 1:
                raise ValueError(f"two measures are named {shown(name)}: give one of them another name=")
            if name in COLUMNS:
                raise ValueError(f"a measure is named {shown(name)}, as a column of the table: give it another name=")
        _check_known((item.of for item in self.required), [*names, *COLUMNS], "required")
        _check_known((item.of for item in self.others if item.of), names, "others")
        _check_known(self.levels, [name_of(measure) for measure in self.errors if is_error(measure)], "levels")
        return self


def _check_known(asked: Iterable[str], names: list[str], field: str) -> None:
    for name in asked:
        if name not in names:
            raise ValueError(f"{field}: there is no measure {shown(name)}; there are {', '.join(names) or 'none'}")
