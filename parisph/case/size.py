"""Estimates of the number of particles of a case and of their memory."""

import numpy as np

from parisph.case.bodies import Body, Obstacle, Plate, Profile, StillWater
from parisph.case.scene import Scene
from parisph.case.shapes import Tank

MOST = 2**31 - 1    # rows of the pressure matrix that 32-bit integers can number
# Peak memory of the dam break on one rank, with preconditioner: 231, 301 and 487 MB for 3840, 30,720 and 119,040
# particles. A run that first compiles its kernels takes 110 MB more.
BYTES = 2500.0  # per particle
BASE = 223e6    # interpreter, libraries and kernels of one rank


def memory(particles: float, ranks: int = 1) -> float:
    """Return the greatest memory [bytes] of a run, on all ranks together."""
    return BASE * ranks + BYTES * particles


def counts(case: Scene) -> dict[str, int]:
    """Return {"fluid": n, "wall": n, "all": n}, estimates of particle numbers; geometry.build.counts is exact."""
    s, area, length = case.numerics.spacing, 0.0, 0.0
    for fluid in case.fluids:
        width, height = case.bounds_of(fluid)[1] - case.bounds_of(fluid)[0]
        filled = width * height if isinstance(fluid.shape, StillWater) else fluid.shape.area
        area += max(float(filled), s * float(width))    # at least one particle per column
    for body in case.bodies:
        length += _length(body)
    fluid_count, wall = int(area / s**2), int(length / s)
    return {"fluid": fluid_count, "wall": wall, "all": fluid_count + wall}


def _length(body: Body) -> float:
    """Return the length of the outline of a body [m], 0 for a wavemaker, which has few nodes."""
    if isinstance(body, (Profile, Plate)):
        sides = 2.0 if isinstance(body, Plate) else 1.0
        return sides * float(np.linalg.norm(np.diff(body.points, axis=0), axis=1).sum())
    if isinstance(body, Tank):
        return 2.0 * body.height + (1.0 + body.closed) * body.width
    if isinstance(body, Obstacle):
        return 2.0 * float(np.sum(body.bounds[1] - body.bounds[0]))
    return 0.0
