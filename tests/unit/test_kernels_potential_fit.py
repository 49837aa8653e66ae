"""The potential flow that a velocity is close to."""

import numpy as np

from parisph.base.fields import BALLISTIC, WALL, WET
from parisph.kernels import harmonic, monomials
from parisph.kernels.harmonic import Slopes
from parisph.kernels.potential_fit import Potential, fit_potential
from tests.pools import dims, harmonic_cubics, tank


def fit(pool, u):
    """Return beyond (n, dim) and gradient (n, dim, dim) of a velocity u (n, dim), known of walls across them."""
    found = Potential(*(np.full((pool.n,) + (pool.dim,) * rank, np.nan) for rank in (1, 2, 0)))
    known = (pool.kind == WALL) & (pool.corner == 0)
    across = np.where(known, (pool.normal * u).sum(axis=1), np.nan)
    u = np.where(pool.fluid[:, None], u, np.nan)
    fit_potential(found, pool.cloud, u, Slopes(across, known), 2.6 * pool.spacing)
    np.testing.assert_allclose(found.square, np.einsum("iab,iba->i", found.gradient, found.gradient), rtol=1e-12)
    return found.beyond, found.gradient


def jittered(dim):
    """Return a tank, which of it is fluid or wet wall, and which of that lies beside two walls (n,)."""
    pool = tank((8,) * dim if dim == 2 else (6,) * dim, jitter=0.4)
    near = (pool.index <= 1) | ((pool.index >= pool.top - 1) & (np.arange(dim) < dim - 1))
    return pool, pool.fluid | (pool.role == WET), near.sum(axis=1) > 1


@dims
def test_nothing_is_beyond_the_gradient_of_a_harmonic_cubic(dim):
    pool, seen, in_edge = jittered(dim)
    sure = seen if dim == 2 else pool.fluid | (seen & ~in_edge)    # walls in edges of a box may lack data for all terms
    for _, u, bends in harmonic_cubics(pool.x):
        beyond, found = fit(pool, u)
        np.testing.assert_allclose(beyond, 0.0, atol=1e-9)
        np.testing.assert_allclose(found[sure], bends[sure], atol=1e-7)
        assert np.all(found[~seen] == 0.0)


@dims
def test_walls_in_edges_know_the_gradient_of_a_harmonic_quadratic(dim):
    pool, seen, _ = jittered(dim)
    for a in range(dim - 1):
        u = np.zeros((pool.n, dim))
        u[:, a], u[:, a + 1] = 2.0 * pool.x[:, a], -2.0 * pool.x[:, a + 1]
        beyond, found = fit(pool, u)
        np.testing.assert_allclose(beyond, 0.0, atol=1e-9)
        np.testing.assert_allclose((found[seen]**2).sum(axis=(1, 2)), 8.0, rtol=1e-7)


@dims
def test_roughness_is_beyond_it(dim):
    """Most of what a single particle has, which its neighbours have not."""
    pool = tank((8,) * dim if dim == 2 else (6,) * dim)
    i = pool.at(*[4 if dim == 2 else 3] * dim)
    u = np.zeros((pool.n, dim))
    u[i, 0] = 1.0
    beyond = fit(pool, u)[0]
    assert beyond[i, 0] > 0.5 and np.abs(np.delete(beyond, i, axis=0)).max() < 0.5 * beyond[i, 0]


def test_a_vortex_is_beyond_it_beside_a_wall_only():
    """u = (y, 0) above the bed: inside, the fit does not see that the flow turns; a wall, which the flow follows, does.

    To take a part of it away brings the flow to rest there.
    """
    pool = tank((12, 12))
    u = np.stack([pool.x[:, 1], 0.0 * pool.x[:, 0]], axis=1)
    beyond = fit(pool, u)[0] / pool.spacing
    np.testing.assert_allclose(beyond[pool.far_inside(4)], 0.0, atol=1e-12)
    beside = beyond[pool.at(6, 1)]
    assert abs(beside[0]) > 0.05 and abs(beside[1]) < 1e-12


def test_free_flight_has_no_potential():
    pool = tank((8, 8))
    i = pool.at(4, 4)
    pool.role[i] = BALLISTIC
    beyond, found = fit(pool, np.random.default_rng(0).normal(size=(pool.n, 2)))
    assert np.all(beyond[i] == 0.0) and np.all(found[i] == 0.0) and np.all(beyond[~pool.fluid] == 0.0)


def test_moments_in_3d_are_those_of_a_column_for_each_component():
    rng = np.random.default_rng(3)
    near, v, w = rng.normal(size=(3, 8)), rng.normal(size=(3, 8)), rng.random(8)
    slopes = np.zeros((15, 24))
    for k in range(8):
        for axis in range(3):
            harmonic.fill_slopes(slopes, 8 * axis + k, tuple(near[:, k]), tuple(np.eye(3)[axis]), (0, 1, 2))
    for size in (15, 8):
        work, right = np.zeros((15, 18)), np.zeros(18)
        power, sums = np.empty((monomials.ROOM, 8)), np.empty((monomials.ROOM, 4))
        power[0] = w
        monomials.add_moments(work, right, power, sums, near, v, 8, size)
        used = slopes[:size]
        np.testing.assert_allclose(np.tril(work[:size, :size]), np.tril(used * np.tile(w, 3) @ used.T), atol=1e-10)
        np.testing.assert_allclose(right[:size], used @ (np.tile(w, 3) * v.ravel()), atol=1e-11)
        assert not work[size:].any() and not right[size:].any()
