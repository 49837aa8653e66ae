"""The domain: which rank owns which particles, their ghosts, and their neighbours."""

import numpy as np
from mpi4py import MPI

from parisph.base.arrays import Array, Flags, Floats, Ints
from parisph.base.errors import CaseError, ParisphError
from parisph.base.fields import WALL, WET
from parisph.geometry.mesh import no_mesh
from parisph.kernels.cells import far_from, neighbour_lists
from parisph.parallel.halo import ROUNDING, Halo
from parisph.parallel.migrate import migrate
from parisph.parallel.particles import Particles
from parisph.parallel.partition import Grid, Partition, imbalance, split
from parisph.parallel.survey import Survey, survey
from parisph.parallel.wall_elements import WallElements
from parisph.parallel.work import work_of

STRAY = 0.25  # of the grid's side: a particle farther outside requires a new grid
# root mean square move, in skins, after which a single rank sorts again: it has no ghosts, and a preconditioner lasts
# as long as rows keep their numbers
ALONE = 2.0


class Domain:
    """Keeps each particle on the rank that owns it, sorted, with ghosts and neighbour lists.

    Parameters
    ----------
    particles : Particles
    lower, upper : (dim,) corners of the box of the scene [m]
    radius : [m], the lists contain neighbours closer than this
    skin : [m], largest move of a particle before particles are redistributed. One rank sorts only when the root mean
        square of the moves exceeds ALONE skins.
    list_skin : [m], largest move of a particle before the lists are rebuilt
    closed : whether the box is a closed tank: a particle farther outside than `radius` is lost
    tolerated : imbalance (max/mean of the ranks' work) above which the work is divided again
    balance_every : calls of `redistribute` between checks of the imbalance, if particles do not change rank
    elements : WallElements, or None without walls; particles behind a wall are not neighbours

    Attributes
    ----------
    indptr : (n_owned + 1,) int32, indices : (nnz,) int32
        Neighbours of each owned particle among all local ones: those within `radius + 2 list_skin` when the lists were
        made, which include those within `radius` since then.
    global_rows : (n_all,) int32 (int64 beyond 2^31 rows), global row of each local particle
    n_plans, n_lists, n_updates : numbers of redistributions, new lists, and updates of ghost fields so far

    Raises
    ------
    CaseError : a length is out of range. The constructor does not communicate.
    """

    def __init__(self, particles: Particles, lower: Floats, upper: Floats, radius: float, skin: float,
                 list_skin: float = 0.0, closed: bool = False, tolerated: float = 1.03,
                 balance_every: int = 100, elements: WallElements | None = None) -> None:
        self.particles = particles
        self.elements = elements or WallElements(no_mesh(particles.dim), 0, 1.0)
        self.lower, self.upper = np.array(lower, float), np.array(upper, float)
        self.radius, self.skin, self.list_skin, self.closed = radius, skin, list_skin, closed
        self.tolerated, self.balance_every = tolerated, balance_every
        self._validate()
        # Before the next plan two particles may each move by the skin towards the other.
        self.width = radius + 2.0 * skin + 2.0 * list_skin
        self.indptr: Array = np.zeros(1, np.int32)
        self.indices: Array = np.zeros(0, np.int32)
        self._around = self.indptr, self.indices
        self.global_rows: Array = np.zeros(0, np.int32)
        self.n_plans = self.n_lists = self.n_updates = 0
        self._partition: Partition | None = None
        self._halo: Halo | None = None
        self._plan_x: Floats | None = None
        self._list_x: Floats | None = None
        self._calls, self._looked, self._assigned = 0, -balance_every, particles.n_assigned
        self._removed = False

    def _validate(self) -> None:
        shape = (self.particles.dim,)
        if self.lower.shape != shape or self.upper.shape != shape or not (self.lower < self.upper).all():
            raise CaseError(f"the box from {self.lower} to {self.upper} has no inside in {shape[0]} dimensions")
        if not (self.radius > 0.0 and self.skin >= 0.0 and self.list_skin >= 0.0):
            raise CaseError(f"radius {self.radius} must be positive; skins {self.skin}, {self.list_skin} not negative")

    # -- called by a step -----------------------------------------------------------------

    def redistribute(self, force: bool = False) -> bool:
        """Move particles to their owners if one has moved by the skin, if forced, or if work is uneven. Collective.

        If work is uneven, cells change owners. Sorts the owned particles along the Hilbert curve, makes the ghosts, and
        fills their `exchanged` fields. Returns True if row numbers have changed: arrays outside `particles` are then
        stale. Raises ParticleLost on every rank if a position is not finite, or outside a closed tank.
        """
        return self._redistribute(force, self._survey())

    def refresh(self, *also: str) -> bool:
        """Update the ghosts' positions and the neighbour lists to the current positions. Collective.

        also : names of fields that are sent in the same message as the positions

        Redistributes if needed. Returns and raises as `redistribute`.
        """
        found = self._survey()
        renumbered = self._redistribute(False, found)
        if not renumbered:
            self.update("x", *also)
        if renumbered or found.list_drift > self.list_skin:
            self._rebuild_lists()
        self._look_past_walls()
        renumbered, self._removed = renumbered or self._removed, False
        return renumbered

    def remove(self, which: Flags) -> None:
        """Remove owned particles from the scene, and renew order, ghosts and lists. Collective.

        which : (n_owned,) bool. The next `refresh` returns that row numbers have changed.
        Raises as `redistribute`.
        """
        p = self.particles
        p.reorder(np.flatnonzero(~which))
        p.renumber()
        self._plan_x = self._list_x = None
        self.refresh()
        self._removed = True

    def update(self, *names: str) -> None:
        """Copy the named fields from the owners to the ghosts, in one message. Collective.

        Raises ParisphError if there is no such field.
        """
        unknown = [name for name in names if name not in self.particles.fields]
        if unknown:
            raise ParisphError("no such particle field: "
                               f"{', '.join(unknown)} (this scene has {', '.join(self.particles.fields)})")
        if names:
            self.n_updates += 1    # also on one rank: the messages that several ranks would send
        if self._halo is not None and names:
            self._halo.update(*names)

    @property
    def work(self) -> int:
        """Work of this rank's particles (parallel.work)."""
        return int(self._work().sum())

    @property
    def receivers(self) -> int:
        """Number of ranks that receive ghosts from this one: the messages that it sends in an update."""
        return 0 if self._halo is None else self._halo.receivers

    @property
    def n_sent(self) -> int:
        """Number of ghosts of this rank's particles on other ranks."""
        return 0 if self._halo is None else self._halo.n_sent

    def destroy(self) -> None:
        """Free the MPI and PETSc objects of the halo. Collective."""
        if self._halo is not None:
            self._halo.destroy()
            self._halo = None

    # -- when ------------------------------------------------------------------------------

    def _survey(self) -> Survey:
        if self._assigned != self.particles.n_assigned:  # new particles have no earlier positions
            self._assigned = self.particles.n_assigned
            self._plan_x = self._list_x = None
        grid = (self.lower, self.upper)
        if self._partition is not None:
            grid = (self._partition.grid.origin, self._partition.grid.upper)
        tank = (self.lower - self.radius, self.upper + self.radius) if self.closed else None
        return survey(self.particles, self._plan_x, self._list_x, grid, tank)

    def _redistribute(self, force: bool, found: Survey) -> bool:
        self._calls += 1
        alone = self.particles.comm.size == 1
        moved = found.mean_drift > ALONE * self.skin if alone else found.plan_drift > self.skin
        partition = self._next_partition(found.stray, force or moved)
        if not (force or moved or partition is not self._partition):
            return False
        self._partition = partition
        self._settle(partition)
        return True

    def _next_partition(self, stray: float, moving: bool) -> Partition:
        """Return the partition to use from now on, the same object if it need not change."""
        old = self._partition
        if old is None or stray > STRAY * (old.grid.upper - old.grid.origin).max():
            return self._partition_now()
        if not self._is_uneven(moving):
            return old
        new = self._partition_now(old.grid)
        # Renumbering is expensive: keep the partition if cells are too coarse for a better one.
        return old if np.array_equal(new.splitters, old.splitters) else new

    def _is_uneven(self, moving: bool) -> bool:
        """Return whether the work is too uneven.

        Measured only in every `balance_every`-th call and when particles change rank.
        """
        comm = self.particles.comm
        if comm.size == 1 or not (moving or self._calls - self._looked >= self.balance_every):
            return False
        self._looked = self._calls
        loads = np.empty(comm.size, np.int64)
        comm.Allgather(np.array([self.work], np.int64), loads)
        return imbalance(loads) > self.tolerated

    def _work(self) -> Ints:
        """Return the work of each owned particle (n_owned,) int64, equal for all without lists."""
        p = self.particles
        if self._list_x is None:
            return np.ones(p.n_owned, np.int64)
        return work_of(p.role, np.diff(self.indptr))

    # -- how -------------------------------------------------------------------------------

    def _partition_now(self, grid: Grid | None = None) -> Partition:
        """Make a partition of equal work for the current positions."""
        p = self.particles
        grid = grid or Grid.covering(*self._bounds(), width=self.width * ROUNDING)
        if p.comm.size == 1:
            return Partition(grid, np.array([0, grid.end]))
        return Partition(grid, split(p.comm, grid.cells(grid.keys(p.x)), self._work(), grid.end))

    def _bounds(self) -> tuple[Floats, Floats]:
        """Return the corners of the box around the scene and all particles."""
        p = self.particles
        both = np.concatenate([-self.lower, self.upper])
        if p.n_owned:
            both = np.maximum(both, np.concatenate([-p.x.min(axis=0), p.x.max(axis=0)]))
        if p.comm.size > 1:
            p.comm.Allreduce(MPI.IN_PLACE, both, op=MPI.MAX)
        return -both[:p.dim], both[p.dim:]

    def _settle(self, partition: Partition) -> None:
        """Move particles to their owners, sort them, and make ghosts."""
        p, grid = self.particles, partition.grid
        self.destroy()
        p.resize(p.n_owned, 0)
        keys = grid.keys(p.x)
        if p.comm.size > 1:
            owners = partition.owners(grid.cells(keys))
            arrived = migrate(p, owners)
            keys = np.concatenate([keys[owners == p.comm.rank], grid.keys(p.x[p.n_owned - arrived:])])
        order = np.argsort(keys, kind="stable")
        p.reorder(order)
        rows = np.arange(p.offset, p.offset + p.n_owned)
        if p.comm.size > 1:
            self._halo = Halo(p, partition, grid.cells(keys[order]), self.width)
            rows = np.concatenate([rows, self._halo.rows])
        self.global_rows = rows.astype(np.int32 if p.n_global < 2**31 else np.int64)
        self.elements.settle(p, self.width)
        self._plan_x, self._list_x = p.x.copy(), None
        self.n_plans += 1

    def _rebuild_lists(self) -> None:
        p, radius = self.particles, self.radius + 2.0 * self.list_skin
        apart = self._far_from_water(radius)
        self.indptr, self.indices = self._around = neighbour_lists(p.x_all, p.n_owned, radius, apart)
        self.elements.renew(p, radius, apart[:p.n_owned])
        self._list_x = p.x.copy()
        self.n_lists += 1

    def _far_from_water(self, radius: float) -> Flags:
        """Return which particles (n_all,) bool are nodes of walls in no list of fluid, nor of a node in such a list.

        Their lists would hold nothing that a kernel reads. Wet nodes count as fluid, which may be on another rank.
        radius : of the lists [m]
        """
        p = self.particles
        apart: Flags = (p.kind_all == WALL) & (p.role_all != WET)
        if apart.any():
            apart[apart] = far_from(p.x_all[apart], p.x_all[~apart], 2.0 * radius)
        return apart

    def _look_past_walls(self) -> None:
        """Remove neighbours behind walls from the lists, by the current positions.

        The result must not depend on the age of the lists, which differs between numbers of ranks and after a restart.
        """
        self.indptr, self.indices = self.elements.look(self.particles, self.radius, *self._around)
