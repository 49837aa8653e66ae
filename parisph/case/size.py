"""The number of particles of a case and the memory they need, computed before any of them is made."""

import numpy as np

from parisph.case.bodies import Body, Obstacle, Plate, Profile, StillWater
from parisph.case.lattice import Lattice, boundary_size
from parisph.case.methods import METHODS
from parisph.case.scene import Scene
from parisph.case.shapes import Box, Disc, Polygon, Tank

MOST = 2**31 - 1    # rows of the pressure matrix that 32-bit numbers can name
LOOKED_AT = 4 * 10**6   # lattice points, times edges of a polygon, that are looked at one by one to count the fluid

# Making the particles of a Disc or Polygon takes each rank about 0.4 us per lattice point and edge, and no signal
# stops it. Where more than this would be searched, at least a tenth of the points must be fluid.
SEARCHED = 2 * 10**8
LEAST_FILLED = 0.1

# Measured: peak memory of the dam break on one rank, 231, 301 and 487 MB with 3840, 30,720 and 119,040
# particles, preconditioner included. A run that compiles its kernels first takes 110 MB more.
BYTES = 2500.0  # per particle
BASE = 223e6    # interpreter, libraries and kernels of one rank


def memory(particles: float, ranks: int = 1) -> float:
    """Return the bytes that a run takes at most, on all its ranks together."""
    return BASE * ranks + BYTES * particles


def counts(case: Scene) -> dict[str, int]:
    """Return {"fluid": n, "wall": n, "all": n, "exact": bool}, the numbers of particles as int. Needs little memory.

    Exact, except for a Disc or a Polygon among more than LOOKED_AT lattice points: its number is estimated from its
    area. So is that of a scene that is not plain, generously (geometry.build.counts is exact).
    """
    if not case.plain:
        return _estimate(case)
    wall, exact = _walls(case), True
    if search(case) > MOST or any(n > MOST for n in _extent(case)):
        fluid, exact = int(_shape(case).area / case.numerics.spacing**2), False
    else:
        shape = _shape(case)
        lattice = Lattice(shape, case.tank, case.numerics.spacing)
        exact = isinstance(shape, Box) or search(case) * shape.edges <= LOOKED_AT
        fluid = lattice.count() if exact else int(shape.area / lattice.step.prod())
    return {"fluid": fluid, "wall": wall, "all": fluid + wall, "exact": exact}


def _estimate(case: Scene) -> dict[str, int]:
    """counts() of a scene that is not plain: areas and lengths over those of the spacing."""
    s, area, length = case.numerics.spacing, 0.0, 0.0
    for fluid in case.fluids:
        lower, upper = case.bounds_of(fluid)
        area += float(np.prod(upper - lower)) if isinstance(fluid.shape, StillWater) else fluid.shape.area
    for body in case.bodies:
        length += _length(body)
    fluid_count, wall = int(area / s**2), int(length / s)
    return {"fluid": fluid_count, "wall": wall, "all": fluid_count + wall, "exact": False}


def _length(body: Body) -> float:
    """Length of the outline of a body [m], 0 for a wavemaker, which has few nodes."""
    if isinstance(body, (Profile, Plate)):
        sides = 2.0 if isinstance(body, Plate) else 1.0
        return sides * float(np.linalg.norm(np.diff(body.points, axis=0), axis=1).sum())
    if isinstance(body, (Tank, Obstacle)):
        return 2.0 * float(np.sum(body.bounds[1] - body.bounds[0]))
    return 0.0


def _shape(case: Scene) -> Box | Disc | Polygon:
    """Return the shape of the fluid of a plain scene."""
    shape = case.fluids[0].shape
    assert not isinstance(shape, StillWater)
    return shape


def search(case: Scene) -> float:
    """Return the number of lattice points in the smallest block that holds the fluid, as a float."""
    lower, upper = _shape(case).bounds
    return float(np.prod((upper - lower) / case.numerics.spacing + 1.0))


def mostly_empty(case: Scene) -> bool:
    """Return whether too many lattice points would be searched for too little fluid."""
    shape = _shape(case)
    if isinstance(shape, Box) or search(case) * shape.edges <= SEARCHED:
        return False
    return shape.area / case.numerics.spacing**2 < LEAST_FILLED * search(case)


def _extent(case: Scene) -> list[float]:
    """Lengths of the tank in spacings; none without a tank."""
    return [] if case.tank is None else [float(length) / case.numerics.spacing for length in case.tank.size]


def _walls(case: Scene) -> int:
    """Number of wall particles, in Python's integers, which do not overflow."""
    if case.tank is None:
        return 0
    points = [max(round(n), 1) + 1 for n in _extent(case)]
    closed = [True] * (len(points) - 1) + [case.tank.closed]
    return sum(boundary_size([n + layer * (1 + int(upper)) for n, upper in zip(points, closed)], closed)
               for layer in range(METHODS[case.numerics.method].wall_layers))
