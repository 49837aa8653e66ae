"""Bodies of water along a line, and the height of the free surface (2D).

Computed from the few particles near a gauge. Nothing is collective.
"""

from collections.abc import Sequence

import numpy as np

from parisph.base.arrays import Floats

COLUMN = 1.5    # half the width of the column of water at a gauge, in spacings
SLOPE = 2.0     # steeper than this between two particles is not one smooth surface
CLOSEST = 0.05  # nor are two particles nearer to each other along x, in spacings

Place = tuple[float, float]    # x, y [m]


def bodies(z: Floats, gap: float, counts: Floats | None = None, ends: Floats | None = None) -> Floats:
    """Return the connected bodies (n, 3) along a line: lower end [m], upper end [m], particles; in order.

    Neighbours along the line belong to one body unless they are farther apart than `gap` [m].

    z : (n,) positions of particles, or lower ends of bodies, in any order [m]
    counts, ends : (n,), of bodies found before (each rank finds the bodies of its own particles;
        joining these gives the bodies of all particles)
    """
    order = np.argsort(z)
    z = z[order]
    if len(z) == 0:
        return np.empty((0, 3))
    reach = z if ends is None else np.maximum.accumulate(ends[order])
    first = np.flatnonzero(np.concatenate([[True], z[1:] - reach[:-1] > gap]))
    last = np.append(first[1:], len(z)) - 1
    number = np.ones(len(z)) if counts is None else counts[order]
    return np.column_stack([z[first], reach[last], np.add.reduceat(number, first)])


def surface_height(at: float, x: Floats, y: Floats, top: float, spacing: float,
                   walls: Sequence[float]) -> float:
    """Return the height [m] of the free surface above x = `at`, from the particles on it.

    If the surface is smooth and single-valued, this is the polynomial through the two particles on
    either side: of fourth order in the spacing, and continuous when a particle passes the gauge. At a
    vertical wall d(eta)/dx = 0: particles are mirrored in it, and the polynomial through (-b, y2),
    (-a, y1), (a, y1), (b, y2) has the value (y1 b^2 - y2 a^2)/(b^2 - a^2) at the wall. If there are
    steps steeper than SLOPE, only the nearest particles are used, or only `top`.

    x, y : (n,) particles on the surface, in any order [m]
    top : highest water within COLUMN spacings of the gauge [m]
    walls : positions x of vertical walls [m]
    """
    points = [(a, b) for a, b in zip(x.tolist(), y.tolist())]
    points += [(2.0 * wall - a, b) for wall in walls for a, b in points]
    points = [point for point in points if _reachable(*point, at, top, spacing)]
    points.sort(key=lambda point: (abs(point[0] - at), -point[1]))
    left: list[Place] = []
    right: list[Place] = []
    for point in points:
        side = left if point[0] < at else right
        if len(side) < 2 and not _covered(*point, points, spacing):
            side.append(point)
    if not left or not right or not _smooth(left[0], right[0], spacing):
        return float(top)
    nodes = [left[0], right[0],
             *(side[1] for side in (left, right) if len(side) == 2 and _smooth(side[0], side[1], spacing))]
    return _through(nodes, at)


def _reachable(x: float, y: float, at: float, top: float, spacing: float) -> bool:
    """Return whether a surface of at most SLOPE can rise from the top near the gauge to (x, y); spray is higher."""
    return y - top <= SLOPE * max(abs(x - at) - COLUMN * spacing, 0.0)


def _covered(x: float, y: float, points: Sequence[Place], spacing: float) -> bool:
    """Return whether another surface lies above, too close along x for a surface of at most SLOPE."""
    return any(abs(a - x) < spacing and b - y > SLOPE * max(abs(a - x), 0.5 * spacing) for a, b in points)


def _smooth(one: Place, other: Place, spacing: float) -> bool:
    step = abs(one[0] - other[0])
    return step >= CLOSEST * spacing and abs(one[1] - other[1]) <= SLOPE * step


def _through(nodes: Sequence[Place], at: float) -> float:
    """Value at `at` of the polynomial through the points (Lagrange)."""
    value = 0.0
    for i, (x, y) in enumerate(nodes):
        for j, (other, _) in enumerate(nodes):
            if j != i:
                y *= (at - other) / (x - other)
        value += y
    return value
