"""Results must not depend on how far the neighbour lists reach, nor on the order in them.

Lists are longer than the stencils while their skin lasts, and their order differs between ranks.
"""

import numpy as np
import pytest

from parisph.base.fields import WALL
from parisph.kernels import (
    collisions,
    gradient,
    halves,
    laplacian,
    nearest_walls,
    pairs,
    rankine,
    row,
    shifting,
    strain,
    surface,
    walls,
    wetness,
)
from parisph.kernels.circle import Circle
from parisph.kernels.near import Form
from tests.pools import Rows, dims, free, nowhere, tank

S = 0.1
P = np.random.default_rng(0).normal(size=2000)
U = np.random.default_rng(1).normal(size=(2000, 3))


def least_squares(pool):
    out = np.empty_like(pool.x)
    gradient.least_squares_gradient(out, nowhere(out), pool.cloud, P[: pool.n], Form(2.1 * S, 2, 0.2))
    return out


def harmonic(pool):
    out = np.zeros_like(pool.x)
    gradient.harmonic_gradient(out, pool.cloud, P[: pool.n], 2.6 * S, np.inf, np.inf)
    return out


def symmetric(pool):
    out = np.empty_like(pool.x)
    gradient.symmetric_gradient(out, pool.cloud, P[: pool.n], 1.3 * S, S**pool.dim)
    return out


def wall_velocity(pool):
    u = U[: pool.n, : pool.dim].copy()
    rest = np.zeros_like(u)
    gradient.wall_velocity(u, pool.cloud, rest, rest, 2.6 * S)
    return u


def filtered(pool):
    out = np.empty_like(pool.x)
    strain.velocity_gradient(np.empty((0, pool.dim, pool.dim)), np.empty(0), out, pool.cloud,
                             U[: pool.n, : pool.dim].copy(), 2.1 * S, 0.05)
    return out


def collided(pool):
    out, number, u = np.empty_like(pool.x), np.empty(pool.n, np.int32), U[: pool.n, : pool.dim].copy()
    collisions.count_collisions(number, pool.cloud, u, 0.9 * S)
    collisions.pair_collisions(out, pool.cloud, number, u, velocity_gradient(pool), 0.9 * S, 0.2)
    return out


def velocity_gradient(pool):
    out, u = np.empty((pool.n, pool.dim, pool.dim)), U[: pool.n, : pool.dim].copy()
    strain.velocity_gradient(out, np.empty(pool.n), np.empty_like(u), pool.cloud, u, 2.1 * S, 0.05)
    return out


def mean_rate(pool):
    out = np.empty(pool.n)
    strain.mean_over_fluid(out, pool.cloud, P[: pool.n], 2.1 * S)
    return out


def turned(pool):
    out = np.zeros_like(pool.x)
    pairs.turn_pairs(out, pairs.close_pairs(pool.cloud, S), np.arange(pool.n), np.full(pool.n, 0.1 * S), 0.9 * S)
    return out


def parted(pool):
    out, number = np.empty_like(pool.x), np.empty(pool.n, np.int32)
    cloud = pool.cloud._replace(role=np.where(P[: pool.n] > 0.0, np.int8(1), pool.role))
    cloud = pairs.close_pairs(cloud, S)
    pairs.count_close(number, cloud, 0.9 * S)
    pairs.part_pairs(out, cloud, number, np.arange(pool.n), 0.9 * S, 0.5)
    return out


def guarded(pool):
    u = 4.0 * U[: pool.n, : pool.dim] * pool.fluid[:, None]
    nearest_walls.guard(u, pool.cloud, pool.walls, 0.5 * S, 0.01)
    return u


def density(pool):
    return pool.ratio()


def concentration(pool):
    return pool.concentration()


def shifted(pool):
    out = np.empty_like(pool.x)
    shifting.fick_shift(out, pool.cloud, U[: pool.n, : pool.dim].copy(), np.full(pool.n, 0.01), 0.1 * S, 2.0 * S)
    return out


def of_the_circle(pool, normalised=True):
    rows = Rows(pool)
    rankine.rankine_rows(rows.matrix, rows.flux, pool.cloud, U[: pool.n, : pool.dim].copy(),
                         Circle(rankine.directions(pool.dim), 0.5 * S, 2.1 * S), normalised)
    return rows


