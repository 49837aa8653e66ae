"""References for probes: series in files, waves, and bands of measured peaks."""

from collections.abc import Iterable, Sequence
from typing import Annotated

import numpy as np
from pydantic import AfterValidator, Field, model_validator

from parisph.base import reading
from parisph.base.arrays import Floats
from parisph.base.errors import CaseError
from parisph.base.text import named, shown
from parisph.case.model import Model, Several
from parisph.case.values import LARGEST
from parisph.case.waves import AnyWave


class PeakBand(Model):
    """A published range of the greatest value in an interval of time, and its time.

    start, end : of the interval [s]; low, high : of the band, in the probe's unit; None if only the time is known
    smooth : width [s] of a moving mean of the run, against spikes of single steps; None for none
    when : published time of the greatest value [s], or None
    level : value at rest, subtracted before comparison: still water if `low` and `high` are heights above the bed

    >>> PeakBand(start=2.2, end=2.6, low=2100.0, high=4300.0).high
    4300.0
    """

    start: float = Field(description="start of the interval of time [s]")
    end: float = Field(description="end of the interval of time [s]")
    low: float | None = Field(default=None, description="lower end of the band [unit of the probe]")
    high: float | None = Field(default=None, description="upper end of the band [unit of the probe]")
    smooth: float | None = Field(default=None, gt=0, description="width of the moving mean of the run [s]")
    when: float | None = Field(default=None, description="time of the greatest value [s]")
    level: float = Field(default=0.0, description="level at rest, from which values count [unit of the probe]")

    @model_validator(mode="after")
    def _in_order(self) -> "PeakBand":
        if not self.start < self.end:
            raise ValueError("start must be before end, and low above 0 and below high")
        if self.low is None and self.high is None and self.when is not None:
            return self
        if self.low is None or self.high is None:
            raise ValueError("give low and high, or `when` alone")
        if not 0.0 < self.low < self.high:
            raise ValueError("start must be before end, and low above 0 and below high")
        if not self.level < self.low:
            raise ValueError(f"level = {self.level:g}: must be below low = {self.low:g}")
        return self


class Peaks(Model):
    """The truth of a probe for which single numbers are published, but no series.

    bands : one PeakBand for each greatest value
    name : of the source, as shown on pages; note : for readers

    >>> impact = Peaks([PeakBand(start=0.3, end=0.5, when=0.36)], name="Z17, Sec. 6.2")
    >>> PressureTap("P2", at=(1.18, 0.01), truth=impact).truth.bands[0].when
    0.36
    """

    bands: Several[PeakBand] = Field(min_length=1, max_length=100, description="bands of greatest values")
    name: str = ""
    note: str = ""


def _one_window(window: tuple[float, float] | None) -> tuple[float, float] | None:
    if window is not None and not window[0] < window[1]:
        raise ValueError(f"window = {window}: must end after its start")
    return window


Window = Annotated[tuple[float, float] | None, Field(description="start and end of the comparison [s]"),
                   AfterValidator(_one_window)]


def each_named(others: Iterable[str]) -> None:
    """Raise ValueError if further references lack distinct names, which a summary needs."""
    names = list(others)
    if len({"", *names}) <= len(names):
        raise ValueError(f"others have the names {shown(names)}: give each one of its own")


class Truth(Model):
    """A reference series for a probe: two columns of a text file with one header line ('#' starts a comment).

    Commas, semicolons, tabs or blanks separate columns; with the last three, numbers may have decimal commas.

    file : path, relative to the case file
    time, value : names of the columns
    offset, scale : truth = offset + scale * column, in the probe's unit
    time_scale : seconds for one unit of the time column
    wave : whether the error is that of the wave part, |probe - truth| / |truth - offset|, instead of
        |probe - truth| / |truth|
    rows : {column: word}, only lines with these words in these columns; a file may contain several series
    window : (start, end) [s] of the comparison, at even times; None for all, at the times of the file
    smooth : width [s] of a moving mean of both series before they are compared; None for none
    name : as shown on pages and in legends
    note : for readers of the error, such as the place of a sensor
    published : {author and method: relative L2 error against the same reference}, named as printed or recomputed
    peaks : bands of the greatest values, one PeakBand for each
    others : further references, compared in the same way

    >>> truth = Truth("gauge.csv", time="t_s", value="eta_mm", scale=0.001, offset=0.4, wave=True)
    >>> SurfaceGauge("gauge", at=0.5, truth=truth).truth.scale
    0.001
    """

    file: str
    time: str
    value: str
    offset: float = 0.0
    scale: float = 1.0
    time_scale: float = Field(default=1.0, gt=0, description="seconds for one unit of the time column")
    wave: bool = False
    rows: dict[str, str] = Field(default={}, description="words that lines have in columns")
    window: Window = None
    smooth: float | None = Field(default=None, gt=0, description="width of the moving mean [s]")
    name: str = ""
    note: str = ""
    published: dict[str, float] = Field(default={}, description="relative errors of others")
    peaks: Several[PeakBand] = ()
    others: Several["Truth"] = ()

    @model_validator(mode="after")
    def _others_have_names(self) -> "Truth":
        each_named(other.name for other in self.others)
        return self

    def __hash__(self) -> int:
        """Hash few fields, as others are dictionaries: caches of scenes need a hash of the whole case."""
        return hash((self.file, self.time, self.value, self.name))


