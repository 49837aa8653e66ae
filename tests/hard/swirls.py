"""Vortices in full boxes, at rest and shaken, and the rotating patch."""

import numpy as np

from parisph.case.schema import AtRest, Box, Case, Fluid, Numerics, Sway, Tank
from tests.hard.flow import Bench, History, fluid, flying_among_others
from tests.hard.scene import Scene
from tests.hard.table import Line
from tests.scenes import scene

CELL = ("sin(pi*x)*cos(pi*y)", "-cos(pi*x)*sin(pi*y)")     # [m/s] in the unit box: steady, an exact solution
SHAKEN = Sway(amplitude=0.05, frequency=6.0)
EVERY = 10    # steps between two looks at the roles


def full(velocity=(0.0, 0.0), frame=None, side: int = 40, end: float = 5.0, **numerics) -> Case:
    """Return a full closed unit box. side : spacings; numerics : parts of Numerics"""
    return Case(title="full box", fluid=Fluid(Box(width=1.0, height=1.0), density=1000.0, velocity=velocity),
                walls=Tank(width=1.0, height=1.0, lid=True), gravity=(0.0, 0.0), frame=frame or AtRest(),
                numerics=Numerics(spacing=1.0 / side, **numerics), end_time=end)


def vortex(bench: Bench) -> list[Line]:
    """The energy of a steady vortex, which is constant."""
    found = History.of(bench, full(CELL))
    kinetic = found.kinetic / found.kinetic[0]
    return [Line("change of the kinetic energy after 5 s", abs(kinetic[-1] - 1.0), 0.15, 0.05),
            Line("largest rise of the kinetic energy", kinetic.max() - 1.0), *found.volume_lines()]


def shaken(bench: Bench) -> list[Line]:
    """A full box moves as one body: in its frame the fluid stays at rest."""
    speeds = bench.follow(full(frame=SHAKEN, side=20, end=3.0, jitter=0.4, seed=bench.seed),
                          lambda s: np.linalg.norm(s.particles.u[fluid(s)], axis=1).max())
    return [Line("largest speed over that of the tank", speeds.max() / SHAKEN.top_rate, 1e-6)]


def shaken_vortex(bench: Bench, steps: int = 100) -> list[Line]:
    """Shaking a full box changes the pressure and nothing else.

    Jittered: on the lattice there are ties, which rounding decides.
    """
    how = {"time_step": 0.01, "rtol": 1e-13, "jitter": 0.2, "seed": bench.seed}
    cases = [full(CELL, frame, side=20, **how) for frame in (None, SHAKEN)]
    at_rest, moved = (_positions(bench, case, steps) for case in cases)
    away = np.abs(moved - at_rest).max() / (steps * 0.01)    # the vortex has a top speed of 1 m/s
    return [Line(f"difference from the box at rest after {steps} steps / way", away, 1e-9)]


def _positions(bench, case, steps):
    for s in bench.flow(case, most=steps):
        found = s.particles.x[np.argsort(s.particles.id)].copy()
    return found


def patch(bench: Bench) -> list[Line]:
    """The rotating square, side 40 spacings, until its arms are long and thin."""
    kinetic, flying = [], []
    for s in bench.flow(scene("rotating_patch", spacing=0.025, end_time=10.0)):
        p = s.particles
        kinetic.append((s.time, p.volume @ (p.u**2).sum(axis=1)))
        if s.steps % EVERY == 0:
            flying.append(flying_among_others(s))
    t, energy = np.array(kinetic).T
    energy /= energy[0]
    return [Line("error of the kinetic energy at t omega = 4", abs(np.interp(4.0, t, energy) - 1.0), 0.015),
            Line("error of the kinetic energy at t omega = 10", abs(np.interp(10.0, t, energy) - 1.0), 0.03),
            Line("largest rise of the kinetic energy", energy.max() - 1.0),
            Line("most ballistic particles with five neighbours", max(flying), 0)]


SCENES = {
    "vortex": Scene("a vortex in a full closed box, 40 x 40, 5 s", vortex),
    "box-shaken": Scene("a full closed box, jitter 0.4, shaken 3 s", shaken, jittered=True),
    "box-shaken-vortex": Scene("a vortex in a shaken full box, and in one at rest", shaken_vortex, jittered=True),
    "patch": Scene("rotating patch, s = side/40, to t omega = 10", patch),
}
