"""Measured motions: series of times and values, from a file or given as numbers."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, Any, Union

import numpy as np
from pydantic import Field, model_validator

from parisph.base import paths, reading
from parisph.base.arrays import Floats
from parisph.base.errors import CaseError
from parisph.base.text import named, shown
from parisph.case.model import Model, Several
from parisph.case.motion.splines import cubic
from parisph.case.values import LARGEST, SMALLEST

LEAST = 4    # points of a spline
PARTS = 8    # samples between two times, for the range of a motion
MANY = 2000  # times: a longer series needs only two samples between times
SEEN = 64    # values of a long series in its hash


class Sampled:
    """Base of records with a law of time from values, or rates, at increasing times.

    times [s], values : (n,) each; rate : whether the values are rates, whose integral is the law
    """

    if TYPE_CHECKING:    # fields of each record; as fields of this class they would come first
        @property
        def times(self) -> Sequence[float]: ...
        @property
        def values(self) -> Sequence[float]: ...
        @property
        def rate(self) -> bool: ...

    def _check_increasing(self, what: str) -> None:
        """Raise ValueError unless times increase and each has a value. what : name of the values, in plural"""
        times, values = self.times, self.values
        if len(times) != len(values):
            raise ValueError(f"values: {len(values)} {what} for {len(times)} times; give one for each")
        late = np.flatnonzero(np.diff(times) < SMALLEST)
        if len(late):
            raise ValueError(
                f"times[{late[0] + 1}] = {times[late[0] + 1]}: must be later than the time before it, "
                f"by {SMALLEST:g} s at least"
            )

    def law(self, t: float) -> tuple[float, float, float]:
        """Return the value, its rate and its second derivative at t [s]."""
        curve = cubic(self.times, self.values)
        if not self.rate:
            return curve.at(t)
        moved = float(curve.integrals(np.array([t]))[0])
        return (moved, 0.0, 0.0) if t < self.times[0] or t > self.times[-1] else (moved, *curve.at(t)[:2])

    def values_at(self, times: Floats) -> Floats:
        """Return the values (n,) of the law at times (n,) [s]."""
        curve = cubic(self.times, self.values)
        return curve.integrals(times) if self.rate else curve.values(times)

    @property
    def top_rate(self) -> float:
        """Greatest rate, of straight lines between the times."""
        return float(np.max(np.abs(self.values if self.rate else np.diff(self.values) / np.diff(self.times))))

    def instants(self, stop: float) -> Floats:
        """Return times (n,) [s] in order, from 0 to `stop`, several between two times of the series."""
        knots = np.unique(np.clip(np.concatenate([[0.0], self.times, [stop]]), 0.0, stop))
        parts = PARTS if len(knots) < MANY else 2
        found: Floats = np.append((knots[:-1, None] + np.diff(knots)[:, None] * np.arange(parts) / parts).ravel(), stop)
        return found

    def __hash__(self) -> int:
        """Hash SEEN of the values, as caches call it often."""
        few = slice(None, None, max(1, len(self.times) // SEEN))
        return hash((len(self.times), self.times[few], self.values[few]))


class Series(Sampled, Model):
    """A measured displacement [m] or angle [rad] over time: columns of a CSV file with one header line, or numbers.

    The file is read once, when the record is made; the numbers are then part of the case. A not-a-knot cubic spline
    joins them. Its second derivative is the acceleration of the body, so smooth rough data before. The body rests
    before the first and after the last time: if the data does not begin and end at rest, the velocity jumps there.

    file : path, relative to the case file
    time, value : names of the columns
    scale, offset : value = offset + scale * column, so scale = pi/180 for degrees
    time_scale : seconds for one unit of the time column
    rate : whether the values are velocities [m/s] or [rad/s]; the motion is then their integral
    times, values : in SI units; from the file, if one is given

    >>> angle = Series(times=(0.0, 1.0, 2.0, 3.0), values=(0.0, 0.1, 0.1, 0.0))
    >>> print(f"{angle.law(1.0)[0]:.3f} rad")
    0.100 rad
    >>> angle = Series("roll.csv", time="t_s", value="angle_deg", scale=pi / 180)
    """

    file: str = ""
    time: str = "t"
    value: str = "x"
    scale: float = 1.0
    offset: float = 0.0
    time_scale: float = Field(default=1.0, gt=0, description="seconds for one unit of the time column")
    rate: bool = False
    times: Annotated[Several[float], Field(min_length=LEAST, description="increasing times [s], at least four")] = ()
    values: Annotated[Several[float], Field(min_length=LEAST, description="a value for each time")] = ()

    @model_validator(mode="before")
    @classmethod
    def _with_numbers(cls, data: Any) -> Any:
        if not isinstance(data, dict) or not data.get("file") or "times" in data:
            return data
        options = {
            name: data.get(name, cls.model_fields[name].default)
            for name in ("time", "value", "scale", "offset", "time_scale")
        }
        times, values = _columns(data["file"], options["time"], options["value"])
        return {
            **data,
            "times": tuple((times * options["time_scale"]).tolist()),
            "values": tuple((options["offset"] + options["scale"] * values).tolist()),
        }

    @model_validator(mode="after")
    def _is_sound(self) -> "Series":
        self._check_increasing("values")
        return self


def _columns(file: str, time: str, value: str) -> tuple[Floats, Floats]:
    """Return two columns of a file, (n,) each. Raises ValueError, with a message that shows little of the file."""
    try:
        path = paths.FOLDER.get() / paths.checked(file, "file")
        names, lines = reading.read_columns(path)
    except CaseError as error:
        raise ValueError(str(error)) from None
    except (OSError, ValueError) as error:
        raise ValueError(
            f"file = {shown(file)}: cannot be read ({getattr(error, 'strerror', None) or error})"
        ) from None
    for field, name in (("time", time), ("value", value)):
        if name not in names:
            raise ValueError(
                f"{field} = {shown(name)}: {named(file)} has no such column; it has {reading.listed(names)}"
            )
    columns = [names.index(time), names.index(value)]
    cells = [[row[k] for k in columns] for row in lines.values()]
    try:
        found = np.array([[float(one), float(other)] for one, other in cells]).reshape(-1, 2)
        sound = (np.abs(found) <= LARGEST).all(axis=1)    # nor is any nan
    except ValueError:
        sound = np.array([all(map(_is_number, row)) for row in cells])
    if not sound.all():
        line = list(lines)[int(np.argmin(sound))]
        raise ValueError(
            f"file = {shown(file)}: line {line} holds something that is not a finite number of at most {LARGEST:g}"
        )
    return found[:, 0], found[:, 1]


def _is_number(cell: str) -> bool:
    try:
        return abs(float(cell)) <= LARGEST
    except ValueError:
        return False


Amount = Union[float, Series]    # of an oscillation, or all of a measured motion
