"""The height of the free surface above a place."""

from collections.abc import Sequence
from typing import Any, Literal, Union

import numpy as np
from pydantic import Field

from parisph.base.arrays import Floats
from parisph.base.probe_rows import HEIGHT
from parisph.case.probes import Gauge
from parisph.case.truths import Peaks, Truth, WaveTruth
from parisph.watch import gauges
from parisph.watch.gauges import COLUMN, GAUGE_GAP, column_rows, top
from parisph.watch.sampling import View
from parisph.watch.surface_fit import RADIUS, fitted_height

NODES = 4.0     # [spacings] largest distance along x of surface particles for a gauge
SLOPE = 2.0     # largest slope between two particles of a smooth surface
CLOSEST = 0.05  # [spacings] least distance along x of two such particles

Place = tuple[float, float]    # x, y [m]


class SurfaceGauge(Gauge):
    """Height of the free surface [m] above x = `at`, in 3D above (x, y) [m].

    If the surface is smooth, the height is interpolated between particles (`surface_height`, in 3D
    surface_fit.fitted_height). Where it breaks, the height is that of the topmost particle of the column; on a dry bed
    it is that of the bed.

    >>> SurfaceGauge("gauge", at=0.25).name
    'gauge'
    """

    of_surface = True
    quantity = "surface height $y$"

    kind: Literal["surface_gauge"] = Field(default="surface_gauge", init=False)
    truth: Union[Truth, WaveTruth, Peaks, None] = Field(    # type: ignore[assignment]    # a theory of the surface, too
        default=None, kw_only=True)

    def title(self, scene: Any) -> str:
        return f"Height of the free surface above {self.where}"

    def rows(self, view: View) -> Floats:
        return surface_rows(view, self.place)

    def values(self, sums: Floats, rows: Floats, view: View) -> tuple[float, ...]:
        return (surface(rows, view, self.place),)


def surface_rows(view: View, place: gauges.Place) -> Floats:
    """Return the rows (n, WIDTH) of this rank for `surface` at x, in 3D (x, y) [m]."""
    return column_rows(view, place, GAUGE_GAP, NODES if len(place) == 1 else RADIUS)


def surface(rows: Floats, view: View, place: gauges.Place) -> float:
    """Return the height of the surface [m] at x, in 3D (x, y) [m], from the rows of all ranks."""
    height, s, at = rows[:, 0] == HEIGHT, view.scene.spacing, place[0]
    highest, wet = top(rows[~height], view, place, GAUGE_GAP)
    if not height.any() or not wet:
        return highest
    if len(place) == 2:
        near = [(axis, wall) for axis, wall in view.scene.mirrors_at(view.time) if abs(wall - place[axis]) < RADIUS * s]
        return fitted_height(np.array(place), rows[height, 1:4], highest, COLUMN * s, s, near)
    mirrors = [side for side in view.scene.sides_at(view.time) if abs(side - at) < NODES * s]
    return surface_height(at, rows[height, 1], rows[height, 2], highest, s, mirrors)


def surface_height(at: float, x: Floats, y: Floats, top: float, spacing: float,
                   walls: Sequence[float]) -> float:
    """Return the height [m] of the free surface above x = `at`, from the particles on it.

    If the surface is smooth and single-valued, this is the polynomial through two particles on either side. It is of
    fourth order in the spacing, and continuous when a particle passes the gauge. At a vertical wall d(eta)/dx = 0:
    particles are mirrored in it, and the polynomial through (-b, y2), (-a, y1), (a, y1), (b, y2) has the value
    (y1 b^2 - y2 a^2)/(b^2 - a^2) at the wall. With steps steeper than SLOPE, only the nearest particles are used, or
    only `top`; also where the nearest particles on both sides are more than NODES spacings apart, as below a lid.

    x, y : (n,) particles on the surface, in any order [m]
    top : highest water within COLUMN spacings of the gauge [m]
    walls : positions x of vertical walls [m]
    """
    points = [(a, b) for a, b in zip(x.tolist(), y.tolist())]
    points += [(2.0 * wall - a, b) for wall in walls for a, b in points]
    # without spray: points that a surface of at most SLOPE can reach from the top near the gauge
    points = [(a, b) for a, b in points if b - top <= SLOPE * max(abs(a - at) - COLUMN * spacing, 0.0)]
    points.sort(key=lambda point: (abs(point[0] - at), -point[1]))
    left: list[Place] = []
    right: list[Place] = []
    for point in points:
        side = left if point[0] < at else right
        if len(side) < 2 and not _covered(*point, points, spacing):
            side.append(point)
    if not left or not right or not _smooth(left[0], right[0], spacing) or right[0][0] - left[0][0] > NODES * spacing:
        return float(top)
    nodes = [left[0], right[0],
             *(side[1] for side in (left, right) if len(side) == 2 and _smooth(side[0], side[1], spacing))]
    return _through(nodes, at)


def _covered(x: float, y: float, points: Sequence[Place], spacing: float) -> bool:
    """Return whether another point is above, too near along x for a surface of at most SLOPE."""
    return any(abs(a - x) < spacing and b - y > SLOPE * max(abs(a - x), 0.5 * spacing) for a, b in points)


def _smooth(one: Place, other: Place, spacing: float) -> bool:
    step = abs(one[0] - other[0])
    return step >= CLOSEST * spacing and abs(one[1] - other[1]) <= SLOPE * step


def _through(nodes: Sequence[Place], at: float) -> float:
    """Return the value at `at` of the polynomial through the points (Lagrange)."""
    value = 0.0
    for i, (x, y) in enumerate(nodes):
        for j, (other, _) in enumerate(nodes):
            if j != i:
                y *= (at - other) / (x - other)
        value += y
    return value
