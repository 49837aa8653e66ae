"""The current volume of each fluid particle (2D): its Voronoi cell, inside walls and the free surface.

Cells are those of the fluid particles alone, cut off at the walls: a particle one spacing in front of a wall has 3/2
cells. The free surface passes through its particles. Each corner of a cell belongs to a triangle of particles
(Delaunay), or at a wall to two particles and their feet on it. It counts with the signed area of the kite between the
particle, its feet on the two sides, and the corner. Corners of triangles too large to be fluid, or on dry walls, do not
count. The kites of a triangle add up to its area even if the corner lies outside, so the sum over all particles is
exactly the area of all triangles.
"""

import math
from collections import namedtuple

import numpy as np

from parisph.base.fields import FLUID, WET
from parisph.kernels.jit import inlined, kernel
from parisph.kernels.records import Cloud, Walls

MOST = 256       # largest numbers of sides of a cell and of wet wall particles near it; others are ignored
# Stretched jets have larger ones.
GAP = 1.0        # tuned 0.75 to 2: circumradius of the largest triangle of fluid, in spacings; judged
NEAR_WALL = 0.75 # tuned 0.5 to 1.5: distance of wet wall particles that make a corner wet, in spacings; judged
NEAR_SIDE = 1.6  # tuned 0.8 to 3.2: distance of neighbours that bound most of a cell, in spacings; judged
ON = 1e-6        # tolerance at an element's ends, over its length
BOX = -1         # side of the initial box, at which a cell is open


# Sides { p : (x, y) . p <= limit } that may bound the cell of a particle, relative to the particle. `member` is the
# neighbour across a side, or -1 for a wall, whose (x, y) has length 1; `wet` are places of wet wall particles.
_Sides = namedtuple("_Sides", "x y limit member wet")
# The corners of a convex polygon, and the side from each corner to the next.
_Polygon = namedtuple("_Polygon", "x y side")


@kernel
def current_volumes(out: np.ndarray, cloud: Cloud, walls: Walls, concave: np.ndarray, reach: float) -> None:
    """Write the current volume out (n_owned,) [m^2] of owned fluid particles, 0 for walls.

    A particle in no triangle, such as a drop, has one cell of the lattice.

    concave : (M, 2) bool, whether the fluid has a concave corner at this end of an element
    reach : [m]; the lists contain all neighbours within it, at least 2.6 spacings
    """
    sides = _Sides(np.empty(MOST), np.empty(MOST), np.empty(MOST), np.empty(MOST, np.int64), np.empty((MOST, 2)))
    cell = _Polygon(np.empty(MOST), np.empty(MOST), np.empty(MOST, np.int64))
    other = _Polygon(np.empty(MOST), np.empty(MOST), np.empty(MOST, np.int64))
    limit, member, spacing = sides.limit, sides.member, cloud.spacing
    near_side = 0.5 * (NEAR_SIDE * spacing) ** 2
    for i in range(len(cloud.indptr) - 1):
        out[i] = 0.0
        if cloud.kind[i] != FLUID:
            continue
        out[i] = spacing * spacing
        n, wet = _sides(sides, i, cloud, reach)
        n = _element_sides(sides, n, i, cloud, walls, concave, reach)
        count, far2 = _box(cell, reach), 2.0 * reach * reach
        for far in (False, True):    # after the near sides, few far ones reach the cell
            for k in range(n):
                if (limit[k] > near_side) == far and (member[k] < 0 or limit[k] < 2.0 * far2):
                    count = _cut(cell, count, other, sides, k)
                    far2 = _farthest(cell, count)
        area, kept = 0.0, 0
        for m in range(count):
            a, b = cell.side[m - 1 if m else count - 1], cell.side[m]
            if a == BOX or b == BOX:
                continue
            if _is_fluid(cell.x[m], cell.y[m], a, b, sides, wet, spacing):
                area += _kite(cell.x[m], cell.y[m], a, b, sides)
                kept += 1
        if kept:
            out[i] = area


@inlined
def _sides(sides, i, cloud, reach):
    """Write the sides between i and other fluid that may bound its cell, and wet places; return both numbers."""
    x, n, w = cloud.x, 0, 0
    for k in range(cloud.indptr[i], cloud.indptr[i + 1]):
        j = cloud.indices[k]
        dx, dy = x[j, 0] - x[i, 0], x[j, 1] - x[i, 1]
        d2 = dx * dx + dy * dy
        if n == MOST // 2 or w == MOST or not d2 < reach * reach:
            continue
        if cloud.kind[j] == FLUID and d2 > 0.0:
            sides.x[n], sides.y[n], sides.limit[n], sides.member[n] = dx, dy, 0.5 * d2, j
            n += 1
        elif cloud.role[j] == WET:
            sides.wet[w, 0], sides.wet[w, 1] = dx, dy
            w += 1
    return n, w


