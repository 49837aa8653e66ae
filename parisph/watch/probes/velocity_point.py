"""Velocity and pressure at one point inside the fluid."""

from collections.abc import Iterator
from itertools import product
from typing import Any, Literal

import numpy as np
from pydantic import Field

from parisph.base.arrays import Floats
from parisph.base.text import point
from parisph.case import probe_checks
from parisph.case.probes import Point
from parisph.case.scene import Scene
from parisph.geometry.probe_places import Places
from parisph.watch.points import AtPoints

TIE = 1e-6    # [spacings] tolerance of a point on a wall


class VelocityPoint(AtPoints):
    """Velocity u, v [m/s] and pressure p [Pa] at the point `at` [m]; nan outside the fluid.

    >>> VelocityPoint("below", at=(2.0, 0.1)).at
    (2.0, 0.1)
    """

    kind: Literal["velocity_point"] = Field(default="velocity_point", init=False)
    at: Point

    @property
    def places(self) -> Floats:
        return np.array([self.at])

    def title(self, scene: Any) -> str:
        return f"Velocity and pressure at {point(self.at)} m"

    def problems(self, case: Scene) -> Iterator[str]:
        yield from list(probe_checks.components(case, at=self.at)) or probe_checks.inside(case, "at", [self.at])

    def misplaced(self, places: Places) -> Iterator[str]:
        around = TIE * places.spacing * np.array([(0,) * len(self.at), *product((1, -1), repeat=len(self.at))])
        if not places.in_front(self.at + around, resting=True):
            yield f"at = {self.at} is not in front of the walls, where fluid can come; move it"
