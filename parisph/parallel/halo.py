"""Ghosts: copies of other ranks' particles near those of this rank."""

from typing import Any

import numpy as np
from mpi4py import MPI

from parisph.base.arrays import Array, Floats, Ints
from parisph.base.errors import ParisphError
from parisph.base.fields import FIELDS, ORDER
from parisph.kernels.jit import kernel, subkernel
from parisph.parallel.hilbert import key_of, machine
from parisph.parallel.messages import exchange, pack, unpack
from parisph.parallel.particles import Particles
from parisph.parallel.partition import Grid, Partition, cell_along

# A pair exactly one halo width apart must not be lost by rounding.
ROUNDING = 1.0 + 1e-9


class Halo:
    """The ghosts of one plan, and their updates. The constructor is collective.

    A rank gets every particle of another rank within `width` of any cell that it owns, even an empty one. The owner
    finds these particles without communication, from the cells around those of its own particles. One message brings
    each rank its ghosts with their `exchanged` fields and their numbers. These define the plan of further exchanges, a
    PETSc star forest whose roots are particles with ghosts elsewhere.

    Parameters
    ----------
    particles : Particles, on the ranks that own them; gets ghosts
    partition : Partition
    cells : (n_owned,) int64, keys of the particles' cells
    width : float, at most the size of the partition's cells / ROUNDING [m]

    Attributes
    ----------
    rows : (n_ghost,) int64, global rows of the ghosts, which are sorted by owner
    receivers, n_sent : int, number of ranks that get ghosts from this one, and of these ghosts
    """

    def __init__(self, particles: Particles, partition: Partition, cells: Ints, width: float) -> None:
        self.particles = particles
        self._units: dict[int, MPI.Datatype] = {}
        particles.resize(particles.n_owned, 0)
        ranks, which = senders(particles.x, cells, partition, width * ROUNDING, particles.comm.rank)
        self.receivers, self.n_sent = len(np.unique(ranks)), len(ranks)
        self._roots, root = np.unique(which, return_inverse=True)
        owner, leaf_root = self._first_message(ranks, which, root)
        self._forest = _star_forest(particles.comm, len(self._roots), owner, leaf_root)

    def _first_message(self, ranks: Ints, which: Ints, root: Ints) -> tuple[Ints, Ints]:
        """Fill the ghosts; return the owner of each, and its number among the owner's roots."""
        p = self.particles
        names = p.fields.exchanged
        records = pack(p, names, which, [("root", np.int32), ("row", np.int64)])
        records["root"] = root
        records["row"] = p.offset + which
        arrived, counts = exchange(p.comm, records, np.bincount(ranks, minlength=p.comm.size))
        p.resize(p.n_owned, len(arrived))
        for name, field in p.fields.items():
            if not field.exchanged:
                getattr(p, f"{name}_all")[p.n_owned:] = field.default
        unpack(p, names, arrived, p.n_owned)
        self.rows = arrived["row"].copy()
        return np.repeat(np.arange(p.comm.size), counts), arrived["root"]

    def update(self, *names: str) -> None:
        """Send the named fields of the owners to the ghosts, all in one message. Collective.

        Raises ParisphError for an unknown field (on all ranks if all give the same names).
        """
        p, dim = self.particles, self.particles.dim
        parts: list[tuple[int, Array]] = []
        columns = 0
        for name in names:
            width = _width(name, dim)
            parts.append((columns, _as_columns(getattr(p, f"{name}_all"), width)))
            columns += width
        root, leaf = np.empty((len(self._roots), columns)), np.empty((p.n_ghost, columns))
        for place, values in parts:
            _take(root, place, values, self._roots)
        unit = self._unit(columns)
        self._forest.bcastBegin(unit, root, leaf, MPI.REPLACE)
        self._forest.bcastEnd(unit, root, leaf, MPI.REPLACE)
        for place, values in parts:
            _put(values, leaf, place)

    def _unit(self, columns: int) -> MPI.Datatype:
        if columns not in self._units:
            self._units[columns] = MPI.DOUBLE.Create_contiguous(columns).Commit()
        return self._units[columns]

    def destroy(self) -> None:
        """Free the plan; the ghosts keep their values. Collective."""
        self._forest.destroy()
        for unit in self._units.values():
            unit.Free()
        self._units.clear()


def _width(name: str, dim: int) -> int:
    """Return the number of doubles of a field in a message."""
    if name not in FIELDS:
        raise ParisphError(f"no such particle field: {name} (there are {', '.join(FIELDS)})")
    return int(dim ** ORDER[FIELDS[name].shape])


def _as_columns(values: Array, width: int) -> Array:
    """Return a view (n, width) of values, as doubles if they have 8 bytes: an id may need all 64 bits."""
    return (values.view(np.float64) if values.dtype.itemsize == 8 else values).reshape(len(values), width)


def compile_for_ranks() -> None:
    """Compile or load the kernels that only several ranks need for ghosts in 2D. Not collective."""
    nowhere = Partition(Grid(np.zeros(2), 1.0, 1, 0, *machine(2)), np.zeros(2, np.int64))
    senders(np.zeros((0, 2)), np.zeros(0, np.int64), nowhere, 0.0, 0)
    for kind in {np.float64 if np.dtype(field.dtype).itemsize == 8 else field.dtype for field in FIELDS.values()}:
        values: Array = np.zeros((1, 1), kind)
        message = np.zeros((1, 1))
        _take(message, 0, values, np.zeros(1, np.int64))
        _put(values, message, 0)


