"""Tanks that overflow, and water just below a lid."""

from functools import partial

import numpy as np

from parisph.case.schema import Box, Case, Fluid, Numerics, Sway, Tank
from tests.hard.flow import Bench, History
from tests.hard.scene import Scene
from tests.hard.table import Line

S = 0.025


def swayed(height: float, amplitude: float, lid: bool, end: float) -> Case:
    """Return water 1 m long and 0.5 m deep in a tank of this height [m], swayed near its first frequency."""
    return Case(title="swayed", fluid=Fluid(Box(width=1.0, height=0.5), density=1000.0),
                walls=Tank(width=1.0, height=height, lid=lid), gravity=(0.0, -9.81),
                frame=Sway(amplitude=amplitude, frequency=5.0), numerics=Numerics(spacing=S), end_time=end)


def overflowing(bench: Bench) -> list[Line]:
    """Water that sways over the rims of an open tank: what is in it and what has left it is all there was."""
    start, worst, left = None, 0.0, 0.0
    for s in bench.flow(swayed(0.55, 0.08, lid=False, end=4.0)):
        inside = s.particles.volume.sum()
        start, left = start or inside, s.left.volume
        worst = max(worst, abs(inside + left - start) / start)
    return [Line("volume that has left over that at the start", left / start, 0.02, least=True),
            Line("volume in the tank and of what left, error", worst, 1e-12)]


def below_lid(bench: Bench) -> list[Line]:
    """Water one spacing below a lid, swayed until it hits it everywhere."""
    found = History.of(bench, swayed(0.5 + S, 0.05, lid=True, end=3.0))
    return found.volume_lines()


def at_rest(bench: Bench, height: float, lid: bool) -> list[Line]:
    """Water at rest in a tank of this height [m], jittered inside: it stays where it is."""
    jittered = {"numerics.jitter": 0.4, "numerics.seed": bench.seed, "numerics.time_step": 0.005}
    case = swayed(height, 0.0, lid, end=3.0).changed(**jittered)
    speeds = bench.follow(case, lambda s: np.abs(s.particles.u).max())
    return [Line("largest speed / sqrt(g d)", speeds.max() / np.sqrt(9.81 * 0.5), 1e-4)]


SCENES = {
    "overflow": Scene("a tank that overflows, 4 s", overflowing, may_stop=True),
    "lid": Scene("water one spacing below a lid, swayed, 3 s", below_lid, may_stop=True),
    "lid-rest": Scene("water at rest one spacing below a lid, 3 s", partial(at_rest, height=0.5 + S, lid=True),
                      jittered=True),
    "rest": Scene("water at rest in an open tank, violent preset, 3 s", partial(at_rest, height=0.75, lid=False),
                  jittered=True),
}
