"""Position projection's source, concentration gradient and Fick shift."""

import numpy as np
import pytest

from parisph.base.fields import BALLISTIC, INNER, SURFACE
from parisph.kernels import packing, shifting
from tests.pools import block, dims, tank

H, LIMIT, REACH = 1.3, 0.1, 2.6


def shifted(pool, gradient, strength=0.3, cap=0.1, reach=2.0):
    out = np.full((pool.n, pool.dim), np.nan)
    shifting.fick_shift(out, pool.cloud, gradient, np.full(pool.n, strength * (H * pool.spacing) ** 2),
                        cap * pool.spacing, reach * pool.spacing)
    return out


# -- concentration gradient -------------------------------------------------------------------------


@dims
def test_gradient_at_the_surface_points_into_the_fluid(dim):
    pool = tank((12, 12) if dim == 2 else (9, 9, 9))
    gradient = pool.spacing * pool.concentration()
    top = pool.fluid & (pool.index[:, -1] == pool.top[-1])
    far = top & np.all((pool.index[:, :-1] > 2) & (pool.index[:, :-1] < pool.top[:-1] - 2), axis=1)
    assert np.all(gradient[top, -1] < -0.1)
    np.testing.assert_allclose(gradient[far, :-1], 0.0, atol=1e-12)


@dims
def test_gradient_across_a_wall_counts_more_in_the_first_layer(dim):
    pool = tank((9, 9) if dim == 2 else (7, 7, 7), lid=True)
    gradient, covered = np.full((pool.n, dim), 0.3), np.ones(pool.n)
    shifting.stiffen(gradient, pool.cloud, covered, np.where(pool.fluid, 1.0, 0.5))
    middle = np.all((pool.index[:, :-1] > 2) & (pool.index[:, :-1] < pool.top[:-1] - 2), axis=1)
    for layer, expected in ((1, 0.3 * shifting.STIFF), (2, 0.3)):
        low = middle & (pool.index[:, -1] == layer)
        assert low.any()
        np.testing.assert_allclose(gradient[low, -1], expected, rtol=1e-7)
        np.testing.assert_allclose(gradient[low, :-1], 0.3, rtol=1e-7)
    again = np.full((pool.n, dim), 0.3)
    shifting.stiffen(again, pool.cloud, np.zeros(pool.n), np.full(pool.n, 0.5))    # above the water line
    np.testing.assert_array_equal(again, 0.3)


# -- what the position projection corrects ------------------------------------------------------------


def error(pool, alpha, doubt=0.0):
    e = np.full(pool.n, np.nan)
    shifting.compression(e, pool.cloud, alpha, np.full(pool.n, doubt), LIMIT, REACH * pool.spacing)
    return e


@dims
def test_density_error_is_clipped(dim):
    pool = block(dim, 5)
    for alpha, expected in ((1.0, 0.0), (1.03, 0.03), (0.95, -0.05), (1.7, 0.1), (0.2, -0.1)):
        np.testing.assert_allclose(error(pool, np.full(pool.n, alpha)), expected, atol=1e-15)


@dims
def test_near_the_surface_only_what_exceeds_the_doubt_is_compression(dim):
    pool = tank((9, 9) if dim == 2 else (6, 6, 8))
    inner = pool.role == INNER
    near = inner & (pool.index[:, -1] > pool.top[-1] - REACH)
    for alpha, doubt, expected in ((0.96, 0.03, 0.0), (1.02, 0.03, 0.0), (1.05, 0.03, 0.02), (1.7, 0.03, 0.07),
                                   (0.96, 0.0, 0.0), (1.04, 0.0, 0.04)):
        e = error(pool, np.full(pool.n, alpha), doubt=doubt)
        assert np.all(e[~inner] == 0.0)
        np.testing.assert_allclose(e[near], expected, atol=1e-12)
        np.testing.assert_allclose(e[inner & ~near], np.clip(alpha - 1.0, -LIMIT, LIMIT), rtol=1e-12)


def test_free_flying_particles_count_as_surface():
    pool = block(2, 7)
    pool.role[pool.at(3, 3)] = BALLISTIC
    e = error(pool, np.full(pool.n, 0.96))
    assert e[pool.at(3, 4)] == 0.0 and e[pool.at(0, 0)] == pytest.approx(-0.04)


# -- Fick shift ---------------------------------------------------------------------------------------


@dims
def test_shift_goes_from_dense_to_sparse(dim):
    pool = block(dim, 11 if dim == 2 else 7)
    middle = pool.top / 2.0
    pool.x += 0.02 * (pool.index - middle) * np.abs(pool.index - middle) * pool.spacing  # dense in the middle
    pool.relist()
    i = pool.at(*middle.astype(int) + np.eye(dim, dtype=int)[0])
    out = shifted(pool, pool.concentration())
    assert out[i, 0] > 0.0 and np.all(np.abs(out[i, 1:]) < 1e-12 + 1e-9 * out[i, 0])


