"""The water that passes a line, in 3D a rectangle."""

from collections.abc import Iterator
from typing import Any, Literal, Optional

import numpy as np
from pydantic import Field, SerializerFunctionWrapHandler, model_serializer

from parisph.base.text import point
from parisph.case import probe_checks
from parisph.case.breadth import LATER, Across
from parisph.case.probes import Point, Probe
from parisph.case.scene import Scene
from parisph.watch.passages import Gate
from parisph.watch.sampling import ProbeScene, View


class Flux(Probe):
    """Water that passes the straight line from `start` to `end` [m]: its rate [m2/s] and the total so far [m2].

    Both are positive for water that passes from the left of the line to its right, as seen from `start` to `end`:
    towards +x, if the line goes upwards. They are per metre of width. The line is fixed in the frame of the scene.

    In 3D it is a rectangle, with rate [m3/s] and total [m3]. Two points (x, z) give a line in the section, which
    reaches over the whole breadth, or over `across`. Two points (x, y, z) are opposite corners of a vertical rectangle.
    Seen from above, water counts as positive from the left of the way from `start` to `end` to its right: towards +x,
    if y increases.

    total : the sum of the volumes of all particles that have passed, less those that have come back. It is exact: it
        equals the gain of a basin that the line closes
    rate : by the velocities of particles within a spacing of the line at that time. Its integral differs from the total
        by the displacements that keep the distances of particles even

    pause : time without water passing that ends an event [s]. The summary then has start, end and volume of each event,
        as for crests over a wall; the sum of the volumes is the total. None for no events

    >>> Flux("over", start=(4.0, 0.5), end=(4.0, 1.0), pause=0.3).pause
    0.3
    >>> Flux("beside", start=(0.7, 0.7, 0.0), end=(0.7, 1.0, 1.0)).end
    (0.7, 1.0, 1.0)
    """

    columns = {"rate": "m^2/s", "total": "m^2"}
    judged = "total"
    quantity, quantities = "volume rate", {"total": "volume passed"}

    kind: Literal["flux"] = Field(default="flux", init=False)
    start: Point = Field(description="first point (x, y), in 3D (x, z) or (x, y, z) [m]")
    end: Point = Field(description="last point (x, y), in 3D (x, z) or (x, y, z) [m]")
    pause: Optional[float] = Field(default=None, gt=0, description="time without water passing that ends an event [s]")
    across: Across = Field(default=None, kw_only=True)

    @model_serializer(mode="wrap")
    def _as_before(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Leave out what only a 3D scene has: releases before do not know it."""
        return {name: value for name, value in handler(self).items() if value is not None or name not in LATER}

    def gate(self, dim: int) -> Gate:
        if dim == 2:
            return Gate(self.start, self.end)
        if len(self.start) == 2:
            return Gate(self.start, self.end, (0, 2), 1, self.across)
        low, high = sorted((self.start[2], self.end[2]))
        return Gate(self.start[:2], self.end[:2], (0, 1), 2, (low, high))

    def columns_in(self, scene: ProbeScene) -> dict[str, str]:
        return dict(self.columns) if scene.dim == 2 else {"rate": "m^3/s", "total": "m^3"}

    def title(self, scene: ProbeScene) -> str:
        ends = f"{point(self.start)} to {point(self.end)}"
        if scene.dim == 2:
            return f"Water that passes the line from {ends} m, positive from its left to its right"
        across = "" if self.across is None else f", across y = {self.across[0]:g} to {self.across[1]:g} m"
        seen = ", seen from above" if len(self.start) == 3 else ""
        return f"Water that passes the rectangle from {ends} m{across}, positive from its left to its right{seen}"

    def problems(self, case: Scene) -> Iterator[str]:
        found = list(self._wrong_line(case))
        yield from found
        if found:
            return
        a, b = (self._corner(case, x) for x in (self.start, self.end))
        middle = tuple(0.5 * (one + other) for one, other in zip(a, b))
        yield from probe_checks.inside(case, "the middle of the line" if case.dim == 2 else
                                       "the middle of the rectangle", [middle, a, b])

    def _wrong_line(self, case: Scene) -> Iterator[str]:
        if case.dim == 2:
            yield from probe_checks.line(case, self.start, self.end)
            if self.across is not None:
                yield f"across = {self.across}: only a 3D scene has places across; leave it out"
            return
        if len(self.start) != len(self.end):
            yield (f"start = {self.start} and end = {self.end}: give both as (x, z), for a line of the section, or "
                   "both as (x, y, z), for a vertical rectangle")
        elif len(self.start) == 2:
            low, high = case.breadth or (-np.inf, np.inf)
            if self.start == self.end:
                yield f"start and end = {self.start}: must be two points; move one of them"
            if self.across is not None and not low <= self.across[0] < self.across[1] <= high:
                yield f"across = {self.across} must lie within the breadth, from y = {low:g} to {high:g}; move it"
        elif self.across is not None:
            yield f"across = {self.across}: the corners (x, y, z) give the rectangle; leave it out"
        elif self.start[:2] == self.end[:2] or self.start[2] == self.end[2]:
            yield (f"start = {self.start} and end = {self.end} must be opposite corners of a vertical rectangle, with "
                   "two places (x, y) and two heights; for another rectangle give (x, z) and across=")

    def _corner(self, case: Scene, x: Point) -> Point:
        """Return a corner, or the middle of an end of the rectangle, (dim,) [m]."""
        if case.dim == 2 or len(x) == 3:
            return x
        low, high = self.across or case.breadth or (0.0, 0.0)
        return x[0], 0.5 * (low + high), x[1]

    def sums(self, view: View) -> tuple[float, ...]:
        """See Probe. The rate is the sum of volume times velocity across the line, weighted by a hat function of the
        distance. On a lattice of the spacing these weights add up to 1 for any place of the line.
        """
        p, s, gate = view.particles, view.scene.spacing, self.gate(view.scene.dim)
        near, away, across = gate.near(p.x, s)
        own = view.fluid[near]
        near, away = near[own], away[own]
        rate = (p.volume[near] * (1.0 - away / s) / s) @ (p.u[near] @ across)
        return float(rate), view.passages.mine(gate) if view.passages is not None else 0.0
