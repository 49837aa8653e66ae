"""The velocity gradient and the rate of strain, against exact fields."""

import numpy as np
import pytest

from parisph.base.fields import DRY
from parisph.kernels import strain
from tests.pools import block, dims, free, tank


def found(pool, u, floor=0.05):
    g, rate = np.full((pool.n, pool.dim, pool.dim), np.nan), np.full(pool.n, np.nan)
    strain.velocity_gradient(g, rate, np.empty((0, pool.dim)), pool.cloud, u, 2.1 * pool.spacing, floor)
    return g, rate


@dims
@pytest.mark.parametrize("jitter", [0.0, 0.8])
def test_linear_velocity_is_exact(dim, jitter):
    pool = tank((8,) * dim if dim == 2 else (6,) * dim, jitter=jitter)
    random = np.random.default_rng(0)
    gradient = random.normal(size=(dim, dim))
    g, rate = found(pool, pool.x @ gradient.T + random.normal(size=dim))
    symmetric = 0.5 * (gradient + gradient.T)
    np.testing.assert_allclose(g[pool.fluid], np.broadcast_to(gradient, g[pool.fluid].shape), atol=1e-10)
    np.testing.assert_allclose(rate[pool.fluid], np.sqrt(2.0 * (symmetric**2).sum()), rtol=1e-9)
    assert np.all(g[~pool.fluid] == 0.0) and np.all(rate[~pool.fluid] == 0.0)


def test_rigid_rotation_is_no_strain():
    pool = block(2, 7, jitter=0.8)
    g, rate = found(pool, pool.x @ np.array([[0.0, 2.0], [-2.0, 0.0]]))
    assert np.abs(g).max() == pytest.approx(2.0) and rate.max() < 1e-10


def test_simple_shear_has_the_rate_of_its_slope():
    _, rate = found(pool := block(2, 6), pool.x[:, ::-1] * [3.0, 0.0])
    np.testing.assert_allclose(rate, 3.0)


@dims
def test_it_converges_with_second_order_on_a_lattice(dim):
    errors = []
    for n in (8, 16) if dim == 2 else (6, 12):
        pool = block(dim, n)
        x = pool.x / (n * pool.spacing)
        u = np.stack([np.sin(2.0 * x[:, 0]) * np.cos(x[:, 1]), *[np.cos(x[:, -1])] * (dim - 1)], axis=1)
        g, _ = found(pool, u)
        inside = np.all((x > 0.3) & (x < 0.7), axis=1)
        exact = 2.0 * np.cos(2.0 * x[:, 0]) * np.cos(x[:, 1])
        errors.append(np.abs(g[inside, 0, 0] * n * pool.spacing - exact[inside]).max())
    assert errors[0] > 3.0 * errors[1]


@dims
def test_neighbours_that_do_not_span_the_space_give_none(dim):
    line = free(np.arange(6)[:, None] * 0.8 * np.eye(dim)[0])
    g, rate = found(line, np.random.default_rng(0).normal(size=line.x.shape))
    assert np.all(g == 0.0) and np.all(rate == 0.0)


def test_dry_walls_do_not_count():
    pool = tank((7, 7))
    pool.role[~pool.fluid] = DRY
    u = np.where(pool.fluid[:, None], pool.x @ np.diag([1.0, -1.0]), 99.0)
    g, _ = found(pool, u)
    np.testing.assert_allclose(g[pool.fluid], np.broadcast_to(np.diag([1.0, -1.0]), g[pool.fluid].shape), atol=1e-10)


@dims
def test_mean_over_the_fluid_within_the_radius(dim):
    pool = tank((7,) * dim if dim == 2 else (5,) * dim, jitter=0.5)
    f, out = np.random.default_rng(0).normal(size=pool.n), np.full(pool.n, np.nan)
    strain.mean_over_fluid(out, pool.cloud, f, 2.1 * pool.spacing)
    far = np.linalg.norm(pool.x[:, None] - pool.x[None], axis=2)
    near = (far < 2.1 * pool.spacing) & pool.fluid[None]
    np.testing.assert_allclose(out[pool.fluid], (near @ f / near.sum(axis=1))[pool.fluid], rtol=1e-12)
    assert np.all(out[~pool.fluid] == 0.0)
