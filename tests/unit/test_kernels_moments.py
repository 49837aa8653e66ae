"""Moments of neighbourhoods, and the small linear systems of least squares."""

import numpy as np
import pytest

from parisph.base.fields import CONTACT, DRY
from parisph.kernels import moments
from parisph.kernels.smoothing import quartic_weight
from tests.pools import block, dims, free


def definite(n, seed=0):
    a = np.random.default_rng(seed).normal(size=(n, n + 3))
    return a @ a.T


@pytest.mark.parametrize("n", [2, 3, 4, 8])
def test_cholesky_solves(n):
    a = definite(n)
    b = np.random.default_rng(1).normal(size=n)
    factor, solution = np.tril(a) + np.triu(np.full((n, n), np.nan), 1), b.copy()  # the upper part is not read
    assert moments.cholesky(factor, n)
    moments.cholesky_solve(factor, solution, n)
    np.testing.assert_allclose(solution, np.linalg.solve(a, b), rtol=1e-9)


def test_cholesky_uses_the_leading_block_only():
    a = np.full((8, 8), np.nan)
    a[:4, :4] = definite(4)
    assert moments.cholesky(a, 4) and np.isnan(a[4:]).all()


@pytest.mark.parametrize("spoil", [
    lambda a: np.zeros_like(a),
    lambda a: a @ np.diag([1.0, 1.0, 0.0, 1.0]),
    lambda a: np.outer(a[0], a[0]),
    lambda a: np.full_like(a, np.nan),
    lambda a: np.diag([1.0, 1.0, 1.0, 1e-3]),
])
def test_cholesky_refuses_what_is_degenerate(spoil):
    a = spoil(definite(4))
    assert not moments.cholesky(0.5 * (a + a.T), 4)


@dims
def test_inverse_and_measure_of_isotropy(dim):
    m, inverse = definite(dim), np.full((dim, dim), np.nan)
    measure = moments.invert(m, inverse, tuple(range(dim)))
    np.testing.assert_allclose(inverse @ m, np.eye(dim), atol=1e-10)
    assert measure == pytest.approx(np.linalg.det(m) / (np.trace(m) / dim) ** dim, rel=1e-12)
    for scale in (1e-30, 1.0, 1e30):
        assert moments.invert(scale * np.eye(dim), inverse, tuple(range(dim))) == pytest.approx(1.0, rel=1e-12)


@dims
def test_flat_empty_and_broken_moments_measure_zero(dim):
    axes, inverse = tuple(range(dim)), np.empty((dim, dim))
    flat = np.eye(dim)
    flat[-1, -1] = 0.0
    for m in (flat, np.zeros((dim, dim)), np.full((dim, dim), np.nan), -np.eye(dim)):
        assert moments.invert(m, inverse, axes) == 0.0


@dims
@pytest.mark.parametrize("power", [0, 2])
def test_second_moment(dim, power):
    pool = block(dim, 7, jitter=0.8)
    i, radius = pool.at(*[3] * dim), 2.1 * pool.spacing
    pool.role[pool.at(*[2] * dim)] = DRY
    pool.role[pool.at(*[4] * dim)] = CONTACT
    m = np.empty((dim, dim))
    found = moments.second_moment(m, i, pool.cloud, radius**2, power)
    r = pool.x - pool.x[i]
    r2 = (r**2).sum(axis=1)
    near = (r2 > 0.0) & (r2 < radius**2) & (pool.role != DRY) & (pool.role != CONTACT)
    weight = [quartic_weight(value, radius**2) * (radius**2 / value if power else 1.0) for value in r2[near]]
    assert found == np.count_nonzero(near)
    expected = np.einsum("k,ka,kb->ab", weight, r[near], r[near]) / radius**2
    np.testing.assert_allclose(m, expected, rtol=1e-12, atol=1e-14)


@pytest.mark.parametrize("power", [0, 2])
def test_pairs_without_a_direction_or_too_far_apart_weigh_nothing(power):
    pool = free([[0, 0], [0, 0], [1, 0]], spacing=1.0)
    assert moments.pair_weight(0, 1, pool.x, 4.0, power, pool.axes) == (0.0, 0.0)
    assert moments.pair_weight(0, 2, pool.x, 1.0, power, pool.axes) == (0.0, 1.0)
    weight, r2 = moments.pair_weight(0, 2, pool.x, 4.0, power, pool.axes)
    assert r2 == 1.0 and weight == pytest.approx(quartic_weight(1.0, 4.0) * (4.0 if power else 1.0), rel=1e-14)


@pytest.mark.parametrize("n", [1, 3, 6])
def test_elimination_solves_systems_that_need_a_row_exchange(n):
    random = np.random.default_rng(n)
    for _ in range(20):
        a, exact = random.normal(size=(n, n)), random.normal(size=n)
        a[0, 0] = 0.0 if n > 1 else 2.0
        right = a @ exact
        factored, found = a.copy(), right.copy()
        if moments.eliminate(factored, found, n):
            np.testing.assert_allclose(found, exact, rtol=1e-8, atol=1e-8)
        else:
            assert np.linalg.cond(a) > 10.0
    singular = np.ones((n, n))
    assert moments.eliminate(singular, np.ones(n), n) == (n == 1)
