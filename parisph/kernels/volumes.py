"""The volume that each fluid particle represents now (2D): its Voronoi cell, inside walls and the free surface.

The cells are those of the fluid particles alone, cut off at the walls: a particle one spacing in front of
a wall has 3/2 cells. The free surface passes through the particles on it. What lies inside is decided for each
corner of the cells, which belongs to a triangle of particles (Delaunay), or at a wall to two particles and
their feet on it. A triangle that is too large to be fluid is left out by all its particles, and so is what
lies at a wall that is not wet. A corner counts with the kite between the particle, its feet on the two sides, and
itself. Kites have signs, so that those of a triangle add up to its area also if its corner lies outside. The
sum over all particles is then exactly the area of all triangles.
"""

import math

import numpy as np

from parisph.base.fields import FLUID, WET
from parisph.kernels.jit import inlined, kernel, subkernel

MOST = 256       # sides of a cell that are looked at, and wet wall particles; further ones are ignored
GAP = 1.0        # spacings: circumradius of the largest triangle that is fluid; stretched jets have larger ones
NEAR_WALL = 0.75 # spacings: a corner on a wall is wet if a wet wall particle is as near
NEAR_SIDE = 1.6  # spacings: neighbours that bound most of a cell
ON = 1e-6        # of an element's length: what is no farther beyond its end is on it
BOX = -1         # side of the box from which cells are cut: there the cell is open


@kernel
def current_volumes(out: np.ndarray, x: np.ndarray, kind: np.ndarray, role: np.ndarray, lower: np.ndarray,
                    upper: np.ndarray, spacing: float, reach: float, corners: np.ndarray, concave: np.ndarray,
                    element_indptr: np.ndarray, element_indices: np.ndarray, indptr: np.ndarray,
                    indices: np.ndarray) -> None:
    """Write the volume out (n_owned,) [m^2] that owned fluid particles represent now, 0 for walls.

    A particle in no triangle, such as a drop, represents one cell of the lattice.

    x : (n_all, 2) [m]; kind, role : (n_all,); lower, upper : (2,) where walls are [m], infinite where there is none
    spacing, reach : [m]; the lists contain all neighbours within `reach`, at least 2.6 spacings
    corners, element_indptr, element_indices : walls as elements, as in `solids`; or none
    concave : (M, 2) bool, whether the fluid has a concave corner at this end of an element
    """
    nx, ny, limit, member = np.empty(MOST), np.empty(MOST), np.empty(MOST), np.empty(MOST, np.int64)
    px, py, edge = np.empty(MOST), np.empty(MOST), np.empty(MOST, np.int64)
    qx, qy, qedge = np.empty(MOST), np.empty(MOST), np.empty(MOST, np.int64)
    wet, foot = np.empty((MOST, 2)), np.empty(2)
    near_side = 0.5 * (NEAR_SIDE * spacing) ** 2
    gap2, near2 = (GAP * spacing) ** 2, (NEAR_WALL * spacing) ** 2
    for i in range(len(indptr) - 1):
        out[i] = 0.0
        if kind[i] != FLUID:
            continue
        out[i] = spacing * spacing
        sides, walls = _sides(nx, ny, limit, member, wet, i, x, kind, role, lower, upper, reach, indptr, indices)
        sides = _element_sides(nx, ny, limit, member, foot, sides, i, x, reach, corners, concave, element_indptr,
                               element_indices)
        count, far2 = _box(px, py, edge, reach), 2.0 * reach * reach
        for far in (False, True):    # near sides first: far ones do not reach the cell then
            for k in range(sides):
                if (limit[k] > near_side) == far and (member[k] < 0 or limit[k] < 2.0 * far2):
                    count = _cut(px, py, edge, count, qx, qy, qedge, nx[k], ny[k], limit[k], k)
                    far2 = _farthest(px, py, count)
        area, kept = 0.0, 0
        for m in range(count):
            a, b = edge[m - 1 if m else count - 1], edge[m]
            if a == BOX or b == BOX:
                continue
            if _is_fluid(px[m], py[m], a, b, member, wet, walls, gap2, near2):
                area += _kite(px[m], py[m], a, b, nx, ny, limit)
                kept += 1
        if kept:
            out[i] = area


