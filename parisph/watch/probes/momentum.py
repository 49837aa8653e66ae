"""The momentum of the fluid."""

from typing import Literal

import numpy as np
from pydantic import Field

from parisph.base.arrays import Floats
from parisph.case.probes import Probe
from parisph.watch.sampling import ProbeScene, View


class Momentum(Probe):
    """Momentum of all fluid in the tank's frame [kg/s per metre of width].

    >>> Momentum("momentum").name
    'momentum'
    """

    columns = {"px": "kg/s", "py": "kg/s"}
    quantity = "momentum"

    kind: Literal["momentum"] = Field(default="momentum", init=False)

    def columns_in(self, scene: ProbeScene) -> dict[str, str]:
        return {f"p{axis}": "kg/s" if scene.dim == 2 else "kg m/s" for axis in "xyz"[:scene.dim]}

    def sums(self, view: View) -> Floats:
        found: Floats = np.asarray(view.particles.volume @ view.particles.u, float)
        return found

    def values(self, sums: Floats, rows: Floats, view: View) -> Floats:
        return view.scene.density * sums
