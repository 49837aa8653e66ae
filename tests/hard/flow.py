"""One scene followed step by step, and what is measured in it."""

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from mpi4py import MPI

from parisph import Case, Energy, Volume
from parisph.base.fields import BALLISTIC, FLUID
from parisph.driver import Simulation
from parisph.kernels.cells import neighbour_lists
from parisph.watch import instruments
from tests.hard.table import Line

NEAR = 2.1    # spacings: the reach of velocity gradients


class Bench:
    """Runs the flows of one scene on one rank, and counts their steps and CPU seconds.

    seed : of jittered starts
    steps, cpu_seconds : of all flows so far; the time of measuring is in them
    """

    def __init__(self, seed: int = 1):
        self.seed, self.steps, self.cpu_seconds = seed, 0, 0.0

    def flow(self, case: Case, until: float | None = None, most: int | None = None) -> Iterator[Simulation]:
        """Yield the Simulation of a case at the start and after each step.

        until : time [s] at which to end, instead of the end of the case
        most : number of steps after which to end, None for any
        """
        case = case if until is None else case.changed(end_time=until)
        begun, s = time.process_time(), Simulation(case, MPI.COMM_SELF)
        try:
            s.solve_start()
            yield s
            while not s.finished() and (most is None or s.steps < most):
                s.advance()
                self.steps += 1
                yield s
        finally:
            s.destroy()
            self.cpu_seconds += time.process_time() - begun

    def follow(self, case: Case, look: Callable, until: float | None = None, most: int | None = None) -> np.ndarray:
        """Return look(Simulation) at the start and after each step, one row each."""
        return np.array([look(s) for s in self.flow(case, until, most)])


class Measured:
    """Energy and volume of a Simulation, as the probes see them.

    watch(simulation) returns time [s], kinetic and total energy [J/m], and the mean Voronoi cell inside the
    fluid over its value on the lattice (nan if nothing is deep inside).
    """

    def __init__(self):
        self._samplers = None

    def __call__(self, s: Simulation) -> tuple[float, float, float, float]:
        """Return (time, kinetic, total, cell)."""
        if self._samplers is None:
            wanted = (Energy(name="energy"), Volume(name="volume"))
            self._samplers = instruments.build(s.case.model_copy(update={"probes": wanted}), s.comm)
        found = instruments.sample_all(self._samplers, s.particles, s.domain, s.time)
        kinetic, _, total = found["energy"]
        return s.time, kinetic, total, found["volume"][0]


@dataclass
class History:
    """What `Measured` saw in each step, as arrays (steps + 1,): time [s], kinetic, total [J/m], cell."""

    time: np.ndarray
    kinetic: np.ndarray
    total: np.ndarray
    cell: np.ndarray

    @classmethod
    def of(cls, bench: Bench, case: Case, until: float | None = None, most: int | None = None) -> "History":
        """Follow a case to its end."""
        return cls(*bench.follow(case, Measured(), until, most).T)

    def energy_rise(self) -> float:
        """Return the largest total energy over its start, minus one."""
        return self.total.max() / self.total[0] - 1.0

    def volume_errors(self) -> np.ndarray:
        """Return |cell - 1| of the steps in which there was a cell deep inside."""
        return np.abs(self.cell - 1.0)[np.isfinite(self.cell)]

    def volume_lines(self, often: float | None = None, always: float | None = None) -> list[Line]:
        """Return lines for the volume: its error in 99 % of the steps, and always.

        often, always : what is required of them, None for a report. Both are nan if no step had a cell deep inside.
        """
        errors = self.volume_errors()
        found = (float(np.quantile(errors, 0.99)), errors.max()) if len(errors) else (np.nan, np.nan)
        return [Line("volume error in 99 % of the steps", found[0], often),
                Line("largest volume error", found[1], always)]

    def at(self, name: str, time: float) -> float:
        """Return a quantity at a time [s], interpolated between steps."""
        return float(np.interp(time, self.time, getattr(self, name)))


def fluid(s: Simulation) -> np.ndarray:
    """Return which particles are fluid, (n,) bool."""
    return s.particles.kind == FLUID


def nearest(s: Simulation) -> float:
    """Return the least distance of two fluid particles over the spacing, at most 1."""
    x, spacing = s.particles.x[fluid(s)], s.numerics.spacing
    start, other = neighbour_lists(x, len(x), spacing)
    if not len(other):
        return 1.0
    this = np.repeat(np.arange(len(x)), np.diff(start))
    return float(np.linalg.norm(x[this] - x[other], axis=1).min() / spacing)


def flying_among_others(s: Simulation, neighbours: int = 5) -> int:
    """Return how many particles are ballistic though so many neighbours are within 2.1 spacings."""
    p = s.particles
    start, _ = neighbour_lists(p.x, len(p.x), NEAR * s.numerics.spacing)
    return int(np.count_nonzero((p.role == BALLISTIC) & (np.diff(start) >= neighbours)))
