"""Position projection's source, concentration gradient and Fick shift."""

import numpy as np
import pytest

from parisph.base.fields import BALLISTIC, INNER, SURFACE, WALL
from parisph.kernels import shifting, surface
from tests.pools import block, tank

dims = pytest.mark.parametrize("dim", [2, 3])
H, LIMIT, REACH = 1.3, 0.1, 2.6


def concentration(pool):
    h = H * pool.spacing
    out = np.full((pool.n, pool.dim), np.nan)
    shifting.concentration(np.empty(pool.n), out, *pool.walls, h, surface.lattice_sum(pool.spacing, h, pool.axes),
                           *pool.csr)
    return out


def ratio(pool):
    h = H * pool.spacing
    alpha = np.empty(pool.n)
    surface.density_ratio(alpha, *pool.walls, h, surface.lattice_sum(pool.spacing, h, pool.axes), *pool.csr)
    return alpha


@dims
def test_the_density_ratio_is_that_by_which_the_surface_is_found(dim):
    pool = tank((6,) * dim if dim == 2 else (4,) * dim, jitter=0.6)
    h = H * pool.spacing
    alpha, gradient = np.full(pool.n, np.nan), np.full((pool.n, dim), np.nan)
    shifting.concentration(alpha, gradient, *pool.walls, h, surface.lattice_sum(pool.spacing, h, pool.axes), *pool.csr)
    np.testing.assert_allclose(alpha, ratio(pool), rtol=1e-13)


def shifted(pool, gradient, strength=0.3, cap=0.1, reach=2.0):
    out = np.full((pool.n, pool.dim), np.nan)
    shifting.fick_shift(out, pool.cloud, gradient, np.full(pool.n, strength * (H * pool.spacing) ** 2),
                        cap * pool.spacing, reach * pool.spacing)
    return out


# -- concentration gradient -------------------------------------------------------------------------


@dims
@pytest.mark.parametrize("lid", [False, True])
def test_no_gradient_on_a_lattice_at_walls_and_in_corners(dim, lid):
    pool = tank((12, 12) if dim == 2 else (9, 9, 9), lid)
    gradient = concentration(pool)
    full = pool.fluid & (lid | (pool.index[:, -1] <= pool.top[-1] - 3))
    assert full[pool.at(*[1] * dim)]
    np.testing.assert_allclose(pool.spacing * gradient[full], 0.0, atol=1e-13)
    assert np.all(gradient[~pool.fluid] == 0.0)


@dims
def test_gradient_at_the_surface_points_into_the_fluid(dim):
    pool = tank((12, 12) if dim == 2 else (9, 9, 9))
    gradient = pool.spacing * concentration(pool)
    top = pool.fluid & (pool.index[:, -1] == pool.top[-1])
    far = top & np.all((pool.index[:, :-1] > 2) & (pool.index[:, :-1] < pool.top[:-1] - 2), axis=1)
    assert np.all(gradient[top, -1] < -0.1)
    np.testing.assert_allclose(gradient[far, :-1], 0.0, atol=1e-13)


@dims
def test_gradient_is_the_derivative_of_the_density_ratio(dim):
    pool = tank((9, 9) if dim == 2 else (7, 7, 7), jitter=0.8)
    gradient = concentration(pool)
    d = 1e-6 * pool.spacing
    for index in ([1] * dim, [4] * (dim - 1) + [1], [3] * dim, [4] * (dim - 1) + [pool.top[-1]]):
        i = pool.at(*index)
        for a in range(dim):
            found = []
            for sign in (1, -1):
                pool.x[i, a] += sign * d
                found.append(ratio(pool)[i])
                pool.x[i, a] -= sign * d
            difference = (found[0] - found[1]) / (2.0 * d)
            # the particle's own images move with it: they are a part of the environment here
            own = own_images(pool, i, a)
            assert gradient[i, a] == pytest.approx(difference - own, abs=1e-5 / pool.spacing)


def own_images(pool, i, a):
    """Return by how much the density at i changes because its own images in the walls follow it along axis a."""
    near = pool.indices[pool.indptr[i]:pool.indptr[i + 1]]
    h = H * pool.spacing
    full = surface.lattice_sum(pool.spacing, h, pool.axes)
    keep = np.concatenate([[i], near[pool.kind[near] == WALL]])
    indptr = np.array([0, len(keep) - 1], np.int32)
    arrays = (pool.x[keep], pool.kind[keep], pool.corner[keep], pool.normal[keep])
    arguments = (h, full, indptr, np.arange(1, len(keep), dtype=np.int32), pool.axes)
    d, values = 1e-6 * pool.spacing, []
    for sign in (1, -1):
        moved = arrays[0].copy()
        moved[0, a] += sign * d
        alpha = np.empty(1)
        surface.density_ratio(alpha, moved, *arrays[1:], *arguments)
        values.append(alpha[0])
    frozen = np.empty((1, pool.dim))
    shifting.concentration(np.empty(1), frozen, *arrays, *arguments)
    return (values[0] - values[1]) / (2.0 * d) - frozen[0, a]


