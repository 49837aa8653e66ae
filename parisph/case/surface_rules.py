"""Checks of Surfaces in a scene that do not need their files."""

from collections import Counter
from collections.abc import Iterator

from parisph.case.bodies import Plate, Profile, motion_of
from parisph.case.motion import AtRest
from parisph.case.scene import Scene
from parisph.case.scenery import body_names
from parisph.case.shapes import Tank


def problems(case: Scene) -> Iterator[str]:
    """Yield the problems of the Surfaces of a case, one line each."""
    if not case.surfaces:
        return
    names = [surface.name for surface in case.surfaces]
    what = f"walls, {names[0]}: a Surface"
    if case.dim == 2:
        yield f"{what} is for 3D scenes; give the Tank or the Profile around it a breadth"
        return
    if not case.bodies:
        yield f"{what} needs walls around the fluid; give a Tank or a Profile with a breadth"
        return
    for name, count in sorted(Counter([*body_names(case.bodies), *names]).items()):
        if count > 1 and name in names:
            yield f"walls: the name {name!r} is given {count} times; give each body a name of its own"
    for name, body in zip(body_names(case.bodies), case.bodies):
        if isinstance(body, Plate):
            yield (f"walls, {name}: a Plate has no thickness, and cannot be in a scene with Surfaces so far; give an "
                   "Obstacle with the thickness of two spacings")
        around = isinstance(body, Tank) or isinstance(body, Profile) and body.breadth is not None
        if around and not isinstance(motion_of(body), AtRest):
            yield (f"walls, {name}: it cannot move and leave the Surfaces behind; move the whole scene by frame=")
