"""Checks of scenes of several bodies that do not need their geometry (see geometry.scene_checks)."""

from collections import Counter
from collections.abc import Iterator

from parisph.base.text import shown
from parisph.case.bodies import Body, Flap, Piston, motion_of
from parisph.case.fluids import Fluid
from parisph.case.scene import Scene
from parisph.case.shapes import Tank

CLOSE = 1e-9    # [m], [rad]: tolerance of the start of a motion


def body_names(bodies: tuple[Body, ...]) -> list[str]:
    """Return the names of bodies: as given, or tank, obstacle-1, ... by kind and position in the list."""
    return [body.name or body.kind + (f"-{number}" if number else "") for number, body in enumerate(bodies)]


def fluid_names(case: Scene) -> Iterator[tuple[str, Fluid]]:
    """Yield the bodies of fluid with their names in messages: fluid, or fluid[0], fluid[1], ... of several."""
    for number, fluid in enumerate(case.fluids):
        yield (f"fluid[{number}]" if isinstance(case.fluid, tuple) else "fluid"), fluid


def wall_speed(case: Scene) -> float:
    """Return the greatest speed [m/s] of a wall in the frame of the scene, 0 if none moves."""
    bounds = case.wall_bounds
    if bounds is None:
        return 0.0
    return max((motion_of(body).top_speed(*bounds) for body in case.bodies), default=0.0)


def longest_step(case: Scene) -> float:
    """Return the longest time step [s] that resolves the motions of frame and walls, infinite without motion."""
    return min([case.frame.longest_step, *(motion_of(body).longest_step for body in case.bodies)])


def problems(case: Scene) -> list[str]:
    """Return the problems of a case that come from its bodies, one line each."""
    return [*_bodies(case), *_fluids(case)]


def _bodies(case: Scene) -> Iterator[str]:
    bodies = case.bodies
    if case.walls is not None and not case.all_bodies:
        yield "walls = (): names no body; leave it out"
    for name, count in sorted(Counter(body_names(bodies)).items()):
        if count > 1:
            yield f"walls: the name {name!r} is given {count} times; give each body a name of its own"
    if sum(isinstance(body, Tank) for body in bodies) > 1:
        yield "walls: more than one Tank: fluid cannot be in both; give one Tank or Profile, and Obstacles in it"
    makers = [body for body in bodies if isinstance(body, (Piston, Flap))]
    if makers and len(makers) == len(bodies):
        yield f"walls: a {type(makers[0]).__name__} stands on a bed; give a Tank or a Profile with it"
    for name, body in zip(body_names(bodies), bodies):
        if case.closed and isinstance(body, (Piston, Flap)):
            yield (f"walls, {name}: the fluid fills the tank up to its lid, and has no room for the motion of a "
                   f"{type(body).__name__}; leave air below the lid")
        away = motion_of(body).law(0.0)[0]
        if abs(away) > CLOSE:
            yield (f"walls, {name}: its motion begins at {away:g}, must begin at 0; describe the body where it is at "
                   "t = 0, and the motion from there")


def _fluids(case: Scene) -> Iterator[str]:
    first = case.fluids[0]
    for number, fluid in enumerate(case.fluids[1:], 1):
        for field in ("density", "viscosity"):
            mine, other = getattr(fluid, field), getattr(first, field)
            if mine != other:
                yield (f"fluid[{number}].{field} = {shown(mine)}: must be that of fluid[0], {shown(other)}: "
                       "all bodies are of one fluid")
