"""The sampling of a run's probes: every n steps, or at a fixed rate in time."""

from collections.abc import Sequence

import numpy as np

from parisph.case.numerics import Output
from parisph.driver.peaks import Peaks
from parisph.driver.schedule import ROUNDING, Times
from parisph.driver.simulation import Simulation
from parisph.watch import instruments
from parisph.watch.sampling import Sampler

Values = dict[str, tuple[float, ...]]    # of each probe
Line = tuple[float, int, Values]         # time [s], step, values


class Watch:
    """The samples of a run's probes. All methods are collective unless stated otherwise.

    At a fixed rate, samples are taken at exactly k intervals, by linear interpolation in time between
    the ends of the step that contains them. Probes are evaluated in these steps only. Nothing has to
    be stored for a restart, which evaluates them again at the beginning of its first step.

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
        # (time [s], values) at the beginning of a step that passes a sample
        self._last: tuple[float, Values] | None = None
        self._since = 0.0    # [s], up to where samples are taken

    def title(self, sampler: Sampler) -> str:
        """Return the line for the head of a probe's file. Not collective."""
        if self._times is None:
            return sampler.title
        apart = sampler.probe.every * self._interval
        return f"{sampler.title}; every {apart:.12g} s by linear interpolation in time between the steps around"

    def at_start(self) -> list[Line]:
        """Return the lines [(time [s], step, {probe: values})] of the start of a run."""
        s = self.simulation
        found = self._sample(self.samplers)
        self.peaks.look(found)
        return [(s.time, s.steps, found)]

    def before_step(self, after: float) -> None:
        """Evaluate the probes before a step that ends at `after` [s], if it contains samples."""
        s = self.simulation
        self._since = s.reached
        if self._times is None or not self._times.after(self._since) < after - ROUNDING * (after - s.time):
            return
        if self._last is None or self._last[0] != s.time:
            self._last = s.time, self._sample(self.samplers)

    def after_step(self) -> list[Line]:
        """Return the lines [(time [s], step, {probe: values})] that are due after the step."""
        s = self.simulation
        due = self._due()
        found = self._sample(self._needed(due))
        self.peaks.look(found)
        if not due:
            return []
        before, self._last = self._last, (s.time, found)
        return [(time, s.steps, self._of(number, _between(before, self._last, time))) for time, number in due]

    def _needed(self, due: Sequence[tuple[float, int]]) -> Sequence[Sampler]:
        """Return the samplers to evaluate after a step. Not collective.

        At a fixed rate all of them, if there are samples: the next step may begin with these values.
        """
        if due and self._times is not None:
            return self.samplers
        return [sampler for sampler in self.samplers
                if sampler.probe.peak or any(_is_for(sampler, number) for _, number in due)]

    def _of(self, number: int, values: Values) -> Values:
        """Return the values of the probes that have the sample of that number."""
        return {sampler.name: values[sampler.name] for sampler in self.samplers if _is_for(sampler, number)}

    def _due(self) -> list[tuple[float, int]]:
        """Return the samples that the last step has made due: their times [s] and numbers. Not collective."""
        s = self.simulation
        if self._times is None:
            return [] if s.steps % self._every else [(s.time, s.steps // self._every)]
        return [(time, round(time / self._interval)) for time in self._times.between(self._since, s.reached)]

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
        a, b = np.array(before[1][name]), np.array(values)
        mixed = np.where(np.isfinite(a + b), a + share * (b - a), a if share < 0.5 else b)
        found[name] = tuple(mixed.tolist())
    return found
