"""Real partitions in simulation: particles, neighbours and ghosts of every rank of any number, in one process.

    python run_scripts/studies/cost_model/partitions.py --dim 2 --particles 1e7 --ranks 16 1024 6144 -o partitions.csv

The partition is that of a run: its grid, keys, cuts and ghosts come from parisph.parallel, rank by rank. Only the
communicator is another one. A lattice is made cell by cell, so that the memory goes with the cells and not with the
particles.
"""

import argparse
import csv
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT))

from parisph.driver.simulation import LIST_SKIN, SKIN  # noqa: E402
from parisph.kernels.jit import kernel  # noqa: E402
from parisph.methods.lengths import MLS, NEAR  # noqa: E402
from parisph.parallel.halo import ROUNDING, senders  # noqa: E402
from parisph.parallel.partition import Grid, Partition, split  # noqa: E402

# {dim: of the halo, in spacings}, as in parallel.domain
WIDTH = {dim: NEAR + 2.0 * skin + 2.0 * LIST_SKIN for dim, skin in SKIN.items()}
STENCIL = MLS    # of most rows of the matrix, in spacings
BOXES = {2: ((0.5, 1.0), (2.0, 2.0)), 3: ((0.5, 1.0, 1.0), (2.0, 1.0, 2.0))}    # of the column, and of its tank [m]
RANKS = (1, 2, 4, 16, 64, 256, 1024, 2048, 4096, 6144, 10_000)


class OneForAll:
    """Stands for the communicator of `size` ranks: what this one rank has is all there is."""

    rank = 0

    def __init__(self, size: int) -> None:
        self.size = size

    def allreduce(self, value: int) -> int:
        """Return the sum over all ranks."""
        return value

    def Allreduce(self, _: object, values: np.ndarray) -> None:
        """Leave the sums over all ranks in `values`."""


class Points:
    """Any particles, ordered by cell.

    x : (n, dim) [m]; lower, upper : (dim,) corners of the scene's box [m]; width : of the halo [m]
    weights : (n,) int64, work of each particle, 1 by default

    cells, counts, work : (m,) int64, keys of the cells with particles, sorted; their particles; and the work of these
    """

    def __init__(self, x: np.ndarray, lower: np.ndarray, upper: np.ndarray, width: float,
                 weights: np.ndarray | None = None) -> None:
        self.grid = covering(x.min(axis=0), x.max(axis=0), lower, upper, width)
        cells = self.grid.cells(self.grid.keys(x))
        order = np.argsort(cells, kind="stable")
        self._x = x[order]
        self.cells, first, self.counts = np.unique(cells[order], return_index=True, return_counts=True)
        self._ends = np.append(first, len(x))
        self.work = self.counts if weights is None else np.add.reduceat(weights[order], first)

    def particles(self, first: int, last: int) -> np.ndarray:
        """Return the particles (n, dim) [m] of cells number first to last - 1."""
        return self._x[self._ends[first]:self._ends[last]]


class Column:
    """A column of about n particles on a lattice in a tank, which exist only cell by cell. Attributes as of Points.

    spacing : [m]; n : int, exact number of particles
    """

    def __init__(self, dim: int, n: float, reach: float | None = None) -> None:
        box, tank = (np.array(size) for size in BOXES[dim])
        self.spacing = float((box.prod() / n) ** (1.0 / dim))
        self.axes = [(np.arange(round(side / self.spacing)) + 0.5) * self.spacing for side in box]
        self.n = int(np.prod([len(axis) for axis in self.axes]))
        first, last = (np.array([axis[end] for axis in self.axes]) for end in (0, -1))
        self.grid = covering(first, last, np.zeros(dim), tank, (reach or WIDTH[dim]) * self.spacing)
        self._place()

    def _place(self):
        """Find the cells: along each axis, a cell has the coordinates from one number to the next."""
        ends = [self._ends(a) for a in range(len(self.axes))]
        numbers = np.stack(np.meshgrid(*[np.arange(len(e) - 1) for e in ends], indexing="ij"), -1)
        numbers = numbers.reshape(-1, len(ends))
        start = np.stack([e[:-1][k] for e, k in zip(ends, numbers.T)], -1)
        length = np.stack([np.diff(e)[k] for e, k in zip(ends, numbers.T)], -1)
        corner = np.stack([axis[k] for axis, k in zip(self.axes, start.T)], -1)
        keys = self.grid.cells(self.grid.keys(corner))
        order = np.argsort(keys)
        self.cells, self._start, self._length = keys[order], start[order], length[order]
        self.last = self._start + self._length    # numbers of the coordinates after those of each cell
        self.counts = self.work = self._length.prod(axis=1)

    def _ends(self, a):
        """Return where cells begin among the coordinates of an axis, and the end."""
        fine = self.grid.size / 2.0**self.grid.fine    # as Grid.keys rounds
        cell = np.floor((self.axes[a] - self.grid.origin[a]) / fine).astype(np.int64) >> self.grid.fine
        return np.append(np.unique(cell, return_index=True)[1], len(cell))

    def particles(self, first: int, last: int) -> np.ndarray:
        """Return the particles (n, dim) [m] of cells number first to last - 1."""
        x = np.empty((self.counts[first:last].sum(), len(self.axes)))
        _fill(x, self._start[first:last], self._length[first:last], 0.5 * self.spacing, self.spacing)
        return x


