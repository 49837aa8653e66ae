"""The sampling of a run's probes: every n steps, or at a fixed rate in time."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from parisph.case.numerics import Output
from parisph.driver.peaks import Peaks
from parisph.driver.schedule import ROUNDING, Times
from parisph.driver.simulation import Simulation
from parisph.watch import instruments
from parisph.watch.sampling import Sampler

Values = dict[str, tuple[float, ...]]    # of each probe
Line = tuple[float, int, Values]         # time [s], step, values


@dataclass
class _Clock:
    """Probes whose values are of the same times: those of the particles, or those of the pressure.

    now : time of their values [s]
    since : up to where samples are taken [s]
    last : (time [s], values) at the beginning of a step that passes a sample, or None
    """

    samplers: Sequence[Sampler]
    now: float
    since: float
    last: tuple[float, Values] | None = None


class Watch:
    """The samples of a run's probes. All methods are collective unless stated otherwise.

    Samples have the time of what they measure: that of the particles, the end of a step, or for pressures on walls
    that of the pressure, in a projection the middle of the step. What is due after the last pressure of a run has that
    pressure, so that all series reach the end. At a fixed rate, samples are taken at exactly k intervals, by linear
    interpolation in time between two steps, and probes are evaluated around these only. Nothing has to be stored for a
    restart, which evaluates them again at the beginning of its first step.

    Parameters
    ----------
    simulation : Simulation
    samplers : list of Sampler (io.probes.build)
    output : Output of the case
    peaks : Peaks, which sees the values of its probes in every step
    """

    def __init__(self, simulation: Simulation, samplers: list[Sampler], output: Output, peaks: Peaks) -> None:
        self.simulation, self.samplers, self.peaks = simulation, samplers, peaks
        self._every = output.probe_every
        self._interval = output.probe_interval or 0.0    # [s]
        self._times = Times(self._interval) if self._interval else None
        self._places, self._pressures = (
            _Clock([sampler for sampler in samplers if sampler.of_pressure is pressures], 0.0, 0.0)
            for pressures in (False, True))
        self._clocks = [clock for clock in (self._places, self._pressures) if clock.samplers]
        self._look_at_clocks()

    def title(self, sampler: Sampler) -> str:
        """Return the line for the head of a probe's file. Not collective."""
        if self._times is None:
            return f"{sampler.title}{'; time is that of the pressure' * sampler.of_pressure}"
        apart = sampler.probe.every * self._interval
        return f"{sampler.title}; every {apart:.12g} s by linear interpolation in time between the steps around"

    def reached(self, sampler: Sampler) -> float:
        """Return the time [s] up to which samples of a probe are final now. Not collective."""
        if self.simulation.finished():
            return self.simulation.reached
        return (self._pressures if sampler.of_pressure else self._places).now + self.simulation.rounding

    def at_start(self) -> list[Line]:
        """Return the lines [(time [s], step, {probe: values})] of the start of a run."""
        s = self.simulation
        self._look_at_clocks()
        found = self._sample(self.samplers)
        self.peaks.look(found)
        return [(s.time, s.steps, found)]

    def before_step(self, after: float) -> None:
        """Evaluate the probes before a step that ends at `after` [s], if it contains samples."""
        s = self.simulation
        self._look_at_clocks()
        if self._times is None:
            return
        needed = []
        for clock in self._clocks:
            clock.since = clock.now + s.rounding
            passes = self._times.after(clock.since) < after - ROUNDING * (after - s.time)
            if passes and (clock.last is None or clock.last[0] != clock.now):
                needed.append(clock)
        found = self._sample([sampler for clock in needed for sampler in clock.samplers])
        for clock in needed:
            clock.last = clock.now, found

    def after_step(self) -> list[Line]:
        """Return the lines [(time [s], step, {probe: values})] that are due after the step."""
        s = self.simulation
        self._look_at_clocks()
        due = [self._due(clock) for clock in self._clocks]
        found = self._sample(self._needed(due))
        self.peaks.look(found)
        lines = []
        for clock, own in zip(self._clocks, due):
            if own:
                before, clock.last = clock.last, (clock.now, found)
                lines += [(time, s.steps, self._of(clock, number, _between(before, clock.last, time)))
                          for time, number in own]
        return lines

    def _look_at_clocks(self) -> None:
        self._places.now, self._pressures.now = self.simulation.time, self.simulation.pressure_time

    def _needed(self, due: Sequence[Sequence[tuple[float, int]]]) -> Sequence[Sampler]:
        """Return the samplers to evaluate after a step, in their order. Not collective.

        At a fixed rate all of a clock, if there are samples: the next step may begin with these values.
        """
        needed = {id(sampler) for clock, own in zip(self._clocks, due) for sampler in clock.samplers
                  if sampler.probe.peak or (own and self._times) or any(_is_for(sampler, number) for _, number in own)}
        return [sampler for sampler in self.samplers if id(sampler) in needed]

    def _of(self, clock: _Clock, number: int, values: Values) -> Values:
        """Return the values of the probes of a clock that have the sample of that number."""
        return {sampler.name: values[sampler.name] for sampler in clock.samplers if _is_for(sampler, number)}

    def _due(self, clock: _Clock) -> list[tuple[float, int]]:
        """Return the samples that the last step has made due: their times [s] and numbers. Not collective."""
        s, done = self.simulation, self.simulation.finished()
        if self._times is None:
            times = [clock.now] if clock.now >= s.time or not done else [clock.now, s.time]
            return [] if s.steps % self._every else [(time, s.steps // self._every) for time in times]
        end = s.reached if done else clock.now + s.rounding
        return [(time, round(time / self._interval)) for time in self._times.between(clock.since, end)]

    def _sample(self, samplers: Sequence[Sampler]) -> Values:
        s = self.simulation
        with s.timers("probes"):
            return instruments.sample_all(samplers, s.particles, s.domain, s.time)


def _is_for(sampler: Sampler, number: int) -> bool:
    """Return whether the sample of that number, from 0 on, is one of the sampler's."""
    return number % sampler.probe.every == 0


def _between(before: tuple[float, Values] | None, after: tuple[float, Values], time: float) -> Values:
    """Return {probe: values} at `time` by interpolation between two samples (time, {probe: values}).

    If a value of either sample is nan, the nearer one is taken.
    """
    if before is None:
        return after[1]
    share = (time - before[0]) / (after[0] - before[0])
    if share > 1.0 - ROUNDING:
        return after[1]
    found = {}
    for name, values in after[1].items():
        if name not in before[1]:    # of the other clock
            continue
        a, b = np.array(before[1][name]), np.array(values)
        mixed = np.where(np.isfinite(a + b), a + share * (b - a), a if share < 0.5 else b)
        found[name] = tuple(mixed.tolist())
    return found
