"""Walls as elements, in 2D (segments) and 3D (triangles): lines of sight past them, and the nearest ones.

Elements have current `corners` (M, dim, dim) [m], ordered as in `records.Walls`. Every owned particle has a list of the
elements near it (`seen_elements`), mostly an empty one. Many elements lie in one plane: a line crosses none of these if
both ends are on one side of it.
"""

import math

import numpy as np

from parisph.base.fields import FLUID, WALL
from parisph.kernels.cells import nearby
from parisph.kernels.jit import axes_of, inlined, kernel, subkernel
from parisph.kernels.records import Cloud, Shapes, Walls

LIFT = 0.1       # tuned 0.05 to 0.2: spacings in front of its wall from which a node sees; judged
SLACK = 1e-9     # margin of an element over its size, so that lines cannot pass between two elements
PLANES = 16      # largest number of planes near a particle that are told apart
ROUNDING = 1e-6  # uncertainty of the distance to a plane, over the lift
SIDE = 0.9       # tuned 0.45 to 1: cosine above which two walls count as one to keep off; judged


Lists = tuple[np.ndarray, np.ndarray]    # CSR: indptr (n + 1,) int32, indices (nnz,) int32


def shapes_of(corners: np.ndarray, number: np.ndarray) -> Shapes:
    """Return the Shapes of elements (M, dim, dim) [m] with these numbers of their planes (M,) int."""
    count, dim = corners.shape[:2]
    shapes = Shapes(np.empty((count, dim)), np.empty(count), np.empty((count, dim + 1)), number)
    _measure(shapes, corners, axes_of(dim))
    return shapes


def plane_numbers(corners: np.ndarray, motion: np.ndarray, spacing: float) -> np.ndarray:
    """Return numbers (M,) that are equal for elements (M, dim, dim) [m] in one plane with one motion (M,), so forever.

    Elements that differ by rounding may have different numbers. spacing : [m]
    """
    if len(corners) == 0:
        return np.zeros(0, np.int64)
    plane = shapes_of(corners, np.zeros(len(corners), np.int64)).plane
    plane[:, -1] /= spacing
    keys = np.column_stack([np.round(plane / SLACK).astype(np.int64), motion])
    numbers: np.ndarray = np.unique(keys, axis=0, return_inverse=True)[1].reshape(-1)
    return numbers


