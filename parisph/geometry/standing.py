"""The walls of a case as bodies with outlines: wavemakers become vertical faces on the bed (2D)."""

from collections.abc import Sequence

import numpy as np

from parisph.base.arrays import Floats
from parisph.base.errors import CaseError
from parisph.case.bodies import Flap, Obstacle, Piston, Profile
from parisph.case.motion import AtRest
from parisph.case.scene import Scene
from parisph.case.scenery import body_names
from parisph.case.shapes import Tank
from parisph.geometry.columns import crossings
from parisph.geometry.solid import Wall, solid_of
from parisph.geometry.tips import tips

ON = 1e-6    # of the height of a wavemaker: within this distance of a wall its hinge lies on it


def standing(case: Scene) -> tuple[Wall, ...]:
    """Return the walls of a case, named; a Piston or a Flap is the Profile of its face, with its motion.

    Solids follow that fill tips of the fluid too narrow for particles.
    Raises CaseError for a piston without a bed below it, and for a flap whose hinge is not on a wall.
    """
    walls = given(case)
    if len(walls) == 1 and isinstance(walls[0], Tank):
        return walls
    return *walls, *(tip.solid for tip in tips(walls, case.numerics.spacing))


def given(case: Scene) -> tuple[Wall, ...]:
    """Return the walls of a case like `standing`, without filled tips. Raises CaseError."""
    names = body_names(case.bodies)
    fixed = [body for body in case.bodies if not isinstance(body, (Piston, Flap)) and isinstance(body.motion, AtRest)]
    return tuple(_face(body, name, fixed) if isinstance(body, (Piston, Flap)) else body.model_copy(
        update={"name": name}) for body, name in zip(case.bodies, names))


def _face(maker: Piston | Flap, name: str, fixed: Sequence[Wall]) -> Profile:
    """Return the face of a wavemaker, with the fluid on its left."""
    top = max((float(body.bounds[1][-1]) for body in fixed), default=-np.inf) if maker.top is None else maker.top
    bottom = maker.hinge[1] if isinstance(maker, Flap) else maker.bottom
    beds = _beds(fixed, maker.place)
    if bottom is None:
        bed = _bed(fixed, maker.place)
        if bed is None:
            raise CaseError(f"walls, {name}: there is no bed below x = {maker.place:g}; extend a Profile or a Tank "
                            "below it, or give its lower end: bottom=...")
        bottom = bed
    if not top > bottom:
        raise CaseError(f"walls, {name}: its upper end at y = {top:g} is not above the lower one at {bottom:g}; give "
                        "top=...")
    if isinstance(maker, Flap) and not np.any(np.abs(beds - bottom) < ON * (top - bottom)):
        raise CaseError(f"walls, {name}: its hinge at ({maker.place:g}, {bottom:g}) is not on a wall; put it on the "
                        "bed or on an Obstacle")
    ends = (maker.place, bottom), (maker.place, top)
    return Profile(points=ends if maker.fluid_on_left else ends[::-1], side="left", name=name, slip=maker.slip,
                   motion=maker.moved)


def _bed(fixed: Sequence[Wall], x: float) -> float | None:
    """Return the height [m] of the bed at x, including solids that stand on it, or None without a bed."""
    open_ones = [body for body in fixed if isinstance(body, (Profile, Tank))]
    grounds = _beds(open_ones, x)
    solids = sorted(pair for body in fixed if isinstance(body, Obstacle) for pair in _spans(body, x))
    if not len(grounds) and not solids:
        return None
    bed = float(grounds.max()) if len(grounds) else solids[0][1]
    for low, high in solids:
        if low <= bed + ON * max(abs(bed), high - low):
            bed = max(bed, high)
    return bed


def _spans(body: Obstacle, x: float) -> list[tuple[float, float]]:
    """Return the lower and upper ends [m] of the parts of a solid at x."""
    a, b = solid_of(body).elements.swapaxes(0, 1)
    heights = np.sort(crossings(a, b, np.array([x]))[1]).tolist()
    return list(zip(heights[::2], heights[1::2]))


def _beds(fixed: Sequence[Wall], x: float) -> Floats:
    """Return the heights (n,) [m] of walls at x with fluid above them."""
    a, b = np.concatenate([np.empty((0, 2, 2)), *(solid_of(body).elements for body in fixed)]).swapaxes(0, 1)
    up = (a[:, 0] < b[:, 0]) & (a[:, 0] <= x) & (x <= b[:, 0])
    a, along = a[up], (b - a)[up]
    found: Floats = a[:, 1] + (x - a[:, 0]) / along[:, 0] * along[:, 1]
    return found
