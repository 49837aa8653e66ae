"""The walls of a scene as elements on one rank: where they are now, and which of them each particle sees."""

import numpy as np

from parisph.base.fields import WALL
from parisph.geometry.mesh import WallMesh
from parisph.kernels import solids
from parisph.parallel.particles import Particles


class WallElements:
    """The elements near the particles of this rank. Nothing here is collective.

    Every rank knows the whole mesh of the walls, which are rigid: it needs no messages to know where they are.

    Parameters
    ----------
    mesh : WallMesh
    first : id of the particle that is the mesh's first node; the others follow in its order
    spacing : [m]

    Attributes
    ----------
    corners : (M, dim, dim) [m], of the elements near this rank's particles; velocity : (M, dim) [m/s]
    nodes : (M, dim) int32, the local particles at their corners, -1 for those of other ranks that are no ghosts here
    indptr, indices : (n_owned + 1,), (nnz,) int32, the elements that each owned particle sees
    """

    def __init__(self, mesh: WallMesh, first: int, spacing: float) -> None:
        self.mesh, self.first, self.spacing = mesh, first, spacing
        self.x, self.u = mesh.x0.copy(), np.zeros_like(mesh.x0)
        self._near = np.zeros(0, np.int64)
        self.nodes = np.zeros((0, mesh.dim), np.int32)
        self.indptr, self.indices = np.zeros(1, np.int32), np.zeros(0, np.int32)
        self._place()

    def settle(self, particles: Particles, width: float) -> None:
        """Choose the elements within the width [m] of owned particles, after these have changed ranks or order."""
        p, corners = particles, self.mesh.corners(self.x)
        if p.n_owned:
            lower, upper = p.x.min(axis=0) - width, p.x.max(axis=0) + width
            near = (corners.min(axis=1) <= upper).all(axis=1) & (corners.max(axis=1) >= lower).all(axis=1)
            self._near = np.flatnonzero(near)
        else:
            self._near = np.zeros(0, np.int64)
        local = np.full(len(self.x), -1, np.int32)
        walls = np.flatnonzero(p.kind_all == WALL)
        local[p.id_all[walls] - self.first] = walls
        self.nodes = local[self.mesh.elements[self._near]]
        self._place()

    def _place(self):
        elements = self.mesh.elements[self._near]
        self.corners = np.ascontiguousarray(self.x[elements])
        self.velocity = self.u[elements].mean(axis=1)

    def renew(self, particles: Particles, radius: float) -> None:
        """Make the lists of the elements within the radius [m] of owned particles."""
        p = particles
        self.indptr, self.indices = solids.element_lists(p.x, self.corners, p.normal, radius, self.spacing)

    def visible(self, particles: Particles, indptr: np.ndarray, indices: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return neighbour lists without what is behind a wall; those given are used up."""
        p = particles
        return solids.visible_lists(p.x_all, p.normal_all, self.corners, self.spacing, self.indptr, self.indices,
                                    indptr, indices)

    def mean_of_nodes(self, values: np.ndarray) -> np.ndarray:
        """Return the mean over the corners of each element (M,) of values (n_all,) of particles.

        Corners at which there is no particle here do not count: their elements are far from all owned particles.
        """
        here = self.nodes >= 0
        total = np.where(here, values[self.nodes], 0.0).sum(axis=1)
        return total / np.maximum(here.sum(axis=1), 1)
