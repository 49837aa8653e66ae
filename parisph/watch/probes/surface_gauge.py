"""The height of the free surface above a place."""

from typing import Any, Literal, Union

from parisph.base.arrays import Floats
from parisph.case.probes import Gauge
from parisph.case.truths import Peaks, Truth, WaveTruth
from parisph.watch.elevation import surface_height
from parisph.watch.gauges import GAUGE_GAP, HEIGHT, column_rows, top
from parisph.watch.sampling import View

NODES = 4.0    # spacings within which surface particles may serve a gauge


class SurfaceGauge(Gauge):
    """Height y of the free surface [m] above x = `at` [m].

    It is a smooth fit if the surface is smooth (watch.elevation.surface_height). Where the surface breaks, the value is
    that of a ColumnHeight; on a dry bed it is the height of the bed.

    Examples
    --------
    >>> SurfaceGauge("gauge", at=0.25).name
    'gauge'
    """

    dims = (2,)
    of_surface = True
    quantity = "surface height $y$"

    kind: Literal["surface_gauge"] = "surface_gauge"
    truth: Union[Truth, WaveTruth, Peaks, None] = None    # type: ignore[assignment]    # a theory of the surface, too

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