@dims
def test_shift_evens_out_disorder(dim):
    pool = tank((12, 12) if dim == 2 else (8, 8, 8), lid=True, jitter=0.8)
    spread = [np.std(pool.ratio()[pool.fluid])]
    for _ in range(10):
        move = shifted(pool, pool.concentration())
        pool.x[pool.fluid] += move[pool.fluid]
        pool.relist()
        spread.append(np.std(pool.ratio()[pool.fluid]))
    assert np.all(np.diff(spread) < 0.0) and spread[-1] < 0.3 * spread[0]


@dims
def test_shift_is_proportional_up_to_its_cap(dim):
    pool = block(dim, 5)
    gradient = 0.3 * np.random.default_rng(0).normal(size=(pool.n, dim)) / pool.spacing
    free_shift = shifted(pool, gradient, cap=1e9)
    np.testing.assert_allclose(free_shift, -0.3 * (H * pool.spacing) ** 2 * gradient, rtol=1e-13)
    capped = shifted(pool, gradient)
    length = np.linalg.norm(free_shift, axis=1)
    assert length.max() > 0.1 * pool.spacing > length.min()
    np.testing.assert_allclose(np.linalg.norm(capped, axis=1), np.minimum(length, 0.1 * pool.spacing), rtol=1e-13)
    direction = capped / np.linalg.norm(capped, axis=1)[:, None]
    np.testing.assert_allclose(direction, free_shift / length[:, None], rtol=1e-12)


@dims
def test_shift_is_zero_on_the_surface_and_tangential_near_it(dim):
    pool = tank((9, 9) if dim == 2 else (6, 6, 8))
    gradient = np.random.default_rng(1).normal(size=(pool.n, dim)) / pool.spacing
    surface_normal = np.random.default_rng(2).normal(size=dim)
    gradient[pool.role == SURFACE] = surface_normal
    out = shifted(pool, gradient, cap=1e9)
    assert np.all(out[pool.role != INNER] == 0.0)
    inner = pool.role == INNER
    near = inner & (pool.index[:, -1] == pool.top[-1] - 1)
    raw = -0.3 * (H * pool.spacing) ** 2 * gradient
    n = surface_normal / np.linalg.norm(surface_normal)
    np.testing.assert_allclose(out[near], raw[near] - np.outer(raw[near] @ n, n), atol=1e-13)
    far = inner & (pool.index[:, -1] < pool.top[-1] - 2)
    np.testing.assert_allclose(out[far], raw[far], rtol=1e-13)


def test_normal_is_the_weighted_mean_of_the_surface_particles():
    pool = block(2, 7)
    i, one, two = pool.at(3, 3), pool.at(4, 3), pool.at(3, 4)
    pool.x[two, 1] += 0.5 * pool.spacing
    pool.relist()
    pool.role[[one, two]] = SURFACE, BALLISTIC
    gradient = np.zeros((pool.n, 2))
    gradient[one], gradient[two], gradient[i] = [2.0, 0.0], [0.0, 1.0], [1.0, 1.0]
    out = shifted(pool, gradient, cap=1e9)[i]
    normal = np.array([2.0, 1.0 / 1.5**2])
    assert out @ normal == pytest.approx(0.0, abs=1e-15) and np.linalg.norm(out) > 0.0


@dims
def test_packing_is_level_below_a_level_surface_and_leaves_an_uneven_one(dim):
    pool = tank((9, 9) if dim == 2 else (6, 6, 8))
    inner, below = pool.role == INNER, pool.top[-1] - pool.index[:, -1]

    def levelled():
        move = np.ones((pool.n, dim))
        packing.level_off(move, pool.cloud, 2.1 * pool.spacing, 0.5 * pool.spacing)
        return move

    move = levelled()
    np.testing.assert_array_equal(move[inner, -1], below[inner] > 2)
    assert np.all(move[inner, :-1] == 1.0)
    raised = pool.at(*(4,) * (dim - 1), pool.top[-1])
    pool.x[raised, -1] += 0.6 * pool.spacing
    still = inner & (below == 1) & (np.linalg.norm(pool.x - pool.x[raised], axis=1) < 2.1 * pool.spacing)
    np.testing.assert_array_equal(levelled()[inner & (below == 1), 0], ~still[inner & (below == 1)])


@dims
def test_lengths_are_limited(dim):
    vector = np.random.default_rng(0).normal(size=(20, dim))
    before = vector.copy()
    vector[3] = before[3] = 0.0
    shifting.limit_lengths(vector, 15, 0.5, tuple(range(dim)))
    np.testing.assert_array_equal(vector[15:], before[15:])
    length = np.linalg.norm(before[:15], axis=1)
    np.testing.assert_allclose(np.linalg.norm(vector[:15], axis=1), np.minimum(length, 0.5), atol=1e-15)
    short = length < 0.5
    np.testing.assert_array_equal(vector[:15][short], before[:15][short])