@kernel
def _fill(x, start, length, first, spacing):
    n, dim = 0, x.shape[1]
    for cell in range(len(start)):
        count = 1
        for a in range(dim):
            count *= length[cell, a]
        for k in range(count):
            rest = k
            for a in range(dim):
                x[n, a] = first + spacing * (start[cell, a] + rest % length[cell, a])
                rest //= length[cell, a]
            n += 1


def covering(first: np.ndarray, last: np.ndarray, lower: np.ndarray, upper: np.ndarray, width: float) -> Grid:
    """Return the grid of a run, over the box of the scene and of the particles, (dim,) corners [m]; see Domain."""
    return Grid.covering(np.minimum(lower, first), np.maximum(upper, last), width * ROUNDING)


@dataclass(frozen=True)
class Shares:
    """What each rank has, (ranks,) int64 each.

    owned : particles; sent, received : ghosts; to, by : ranks that get ghosts of this one, and that send it some
    receivers : list of (to,) int64, which ones
    """

    owned: np.ndarray
    sent: np.ndarray
    received: np.ndarray
    to: np.ndarray
    by: np.ndarray
    receivers: list[np.ndarray]


def cut(scene: Points | Column, ranks: int) -> Partition:
    """Return the partition of a scene among ranks."""
    return Partition(scene.grid, split(OneForAll(ranks), scene.cells, scene.work, scene.grid.end))


def shares(scene: Points | Column, partition: Partition, width: float) -> Shares:
    """Return what each rank has if it gets the particles within `width` [m] of its cells as ghosts."""
    ranks = len(partition.splitters) - 1
    ends = np.searchsorted(scene.cells, partition.splitters)
    below = np.concatenate([[0], np.cumsum(scene.counts)])
    sent, received, to, by = (np.zeros(ranks, np.int64) for _ in range(4))
    everyone = []
    for rank in range(ranks):
        first, last = ends[rank], ends[rank + 1]
        x, cells = scene.particles(first, last), np.repeat(scene.cells[first:last], scene.counts[first:last])
        receivers, counts = np.unique(senders(x, cells, partition, width * ROUNDING, rank)[0], return_counts=True)
        sent[rank], to[rank] = counts.sum(), len(receivers)
        received[receivers] += counts
        by[receivers] += 1
        everyone.append(receivers)
    return Shares(np.diff(below[ends]), sent, received, to, by, everyone)


def hops(scene: Column, partition: Partition, receivers: list[np.ndarray]) -> int:
    """Return how many ranks the way from the free surface to the farthest rank has: rounds of pressure.groups.

    The surface is on top of the column and at its right side.
    """
    last = scene.last
    wet = np.any([last[:, a] == last[:, a].max() for a in (0, last.shape[1] - 1)], axis=0)
    reached = np.zeros(len(receivers), bool)
    reached[partition.owners(scene.cells[wet])] = True
    front, found = np.flatnonzero(reached), 0
    while True:
        front = np.unique(np.concatenate([receivers[rank] for rank in front]))
        front = front[~reached[front]]
        if not len(front):
            return found
        reached[front] = True
        found += 1


def line(scene: Column, ranks: int) -> dict[str, float]:
    """Return what a number of ranks gives: max and mean of everything, for the halo and for the matrix."""
    partition = cut(scene, ranks)
    halo = shares(scene, partition, WIDTH[len(scene.axes)] * scene.spacing)
    matrix = shares(scene, partition, STENCIL * scene.spacing)
    found = {"dim": len(scene.axes), "particles": scene.n, "ranks": ranks,
             "hops": hops(scene, partition, matrix.receivers), "empty": np.count_nonzero(halo.owned == 0),
             "owned_mean": halo.owned.mean(), "owned_max": halo.owned.max()}
    for name, which in (("halo", halo), ("matrix", matrix)):
        for what in ("to", "sent", "received"):
            values = getattr(which, what)
            found[f"{name}_{what}_mean"], found[f"{name}_{what}_max"] = values.mean(), values.max()
    return {name: round(float(value), 3) for name, value in found.items()}


def main() -> None:
    """Write one line for each number of ranks, and print it."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--dim", type=int, choices=(2, 3), default=2)
    parser.add_argument("--particles", type=float, default=1e6)
    parser.add_argument("--ranks", type=int, nargs="+", default=list(RANKS))
    parser.add_argument("-o", "--output", type=Path, help="CSV file, to which lines are added")
    args = parser.parse_args()
    scene = Column(args.dim, args.particles)
    for ranks in args.ranks:
        start = time.perf_counter()
        found = line(scene, ranks)
        print(f"{args.dim}D, {scene.n} particles, {ranks} ranks, {time.perf_counter() - start:.1f} s: owned "
              f"max/mean {found['owned_max'] / found['owned_mean']:.3f}, neighbours {found['halo_to_mean']:.1f} "
              f"(max {found['halo_to_max']:.0f}), ghosts {found['halo_received_mean']:.0f} "
              f"(max {found['halo_received_max']:.0f})", flush=True)
        if args.output:
            append(args.output, found)


def append(path: Path, found: dict[str, float]) -> None:
    """Add a line to a CSV file in the order of its head, or with a head if the file is new."""
    names = path.read_text(encoding="utf-8").partition("\n")[0].split(",") if path.exists() else []
    with open(path, "a", newline="", encoding="utf-8") as file:
        table = csv.DictWriter(file, names or list(found), lineterminator="\n")
        if not names:
            table.writeheader()
        table.writerow(found)


if __name__ == "__main__":
    main()
