"""The height of the free surface above a place."""

from collections.abc import Sequence
from typing import Any, Literal, Union

from pydantic import Field

from parisph.base.arrays import Floats
from parisph.base.probe_rows import HEIGHT
from parisph.case.probes import Gauge
from parisph.case.truths import Peaks, Truth, WaveTruth
from parisph.watch.gauges import COLUMN, GAUGE_GAP, column_rows, top
from parisph.watch.sampling import View

NODES = 4.0     # spacings within which surface particles may serve a gauge
SLOPE = 2.0     # steeper than this between two particles is not one smooth surface
CLOSEST = 0.05  # spacings: nor are two particles nearer to each other along x

Place = tuple[float, float]    # x, y [m]


class SurfaceGauge(Gauge):
    """Height y of the free surface [m] above x = `at` [m].

    It is a smooth fit if the surface is smooth (`surface_height`). Where the surface breaks, the value is
    that of a ColumnHeight; on a dry bed it is the height of the bed.

    >>> SurfaceGauge("gauge", at=0.25).name
    'gauge'
    """

    dims = (2,)
    of_surface = True
    quantity = "surface height $y$"

    kind: Literal["surface_gauge"] = Field(default="surface_gauge", init=False)
    truth: Union[Truth, WaveTruth, Peaks, None] = Field(    # type: ignore[assignment]    # a theory of the surface, too
        default=None, kw_only=True)

    def title(self, scene: Any) -> str:
        return f"Height of the free surface above x = {self.at:g} m"

    def rows(self, view: View) -> Floats:
        return surface_rows(view, self.at)

    def values(self, sums: Floats, rows: Floats, view: View) -> tuple[float, ...]:
        return (surface(rows, view, self.at),)


def surface_rows(view: View, at: float) -> Floats:
    """Return what `surface` needs of this rank at x = `at` [m]: rows (n, 4)."""
    return column_rows(view, at, GAUGE_GAP, NODES)


def surface(rows: Floats, view: View, at: float) -> float:
    """Return the height of the surface [m] at x = `at` [m] from the rows of all ranks."""
    height, s = rows[:, 0] == HEIGHT, view.scene.spacing
    highest, wet = top(rows[~height], view, at, GAUGE_GAP)
    if not height.any() or not wet:
        return highest
    mirrors = [side for side in view.scene.sides_at(view.time) if abs(side - at) < NODES * s]
    return surface_height(at, rows[height, 1], rows[height, 2], highest, s, mirrors)


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
    # what a surface of at most SLOPE can reach from the top near the gauge; spray is higher
    points = [(a, b) for a, b in points if b - top <= SLOPE * max(abs(a - at) - COLUMN * spacing, 0.0)]
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
