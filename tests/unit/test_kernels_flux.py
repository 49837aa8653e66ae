"""Divergence stencils without a pressure row."""

import numpy as np
import pytest

from parisph.base.fields import DRY, INNER, WALL
from parisph.kernels import flux, gradient, rankine
from parisph.kernels.circle import Circle
from parisph.kernels.near import Form
from tests.pools import Rows, block, dims, free, nowhere, tank

jitters = pytest.mark.parametrize("jitter", [0.0, 0.8, 1.2])
CIRCLE, MLS = 0.5, 2.1


def circle(pool):
    return Circle(rankine.directions(pool.dim), CIRCLE * pool.spacing, MLS * pool.spacing)


def of_the_circle(pool, u):
    rows = Rows(pool)
    flux.flux_rows(rows.flux, pool.cloud, u, circle(pool))
    return rows


def with_pressure(pool, u, normalised):
    rows = Rows(pool)
    rankine.rankine_rows(rows.matrix, rows.flux, pool.cloud, u, circle(pool), normalised)
    return rows


def nodal(pool, u, power=2, floor=0.05):
    rows = Rows(pool)
    flux.least_squares_flux(rows.flux, pool.cloud, u, Form(MLS * pool.spacing, power, floor))
    return rows


@dims
@jitters
@pytest.mark.parametrize("normalised", [True, False])
def test_flux_is_that_of_the_pressure_rows(dim, jitter, normalised):
    pool = tank((8,) * dim if dim == 2 else (5,) * dim, jitter=jitter)
    pool.role[(pool.kind == WALL) & ((pool.x[:, 0] == 0.0) | (jitter > 1.0))] = DRY    # some stencils are given up
    u = np.random.default_rng(0).normal(size=pool.x.shape)
    found, expected = of_the_circle(pool, u), with_pressure(pool, u, normalised)
    # making a row isotropic can spoil it, with its flux: here the flux is kept
    kept = np.flatnonzero((pool.role == INNER) & ((expected.measure > 0.0) | (not normalised)))
    if jitter > 1.0:
        assert np.any(found.div == 0.0) and len(kept) > 0.5 * np.count_nonzero(pool.role == INNER)
    for i in kept:
        np.testing.assert_allclose(dense(found, i), dense(expected, i), atol=1e-10)
    np.testing.assert_allclose(found.div[kept], expected.div[kept], atol=1e-10)


def dense(rows, i):
    """Return the flux of one stencil over all particles, (n, dim)."""
    own = slice(rows.pool.indptr[i], rows.pool.indptr[i] + rows.count[i])
    out = np.zeros((rows.pool.n, rows.pool.dim))
    out[rows.columns[own]] = rows.flux.flux[own]
    return out


@dims
@pytest.mark.parametrize("of", [of_the_circle, nodal])
def test_longer_lists_change_nothing(dim, of):
    short, long = (block(dim, 8 if dim == 2 else 5, 0.8, reach=reach) for reach in (2.6, 3.6))
    u = np.random.default_rng(1).normal(size=short.x.shape)
    one, other = of(short, u), of(long, u)
    np.testing.assert_array_equal(one.count <= np.diff(short.indptr), True)
    np.testing.assert_array_equal(one.count, other.count)
    np.testing.assert_allclose(one.div, other.div, atol=1e-10)


@dims
@jitters
@pytest.mark.parametrize("of", [of_the_circle, nodal])
def test_divergence_of_linear_velocity_is_exact(dim, jitter, of):
    pool = block(dim, 9 if dim == 2 else 6, jitter)
    slope = np.random.default_rng(5).normal(size=(dim, dim))
    rows = of(pool, pool.x @ slope.T + 3.0)
    np.testing.assert_allclose(rows.div[pool.far_inside(2)], np.trace(slope), atol=1e-10)


@dims
def test_what_reads_the_rankine_stencils_reads_these(dim):
    pool = block(dim, 9 if dim == 2 else 6, 0.8)
    slope = np.random.default_rng(6).normal(size=(dim, dim))
    u, deep = pool.x @ slope.T, pool.far_inside(2)
    exact = np.trace(slope @ slope), np.sqrt(2.0 * (slope**2).sum()), np.trace(slope)
    for rows in (of_the_circle(pool, np.zeros_like(u)), nodal(pool, np.zeros_like(u))):
        assert np.all(rows.div == 0.0)
        out = np.full((4, pool.n), np.nan)
        rankine.divergence(out[0], rows.flux, pool.cloud, u)
        rankine.gradient_invariants(rankine.Invariants(*out[1:]), rows.flux, pool.cloud, u)
        for found, value in zip(out, (exact[2], *exact), strict=True):
            np.testing.assert_allclose(found[deep], value, atol=1e-9)


@dims
@pytest.mark.parametrize("power", [0, 2])
def test_nodal_divergence_is_the_trace_of_the_least_squares_gradient(dim, power):
    pool = block(dim, 8 if dim == 2 else 5, 0.8)
    u, trace = np.random.default_rng(7).normal(size=pool.x.shape), np.zeros(pool.n)
    for a in range(dim):
        out = np.empty_like(u)
        gradient.least_squares_gradient(out, nowhere(out), pool.cloud, np.ascontiguousarray(u[:, a]),
                                        Form(MLS * pool.spacing, power, 0.0))
        trace += out[:, a]
    np.testing.assert_allclose(nodal(pool, u, power, 0.0).div, trace, atol=1e-10 / pool.spacing)


@dims
@pytest.mark.parametrize("of", [of_the_circle, nodal])
@pytest.mark.parametrize("shape", ["alone", "coincident", "line"])
def test_stencils_without_support_are_zero(dim, of, shape):
    index = {"alone": np.zeros((1, dim)), "coincident": np.zeros((4, dim)),
             "line": np.arange(6)[:, None] * np.eye(dim)[:1]}[shape]
    pool = free(index)
    assert np.all(pool.role == INNER)
    rows = of(pool, np.random.default_rng(0).normal(size=pool.x.shape))
    assert np.all(rows.flux.flux == 0.0) and np.all(rows.div == 0.0)
    assert np.all(rows.count <= np.diff(pool.indptr))
