"""Normals of elements, and the nearest element to each point. 2D and 3D.

Elements are the leaves of a binary tree of boxes. All points go down the tree together, level by level, and drop the
boxes that are farther away than an element already seen. So a point visits only a few boxes on each level.
"""

import numpy as np

from parisph.base.arrays import Floats, Ints
from parisph.geometry.columns import meet

CHUNK = 2**16      # points that go down the tree together
PAIRS = 2**20      # pairs of a point and an element treated at once
TIE = 1e-9         # of a distance: differences below this count as equal
BITS = 10          # bits per axis of the place of an element in Morton order


def area_vectors(corners: Floats) -> Floats:
    """Return the normals (M, dim) of elements (M, dim, dim), with their measures as lengths [m^(dim-1)]."""
    along = corners[:, 1] - corners[:, 0]
    if corners.shape[2] == 2:
        found: Floats = np.stack([-along[:, 1], along[:, 0]], axis=1) + 0.0    # no negative zeros
        return found
    return 0.5 * np.cross(along, corners[:, 2] - corners[:, 0]) + 0.0


def unit_normals(corners: Floats) -> Floats:
    """Return the unit normals (M, dim) of elements (M, dim, dim)."""
    normal = area_vectors(corners)
    unit: Floats = normal / np.linalg.norm(normal, axis=1)[:, None]
    return unit


def nearest(x: Floats, corners: Floats, within: float = np.inf) -> tuple[Floats, Ints, Floats]:
    """Return the distance (n,) [m] of points from elements, the nearest element (n,), and its point (n, dim) [m].

    x : (n, dim) [m]; corners : (M, dim, dim) [m]
    within : [m]; points farther away get distance inf and element -1; a small value is faster
    Of equally near elements, like those that share a node, the one with the normal nearest to the way to x.
    """
    if len(corners) == 0:
        return np.full(len(x), np.inf), np.full(len(x), -1), np.full(x.shape, np.nan)
    tree = _Tree(corners)
    parts = [_nearest(x[low:low + CHUNK], corners, tree, within) for low in range(0, max(len(x), 1), CHUNK)]
    distance, element, foot = (np.concatenate(found) for found in zip(*parts))
    return distance, element, foot


