"""The front of the water."""

from collections.abc import Iterator
from typing import Literal

import numpy as np
from pydantic import Field

from parisph.base.arrays import Floats, Ints
from parisph.base.probe_rows import WIDTH
from parisph.case.probes import AcrossProbe
from parisph.case.scene import Scene
from parisph.watch.gauges import BED, BED_GAP, COLUMN, ROUNDING, bodies, bodies_of_all, body_rows
from parisph.watch.sampling import ProbeScene, View


class WaterFront(AcrossProbe):
    """Position x [m] of the water's foremost particle along the bed.

    Only the main body of the water within 2 spacings of the bed counts: the largest without a gap of more than 2.1
    spacings along x. So a droplet ahead is not the front. Without a bed, it is that of all fluid.

    In 3D the water is looked at in strips 3 spacings broad, each as in 2D. Water of neighbouring strips is one body
    where it overlaps along x, to 2.1 spacings.

    y : of the middle of the only strip, in a 3D scene; None for all

    >>> WaterFront("front").kind
    'water_front'
    """

    columns = {"x": "m"}
    quantity = "front position $x$"

    kind: Literal["water_front"] = Field(default="water_front", init=False)

    def title(self, scene: ProbeScene) -> str:
        what = ("Position of the water's foremost particle along the bed" if scene.tank or scene.now is not None
                else "Foremost position of the fluid")
        return what if self.y is None else f"{what}, at y = {self.y:g} m"

    def problems(self, case: Scene) -> Iterator[str]:
        return self.wrong_y(case)

    def rows(self, view: View) -> Floats:
        x, s = view.body, view.scene.spacing
        if self.y is not None:
            x = x[np.abs(x[:, 1] - self.y) <= COLUMN * s * ROUNDING]
        bed = view.scene.bed_at(x[:, :-1], view.time)
        if bed is not None:
            x = x[x[:, -1] <= bed + BED * s * ROUNDING]
        if view.scene.dim == 2 or self.y is not None:
            return body_rows(bodies(x[:, 0], BED_GAP * s))
        strip = np.floor((x[:, 1] - view.scene.lower[1]) / (2.0 * COLUMN * s)).astype(np.int64)
        return np.concatenate([np.empty((0, WIDTH)), *(_strip_rows(number, bodies(x[strip == number, 0], BED_GAP * s))
                                                       for number in np.unique(strip))])

    def values(self, sums: Floats, rows: Floats, view: View) -> tuple[float, ...]:
        return (_front(rows, BED_GAP * view.scene.spacing),)


def _strip_rows(number: int, found: Floats) -> Floats:
    """Return bodies (n, 3) of a strip as rows with its number."""
    rows = body_rows(found)
    rows[:, 0] = number
    return rows


def _front(rows: Floats, gap: float) -> float:
    """Return the upper end [m] of the largest body of all strips, nan without any. A row begins with its strip."""
    if not len(rows):
        return np.nan
    strips = {int(number): bodies_of_all(rows[rows[:, 0] == number], gap) for number in np.unique(rows[:, 0])}
    parts = np.concatenate(list(strips.values()))
    strip = np.repeat(list(strips), [len(found) for found in strips.values()])
    group = _groups(strip, parts, gap)
    many = np.bincount(group, parts[:, 2])
    return float(parts[group == np.argmax(many), 1].max())


def _groups(strip: Ints, parts: Floats, gap: float) -> Ints:
    """Return the number (n,) of the body to which each part (n, 3) of a strip belongs."""
    group = np.arange(len(parts))
    joined = (strip[:, None] + 1 == strip) & (parts[:, None, 0] <= parts[:, 1] + gap) & (
        parts[:, 0] <= parts[:, None, 1] + gap)
    for one, other in np.argwhere(joined):
        group[group == group[other]] = group[one]
    return group
