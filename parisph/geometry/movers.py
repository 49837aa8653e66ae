"""The interface between a step and the motion of a body."""

from typing import NamedTuple, Protocol

from parisph.base.arrays import Floats, Ints
from parisph.geometry.mesh import WallMesh


class MovedNodes(NamedTuple):
    """Nodes of a body in a step, (n, dim) each.

    x [m], normal, vector_area [m^(dim-1)] : at a time in the step
    u [m/s], turn [1/s] : velocity, and rotation rate of the normal, at the start of the step
    mean [m/s] : mean velocity over the step; a [m/s2] : acceleration that turns u into the velocity at its end. In a
        step of length 0, u and the acceleration at that time
    """

    x: Floats
    normal: Floats
    vector_area: Floats
    u: Floats
    turn: Floats
    mean: Floats
    a: Floats


class Mover(Protocol):
    """How a body moves: by a law of time (methods.rigid_bodies.Prescribed), or by a user's object.

    Each rank asks its own copy, and all copies must agree. Nothing here is collective.
    """

    def moved(self, mesh: WallMesh, own: Ints, at: float, start: float, stop: float) -> MovedNodes:
        """Return the nodes `own` (n,) of the mesh at time `at` [s], in a step from start to stop [s].

        mesh.x0[own], mesh.normal0[own] and mesh.vector_area[own] are those at t = 0
        """

    def longest_step(self, x0: Floats, time: float, room: float) -> float:
        """Return the longest step [s] after a time [s] in which no node x0 (n, dim) moves by more than `room` [m].

        x0 : positions [m] in the mesh, at t = 0
        """
