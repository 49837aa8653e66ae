"""Voronoi cells inside the fluid (3D), as kernels.interior in 2D.

A cell is star-shaped about its particle. So its volume is the mean of r^3 over all directions times 4 pi/3, where r is
the distance to the first bisector. DIRECTIONS points of a Fibonacci spiral give the mean over disordered cells to .01 %
and the cube of a lattice to .003 % (Gonzalez 2010, Math. Geosci. 42, 49-64).
"""

import math

import numpy as np

from parisph.base.arrays import Floats
from parisph.base.fields import BALLISTIC, INNER, SURFACE, WALL
from parisph.kernels.interior import before_wall
from parisph.kernels.jit import kernel, subkernel
from parisph.kernels.records import Cloud

MOST = 512        # neighbours of one particle; a cell with more is skipped
DIRECTIONS = 474
NEAR = 1.8        # [spacings] distance of the neighbours that close most cells, with corners up to .9 away


def spiral(many: int = DIRECTIONS) -> Floats:
    """Return unit vectors (3, many), evenly spread."""
    k = np.arange(many) + 0.5
    z, angle = 1.0 - 2.0 * k / many, np.pi * (1.0 + math.sqrt(5.0)) * k
    ring = np.sqrt(1.0 - z * z)
    return np.stack([ring * np.cos(angle), ring * np.sin(angle), z])


@kernel
def interior_volumes(cloud: Cloud, cells: np.ndarray, away: float, reach: float,
                     toward: np.ndarray) -> tuple[float, float, int]:
    """Return (sum of the volumes [m^3], cells represented, number) of owned Voronoi cells inside the fluid.

    Inside are inner particles farther than `away` from every surface and ballistic particle. Cells end at walls. A cell
    that the neighbours within the reach do not close is skipped.

    cells : as of `interior.interior_cells`
    away <= reach : at most the radius of the lists [m]; toward : (3, m), evenly spread unit vectors
    """
    d, size, nearness, m = np.empty((3, MOST)), np.empty(MOST), np.empty(toward.shape[1]), toward.shape[1]
    total, meant, count, near = 0.0, 0.0, 0, NEAR * cloud.spacing
    for i in range(len(cloud.indptr) - 1):
        if cloud.role[i] != INNER:
            continue
        n = _neighbours(d, size, i, cloud, away, reach, len(cells) > 0)
        if n == 0:
            continue
        nearness[:] = 0.0
        farthest = _look(nearness, d, size, n, toward, 0.0, near)
        # a site cuts off only corners farther away than half its distance
        if near < reach and 2.0 * farthest > near:
            farthest = _look(nearness, d, size, n, toward, near, min(reach, 2.0 * farthest))
        if 2.0 * farthest < reach:
            cubes = 0.0
            for k in range(m):
                cubes += 1.0 / (nearness[k] * nearness[k] * nearness[k])
            total += 4.0 / 3.0 * math.pi * cubes / m
            count += 1
            meant += cells[i] if len(cells) > 0 else 1.0
    return total, meant, count


@subkernel
def _neighbours(d, size, i, cloud, away, reach, to_walls):
    """Write r_ij and |r_ij| of the neighbours within the reach; return their number, 0 near the surface.

    to_walls : whether the images of the particle behind walls count in place of wall particles
    """
    x, role, n = cloud.x, cloud.role, 0
    for k in range(cloud.indptr[i], cloud.indptr[i + 1]):
        j = cloud.indices[k]
        dx, dy, dz = x[j, 0] - x[i, 0], x[j, 1] - x[i, 1], x[j, 2] - x[i, 2]
        d2 = dx * dx + dy * dy + dz * dz
        if (role[j] == SURFACE or role[j] == BALLISTIC) and d2 < away * away:
            return 0
        if to_walls and cloud.kind[j] == WALL:
            depth = before_wall(i, j, cloud)
            dx, dy = -2.0 * depth * cloud.normal[j, 0], -2.0 * depth * cloud.normal[j, 1]
            dz, d2 = -2.0 * depth * cloud.normal[j, 2], 4.0 * depth * depth
        if 0.0 < d2 < reach * reach:
            if n == len(size):
                return 0
            d[0, n], d[1, n], d[2, n], size[n] = dx, dy, dz, math.sqrt(d2)
            n += 1
    return n


@subkernel
def _look(nearness, d, size, n, toward, least, most):
    """Raise 1/r (m,) in all directions to those of the sites in least <= |r_j| < most; return the greatest r."""
    for j in range(n):
        if not least <= size[j] < most:
            continue
        half = 2.0 / (size[j] * size[j])
        ex, ey, ez = half * d[0, j], half * d[1, j], half * d[2, j]
        for k in range(len(nearness)):    # the compiler vectorises this
            own = ex * toward[0, k] + ey * toward[1, k] + ez * toward[2, k]
            nearness[k] = own if own > nearness[k] else nearness[k]
    lowest = math.inf
    for k in range(len(nearness)):
        lowest = min(lowest, nearness[k])
    return 1.0 / lowest if lowest > 0.0 else math.inf
