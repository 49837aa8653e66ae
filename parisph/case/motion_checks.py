"""Checks of the motions of a 3D scene: their directions, and bodies that leave their section."""

from collections.abc import Iterator

import numpy as np

from parisph.base.arrays import Floats
from parisph.base.text import shown
from parisph.case.bodies import Body, Obstacle, Plate, motion_of
from parisph.case.motion import Combined, Motion, Spatial, Sway, leaves_section
from parisph.case.motion.spatial import corners
from parisph.case.scene import Scene
from parisph.case.scenery import body_names
from parisph.case.shapes import Tank

CLEAR = 2.0     # spacings between a body that leaves its section and all others, as particles need room between them
MOST = 2000     # times at which the place of such a body is looked at
STILL = 0.05    # of the greatest angular velocities, below which a frame begins at rest: a spline of data does nearly
THERE = 1e-9    # of a spacing: greatest displacement of a body at the start


def problems(case: Scene) -> list[str]:
    """Return the problems of the motions of frame and bodies, one line each."""
    return [*(_flat(case) if case.dim == 2 else [*_ways(case), *_starts(case)])]


def clearances(case: Scene) -> list[str]:
    """Return the problems of bodies that leave their section and are not clear of others, one line each; none in 2D."""
    return [*_clear(case)] if case.dim == 3 else []


def _named(case: Scene) -> list[tuple[str, Motion]]:
    """Return the motions of frame and bodies, each part of a Combined, with their names in messages."""
    found = [("frame", case.frame), *((f"walls, {name}: motion", motion_of(body)) for name, body
                                      in zip(body_names(case.bodies), case.bodies))]
    parts = [(f"{name}.parts[{k}]", part) for name, motion in found if isinstance(motion, Combined)
             for k, part in enumerate(motion.parts)]
    return [*found, *parts]


def _flat(case: Scene) -> Iterator[str]:
    for name, motion in _named(case):
        if isinstance(motion, Spatial) and ".parts" not in name:
            yield (f"{name} = {motion.kind}: exists in 3D only, and this scene is 2D; use a Sway, Heave, Roll, Moved "
                   "or Tabulated, or give a Tank or a Profile a breadth")


def _ways(case: Scene) -> Iterator[str]:
    for name, motion in _named(case):
        way = motion.direction if isinstance(motion, Sway) else ()
        if len(way) == 2 and way[1] != 0.0:
            yield (f"{name}.direction = {shown(way)}: in 3D z is up, and y across; give three components, "
                   f"{shown((way[0], way[1], 0.0))} across or {shown((way[0], 0.0, way[1]))} upwards")


def _starts(case: Scene) -> Iterator[str]:
    """Water that turns with its tank at the start keeps the axis of its rotation in space."""
    frame = case.frame
    if isinstance(frame, Combined) and sum(part.turns for part in frame.parts) > 1:
        spin = float(np.linalg.norm(frame.spin_within(0.0)))
        if spin > STILL * sum(part.top_rate for part in frame.parts if part.turns):
            yield (f"frame = combined: it turns by {spin:.3g} rad/s at t = 0, about an axis that then changes: the "
                   "rotation that water has at the start would keep its axis in space; begin at rest, with a ramp "
                   "or with data that begin level, or give one rotation")


def _clear(case: Scene) -> Iterator[str]:
    named = list(zip(body_names(case.bodies), case.bodies))
    motions = {motion_of(body) for body in case.bodies}
    for name, body in named:
        motion = motion_of(body)
        if not leaves_section(motion):
            continue
        title = f"walls, {name}: motion = {motion.kind}"
        away = float(np.abs(motion.placed(_box(case, body), 0.0) - _box(case, body)).max())
        if away > THERE * case.numerics.spacing:
            yield (f"{title}: it begins {away:.3g} m from where the body is described, must begin at 0; describe the "
                   "body where it is at t = 0, and the motion from there")
        elif len(motions) == 1 and not case.surfaces:    # all of the scene moves as one
            continue
        elif not isinstance(body, Obstacle):
            yield (f"{title}: takes it out of its section, in which a {type(body).__name__} is joined with others; "
                   "only an Obstacle clear of all others can move so, or all walls together; move all by frame=")
        else:
            yield from _away(case, title, body, [pair for pair in named if motion_of(pair[1]) != motion])


def _box(case: Scene, body: Body) -> Floats:
    """Return the corners (n, 3) [m] of the box around a body, of a wavemaker its place."""
    if not hasattr(body, "bounds"):
        return np.zeros((1, 3))
    return corners(*case.box_of(body))


def _away(case: Scene, title: str, body: Obstacle, others: list[tuple[str, Body]]) -> Iterator[str]:
    """Compare the boxes around an obstacle and around others, in all places of the run."""
    need = CLEAR * case.numerics.spacing
    lower, upper = _swept(case, body)
    for name, other in others:
        if isinstance(other, Tank):
            low, high = map(np.array, case.box_of(other))
            if not other.closed:
                high[-1] = np.inf
            gap, advice = float(min((lower - low).min(), (high - upper).min())), "the box around it comes within"
        elif isinstance(other, (Obstacle, Plate)):
            low, high = _swept(case, other)
            gap, advice = float(np.maximum(low - upper, lower - high).max()), "the boxes around both come within"
        else:
            yield (f"{title}: takes it out of its section, for which nothing but a Tank, Obstacles and Plates may be "
                   f"around it, and {name} is a {type(other).__name__}; move it in the section, or all by frame=")
            continue
        if gap < need * (1.0 - 1e-9):
            yield (f"{title}: {advice} {max(gap, 0.0):.3g} m of {name}, must stay {need:.3g} m clear, {CLEAR:g} "
                   "spacings, as it leaves its section; move it away from there, move it less far, or make it smaller")


def _swept(case: Scene, body: Body) -> tuple[Floats, Floats]:
    """Return the corners (3,) [m] of the box around a body in all its places."""
    motion, x = motion_of(body), _box(case, body)
    times = motion.instants(case.end_time)
    places = np.concatenate([motion.placed(x, float(t)) for t in times[:: 1 + len(times) // MOST]])
    return places.min(axis=0), places.max(axis=0)
