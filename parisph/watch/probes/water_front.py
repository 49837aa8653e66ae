"""The front of the water."""

from typing import Literal

import numpy as np
from pydantic import Field

from parisph.base.arrays import Floats
from parisph.case.probes import Probe
from parisph.watch.gauges import BED, BED_GAP, ROUNDING, bodies, bodies_of_all, body_rows
from parisph.watch.sampling import ProbeScene, View


class WaterFront(Probe):
    """Position x [m] of the water's foremost particle along the bed.

    Only the main body of the water within 2 spacings of the bed counts: the largest without a gap of more than 2.1
    spacings along x. So a droplet ahead is not the front. Without a bed, it is that of all fluid.

    >>> WaterFront("front").kind
    'water_front'
    """

    columns = {"x": "m"}
    dims = (2,)
    quantity = "front position $x$"

    kind: Literal["water_front"] = Field(default="water_front", init=False)

    def title(self, scene: ProbeScene) -> str:
        return ("Position of the water's foremost particle along the bed" if scene.tank or scene.now is not None
                else "Foremost position of the fluid")

    def rows(self, view: View) -> Floats:
        x, y = view.body[:, 0], view.body[:, -1]
        bed = view.scene.bed_at(x, view.time)
        if bed is not None:
            x = x[y <= bed + BED * view.scene.spacing * ROUNDING]
        return body_rows(bodies(x, BED_GAP * view.scene.spacing))

    def values(self, sums: Floats, rows: Floats, view: View) -> tuple[float, ...]:
        found = bodies_of_all(rows, BED_GAP * view.scene.spacing)
        return (found[np.argmax(found[:, 2]), 1] if len(found) else np.nan,)
