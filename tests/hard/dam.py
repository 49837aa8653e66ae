"""Dam breaks: long, coarse, disordered, and with steps that are too long."""

from functools import partial

import numpy as np

from parisph.case.schema import Case
from parisph.driver.conservation import VOLUME_LIMIT, Conservation
from tests.hard.flow import Bench, History, fluid
from tests.hard.scene import Scene
from tests.hard.table import Line
from tests.scenes import scene

LONG, EARLY = 40.0, 10.0    # t sqrt(g/H)


def broken(spacing: float, end: float, jitter: float = 0.2, seed: int = 0, **sets) -> Case:
    """Return the dam break of cases/. spacing : over H; end : t sqrt(g/H)"""
    return scene("dam_break", spacing=spacing, end_time=end, jitter=jitter, seed=seed, **sets)


def long(bench: Bench, end: float = LONG) -> list[Line]:
    """The dam break at H/s = 40 far beyond its impact. Of its volume more is required until t* = 10."""
    found = History.of(bench, broken(0.025, end, seed=bench.seed))
    errors = np.abs(found.cell - 1.0)[found.time <= EARLY / np.sqrt(9.81)]
    return [Line("volume error in 99 % of the steps to t* = 10", float(np.nanquantile(errors, 0.99)), 0.01),
            Line("largest volume error to t* = 10", np.nanmax(errors), 0.013, 0.01), *found.volume_lines(),
            Line("largest rise of the energy above its start", found.energy_rise())]


def coarse(bench: Bench, end: float = LONG) -> list[Line]:
    """The same with 200 particles."""
    found = History.of(bench, broken(0.05, end, seed=bench.seed))
    return [*found.volume_lines(often=0.03), Line("largest rise of the energy above its start", found.energy_rise())]


def disordered(bench: Bench) -> list[Line]:
    """A start in the greatest disorder that a case may have, to t* = 4."""
    found = History.of(bench, broken(0.025, 4.0, jitter=1.2, seed=bench.seed))
    return [*found.volume_lines(), Line("largest rise of the energy above its start", found.energy_rise())]


def fast(bench: Bench, cfl: float) -> list[Line]:
    """Adaptive steps of a whole spacing and more, to t* = 4: volume is kept, or its loss is said.

    The limit by acceleration, which would keep these steps short, is off.
    """
    watch, moved = None, 0.0
    case = broken(0.025, 4.0, seed=bench.seed, time_step="none", cfl=cfl).changed(**{"numerics.fall": 0.0})
    for s in bench.flow(case):
        watch = watch or Conservation(s)
        watch.measure(s)
        moved = max(moved, np.linalg.norm(s.particles.u[fluid(s)], axis=1).max() * (s.dt or 0.0) / 0.025)
    ends = watch.volume.extremes()
    worst = max(abs(ends["low"]), abs(ends["high"]))
    said = any("volume" in line for line in watch.passed().values())
    return [Line("longest way of a particle in a step / s", moved), Line("largest volume error", worst),
            Line("volume error of which no warning speaks", 0.0 if said else worst, VOLUME_LIMIT),
            Line("fluid particles at the end over the start", fluid(s).sum() / (20 * 40), 1.0, least=True)]


SCENES = {
    "dam-40": Scene("dam break, H/s = 40, to t* = 40", long, limit=1200.0, jittered=True),
    "dam-200": Scene("dam break of 200 particles, to t* = 40", coarse, jittered=True),
    "dam-jitter-1.2": Scene("dam break, H/s = 40, jitter 1.2, to t* = 4", disordered, jittered=True),
    **{f"dam-cfl-{cfl:g}": Scene(f"dam break, H/s = 40, cfl {cfl:g}, to t* = 4", partial(fast, cfl=cfl),
                                 may_stop=True, jittered=True) for cfl in (1.0, 1.5)},
}
