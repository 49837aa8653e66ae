"""Scenes of any walls as arrays that kernels take: fluid first, then wall nodes."""

from dataclasses import dataclass

import numpy as np

from parisph.base.fields import FLUID, INNER, SURFACE, WALL, WET
from parisph.case.bodies import StillWater
from parisph.geometry.fill import Filling
from parisph.geometry.mesh import WallMesh, wall_mesh
from parisph.kernels import density, packing, sight
from parisph.kernels.cells import neighbour_lists
from parisph.kernels.jit import axes_of
from parisph.kernels.records import cloud_of
from tests.pools import elements_near


@dataclass
class Scene:
    """Particles of a scene, serial. n : number of fluid particles; spacing : [m]; level : of the water [m], or None"""

    x: np.ndarray
    n: int
    role: np.ndarray
    normal: np.ndarray
    mesh: WallMesh
    spacing: float
    level: float | None = None
    reach: float = 2.6

    def __post_init__(self):
        s, dim, nodes = self.spacing, self.dim, len(self.x) - self.n
        self.kind = np.repeat(np.array([FLUID, WALL], np.int8), [self.n, nodes])
        self.weight = np.concatenate([np.ones(self.n), self.mesh.area * self.mesh.share / s ** (dim - 1)])
        self.area = np.concatenate([np.zeros((self.n, dim)), self.mesh.vector_area / s ** (dim - 1)])
        self.corners = self.mesh.corners()
        self.present = np.ones(len(self.corners), bool)
        if self.level is not None:    # walls above the water do not count
            self.present = self.corners.mean(axis=1)[:, -1] < self.level
            dry = (self.kind == WALL) & (self.x[:, -1] > self.level + 1.01 * s)
            self.weight[dry], self.area[dry] = 0.0, 0.0
        self.table = density.table(s, 1.3 * s, dim)

    @property
    def dim(self):
        return self.x.shape[1]

    @property
    def axes(self):
        return axes_of(self.dim)

    def records(self):
        """Return the Cloud with the neighbours that are visible, and the Walls, of all particles."""
        radius = self.reach * self.spacing
        walls = elements_near(self.x, self.corners, radius, self.spacing, self.normal)
        around = neighbour_lists(self.x, len(self.x), radius)
        cloud = cloud_of(self.x, self.kind, self.role, self.normal, *around, self.spacing)
        indptr, indices = sight.seen_neighbours(cloud, walls)
        return cloud._replace(indptr=indptr, indices=indices), walls._replace(present=self.present.astype(float))

    def lists(self):
        """Return the CSR of visible neighbours."""
        cloud, _ = self.records()
        return cloud.indptr, cloud.indices

    def completed(self):
        """Return the completed density ratio of the fluid (n,), and its gradient (n, dim) [1/m]."""
        ratio, gradient = np.empty(len(self.x)), np.empty(self.x.shape)
        density.completed_density(ratio, gradient, *self.records(), self.weight, self.area, self.table)
        return ratio[:self.n], gradient[:self.n]

    def pack(self, steps=packing.STEPS):
        """Move the inner fluid until it lies evenly."""
        for _ in range(steps):
            move = packing.packing_move(*self.records(), self.weight, self.area, self.table)
            self.x[:len(move)] += move

    def alpha(self):
        """Return the completed density ratio of the fluid (n,)."""
        return self.completed()[0]

    def gradient(self):
        """Return its gradient (n, dim) [1/m]."""
        return self.completed()[1]


def filled(shape, walls, spacing):
    """Return the Scene of a shape or StillWater, or of several, between walls."""
    mesh = wall_mesh(walls, spacing)
    x, roles = [], []
    for one in shape if isinstance(shape, (tuple, list)) else (shape,):
        fill = Filling(one, walls, spacing)
        index = fill.indices()
        x.append(fill.position(index))
        roles.append(np.where(fill.is_surface(index), SURFACE, INNER))
    x = np.concatenate(x)
    role = np.concatenate([*roles, np.full(len(mesh.x0), WET)]).astype(np.int8)
    return Scene(np.concatenate([x, mesh.x0]), len(x), role, np.concatenate([np.zeros(x.shape), mesh.normal0]), mesh,
                 spacing, shape.level if isinstance(shape, StillWater) else None)


def beside(mesh, x, spacing):
    """Return the Scene of inner fluid at x (n, dim) beside the walls of a mesh."""
    role = np.repeat(np.array([INNER, WET], np.int8), [len(x), len(mesh.x0)])
    return Scene(np.concatenate([x, mesh.x0]), len(x), role, np.concatenate([np.zeros(x.shape), mesh.normal0]), mesh,
                 spacing)


def fluid(x, corners, spacing, lists=None):
    """Return the Cloud of fluid at points x, with neighbour lists if any are given, and the Walls near them."""
    x = np.atleast_2d(np.array(x, float))
    kind, lists = np.full(len(x), FLUID, np.int8), lists or (np.zeros(len(x) + 1, np.int32), np.zeros(0, np.int32))
    return cloud_of(x, kind, kind, np.zeros_like(x), *lists, spacing), elements_near(x, corners, 2.6 * spacing, spacing)
