"""The water that passes a line (2D)."""

from collections.abc import Iterator
from typing import Annotated, Any, Literal, Optional

import numpy as np
from pydantic import Field

from parisph.base.text import point
from parisph.case import probe_checks
from parisph.case.probes import Probe
from parisph.case.scene import Scene
from parisph.watch.sampling import View


class Flux(Probe):
    """Water that passes the straight line from `start` to `end` [m]: its rate [m2/s] and the total so far [m2].

    Both are positive for water that passes from the left of the line to its right, as seen from `start` to `end`:
    towards +x, if the line goes upwards. They are per metre of width. The line is fixed in the frame of the scene.

    total : the sum of the volumes of all particles that have passed, less those that have come back. It is exact: it
        equals the gain of a basin that the line closes
    rate : by the velocities of particles within a spacing of the line at that time. Its integral differs from the total
        by the displacements that keep the distances of particles even

    pause : time without water passing that ends an event [s]. The summary then has start, end and volume of each event,
        as for crests over a wall; the sum of the volumes is the total. None for no events

    >>> Flux("over", start=(4.0, 0.5), end=(4.0, 1.0), pause=0.3).pause
    0.3
    """

    columns = {"rate": "m^2/s", "total": "m^2"}
    dims = (2,)
    judged = "total"
    quantity, quantities = "volume rate", {"total": "volume passed"}

    kind: Literal["flux"] = Field(default="flux", init=False)
    start: Annotated[tuple[float, ...], Field(min_length=2, max_length=2, description="first point (x, y) [m]")]
    end: Annotated[tuple[float, ...], Field(min_length=2, max_length=2, description="last point (x, y) [m]")]
    pause: Optional[float] = Field(default=None, gt=0, description="time without water passing that ends an event [s]")

    @property
    def line(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        return self.start, self.end

    def title(self, scene: Any) -> str:
        ends = f"{point(self.start)} to {point(self.end)}"
        return f"Water that passes the line from {ends} m, positive from its left to its right"

    def problems(self, case: Scene) -> Iterator[str]:
        middle = tuple(0.5 * (a + b) for a, b in zip(self.start, self.end))
        yield from list(probe_checks.line(case, self.start, self.end)) or probe_checks.inside(
            case, "the middle of the line", [middle, self.start, self.end])

    def sums(self, view: View) -> tuple[float, ...]:
        """See Probe. The rate is the sum of volume times velocity across the line, weighted by a hat function of the
        distance. On a lattice of the spacing these weights add up to 1 for any place of the line.
        """
        p, s, along = view.particles, view.scene.spacing, np.subtract(self.end, self.start)
        length = float(np.hypot(*along))
        along /= length
        across, off = np.array([along[1], -along[0]]), p.x - self.start
        away, share = np.abs(off @ across), off @ along
        near = np.flatnonzero(view.fluid & (away < s) & (share >= 0.0) & (share <= length))
        rate = (p.volume[near] * (1.0 - away[near] / s) / s) @ (p.u[near] @ across)
        return float(rate), view.passages.mine(self) if view.passages is not None else 0.0
