"""The walls of a scene as elements on one rank: their current positions, and those that each particle sees."""

from collections.abc import Sequence

import numpy as np

from parisph.base.arrays import Array, Flags, Floats, Ints
from parisph.base.errors import CaseError
from parisph.base.fields import DRY, WALL
from parisph.geometry.distance import nearest
from parisph.geometry.mesh import WallMesh
from parisph.geometry.movers import Mover
from parisph.kernels import sight, wetness
from parisph.kernels.elements import plane_numbers, shapes_of
from parisph.kernels.jit import axes_of
from parisph.kernels.records import Cloud, no_walls
from parisph.parallel.particles import Particles

MARGIN = 0.5     # spacings that a particle may move before elements near it are looked for again, if walls rest
NO_ROOM = 0.4    # spacings in front of a wall that moves: nodes of others there are dry, as no particle fits between


class WallElements:
    """The elements near the particles of this rank. Nothing here is collective.

    Every rank has the whole mesh of the walls, which are rigid, so it needs no messages to move them.

    Parameters
    ----------
    mesh : WallMesh
    first : particle id of the first node of the mesh; the others follow in order
    spacing : [m]
    movers : of the bodies, by the number of their motion; number 0 is rest

    Attributes
    ----------
    x, normal, u, a, turn : (N, dim), of all nodes: position [m], normal, velocity [m/s], acceleration [m/s^2], rotation
    rate [1/s]
    moves : (N,) bool, nodes of moving walls
    walls : the elements near this rank's particles (kernels.records.Walls), with the lists of those that each owned
        particle sees; velocity, acceleration : (M, dim), of these elements; motion : (M,) int, number of their motion
    nodes : (M, dim) int32, the local particles at their corners, -1 for particles not on this rank
    """

    def __init__(self, mesh: WallMesh, first: int, spacing: float, movers: Sequence[Mover] = ()) -> None:
        self.mesh, self.first, self.spacing, self._ends = mesh, first, spacing, mesh.ends
        self.x, self.normal, self._vectors = mesh.x0.copy(), mesh.normal0.copy(), mesh.vector_area.copy()
        self.u, self.a, self.turn = np.zeros_like(mesh.x0), np.zeros_like(mesh.x0), np.zeros_like(mesh.x0)
        self.node_motion = np.array([body.motion for body in mesh.bodies], np.int64)[mesh.body]
        self.moves = self.node_motion > 0
        self._moving = {number: (movers[number], np.flatnonzero(self.node_motion == number))
                        for number in np.unique(self.node_motion[self.moves])}
        self._planes = plane_numbers(mesh.corners(), self.node_motion[mesh.elements[:, 0]], spacing)
        self._near = np.zeros(0, np.int64)
        self.nodes, self.walls = np.zeros((0, mesh.dim), np.int32), no_walls(0, mesh.dim)
        self._candidates, self._reach = sight.no_lists(0), 0.0
        self._searched: Floats | None = None    # places of particles at the last search
        self._apart: Flags = np.zeros(0, np.bool_)
        # elements that nodes see, if walls rest, and which nodes have been looked at
        self._seen, self._looked = sight.no_lists(0), np.zeros(0, np.bool_)
        self._mean = self.u
        self._place()

    @property
    def edges(self) -> Array:
        """Kinds of edges (geometry.mesh) at the corners of the elements near this rank's particles, (M, dim) int8."""
        edges: Array = self.mesh.edge[self.mesh.elements[self._near]]
        return edges

    def before_moving(self, particles: Particles) -> Floats:
        """Return the distance (n_owned,) [m] of wall particles from walls with another motion, 0 behind these."""
        p = particles
        found, own = np.full(p.n_owned, np.inf), np.full(p.n_owned, self.motion.max(initial=0))    # none for fluid
        walls = p.kind == WALL
        own[walls] = self.node_motion[p.id[walls] - self.first]
        wetness.before_moving_walls(found, p.x, own, self.walls, self.motion, axes_of(p.dim))
        return found

    def without_room(self, particles: Particles) -> Flags:
        """Return which wall particles (n_owned,) bool are dry because fluid has no room in front of them.

        These are nodes close to a moving wall or behind it, and ends of lines of elements, like the foot of a
        wavemaker. They have no pressure, but that of the water beside them extends to them.
        """
        p = particles
        found = np.zeros(p.n_owned, bool)
        walls = np.flatnonzero((p.role == DRY) & (p.kind == WALL))
        node = p.id[walls] - self.first
        left_out = self.before_moving(p)[walls] < NO_ROOM * self.spacing if self.moving else False
        found[walls] = self._ends[node] | left_out
        return found

    @property
    def moving(self) -> bool:
        """Whether any wall moves."""
        return bool(self._moving)

    def let_move(self, name: str, mover: Mover) -> None:
        """Let a mover replace the motion of a body, and of bodies with the same motion, from the next step on.

        The extent of the scene, the rims over which water leaves a tank or a wavemaker, probes other than Force, and
        pictures still use the motion in the case: a tank or a wavemaker must stay near it. Checkpoints have no movers:
        call it again after a restart. Call it on all ranks. Raises CaseError on all of them if no body of this name
        moves.
        """
        moving = {body.name: body.motion for body in self.mesh.bodies if body.motion}
        if name not in moving:
            raise CaseError(f"let_move: no body {name!r} moves (those that do: {', '.join(moving) or 'none'}); give it "
                            "a motion in the case, which sets its range")
        self._moving[moving[name]] = mover, self._moving[moving[name]][1]

    # -- positions -------------------------------------------------------------------------

    def place(self, at: float, start: float, stop: float) -> None:
        """Move walls to their positions at time `at` [s], in a step from start to stop [s], possibly of length 0.

        Nodes have the velocity at the start, elements the mean of the step. The acceleration is the mean of the step.
        """
        mean = self.u.copy()
        for mover, own in self._moving.values():
            (self.x[own], self.normal[own], self._vectors[own], self.u[own], self.turn[own], mean[own],
             self.a[own]) = mover.moved(self.mesh, own, at, start, stop)
        self._mean = mean
        self._place()

    def put(self, particles: Particles) -> None:
        """Write position, normal and area of wall particles of this rank, with ghosts, and velocity of owned ones."""
        p = particles
        here, node = self._here(p.kind_all, p.id_all)
        p.x_all[here], p.normal_all[here] = self.x[node], self.normal[node]
        p.area_all[here] = self._vectors[node] / self.spacing ** (p.dim - 1)
        here, node = self._here(p.kind, p.id)
        p.wall_u[here] = self.u[node]

    def of_particles(self, values: Floats, particles: Particles) -> Floats:
        """Return the values (N, dim) of nodes at owned particles (n_owned, dim), 0 except at nodes of moving walls."""
        found = np.zeros_like(particles.x)
        here, node = self._here(particles.kind, particles.id)
        found[here] = values[node]
        return found

    def of_walls(self, particles: Particles) -> tuple[Ints, Floats, Floats, Floats]:
        """Return the particles (m,) that are nodes of moving walls, with ghosts, and their a, turn and u (m, dim)."""
        here, node = self._here(particles.kind_all, particles.id_all)
        return here, self.a[node], self.turn[node], self.u[node]

    def _here(self, kind: Array, number: Ints) -> tuple[Ints, Ints]:
        """Return the particles (m,) that are nodes of moving walls, and their nodes (m,)."""
        here = np.flatnonzero(kind == WALL)
        node = number[here] - self.first
        return here[self.moves[node]], node[self.moves[node]]

    def longest_step(self, time: float, cfl: float) -> float:
        """Return the longest step [s] after a time [s] in which walls move by at most cfl spacings."""
        return min((mover.longest_step(self.mesh.x0[own], time, cfl * self.spacing)
                    for mover, own in self._moving.values()), default=np.inf)

    # -- near elements ---------------------------------------------------------------------

    def settle(self, particles: Particles, width: float) -> None:
        """Choose the elements within the width [m] of owned particles, after these have changed ranks or order."""
        p, corners, self._searched = particles, self.mesh.corners(self.x), None
        self._seen, self._looked = sight.no_lists(p.n_owned), np.zeros(p.n_owned, np.bool_)
        self._near = np.zeros(0, np.int64)
        if p.n_owned:
            lower, upper = p.x.min(axis=0) - width, p.x.max(axis=0) + width
            near = (corners.min(axis=1) <= upper).all(axis=1) & (corners.max(axis=1) >= lower).all(axis=1)
            self._near = np.flatnonzero(near)
        local = np.full(len(self.x), -1, np.int32)
        walls = np.flatnonzero((p.kind_all == WALL) & (len(self.x) > 0))    # without elements there is no mesh
        local[p.id_all[walls] - self.first] = walls
        self.nodes = local[self.mesh.elements[self._near]]
        self._place()

    def _place(self) -> None:
        elements = self.mesh.elements[self._near]
        self.velocity, self.acceleration = self._mean[elements].mean(axis=1), self.a[elements].mean(axis=1)
        self.motion = self.node_motion[elements[:, 0]]
        n, corners = len(elements), np.ascontiguousarray(self.x[elements])
        self.walls = self.walls._replace(corners=corners, velocity=self.velocity, present=np.ones(n),
                                         sticks=np.zeros(n, np.bool_),
                                         shapes=shapes_of(corners, self._planes[self._near]))

    def name_near(self, x: Floats) -> str:
        """Return the name of the body of the chosen element nearest to x (dim,) [m]."""
        element = int(nearest(x[None], self.walls.corners)[1][0])
        return str(self.mesh.bodies[self.mesh.element_body[self._near[element]]].name)

    def renew(self, particles: Particles, radius: float, apart: Flags | None = None) -> None:
        """Find the elements that may come within the radius [m] of owned particles until the next call.

        If walls rest, only for fluid that has moved by more than the margin since they were last looked for.

        apart : (n_owned,) bool, nodes that need no lists; default none
        """
        p, known, margin, n = particles, self._searched, MARGIN * self.spacing, particles.n_owned
        self._apart, self._reach = np.zeros(n, np.bool_) if apart is None else apart, radius + margin
        if self.moving or known is None:
            which = np.flatnonzero(~self._apart if self.moving else p.kind != WALL)
            self._candidates = sight.no_lists(n)
            self._searched = known = p.x.copy()
        else:
            which = np.flatnonzero((np.abs(p.x - known).max(axis=1) > margin / self.mesh.dim) & (p.kind != WALL))
        if len(which):
            self._candidates = self._near_ones(self._candidates, p.x, which)
            known[which] = p.x[which]

    def _near_ones(self, lists: sight.Lists, x: Floats, which: Ints) -> sight.Lists:
        """Return lists with those of some particles (m,) at x (n_owned, dim) [m] replaced by the elements near them."""
        found = sight.near_lists(x[which], self.walls.shapes, self._reach)
        replaced: sight.Lists = sight.replaced(*lists, which, *found)
        return replaced

    def look(self, particles: Particles, radius: float, indptr: Array, indices: Array) -> tuple[Array, Array]:
        """Update the lists of elements within a radius [m]; return neighbour lists without particles behind walls.

        Nodes of walls at rest need lists, and get them, only where something is hidden.
        """
        cloud, n = particles.cloud(indptr, indices, self.spacing), particles.n_owned
        free = bool(sight.is_open(cloud, self.walls))
        if not (self.moving or free):
            self._look_from_nodes(particles, cloud, radius)
        known = None if self.moving else sight.no_lists(n) if free else self._seen
        near, others = self._candidates
        self.walls = sight.seen_elements(cloud, self.walls._replace(indptr=near, indices=others), radius, free, known)
        return (indptr, indices) if free else sight.seen_neighbours(cloud, self.walls)

    def _look_from_nodes(self, particles: Particles, cloud: Cloud, radius: float) -> None:
        """Find what nodes at rest see that need lists for the first time since particles were sorted."""
        p = particles
        which = np.flatnonzero((p.kind == WALL) & ~self._apart & ~self._looked)
        if len(which):
            near, others = self._near_ones(sight.no_lists(p.n_owned), p.x, which)
            walls = sight.seen_elements(cloud, self.walls._replace(indptr=near, indices=others), radius, False)
            starts = np.append(walls.indptr[which], walls.indptr[-1])    # lists of others are empty
            self._seen = sight.replaced(*self._seen, which, starts, walls.indices)
            self._looked[which] = True

    def mean_of_nodes(self, values: Floats) -> Floats:
        """Return the mean over the corners of each element (M,) of values (n_all,) of particles.

        Corners without a particle on this rank do not count: their elements are far from owned particles.
        """
        mean = np.empty(len(self.nodes))
        wetness.mean_of_nodes(mean, self.nodes, values)
        return mean
