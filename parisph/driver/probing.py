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
        self._times = Times(output.probe_interval) if output.probe_interval else None
        # (time [s], values) at the beginning of a step that passes a sample
        self._last: tuple[float, Values] | None = None
        self._since = 0.0    # [s], up to where samples are taken

    def title(self, sampler: Sampler) -> str:
        """Return the line for the head of a probe's file. Not collective."""
        if self._times is None:
            return sampler.title
        return (f"{sampler.title}; every {self._times.every:.12g} s by linear interpolation in time between "
                "the steps around")

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
        found = self._sample(self.samplers if due else self.peaks.samplers)
        self.peaks.look(found)
        if not due:
            return []
        before, self._last = self._last, (s.time, found)
        return [(time, s.steps, _between(before, self._last, time)) for time in due]

    def _due(self) -> list[float]:
        """Return the times of the samples [s] that the last step has made due. Not collective."""
        s = self.simulation
        if self._times is None:
            return [] if s.steps % self._every else [s.time]
        return self._times.between(self._since, s.reached)

    def _sample(self, samplers: Sequence[Sampler]) -> Values:
        s = self.simulation
        with s.timers("probes"):
            return instruments.sample_all(samplers, s.particles, s.domain, s.time)


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