def near_lists(x: np.ndarray, shapes: Shapes, radius: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the elements within the radius [m] of points x (n, dim) [m], and perhaps others, as CSR.

    Returns indptr (n + 1,) int32, indices (nnz,) int32. Raises ValueError as `cells.nearby`.
    """
    if len(shapes.size) == 0:
        return np.zeros(len(x) + 1, np.int32), np.zeros(0, np.int32)
    return nearby(x, shapes.middle, radius + shapes.size.max())


@kernel
def replaced(indptr: np.ndarray, indices: np.ndarray, which: np.ndarray, starts: np.ndarray, found: np.ndarray
             ) -> tuple[np.ndarray, np.ndarray]:
    """Return the CSR lists with those of some particles replaced, as CSR.

    which : (m,), these particles, ascending; starts (m + 1,), found : their lists, CSR
    """
    ends, m, n = np.empty_like(indptr), 0, len(indices) + len(found)
    left, count = np.empty(n, indices.dtype), 0
    ends[0] = 0
    for i in range(len(indptr) - 1):
        if m < len(which) and which[m] == i:
            for k in range(starts[m], starts[m + 1]):
                left[count] = found[k]
                count += 1
            m += 1
        else:
            for k in range(indptr[i], indptr[i + 1]):
                left[count] = indices[k]
                count += 1
        ends[i + 1] = count
    return ends, left[:count]


def no_lists(n: int) -> Lists:
    """Return n empty lists."""
    return np.zeros(n + 1, np.int32), np.zeros(0, np.int32)


def seen_elements(cloud: Cloud, walls: Walls, radius: float, nothing_hidden: bool, known: Lists | None = None
                  ) -> Walls:
    """Return the walls with lists of the elements within the radius [m] that are not hidden by others.

    walls : with the lists of `near_lists`
    nothing_hidden : as in a tank, of `is_open`
    known : lists by an earlier call, if no wall has moved since; those of wall particles are taken from them
    """
    indptr = np.empty_like(walls.indptr)
    indices = np.empty(len(walls.indices) + (0 if known is None else len(known[1])), np.int32)
    count = keep_unhidden(indptr, indices, cloud, walls, radius, nothing_hidden,
                          (np.empty(0, np.int32), indices) if known is None else known)
    return walls._replace(indptr=indptr, indices=indices[:count])


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
    two directions, so that both particles of a pair agree.

    indptr, indices : outputs, as long as the lists of the cloud
    """
    axes, lift = cloud.axes, LIFT * cloud.spacing
    p, q, sight = np.empty(len(axes)), np.empty(len(axes)), _sight(walls.indptr)
    n = indptr[0] = 0
    for i in range(len(indptr) - 1):
        if walls.indptr[i] == walls.indptr[i + 1]:
            for k in range(cloud.indptr[i], cloud.indptr[i + 1]):
                indices[n] = cloud.indices[k]
                n += 1
        else:
            _lifted(p, i, cloud, lift)
            planes = _find_planes(sight, p, i, walls, axes)
            for k in range(cloud.indptr[i], cloud.indptr[i + 1]):
                j = cloud.indices[k]
                _lifted(q, j, cloud, lift)
                indices[n] = j
                n += _is_free(p, q, sight, planes, (i, -1, axes), walls, lift)
        indptr[i + 1] = n
    return n


@inlined
def _lifted(p, i, cloud, lift):
    for a in range(len(cloud.axes)):
        p[a] = cloud.x[i, a] + lift * cloud.normal[i, a]


@subkernel
def _sight(indptr):
    """Return the scratch of `_find_planes`.

    For each plane near a particle: an element, the height of the particle, and whether a line crosses it; then the
    place among these of the plane of each entry in the particle's list.
    """
    longest = 0
    for i in range(len(indptr) - 1):
        longest = max(longest, indptr[i + 1] - indptr[i])
    return np.empty(longest, np.int64), np.empty(longest), np.empty(longest, np.bool_), np.empty(longest, np.int64)


@inlined
def _find_planes(sight, p, i, walls, axes):
    """Write the planes of the elements listed for particle i, and the height of p; return their number.

    After PLANES different ones, each further element counts as another plane.
    """
    (element, height, _, member), shapes, found, first = sight, walls.shapes, 0, walls.indptr[i]
    for k in range(first, walls.indptr[i + 1]):
        e, place = walls.indices[k], found
        for m in range(min(found, PLANES)):
            if shapes.number[element[m]] == shapes.number[e]:
                place = m
        member[k - first] = place
        if place == found:
            element[found], height[found] = e, _above(p, e, shapes, axes)
            found += 1
    return found


@inlined
def _above(p, e, shapes, axes):
    """Return the height of a point above the plane of an element [m]."""
    height = -shapes.plane[e, len(axes)]
    for a in range(len(axes)):
        height += shapes.plane[e, a] * p[a]
    return height


@inlined
def _is_free(p, q, sight, planes, which, walls, lift):
    """Return whether the line from p to q crosses none of the elements listed for a particle, except one entry.

    It crosses none if no plane is between p and q. which : the particle, the entry, and the axes
    """
    (element, height, crossed, member), (i, own, axes), shapes = sight, which, walls.shapes
    margin, between, first = ROUNDING * lift, False, walls.indptr[i]
    for m in range(planes):
        other = _above(q, element[m], shapes, axes)
        crossed[m] = min(height[m], other) <= margin and max(height[m], other) >= -margin
        between = between or crossed[m]
    if between:
        for k in range(first, walls.indptr[i + 1]):
            if crossed[member[k - first]] and k != own and _crosses(p, q, walls.indices[k], walls.corners, axes):
                return False
    return True


@kernel
def is_open(cloud: Cloud, walls: Walls) -> bool:
    """Return whether all particles and elements are in front of the planes of all elements, so that none hides another.

    It is so for water in a tank, and the places of nodes and elements are lifted off their walls.
    """
    axes, lift, shapes, found = cloud.axes, LIFT * cloud.spacing, walls.shapes, 0
    q, element = np.empty(len(axes)), np.empty(PLANES, np.int64)
    for e in range(len(shapes.number)):
        known = False
        for m in range(found):
            known = known or shapes.number[element[m]] == shapes.number[e]
        if not known:
            if found == PLANES:
                return False
            element[found] = e
            found += 1
    for e in range(len(shapes.number)):
        _lifted_middle(q, e, shapes, lift, axes)
        if not _before(q, element, found, shapes, lift, axes):
            return False
    for i in range(len(cloud.kind)):
        _lifted(q, i, cloud, lift)
        if not _before(q, element, found, shapes, lift, axes):
            return False
    return True


@inlined
def _before(p, element, planes, shapes, lift, axes):
    """Return whether a point is in front of all planes by more than rounding."""
    before = True
    for m in range(planes):
        before = before and _above(p, element[m], shapes, axes) > ROUNDING * lift
    return before


@inlined
def _lifted_middle(q, e, shapes, lift, axes):
    """Write the place that is the lift [m] in front of the centroid of element e."""
    for a in range(len(axes)):
        q[a] = shapes.middle[e, a] + lift * shapes.plane[e, a]


@kernel
def _measure(shapes: Shapes, corners: np.ndarray, axes: tuple[int, ...]) -> None:
    """Write all but the numbers."""
    middle, size, plane, _ = shapes
    dim, n = len(axes), np.empty(len(axes))
    for e in range(len(corners)):
        element_normal(n, e, corners, axes)
        plane[e, dim] = 0.0
        for a in range(dim):
            plane[e, a] = n[a]
            plane[e, dim] += n[a] * corners[e, 0, a]
            middle[e, a] = 0.0
            for c in range(dim):
                middle[e, a] += corners[e, c, a] / dim
        size2 = 0.0
        for c in range(dim):
            apart2 = 0.0
            for a in range(dim):
                apart2 += (corners[e, c, a] - middle[e, a]) ** 2
            size2 = max(size2, apart2)
        size[e] = math.sqrt(size2)


@kernel
def keep_unhidden(indptr: np.ndarray, indices: np.ndarray, cloud: Cloud, walls: Walls, radius: float,
                  nothing_hidden: bool, known: Lists) -> int:
    """Write the visible elements within the radius [m] of owned particles; return their number.

    The centroid or the nearest point, lifted off, must be visible: a moving wall hides the part of an element that it
    covers. Elements in front of which the particle is not are kept, so that fluid cannot pass them.

    indptr, indices : outputs, with room for the lists of walls and the known ones
    known : lists of wall particles, without rows if they are not known
    """
    axes, lift, shapes = cloud.axes, LIFT * cloud.spacing, walls.shapes
    p, q, foot, sight = np.empty(len(axes)), np.empty(len(axes)), np.empty(len(axes)), _sight(walls.indptr)
    left = indptr[0] = 0
    for i in range(len(indptr) - 1):
        if cloud.kind[i] == WALL and len(known[0]) > 0:
            for k in range(known[0][i], known[0][i + 1]):
                indices[left] = known[1][k]
                left += 1
        elif walls.indptr[i] < walls.indptr[i + 1]:
            _lifted(p, i, cloud, lift)
            planes = 0 if nothing_hidden else _find_planes(sight, p, i, walls, axes)
            for k in range(walls.indptr[i], walls.indptr[i + 1]):
                e = walls.indices[k]
                free = _is_within(p, e, foot, radius, walls, axes)
                if free and not nothing_hidden:
                    _lifted_middle(q, e, shapes, lift, axes)
                    free = _is_free(p, q, sight, planes, (i, k, axes), walls, lift)
                    if not free:
                        nearest_point(foot, p, e, walls.corners, axes)
                        for a in range(len(axes)):
                            q[a] = foot[a] + lift * shapes.plane[e, a]
                        free = (_above(p, e, shapes, axes) <= 0.0
                                or _is_free(p, q, sight, planes, (i, k, axes), walls, lift))
                indices[left] = e
                left += free
        indptr[i + 1] = left
    return left


@inlined
def _is_within(p, e, foot, radius, walls, axes):
    """Return whether an element is within the radius of p. The foot, (dim,) scratch, is found where it is needed."""
    apart2, shapes = 0.0, walls.shapes
    for a in range(len(axes)):
        apart2 += (shapes.middle[e, a] - p[a]) ** 2
    if apart2 <= radius * radius:
        return True
    if apart2 > (radius + shapes.size[e]) ** 2 * (1.0 + SLACK):
        return False
    nearest_point(foot, p, e, walls.corners, axes)
    return _apart2(foot, p, axes) <= radius * radius


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
        if cloud.kind[i] == FLUID and walls.indptr[i] < walls.indptr[i + 1] and not _is_clear(i, cloud, walls, 0.0):
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
        if length == 0.0 or _is_clear(i, cloud, walls, distance + length):
            continue
        for w in range(nearest_walls(away, member, places, i, cloud, walls, distance + length)):
            _hold_back(move, i, away, w, 0.0, min(distance - away[w, len(axes)], 0.0), axes)


@inlined
def _is_clear(i, cloud, walls, reach):
    """Return whether a particle is farther than the reach [m] in front of the planes of all elements in its list."""
    for k in range(walls.indptr[i], walls.indptr[i + 1]):
        e, height = walls.indices[k], 0.0
        for a in range(len(cloud.axes)):
            height += walls.shapes.plane[e, a] * cloud.x[i, a]
        if not height - walls.shapes.plane[e, len(cloud.axes)] > reach:
            return False
    return True


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
        if _is_clear(i, cloud, walls, reach):
            continue
        for w in range(nearest_walls(away, member, places, i, cloud, walls, reach)):
            speed = 0.0
            for a in range(len(axes)):
                speed += walls.velocity[member[w], a] * away[w, a]
            hit |= _hold_back(u, i, away, w, speed, min(distance - away[w, len(axes)], 0.0) / dt, axes)
        slowed += hit
    return slowed
