"""Voronoi cells inside the fluid (2D): an unbiased measure of volume on disordered particles.

A kernel-sum density is wrong by several per cent on disordered particles, and the union of discs hides losses; the mean
area of the Voronoi cells is neither. The edges of a cell are followed in order: at each corner, the next edge belongs
to the neighbour whose bisector is met first. Each edge is visited once, and nothing is sorted.
"""

import math

import numpy as np

from parisph.base.fields import BALLISTIC, INNER, SURFACE, WALL
from parisph.kernels.jit import inlined, kernel, subkernel
from parisph.kernels.records import Cloud

MOST = 256  # neighbours of one particle; a cell with more is skipped


@kernel
def interior_cells(cloud: Cloud, cells: np.ndarray, away: float, reach: float) -> tuple[float, float, int]:
    """Return (sum of the areas [m^2], cells represented, number) of owned Voronoi cells inside the fluid.

    Inside are inner particles farther than `away` from every surface and ballistic particle. Cells end at walls. A cell
    that the neighbours within the reach do not close is skipped, because its area would depend on the lists.

    cells : (n_owned,), those that particles represent, with half cells at walls; or empty, where fluid at walls stays
        there: wall particles then have cells of their own, and each fluid particle represents one
    away <= reach : at most the radius of the lists [m]
    """
    rx, ry, limit, along = np.empty(MOST), np.empty(MOST), np.empty(MOST), np.empty(MOST)
    total, meant, count = 0.0, 0.0, 0
    for i in range(len(cloud.indptr) - 1):
        if cloud.role[i] != INNER:
            continue
        n = _neighbours(rx, ry, limit, i, cloud, away, reach, len(cells) > 0)
        area, farthest2 = _walk(rx, ry, limit, along, n)
        # sites beyond the reach can cut off only corners farther away than half the reach
        if 4.0 * farthest2 < reach * reach:
            total += area
            count += 1
            meant += cells[i] if len(cells) > 0 else 1.0
    return total, meant, count


@subkernel
def _neighbours(rx, ry, limit, i, cloud, away, reach, to_walls):
    """Write r_ij and |r_ij|^2/2 of the neighbours within the reach; return their number, 0 near the surface.

    to_walls : whether the images of the particle behind walls count in place of wall particles
    """
    x, role, n = cloud.x, cloud.role, 0
    for k in range(cloud.indptr[i], cloud.indptr[i + 1]):
        j = cloud.indices[k]
        dx, dy = x[j, 0] - x[i, 0], x[j, 1] - x[i, 1]
        d2 = dx * dx + dy * dy
        if (role[j] == SURFACE or role[j] == BALLISTIC) and d2 < away * away:
            return 0
        if to_walls and cloud.kind[j] == WALL:
            depth = before_wall(i, j, cloud)
            dx, dy = -2.0 * depth * cloud.normal[j, 0], -2.0 * depth * cloud.normal[j, 1]
            d2 = 4.0 * depth * depth
            if d2 == 0.0:
                continue
        if d2 < reach * reach:
            if n == len(rx):
                return 0
            rx[n], ry[n], limit[n] = dx, dy, 0.5 * d2
            n += 1
    return n


@inlined
def before_wall(i: int, j: int, cloud: Cloud) -> float:
    """Return the distance [m] of particle i from the wall of particle j, 0 if it is not straight before this particle.

    Particles in corners have no wall of their own.
    """
    depth, d2 = 0.0, 0.0
    for a in range(len(cloud.axes)):
        depth += (cloud.x[i, a] - cloud.x[j, a]) * cloud.normal[j, a]
        d2 += (cloud.x[i, a] - cloud.x[j, a]) ** 2
    straight = not cloud.corner[j] and d2 - depth * depth < cloud.spacing * cloud.spacing
    return max(depth, 0.0) if straight else 0.0


@subkernel
def _walk(rx, ry, limit, along, n):
    """Return the area of the cell { p : p . r_j <= |r_j|^2/2 } and its farthest corner's distance squared.

    The distance is infinite if the cell is open.
    """
    if n == 0:
        return 0.0, math.inf
    first = 0
    for j in range(1, n):
        if limit[j] < limit[first]:
            first = j
    here = first  # the bisector of the nearest neighbour is always an edge
    px, py = 0.5 * rx[here], 0.5 * ry[here]
    twice, farthest2 = 0.0, 0.0
    for _ in range(n):
        ex, ey = -ry[here], rx[here]
        tiny = 1e-9 * limit[here]
        # distance along the edge to each bisector; two plain loops, which the compiler vectorises
        for j in range(n):
            ahead = rx[j] * ex + ry[j] * ey
            along[j] = (limit[j] - rx[j] * px - ry[j] * py) / ahead if ahead > tiny else math.inf
        t = math.inf
        for j in range(n):
            t = min(t, along[j])
        if not t < math.inf:
            break
        here = 0
        while along[here] != t:
            here += 1
        qx, qy = px + t * ex, py + t * ey
        twice += px * qy - py * qx
        farthest2 = max(farthest2, qx * qx + qy * qy)
        px, py = qx, qy
        if here == first:
            return 0.5 * (twice + 0.5 * (px * ry[first] - py * rx[first])), farthest2
    return 0.0, math.inf
