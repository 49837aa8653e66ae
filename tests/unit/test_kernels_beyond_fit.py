"""What a velocity has beyond its fit, which the filter removes, against exact fields."""

import numpy as np
import pytest

from parisph.base.fields import DRY, WALL
from parisph.kernels import strain
from tests.pools import block, dims, free, tank


def smoothed(pool, u, strength=0.03):
    """Return the change by the filter, and check that it is the same with the gradient in the same pass."""
    alone, beside = np.full_like(pool.x, np.nan), np.full_like(pool.x, np.nan)
    for n, beyond in ((0, alone), (pool.n, beside)):
        g, rate = np.empty((n, pool.dim, pool.dim)), np.empty(n)
        strain.velocity_gradient(g, rate, beyond, pool.cloud, u, 2.1 * pool.spacing, 0.05)
    np.testing.assert_array_equal(beside, alone)
    return -strength * alone


@dims
@pytest.mark.parametrize("jitter", [0.0, 0.8])
def test_linear_velocity_passes(dim, jitter):
    pool = tank((8,) * dim if dim == 2 else (6,) * dim, jitter=jitter)
    random = np.random.default_rng(0)
    u = pool.x @ random.normal(size=(dim, dim)) + random.normal(size=dim)
    np.testing.assert_allclose(smoothed(pool, u, 1.0), 0.0, atol=1e-12)


@dims
def test_roughness_is_reduced_and_walls_are_left_alone(dim):
    pool = tank((12, 12) if dim == 2 else (7, 7, 7), jitter=0.4)
    u = np.random.default_rng(1).normal(size=pool.x.shape)
    change = smoothed(pool, u)
    assert np.all(change[~pool.fluid] == 0.0)
    inside = pool.far_inside(2)
    work = (change[inside] * u[inside]).sum()
    assert work < 0.0
    # white noise loses strength (1 - the particle's share in its own mean), a half or more
    assert -work / (u[inside] ** 2).sum() == pytest.approx(0.03 * 0.75, rel=0.2)
    np.testing.assert_allclose(smoothed(pool, u, 0.06), 2.0 * change, rtol=1e-12, atol=1e-15)


@dims
def test_a_particle_counts_once_in_its_own_mean(dim):
    pool = block(dim, 7)
    i = pool.at(*(3,) * dim)
    u = np.where((np.arange(pool.n) == i)[:, None], np.ones(dim), 0.0)
    q = np.minimum(np.linalg.norm(pool.x - pool.x[i], axis=1) / (2.1 * pool.spacing), 1.0)
    share = 1.0 / (1.0 - 6.0 * q**2 + 8.0 * q**3 - 3.0 * q**4).sum()
    np.testing.assert_allclose(smoothed(pool, u, 1.0)[i], share - 1.0)


def test_alternating_velocity_decays_and_a_long_wave_hardly():
    pool = block(2, 24)
    inside = pool.far_inside(4)
    alternating = np.where(pool.index.sum(axis=1) % 2 == 0, 1.0, -1.0)[:, None] * np.ones(2)
    k = 2.0 * np.pi / (24.0 * pool.spacing)
    wave = np.stack([np.cos(k * pool.x[:, 0]) * np.exp(k * pool.x[:, 1]),
                     np.sin(k * pool.x[:, 0]) * np.exp(k * pool.x[:, 1])], axis=1)
    rates = []
    for u in (alternating, wave):
        change = smoothed(pool, u)
        rates.append(-(change[inside] * u[inside]).sum() / (u[inside] ** 2).sum())
    assert rates[0] > 0.03 * 0.9
    assert abs(rates[1]) < 1e-4 * rates[0], "a harmonic velocity has no Laplacian"


def test_filter_leaves_dry_walls_out():
    pool = tank((8, 8), jitter=0.4)
    pool.role[pool.kind == WALL] = DRY
    u = np.where(pool.fluid[:, None], pool.x, np.nan)
    change = smoothed(pool, u, 1.0)
    np.testing.assert_allclose(change[pool.fluid], 0.0, atol=1e-12)


@dims
@pytest.mark.parametrize(("distance", "touched"), [(0.8, True), (2.0, False)])
def test_particle_that_dominates_its_own_mean_is_left_alone(dim, distance, touched):
    unit = np.eye(dim)
    pool = free(np.vstack([np.zeros(dim), distance * unit, -distance * unit]))
    u = np.vstack([np.ones(dim), np.zeros((2 * dim, dim))])
    assert np.any(smoothed(pool, u, 1.0)[0] != 0.0) == touched


@dims
@pytest.mark.parametrize("shape", ["alone", "pair", "line", "wavy line", "coincident"])
def test_filter_leaves_degenerate_neighbourhoods_alone(dim, shape):
    rng = np.random.default_rng(0)
    line = np.arange(9)[:, None] * np.eye(dim)[0]
    index = {"alone": np.zeros((1, dim)), "pair": line[:2], "line": line + 0.3 * rng.random((9, 1)) * np.eye(dim)[0],
             "wavy line": line + 0.1 * rng.random((9, dim)), "coincident": np.zeros((4, dim))}[shape]
    pool = free(index)
    u = pool.x @ rng.normal(size=(dim, dim)) + 1.0
    np.testing.assert_allclose(smoothed(pool, u, 1.0), 0.0, atol=1e-12)
    assert np.all(smoothed(pool, rng.normal(size=pool.x.shape), 1.0) == 0.0)
