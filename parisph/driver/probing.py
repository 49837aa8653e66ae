"""The sampling of a run's probes: every n steps, or at a fixed rate in time."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from parisph.base.arrays import Array, Floats
from parisph.case.numerics import Output
from parisph.driver.peaks import PeakFlows
from parisph.driver.schedule import ROUNDING, Times
from parisph.driver.simulation import Simulation
from parisph.watch import instruments
from parisph.watch.means import Means, between
from parisph.watch.sampling import Sampler

Values = dict[str, tuple[float, ...]]    # of each probe
Line = tuple[float, int, Values]         # time [s], step, values


@dataclass
class _Clock:
    """Probes with values at the same times: those of particles, or those of pressure.

    now : time of their values [s]
    since : time up to which samples are taken [s]
    last : (time [s], values) at the beginning of a step that passes a sample, or None
    """

    samplers: Sequence[Sampler]
    now: float
    since: float
    last: tuple[float, Values] | None = None


class Watch:
    """The samples of a run's probes. All methods are collective unless stated otherwise.

    Samples have the time of their quantity: the end of a step, or for pressures on walls the time of the pressure, in a
    projection the middle of the step. A sample due after the last pressure of a run has that pressure, so all series
    reach the end. At a fixed rate, samples are at exactly k intervals, by linear interpolation in time between two
    steps, and probes are evaluated only around these times, and at a restart.

    Pressures of a projection are means in time (watch.means). Their probes are evaluated in every step, and a sample is
    written when its mean is known, some steps later. A restart needs the state of the means.

    samplers : list of Sampler (watch.instruments.build)
    output : Output of the case
    peaks : PeakFlows, which gets the values of its probes in every step, means when they are known
    state : `state()` of an earlier part of the run, from its checkpoint
    """

    def __init__(self, simulation: Simulation, samplers: list[Sampler], output: Output, peaks: PeakFlows,
                 state: Mapping[str, Any] | None = None) -> None:
        self.simulation, self.samplers, self.peaks = simulation, samplers, peaks
        self._every = output.probe_every
        self._interval = output.probe_interval or 0.0    # [s]
        self._times = Times(self._interval) if self._interval else None
        self._places, self._pressures = (
            _Clock([sampler for sampler in samplers if sampler.of_pressure is pressures], 0.0, 0.0)
            for pressures in (False, True))
        self._averaged = simulation.pressure_window is not None and bool(self._pressures.samplers)
        self._clocks = [clock for clock in (self._places, self._pressures)
                        if clock.samplers and not (self._averaged and clock is self._pressures)]
        self._start = simulation.time    # of the last step [s]
        self._means: Means | None = None
        self._pending: list[tuple[float, int, int]] = []    # samples waiting for their means: time [s], step, number
        if state and self._averaged:
            self._means = Means.resumed(state["means"])
            self._pending = [(time, step, number) for time, step, number in state["pending"]]
        self._look_at_clocks()

    def title(self, sampler: Sampler) -> str:
        """Return the title in a probe's file. Not collective."""
        mean = "; mean in time with the impulse of the pressure" * (sampler.of_pressure and self._averaged)
        if self._times is None:
            return f"{sampler.title}{'; time is that of the pressure' * sampler.of_pressure}{mean}"
        apart = sampler.probe.every * self._interval
        return f"{sampler.title}; every {apart:.12g} s by linear interpolation in time between the steps around{mean}"

    def reached(self, sampler: Sampler) -> float:
        """Return the time [s] up to which samples of a probe are final. Not collective."""
        if self.simulation.finished():
            return self.simulation.reached
        if sampler.of_pressure and self._means is not None:
            return self._means.known + self.simulation.rounding
        return (self._pressures if sampler.of_pressure else self._places).now + self.simulation.rounding

    def state(self) -> dict[str, Any]:
        """Return the data that a checkpoint needs. Not collective."""
        return {} if self._means is None else {"means": self._means.state(), "pending": self._pending}

    def at_start(self) -> list[Line]:
        """Return the lines [(time [s], step, {probe: values})] of the start of a run."""
        s = self.simulation
        self._look_at_clocks()
        found = self._sample(self.samplers)
        if self._averaged:
            self._means = Means(s.time, self._joined(found))
        self._look_at_peaks(found)
        return [(s.time, s.steps, found)]

    def before_step(self, after: float) -> None:
        """Evaluate the probes before a step that ends at `after` [s], if it contains samples."""
        s = self.simulation
        self._look_at_clocks()
        if self._averaged and self._means is None:    # the checkpoint is of an earlier version
            self._means = Means(self._pressures.now, self._joined(self._sample(self._pressures.samplers)), s.time)
        self._start, self._pressures.since = s.time, self._pressures.now + s.rounding
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
        lines: list[Line] = []
        if self._means is not None:
            lines = self._mean_lines(found, self._means)
        self._look_at_peaks(found)
        for clock, own in zip(self._clocks, due):
            if own:
                before, clock.last = clock.last, (clock.now, found)
                lines += [(time, s.steps, self._of(clock, number, _between(before, clock.last, time)))
                          for time, number in own]
        return lines

    def look_at_last(self) -> None:
        """Pass the means of the last steps to the peaks, if the run has ended."""
        means = self._means
        if means is not None and self.simulation.finished():
            self.peaks.look_at_last(lambda time: self._at(means, time, ended=True))

    def _look_at_peaks(self, found: Values) -> None:
        """Pass the values of this step to the peaks, and the means that are now known."""
        s, means, averaged = self.simulation, self._means, set()
        if means is not None:
            averaged = {sampler.name for sampler in self._pressures.samplers}
            self.peaks.look_at_means(averaged, means.knots, means.known + s.rounding,
                                     lambda time: self._at(means, time))
            self.look_at_last()
        self.peaks.look({name: values for name, values in found.items() if name not in averaged})

    def _at(self, means: Means, time: float, ended: bool = False) -> Values:
        """Return the values of the pressure probes at a time [s] with known means."""
        mean, acted = means.at(time, ended)
        return self._values(np.where(self._as_acted, acted, mean))

    def _mean_lines(self, found: Values, means: Means) -> list[Line]:
        """Return the lines of pressures whose means became known in the last step. Not collective."""
        s, clock, ended = self.simulation, self._pressures, self.simulation.finished()
        means.add(self._start, s.time, clock.now, self._joined(found), s.pressure_window or 0.0)
        self._pending += [(time, s.steps, number) for time, number in self._due(clock)]
        known, lines = means.known + s.rounding, []
        for time, step, number in self._pending:
            if ended or time <= known:
                lines.append((time, step, self._of(clock, number, self._at(means, time, ended))))
        # a run continued beyond its end gets better means of the last ones, but no sample after its last pressure
        self._pending = [line for line in self._pending if known < line[0] <= clock.now + s.rounding]
        return lines

    def _joined(self, found: Values) -> Floats:
        """Return the values (n,) of all pressure probes, concatenated."""
        return np.concatenate([found[sampler.name] for sampler in self._pressures.samplers])

    def _values(self, joined: Floats) -> Values:
        """Return {probe: values} of the pressure probes from their concatenated values."""
        ends = np.cumsum([len(sampler.columns) for sampler in self._pressures.samplers])
        return {sampler.name: tuple(own.tolist())
                for sampler, own in zip(self._pressures.samplers, np.split(joined, ends[:-1]))}

    @property
    def _as_acted(self) -> Array:
        """Which of the values (n,) of pressure probes are not averaged."""
        return np.array([name in sampler.acted for sampler in self._pressures.samplers for name in sampler.columns])

    def _look_at_clocks(self) -> None:
        self._places.now, self._pressures.now = self.simulation.time, self.simulation.pressure_time

    def _needed(self, due: Sequence[Sequence[tuple[float, int]]]) -> Sequence[Sampler]:
        """Return the samplers to evaluate after a step, in their order. Not collective.

        Those of means always. At a fixed rate all of a clock with samples: the next step may begin with these values.
        """
        needed = {id(sampler) for clock, own in zip(self._clocks, due) for sampler in clock.samplers
                  if sampler.probe.peak or (own and self._times) or any(_is_for(sampler, number) for _, number in own)}
        return [sampler for sampler in self.samplers
                if id(sampler) in needed or (self._averaged and sampler.of_pressure)]

    def _of(self, clock: _Clock, number: int, values: Values) -> Values:
        """Return the values of the probes of a clock that take the sample of this number."""
        return {sampler.name: values[sampler.name] for sampler in clock.samplers if _is_for(sampler, number)}

    def _due(self, clock: _Clock) -> list[tuple[float, int]]:
        """Return the samples due after the last step: their times [s] and numbers. Not collective."""
        s, done = self.simulation, self.simulation.finished()
        if self._times is None:
            times = [clock.now] if clock.now >= s.time or not done else [clock.now, s.time]
            return [] if s.steps % self._every else [(time, s.steps // self._every) for time in times]
        end = s.reached if done else clock.now + s.rounding
        return [(time, round(time / self._interval)) for time in self._times.between(clock.since, end)]

    def _sample(self, samplers: Sequence[Sampler]) -> Values:
        s = self.simulation
        with s.timers("probes"):
            return instruments.sample_all(samplers, s.particles, s.domain, s.time, s.passages)


def _is_for(sampler: Sampler, number: int) -> bool:
    """Return whether a sampler takes the sample of this number, from 0 on."""
    return number % sampler.probe.every == 0


def _between(before: tuple[float, Values] | None, after: tuple[float, Values], time: float) -> Values:
    """Return {probe: values} at `time` by interpolation between two samples (time, {probe: values}).

    If a value of either sample is nan, the nearer one is taken.
    """
    if before is None:
        return after[1]
    if time - before[0] > (1.0 - ROUNDING) * (after[0] - before[0]):
        return after[1]
    # values that before[1] lacks are of the other clock
    ends = {name: [(before[0], np.array(before[1][name])), (after[0], np.array(values))]
            for name, values in after[1].items() if name in before[1]}
    return {name: tuple(between(line, time).tolist()) for name, line in ends.items()}
