"""The height of a column of water."""

from typing import Any, Literal

from pydantic import Field

from parisph.base.arrays import Floats
from parisph.case.probes import Gauge
from parisph.watch.gauges import COLUMN_GAP, column_rows, top
from parisph.watch.sampling import View


class ColumnHeight(Gauge):
    """Height [m] of the topmost water connected to the bed at x = `at`, in 3D at (x, y) [m].

    The topmost particle counts, within 1.5 spacings along x, in 3D around the place, of the water whose lowest particle
    is within 2.1 spacings of the bed. Nothing is added to its height, because surface particles of the lattice are on
    the surface. A gap of more than 2.1 spacings ends the column, above a particle inside the fluid 3.35. A dry bed
    gives its own height.

    >>> ColumnHeight("column", at=0.0).at
    0.0
    """

    quantity = "column height $y$"

    kind: Literal["column_height"] = Field(default="column_height", init=False)

    def title(self, scene: Any) -> str:
        return f"Height of the water column at {self.where}"

    def rows(self, view: View) -> Floats:
        return column_rows(view, self.place, COLUMN_GAP)

    def values(self, sums: Floats, rows: Floats, view: View) -> tuple[float, ...]:
        return (top(rows, view, self.place, COLUMN_GAP)[0],)