@inlined
def _element_sides(sides, n, i, cloud, walls, concave, reach):
    """Append sides on walls to the first n; return the new number of sides.

    They lie on walls that the particle faces, and on walls behind a concave corner. A particle whose nearest point is
    an edge has a side through the edge, normal to the line to it.
    """
    x, corners = cloud.x, walls.corners
    nearest, ahead, foot_x, foot_y = reach, False, 0.0, 0.0
    for k in range(walls.indptr[i], walls.indptr[i + 1]):
        e = walls.indices[k]
        ax, ay = corners[e, 0, 0] - x[i, 0], corners[e, 0, 1] - x[i, 1]
        sx, sy = corners[e, 1, 0] - corners[e, 0, 0], corners[e, 1, 1] - corners[e, 0, 1]
        length = math.sqrt(sx * sx + sy * sy)
        height = (sy * ax - sx * ay) / length
        if height < -ON * length or n == MOST - 1:
            continue
        t = -(ax * sx + ay * sy) / (length * length)
        within = min(max(t, 0.0), 1.0)
        dx, dy = ax + within * sx, ay + within * sy
        apart = math.sqrt(dx * dx + dy * dy)
        square = -ON <= t <= 1.0 + ON
        if apart < nearest * (1.0 - ON) or (square and apart < nearest * (1.0 + ON)):
            nearest, ahead, foot_x, foot_y = apart, not square, dx, dy
        if height < reach and (square or (t < 0.0 and concave[e, 0]) or (t > 1.0 and concave[e, 1])):
            sides.x[n], sides.y[n], sides.limit[n], sides.member[n] = sy / length, -sx / length, height, -1
            n += 1
    if ahead and nearest > 0.0:
        sides.x[n], sides.y[n], sides.limit[n], sides.member[n] = foot_x / nearest, foot_y / nearest, nearest, -1
        n += 1
    return n


@inlined
def _box(cell, reach):
    """Write the corners of a square around the particle, anticlockwise; return their number."""
    for m in range(4):
        cell.x[m] = reach if m == 0 or m == 3 else -reach
        cell.y[m] = reach if m < 2 else -reach
        cell.side[m] = BOX
    return 4


@inlined
def _farthest(cell, count):
    """Return the largest squared distance of a corner."""
    far2 = 0.0
    for m in range(count):
        far2 = max(far2, cell.x[m] * cell.x[m] + cell.y[m] * cell.y[m])
    return far2


@inlined
def _cut(cell, count, other, sides, side):
    """Cut a convex polygon with a side, in place; return the number of its corners. other : scratch"""
    px, py, nx, ny, limit = cell.x, cell.y, sides.x[side], sides.y[side], sides.limit[side]
    outside = False
    for m in range(count):
        outside = outside or nx * px[m] + ny * py[m] > limit
    if not outside or count > MOST - 2:
        return count
    n = 0
    for m in range(count):
        k = m + 1 if m + 1 < count else 0
        a, b = nx * px[m] + ny * py[m] - limit, nx * px[k] + ny * py[k] - limit
        if a <= 0.0:
            other.x[n], other.y[n], other.side[n] = px[m], py[m], cell.side[m]
            n += 1
        if (a <= 0.0) != (b <= 0.0):
            t = a / (a - b)
            other.x[n], other.y[n] = px[m] + t * (px[k] - px[m]), py[m] + t * (py[k] - py[m])
            other.side[n] = side if a <= 0.0 else cell.side[m]
            n += 1
    for m in range(n):
        px[m], py[m], cell.side[m] = other.x[m], other.y[m], other.side[m]
    return n


@inlined
def _kite(vx, vy, a, b, sides):
    """Return the signed area between the particle, its feet on the sides a and b, and their corner v."""
    nx, ny, limit = sides.x, sides.y, sides.limit
    ta = limit[a] / (nx[a] * nx[a] + ny[a] * ny[a])
    tb = limit[b] / (nx[b] * nx[b] + ny[b] * ny[b])
    return 0.5 * (ta * (nx[a] * vy - ny[a] * vx) + tb * (vx * ny[b] - vy * nx[b]))


@inlined
def _is_fluid(vx, vy, a, b, sides, wet, spacing):
    """Return whether the corner v of the sides a and b belongs to fluid. wet : number of wet places

    All particles of a triangle agree, on any rank.
    """
    if sides.member[a] >= 0 and sides.member[b] >= 0:
        return vx * vx + vy * vy <= (GAP * spacing) ** 2
    for w in range(wet):
        if (sides.wet[w, 0] - vx) ** 2 + (sides.wet[w, 1] - vy) ** 2 <= (NEAR_WALL * spacing) ** 2:
            return True
    return False
