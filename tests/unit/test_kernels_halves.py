"""The half cells beside walls: each counts once, at the wall or with the fluid that represents it."""

import numpy as np
import pytest

from parisph.base.fields import WALL
from parisph.kernels import halves
from tests.pools import dims, tank


def filled(dim, **how):
    return tank((9, 9) if dim == 2 else (7, 7, 7), **how)


def weights(pool):
    """Return the part of a cell inside the fluid of each wall particle, half of it for each plane that it is in."""
    flat = (pool.index == 0) | (pool.index == pool.top)
    return np.where(pool.kind == WALL, 0.5 ** flat.sum(axis=1), 1.0)


def counted(pool, beside):
    """Return share and spare (n,) if each fluid particle began with so many half cells, over s^dim: (n,)."""
    share, spare = np.full((2, pool.n), np.nan)
    halves.claims(share, spare, pool.cloud, beside, weights(pool))
    halves.wall_share(share, pool.cloud, weights(pool))
    assert np.all(spare[pool.kind == WALL] == 0.0) and np.all(share[pool.fluid] <= 1.0)
    return share, spare


def held(pool, share, spare):
    """Return all half cells, at walls and with fluid, over s^dim."""
    walls = pool.kind == WALL
    return (weights(pool) * share)[walls].sum() + spare.sum()


@dims
@pytest.mark.parametrize("beside, expected", [(0.0, 0.0), (0.25, 0.5), (0.5, 1.0), (0.7, 1.0)])
def test_the_share_of_a_wall_is_the_half_cells_in_front_of_it(dim, beside, expected):
    pool = filled(dim)
    side = np.all((pool.index[:, :-1] > 2) & (pool.index[:, :-1] < pool.top[:-1] - 2), axis=1)
    low = side & (pool.index[:, -1] == 1)
    share, spare = counted(pool, np.where(low, beside, 0.0))
    np.testing.assert_allclose(share[side & (pool.index[:, -1] == 0)], expected, atol=1e-7)
    np.testing.assert_allclose(spare[low], max(beside - 0.5, 0.0), atol=1e-7)


@dims
def test_a_particle_between_two_of_a_wall_has_its_half_cell_at_both(dim):
    pool = filled(dim)
    i, ahead, behind = (pool.at(*(4,) * (dim - 2), k, *low) for k, low in ((4, (1,)), (4, (0,)), (5, (0,))))
    pool.x[i, dim - 2] += 0.25 * pool.spacing
    pool.relist()
    share, spare = counted(pool, np.where(np.arange(pool.n) == i, 0.5, 0.0))
    np.testing.assert_allclose(share[[ahead, behind]], [0.75, 0.25], atol=1e-7)
    assert held(pool, share, spare) == pytest.approx(0.5, abs=1e-7)


@dims
def test_fluid_on_the_lattice_represents_all_half_cells_and_carries_none(dim):
    """In corners and along edges too, where the layers of fluid are farther from a node."""
    pool = filled(dim, lid=True)
    sides = (pool.index == 1).sum(axis=1) + (pool.index == pool.top - 1).sum(axis=1)
    share, spare = counted(pool, np.where(pool.fluid, 1.5**sides - 1.0, 0.0))
    np.testing.assert_allclose(share[pool.kind == WALL], 1.0, atol=1e-6)
    np.testing.assert_allclose(spare, 0.0, atol=1e-6)


@dims
def test_fluid_that_has_left_a_wall_carries_its_half_cell(dim):
    pool = filled(dim)
    beside = np.where(pool.far_inside(2) & np.all((pool.index > 1) & (pool.index < pool.top - 1), axis=1), 0.5, 0.0)
    share, spare = counted(pool, beside)
    np.testing.assert_allclose(share[(pool.kind == WALL) & (pool.corner == 0)], 0.0, atol=1e-12)
    np.testing.assert_allclose(spare[pool.fluid], beside[pool.fluid], atol=1e-12)


@dims
@pytest.mark.parametrize("height", [0.5, 1.0, 1.7, 1.85, 2.2, 3.0])
def test_no_half_cell_is_lost_on_the_way(dim, height):
    """Whatever the distance of a particle from a wall is."""
    pool = filled(dim)
    i = pool.at(*(4,) * (dim - 1), 1)
    pool.x[i, -1] = height * pool.spacing
    pool.relist()
    share, spare = counted(pool, np.where(np.arange(pool.n) == i, 0.5, 0.0))
    assert held(pool, share, spare) == pytest.approx(0.5, abs=1e-7)
    assert spare[i] == pytest.approx(0.5 * np.clip(1.0 - (2.0 - height) / halves.ROOM, 0.0, 1.0), abs=1e-7)


@dims
def test_fluid_of_one_wall_in_a_corner_has_its_half_cell_once(dim):
    """It is before two walls, and its half cell is divided between them."""
    pool = filled(dim)
    i = pool.at(*(3,) * (dim - 2), 1, 1)
    share, spare = counted(pool, np.where(np.arange(pool.n) == i, 0.5, 0.0))
    assert spare[i] == 0.0 and 0.3 < share[i] < 0.7
    assert held(pool, share, spare) == pytest.approx(0.5, abs=1e-7)


@dims
def test_fluid_that_is_pressed_together_along_a_wall_represents_more_of_its_particles(dim):
    """Strained along one axis by 0.8: there are 1/0.8 half cells at each wall particle."""
    pool = filled(dim)
    fluid, middle = pool.fluid, pool.x[pool.fluid].mean(axis=0)
    sides = (pool.index == 1).sum(axis=1) + (pool.index[:, :-1] == pool.top[:-1] - 1).sum(axis=1)
    beside = np.where(fluid, 1.5**sides - 1.0, 0.0)
    pool.x[fluid, 0] = middle[0] + 0.8 * (pool.x[fluid, 0] - middle[0])
    pool.relist()
    low = (pool.kind == WALL) & (pool.corner == 0) & (pool.normal[:, 1] > 0.5)
    near = low & (np.abs(pool.x[:, 0] - middle[0]) < 1.5 * pool.spacing)
    if dim == 3:
        near &= np.abs(pool.x[:, 2] - middle[2]) < 1.5 * pool.spacing
    found, _ = counted(pool, beside)
    assert found[near].mean() == pytest.approx(1.25, abs=0.06)
