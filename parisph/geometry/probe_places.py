"""Checks of the places of probes between walls of any shape (2D)."""

from collections.abc import Iterator
from functools import cached_property

import numpy as np

from parisph.base.arrays import Floats, Ints
from parisph.case.motion import AtRest
from parisph.case.probes import singles
from parisph.case.scene import Scene
from parisph.geometry.build import domain
from parisph.geometry.distance import area_vectors
from parisph.geometry.mesh import WallMesh, wall_mesh
from parisph.geometry.solid import Wall, in_fluid

# Sides of a tank: the axis across them, and the sign of the normal into the fluid.
SIDES = {"left": (0, 1.0), "right": (0, -1.0), "bed": (1, 1.0), "lid": (1, -1.0)}
SQUARE = 0.9    # least cosine between the normals of an element and of the side it belongs to
HEIGHTS = 400   # places on a vertical line that are checked for fluid


class Places:
    """Walls, and the space for fluid between them.

    walls : of the case; mesh : of the walls, None without walls; spacing [m]
    """

    def __init__(self, case: Scene, walls: tuple[Wall, ...]) -> None:
        self.case, self.walls, self.spacing = case, walls, case.numerics.spacing
        self.mesh = wall_mesh(walls, self.spacing) if walls else None

    def in_front(self, x: Floats, resting: bool = False) -> bool:
        """Return whether fluid may be at any of the points x (n, 2) [m]; resting : consider only walls at rest"""
        return bool(in_fluid([wall for wall in self.walls if not resting or isinstance(wall.motion, AtRest)], x).any())

    def has_room(self, x: float) -> bool:
        """Return whether there is room for fluid above x [m]."""
        beside = 0.01 * self.spacing    # x may be on a wall
        return any(self.in_front(np.stack([np.full(HEIGHTS, at), self._heights], axis=1))
                   for at in (x - beside, x + beside))

    @cached_property
    def _heights(self) -> Floats:
        lower, upper = domain(self.case)
        heights: Floats = np.linspace(lower[1], max(upper[1], self.case.fluid_bounds[1][1]), HEIGHTS)
        return heights


def on_side(mesh: WallMesh, number: int, side: str | None) -> Ints:
    """Return the elements (n, 2) of a body, or of one side of it.

    number : of the body; side : a key of SIDES, None for the whole body
    """
    own: Ints = mesh.elements[mesh.element_body == number]
    if side is None:
        return own
    axis, inward = SIDES[side]
    normal = area_vectors(mesh.x0[own])
    found: Ints = own[inward * normal[:, axis] > SQUARE * np.linalg.norm(normal, axis=1)]
    return found


def faults(case: Scene, walls: tuple[Wall, ...]) -> Iterator[str]:
    """Yield one line for each misplaced probe of a scene, such as one off the wall or without fluid."""
    places = Places(case, walls)
    for name, probe in singles(case.probes):
        yield from (f"probe {name!r}: {line}" for line in probe.misplaced(places))
