"""Which particles are where, and who is near whom: the particles' domain, spread over ranks."""

import numpy as np

from parisph.base.errors import ParticleLost, agree
from parisph.kernels.cells import neighbour_lists


class Domain:
    """Keeps particles on the rank and in the order they belong, with neighbour lists.

    Parameters
    ----------
    particles : Particles
    lower, upper : (dim,) corners of the box that the scene fills [m]
    radius : float
        Neighbours at a distance below it are in the lists [m].
    skin : float
        How far a particle may move until particles are redistributed [m].
    list_skin : float
        How far a particle may move until the lists are rebuilt [m].
    closed : bool
        Whether the box is a closed tank: a particle farther outside than `radius` is lost.

    Attributes
    ----------
    indptr : (n_owned + 1,) int32, indices : (nnz,) int32
        Neighbours of each owned particle, among all local ones: at least those within
        `radius`, and not all of them (pairs up to `radius + 2 list_skin` are listed).
    global_rows : (n_all,) integer, global row of each local particle
    """

    def __init__(self, particles, lower, upper, radius, skin, list_skin=0.0, closed=False):
        self.particles = particles
        self.lower, self.upper = np.array(lower, float), np.array(upper, float)
        self.radius, self.skin, self.list_skin, self.closed = radius, skin, list_skin, closed
        self.indptr, self.indices, self.global_rows = np.zeros(1, np.int32), np.zeros(0, np.int32), None
        self._plan_x = self._list_x = None

    def redistribute(self, force=False):
        """Put particles where they belong if they have moved by more than the skin. Collective.

        Returns True when row numbers have changed; arrays held outside `particles` are stale then.
        Raises ParticleLost on every rank if a position is not finite, or outside a closed tank.
        """
        p = self.particles
        self._check()
        if not force and self._plan_x is not None and _drift(p.x, self._plan_x) <= self.skin:
            return False
        self._plan_x, self._list_x = p.x.copy(), None
        self.global_rows = np.arange(p.n_owned, dtype=np.int32)
        return True

    def refresh(self):
        """Make ghosts and neighbour lists valid at the positions of now. Collective.

        Returns and raises as `redistribute`.
        """
        p = self.particles
        renumbered = self.redistribute()
        if self._list_x is None or _drift(p.x, self._list_x) > self.list_skin:
            self.indptr, self.indices = neighbour_lists(p.x_all, p.n_owned, self.radius + 2.0 * self.list_skin)
            self._list_x = p.x.copy()
        return renumbered

    def update(self, *names):
        """Bring the named fields of the ghosts up to date with their owners. Collective."""

    def record_load(self, seconds):
        """Add measured work of this rank, for rebalancing [s]. Not collective."""

    def _check(self):
        bad = ~np.isfinite(self.particles.x).all(axis=1)
        error = ParticleLost(f"{bad.sum()} particles have no finite position") if bad.any() else None
        agree(self.particles.comm, error)


def _drift(x, reference):
    return np.sqrt(((x - reference) ** 2).sum(axis=1).max(initial=0.0))
