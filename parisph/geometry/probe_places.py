"""Checks of the places of probes between walls of any shape.

In 3D a place lies in the section of its y, or in those of both sides of a cut.
"""

from collections.abc import Iterator
from functools import cached_property

import numpy as np

from parisph.base.arrays import Floats, Ints
from parisph.case.breadth import section_of
from parisph.case.lattice import FIT
from parisph.case.motion import AtRest
from parisph.case.probes import singles
from parisph.case.scene import Scene
from parisph.case.sections import sections
from parisph.geometry.build import domain, scene_mesh
from parisph.geometry.distance import area_vectors, nearest
from parisph.geometry.mesh import WallMesh, wall_mesh
from parisph.geometry.scene_room import in_room
from parisph.geometry.solid import Wall, in_fluid
from parisph.geometry.spans import plane_walls
from parisph.geometry.standing import standing

# Sides of a tank: the axis across them, and the sign of the normal into the fluid. Front and back are those of 3D.
SIDES = {"left": (0, 1.0), "right": (0, -1.0), "bed": (-1, 1.0), "lid": (-1, -1.0)}
ENDS = {"front": (1, 1.0), "back": (1, -1.0)}
SQUARE = 0.9    # least cosine between the normals of an element and of the side it belongs to
HEIGHTS = 400   # places on a vertical line that are checked for fluid


class Places:
    """Walls, and the space for fluid between them.

    walls : of a 2D case; mesh : of the walls, None without walls; spacing [m]
    """

    def __init__(self, case: Scene, walls: tuple[Wall, ...]) -> None:
        self.case, self.spacing = case, case.numerics.spacing
        self.parts = [(-np.inf, np.inf, walls)] if case.dim == 2 else [
            (low, high, standing(scene)) for low, high, scene in sections(case)]

    @cached_property
    def mesh(self) -> WallMesh | None:
        """The mesh of the walls of the scene."""
        return scene_mesh(self.case)

    def plane(self, y: float | None) -> WallMesh | None:
        """The mesh of the walls in the section: that of a 2D scene, or of a 3D scene at y [m]."""
        if y is None or self.mesh is None:
            return self.mesh
        walls = plane_walls(self.case, y)
        return wall_mesh(walls, self.spacing) if walls else None

    @cached_property
    def bodies(self) -> dict[str, Wall]:
        """The bodies of the scene by name, in the section."""
        return {wall.name: wall for _, _, walls in self.parts for wall in walls}

    def walls_at(self, x: Floats) -> Iterator[tuple[Wall, ...]]:
        """Yield the walls of the section at a place (dim,) [m], or of those on both sides of a cut."""
        y = float(x[1]) if self.case.dim == 3 else 0.0
        slack = FIT * self.spacing
        yield from (walls for low, high, walls in self.parts if low - slack <= y <= high + slack)

    def in_front(self, x: Floats, resting: bool = False) -> bool:
        """Return whether fluid may be at any of the points x (n, dim) [m]; resting : consider only walls at rest"""
        if self.case.dim == 2:
            return _free(self.parts[0][2], x, resting)
        if self.case.surfaces:
            x = x[in_room(self.case, x)]
        return any(_free(walls, section_of(place[None]), resting) for place in x for walls in self.walls_at(place))

    def hidden(self, x: Floats) -> list[str]:
        """Return the names of the bodies that keep fluid from a place (dim,) [m]."""
        if self.case.surfaces and not in_room(self.case, x[None])[0]:
            mesh = scene_mesh(self.case)
            assert mesh is not None
            return [mesh.bodies[mesh.element_body[nearest(x[None], mesh.corners())[1][0]]].name]
        found = [[wall.name for wall in walls if not in_fluid([wall], section_of(x[None]))[0]]
                 for walls in self.walls_at(x)]
        return min(found, key=len, default=["the front or the back of the scene"])

    def has_room(self, x: float, y: float | None = None) -> bool:
        """Return whether there is room for fluid above x [m], in 3D above (x, y)."""
        beside = 0.01 * self.spacing    # x may be on a wall
        across = [] if y is None else [np.full(HEIGHTS, y)]
        return any(self.in_front(np.stack([np.full(HEIGHTS, at), *across, self._heights], axis=1))
                   for at in (x - beside, x + beside))

    @cached_property
    def _heights(self) -> Floats:
        lower, upper = domain(self.case)
        heights: Floats = np.linspace(lower[-1], max(upper[-1], self.case.fluid_bounds[1][-1]), HEIGHTS)
        return heights


def _free(walls: tuple[Wall, ...], x: Floats, resting: bool) -> bool:
    """Return whether fluid may be at any of the points x (n, 2) [m] between walls, or between those at rest."""
    return bool(in_fluid([wall for wall in walls if not resting or isinstance(wall.motion, AtRest)], x).any())


def on_side(mesh: WallMesh, number: int, side: str | None) -> Ints:
    """Return the elements (n, dim) of a body, or of one side of it.

    number : of the body; side : a key of SIDES, in 3D also of ENDS, None for the whole body
    """
    own: Ints = mesh.elements[mesh.element_body == number]
    if side is None:
        return own
    axis, inward = (SIDES if mesh.dim == 2 else SIDES | ENDS)[side]
    normal = area_vectors(mesh.x0[own])
    found: Ints = own[inward * normal[:, axis] > SQUARE * np.linalg.norm(normal, axis=1)]
    return found


def faults(case: Scene, walls: tuple[Wall, ...]) -> Iterator[str]:
    """Yield one line for each misplaced probe of a scene, such as one off the wall or without fluid."""
    places = Places(case, walls)
    for name, probe in singles(case.probes):
        yield from (f"probe {name!r}: {line}" for line in probe.misplaced(places))
