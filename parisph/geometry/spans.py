"""The parts of a 3D scene along its breadth, each with one section, and the layers of nodes and particles in them."""

from collections.abc import Hashable
from dataclasses import dataclass
from itertools import count

import numpy as np

from parisph.base.arrays import Floats, Ints
from parisph.case.bodies import Profile
from parisph.case.scene import Scene
from parisph.case.scenery import body_names
from parisph.case.sections import cuts, section
from parisph.geometry.scene_cache import cached
from parisph.geometry.solid import Wall
from parisph.geometry.standing import standing
from parisph.geometry.tips import Filled


@dataclass(frozen=True)
class Span:
    """A part of a 3D scene between two cuts, lower and upper [m], with its section.

    walls : of the section, as of geometry.standing; body : (n,) int, their numbers in `scene_walls`
    layers : (m,) [m], the planes of nodes across, with both ends
    """

    lower: float
    upper: float
    scene: Scene
    walls: tuple[Wall, ...]
    body: Ints
    layers: Floats


@cached(4)
def spans(case: Scene) -> tuple[Span, ...]:
    """Return the parts of a 3D scene with walls, in order. Cached. Raises CaseError."""
    ends, known, found = cuts(case).tolist(), list(scene_walls(case)), []
    numbers = {_key(wall): number for number, wall in enumerate(known)}
    for low, high in zip(ends, ends[1:]):
        scene = section(case, low, high)
        walls = standing(scene)
        body = np.array([numbers[_key(wall)] for wall in walls], dtype=np.int64)
        found.append(Span(low, high, scene, walls, body, divided(low, high, case.numerics.spacing)))
    return tuple(found)


def divided(low: float, high: float, spacing: float) -> Floats:
    """Return the planes (m,) [m] that divide a part across into round(length / s) layers, with both ends."""
    many = max(round((high - low) / spacing), 1)
    found: Floats = low + np.arange(many + 1) * ((high - low) / many)
    found[-1] = high
    return found


@cached(4)
def scene_walls(case: Scene) -> tuple[Wall, ...]:
    """Return the walls of a case, each once; in 3D as in the first section that has them, in the order of the case.

    Cached. Raises CaseError.
    """
    if case.dim == 2:
        return standing(case)
    ends = cuts(case).tolist()
    every = [wall for low, high in zip(ends, ends[1:]) for wall in standing(section(case, low, high))]
    first = {_key(wall): wall for wall in reversed(every)}
    order, filled = body_names(case.bodies), [wall for wall in first.values() if isinstance(wall, Filled)]
    names = (name for name in map("filled{}".format, count(1)) if name not in order)
    return (*(first[name] for name in order if name in first),
            *(wall.model_copy(update={"name": name}) for wall, name in zip(filled, names)))


def plane_walls(case: Scene, y: float) -> tuple[Wall, ...]:
    """Return the walls of the section of a 3D scene at y [m], at the end of a body with those of both sides."""
    return standing(section(case, y, y))


def container(case: Scene) -> Wall:
    """Return the body of `scene_walls` that gives a 3D scene its breadth."""
    body = case.tank or next(body for body in case.bodies if isinstance(body, Profile) and body.breadth is not None)
    name = body_names(case.bodies)[case.bodies.index(body)]
    return next(wall for wall in scene_walls(case) if wall.name == name)


def _key(wall: Wall) -> Hashable:
    """Return what a wall has in common in all sections: its name, or of a filled tip its shape and motion."""
    return (wall.shape, wall.motion) if isinstance(wall, Filled) else wall.name