# -- what the position projection corrects ------------------------------------------------------------


def error(pool, alpha, doubt=0.0, surplus=0.0, rapid=0.0):
    e = np.full(pool.n, np.nan)
    surplus, rapid, doubt = (np.full(pool.n, value) for value in (surplus, rapid, doubt))
    shifting.compression(e, pool.cloud, alpha, surplus, rapid, doubt, LIMIT, REACH * pool.spacing)
    return e


@dims
def test_density_error_is_clipped(dim):
    pool = block(dim, 5)
    for alpha, expected in ((1.0, 0.0), (1.03, 0.03), (0.95, -0.05), (1.7, 0.1), (0.2, -0.1)):
        np.testing.assert_allclose(error(pool, np.full(pool.n, alpha)), expected, atol=1e-15)


@dims
def test_density_error_near_the_surface_is_one_sided(dim):
    pool = tank((9, 9) if dim == 2 else (6, 6, 8))
    top, inner = pool.top[-1], pool.role == INNER
    near = inner & (pool.index[:, -1] > top - REACH)
    thin, thick = error(pool, np.full(pool.n, 0.96)), error(pool, np.full(pool.n, 1.04))
    np.testing.assert_allclose(thin[near], 0.0)
    np.testing.assert_allclose(thin[inner & ~near], -0.04, rtol=1e-12)
    np.testing.assert_allclose(thick[inner], 0.04, rtol=1e-12)
    assert np.all(thin[~inner] == 0.0) and np.all(thick[~inner] == 0.0)


@dims
def test_near_the_surface_only_what_exceeds_the_doubt_is_compression(dim):
    pool = tank((9, 9) if dim == 2 else (6, 6, 8))
    inner = pool.role == INNER
    near = inner & (pool.index[:, -1] > pool.top[-1] - REACH)
    for alpha, expected in ((0.96, 0.0), (1.02, 0.0), (1.05, 0.02), (1.7, 0.07)):
        e = error(pool, np.full(pool.n, alpha), doubt=0.03)
        np.testing.assert_allclose(e[near], expected, atol=1e-12)
        np.testing.assert_allclose(e[inner & ~near], np.clip(alpha - 1.0, -LIMIT, LIMIT), rtol=1e-12)


@dims
def test_rapid_fluid_is_not_pushed_by_a_surplus(dim):
    """Of alpha - 1 = .04 and a surplus of .03 or .06 less is left, but it does not attract."""
    pool = tank((9, 9) if dim == 2 else (6, 6, 8))
    inner = pool.role == INNER
    near = inner & (pool.index[:, -1] > pool.top[-1] - REACH)
    for surplus, rapid, left in ((0.03, 1.0, 0.01), (0.06, 1.0, 0.0), (0.03, 0.5, 0.025), (0.03, 0.0, 0.04)):
        e = error(pool, np.full(pool.n, 1.04), surplus=surplus, rapid=rapid)
        np.testing.assert_allclose(e[inner], left, atol=1e-12)
    thin = error(pool, np.full(pool.n, 0.96), surplus=0.03, rapid=1.0)    # a void stays one
    np.testing.assert_allclose(thin[inner & ~near], -0.04, atol=1e-12)
    doubted = error(pool, np.full(pool.n, 1.04), doubt=0.02, surplus=0.01, rapid=1.0)
    np.testing.assert_allclose(doubted[near], 0.01, atol=1e-12)


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
    out = shifted(pool, concentration(pool))
    assert out[i, 0] > 0.0 and np.all(np.abs(out[i, 1:]) < 1e-12 + 1e-9 * out[i, 0])


@dims
def test_shift_evens_out_disorder(dim):
    pool = tank((12, 12) if dim == 2 else (8, 8, 8), lid=True, jitter=0.8)
    spread = [np.std(ratio(pool)[pool.fluid])]
    for _ in range(10):
        move = shifted(pool, concentration(pool))
        pool.x[pool.fluid] += move[pool.fluid]
        pool.relist()
        spread.append(np.std(ratio(pool)[pool.fluid]))
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
