"""A plane region divided into triangles of about a spacing, with given nodes on its boundary."""

from collections.abc import Callable

import numpy as np

from parisph.base.arrays import Flags, Floats, Ints
from parisph.base.errors import CaseError
from parisph.geometry.columns import cross
from parisph.geometry.distance import nearest

ROOM = 0.6       # spacings: least distance of an inner node from the boundary
OUTSIDE = 1.0    # of its size, beyond the region: the outermost points, so that its boundary is inside
THIN = 1e-6      # of a square spacing: smaller triangles are flat
ROUNDS = 100     # most passes over the missing edges


def triangulated(nodes: Floats, edges: Ints, inside: Callable[[Floats], Flags], spacing: float,
                 where: str) -> tuple[Floats, Ints]:
    """Return inner nodes (k, 2) [m], which follow the given ones, and anticlockwise triangles (m, 3) of a region.

    nodes : (n, 2) [m], all on its boundary; edges : (e, 2), pairs of nodes that must be sides of triangles; inside :
    whether points (n, 2) [m] lie in it; spacing : [m]; where : the region, in messages

    Inner nodes lie on a lattice that divides the box around the region evenly. Raises CaseError.
    """
    # 2D scenes do not load it
    from scipy.spatial import Delaunay

    inner = _inner(nodes, edges, inside, spacing)
    points = np.concatenate([nodes, inner])
    lower, upper = points.min(axis=0), points.max(axis=0)
    far = OUTSIDE * (upper - lower).max()
    box = np.array([(lower[0] - far, lower[1] - far), (upper[0] + far, lower[1] - far),
                    (upper[0] + far, upper[1] + far), (lower[0] - far, upper[1] + far)])
    every = np.concatenate([points, box])
    found = _with_edges(every, Delaunay(every).simplices.astype(np.int64), edges, where)
    a, b, c = (every[found[:, k]] for k in range(3))
    area = 0.5 * cross(b - a, c - a)
    found[area < 0.0] = found[area < 0.0][:, ::-1]
    kept = (found < len(points)).all(axis=1) & (np.abs(area) > THIN * spacing**2)
    kept[kept] = inside(((a + b + c) / 3.0)[kept])
    return inner, found[kept]


def _inner(nodes: Floats, edges: Ints, inside: Callable[[Floats], Flags], spacing: float) -> Floats:
    """Return the inner nodes: lattice points away from the edges and outside the circles over them."""
    lower, upper = nodes.min(axis=0), nodes.max(axis=0)
    many = np.maximum(np.round((upper - lower) / spacing), 1).astype(np.int64)
    axes = [low + np.arange(1, n) * ((high - low) / n) for low, high, n in zip(lower, upper, many)]
    x = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
    x = x[inside(x)]
    ends = nodes[edges]
    middle, radius = ends.mean(axis=1), 0.5 * np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    x = x[nearest(x, ends, 2.0 * spacing)[0] > ROOM * spacing]
    longest = float(radius.max(initial=0.0))
    if longest > ROOM * spacing:
        for at, reach in zip(middle[radius > ROOM * spacing], radius[radius > ROOM * spacing]):
            x = x[np.linalg.norm(x - at, axis=1) > reach]
    found: Floats = x
    return found


def _with_edges(points: Floats, triangles: Ints, edges: Ints, where: str) -> Ints:
    """Return triangles (m, 3) changed so that all edges (e, 2) are sides, by swaps of diagonals."""
    for _ in range(ROUNDS):
        missing = edges[~_present(triangles, edges, len(points))]
        if not len(missing):
            return triangles
        for one, other in missing.tolist():
            _swap_towards(points, triangles, one, other)
    raise CaseError(f"walls: {where}, the mesh of a wall across cannot join its nodes: use a smaller spacing")


def _keys(pairs: Ints, many: int) -> Ints:
    found: Ints = pairs.min(axis=-1) * many + pairs.max(axis=-1)
    return found


def _present(triangles: Ints, edges: Ints, many: int) -> Flags:
    """Return which edges (e, 2) are sides of triangles."""
    sides = _keys(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), many)
    found: Flags = np.isin(_keys(edges, many), sides)
    return found


def _swap_towards(points: Floats, triangles: Ints, one: int, other: int) -> None:
    """Swap the diagonals of convex pairs of triangles that an edge between two points crosses, once each."""
    start, way = points[one], points[other] - points[one]
    side = cross(way, points - start)
    for k in range(len(triangles)):
        for a, b in ((0, 1), (1, 2), (2, 0)):
            p, q = int(triangles[k, a]), int(triangles[k, b])
            if {p, q} & {one, other} or side[p] * side[q] >= 0.0:
                continue
            along = cross(points[q] - points[p], start - points[p]) * cross(points[q] - points[p],
                                                                          points[other] - points[p])
            if along < 0.0 and _swapped(points, triangles, k, p, q):
                break


def _swapped(points: Floats, triangles: Ints, k: int, p: int, q: int) -> bool:
    """Swap the side p, q of triangle k for the other diagonal if the two triangles beside it are convex together."""
    pair = np.flatnonzero((triangles == p).any(axis=1) & (triangles == q).any(axis=1))
    if len(pair) != 2:
        return False
    r, t = (int(triangles[m][(triangles[m] != p) & (triangles[m] != q)][0]) for m in pair)
    way = points[t] - points[r]
    if cross(way, points[p] - points[r]) * cross(way, points[q] - points[r]) >= 0.0:
        return False
    triangles[pair[0]], triangles[pair[1]] = (r, t, p), (t, r, q)
    return True


def corner_parts(corners: Floats) -> Floats:
    """Return the part (m, 3) of each triangle (m, 3, dim) that is nearest to each of its corners, cut at their sides.

    In an obtuse triangle, half is the corner's with the obtuse angle. So a node of a square lattice has a square,
    whatever the diagonals.
    """
    side2 = np.sum((corners[:, [1, 2, 0]] - corners[:, [2, 0, 1]]) ** 2, axis=2)    # opposite to each corner
    # squares of the sides times the cotangents of the opposite angles, over twice the area
    turned = side2 * (side2.sum(axis=1)[:, None] - 2.0 * side2)
    parts: Floats = 0.5 * (1.0 - turned / np.maximum(turned.sum(axis=1), 1e-300)[:, None])
    obtuse = turned < 0.0
    any_ = obtuse.any(axis=1)
    parts[any_] = np.where(obtuse[any_], 0.5, 0.25)
    return parts
