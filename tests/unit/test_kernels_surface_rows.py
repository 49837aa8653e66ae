"""Where rows of surface particles put p = 0: a part of a layer outside full cells, at the centre of half cells."""

import numpy as np
import pytest

from parisph.base.fields import INNER, SURFACE
from parisph.kernels import records
from parisph.kernels.surface_rows import surface_rows
from parisph.pressure.rows import add_surface_values
from tests.pools import Rows, block, dims, tank


def rows(pool, share=1.0, offset=0.5):
    """Return count, columns and values of the rows; share: of a cell that each particle stands for."""
    s, found = pool.spacing, Rows(pool).matrix
    found.count[:] = -1
    cells = share * np.where(pool.fluid, 1.0, 0.0)
    surface_rows(found, pool.cloud, cells, offset * s, 2.1 * s)
    return found[:3]


def outside(pool, i, found):
    """Return the distance [m] from particle i to p = 0 of the pressure, linear in the depth, that its row keeps."""
    count, columns, values = found
    own = slice(pool.indptr[i], pool.indptr[i] + count[i])
    share = values[own].sum()
    depth = pool.x[i, -1] - values[own] @ pool.x[columns[own], -1] / share
    return depth * share / (1.0 - share)


def flat_surface(dim):
    """A block of which the upper layer is the surface, and one of its particles in the middle."""
    pool = block(dim, 9 if dim == 2 else 7)
    pool.role[pool.index[:, -1] == pool.top[-1]] = SURFACE
    return pool, np.flatnonzero((pool.role == SURFACE) & (pool.index[:, :-1] == pool.top[:-1] // 2).all(axis=1))[0]


@dims
@pytest.mark.parametrize("offset", [0.25, 0.5])
def test_pressure_linear_in_depth_is_zero_at_the_offset(dim, offset):
    pool, i = flat_surface(dim)
    found = count, columns, values = rows(pool, offset=offset)
    own = slice(pool.indptr[i], pool.indptr[i] + count[i])
    assert count[i] > dim
    assert outside(pool, i, found) == pytest.approx(offset * pool.spacing, rel=0.02)
    assert values[own].min() > 0.0 and values[own].sum() < 1.0
    assert np.all(pool.role[columns[own]] == INNER)


@pytest.mark.parametrize("stretch", [0.67, 0.8, 1.2, 1.5])
def test_the_offset_follows_the_distance_of_the_layers(stretch):
    """A lattice that is stretched along the surface, or pushed together, with cells of the same area."""
    assert offset_of(stretch, 1.0 / stretch) == pytest.approx(0.5 / stretch, rel=0.015)


@pytest.mark.parametrize("layers", [0.5, 0.7, 0.85, 1.2, 1.4])
@pytest.mark.parametrize("planar", [False, True])
def test_the_offset_follows_the_distance_of_the_layers_in_3d(layers, planar):
    """The same for a lattice that widens in one direction along the surface, or in both."""
    wide = (1.0 / layers, 1.0) if planar else (layers**-0.5,) * 2
    assert offset_of(*wide, layers) == pytest.approx(0.5 * layers, abs=0.01)


def test_the_offset_has_limits():
    assert offset_of(0.5, 2.0) == pytest.approx(0.5 * 1.5, rel=1e-12)
    pool, i = flat_surface(2)
    pool.x[:] = pool.x[i] + (pool.x - pool.x[i]) * (4.0, 0.25)
    count, _, values = rows(pool)
    a, depth = 0.5 * 0.3, 0.5
    assert values[pool.indptr[i]:pool.indptr[i] + count[i]].sum() == pytest.approx(a / (a + depth), rel=1e-12)


def offset_of(*stretches):
    """Return the distance from the surface particle of a stretched lattice to p = 0, in spacings."""
    pool, i = flat_surface(len(stretches))
    pool.x[:] = pool.x[i] + (pool.x - pool.x[i]) * stretches
    pool.relist()
    return outside(pool, i, rows(pool)) / pool.spacing


@dims
def test_a_particle_on_the_surface_has_no_pressure(dim):
    pool, i = flat_surface(dim)
    assert rows(pool, share=0.5)[0][i] == 0
    assert rows(pool, share=0.8)[0][i] == 0
    full = outside(pool, i, rows(pool))
    assert outside(pool, i, rows(pool, share=0.87)) == pytest.approx(full, rel=1e-12)
    assert outside(pool, i, rows(pool, share=0.835)) == pytest.approx(0.5 * full, rel=1e-12)


def test_only_rows_of_surface_particles_are_written():
    pool, _ = flat_surface(2)
    count, _, _ = rows(pool)
    assert np.all(count[pool.role == INNER] == -1) and np.all(count[pool.role == SURFACE] >= 0)


def test_a_lone_particle_and_a_thread_have_no_pressure():
    pool, i = flat_surface(2)
    pool.role[:] = SURFACE
    count, _, _ = rows(pool)
    assert np.all(count == 0)


def tank_surface(dim, share):
    """A tank whose upper layer is the surface, counts of entries, and the numbers in that layer from a corner."""
    pool = tank((6,) * dim)
    surface = pool.fluid & (pool.x[:, -1] == pool.x[pool.fluid, -1].max())
    pool.role[surface] = SURFACE
    numbers = np.flatnonzero(surface)
    return pool, rows(pool, share=share)[0], numbers[np.lexsort(pool.x[numbers, :-1].T)]


@dims
@pytest.mark.parametrize("share, full", [(0.75, False), (1.5, True)])
def test_half_a_cell_beside_a_wall_lies_on_the_surface_wherever_it_is(dim, share, full):
    """3/2 spacings wide and 1/2 high, before and after it has left the wall."""
    pool, count, surface = tank_surface(dim, share)
    assert np.all((count[surface] > 0) == full)


@dims
@pytest.mark.parametrize("offset", [0.0, 0.5])
def test_the_same_pressure_all_along_the_surface_is_that_of_the_fluid(dim, offset):
    """Rows whose weights sum to one, with p = 0 on the surface: 7 Pa there are 7 Pa everywhere."""
    pool, _ = flat_surface(dim)
    count, columns, values = rows(pool, offset=offset) if offset else rows(pool, share=0.5)
    inner = np.flatnonzero(pool.role == INNER)
    for i in inner:
        start, end = pool.indptr[i], pool.indptr[i + 1]
        count[i], columns[start:end], values[start:end] = end - start, pool.indices[start:end], 1.0 / (end - start)
    given = np.where(pool.role == SURFACE, 7.0, np.nan)
    right = np.zeros(pool.n)
    add_surface_values(right, records.Rows(count, columns, values, right), pool.cloud, given, offset > 0.0)
    for i in range(pool.n):
        own = slice(pool.indptr[i], pool.indptr[i] + count[i])
        unknown = np.ones(count[i], bool) if offset else pool.role[columns[own]] == INNER
        assert 7.0 - 7.0 * values[own][unknown].sum() == pytest.approx(right[i], rel=1e-12, abs=1e-12)
