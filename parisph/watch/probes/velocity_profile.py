"""Velocity and pressure at points along a line."""

from collections.abc import Iterator
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


class VelocityProfile(AtPoints):
    """Velocity [m/s] and pressure [Pa] at `points` points, evenly spaced from `start` to `end` [m].

    The columns of point k are u_k, v_k and p_k; the first point is 0. Points outside the fluid have nan.

    >>> VelocityProfile("middle", start=(0.5, 0.0), end=(0.5, 1.0), points=3).places.tolist()
    [[0.5, 0.0], [0.5, 0.5], [0.5, 1.0]]
    """

    kind: Literal["velocity_profile"] = Field(default="velocity_profile", init=False)
    start: Point = Field(description="first point (x, y) [m]")
    end: Point = Field(description="last point (x, y) [m]")
    points: int = Field(default=21, ge=2, le=1000, description="number of points")

    @property
    def places(self) -> Floats:
        """The points (points, dim) [m]."""
        return np.linspace(self.start, self.end, self.points)

    def title(self, scene: Any) -> str:
        return f"Velocity and pressure at {self.points} points from {point(self.start)} to {point(self.end)} m"

    def problems(self, case: Scene) -> Iterator[str]:
        return probe_checks.line(case, self.start, self.end)

    def misplaced(self, places: Places) -> Iterator[str]:
        if not places.in_front(self.places):
            yield f"no point from {self.start} to {self.end} is in front of the walls; move it"
