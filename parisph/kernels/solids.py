"""Walls as elements, in 2D (segments) and 3D (triangles): what is visible past them, and which of them are near.

Elements are `corners` (M, dim, dim) [m], where they are now, with the fluid on the left of the way from the first to
the second corner, in 3D on the side from which the corners are in anticlockwise order. Every owned particle has a
list of the elements near it (element_lists); most lists are empty, and then nothing is done.
"""

import math

import numpy as np

from parisph.base.fields import FLUID
from parisph.kernels.cells import nearby
from parisph.kernels.jit import axes_of, inlined, kernel, subkernel

LIFT = 0.1       # spacings: so far in front of its wall a node looks out
SLACK = 1e-9     # of an element's size: a line that passes its edge by less crosses it, so that two leave no gap
SIDE = 0.9       # cosine above which two walls count as one to keep off


def element_lists(x: np.ndarray, corners: np.ndarray, normal: np.ndarray, radius: float,
                  spacing: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the elements within the radius [m] of points x (n, dim) that are not hidden behind others, as CSR.

    corners : (M, dim, dim) [m]; normal : (n, dim), of nodes, 0 for fluid
    Returns indptr (n + 1,) int32, indices (nnz,) int32. Raises ValueError as `cells.nearby`.
    """
    return unhidden_lists(x, normal, corners, radius, spacing, *near_lists(x, corners, radius))


def near_lists(x: np.ndarray, corners: np.ndarray, radius: float) -> tuple[np.ndarray, np.ndarray]:
    """Return at least the elements within the radius [m] of points x (n, dim), as CSR. As element_lists."""
    if len(corners) == 0:
        return np.zeros(len(x) + 1, np.int32), np.zeros(0, np.int32)
    axes = axes_of(x.shape[1])
    middle = np.empty((len(corners), len(axes)))
    size = _middles(middle, corners, axes)
    return nearby(x, middle, radius + size)


def unhidden_lists(x: np.ndarray, normal: np.ndarray, corners: np.ndarray, radius: float, spacing: float,
                   indptr: np.ndarray, indices: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return those elements of near lists that element_lists has; the lists given are used up."""
    axes = axes_of(x.shape[1])
    return indptr, indices[: _keep_unhidden(indptr, indices, x, normal, corners, radius, LIFT * spacing, axes)]


def visible_lists(x: np.ndarray, normal: np.ndarray, corners: np.ndarray, spacing: float, element_indptr: np.ndarray,
                  element_indices: np.ndarray, indptr: np.ndarray,
                  indices: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return neighbour lists without those neighbours that are behind a wall; the lists given are used up.

    normal : (n_all, dim), 0 for fluid; the element lists must reach as far as the neighbour lists do
    """
    axes = axes_of(x.shape[1])
    n = keep_visible(indptr, indices, x, normal, corners, LIFT * spacing, element_indptr, element_indices, axes)
    return indptr, indices[:n]


@kernel
def keep_visible(indptr: np.ndarray, indices: np.ndarray, x: np.ndarray, normal: np.ndarray, corners: np.ndarray,
                 lift: float, element_indptr: np.ndarray, element_indices: np.ndarray, axes: tuple[int, ...]) -> int:
    """Leave in the lists, in place, the neighbours that are seen: the line between the particles crosses no element.

    The ends at nodes are lifted off the wall by `lift` [m] along the normal. A line that crosses a solid goes through
    its front once, in one of the two directions, so that both particles of a pair come to the same decision.

    Returns the number of neighbours that are left.
    """
    p, q = np.empty(len(axes)), np.empty(len(axes))
    n, begin = 0, indptr[0]
    for i in range(len(indptr) - 1):
        end = indptr[i + 1]
        first, last = element_indptr[i], element_indptr[i + 1]
        if first == last:
            for k in range(begin, end):
                indices[n] = indices[k]
                n += 1
        else:
            _lifted(p, i, x, normal, lift, axes)
            for k in range(begin, end):
                j = indices[k]
                _lifted(q, j, x, normal, lift, axes)
                free = True
                for m in range(first, last):
                    free = free and not _crosses(p, q, element_indices[m], corners, axes)
                indices[n] = j
                n += free
        begin = end
        indptr[i + 1] = n
    return n


@inlined
def _lifted(p, i, x, normal, lift, axes):
    for a in range(len(axes)):
        p[a] = x[i, a] + lift * normal[i, a]


@kernel
def _middles(middle, corners, axes):
    """Write the middles of elements; return the greatest distance of a corner from its middle [m]."""
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
def _keep_unhidden(indptr, indices, x, normal, corners, radius, lift, axes) -> int:
    """Leave in the lists, in place, elements within the radius of a point that are not hidden.

    The middle of an element or its nearest point, lifted off, must be seen: a wall that moves hides a part of an
    element over which it stands. Elements that a point is behind stay, so that fluid cannot pass them. Returns the
    number that are left.
    """
    dim = len(axes)
    p, q, n, foot, r = np.empty(dim), np.empty(dim), np.empty(dim), np.empty(dim), np.empty(dim)
    left, begin, free = 0, indptr[0], np.empty(256, np.bool_)
    for i in range(len(indptr) - 1):
        end = indptr[i + 1]
        _lifted(p, i, x, normal, lift, axes)
        if end - begin > len(free):
            free = np.empty(2 * (end - begin), np.bool_)
        for k in range(begin, end):
            e = indices[k]
            nearest_point(foot, p, e, corners, axes)
            free[k - begin] = _apart2(foot, p, axes) <= radius * radius
            element_normal(n, e, corners, axes)
            if not free[k - begin] or _height(p, e, n, corners, axes) <= 0.0:
                continue
            for a in range(dim):
                q[a] = lift * n[a]
                r[a] = foot[a] + lift * n[a]
                for c in range(dim):
                    q[a] += corners[e, c, a] / dim
            for m in range(begin, end):
                free[k - begin] = free[k - begin] and (m == k or not _crosses(p, q, indices[m], corners, axes))
            nearest = not free[k - begin]
            if nearest:
                for m in range(begin, end):
                    nearest = nearest and (m == k or not _crosses(p, r, indices[m], corners, axes))
            free[k - begin] = free[k - begin] or nearest
        for k in range(begin, end):
            indices[left] = indices[k]
            left += free[k - begin]
        begin = end
        indptr[i + 1] = left
    return left


@inlined
def _apart2(p, q, axes):
    total = 0.0
    for a in range(len(axes)):
        total += (p[a] - q[a]) ** 2
    return total


@inlined
def _height(p, e, n, corners, axes):
    """Return how far a point is in front of the plane of an element [m]."""
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
    if b >= 0.0 and c >= 0.0 and b + c <= 1.0:
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


@subkernel
def nearest_walls(away: np.ndarray, member: np.ndarray, p: np.ndarray, foot: np.ndarray, n: np.ndarray, i: int,
                  x: np.ndarray, corners: np.ndarray, element_indptr: np.ndarray, element_indices: np.ndarray,
                  axes: tuple[int, ...]) -> int:
    """Find the walls that particle i must keep off: the nearest element, and further ones that it faces squarely.

    away : (dim, 1 + dim) output, of each wall the unit vector from its nearest point to the particle, and the
        distance [m], negative behind the wall; there the vector is the normal
    member : (dim,) int64 output, elements; p, foot, n : (dim,) scratch
    Returns the number of walls, at most dim. Beside an edge only the edge itself counts.
    """
    dim = len(axes)
    for a in range(dim):
        p[a] = x[i, a]
    found = 0
    for turn in range(dim):
        best, in_front = math.inf, False
        for k in range(element_indptr[i], element_indptr[i + 1]):
            e = element_indices[k]
            squarely = nearest_point(foot, p, e, corners, axes)
            apart2 = _apart2(foot, p, axes)
            if apart2 > best * (1.0 + 1e-9) or (turn > 0 and not squarely):
                continue
            element_normal(n, e, corners, axes)
            height = _height(p, e, n, corners, axes)
            # straight ahead of a plate's tip a particle is in front of neither side
            front = height > 0.0 or (not squarely and height > -1e-9 * math.sqrt(apart2))
            if turn > 0 and (not front or _is_like(n, found, away, axes)):
                continue
            if apart2 < best * (1.0 - 1e-9) or (front and not in_front):
                best, in_front = apart2, front
                _note(away, member, found, e, p, foot, n, math.sqrt(apart2), front, squarely, axes)
        if best == math.inf:
            break
        found += 1
    return found


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
def _note(away, member, w, e, p, foot, n, apart, front, squarely, axes):
    dim = len(axes)
    member[w] = e
    away[w, dim] = apart if front else -apart
    for a in range(dim):
        away[w, a] = (p[a] - foot[a]) / apart if front and apart > 0.0 and not squarely else n[a]


@kernel
def keep_off_solids(move: np.ndarray, x: np.ndarray, kind: np.ndarray, corners: np.ndarray, distance: float,
                    element_indptr: np.ndarray, element_indices: np.ndarray, axes: tuple[int, ...]) -> None:
    """Remove the part of a displacement that would bring fluid closer to a wall than the distance [m].

    move : (n_owned, dim) [m], changed in place
    """
    dim = len(axes)
    away, member = np.empty((dim, dim + 1)), np.empty(dim, np.int64)
    p, foot, n = np.empty(dim), np.empty(dim), np.empty(dim)
    for i in range(len(element_indptr) - 1):
        if kind[i] != FLUID or element_indptr[i] == element_indptr[i + 1]:
            continue
        for w in range(nearest_walls(away, member, p, foot, n, i, x, corners, element_indptr, element_indices, axes)):
            outward = 0.0
            for a in range(dim):
                outward += move[i, a] * away[w, a]
            allowed = min(distance - away[w, dim], 0.0)
            if outward < allowed:
                for a in range(dim):
                    move[i, a] += (allowed - outward) * away[w, a]


@kernel
def guard_solids(u: np.ndarray, x: np.ndarray, kind: np.ndarray, corners: np.ndarray, wall_u: np.ndarray,
                 distance: float, dt: float, element_indptr: np.ndarray, element_indices: np.ndarray,
                 axes: tuple[int, ...]) -> int:
    """Keep fluid from coming closer to a wall than the distance [m] in the next dt [s], as collisions.wall_guard does.

    u : (n_all, dim) [m/s], that of owned fluid is changed; wall_u : (M, dim) [m/s], of the elements
    Returns the number of particles that were slowed down.
    """
    dim = len(axes)
    away, member = np.empty((dim, dim + 1)), np.empty(dim, np.int64)
    p, foot, n = np.empty(dim), np.empty(dim), np.empty(dim)
    slowed = 0
    for i in range(len(element_indptr) - 1):
        if kind[i] != FLUID or element_indptr[i] == element_indptr[i + 1]:
            continue
        hit = False
        for w in range(nearest_walls(away, member, p, foot, n, i, x, corners, element_indptr, element_indices, axes)):
            outward = 0.0
            for a in range(dim):
                outward += (u[i, a] - wall_u[member[w], a]) * away[w, a]
            allowed = min(distance - away[w, dim], 0.0) / dt
            if outward < allowed:
                hit = True
                for a in range(dim):
                    u[i, a] += (allowed - outward) * away[w, a]
        slowed += hit
    return slowed