def across(x: Floats, way: Floats, corners: Floats, facing: float = 0.0, least: float = 1e-9) -> tuple[Floats, Ints]:
    """Return the distance (n,) [m] from points to the first element facing them in a direction, and that element (n,).

    x : (n, 2) [m]; way : (n, 2), unit directions; corners : (M, 2, 2) [m]
    facing : only elements with a smaller cosine between the direction and their normal count
    least : only distances above this count [m]. Without such an element the distance is inf. 2D
    """
    gap, first, normal = np.empty(len(x)), np.empty(len(x), np.int64), unit_normals(corners)
    a, along = corners[:, 0], corners[:, 1] - corners[:, 0]
    rows = max(PAIRS // len(a), 1)
    for low in range(0, len(x), rows):
        part = slice(low, low + rows)
        t, u = meet(x[part, None], way[part, None], a, along)
        t = np.where((t > least) & (u >= 0.0) & (u <= 1.0) & (way[part] @ normal.T < facing), t, np.inf)
        gap[part], first[part] = t.min(axis=1), t.argmin(axis=1)
    return gap, first


class _Tree:
    """Boxes around elements: 2^k on level k, each around two of the next level; one element each on the last.

    leaf : (2^levels,) the elements in Morton order, the last one repeated; lower, upper : of each level, (2^k, dim) [m]
    """

    def __init__(self, corners: Floats) -> None:
        middle = corners.mean(axis=1)
        order = np.argsort(_along_curve(middle), kind="stable")
        self.levels = int(np.ceil(np.log2(len(order)))) if len(order) > 1 else 0
        self.leaf = np.append(order, np.full(2**self.levels - len(order), order[-1]))
        self.lower, self.upper = [corners.min(axis=1)[self.leaf]], [corners.max(axis=1)[self.leaf]]
        for _ in range(self.levels):
            self.lower.insert(0, np.minimum(self.lower[0][::2], self.lower[0][1::2]))
            self.upper.insert(0, np.maximum(self.upper[0][::2], self.upper[0][1::2]))
        self.some = corners[self.leaf, 0]    # a point of each leaf


def _along_curve(x: Floats) -> Ints:
    """Return the Morton numbers (n,) of points (n, dim)."""
    extent = max(np.ptp(x, axis=0).max(), 1e-300)
    place = ((x - x.min(axis=0)) / extent * (2**BITS - 1)).astype(np.int64)
    key = np.zeros(len(x), dtype=np.int64)
    for bit in range(BITS):
        for axis in range(x.shape[1]):
            key |= ((place[:, axis] >> bit) & 1) << (x.shape[1] * bit + axis)
    return key


def _nearest(x: Floats, corners: Floats, tree: _Tree, within: float) -> tuple[Floats, Ints, Floats]:
    """nearest() for points that go down the tree together."""
    point, box = np.arange(len(x)), np.zeros(len(x), dtype=np.int64)
    limit2 = np.square(np.full(len(x), within))
    for level in range(tree.levels + 1):
        if level:
            point, box = np.repeat(point, 2), np.repeat(2 * box, 2)
            box[1::2] += 1
        gap2, seen2 = np.zeros(len(point)), np.zeros(len(point))
        below = tree.levels - level
        some = tree.some[(box << below) + ((1 << below) >> 1)]    # a point of an element in each box
        for axis in range(x.shape[1]):
            at = x[point, axis]
            outside = np.maximum(np.maximum(tree.lower[level][box, axis] - at, at - tree.upper[level][box, axis]), 0.0)
            gap2 += outside**2
            seen2 += (some[:, axis] - at) ** 2
        _lower(limit2, point, seen2)
        keep = gap2 <= limit2[point] * (1.0 + 4.0 * TIE)
        point, box = point[keep], box[keep]
    return _best(x, corners, point, tree.leaf[box], within)


def _lower(limit: Floats, point: Ints, value: Floats) -> None:
    """Lower the limits of points to the least of their values; the points are in order."""
    if len(point):
        first = np.flatnonzero(np.append(True, point[1:] != point[:-1]))
        limit[point[first]] = np.minimum(limit[point[first]], np.minimum.reduceat(value, first))


def _best(x: Floats, corners: Floats, point: Ints, candidate: Ints, within: float) -> tuple[Floats, Ints, Floats]:
    """Return the result of nearest() from pairs of a point and a candidate, which are in the order of the points."""
    n, dim = x.shape
    distance, element, foot = np.full(n, np.inf), np.full(n, -1), np.full((n, dim), np.nan)
    at = on_segments(x[point], *np.moveaxis(corners[candidate], 1, 0)) if dim == 2 else _on_triangles(
        x[point], *np.moveaxis(corners[candidate], 1, 0))
    apart = np.sqrt(np.sum((x[point] - at) ** 2, axis=1))
    least = np.full(n, within)
    _lower(least, point, apart)
    near = apart <= least[point] * (1.0 + TIE)
    point, candidate, at, apart = point[near], candidate[near], at[near], apart[near]
    order = np.lexsort([_square(x[point] - at, area_vectors(corners[candidate])), point])
    last = order[np.append(point[order][1:] != point[order][:-1], True)] if len(order) else order
    distance[point[last]], element[point[last]], foot[point[last]] = apart[last], candidate[last], at[last]
    return distance, element, foot


def _square(away: Floats, normal: Floats) -> Floats:
    """Return |cosine| between directions (n, dim) and normals, slightly more in front of a plane than behind it.

    Beside an edge, a point lies on the side that the element with the largest value gives.
    """
    height = np.sum(away * normal, axis=1)
    cosine = height / np.maximum(np.linalg.norm(away, axis=1) * np.linalg.norm(normal, axis=1), 1e-300)
    found: Floats = np.abs(cosine) + TIE * np.sign(cosine)
    return found


def on_segments(x: Floats, a: Floats, b: Floats) -> Floats:
    """Return the points (..., dim) [m] nearest to x on straight pieces from a to b."""
    along = b - a
    t = np.sum((x - a) * along, axis=-1) / np.maximum(np.sum(along * along, axis=-1), 1e-300)
    found: Floats = a + np.clip(t, 0.0, 1.0)[..., None] * along
    return found


def _on_triangles(x: Floats, a: Floats, b: Floats, c: Floats) -> Floats:
    """Return the points of triangles nearest to x: the foot if it is inside, else the nearest on the sides."""
    normal = np.cross(b - a, c - a)
    size2 = np.maximum(np.sum(normal * normal, axis=-1), 1e-300)
    foot = x - (np.sum((x - a) * normal, axis=-1) / size2)[..., None] * normal
    inside = np.ones(foot.shape[:-1], dtype=bool)
    best, least = foot, np.full(foot.shape[:-1], np.inf)
    for p, q in ((a, b), (b, c), (c, a)):
        inside &= np.sum(np.cross(q - p, foot - p) * normal, axis=-1) >= 0.0
        at = on_segments(x, p, q)
        apart2 = np.sum((x - at) ** 2, axis=-1)
        best = np.where((apart2 < least)[..., None], at, best)
        least = np.minimum(least, apart2)
    return np.where(inside[..., None], foot, best)
