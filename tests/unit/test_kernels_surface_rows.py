"""The rows of surface particles are exact where pressure is linear in the depth, and leave half particles at p = 0."""

import numpy as np
import pytest

from parisph.base.fields import INNER, SURFACE
from parisph.kernels.surface_rows import surface_rows
from parisph.pressure.rows import add_surface_values
from tests.pools import block, tank

dims = pytest.mark.parametrize("dim", [2, 3])


def rows(pool, share=1.0, offset=0.5):
    """Return count, columns and values of the rows; share: of a cell that each particle stands for."""
    n, s = pool.n, pool.spacing
    count = np.full(n, -1, np.int32)
    columns, values = np.zeros(len(pool.indices), np.int32), np.zeros(len(pool.indices))
    volume = share * np.where(pool.fluid, s**pool.dim, 0.0)
    surface_rows(count, columns, values, pool.x, pool.kind, pool.role, volume, offset * s, s, 2.1 * s, *pool.csr)
    return count, columns, values


def flat_surface(dim):
    """A block of which the upper layer is the surface, and one of its particles in the middle."""
    pool = block(dim, 9 if dim == 2 else 7)
    pool.role[pool.index[:, -1] == pool.top[-1]] = SURFACE
    return pool, np.flatnonzero((pool.role == SURFACE) & (pool.index[:, :-1] == pool.top[:-1] // 2).all(axis=1))[0]


@dims
@pytest.mark.parametrize("offset", [0.25, 0.5])
def test_pressure_linear_in_depth_is_exact(dim, offset):
    pool, i = flat_surface(dim)
    depth = pool.x[i, -1] + offset * pool.spacing - pool.x[:, -1]
    count, columns, values = rows(pool, offset=offset)
    own = slice(pool.indptr[i], pool.indptr[i] + count[i])
    assert count[i] > dim
    assert values[own] @ depth[columns[own]] == pytest.approx(depth[i], rel=1e-12)
    assert values[own].min() > 0.0 and values[own].sum() < 1.0
    assert np.all(pool.role[columns[own]] == INNER)


@dims
def test_a_particle_on_the_surface_has_no_pressure(dim):
    pool, i = flat_surface(dim)
    assert rows(pool, share=0.5)[0][i] == 0
    assert rows(pool, share=0.59)[0][i] == 0
    part, full = (values[pool.indptr[i]] for _, _, values in (rows(pool, share=0.75), rows(pool)))
    offset = 0.5 * (0.75 - 0.6) / 0.4
    assert part / full == pytest.approx(offset / (1.0 + offset) / (0.5 / 1.5), rel=0.1)    # the mean depth is about one


def test_only_rows_of_surface_particles_are_written():
    pool, _ = flat_surface(2)
    count, _, _ = rows(pool)
    assert np.all(count[pool.role == INNER] == -1) and np.all(count[pool.role == SURFACE] >= 0)


def test_a_lone_particle_and_a_thread_have_no_pressure():
    pool, i = flat_surface(2)
    pool.role[:] = SURFACE
    count, _, _ = rows(pool)
    assert np.all(count == 0)


def test_beside_a_wall_a_particle_stands_for_half_a_spacing_more():
    pool = tank((8, 8))
    surface = pool.fluid & (pool.x[:, 1] == pool.x[pool.fluid, 1].max())
    pool.role[surface] = SURFACE
    first = np.flatnonzero(surface)[np.argmin(pool.x[surface, 0])]
    assert rows(pool, share=0.75)[0][first] == 0     # 3/2 spacings wide, 1/2 high
    middle = np.flatnonzero(surface)[np.count_nonzero(surface) // 2]
    assert rows(pool, share=0.75)[0][middle] > 0


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
    add_surface_values(right, given, pool.role, count, columns, values, offset > 0.0, pool.indptr)
    for i in range(pool.n):
        own = slice(pool.indptr[i], pool.indptr[i] + count[i])
        unknown = np.ones(count[i], bool) if offset else pool.role[columns[own]] == INNER
        assert 7.0 - 7.0 * values[own][unknown].sum() == pytest.approx(right[i], rel=1e-12, abs=1e-12)
