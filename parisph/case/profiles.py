"""Reference profiles of the surface, as the truth of an array of gauges."""

import math

import numpy as np
from pydantic import Field, model_validator

from parisph.base import reading
from parisph.base.arrays import Floats
from parisph.base.errors import CaseError
from parisph.base.text import named, shown
from parisph.case.model import Model, Several
from parisph.case.truths import each_named

MOST = 1000    # profiles in a file


class Profiles(Model):
    """Heights of the surface along x at several times: columns of a CSV file with one header line ('#' for comments).

    Each profile is compared at its time, without a shift, at the gauges between its ends. If it overturns, its top
    counts, as for a gauge.

    file : path, relative to the case file
    time, x, value : names of the columns
    offset, scale : height = offset + scale * column [m]
    x_offset, x_scale : place = x_offset + x_scale * column [m]
    time_scale : seconds for one unit of the time column
    wave : whether the error is relative to the height above `offset` alone
    rows : {column: word}, only lines with these words in these columns
    name, note, published, others : as of a Truth; the others may have other times

    >>> measured = Profiles("photos.csv", time="t_s", x="x_cm", value="y_cm", scale=0.01, x_scale=0.01)
    >>> gauges = [SurfaceGauge(f"x{k}", at=0.1 * k) for k in (4, 5, 6)]
    >>> ProbeArray("profile", gauges, truth=measured).truth.x_scale
    0.01
    """

    file: str
    time: str
    x: str
    value: str
    offset: float = 0.0
    scale: float = 1.0
    x_offset: float = 0.0
    x_scale: float = 1.0
    time_scale: float = Field(default=1.0, gt=0, description="seconds for one unit of the time column")
    wave: bool = False
    rows: dict[str, str] = Field(default={}, description="words that lines have in columns")
    name: str = ""
    note: str = ""
    published: dict[str, float] = Field(default={}, description="relative errors of others")
    others: Several["Profiles"] = ()

    @model_validator(mode="after")
    def _others_have_names(self) -> "Profiles":
        each_named(other.name for other in self.others)
        return self

    def __hash__(self) -> int:
        """Hash few fields, as others are dictionaries: caches of scenes need a hash of the whole case."""
        return hash((self.file, self.time, self.value, self.name))


def read_profiles(truth: Profiles) -> list[tuple[float, Floats, Floats]]:
    """Return (time [s], places (n,) [m], heights (n,) [m]) of each profile in order of time, points as in the file.

    Raises CaseError : the file cannot be read, a column is missing, or a value is not a number.
    """
    try:
        names, lines = reading.read_columns(truth.file)
    except (OSError, ValueError) as error:
        why = error.strerror if isinstance(error, OSError) else error
        raise CaseError(f"truth.file = {shown(truth.file)}: cannot be read ({why})") from None
    for name in (truth.time, truth.x, truth.value, *truth.rows):
        if name not in names:
            raise CaseError(f"truth: {named(truth.file)} has no column {shown(name)}; it has {reading.listed(names)}")
    columns = [names.index(name) for name in (truth.time, truth.x, truth.value)]
    words = {names.index(name): word for name, word in truth.rows.items()}
    data = np.array([_numbers(truth, number, [cells[k] for k in columns]) for number, cells in lines.items()
                     if all(cells[k] == word for k, word in words.items())]).reshape(-1, 3)
    times = np.unique(data[:, 0])
    if not 0 < len(times) <= MOST:
        raise CaseError(f"truth.file = {shown(truth.file)}: has {len(times)} profiles, and must have 1 to {MOST}")
    parts = [(float(t), data[data[:, 0] == t]) for t in times]
    return [(t * truth.time_scale, truth.x_offset + truth.x_scale * part[:, 1], truth.offset + truth.scale * part[:, 2])
            for t, part in parts]


def height(x: Floats, y: Floats, at: float) -> float | None:
    """Return the height [m] of the upper surface of a profile at a place [m], None beyond its ends.

    x, y : (n,) points along the surface [m], joined by straight lines, which may overturn
    """
    low, high = np.minimum(x[:-1], x[1:]), np.maximum(x[:-1], x[1:])
    found = np.flatnonzero((low <= at) & (at <= high))
    values = []
    for k in found:
        run = x[k + 1] - x[k]
        values.append(max(y[k], y[k + 1]) if run == 0.0 else y[k] + (at - x[k]) / run * (y[k + 1] - y[k]))
    return float(max(values)) if values else None


def _numbers(truth: Profiles, line: int, cells: list[str]) -> list[float]:
    try:
        found = [float(cell) for cell in cells]
    except ValueError:
        found = [np.nan]
    if not all(map(math.isfinite, found)):
        raise CaseError(f"truth.file = {shown(truth.file)}, line {line}: time, place and height must be finite numbers")
    return found
