"""Walls as elements, in 2D (segments) and 3D (triangles): lines of sight past them, and the nearest ones.

Elements have current `corners` (M, dim, dim) [m], ordered as in `records.Walls`. Every owned particle has a list of the
elements near it (`seen_elements`), mostly an empty one.
"""

import math

import numpy as np

from parisph.base.fields import FLUID
from parisph.kernels.cells import nearby
from parisph.kernels.jit import axes_of, inlined, kernel, subkernel
from parisph.kernels.records import Cloud, Walls

LIFT = 0.1       # tuned 0.05 to 0.2: spacings in front of its wall from which a node sees; judged
SLACK = 1e-9     # margin of an element over its size, so that lines cannot pass between two elements
PLANES = 6       # largest number of planes near a particle: with more, each element is tested
ROUNDING = 1e-8  # uncertainty of the distance to a plane, over the lift
SIDE = 0.9       # tuned 0.45 to 1: cosine above which two walls count as one to keep off; judged


def near_lists(x: np.ndarray, corners: np.ndarray, radius: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the elements (M, dim, dim) within the radius [m] of points x (n, dim) [m], and perhaps others, as CSR.

    Returns indptr (n + 1,) int32, indices (nnz,) int32. Raises ValueError as `cells.nearby`.
    """
    if len(corners) == 0:
        return np.zeros(len(x) + 1, np.int32), np.zeros(0, np.int32)
    axes = axes_of(x.shape[1])
    middle = np.empty((len(corners), len(axes)))
    size = _middles(middle, corners, axes)
    return nearby(x, middle, radius + size)


def seen_elements(cloud: Cloud, walls: Walls, radius: float) -> tuple[Walls, bool]:
    """Return the walls with lists of the elements within the radius [m] that are not hidden by others.

    walls : with the lists of `near_lists`
    The second is whether nothing is hidden, as in a tank: `is_open`.
    """
    indptr, indices, free = np.empty_like(walls.indptr), np.empty_like(walls.indices), is_open(cloud, walls)
    return walls._replace(indptr=indptr, indices=indices[:keep_unhidden(indptr, indices, cloud, walls, radius,
                                                                         free)]), free


def seen_neighbours(cloud: Cloud, walls: Walls) -> tuple[np.ndarray, np.ndarray]:
    """Return the lists of neighbours without those behind a wall, as CSR.

    walls : with lists of `seen_elements` that reach as far as the neighbour lists do
    """
    indptr, indices = np.empty_like(cloud.indptr), np.empty_like(cloud.indices)
    return indptr, indices[:keep_visible(indptr, indices, cloud, walls)]


@kernel
def keep_visible(indptr: np.ndarray, indices: np.ndarray, cloud: Cloud, walls: Walls) -> int:
    """Write the visible neighbours, those whose connecting line crosses no element; return their number.

    Ends at nodes are lifted off the wall along the normal. A line through a solid passes its front once, in one of the
    two directions, so that both particles of a pair agree. Lines between points in front of all planes of elements
    cross none.

    indptr, indices : outputs, as long as the lists of the cloud
    """
    axes, lift = cloud.axes, LIFT * cloud.spacing
    p, q, plane = np.empty(len(axes)), np.empty(len(axes)), np.empty((PLANES, len(axes) + 1))
    n = indptr[0] = 0
    for i in range(len(indptr) - 1):
        first, last = walls.indptr[i], walls.indptr[i + 1]
        if first == last:
            for k in range(cloud.indptr[i], cloud.indptr[i + 1]):
                indices[n] = cloud.indices[k]
                n += 1
        else:
            _lifted(p, i, cloud, lift)
            planes = _planes(plane, q, first, last, walls.indices, walls.corners, lift, axes)
            simple = _before(p, plane, planes, lift, axes)
            for k in range(cloud.indptr[i], cloud.indptr[i + 1]):
                j = cloud.indices[k]
                _lifted(q, j, cloud, lift)
                free = True
                if not (simple and _before(q, plane, planes, lift, axes)):
                    for m in range(first, last):
                        free = free and not _crosses(p, q, walls.indices[m], walls.corners, axes)
                indices[n] = j
                n += free
        indptr[i + 1] = n
    return n


@inlined
def _lifted(p, i, cloud, lift):
    for a in range(len(cloud.axes)):
        p[a] = cloud.x[i, a] + lift * cloud.normal[i, a]


@inlined
def _planes(plane, n, first, last, listed, corners, lift, axes):
    """Write normals and offsets of the planes of listed elements; return their number, -1 if too many."""
    dim, found = len(axes), 0
    for k in range(first, last):
        e = listed[k]
        element_normal(n, e, corners, axes)
        offset = 0.0
        for a in range(dim):
            offset += n[a] * corners[e, 0, a]
        known = False
        for m in range(found):
            cosine = 0.0
            for a in range(dim):
                cosine += n[a] * plane[m, a]
            known = known or (cosine > 1.0 - SLACK and abs(offset - plane[m, dim]) < ROUNDING * lift)
        if not known:
            if found == PLANES:
                return -1
            for a in range(dim):
                plane[found, a] = n[a]
            plane[found, dim] = offset
            found += 1
    return found


@inlined
def _before(p, plane, planes, lift, axes):
    """Return whether a point is in front of all planes by more than rounding; False if there are too many planes."""
    before = planes >= 0
    for m in range(planes):
        height = -plane[m, len(axes)]
        for a in range(len(axes)):
            height += plane[m, a] * p[a]
        before = before and height > ROUNDING * lift
    return before


@inlined
def _lifted_centroid(q, n, e, corners, lift, axes):
    """Write the normal of element e, and the place that is the lift [m] in front of its centroid."""
    element_normal(n, e, corners, axes)
    for a in range(len(axes)):
        q[a] = lift * n[a]
        for c in range(len(axes)):
            q[a] += corners[e, c, a] / len(axes)


@kernel
def is_open(cloud: Cloud, walls: Walls) -> bool:
    """Return whether all particles and elements are in front of the planes of all elements, so that none hides another.

    It is so for water in a tank, and the places of nodes and elements are lifted off their walls.
    """
    axes, lift, count = cloud.axes, LIFT * cloud.spacing, len(walls.corners)
    q, n, plane = np.empty(len(axes)), np.empty(len(axes)), np.empty((PLANES, len(axes) + 1))
    planes = _planes(plane, n, 0, count, np.arange(count), walls.corners, lift, axes)
    for e in range(count):
        _lifted_centroid(q, n, e, walls.corners, lift, axes)
        if not _before(q, plane, planes, lift, axes):
            return False
    for i in range(len(cloud.kind)):
        _lifted(q, i, cloud, lift)
        if not _before(q, plane, planes, lift, axes):
            return False
    return True


@kernel
def _middles(middle, corners, axes):
    """Write the centroids of elements; return the greatest distance of a corner from its centroid [m]."""
    dim, size2 = len(axes), 0.0
    for e in range(len(corners)):
        for a in range(dim):
            middle[e, a] = 0.0
            for c in range(dim):
                middle[e, a] += corners[e, c, a] / dim
        for c in range(dim):
            apart2 = 0.0
            for a in range(dim):
                apart2 += (corners[e, c, a] - middle[e, a]) ** 2
            size2 = max(size2, apart2)
    return math.sqrt(size2)


@kernel
def keep_unhidden(indptr: np.ndarray, indices: np.ndarray, cloud: Cloud, walls: Walls, radius: float,
                  nothing_hidden: bool) -> int:
    """Write the visible elements within the radius [m] of owned particles; return their number.

    The centroid or the nearest point, lifted off, must be visible: a moving wall hides the part of an element that it
    covers. Elements in front of which the particle is not are kept, so that fluid cannot pass them. If particle and
    centroid are in front of all planes, nothing is between them.

    indptr, indices : outputs, as long as the lists of walls
    """
    axes, lift = cloud.axes, LIFT * cloud.spacing
    dim = len(axes)
    p, q, n, foot, plane = np.empty(dim), np.empty(dim), np.empty(dim), np.empty(dim), np.empty((PLANES, dim + 1))
    left = indptr[0] = 0
    for i in range(len(indptr) - 1):
        first, last = walls.indptr[i], walls.indptr[i + 1]
        if first < last:
            _lifted(p, i, cloud, lift)
            planes = 0 if nothing_hidden else _planes(plane, n, first, last, walls.indices, walls.corners, lift, axes)
            simple = _before(p, plane, planes, lift, axes)
            for k in range(first, last):
                e = walls.indices[k]
                nearest_point(foot, p, e, walls.corners, axes)
                free = _apart2(foot, p, axes) <= radius * radius
                if free and not nothing_hidden:
                    _lifted_centroid(q, n, e, walls.corners, lift, axes)
                    for a in range(dim):
                        foot[a] += lift * n[a]
                    if not (simple and _before(q, plane, planes, lift, axes)):
                        free = (_height(p, e, n, walls.corners, axes) <= 0.0
                                or _is_free(p, q, first, last, k, walls, axes)
                                or _is_free(p, foot, first, last, k, walls, axes))
                indices[left] = e
                left += free
        indptr[i + 1] = left
    return left


@inlined
def _is_free(p, q, first, last, own, walls, axes):
    """Return whether the line from p to q crosses no listed element except entry `own`."""
    free = True
    for m in range(first, last):
        free = free and (m == own or not _crosses(p, q, walls.indices[m], walls.corners, axes))
    return free


@inlined
def _apart2(p, q, axes):
    total = 0.0
    for a in range(len(axes)):
        total += (p[a] - q[a]) ** 2
    return total


@inlined
def _height(p, e, n, corners, axes):
    """Return the distance of a point from the plane of an element [m], positive in front."""
    total = 0.0
    for a in range(len(axes)):
        total += (p[a] - corners[e, 0, a]) * n[a]
    return total


@inlined
def element_normal(n: np.ndarray, e: int, corners: np.ndarray, axes: tuple[int, ...]) -> float:
    """Write the unit normal of an element, into the fluid; return its measure [m^(dim-1)]."""
    if len(axes) == 2:
        nx, ny = corners[e, 0, 1] - corners[e, 1, 1], corners[e, 1, 0] - corners[e, 0, 0]
        size = math.sqrt(nx * nx + ny * ny)
        n[0], n[1] = nx / size, ny / size
        return size
    ax, ay, az = corners[e, 0, 0], corners[e, 0, 1], corners[e, 0, 2]
    ux, uy, uz = corners[e, 1, 0] - ax, corners[e, 1, 1] - ay, corners[e, 1, 2] - az
    vx, vy, vz = corners[e, 2, 0] - ax, corners[e, 2, 1] - ay, corners[e, 2, 2] - az
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    size = math.sqrt(nx * nx + ny * ny + nz * nz)
    n[0], n[1], n[2] = nx / size, ny / size, nz / size
    return 0.5 * size


@inlined
def _crosses(p, q, e, corners, axes):
    """Return whether the line from p to q crosses element e."""
    if len(axes) == 2:
        ex, ey = corners[e, 1, 0] - corners[e, 0, 0], corners[e, 1, 1] - corners[e, 0, 1]
        px, py = p[0] - corners[e, 0, 0], p[1] - corners[e, 0, 1]
        dx, dy = q[0] - p[0], q[1] - p[1]
        before = ex * py - ey * px
        slant = ex * dy - ey * dx
        if (before > 0.0) == (before + slant > 0.0):
            return False
        u = (px * dy - py * dx) / slant
        return -SLACK <= u <= 1.0 + SLACK
    return _crosses_triangle(p, q, e, corners)


@inlined
def _crosses_triangle(p, q, e, corners):
    ax, ay, az = corners[e, 0, 0], corners[e, 0, 1], corners[e, 0, 2]
    ux, uy, uz = corners[e, 1, 0] - ax, corners[e, 1, 1] - ay, corners[e, 1, 2] - az
    vx, vy, vz = corners[e, 2, 0] - ax, corners[e, 2, 1] - ay, corners[e, 2, 2] - az
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    px, py, pz = p[0] - ax, p[1] - ay, p[2] - az
    dx, dy, dz = q[0] - p[0], q[1] - p[1], q[2] - p[2]
    before, slant = nx * px + ny * py + nz * pz, nx * dx + ny * dy + nz * dz
    if (before > 0.0) == (before + slant > 0.0):
        return False
    # p + t d = corner + b u + c v (Moller & Trumbore 1997)
    wx, wy, wz = py * dz - pz * dy, pz * dx - px * dz, px * dy - py * dx
    b = -(vx * wx + vy * wy + vz * wz) / slant
    c = (ux * wx + uy * wy + uz * wz) / slant
    return b >= -SLACK and c >= -SLACK and b + c <= 1.0 + SLACK


@inlined
def nearest_point(foot: np.ndarray, p: np.ndarray, e: int, corners: np.ndarray, axes: tuple[int, ...]) -> bool:
    """Write the point of element e nearest to p; return whether it is inside the element, not on its edge."""
    if len(axes) == 2:
        return _nearest_on_side(foot, p, e, 0, 1, corners, axes)
    return _nearest_on_triangle(foot, p, e, corners, axes)


@inlined
def _nearest_on_side(foot, p, e, first, second, corners, axes):
    along, length2 = 0.0, 0.0
    for a in range(len(axes)):
        d = corners[e, second, a] - corners[e, first, a]
        along += (p[a] - corners[e, first, a]) * d
        length2 += d * d
    t = min(max(along / length2, 0.0), 1.0)
    for a in range(len(axes)):
        foot[a] = corners[e, first, a] + t * (corners[e, second, a] - corners[e, first, a])
    return 0.0 <= along <= length2


@inlined
def _nearest_on_triangle(foot, p, e, corners, axes):
    uu, uv, vv, up, vp = 0.0, 0.0, 0.0, 0.0, 0.0
    for a in range(3):
        u, v = corners[e, 1, a] - corners[e, 0, a], corners[e, 2, a] - corners[e, 0, a]
        w = p[a] - corners[e, 0, a]
        uu, uv, vv, up, vp = uu + u * u, uv + u * v, vv + v * v, up + u * w, vp + v * w
    det = uu * vv - uv * uv
    b, c = (vv * up - uv * vp) / det, (uu * vp - uv * up) / det
    if b >= -SLACK and c >= -SLACK and b + c <= 1.0 + SLACK:    # above an edge, one of the two must qualify
        for a in range(3):
            foot[a] = (1.0 - b - c) * corners[e, 0, a] + b * corners[e, 1, a] + c * corners[e, 2, a]
        return True
    best, side = math.inf, 0
    for k in range(3):
        _nearest_on_side(foot, p, e, k, (k + 1) % 3, corners, axes)
        apart2 = _apart2(foot, p, axes)
        if apart2 < best:
            best, side = apart2, k
    _nearest_on_side(foot, p, e, side, (side + 1) % 3, corners, axes)
    return False


@inlined
def nearest_walls(away: np.ndarray, member: np.ndarray, places: tuple[np.ndarray, np.ndarray, np.ndarray], i: int,
                  cloud: Cloud, walls: Walls, reach: float) -> int:
    """Write the walls that particle i must keep off, at most dim: the nearest element and others that it faces; return
    how many.

    A particle faces an element if its foot is inside the element. Walls in front of it beyond the reach [m] may be left
    out. Beside an edge only the edge itself counts.

    away : (dim, 1 + dim) output: unit vector from the nearest point to the particle, and distance [m]; behind the wall
        the normal, and a negative distance
    member : (dim,) int64 output, elements; places : scratch of `three_places`
    """
    axes, corners = cloud.axes, walls.corners
    p, foot, n = places
    for a in range(len(axes)):
        p[a] = cloud.x[i, a]
    found = 0
    for turn in range(len(axes)):
        best, in_front, alone = math.inf, False, False
        for k in range(walls.indptr[i], walls.indptr[i + 1]):
            e = walls.indices[k]
            squarely = nearest_point(foot, p, e, corners, axes)
            apart2 = _apart2(foot, p, axes)
            if apart2 > best * (1.0 + 1e-9) or (turn > 0 and not squarely):
                continue
            element_normal(n, e, corners, axes)
            height = _height(p, e, n, corners, axes)
            # ahead of a plate's tip a particle is in front of neither side
            front = height > 0.0 or (not squarely and height > -1e-9 * math.sqrt(apart2))
            if turn > 0 and (not front or _is_like(n, found, away, axes)):
                continue
            nearer = apart2 < best * (1.0 - 1e-9)
            alone = nearer and not squarely
            if nearer or (front and not in_front):
                best, in_front = apart2, front
                member[found] = e
                _note(away, found, places, math.sqrt(apart2), front, squarely, axes)
        if best == math.inf:
            break
        if alone and not in_front:    # beyond a free edge, as the rim of a tank
            nearest_point(foot, p, member[found], corners, axes)
            _note(away, found, places, math.sqrt(best), True, False, axes)
        found += 1
        if away[found - 1, len(axes)] > reach:    # all others are farther
            break
    return found


@subkernel
def three_places(axes: tuple[int, ...]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the scratch of `nearest_walls`."""
    return np.empty(len(axes)), np.empty(len(axes)), np.empty(len(axes))


@inlined
def _is_like(n, found, away, axes):
    for w in range(found):
        cosine = 0.0
        for a in range(len(axes)):
            cosine += n[a] * away[w, a]
        if cosine > SIDE:
            return True
    return False


@inlined
def _note(away, w, places, apart, front, squarely, axes):
    p, foot, n = places
    away[w, len(axes)] = apart if front else -apart
    for a in range(len(axes)):
        away[w, a] = (p[a] - foot[a]) / apart if front and apart > 0.0 and not squarely else n[a]


@kernel
def depths(depth: np.ndarray, cloud: Cloud, walls: Walls) -> None:
    """Write the depth of each owned fluid particle behind the nearest wall (n_owned,) [m], 0 in front of it."""
    axes = cloud.axes
    away, member, places = np.empty((len(axes), len(axes) + 1)), np.empty(len(axes), np.int64), three_places(axes)
    for i in range(len(depth)):
        depth[i] = 0.0
        if cloud.kind[i] == FLUID and walls.indptr[i] < walls.indptr[i + 1]:
            nearest_walls(away, member, places, i, cloud, walls, 0.0)
            depth[i] = max(-away[0, len(axes)], 0.0)


@kernel
def keep_off(move: np.ndarray, cloud: Cloud, walls: Walls, distance: float) -> None:
    """Remove the part of displacements that would bring fluid closer to a wall than the distance [m].

    move : (n_owned, dim) [m], changed in place
    """
    axes = cloud.axes
    away, member, places = np.empty((len(axes), len(axes) + 1)), np.empty(len(axes), np.int64), three_places(axes)
    for i in range(len(move)):
        if cloud.kind[i] != FLUID or walls.indptr[i] == walls.indptr[i + 1]:
            continue
        length = _length(move, i, axes)
        if length == 0.0:
            continue
        for w in range(nearest_walls(away, member, places, i, cloud, walls, distance + length)):
            _hold_back(move, i, away, w, 0.0, min(distance - away[w, len(axes)], 0.0), axes)


@inlined
def _length(vector, i, axes):
    length2 = 0.0
    for a in range(len(axes)):
        length2 += vector[i, a] ** 2
    return math.sqrt(length2)


@inlined
def _hold_back(move, i, away, w, wall_speed, allowed, axes):
    """Raise the velocity of a vector off wall w, relative to it, to at least `allowed`; return whether it was less."""
    outward = -wall_speed
    for a in range(len(axes)):
        outward += move[i, a] * away[w, a]
    if outward >= allowed:
        return False
    for a in range(len(axes)):
        move[i, a] += (allowed - outward) * away[w, a]
    return True


@kernel
def guard(u: np.ndarray, cloud: Cloud, walls: Walls, distance: float, dt: float) -> int:
    """Keep fluid from coming closer to a wall than the distance [m] in the next dt [s]; return how many it slowed down.

    The velocity into the wall is limited to the gap over dt, and to the wall's own velocity without a gap. A particle
    behind the wall would see its neighbours on the wrong side, with an unbounded pressure.

    u : (n_all, dim) [m/s], that of owned fluid is changed
    """
    axes = cloud.axes
    away, member, places = np.empty((len(axes), len(axes) + 1)), np.empty(len(axes), np.int64), three_places(axes)
    slowed, fastest = 0, 0.0
    for e in range(len(walls.velocity)):
        fastest = max(fastest, _length(walls.velocity, e, axes))
    for i in range(len(walls.indptr) - 1):
        if cloud.kind[i] != FLUID or walls.indptr[i] == walls.indptr[i + 1]:
            continue
        hit, reach = False, distance + (_length(u, i, axes) + fastest) * dt
        for w in range(nearest_walls(away, member, places, i, cloud, walls, reach)):
            speed = 0.0
            for a in range(len(axes)):
                speed += walls.velocity[member[w], a] * away[w, a]
            hit |= _hold_back(u, i, away, w, speed, min(distance - away[w, len(axes)], 0.0) / dt, axes)
        slowed += hit
    return slowed
