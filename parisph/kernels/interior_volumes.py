"""Voronoi cells inside the fluid (3D), as kernels.interior in 2D.

A cell is star-shaped about its particle. So its volume is the mean of r^3 over all directions times 4 pi/3, where r is
the distance to the first bisector. DIRECTIONS points of a Fibonacci spiral give the mean over disordered cells to .01 %
and the cube of a lattice to .05 % (Gonzalez 2010, Math. Geosci. 42, 49-64).
"""

import math

import numpy as np

from parisph.base.arrays import Floats
from parisph.base.fields import BALLISTIC, INNER, SURFACE
from parisph.kernels.jit import kernel, subkernel
from parisph.kernels.records import Cloud

MOST = 512        # neighbours of one particle; a cell with more is skipped
DIRECTIONS = 400
LEAST = 1e-9      # of the distance of a neighbour: least part of it along a direction that meets its bisector


def spiral(many: int = DIRECTIONS) -> Floats:
    """Return unit vectors (many, 3), evenly spread."""
    k = np.arange(many) + 0.5
    z, angle = 1.0 - 2.0 * k / many, np.pi * (1.0 + math.sqrt(5.0)) * k
    ring = np.sqrt(1.0 - z * z)
    return np.stack([ring * np.cos(angle), ring * np.sin(angle), z], axis=1)


@kernel
def interior_volumes(cloud: Cloud, away: float, reach: float, toward: np.ndarray) -> tuple[float, int]:
    """Return (sum of the volumes [m^3], number) of the Voronoi cells of owned particles inside the fluid.

    Inside are inner particles farther than `away` from every surface and ballistic particle. The sites are fluid and
    wall particles. A cell that the neighbours within the reach do not close is skipped.

    away <= reach : at most the radius of the lists [m]; toward : (m, 3), evenly spread unit vectors
    """
    d, limit = np.empty((3, MOST)), np.empty(MOST)
    total, count = 0.0, 0
    for i in range(len(cloud.indptr) - 1):
        if cloud.role[i] != INNER:
            continue
        n = _neighbours(d, limit, i, cloud, away, reach)
        if n == 0:
            continue
        cubes, farthest = 0.0, 0.0
        for k in range(len(toward)):
            r = _reach(d, limit, n, toward[k, 0], toward[k, 1], toward[k, 2])
            cubes += r * r * r
            farthest = max(farthest, r)
        # sites beyond the reach can cut off only corners farther away than half the reach
        if 2.0 * farthest < reach:
            total += 4.0 / 3.0 * math.pi * cubes / len(toward)
            count += 1
    return total, count


@subkernel
def _neighbours(d, limit, i, cloud, away, reach):
    """Write r_ij and |r_ij|^2/2 of the neighbours within the reach; return their number, 0 near the surface."""
    x, role, n = cloud.x, cloud.role, 0
    for k in range(cloud.indptr[i], cloud.indptr[i + 1]):
        j = cloud.indices[k]
        dx, dy, dz = x[j, 0] - x[i, 0], x[j, 1] - x[i, 1], x[j, 2] - x[i, 2]
        d2 = dx * dx + dy * dy + dz * dz
        if (role[j] == SURFACE or role[j] == BALLISTIC) and d2 < away * away:
            return 0
        if d2 < reach * reach:
            if n == len(limit):
                return 0
            d[0, n], d[1, n], d[2, n], limit[n] = dx, dy, dz, 0.5 * d2
            n += 1
    return n


@subkernel
def _reach(d, limit, n, ex, ey, ez):
    """Return the distance in a direction to the first bisector, infinite without any."""
    nearest = math.inf
    for j in range(n):
        ahead = d[0, j] * ex + d[1, j] * ey + d[2, j] * ez
        nearest = min(nearest, limit[j] / ahead if ahead * ahead > LEAST * limit[j] and ahead > 0.0 else math.inf)
    return nearest
