"""Which points lie inside a surface of triangles (3D)."""

import numpy as np

from parisph.base.arrays import Flags, Floats, Ints
from parisph.geometry.distance import area_vectors

PAIRS = 2**20    # pairs of a point and a triangle treated at once
# of the size of a cell of the plan: points move by this before they are looked for, away from edges of triangles
ASIDE = np.array([1.0e-6, 1.6180339887e-6])
CELLS = 2**24    # most cells of the plan


def winding(x: Floats, corners: Floats) -> Floats:
    """Return how often a surface goes around each point (n,): 1 inside one with normals outward, 0 outside, exactly.

    x : (n, 3) [m]; corners : (M, 3, 3) [m]. The sum of the solid angles of all triangles over 4 pi: van Oosterom and
    Strackee (1983), eq. 8. The cost is points times triangles; see `floors` for many points.
    """
    found = np.zeros(len(x))
    rows = max(PAIRS // max(len(corners), 1), 1)
    for low in range(0, len(x), rows):
        a, b, c = np.moveaxis(corners[None] - x[low:low + rows, None, None], 2, 0)
        la, lb, lc = (np.linalg.norm(side, axis=2) for side in (a, b, c))
        volume = np.sum(a * np.cross(b, c), axis=2)
        below = la * lb * lc + np.sum(a * b, axis=2) * lc + np.sum(b * c, axis=2) * la + np.sum(c * a, axis=2) * lb
        found[low:low + rows] = np.sum(np.arctan2(volume, below), axis=1) / (2.0 * np.pi)
    return found


def floors(x: Floats, corners: Floats, cell: float) -> Ints:
    """Return the number of upward triangles below each point less that of downward ones, (n,) int.

    It is 1 in a room of fluid, also above its rim, and 0 in solids and below the room. For points on the surface it is
    that of a side. x : (n, 3) [m]; corners : (M, 3, 3) [m], with normals into the fluid
    cell : [m], of the grid of the plan by which points and triangles are brought together; about the size of triangles
    """
    found = np.zeros(len(x), dtype=np.int64)
    upward = area_vectors(corners)[:, 2]
    level = np.abs(upward) > 1e-12 * cell**2
    corners, upward = corners[level], upward[level]
    if not len(x) or not len(corners):
        return found
    lower, upper = x[:, :2].min(axis=0), x[:, :2].max(axis=0)
    cell = max(cell, float(np.sqrt(np.prod((upper - lower) / cell + 1.0) / CELLS)) * cell)
    place = x[:, :2] + ASIDE * cell
    columns = ((upper - lower) / cell).astype(np.int64) + 1
    key = _cell(place, lower, cell, columns)
    order = np.argsort(key, kind="stable")
    begin = np.searchsorted(key[order], np.arange(int(columns.prod()) + 1))
    first = np.clip(np.floor((corners[:, :, :2].min(axis=1) - lower) / cell).astype(np.int64), 0, columns)
    last = np.clip(np.floor((corners[:, :, :2].max(axis=1) - lower) / cell).astype(np.int64), -1, columns - 1)
    for part in _portions(first, last, begin, columns):
        triangle, point = _pairs(part, first, last, begin, columns)
        point = order[point]
        below = _below(place[point], x[point, 2], corners[triangle])
        np.add.at(found, point[below], np.sign(upward[triangle[below]]).astype(np.int64))
    return found


def _cell(place: Floats, lower: Floats, cell: float, columns: Ints) -> Ints:
    index = np.clip(((place - lower) / cell).astype(np.int64), 0, columns - 1)
    found: Ints = index[:, 0] * columns[1] + index[:, 1]
    return found


def _portions(first: Ints, last: Ints, begin: Ints, columns: Ints) -> list[Ints]:
    """Return the triangles in portions with some PAIRS pairs each; one with more is a portion by itself."""
    many = np.prod(np.maximum(last - first + 1, 0), axis=1) * max(int(np.ceil((begin[-1] / max(columns.prod(), 1)))), 1)
    whole = np.flatnonzero(many > 0)
    return np.split(whole, np.flatnonzero(np.diff(np.cumsum(many[whole]) // PAIRS)) + 1)


def _pairs(part: Ints, first: Ints, last: Ints, begin: Ints, columns: Ints) -> tuple[Ints, Ints]:
    """Return the pairs (triangle, place in the order of points) whose cells of the plan agree."""
    extent = last[part] - first[part] + 1
    cells = extent.prod(axis=1)
    triangle = np.repeat(part, cells)
    number = np.arange(len(triangle)) - np.repeat(np.cumsum(cells) - cells, cells)
    across = np.repeat(extent[:, 1], cells)
    key = (first[triangle, 0] + number // across) * columns[1] + first[triangle, 1] + number % across
    many = begin[key + 1] - begin[key]
    triangle = np.repeat(triangle, many)
    return triangle, np.repeat(begin[key], many) + np.arange(len(triangle)) - np.repeat(np.cumsum(many) - many, many)


def _below(place: Floats, height: Floats, corners: Floats) -> Flags:
    """Return which triangles (n, 3, 3) [m] the vertical line downward from each point meets, (n,) bool."""
    a, b, c = (corners[:, k, :2] - place for k in range(3))
    one, two, three = (p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0] for p, q in ((b, c), (c, a), (a, b)))
    inside = ((one >= 0.0) == (two >= 0.0)) & ((two >= 0.0) == (three >= 0.0))
    total = one + two + three
    z = (one * corners[:, 0, 2] + two * corners[:, 1, 2] + three * corners[:, 2, 2]) / np.where(total, total, 1.0)
    found: Flags = inside & (z < height) & (total != 0.0)
    return found
