"""Checks of the places of probes in a scene. Each yields one line per problem, with field, value, limit and remedy."""

from collections.abc import Iterator, Sequence

import numpy as np

from parisph.base.text import shown
from parisph.case.bodies import Body, motion_of
from parisph.case.expressions import uniform_field
from parisph.case.motion import Rotation
from parisph.case.probes import (
    ColumnHeight,
    Flux,
    Force,
    PressureTap,
    RunUp,
    SurfaceGauge,
    VelocityPoint,
    VelocityProfile,
    singles,
)
from parisph.case.scene import Scene
from parisph.case.scenery import body_names


def problems(case: Scene) -> Iterator[str]:
    """Yield the problems of all probes of a case."""
    for name, probe in singles(case.probes):
        what = f"probe {name!r}"
        if isinstance(probe, PressureTap):
            yield from _tap(case, probe, what)
        elif isinstance(probe, (VelocityProfile, Flux)):
            found = list(_line(case, probe, what))
            yield from found
            if isinstance(probe, Flux) and not found:
                middle = tuple(0.5 * (a + b) for a, b in zip(probe.start, probe.end))
                yield from _within(case, what, "the middle of the line", [middle, probe.start, probe.end])
        elif isinstance(probe, VelocityPoint):
            found = list(_components(case, what, at=probe.at))
            yield from found or _within(case, what, "at", [probe.at])
        elif isinstance(probe, (SurfaceGauge, ColumnHeight)) and case.wall_bounds is not None:
            low, high = case.wall_bounds
            if not low[0] <= probe.at <= high[0]:
                yield f"{what}: at = {probe.at:g} must lie within the walls, from x = {low[0]:g} to {high[0]:g}"
        elif isinstance(probe, (RunUp, Force)):
            yield from _on_body(case, probe, what)


def _within(case: Scene, what: str, field: str, points: Sequence[Sequence[float]]) -> Iterator[str]:
    """One of the points must lie between the walls; above them there may be water unless there is a lid."""
    if case.wall_bounds is None:
        return
    (low, high), x = case.wall_bounds, np.array(points, dtype=float)
    tolerance = 1e-6 * float(np.max(high - low))
    high = high + np.where(np.arange(case.dim) < case.dim - 1 + case.lidded, 0.0, np.inf)
    if not np.all((x >= low - tolerance) & (x <= high + tolerance), axis=1).any():
        ends = " to ".join(f"({', '.join(f'{a:g}' for a in end)})" for end in (low, high))
        yield f"{what}: {field} = {shown(tuple(x[0].tolist()))} must lie within the walls, from {ends}; move it"


def _components(case: Scene, what: str, **points: Sequence[float]) -> Iterator[str]:
    for name, point in points.items():
        if len(point) != case.dim:
            yield f"{what}: {name} = {point} must have {case.dim} components"


def _line(case: Scene, probe: VelocityProfile | Flux, what: str) -> Iterator[str]:
    found = list(_components(case, what, start=probe.start, end=probe.end))
    yield from found
    if not found and probe.start == probe.end:
        yield f"{what}: start and end = {probe.start}: must be two points"


def _tap(case: Scene, probe: PressureTap, what: str) -> Iterator[str]:
    if case.walls is None:
        yield f"{what}: a pressure tap needs a wall; give walls=Tank(...) or leave the tap out"
        return
    if len(probe.at) != case.dim:
        yield f"{what}: at = {probe.at} must have {case.dim} components"


def _on_body(case: Scene, probe: RunUp | Force, what: str) -> Iterator[str]:
    """The line or the body of a probe must exist."""
    points = probe.points if isinstance(probe, RunUp) else (probe.about,)
    for point in points or ():
        yield from _components(case, what, point=point)
    if isinstance(probe, Force) and probe.still is not None:
        force = None if case.turns else uniform_field(case.gravity)
        if force is None or force[:-1].any() or not force[-1] < 0.0:
            yield (f"{what}: still = {probe.still:g}: there is no hydrostatic force where gravity is not constant and "
                   "straight down; leave it out")
    names = body_names(case.bodies)
    if isinstance(probe, RunUp) and probe.points is not None:
        if any(len(point) != case.dim for point in probe.points):
            return
        if any(one == other for one, other in zip(probe.points, probe.points[1:])):
            yield f"{what}: points: two that follow each other must be two points"
        else:
            yield from _within(case, what, "points", probe.points)
        if probe.on not in ("tank", *names):
            yield f"{what}: on = {probe.on!r}: there is no body of this name; there is {', '.join(map(repr, names))}"
        return
    if not names:
        yield f"{what}: there is no tank; give walls=Tank(...) or leave the probe out"
    elif probe.on not in names:
        yield f"{what}: on = {probe.on!r}: there is no body of this name; there is {', '.join(map(repr, names))}"
    else:
        yield from _side(case, probe, what, case.bodies[names.index(probe.on)])


def _side(case: Scene, probe: RunUp | Force, what: str, body: Body) -> Iterator[str]:
    kind = body.kind
    if isinstance(probe, RunUp):
        if probe.side is None and kind not in ("piston", "flap"):
            yield f"{what}: on = {probe.on!r}: give the side of it, side='left' or 'right', or the points of a line"
        elif probe.side is not None and kind in ("piston", "flap"):
            yield f"{what}: side = {probe.side!r}: {probe.on} has fluid on one side only; leave it out"
        elif probe.film is not None and kind == "tank" and not isinstance(motion_of(body), Rotation):
            yield (f"{what}: film = {probe.film:g} m is of no use at a vertical side, where the surface is that of a "
                   "SurfaceGauge; leave it out, or give the points of a line")
    elif kind != "tank" and probe.side is not None:
        yield f"{what}: side = {probe.side!r}: only a tank has sides; leave it out"
    elif probe.side == "lid" and not case.lidded:
        yield f"{what}: side = 'lid': the tank has none; give it one, or choose another side"
