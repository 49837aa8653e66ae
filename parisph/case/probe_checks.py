"""Checks of probes that several kinds share. Each yields one line per problem: field, value, limit and remedy."""

from collections.abc import Iterator, Sequence

import numpy as np

from parisph.base.text import point, shown
from parisph.case.scene import Scene
from parisph.case.scenery import body_names

Points = Sequence[Sequence[float]]


def inside(case: Scene, field: str, points: Points) -> Iterator[str]:
    """At least one of the points must lie within the walls, or above them if there is no lid."""
    if case.wall_bounds is None:
        return
    (low, high), x = case.wall_bounds, np.array(points, dtype=float)
    tolerance = 1e-6 * float(np.max(high - low))
    high = high + np.where(np.arange(case.dim) < case.dim - 1 + case.lidded, 0.0, np.inf)
    if not np.all((x >= low - tolerance) & (x <= high + tolerance), axis=1).any():
        yield (f"{field} = {shown(tuple(x[0].tolist()))} must lie within the walls, from {point(low)} to "
               f"{point(high)}; move it")


def components(case: Scene, **points: Sequence[float]) -> Iterator[str]:
    """Each point must have as many components as the scene has dimensions."""
    for name, x in points.items():
        if len(x) != case.dim:
            axes = "(x, y, z), with y across and z up" if case.dim == 3 else "(x, y), as the scene is 2D"
            yield f"{name} = {x} must have {case.dim} components; give {axes}"


def line(case: Scene, start: Sequence[float], end: Sequence[float]) -> Iterator[str]:
    """The ends of a line must differ."""
    found = list(components(case, start=start, end=end))
    yield from found
    if not found and start == end:
        yield f"start and end = {start}: must be two points; move one of them"


def body(case: Scene, on: str, surfaces: bool = False) -> Iterator[str]:
    """A body must have this name. surfaces : whether a Surface will do"""
    names, files = body_names(case.bodies), [surface.name for surface in case.surfaces]
    if not names:
        yield "there is no tank; give walls=Tank(...) or leave the probe out"
    elif on in files and not surfaces:
        yield (f"on = {on!r}: a Surface has no section in which this is measured; give another body, or gauges above "
               "the Surface")
    elif on not in names + files:
        known = names + files * surfaces
        yield f"on = {on!r}: there is no body of this name; there is {', '.join(map(repr, known))}"
