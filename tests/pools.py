"""Blocks and tanks of particles for the tests of kernels, in 2D and in 3D."""

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pytest

from parisph.base.fields import ABSENT, FLUID, INNER, SURFACE, WALL
from parisph.case.lattice import Lattice
from parisph.geometry.mesh import WallMesh, block_mesh
from parisph.kernels import density, records
from parisph.kernels.cells import neighbour_lists
from parisph.kernels.elements import plane_numbers, shapes_of
from parisph.kernels.jit import axes_of
from parisph.kernels.moments import second_moment
from parisph.kernels.records import cloud_of, no_walls
from parisph.kernels.sight import is_open, near_lists, seen_elements
from parisph.patch import arrangement

dims = pytest.mark.parametrize("dim", [2, 3])


@dataclass
class Pool:
    """Particles with their neighbour lists; every field is an (n, ...) array as kernels take it.

    index : (n, dim) lattice index of each particle; spacing : s [m]; top : (dim,) far lattice index
    mesh : of the walls, or None
    """

    x: np.ndarray
    kind: np.ndarray
    corner: np.ndarray
    normal: np.ndarray
    role: np.ndarray
    index: np.ndarray
    top: np.ndarray
    spacing: float
    reach: float = 2.6
    mesh: WallMesh | None = None

    def __post_init__(self):
        self.relist()

    def relist(self):
        """Rebuild the neighbour lists and those of elements, after x was changed."""
        self.indptr, self.indices = neighbour_lists(self.x, len(self.x), self.reach * self.spacing)
        corners = np.empty((0, self.dim, self.dim)) if self.mesh is None else self.mesh.corners()
        walls = elements_near(self.x, corners, self.reach * self.spacing, self.spacing, self.normal)
        self._elements = walls._replace(velocity=np.zeros((len(corners), self.dim)))
        place = {tuple(at): k for k, at in enumerate(np.round(self.x / self.spacing, 6)) if self.kind[k] != FLUID}
        at = np.round(corners.reshape(-1, self.dim) / self.spacing, 6)
        self.nodes = np.array([place.get(tuple(one), -1) for one in at], int).reshape(len(corners), self.dim)

    @property
    def n(self):
        return len(self.x)

    @property
    def dim(self):
        return self.x.shape[1]

    @property
    def axes(self):
        return axes_of(self.dim)

    @property
    def fluid(self):
        return self.kind == FLUID

    @property
    def cloud(self):
        """The record that kernels take."""
        return records.cloud_of(self.x, self.kind, self.role, self.normal, self.indptr, self.indices,
                                self.spacing)._replace(corner=self.corner)

    @property
    def walls(self):
        """The elements of a tank, but those at whose corners is no wall particle."""
        there = (self.nodes >= 0) & (self.kind[self.nodes] == WALL)
        return self._elements._replace(present=there.any(axis=1).astype(float))

    def walls_with(self, u, no_slip):
        """Return the elements with the velocity and the slip of their particles, u (n, dim) and no_slip (n,)."""
        if not len(self.nodes):
            return self.walls
        sticks = (no_slip[self.nodes] == 1).all(axis=1)
        return self.walls._replace(velocity=u[self.nodes].mean(axis=1), sticks=sticks)

    @property
    def csr(self):
        return self.indptr, self.indices, self.axes

    @property
    def _completion(self):
        """What completed sums need beside the records: weights, areas and the table."""
        weight, area = np.ones(self.n), np.zeros((self.n, self.dim))
        if self.mesh is not None:
            scale = self.spacing ** (self.dim - 1)
            here, node = np.nonzero(self.kind == WALL)[0], {}
            for elements, numbers in zip(self.mesh.elements, self.nodes):
                node.update(zip(numbers.tolist(), elements.tolist()))
            at = [node[k] for k in here.tolist()]
            weight[here], area[here] = (self.mesh.area * self.mesh.share)[at] / scale, self.mesh.vector_area[at] / scale
        weight[self.kind == ABSENT], area[self.kind == ABSENT] = 0.0, 0.0
        return weight, area, density.table(self.spacing, 1.3 * self.spacing, self.dim)

    def ratio(self):
        """Return the density ratio with h = 1.3 s, (n,)."""
        return self.completed()[0]

    def concentration(self):
        """Return its gradient (n, dim) [1/m]."""
        return self.completed()[1]

    def completed(self):
        """Return both."""
        ratio, gradient = np.full(self.n, np.nan), np.full((self.n, self.dim), np.nan)
        density.completed_density(ratio, gradient, self.cloud, self.walls, *self._completion)
        return ratio, gradient

    def quality(self, radius, power):
        """Return det/(trace/dim)^dim of the moment of each particle's neighbours, as least squares weigh them: (n,)."""
        m, found = np.empty((self.dim, self.dim)), np.empty(self.n)
        for i in range(self.n):
            second_moment(m, i, self.cloud, radius**2, power)
            found[i] = np.linalg.det(m) / max(np.trace(m) / self.dim, 1e-300) ** self.dim
        return found

    def far_inside(self, layers):
        """Return which particles are at least so many lattice layers away from the rim of the lattice, (n,) bool."""
        return np.all((self.index >= layers) & (self.index <= self.top - layers), axis=1)

    def at(self, *index):
        """Return the number of the particle with this lattice index."""
        found = np.flatnonzero((self.index == index).all(axis=1))
        assert found.size == 1, f"{found.size} particles at {index}"
        return int(found[0])