def divergence(pool):
    return of_the_circle(pool).div


def rankine_rows(pool, normalised=True):
    rows = of_the_circle(pool, normalised)
    return np.stack([rows.applied(P[: pool.n]), rows.measure])


def printed_rows(pool):
    return rankine_rows(pool, False)


def sph_rows(pool):
    rows = Rows(pool)
    laplacian.isph_rows(rows.matrix, pool.cloud, 1.3 * S, S**pool.dim)
    return np.stack([rows.applied(P[: pool.n]), rows.measure])


def wall_rows(pool):
    rows = Rows(pool)
    walls.sfdi_rows(rows.matrix, pool.cloud, 2.6 * S)
    return np.stack([rows.applied(P[: pool.n]), rows.measure])


def harmonic_wall_rows(pool):
    rows = Rows(pool)
    walls.sfdi_rows(rows.matrix, pool.cloud, 2.6 * S)
    walls.harmonic_rows(rows.matrix, pool.cloud, 2.6 * S, np.inf)
    return np.stack([rows.applied(P[: pool.n]), rows.measure])


def by_gap(pool):
    if pool.dim == 3:
        return pool.role
    role, was = pool.role.copy(), (P[: pool.n] > 0.0).astype(np.int8)
    surface.surface_by_gap(role, was, pool.cloud, pool.walls, np.ones(pool.n), 2.0 * S, surface.Gap(2.3, 1.4, 0.55))
    return role


def covered(pool):
    out = np.empty(pool.n)
    wetness.covered_walls(out, pool.cloud)
    return out


def shares(pool):
    """Half cells around fluid, and what it represents of them and carries, when it has left a half of its own."""
    found, spare, share = np.empty((3, pool.n))
    weight = np.where(pool.kind == WALL, 0.5, 1.0)
    halves.half_cells_around(found, pool.cloud, weight)
    halves.claims(share, spare, pool.cloud, 0.7 * found + 0.1, weight)
    halves.wall_share(share, pool.cloud, weight)
    return np.stack([found, spare, share])


EVERY = (least_squares, harmonic, symmetric, wall_velocity, velocity_gradient, mean_rate, filtered, collided, turned,
         parted, guarded, density, concentration, shifted, divergence, printed_rows, sph_rows, wall_rows,
         harmonic_wall_rows, by_gap, rankine_rows, covered, shares)
each = pytest.mark.parametrize("kernel", EVERY, ids=lambda kernel: kernel.__name__)


def pool_of(dim, reach=2.6):
    """Return a tank so wide that no particle has opposite walls in its list."""
    return tank((9, 8) if dim == 2 else (8, 8, 8), jitter=0.9, spacing=S, reach=reach)


@dims
@each
def test_longer_lists(dim, kernel):
    short, long = pool_of(dim), pool_of(dim, 3.3)
    assert len(long.indices) > 1.2 * len(short.indices)
    np.testing.assert_allclose(kernel(long), kernel(short), rtol=1e-9, atol=1e-11)


@dims
@each
def test_order_in_the_lists(dim, kernel):
    pool = pool_of(dim)
    expected = kernel(pool)
    random = np.random.default_rng(2)
    for first, last in zip(pool.indptr[:-1], pool.indptr[1:]):
        random.shuffle(pool.indices[first:last])
    np.testing.assert_allclose(kernel(pool), expected, rtol=1e-9, atol=1e-11)


@dims
def test_means_in_place_of_rows(dim):
    """In a line, in 3D in a plane, no row is sound; two of the neighbours are 2.61 and 2.65 spacings away."""
    plane = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [-1.5, 2, 0], [2.61, 0, 0], [0, 2.65, 0]]
    line = [[0, 0], [1, 0], [-1, 0], [2.5, 0], [2.61, 0], [-2.65, 0]]
    pool = free(line if dim == 2 else plane, spacing=S, reach=3.3)
    means = Rows(pool)
    means.count[:] = 0
    row.mean_rows(means.matrix, pool.cloud, 2.6 * S)
    for rows in (of_the_circle(pool), means):
        columns, values = rows.entries(0)
        assert sorted(columns) == [1, 2, 3] and rows.measure[0] == 0.0
        np.testing.assert_array_equal(values, 1.0 / 3.0)
