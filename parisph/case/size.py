"""The number of particles of a case and the memory they need, computed before any of them is made."""

import numpy as np

from parisph.case.lattice import Lattice, boundary_size
from parisph.case.methods import METHODS
from parisph.case.scene import Scene
from parisph.case.shapes import Box

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
    area.
    """
    wall, exact = _walls(case), True
    if search(case) > MOST or any(n > MOST for n in _extent(case)):
        fluid, exact = int(case.fluid.shape.area / case.numerics.spacing**2), False
    else:
        lattice = Lattice(case.fluid.shape, case.walls, case.numerics.spacing)
        exact = isinstance(case.fluid.shape, Box) or search(case) * case.fluid.shape.edges <= LOOKED_AT
        fluid = lattice.count() if exact else int(case.fluid.shape.area / lattice.step.prod())
    return {"fluid": fluid, "wall": wall, "all": fluid + wall, "exact": exact}


def search(case: Scene) -> float:
    """Return the number of lattice points in the smallest block that holds the fluid, as a float."""
    lower, upper = case.fluid.shape.bounds
    return float(np.prod((upper - lower) / case.numerics.spacing + 1.0))


def mostly_empty(case: Scene) -> bool:
    """Return whether too many lattice points would be searched for too little fluid."""
    shape = case.fluid.shape
    if isinstance(shape, Box) or search(case) * shape.edges <= SEARCHED:
        return False
    return shape.area / case.numerics.spacing**2 < LEAST_FILLED * search(case)


def _extent(case: Scene) -> list[float]:
    """Lengths of the tank in spacings; none without a tank."""
    return [] if case.walls is None else [float(length) / case.numerics.spacing for length in case.walls.size]


def _walls(case: Scene) -> int:
    """Number of wall particles, in Python's integers, which do not overflow."""
    if case.walls is None:
        return 0
    points = [max(round(n), 1) + 1 for n in _extent(case)]
    closed = [True] * (len(points) - 1) + [case.walls.closed]
    return sum(boundary_size([n + layer * (1 + int(upper)) for n, upper in zip(points, closed)], closed)
               for layer in range(METHODS[case.numerics.method].wall_layers))
