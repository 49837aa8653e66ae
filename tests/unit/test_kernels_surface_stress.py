"""The free surface of viscous fluid: no stress on it, against exact fields."""

import numpy as np
import pytest

from parisph.base.fields import ABSENT, FLUID, SURFACE, WALL
from parisph.kernels import surface_stress, viscous
from tests.pools import block, dims, tank

jitters = pytest.mark.parametrize("jitter", [0.0, 0.6])
H, RADIUS = 1.3, 2.6


def found(pool, u, nu=1.0, no_slip=0):
    """Return the acceleration (n, dim) and the tension (n,)."""
    s, out, tension = pool.spacing, np.full((pool.n, pool.dim), np.nan), np.full(pool.n, np.nan)
    slip = ((pool.kind == WALL) * np.asarray(no_slip)).astype(np.int8)
    records = pool.cloud, pool.walls_with(u, slip), viscous.Flowing(u, np.broadcast_to(nu, pool.n) + 0.0, slip)
    viscous.corrected(out, *records, RADIUS * s, H * s)
    surface_stress.stress_free(out, tension, *records, RADIUS * s)
    return out, tension


def below(dim, jitter, seed=0):
    """Return a tank of disordered fluid below a flat surface at the height 0, and its particles of the surface."""
    pool = tank((9, 7) if dim == 2 else (7, 7, 6), jitter=jitter, spacing=1.0, seed=seed)
    pool.x[:, -1] -= pool.top[-1]
    return pool, pool.fluid & (pool.index[:, -1] == pool.top[-1])


@dims
@jitters
def test_a_drop_that_turns_as_one_body_feels_nothing(dim, jitter):
    """But for some ill-supported particles, 8 of 48 in 2D, which keep the form of Morris: that brakes the drop."""
    pool = block(dim, 13 if dim == 2 else 11, jitter, spacing=1.0)
    size = pool.top[0] / 2
    distance = np.linalg.norm(pool.index - size, axis=1)
    pool.kind[distance > size + 0.5] = ABSENT
    pool.role[distance > size - 0.7] = SURFACE
    drop, top = pool.kind == FLUID, (pool.kind == FLUID) & (pool.role == SURFACE)
    random = np.random.default_rng(6).normal(size=(dim, dim))
    u = pool.x @ (random - random.T) + 3.0
    out, tension = found(pool, u)
    felt = np.abs(out).max(axis=1) > 1e-10
    assert not np.any(felt[drop & ~top]) and felt[top].mean() <= (0.17 if jitter else 0.0)
    np.testing.assert_allclose(tension, 0.0, atol=1e-9)
    flowing = viscous.Flowing(u, np.ones(pool.n), np.zeros(pool.n, np.int8))
    viscous.morris(out, pool.cloud, pool.walls, flowing, H)
    assert np.all(np.abs(out[top]).max(axis=1) > 0.1)


@dims
@jitters
def test_linear_velocities_without_shear_at_the_surface(dim, jitter):
    """Nothing acts, and pressure balances the stress along the normal."""
    pool, top = below(dim, jitter)
    g = np.random.default_rng(7).normal(size=(dim, dim))
    g[-1, :-1] = -g[:-1, -1]
    g[-1, -1] = -np.trace(g[:-1, :-1])
    out, tension = found(pool, pool.x @ g.T, nu=0.3, no_slip=1)
    np.testing.assert_allclose(out[top], 0.0, atol=1e-10)
    np.testing.assert_allclose(tension[top], 0.6 * g[-1, -1], rtol=1e-8)
    assert np.all(tension[~top] == 0.0)


@dims
@jitters
def test_quadratic_velocities_without_shear_at_the_surface(dim, jitter):
    pool, top = below(dim, jitter)
    x, y = pool.x[:, 0], pool.x[:, -1]
    for along, up, laplacian, rise in ((y**2, 0.0 * y, 2.0, 0.0 * x), (x**2, -2.0 * x * y, 2.0, -2.0 * x)):
        u = np.zeros((pool.n, dim))
        u[:, 0], u[:, -1] = along, up
        out, tension = found(pool, u, no_slip=1)
        np.testing.assert_allclose(out[top, 0], laplacian, rtol=1e-8)
        np.testing.assert_allclose(out[top, 1:], 0.0, atol=1e-8)
        np.testing.assert_allclose(tension[top], 2.0 * rise[top], atol=1e-8)


@dims
def test_shear_is_stopped_by_a_surface(dim):
    """By about its flux over the half cell of the surface, -g/(s/2); the fit reaches more than one layer down."""
    pool, top = below(dim, 0.0)
    inside = top & np.all((pool.index[:, :-1] > 2) & (pool.index[:, :-1] < pool.top[:-1] - 2), axis=1)
    u = np.zeros((pool.n, dim))
    u[:, 0] = pool.x[:, -1]
    out, tension = found(pool, u, no_slip=1)
    assert inside.any() and np.all((out[inside, 0] < -1.2) & (out[inside, 0] > -2.2))
    np.testing.assert_allclose(out[inside, 1:], 0.0, atol=1e-10)
    np.testing.assert_allclose(tension[inside], 0.0, atol=1e-10)


def test_ill_supported_particles_keep_what_they_have():
    """A row of particles gives no slope across it."""
    pool = block(2, 7, spacing=1.0)
    pool.kind[pool.index[:, 1] != 3] = ABSENT
    pool.role[:] = SURFACE
    out, tension = np.full((pool.n, 2), 5.0), np.full(pool.n, 5.0)
    flowing = viscous.Flowing(pool.x.copy(), np.ones(pool.n), np.zeros(pool.n, np.int8))
    surface_stress.stress_free(out, tension, pool.cloud, pool.walls, flowing, RADIUS)
    assert np.all(out == 5.0) and np.all(tension == 0.0)


@pytest.mark.parametrize(("no_slip", "jitter"), [(0, 0.0), (1, 0.0), (1, 1.2)])
def test_explicit_steps_of_the_stable_length(no_slip, jitter):
    """Both components together, because the condition couples them.

    Free-slip walls on the lattice only: reflections of particles too close to one make modes that grow with any form.
    """
    for seed in range(3):
        pool, top = below(2, jitter, seed)
        pool.x[top] += 0.8 * jitter * (np.random.default_rng(99 + seed).random((top.sum(), 2)) - 0.5)
        pool.relist()
        fluid, columns = np.flatnonzero(pool.fluid), []
        for j in fluid:
            for component in range(2):
                u = np.zeros((pool.n, 2))
                u[j, component] = 1.0
                columns.append(found(pool, u, no_slip=no_slip)[0][fluid].ravel())
        assert np.abs(1.0 + viscous.STABLE * np.linalg.eigvals(np.transpose(columns))).max() < 1.0