def block(dim, side, jitter=0.0, spacing=0.1, reach=2.6, seed=0):
    """Return a square or cube of side^dim inner fluid particles without walls."""
    return free(np.stack(np.meshgrid(*[np.arange(side)] * dim, indexing="ij"), axis=-1).reshape(-1, dim),
                jitter, spacing, reach, seed)


def free(index, jitter=0.0, spacing=0.1, reach=2.6, seed=0):
    """Return inner fluid particles at lattice indices (n, dim), no walls, each moved by jitter s (Rn - 1/2)."""
    index = np.asarray(index)
    n, dim = index.shape
    x = spacing * (index + jitter * (np.random.default_rng(seed).random((n, dim)) - 0.5))
    none = np.zeros(n, np.int8)
    return Pool(x, none + np.int8(FLUID), none.copy(), np.zeros((n, dim)), none + np.int8(INNER), index,
                index.max(axis=0), spacing, reach)


def tank(cells, lid=False, jitter=0.0, spacing=0.1, reach=2.6, seed=0):
    """Return an open tank of fluid, or a full closed one.

    Walls lie on lattice planes, fluid one spacing inside. Without a lid the last axis ends at the
    free surface, which lies on the lattice plane `cells[-1]` and is not jittered.
    """
    a = arrangement.tank(cells, jitter, seed, lid, spacing)
    return Pool(a.x, a.kind, a.corner, a.normal, a.role, a.index, a.cells, spacing, reach, mesh_of(cells, lid, spacing))


def mesh_of(cells, lid=True, spacing=0.1):
    """Return the mesh of a tank of so many spacings, in any dimension."""
    size = spacing * np.array(cells, float)
    shape = SimpleNamespace(bounds=(np.zeros(len(cells)), size), size=size, closed=lid)
    return block_mesh(Lattice(shape, shape, spacing))


def elements_near(x, corners, radius, spacing, normal=None):
    """Return the Walls of elements (M, dim, dim) with those within the radius [m] that points x (n, dim) see."""
    shapes = shapes_of(corners, plane_numbers(corners, np.zeros(len(corners), np.int64), spacing))
    indptr, indices = near_lists(x, shapes, radius)
    walls = no_walls(0, x.shape[1])._replace(corners=corners, velocity=np.zeros((len(corners), x.shape[1])),
                                             present=np.ones(len(corners)), sticks=np.zeros(len(corners), bool),
                                             indptr=indptr, indices=indices, shapes=shapes)
    kind = np.full(len(x), FLUID, np.int8)
    normal = np.zeros_like(x) if normal is None else normal
    none = np.zeros(len(x) + 1, np.int32), np.zeros(0, np.int32)
    cloud = cloud_of(x, kind, kind, normal, *none, spacing)
    return seen_elements(cloud, walls, radius, is_open(cloud, walls))


