"""The partition of space among the ranks: ranges of the Hilbert curve with equal work."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from mpi4py import MPI

from parisph.base.arrays import Floats, Ints
from parisph.kernels.jit import kernel, subkernel
from parisph.parallel.hilbert import KEY_BITS, key_of, machine

SORT_LEVELS = 2   # particles are sorted by cells this many levels finer than those of ranks


class Grid(NamedTuple):
    """Cubic cells that cover all space: cells on the border extend to infinity.

    Attributes
    ----------
    origin : (dim,) lower corner [m]
    size : float, side of a cell, at least the width of the halo [m]
    bits : int; there are 2^bits cells along each axis
    fine : int; a fine key has this many levels below the cell, to sort particles inside it
    place, following : tables of the Hilbert curve through the cells (hilbert.machine)
    """

    origin: Floats
    size: float
    bits: int
    fine: int
    place: Ints
    following: Ints

    @classmethod
    def covering(cls, lower: Floats, upper: Floats, width: float) -> "Grid":
        """Return the grid over a box, (dim,) corners [m], with cells at least `width` [m] wide."""
        dim = len(lower)
        extent = max(float(np.max(upper - lower)), width)
        needed = int(np.ceil(np.log2(extent / width))) + 1  # + 1 keeps particles off the far border
        bits = min(needed, KEY_BITS // dim)
        return cls(np.array(lower, float), width * 2.0 ** (needed - bits), bits,
                   min(SORT_LEVELS, KEY_BITS // dim - bits), *machine(dim))

    @property
    def dim(self) -> int:
        return len(self.origin)

    @property
    def end(self) -> int:
        """One past the last cell's key."""
        return 1 << (self.dim * self.bits)

    @property
    def upper(self) -> Floats:
        """(dim,) upper corner [m]."""
        return self.origin + self.size * 2.0**self.bits

    def keys(self, x: Floats) -> Ints:
        """Return the fine keys (n,) int64 of positions (n, dim) [m], for sorting."""
        keys = np.empty(len(x), np.int64)
        _position_keys(keys, x, self)
        return keys

    def cells(self, keys: Ints) -> Ints:
        """Return the keys of the cells that contain fine keys."""
        return keys >> (self.dim * self.fine)


@subkernel
def cell_along(x: float, origin: float, size: float, count: float) -> int:
    """Return the cell of a coordinate; points outside belong to the cells on the border."""
    # Compare as floats: far outside, the quotient does not fit an integer.
    return int(min(max(np.floor((x - origin) / size), 0.0), count - 1.0))


@kernel
def _position_keys(keys: Ints, x: Floats, grid: Grid) -> None:
    dim, size, bits = len(grid.origin), grid.size / 2.0**grid.fine, grid.bits + grid.fine
    count = 2.0**bits
    cell = np.empty(dim, np.int64)
    for i in range(len(x)):
        for a in range(dim):
            cell[a] = cell_along(x[i, a], grid.origin[a], size, count)
        keys[i] = key_of(cell, bits, grid.place, grid.following)


@dataclass(frozen=True)
class Partition:
    """Ranges of cells, one for each rank, possibly empty.

    Attributes
    ----------
    grid : Grid
    splitters : (ranks + 1,) int64; rank r owns the cells with splitters[r] <= key < splitters[r + 1]
    """

    grid: Grid
    splitters: Ints

    def owners(self, cells: Ints) -> Ints:
        """Return the ranks (n,) that own the cells of the given keys (n,)."""
        return np.searchsorted(self.splitters[1:-1], cells, side="right")


def split(comm: MPI.Comm, cells: Ints, weights: Ints, end: int) -> Ints:
    """Divide the curve into one range per rank, of equal weight as far as cells allow. Collective.

    Finds all cuts at once by bisection of the keys. Each round sums one vector, with an entry per cut, over the ranks.

    Parameters
    ----------
    cells : (n,) int64 keys of the cells of this rank's particles, in any order
    weights : (n,) int64, of the particles; sums of integers are exact
    end : int, one past the last key

    Returns
    -------
    splitters : (ranks + 1,) int64, the same on all ranks
    """
    order = np.argsort(cells, kind="stable")
    cells = cells[order]
    sums = np.concatenate([[0], np.cumsum(weights[order])])
    total = comm.allreduce(int(sums[-1]))
    targets = np.array([rank * total // comm.size for rank in range(1, comm.size)], np.int64)

    def below(keys: Ints) -> Ints:
        found: Ints = sums[np.searchsorted(cells, keys)]
        comm.Allreduce(MPI.IN_PLACE, found)
        return found

    # Find the smallest key with at least the target below it.
    low, high = np.zeros_like(targets), np.full_like(targets, end)
    while (low < high).any():
        middle = (low + high) // 2
        enough = below(middle) >= targets
        low, high = np.where(enough, low, middle + 1), np.where(enough, middle, high)
    # The cut one cell before may be nearer to the target.
    before = np.maximum(high - 1, 0)
    nearer = targets - below(before) < below(high) - targets
    cuts = np.maximum.accumulate(np.where(nearer, before, high))
    return np.concatenate([[0], cuts, [end]])


def imbalance(loads: Ints) -> float:
    """Return max/mean of the ranks' loads; 1 if there is no load."""
    mean = np.mean(loads)
    return float(np.max(loads) / mean) if mean > 0.0 else 1.0
