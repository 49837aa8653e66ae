"""Grids, splitting of the curve, loads, and who needs a ghost of whom."""

import itertools

import numpy as np
import pytest
from mpi4py import MPI

from parisph.base.fields import BALLISTIC, DRY, INNER, WET
from parisph.parallel import partition
from parisph.parallel.halo import senders
from parisph.parallel.hilbert import machine
from parisph.parallel.partition import Grid, Partition
from parisph.parallel.work import work_of
from tests.clouds import KINDS, cloud, keys_of_cells


class Share:
    """One rank of `size` that stands for all: the particles it has are all there are."""

    rank = 0

    def __init__(self, size):
        self.size = size

    def allreduce(self, value):
        return value

    def Allreduce(self, send, receive):
        assert send is MPI.IN_PLACE


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("width", [0.03, 0.1, 0.25, 1.0, 7.0])
def test_grid_covers_the_box_with_cells_wide_enough(dim, width):
    lower = np.array([-1.0, 2.0, 5.0])[:dim]
    upper = lower + np.array([1.0, 0.3, 0.5])[:dim]
    grid = Grid.covering(lower, upper, width)
    assert grid.size >= width and (grid.upper > upper).all() and (grid.origin == lower).all()
    assert grid.bits <= np.log2(max(1.0 / width, 1.0)) + 2.0  # and not many more than needed


def test_huge_boxes_get_wider_cells_instead_of_longer_keys():
    grid = Grid.covering(np.zeros(3), np.full(3, 1e9), 0.01)
    assert grid.dim * (grid.bits + grid.fine) <= 62 and (grid.upper > 1e9).all()
    keys = grid.keys(np.array([[0.0, 0.0, 0.0], [1e9, 1e9, 1e9], [1e300, -1e300, 5.0]]))
    assert (0 <= keys).all() and (grid.cells(keys) < grid.end).all()


@pytest.mark.parametrize("dim", [2, 3])
def test_keys_are_those_of_the_cells_and_outside_belongs_to_the_border(dim):
    grid = Grid(np.full(dim, -1.0), 0.25, 3, 2, *machine(dim))
    x = np.random.default_rng(0).uniform(-1.5, 1.5, (500, dim))
    cells = np.clip(np.floor((x + 1.0) / 0.25), 0, 7).astype(int)
    np.testing.assert_array_equal(grid.cells(grid.keys(x)), keys_of_cells(cells, 3))
    fine = np.clip(np.floor((x + 1.0) / 0.0625), 0, 31).astype(int)
    np.testing.assert_array_equal(grid.keys(x), keys_of_cells(fine, 5))


@pytest.mark.parametrize("size", [1, 2, 3, 7, 40])
@pytest.mark.parametrize("seed", range(3))
def test_split_is_the_best_cut_between_cells(size, seed):
    random = np.random.default_rng(seed)
    cells = np.concatenate([random.integers(0, 256, 300), np.full(100 * seed, 17)])
    weights = random.integers(0, 1000, len(cells))
    splitters = partition.split(Share(size), cells, weights, 256)
    assert splitters[0] == 0 and splitters[-1] == 256 and len(splitters) == size + 1
    assert (np.diff(splitters) >= 0).all()
    below = np.array([weights[cells < key].sum() for key in range(257)])
    for rank in range(1, size):
        target = rank * below[-1] // size
        assert abs(below[splitters[rank]] - target) == np.abs(below - target).min()


def test_split_of_nothing_leaves_every_cell_with_an_owner():
    splitters = partition.split(Share(3), np.zeros(0, np.int64), np.zeros(0, np.int64), 64)
    owners = Partition(None, splitters).owners(np.arange(64))
    assert splitters[-1] == 64 and ((0 <= owners) & (owners < 3)).all()


def test_owner_is_the_rank_whose_range_has_the_key_also_beside_empty_ranges():
    splitters = np.array([0, 0, 5, 5, 5, 9, 16, 16])
    owners = Partition(None, splitters).owners(np.arange(16))
    for key, owner in enumerate(owners):
        assert splitters[owner] <= key < splitters[owner + 1]


def test_imbalance():
    assert partition.imbalance([1.0, 3.0]) == 1.5
    assert partition.imbalance([0.0, 0.0]) == 1.0
    assert partition.imbalance([2.0]) == 1.0


def test_work_goes_with_neighbours_and_with_the_part_a_particle_plays():
    found = work_of(np.array([INNER, WET, DRY, BALLISTIC], np.int8), np.array([20, 20, 20, 0], np.int32))
    np.testing.assert_array_equal(found, [300, 300, 90, 30])
    assert found.dtype == np.int64


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("kind", KINDS)
def test_ghosts_go_to_all_owners_of_cells_within_the_width_and_to_nobody_else(kind, dim):
    """Against brute force over all cells; some points lie outside the grid."""
    x = 1.2 * cloud(kind, dim, 300) - 0.1
    grid = Grid(np.zeros(dim), 0.125, 3, 2, *machine(dim))
    width = 0.12
    third = grid.end // 3
    splitters = np.array([0, 3, third, third, third + 1, grid.end // 2, grid.end])  # one empty, one of a single cell
    owned = Partition(grid, splitters)
    cells = grid.cells(grid.keys(x))
    home = owned.owners(cells)
    corners = np.array(list(itertools.product(range(8), repeat=dim)))
    low = np.where(corners == 0, -np.inf, corners * 0.125)
    high = np.where(corners == 7, np.inf, (corners + 1) * 0.125)
    gap = np.maximum(np.maximum(low[None] - x[:, None], x[:, None] - high[None]), 0.0)
    near = (gap**2).sum(axis=-1) <= width**2
    cell_owners = owned.owners(keys_of_cells(corners, 3))
    for rank in range(6):
        mine = np.flatnonzero(home == rank)
        found = senders(x[mine], cells[mine], owned, width, rank)
        due = [(r, i) for r in range(6) if r != rank for i, j in enumerate(mine) if near[j, cell_owners == r].any()]
        assert list(zip(*found, strict=True)) == due
