"""Diagnostics of a run: measures that reveal a wrong flow, their limits, and remedies."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any, NamedTuple, Optional

import numpy as np
from mpi4py import MPI

from parisph.base.arrays import Floats
from parisph.base.errors import SolverDiverged
from parisph.base.fields import FLUID
from parisph.case.bodies import motion_of
from parisph.case.motion import AtRest
from parisph.case.probes import Gauge, up
from parisph.case.schema import Case
from parisph.driver.conservation import BREAKING, Conservation
from parisph.driver.simulation import Simulation
from parisph.io.reader import Run
from parisph.kernels.closest import least_distance
from parisph.watch import instruments
from parisph.watch.probes.surface_gauge import SurfaceGauge
from parisph.watch.sampling import ProbeScene


class Limit(NamedTuple):
    """A limit of a measure: its value, the range of sensible values, their source, and a remedy."""

    value: float
    range: tuple[float, float]
    source: str
    advice: str


# Remedies tried: a steep gentle wave far beyond these limits within a period keeps them with "violent"; a violent one
# with 1.08 of its energy after 10 periods has 1.00 with "gentle"; a gentle one that breaks down after 9 periods,
# d/s = 10, keeps all limits with 20; and a filter that takes 26 % of a wave takes 17 %.
FINER = "use a smaller spacing"
OTHER = f"{FINER}, or {{other}}"
PRESETS = {"violent": BREAKING,
           "gentle": 'preset="gentle" for waves that do not break'}
LIMITS = {
    # kinetic energy over all energy in motion at the start, of a flow without work on it: at most 1 in reality
    "motion": Limit(1.05, (1.02, 1.2), "runs that are right: 1.00; waves that feed on errors: 1.1 to 3", OTHER),
    # energy in motion from the surface over that at the start, of the same flow; it may lag by part of a wave
    "grown": Limit(1.2, (1.1, 1.5), "standing waves, ten to forty particles long: 1.00 to 1.05; those that feed on "
                   "errors: 1.35 and more", OTHER),
    # mean level of a tank over the height of its waves, both means over LASTING
    "level": Limit(0.05, (0.03, 0.1), "standing waves: 0.01; those that break down: 0.1 to 1", OTHER),
    # height of a wave at a gauge, relative to the median, for regular waves that should be equal
    "height": Limit(0.15, (0.05, 0.3), "flumes: 0.05; waves that lose half of it in 50 periods: 0.5", FINER),
    # least distance of two particles over the spacing
    "pair": Limit(0.2, (0.1, 0.4), "impacts and breaking waves: 0.43 or more; waves before they break down: 0.01",
                  OTHER),
    # water that has left an open tank over all water at the start
    "lost": Limit(1e-3, (1e-4, 1e-2), "a particle of a thousand", "make the walls higher"),
}
CALM = 1e-8        # of the total energy: lower waves, of a ten-thousandth of the depth, count as none
EVERY = 10         # steps between two measurements
GAUGES = 16        # in the middles of equal parts of the tank: their mean excludes the first 31 modes
LASTING = 20.0     # sqrt(d/g), averaging time of levels and heights: three periods of a wave as long as the tank
SHORT = 0.05       # of that, between two measurements of the level at least: gauges take as long as a small step
RESOLVED = 1e-3    # spacings: a smaller error of the level is ignored
LOWEST = 0.02      # spacings: lower waves are ignored
WAVES = 8          # fewest waves that a gauge needs for a comparison
REGULAR = 0.1      # of the median period: spread of the periods from the first to the last decile
GROWN = 0.8        # of the median height: the first wave as high begins the comparison
# Kinetic energy over all energy at the start, of a flow without work on it: at most 1 in reality. Explosions that
# calm down, with parts of methods that no preset has, reached 3.5; others went on to 1e5 and more within some hundred
# steps. At this limit all water has ten times the speed that its energy allows.
EXPLODED = 100.0
RISES = ("energy", "motion", "grown")    # limits of energy without work
FRONT = 3          # waves after that to skip: the front of a train is higher


@dataclass
class Seen:
    """The measures of a run so far, as in a checkpoint.

    pair [s], pair_time [s] : the least distance of two particles
    time [s] : of the last measurement of the level
    mean, square : averages over LASTING of the error of the level [m] and of the variance of the elevation [m2]
    off, off_time, off_height : largest error of the level [m], its time [s], height of the waves until then [m]
    high : the greatest height of waves [m]
    """

    pair: float = math.inf
    pair_time: float = 0.0
    time: Optional[float] = None
    mean: float = 0.0
    square: float = 0.0
    high: float = 0.0
    off: float = 0.0
    off_time: float = 0.0
    off_height: float = 0.0


def advice(limit: Limit, preset: str) -> str:
    """Return the remedy of a limit, without naming the preset in use."""
    used = "gentle" if preset == "solitary" else preset
    return limit.advice.format(other=" and ".join(text for name, text in PRESETS.items() if name != used))


class Diagnostics:
    """Measures energy, volume, pairs and the mean level during a run, and compares all with their limits.

    state : `state()` of an earlier part of the run, or empty; start : as of Conservation
    """

    def __init__(self, simulation: Simulation, state: Mapping[str, Any], start: Mapping[str, float | None]) -> None:
        self.conservation = Conservation(simulation, state.get("conservation"), start)
        case, self._spacing, self._preset = simulation.case, simulation.numerics.spacing, simulation.numerics.preset
        self._seen = Seen(**state.get("doubts", {}))
        self._gauges = instruments.build(case.model_copy(update={"probes": _across(case)}), simulation.comm)
        self._noise = _noise(simulation)
        self._start = self._volume(simulation) + simulation.left.volume
        if self._gauges:
            scene = ProbeScene.of(case)
            self._width, self._bed = float(scene.upper[0] - scene.lower[0]), float(scene.lower[-1])
            self._unit = math.sqrt(self._start / self._width / -float(scene.gravity[-1]))
        self._all = simulation.comm.allreduce(int(np.count_nonzero(simulation.particles.kind == FLUID)))
        self._all += simulation.left.particles
        self._left, self._gone = 0.0, 0

    def step(self, simulation: Simulation) -> None:
        """Measure what is due after a step. Collective."""
        self.conservation.step(simulation)
        if simulation.steps % EVERY == 0:
            self._look(simulation)

    def measure(self, simulation: Simulation) -> None:
        """Measure everything now. Collective."""
        self.conservation.measure(simulation)
        self._look(simulation)

    def _look(self, simulation: Simulation) -> None:
        s, p, seen = simulation, simulation.particles, self._seen
        self._left, self._gone = s.left.volume, s.left.particles
        s.domain.update("x")
        own = least_distance(s.method.flow.cloud)
        least = s.comm.allreduce(own, MPI.MIN) / s.numerics.spacing
        if least < seen.pair:
            seen.pair, seen.pair_time = float(least), s.time
        if self._gauges and (seen.time is None or s.time >= seen.time + SHORT * LASTING * self._unit):
            found = instruments.sample_all(self._gauges, p, s.domain, s.time)
            self._look_at_level(s.time, np.array([y for y, in found.values()]), self._volume(s))

    def state(self) -> dict[str, Any]:
        """Return the data that a checkpoint needs for a restart. Not collective."""
        return {"conservation": self.conservation.state(), "doubts": asdict(self._seen)}

    def passed(self) -> dict[str, str]:
        """Return {limit exceeded so far: message}. Not collective."""
        return {**self.conservation.passed(), **dict((*self._of_motion(), *self._of_level(), *self._of_pairs()))}

    def check(self) -> None:
        """Raise SolverDiverged if the flow has exploded: the run would take ever shorter steps.

        Not collective: the numbers are equal on all ranks.
        """
        conservation = self.conservation
        start, now = conservation.energy.start, conservation.kinetic.now
        if conservation.driven or start is None or now is None or not start > 0.0 or now <= EXPLODED * start:
            return
        raise SolverDiverged(f"the kinetic energy has come to {now / start:.3g} times all energy at the start, though "
                             "nothing does work on the fluid: the flow has exploded; "
                             f"{advice(LIMITS['motion'], self._preset)}")

    @property
    def lost(self) -> float:
        """Fraction of the water that has left the tank."""
        return self._left / self._start if self._start else 0.0

    def of_loss(self) -> list[str]:
        """Return a warning about water that has left the tank, if it exceeds the limit. Not collective."""
        limit = LIMITS["lost"]
        if not self.lost > limit.value:
            return []
        return [f"{self._gone:,d} of {self._all:,d} particles, {self.lost:.2%} of the water, left the tank over its "
                f"rim: {limit.advice}"]

    def _look_at_level(self, time: float, elevations: Floats, volume: float) -> None:
        """Average the error of the level, from the volume of the water, and the variance of the elevation."""
        seen = self._seen
        error = elevations.mean() - self._bed - volume / self._width
        share = 1.0 if seen.time is None else -math.expm1(-(time - seen.time) / (LASTING * self._unit))
        seen.time = time
        seen.mean += share * (error - seen.mean)
        seen.square += share * (elevations.var() - seen.square)
        seen.high = max(seen.high, 4.0 * math.sqrt(seen.square))    # as in a significant height
        if abs(seen.mean) > abs(seen.off):
            seen.off, seen.off_time, seen.off_height = seen.mean, time, seen.high

    def _of_motion(self) -> Iterator[tuple[str, str]]:
        conservation = self.conservation
        start, high = conservation.motion.start, conservation.kinetic.high
        limit, noise = LIMITS["motion"], self._noise + CALM * abs(conservation.energy.start or 0.0)
        if conservation.driven or not start or start <= 0.0 or high is None:
            return
        if high > limit.value * start + noise:
            yield "motion", (f"the kinetic energy was {high / start:.3g} times all energy in motion at the start, at "
                             f"t = {conservation.kinetic.high_time:.4g} s, though nothing does work on the fluid: "
                             f"{advice(limit, self._preset)}")
        limit, most = LIMITS["grown"], conservation.motion.high or 0.0
        if conservation.by_surface and most > limit.value * start + noise:
            yield "grown", (f"the energy in motion was {most / start:.3g} times that at the start, at "
                            f"t = {conservation.motion.high_time:.4g} s, though nothing does work on the fluid: "
                            f"{advice(limit, self._preset)}")

    def _of_level(self) -> Iterator[tuple[str, str]]:
        seen, limit, spacing = self._seen, LIMITS["level"], self._spacing
        if abs(seen.off) > RESOLVED * spacing and abs(seen.off) > limit.value * max(seen.off_height, LOWEST * spacing):
            yield "level", (f"the mean level was {seen.off:+.3g} m off at t = {seen.off_time:.4g} s, more than "
                            f"{limit.value:.0%} of the height of the waves, {seen.off_height:.3g} m: "
                            f"{advice(limit, self._preset)}")

    def _of_pairs(self) -> Iterator[tuple[str, str]]:
        seen, limit = self._seen, LIMITS["pair"]
        if seen.pair < limit.value:
            yield "pair", (f"two particles were {seen.pair:.2g} spacings apart at t = {seen.pair_time:.4g} s, closer "
                           f"than {limit.value:g}: {advice(limit, self._preset)}")

    @staticmethod
    def _volume(simulation: Simulation) -> float:
        """Return the volume of the fluid [m^dim]; walls have none. Collective."""
        total: float = simulation.comm.allreduce(float(simulation.particles.volume.sum()))
        return total


def first_rise(passed: Mapping[str, float]) -> str | None:
    """Return a line with the time when energy first exceeded a limit, or None.

    passed : {limit: time [s] of its excess}
    """
    times = [passed[name] for name in RISES if name in passed]
    return f"  energy first rose beyond its limit at t = {min(times):.4g} s" if times else None


def of_gauges(case: Case, run: Run) -> list[str]:
    """Return one line for the gauge with the largest error among those of regular waves that should be equal.

    These are waves of a start that nothing drives or damps, and waves of a moving body or a zone with a zone behind
    them that absorbs them. Not collective.
    """
    if case.constant_force is None or case.viscosity or case.friction is not None or bool(case.zones) != _makes(case):
        return []
    found = []
    for probe in case.probes:
        if isinstance(probe, Gauge) and probe.of_surface and not any(
                zone.start <= probe.at <= zone.end for zone in case.zones):
            series = run.probe(probe.name)
            found.append((*_uneven(series["time"], series[up(case.dim)], case.numerics.spacing), probe.name))
    share, when, name = max(found, key=lambda one: abs(one[0]), default=(0.0, 0.0, ""))
    limit = LIMITS["height"]
    if abs(share) <= limit.value:
        return []
    return [f"a wave at the gauge {name} was {share:+.0%} off the middle one in height, at t = {when:.4g} s, though "
            f"all should be equal: {limit.advice}"]


def heights(time: Floats, y: Floats) -> tuple[Floats, Floats]:
    """Return the beginnings (n,) [s] and heights (n,) [m] of the waves of a signal after the front of the train.

    A wave is between two upward crossings of the linear trend. Returns none if their periods are irregular.
    """
    trend = np.polyval(np.polyfit(time, y, 1), time)
    up = np.flatnonzero((y[:-1] < trend[:-1]) & (y[1:] >= trend[1:]))
    high = np.array([np.ptp(y[begin:end + 1]) for begin, end in zip(up[:-1], up[1:])])
    if not len(high):
        return np.empty(0), high
    first = int(np.argmax(high >= GROWN * np.median(high))) + FRONT
    if first >= len(high):
        return np.empty(0), np.empty(0)
    begins, high, periods = time[up[first:-1]], high[first:], np.diff(time[up[first:]])
    low, middle, top = np.quantile(periods, (0.1, 0.5, 0.9))
    return (begins, high) if top - low <= REGULAR * middle else (begins[:0], high[:0])


def _uneven(time: Floats, y: Floats, spacing: float) -> tuple[float, float]:
    """Return the largest relative deviation of a wave's height from the median, and its beginning [s].

    0 for too few or too low waves.
    """
    begins, high = heights(time, y) if len(time) > 2 else (np.empty(0), np.empty(0))
    if len(high) < WAVES or np.median(high) < LOWEST * spacing:
        return 0.0, 0.0
    relative = high / np.median(high) - 1.0
    worst = int(np.argmax(np.abs(relative)))
    return float(relative[worst]), float(begins[worst])


def _makes(case: Case) -> bool:
    """Return whether a body or a zone of the case makes waves."""
    return any(getattr(zone, "wave", None) is not None for zone in case.zones) or any(
        not isinstance(motion_of(body), AtRest) for body in case.bodies)


def _across(case: Case) -> Sequence[SurfaceGauge]:
    """Return gauges across the water of an open tank if its level is known, with gravity downwards in its frame."""
    scene = ProbeScene.of(case)
    if case.lidded or case.dim != 2 or case.lone_tank is None:
        return ()
    if scene.gravity[0] != 0.0 or not scene.gravity[-1] < 0.0:
        return ()
    if case.fluid_bounds[0][-1] > scene.lower[-1] + case.numerics.spacing:    # falling water has no level
        return ()
    places = scene.lower[0] + (np.arange(GAUGES) + 0.5) * (scene.upper[0] - scene.lower[0]) / GAUGES
    return tuple(SurfaceGauge(f"level-{number}", at=float(at)) for number, at in enumerate(places))


def _noise(simulation: Simulation) -> float:
    """Return three standard deviations of the potential energy of a jittered start [J/m, J in 3D]. Collective."""
    n, case = simulation.numerics, simulation.case
    lift = n.jitter * n.spacing / math.sqrt(12.0)    # of a uniform distribution
    weights = simulation.particles.volume * case.density * float(np.abs(ProbeScene.of(case).gravity).max())
    return 3.0 * lift * math.sqrt(simulation.comm.allreduce(float((weights**2).sum())))
