"""What a step asks of that which moves a body."""

from typing import NamedTuple, Protocol

from parisph.base.arrays import Floats, Ints
from parisph.geometry.mesh import WallMesh


class MovedNodes(NamedTuple):
    """Nodes of a body in a step, (n, dim) each.

    x [m], normal, vector_area [m^(dim-1)] : at a time in the step
    u [m/s], turn [1/s] : velocity, and the rate at which the normal turns, at its start
    mean [m/s], a [m/s2] : velocity between the places at its start and end, and what changes u to that at its end; u
        and the acceleration at that instant if the step has no length
    """

    x: Floats
    normal: Floats
    vector_area: Floats
    u: Floats
    turn: Floats
    mean: Floats
    a: Floats


class Mover(Protocol):
    """How a body moves: by a law of time (methods.rigid_bodies.Prescribed), or by an object of one's own.

    Every rank asks its own copy, and all must give the same. Nothing here is collective.
    """

    def moved(self, mesh: WallMesh, own: Ints, at: float, start: float, stop: float) -> MovedNodes:
        """Return the nodes `own` (n,) of the mesh at a time [s], in a step from start to stop [s]."""

    def longest_step(self, x0: Floats, time: float, room: float) -> float:
        """Return the longest step [s] after a time [s] in which no node x0 (n, dim) moves by more than `room` [m].

        x0 : places [m] as in the mesh, in the frame of the body
        """
