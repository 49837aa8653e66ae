"""The half cells beside walls: for which part of them fluid stands."""

import numpy as np
import pytest

from parisph.base.fields import WALL
from parisph.kernels import halves
from tests.pools import dims, tank


def filled(dim, **how):
    return tank((9, 9) if dim == 2 else (7, 7, 7), **how)


def shares(pool, cells, most=1.0, before=halves.LAYER):
    """Return the shares if each fluid particle stands for so many cells of the lattice: a number, or (n,)."""
    out = np.full(pool.n, np.nan)
    cells = np.where(pool.fluid, cells, 0.0)
    halves.wall_share(out, pool.cloud, cells, most, before)
    assert np.all(out[pool.fluid] == 1.0)
    return out


@dims
@pytest.mark.parametrize("cells, expected", [(0.5, 0.0), (1.0, 0.0), (1.25, 0.5), (1.5, 1.0), (2.25, 1.0)])
def test_the_share_of_a_wall_is_the_half_cells_in_front_of_it(dim, cells, expected):
    pool = filled(dim)
    plane = (pool.kind == WALL) & (pool.corner == 0)
    np.testing.assert_allclose(shares(pool, cells, most=2.0)[plane], expected, atol=1e-12)


@dims
def test_a_particle_between_two_of_a_wall_has_its_half_cell_at_both(dim):
    pool = filled(dim)
    i, ahead, behind = (pool.at(*(4,) * (dim - 2), k, *low) for k, low in ((4, (1,)), (4, (0,)), (5, (0,))))
    pool.x[i, dim - 2] += 0.25 * pool.spacing
    pool.relist()
    share = shares(pool, np.where(np.arange(pool.n) == i, 1.5, 1.0))
    np.testing.assert_allclose(share[[ahead, behind]], [0.75, 0.25], atol=1e-12)
    assert share[pool.kind == WALL].sum() == pytest.approx(1.0)


@dims
def test_fluid_that_has_left_a_wall_stands_for_nothing_there(dim):
    pool = filled(dim)
    share = shares(pool, np.where(pool.far_inside(2), 1.5, 1.0))
    np.testing.assert_allclose(share[(pool.kind == WALL) & (pool.corner == 0)], 0.0, atol=1e-12)


@dims
def test_fluid_that_is_pressed_together_along_a_wall_stands_for_more_of_its_particles(dim):
    """Strained along one axis by 0.8 and across the wall by 1/0.8: there are 1/0.8 half cells at each wall particle."""
    pool = filled(dim)
    middle = pool.x[pool.fluid].mean(axis=0)
    fluid = pool.fluid
    pool.x[fluid, 0] = middle[0] + 0.8 * (pool.x[fluid, 0] - middle[0])
    pool.x[fluid, 1] = pool.x[fluid, 1] / 0.8
    low = (pool.kind == WALL) & (pool.corner == 0) & (pool.normal[:, 1] > 0.5)
    near = low & (np.abs(pool.x[:, 0] - middle[0]) < 1.5 * pool.spacing)
    cells = np.where(pool.x[:, 1] < 1.5 * pool.spacing, 1.5, 1.0)
    found = shares(pool, cells, np.inf, halves.FAR_BEFORE)
    assert found[near].mean() == pytest.approx(1.25, abs=0.06)
    assert shares(pool, cells)[near].max() == 1.0
