"""A long run: the scene, what is watched in it, and how it ended."""

import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from parisph import Box, Case, Energy, Fluid, Numerics, SurfaceGauge, Tank
from parisph.base.errors import ParisphError
from parisph.watch import instruments
from tests.hard.flow import Bench, nearest
from tests.hard.table import ENDED, Line

G, DEPTH, DENSITY = 9.81, 1.0, 1000.0    # of water and its depth, in SI units
SAMPLES = 40    # of a period, at most: one in each step if there are fewer


@dataclass(frozen=True)
class Setting:
    """What is asked of all runs alike.

    preset : name, None for that of the part
    step : fixed time step over sqrt(d/g), None for an adaptive one
    periods : length of the run, None for that of the part
    limit : CPU time [s] after which a run is ended
    """

    preset: str | None = None
    step: float | None = None
    periods: float | None = None
    limit: float = 3600.0

    def time_step(self, depth: float, g: float) -> float | None:
        """Return the fixed time step in water of a depth [m], None for an adaptive one [s]."""
        return None if self.step is None else float(self.step * np.sqrt(depth / g))

    def words(self) -> str:
        """Return what differs from the usual, for a name."""
        return (f"-{self.preset}" if self.preset else "") + (f"-step{self.step:g}" if self.step else "")


@dataclass
class Record:
    """What a run has shown, sampled at times (n,) [s], and how it ended.

    gauges : (n, gauges) elevations over the still level [m], of the case's SurfaceGauge probes
    kinetic, total : (n,) [J/m]
    closest : (n,) least distance of two fluid particles over the spacing, at most 1
    lost : particles that have left
    until : when it ended [s]
    end : ENDED, or in which period it ended and why; of a run that failed, its last period is left out
    """

    time: np.ndarray
    gauges: np.ndarray
    kinetic: np.ndarray
    total: np.ndarray
    closest: np.ndarray
    lost: int
    until: float
    end: str


@dataclass(frozen=True)
class Long:
    """A long run.

    case : with SurfaceGauge probes; a probe `energy` is added
    level : height y of the still surface [m]
    period : [s], in which its length is given
    measure : function(Record) that returns list of Line
    """

    case: Case
    level: float
    period: float
    measure: Callable[[Record], list[Line]]


def follow(bench: Bench, long: Long, limit: float) -> Record:
    """Compute a long run to its end, or to that of its CPU time [s], and return its Record, whatever becomes of it."""
    begun, end, lost, rows = time.process_time(), ENDED, 0, []
    watched = long.case.model_copy(update={"probes": (*long.case.probes, Energy(name="energy"))})
    samplers = None
    try:
        for s in bench.flow(long.case):
            samplers = samplers or instruments.build(watched, s.comm)
            lost = s.left.particles
            if rows and s.time < rows[-1][0] + long.period / SAMPLES and not s.finished():
                continue
            found = instruments.sample_all(samplers, s.particles, s.domain, s.time)
            kinetic, _, total = found.pop("energy")
            rows.append((s.time, kinetic, total, nearest(s), *(y - long.level for y, in found.values())))
            if time.process_time() - begun > limit:
                end = f"not finished after {limit:g} CPU s, in period {s.time / long.period:.1f}"
                break
    except ParisphError as error:
        reached = rows[-1][0] if rows else 0.0
        end = (f"failed in period {reached / long.period:.1f}: {type(error).__name__}: "
               f"{str(error).partition(chr(10))[0]}")
        return _record([row for row in rows if row[0] <= reached - long.period or row[0] == 0.0], lost, reached, end)
    return _record(rows, lost, rows[-1][0], end)


def _record(rows, lost, until, end):
    t, kinetic, total, closest, *elevations = np.array(rows).T
    return Record(t, np.array(elevations).T, kinetic, total, closest, lost, until, end)


def tank(title: str, length: float, values: Mapping[str, float], setting: Setting, places: Iterable[float],
         end_time: float, preset: str = "gentle", over: float = 0.5, start: Mapping[str, Any] | None = None,
         **more: Any) -> Case:
    """Return a case of water DEPTH deep in a tank of a length [m], with gauges at places x (n,) [m].

    values : of the axes, among them "depth" over the spacing and maybe "jitter"
    over : about what the walls are higher than the water, over the depth; start : of the Fluid; more : of the Case
    """
    count = values["depth"]
    return Case(
        title=title, fluid=Fluid(Box(width=length, height=DEPTH), density=DENSITY, **(start or {})), gravity=(0.0, -G),
        walls=Tank(width=length, height=DEPTH * (1.0 + round(over * count) / count)),
        numerics=Numerics(preset=setting.preset or preset, spacing=DEPTH / count, jitter=values.get("jitter", 0.0),
                          seed=1, time_step=setting.time_step(DEPTH, G)),
        probes=gauges(places), end_time=end_time, **more)


def gauges(places: Iterable[float]) -> list[SurfaceGauge]:
    """Return gauges at x (n,) [m]."""
    return [SurfaceGauge(f"gauge_{number}", at=x) for number, x in enumerate(places)]


def common(record: Record, period: float, periods: float, apart: float | None = 0.5) -> list[Line]:
    """Return what is asked of every run: that it ends, that no pair comes together, and that no water is lost.

    apart : least distance over the spacing that is required, None for a report: pairs of "violent" collide at 0.45
    """
    return [Line("periods", record.until / period, 0.99 * periods, least=True),
            Line("closest pair / s", record.closest.min(), apart, least=True), Line("lost", record.lost, 0)]


def of_level(level: np.ndarray, unit: float, word: str, most: float | None) -> list[Line]:
    """Return lines on the error of a mean level (n,) [m], over a unit [m] that a word names. most : that is required"""
    return [Line(f"level / {word} at the end", level[-1] / unit),
            Line("level, largest size", np.abs(level).max() / unit, most)]
