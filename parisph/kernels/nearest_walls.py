"""The nearest walls of a particle, and what keeps fluid off them, in 2D and 3D."""

import math

import numpy as np

from parisph.base.fields import FLUID
from parisph.kernels.elements import element_normal, nearest_point, square_distance
from parisph.kernels.jit import inlined, kernel, subkernel
from parisph.kernels.records import Cloud, Walls

SIDE = 0.9       # tuned 0.45 to 1: cosine above which two walls count as one to keep off; judged


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
            apart2 = square_distance(foot, p, axes)
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
def _height(p, e, n, corners, axes):
    """Return the distance of a point from the plane of an element [m], positive in front."""
    total = 0.0
    for a in range(len(axes)):
        total += (p[a] - corners[e, 0, a]) * n[a]
    return total


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
