"""Estimates of the number of particles of a case and of their memory."""

import numpy as np

from parisph.case.bodies import Body, Obstacle, Plate, Profile, StillWater
from parisph.case.breadth import Spread, section_of
from parisph.case.fluids import Fluid
from parisph.case.scene import Scene
from parisph.case.shapes import Tank

MOST = 2**31 - 1    # rows of the pressure matrix that 32-bit integers can number
# Peak memory of the dam break on one rank, with preconditioner: 231, 301 and 487 MB for 3840, 30,720 and 119,040
# particles. A run that first compiles its kernels takes 110 MB more.
BYTES = 2500.0  # per particle, and in 3D the slope between two tanks of 18,900 and 68,600 unknowns
BYTES_3D = 5600.0
BASE = 223e6    # interpreter, libraries and kernels of one rank


def memory(particles: float, ranks: int = 1, dim: int = 2) -> float:
    """Return the greatest memory [bytes] of a run in `dim` dimensions, on all ranks together."""
    return BASE * ranks + (BYTES if dim == 2 else BYTES_3D) * particles


def counts(case: Scene) -> dict[str, int]:
    """Return {"fluid": n, "wall": n, "all": n}, estimates of particle numbers; geometry.build.counts is exact."""
    s, area, length = case.numerics.spacing, 0.0, 0.0
    for fluid in case.fluids:
        lower, upper = case.bounds_of(fluid)
        width, height = float(upper[0] - lower[0]), float(upper[-1] - lower[-1])
        filled = width * height if isinstance(fluid.shape, StillWater) else fluid.shape.area
        area += max(float(filled), s * width) * _across(case, fluid)    # at least one particle per column
    for body in case.bodies:
        length += _length(body) * _across(case, body) + _ends(case, body)
    fluid_count, wall = int(area / s**case.dim), int(length / s ** (case.dim - 1))
    return {"fluid": fluid_count, "wall": wall, "all": fluid_count + wall}


def _across(case: Scene, part: Spread | Fluid) -> float:
    """Return the length of a part across a 3D scene [m], 1 in 2D."""
    ends = case.extent_of(part)
    return 1.0 if ends is None else ends[1] - ends[0]


def _ends(case: Scene, body: Body) -> float:
    """Return the area of the front and the back of a body of a 3D scene [m2], 0 in 2D.

    Those of a bed are as high as its box. The ends of an obstacle against the walls of the scene do not count.
    """
    if case.dim == 2 or not isinstance(body, (Tank, Profile, Obstacle)):
        return 0.0
    if isinstance(body, Obstacle):
        return 0.0 if body.extent is None else 2.0 * body.shape.area
    lower, upper = body.bounds
    return 2.0 * float((upper[0] - lower[0]) * (upper[-1] - lower[-1])) if body.breadth is not None else 0.0


def _length(body: Body) -> float:
    """Return the length of the outline of a body in the section [m], 0 for a wavemaker, which has few nodes."""
    if isinstance(body, (Profile, Plate)):
        sides = 2.0 if isinstance(body, Plate) else 1.0
        return sides * float(np.linalg.norm(np.diff(body.points, axis=0), axis=1).sum())
    if isinstance(body, Tank):
        return 2.0 * body.height + (1.0 + body.closed) * body.width
    if isinstance(body, Obstacle):
        lower, upper = body.bounds
        return 2.0 * float(np.sum(section_of(upper - lower)))
    return 0.0