@subkernel
def _sides(nx, ny, limit, member, wet, i, x, kind, role, lower, upper, reach, indptr, indices):
    """Write the sides that may bound the cell of i, { p : n . p <= limit }, and the places `wet` of wet wall particles.

    member : the neighbour across the side, or -1 for a wall, whose n has length 1. Everything is relative to
    i. Returns the numbers of sides and places.
    """
    n, w = 0, 0
    for k in range(indptr[i], indptr[i + 1]):
        j = indices[k]
        dx, dy = x[j, 0] - x[i, 0], x[j, 1] - x[i, 1]
        d2 = dx * dx + dy * dy
        if n == MOST // 2 or w == MOST or not d2 < reach * reach:
            continue
        if kind[j] == FLUID and d2 > 0.0:
            nx[n], ny[n], limit[n], member[n] = dx, dy, 0.5 * d2, j
            n += 1
        elif role[j] == WET:
            wet[w, 0], wet[w, 1] = dx, dy
            w += 1
    for a in range(2):
        for sign in (-1.0, 1.0):
            away = x[i, a] - lower[a] if sign < 0.0 else upper[a] - x[i, a]
            if away < reach:
                nx[n], ny[n] = (sign, 0.0) if a == 0 else (0.0, sign)
                limit[n], member[n] = away, -1
                n += 1
    return n, w


@subkernel
def _element_sides(nx, ny, limit, member, foot, n, i, x, reach, corners, concave, element_indptr, element_indices):
    """Write sides on walls of elements after the first n; return how many sides there are now.

    Those are on the walls that the particle faces squarely, as far as they lead straight on, and on those behind a
    concave corner. A particle ahead of an edge has a side through the edge, at right angles to the way there.
    """
    nearest, ahead = reach, False
    for k in range(element_indptr[i], element_indptr[i + 1]):
        e = element_indices[k]
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
            nearest, ahead = apart, not square
            foot[0], foot[1] = dx, dy
        if height < reach and (square or (t < 0.0 and concave[e, 0]) or (t > 1.0 and concave[e, 1])):
            nx[n], ny[n], limit[n], member[n] = sy / length, -sx / length, height, -1
            n += 1
    if ahead and nearest > 0.0:
        nx[n], ny[n], limit[n], member[n] = foot[0] / nearest, foot[1] / nearest, nearest, -1
        n += 1
    return n


@inlined
def _box(px, py, edge, reach):
    """Write the corners of a square around the particle, anticlockwise; return their number."""
    for m in range(4):
        px[m] = reach if m == 0 or m == 3 else -reach
        py[m] = reach if m < 2 else -reach
        edge[m] = BOX
    return 4


@inlined
def _farthest(px, py, count):
    """Return the largest square of a corner's distance."""
    far2 = 0.0
    for m in range(count):
        far2 = max(far2, px[m] * px[m] + py[m] * py[m])
    return far2


@inlined
def _cut(px, py, edge, count, qx, qy, qedge, nx, ny, limit, side):
    """Cut a convex polygon with a half plane { p : n . p <= limit }; return the number of its corners.

    edge : the side from each corner to the next
    """
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
            qx[n], qy[n], qedge[n] = px[m], py[m], edge[m]
            n += 1
        if (a <= 0.0) != (b <= 0.0):
            t = a / (a - b)
            qx[n], qy[n] = px[m] + t * (px[k] - px[m]), py[m] + t * (py[k] - py[m])
            qedge[n] = side if a <= 0.0 else edge[m]
            n += 1
    for m in range(n):
        px[m], py[m], edge[m] = qx[m], qy[m], qedge[m]
    return n


@inlined
def _kite(vx, vy, a, b, nx, ny, limit):
    """Return the signed area between the particle, its feet on the sides a and b, and their corner v."""
    ta = limit[a] / (nx[a] * nx[a] + ny[a] * ny[a])
    tb = limit[b] / (nx[b] * nx[b] + ny[b] * ny[b])
    return 0.5 * (ta * (nx[a] * vy - ny[a] * vx) + tb * (vx * ny[b] - vy * nx[b]))


@inlined
def _is_fluid(vx, vy, a, b, member, wet, walls, gap2, near2):
    """Return whether the corner v of the sides a and b belongs to fluid.

    All particles of a triangle come to the same decision, on any rank.
    """
    if member[a] >= 0 and member[b] >= 0:
        return vx * vx + vy * vy <= gap2
    for w in range(walls):
        if (wet[w, 0] - vx) ** 2 + (wet[w, 1] - vy) ** 2 <= near2:
            return True
    return False