class WaveTruth(Model):
    """A wave as the truth of a surface gauge, whose error is that of the wave part.

    of : the wave; level : height y of the still surface [m]; window : (start, end) [s] of the comparison, None for all

    >>> wave = SolitaryWave(height=0.05, depth=0.25, at=2.0)
    >>> gauge = SurfaceGauge("gauge", at=2.0, truth=WaveTruth(wave, level=0.25))
    >>> print(f"{gauge.truth.series(2.0, [0.0])[0]:.3f} m")
    0.300 m
    """

    of: AnyWave
    level: float = Field(description="height y of the still surface [m]")
    window: Window = None

    def series(self, x: float, times: Floats, y: float | None = None) -> Floats:
        """Return the height of the surface [m] at x, in 3D at x and y [m], and times (n,) [s]."""
        return self.level + self.of.surface(x, y, np.asarray(times, dtype=float))


def bands_of(truth: Model | None) -> Sequence[PeakBand]:
    """Return the PeakBands of a truth; truth : of a probe, or None."""
    return truth.bands if isinstance(truth, Peaks) else truth.peaks if isinstance(truth, Truth) else ()


def intervals(truth: Model | None) -> tuple[tuple[float, float], ...]:
    """Return the intervals (start, end) [s] in which the greatest values of a probe count; () for all of the run.

    truth : of the probe, or None. They are those of its bands, or else its window.
    """
    window = truth.window if isinstance(truth, (Truth, WaveTruth)) else None
    return tuple((band.start, band.end) for band in bands_of(truth)) or (() if window is None else (window,))


def read_truth(truth: Truth) -> tuple[Floats, Floats]:
    """Return all times (n,) [s] and values (n,) [the probe's unit] of a Truth.

    Raises:
    CaseError : the file cannot be read, a column is missing, or a value is not a number. The message shows only a
        few words of the file, because a stored case may name any file.
    """
    try:
        names, lines = reading.read_columns(truth.file)
    except OSError as error:
        raise CaseError(f"truth.file = {shown(truth.file)}: cannot be read ({error.strerror})") from None
    except ValueError as error:
        raise CaseError(f"truth.file = {shown(truth.file)}: cannot be read ({error})") from None
    for field, name in (("time", truth.time), ("value", truth.value), *(("rows", name) for name in truth.rows)):
        if name not in names:
            raise CaseError(f"truth.{field} = {shown(name)}: {named(truth.file)} has no such column; "
                            f"it has {reading.listed(names)}")
    columns = [names.index(truth.time), names.index(truth.value)]
    words = {names.index(name): word for name, word in truth.rows.items()}
    data = np.array([_numbers(truth, number, [cells[k] for k in columns]) for number, cells in lines.items()
                     if all(cells[k] == word for k, word in words.items())]).reshape(-1, 2)
    if len(data) < 2 or np.any(np.diff(data[:, 0]) <= 0):
        such = f", where {shown(truth.rows)}" if truth.rows else ""
        raise CaseError(f"truth.file = {shown(truth.file)}: must have at least two lines of finite numbers, "
                        f"at increasing times{such}")
    return data[:, 0] * truth.time_scale, truth.offset + truth.scale * data[:, 1]


def _numbers(truth: Truth, line: int, cells: Sequence[str]) -> list[float]:
    try:
        found = [float(cell) for cell in cells]
    except ValueError:
        found = [np.nan]
    if not all(abs(number) <= LARGEST for number in found):    # false also for nan
        raise CaseError(f"truth.file = {shown(truth.file)}: line {line} holds something that is not a finite "
                        f"number of at most {LARGEST:g} in {shown(truth.time)} or {shown(truth.value)}")
    return found
