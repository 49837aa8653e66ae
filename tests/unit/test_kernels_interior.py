"""Volume of the fluid by the Voronoi cells inside it."""

import numpy as np
import pytest

from parisph.base.fields import BALLISTIC, DRY, INNER, SURFACE
from parisph.kernels.cells import neighbour_lists
from parisph.kernels.interior import MOST, interior_cells
from parisph.kernels.interior_volumes import interior_volumes, spiral
from parisph.kernels.records import cloud_of
from tests.pools import tank


def cells_of(x, role=None, away=0.0, reach=2.6, owned=None):
    """Return (sum of areas, number) of the cells of the first `owned` points, all of which have cells of their own."""
    owned = len(x) if owned is None else owned
    role = np.full(len(x), INNER, np.int8) if role is None else role
    indptr, indices = neighbour_lists(x, owned, reach)
    cloud = cloud_of(x, role, role, np.zeros_like(x), indptr, indices, 1.0)
    total, meant, count = interior_cells(cloud, np.zeros(0), away, reach)
    assert meant == count
    return total, count


def lattice(side, jitter, seed=0):
    x = np.stack(np.meshgrid(np.arange(side), np.arange(side)), axis=-1).reshape(-1, 2) + 0.5
    return x + jitter * (np.random.default_rng(seed).random(x.shape) - 0.5)


def clipped(x, i):
    """Return the corners (m, 2) of the cell of x[i] about it, by cutting a large square with every bisector."""
    polygon = 50.0 * np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])
    for d in np.delete(x, i, axis=0) - x[i]:
        side = polygon @ d - 0.5 * d @ d
        kept = []
        for a, b, p, q in zip(side, np.roll(side, -1), polygon, np.roll(polygon, -1, axis=0)):
            if a <= 0.0:
                kept.append(p)
            if a * b < 0.0:
                kept.append(p + a / (a - b) * (q - p))
        polygon = np.array(kept)
    return polygon


def area_of(polygon):
    px, py = polygon.T
    return 0.5 * (px @ np.roll(py, -1) - py @ np.roll(px, -1))


@pytest.mark.parametrize("jitter", [0.0, 0.4, 1.2, 2.0])
def test_cells_fill_a_periodic_plane(jitter):
    side, reach = 10, 5.0
    x = lattice(side, jitter)
    copies = [x] + [x + side * np.array([a, b]) for a in (-1, 0, 1) for b in (-1, 0, 1) if (a, b) != (0, 0)]
    total, count = cells_of(np.concatenate(copies), reach=reach, owned=side * side)
    assert count == side * side and total == pytest.approx(side * side, rel=1e-9)


@pytest.mark.parametrize("jitter", [0.4, 2.0])
def test_each_cell_against_brute_force(jitter):
    x = lattice(8, jitter, seed=3)
    measured = 0
    for i in range(len(x)):
        order = np.concatenate([[i], np.delete(np.arange(len(x)), i)])
        total, count = cells_of(x[order], reach=3.6, owned=1)
        polygon = clipped(x, i)
        closed = np.linalg.norm(polygon, axis=1).max() < 1.8
        assert count == closed
        if closed:
            assert total == pytest.approx(area_of(polygon), rel=1e-9)
            measured += 1
    assert measured > 20


@pytest.mark.parametrize("role", [SURFACE, BALLISTIC])
def test_cells_near_the_surface_are_left_out(role):
    x = lattice(11, 0.0)
    roles = np.full(len(x), INNER, np.int8)
    centre = 60
    roles[centre] = role
    inside = np.all((x > 1.1) & (x < 9.9), axis=1)
    far = np.linalg.norm(x - x[centre], axis=1) >= 2.1
    total, count = cells_of(x, roles, away=2.1)
    assert count == np.count_nonzero(inside & far) and total == pytest.approx(count, rel=1e-12)


def test_walls_close_cells_but_have_none():
    pool = tank((12, 9), lid=True, spacing=1.0)
    total, count = cells_of(pool.x, pool.role)
    assert count == 11 * 8 and total == pytest.approx(88.0, rel=1e-12)
    pool.role[~pool.fluid] = DRY
    assert cells_of(pool.x, pool.role) == (total, count)


@pytest.mark.parametrize("dim", [2, 3])
def test_cells_end_at_walls_if_fluid_takes_half_cells_along(dim):
    """Those of the first layer are 3/2 wide on the lattice, and 1 half a spacing from the wall."""
    pool = tank((12, 9) if dim == 2 else (7, 7, 8), lid=True, spacing=1.0, reach=3.1)
    sides = (pool.index == 1).sum(axis=1) + (pool.index == pool.top - 1).sum(axis=1)
    closed = pool.fluid & (sides < 3)    # where three walls meet, a corner of the cell is too far for the lists
    total, meant, count = summed(pool, 1.5**sides, 3.1)
    assert count == closed.sum() and meant == (1.5**sides)[closed].sum()
    assert total == pytest.approx(meant, rel=1e-12 if dim == 2 else 2e-3)


@pytest.mark.parametrize("dim", [2, 3])
def test_cells_beside_walls_are_those_beside_an_image(dim):
    pool = tank((12, 9) if dim == 2 else (7, 7, 8), lid=True, spacing=1.0, reach=3.1)
    i = pool.at(*(4,) * (dim - 1), 1)
    before, _, count = summed(pool, np.ones(pool.n), 3.1)
    pool.x[i, -1] -= 0.4
    pool.relist()
    after = summed(pool, np.ones(pool.n), 3.1)
    assert after[2] == count and after[0] == pytest.approx(before, rel=1e-12 if dim == 2 else 2e-3)


def summed(pool, cells, reach):
    """Return (sum of cells, cells represented, number) in a pool, cut off at its walls."""
    if pool.dim == 3:
        return interior_volumes(pool.cloud, cells, 0.0, reach, spiral())
    return interior_cells(pool.cloud, cells, 0.0, reach)


def test_nothing_inside():
    assert cells_of(np.zeros((1, 2))) == (0.0, 0)
    assert cells_of(lattice(2, 0.4)) == (0.0, 0)
    assert cells_of(np.empty((0, 2)), np.empty(0, np.int8)) == (0.0, 0)


def test_crowd_of_neighbours_is_left_out():
    angle = 2.0 * np.pi * np.arange(MOST + 1) / (MOST + 1)
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    assert cells_of(np.vstack([[0.0, 0.0], ring]), owned=1) == (0.0, 0)
    total, count = cells_of(np.vstack([[0.0, 0.0], ring[::2]]), owned=1)
    assert count == 1 and total == pytest.approx(np.pi / 4.0, rel=1e-3)


def test_particles_in_the_same_place_give_finite_areas():
    x = np.vstack([lattice(9, 0.4), lattice(9, 0.4)[40:41]])
    total, count = cells_of(x)
    assert np.isfinite(total) and 0 < count < len(x)