class Rows:
    """Buffers for the kernels that fill matrix rows, and what the filled rows do to a field."""

    def __init__(self, pool):
        nnz = len(pool.indices)
        self.pool = pool
        self.matrix = records.Rows(np.zeros(pool.n, np.int32), np.full(nnz, -1, np.int32), np.full(nnz, np.nan),
                                   np.full(pool.n, np.nan))
        self.count, self.columns, self.values, self.measure = self.matrix
        self.flux = records.DivergenceRows(self.count, self.columns, np.full((nnz, pool.dim), np.nan),
                                           np.full(pool.n, np.nan))
        self.div = self.flux.div

    def entries(self, i):
        """Return columns and values of row i."""
        own = slice(self.pool.indptr[i], self.pool.indptr[i] + self.count[i])
        return self.columns[own], self.values[own]

    def applied(self, p):
        """Return row_I(p) = p_I - sum_J values_J p_J for every row, (n,)."""
        out = np.array(p, float)
        for i in range(self.pool.n):
            columns, values = self.entries(i)
            out[i] -= values @ p[columns]
        return out

    def sums(self):
        """Return the sum of the values of every row, (n,)."""
        return np.array([self.entries(i)[1].sum() for i in range(self.pool.n)])


def nowhere(out):
    """Return what a gradient `out` (n, dim) that is known nowhere needs."""
    return np.zeros(len(out), bool)


def monomials(x, degree):
    """Return all monomials of exactly this degree (1 or 2) with their gradients and Laplacians.

    List of (f (n,), gradient (n, dim), Laplacian float).
    """
    dim = x.shape[1]
    unit = np.eye(dim)
    if degree == 1:
        return [(x[:, a], np.tile(unit[a], (len(x), 1)), 0.0) for a in range(dim)]
    return [(x[:, a] * x[:, b], x[:, [a]] * unit[b] + x[:, [b]] * unit[a], 2.0 * (a == b))
            for a in range(dim) for b in range(a + 1)]


def harmonic_quadratics(x):
    """Return harmonic quadratics that span them all, with gradients: list of (f (n,), gradient (n, dim))."""
    dim, unit = x.shape[1], np.eye(x.shape[1])
    found = [(x[:, a] ** 2 - x[:, a + 1] ** 2, 2.0 * x[:, [a]] * unit[a] - 2.0 * x[:, [a + 1]] * unit[a + 1])
             for a in range(dim - 1)]
    return found + [(f, grad) for f, grad, laplacian in monomials(x, 2) if laplacian == 0.0]


def harmonic_cubics(x, many=8, seed=0):
    """Return harmonic polynomials of degree 3, with all lower degrees: list of (f (n,), gradient, second derivatives).

    Real parts of (p . x + i q . x + c)^3 with random orthogonal unit vectors p and q: eight of them span those of
    degree 3.
    """
    dim, random = x.shape[1], np.random.default_rng(seed)
    found = []
    for _ in range(many):
        p, q = np.linalg.qr(random.normal(size=(dim, dim)))[0][:2]
        along = p + 1j * q
        z = x @ along + complex(*random.normal(size=2))
        found.append(((z**3).real, (3.0 * z[:, None] ** 2 * along).real,
                      (6.0 * z[:, None, None] * np.outer(along, along)).real))
    return found


def filled(cells, depth, width=None, jitter=0.0):
    """Return an open tank with fluid up to the layer `depth`, and up to the column `width` along x only."""
    pool = tank(cells, jitter=jitter)
    index = pool.index
    keep = (pool.kind == WALL) | (index[:, -1] <= depth)
    if width is not None:
        keep &= (pool.kind == WALL) | (index[:, 0] <= width)
    pool.role[pool.fluid] = INNER
    top = pool.fluid & (index[:, -1] == depth)
    if width is not None:
        top |= pool.fluid & (index[:, 0] == width)
    pool.role[top] = SURFACE
    return part(pool, keep)


def part(pool, keep):
    """Return the Pool of the particles that are kept, (n,) bool."""
    fields = (getattr(pool, name)[keep] for name in ("x", "kind", "corner", "normal", "role", "index"))
    return Pool(*fields, pool.top, pool.spacing, pool.reach, pool.mesh)