@kernel
def _take(root: Floats, place: int, values: Array, which: Ints) -> None:
    """Copy rows `which` of values to the columns of root from `place` on."""
    for k in range(len(which)):
        for column in range(values.shape[1]):
            root[k, place + column] = values[which[k], column]


@kernel
def _put(values: Array, leaf: Floats, place: int) -> None:
    """Copy the columns of leaf from `place` on to the last rows of values."""
    first = len(values) - len(leaf)
    for k in range(len(leaf)):
        for column in range(values.shape[1]):
            values[first + k, column] = leaf[k, place + column]


def _star_forest(comm: MPI.Comm, n_roots: int, owner: Ints, root: Ints) -> Any:
    """Return the star forest in which leaf k copies root[k] of rank owner[k]. Collective."""
    from parisph.parallel.petsc import PETSc  # here, because the import starts PETSc

    forest = PETSc.SF().create(comm=comm)
    remote = np.stack([owner, root], axis=1).astype(PETSc.IntType)
    forest.setGraph(n_roots, None, remote.ravel())
    forest.setUp()
    return forest


def senders(x: Floats, cells: Ints, partition: Partition, width: float,
            rank: int) -> tuple[Ints, Ints]:
    """Find the ranks that need ghosts of this rank's particles. Not collective.

    Parameters
    ----------
    x : (n_owned, dim) positions [m]
    cells : (n_owned,) int64, keys of their cells; faster if sorted
    partition : Partition
    width : float [m]
    rank : int, of the owner

    Returns
    -------
    ranks, which : (m,) int64, rank `ranks[k]` needs particle `which[k]`; sorted by rank, then by particle
    """
    pairs = _senders(x, cells, partition.splitters, width, rank, partition.grid)
    order = np.argsort(pairs[:, 0], kind="stable")
    return pairs[order, 0], pairs[order, 1]


@kernel
def _senders(x: Floats, cells: Ints, splitters: Ints, width: float, rank: int, grid: Grid) -> Ints:
    n, dim = x.shape
    pairs = np.empty((n // 8 + 64, 2), np.int64)
    found = 0
    offsets = np.empty((3**dim, dim), np.int64)  # of surrounding cells of other ranks
    owners = np.empty(3**dim, np.int64)
    cell = np.empty(dim, np.int64)
    end = 0
    while end < n:
        start = end
        while end < n and cells[end] == cells[start]:
            end += 1
        for a in range(dim):
            cell[a] = cell_along(x[start, a], grid.origin[a], grid.size, 2.0**grid.bits)
        foreign = _foreign_around(offsets, owners, cell, splitters, rank, grid)
        if foreign == 0:
            continue
        room = found + (end - start) * foreign
        if room > len(pairs):
            larger = np.empty((2 * room, 2), np.int64)
            larger[:found] = pairs[:found]
            pairs = larger
        for i in range(start, end):
            for k in range(foreign):
                if _is_near(x[i], cell, offsets[k], width, grid) and not _told(pairs, found, i, owners[k]):
                    pairs[found, 0], pairs[found, 1] = owners[k], i
                    found += 1
    return pairs[:found]


@subkernel
def _foreign_around(offsets: Ints, owners: Ints, cell: Ints, splitters: Ints, rank: int, grid: Grid) -> int:
    """List the cells around `cell` that other ranks own; return their number."""
    dim = len(cell)
    there = np.empty(dim, np.int64)
    n = 0
    for number in range(3**dim):
        rest, inside = number, True
        for a in range(dim):
            offsets[n, a] = rest % 3 - 1
            rest //= 3
            there[a] = cell[a] + offsets[n, a]
            inside = inside and 0 <= there[a] < 2**grid.bits
        if inside:
            key = key_of(there, grid.bits, grid.place, grid.following)
            if key < splitters[rank] or key >= splitters[rank + 1]:
                owners[n] = np.searchsorted(splitters[1:-1], key, side="right")
                n += 1
                if n == len(owners):
                    break
    return n


@subkernel
def _is_near(point: Floats, cell: Ints, offset: Ints, width: float, grid: Grid) -> bool:
    """Return whether a point is within `width` of the cell at `offset` from its own cell."""
    d2 = 0.0
    for a in range(len(point)):
        if offset[a] < 0:
            d2 += max(point[a] - (grid.origin[a] + cell[a] * grid.size), 0.0) ** 2
        elif offset[a] > 0:
            d2 += max(grid.origin[a] + (cell[a] + 1) * grid.size - point[a], 0.0) ** 2
    return d2 <= width * width


@subkernel
def _told(pairs: Ints, found: int, i: int, owner: int) -> bool:
    """Return whether the pair of this owner and this particle is already listed."""
    k = found - 1
    while k >= 0 and pairs[k, 1] == i:
        if pairs[k, 0] == owner:
            return True
        k -= 1
    return False
