"""The half cells beside walls, and what they add to the density where no fluid stands for them."""

import numpy as np
import pytest

from parisph.base.fields import WALL
from parisph.kernels import halves, surface
from parisph.kernels.mirrors import beside_walls
from parisph.kernels.smoothing import cubic_spline, cubic_spline_slope
from tests.pools import tank

dims = pytest.mark.parametrize("dim", [2, 3])
H = 1.3


def filled(dim, **how):
    return tank((9, 9) if dim == 2 else (7, 7, 7), **how)


def shares(pool, cells, most=1.0, before=halves.BEFORE):
    """Return the shares if each fluid particle stands for so many cells of the lattice: a number, or (n,)."""
    out = np.full(pool.n, np.nan)
    cells = np.where(pool.fluid, cells, 0.0)
    halves.wall_share(out, pool.x, pool.kind, cells, pool.normal, pool.spacing, most, before, *pool.csr)
    assert np.all(out[pool.fluid] == 1.0)
    return out


def extra(pool, share):
    h = H * pool.spacing
    ratio, gradient = np.zeros(pool.n), np.zeros((pool.n, pool.dim))
    halves.add_parts(ratio, gradient, np.empty(0), pool.beside, pool.x, pool.kind, 1.0 - share, np.empty(0),
                     pool.corner, pool.normal, h, surface.lattice_sum(pool.spacing, h, pool.axes), *pool.csr)
    return ratio, gradient


@dims
@pytest.mark.parametrize("cells, expected", [(0.5, 0.0), (1.0, 0.0), (1.25, 0.5), (1.5, 1.0), (2.25, 1.0)])
def test_the_share_of_a_wall_is_the_half_cells_in_front_of_it(dim, cells, expected):
    pool = filled(dim)
    plane = (pool.kind == WALL) & (pool.corner == 0)
    np.testing.assert_allclose(shares(pool, cells)[plane], expected, atol=1e-12)


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
def test_the_surplus_is_the_sum_over_walls_without_a_share_and_their_images(dim):
    pool = filled(dim, lid=True)
    ratio, gradient = extra(pool, np.where(pool.fluid, 1.0, 0.25))
    h = H * pool.spacing
    full = surface.lattice_sum(pool.spacing, h, pool.axes)
    offsets = np.stack(np.meshgrid(*[np.arange(-3, 4)] * dim, indexing="ij"), axis=-1).reshape(-1, dim)
    for index in ([1] * dim, [3] * (dim - 1) + [1], [1] * (dim - 1) + [2]):
        i = pool.at(*index)
        walls = offsets[(np.array(index) + offsets == 0).any(axis=1)]    # on the planes, also beyond corners
        r = pool.spacing * np.linalg.norm(walls, axis=1)
        assert ratio[i] == pytest.approx(0.75 / full * sum(cubic_spline(d, h, dim) for d in r), rel=1e-12)
        slope = [cubic_spline_slope(d, h, dim) for d in r]
        np.testing.assert_allclose(gradient[i], -0.75 / full * pool.spacing * (slope @ walls), rtol=1e-10, atol=1e-10)
        assert np.all(gradient[i] < 1e-10)    # density grows towards the walls
    assert np.all(ratio[~pool.fluid] == 0.0) and np.all(gradient[~pool.fluid] == 0.0)


@dims
def test_walls_with_their_whole_share_add_no_surplus(dim):
    ratio, gradient = extra(filled(dim, jitter=0.5), np.ones(filled(dim).n))
    assert not ratio.any() and not gradient.any()


@dims
def test_one_pass_gives_the_surplus_of_two_shares(dim):
    pool, rng = filled(dim, jitter=0.5), np.random.default_rng(2)
    parts = [np.where(pool.fluid, 0.0, rng.uniform(-1.0, 0.5, pool.n)) for _ in range(2)]
    parts[0][::3] = 0.0    # where the second one is not
    h = H * pool.spacing
    ratio, gradient, further = np.zeros(pool.n), np.zeros((pool.n, dim)), np.zeros(pool.n)
    halves.add_parts(ratio, gradient, further, pool.beside, pool.x, pool.kind, parts[0], parts[1], pool.corner,
                     pool.normal, h, surface.lattice_sum(pool.spacing, h, pool.axes), *pool.csr)
    one, other = (extra(pool, 1.0 - part) for part in parts)
    assert other[0].any()
    for found, due in ((ratio, one[0]), (gradient, one[1]), (further, other[0])):
        np.testing.assert_allclose(found, due, atol=1e-12)


@dims
def test_parts_of_fluid_without_walls_are_the_same_sum(dim):
    pool = filled(dim, jitter=0.5)
    part, h = np.where(pool.fluid, np.random.default_rng(1).uniform(-0.3, 0.3, pool.n), 0.0), H * pool.spacing
    full, fluid = surface.lattice_sum(pool.spacing, h, pool.axes), np.flatnonzero(pool.fluid)
    due, found = ((np.zeros(pool.n), np.zeros((pool.n, pool.dim))) for _ in range(2))
    halves.add_parts(*due, np.empty(0), fluid, pool.x, pool.kind, part, np.empty(0), pool.corner, pool.normal, h,
                     full, *pool.csr)
    walls = beside_walls(pool.kind, pool.indptr, pool.indices)
    halves.add_parts_inside(*found, pool.x, pool.kind, part, h, full, walls[1], *pool.csr)
    inside = np.setdiff1d(fluid, walls[0])
    assert len(inside) and np.abs(due[0][inside]).min() > 0.0 and not found[0][walls[0]].any()
    for one, other in zip(found, due):
        np.testing.assert_allclose(one[inside], other[inside], atol=1e-12)


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
    found = shares(pool, cells, halves.PRESSED, halves.FAR_BEFORE)
    assert found[near].mean() == pytest.approx(1.25, abs=0.06)
