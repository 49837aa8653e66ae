"""Weakly compressible SPH: each equation, its conservation laws, and water at rest in a basin."""

import numpy as np
import pytest

from parisph.kernels import weakly
from parisph.kernels.smoothing import cubic_spline, cubic_spline_slope
from tests.pools import block, dims, tank

RHO, SOUND, G = 1000.0, 30.0, 9.81


def lattice(dim, jitter=0.0, side=None, h=1.3):
    """Return fluid without walls whose lists reach 2 h, and h [m]."""
    pool = block(dim, side or (11 if dim == 2 else 8), jitter, reach=2.0 * h)
    return pool, h * pool.spacing


def state(pool, u, h, p=0.0, rho=RHO, force=0.0, mass=None):
    p, rho = (np.broadcast_to(values, pool.n) + 0.0 for values in (p, rho))
    return weakly.State(u, p, rho, force + np.zeros_like(u), RHO * pool.spacing**pool.dim if mass is None else mass, h)


def rate(pool, own):
    out = np.full(pool.n, np.nan)
    weakly.density_rate(out, pool.cloud, pool.walls, own)
    return out


def accelerated(pool, own, omega=0.0):
    out = np.full((pool.n, pool.dim), np.nan)
    weakly.acceleration(out, pool.cloud, pool.walls, own, SOUND, omega)
    return out


def smoothed(pool, own, epsilon):
    out = np.full((pool.n, pool.dim), np.nan)
    weakly.xsph_velocity(out, pool.cloud, own, epsilon)
    return out


# -- equation of state and step --------------------------------------------------------------------------


@pytest.mark.parametrize(("pressure", "density"), [(weakly.tait_pressure, weakly.tait_density),
                                                   (weakly.linear_pressure, weakly.linear_density)])
def test_equations_of_state(pressure, density):
    rho = RHO * np.linspace(0.97, 1.05, 9)
    np.testing.assert_allclose(density(pressure(rho, SOUND, RHO), SOUND, RHO), rho, rtol=1e-13)
    slope = (pressure(RHO + 1e-3, SOUND, RHO) - pressure(RHO - 1e-3, SOUND, RHO)) / 2e-3
    assert pressure(RHO, SOUND, RHO) == 0.0 and slope == pytest.approx(SOUND**2, rel=1e-6)


def test_density_stays_positive_under_any_tension():
    assert 0.5 * RHO < weakly.tait_density(-1e9, SOUND, RHO) < RHO


def test_limits_of_the_step():
    assert weakly.longest_step(0.1, 9.0, 1.0, 0.0, 0.0) == pytest.approx(0.004)
    assert weakly.longest_step(0.1, 10.0, 0.0, 0.5, 0.0) == pytest.approx(0.04 / 13.0)
    assert weakly.longest_step(0.1, 1.0, 0.0, 0.0, 1e4) == pytest.approx(0.25 * np.sqrt(1e-5))


# -- the sums ----------------------------------------------------------------------------------------------


@dims
def test_density_answers_divergence_only(dim):
    pool, h = lattice(dim, 0.6)
    spin = np.random.default_rng(0).normal(size=(dim, dim))
    assert np.abs(rate(pool, state(pool, pool.x @ (spin - spin.T) + 3.0, h))).max() < 1e-10 * RHO
    for width, within in ((1.3, 0.02), (1.8, 0.01)):
        pool, h = lattice(dim, side=None if dim == 2 else 9, h=width)
        inside = pool.far_inside(int(2.0 * width + 1.0))
        np.testing.assert_allclose(rate(pool, state(pool, pool.x * np.arange(1.0, dim + 1.0), h))[inside],
                                   -RHO * dim * (dim + 1) / 2, rtol=within)


@dims
def test_momentum_and_energy_are_conserved(dim):
    """The work of the pressure forces is what the change of density takes up: an identity of Eqs. 6 and 7."""
    pool, h = lattice(dim, 0.8)
    random = np.random.default_rng(1)
    u, rho = random.normal(size=(pool.n, dim)), RHO * (0.95 + 0.1 * random.random(pool.n))
    p = random.normal(size=pool.n) * 1e4
    own, moving = state(pool, u, h, p, rho), state(pool, u + np.arange(1.0, dim + 1.0), h, p, rho)
    plain, viscous = accelerated(pool, own), accelerated(pool, own, 0.3)
    for out in (plain, viscous, smoothed(pool, own, 0.4) - u):
        np.testing.assert_allclose(out.sum(axis=0), 0.0, atol=1e-10 * np.abs(out).sum())
    assert (u * plain).sum() == pytest.approx(-(p / rho**2) @ rate(pool, own), rel=1e-10)
    assert (u * (viscous - plain)).sum() < 0.0
    np.testing.assert_allclose(accelerated(pool, moving, 0.3), viscous, rtol=1e-9, atol=1e-8)
    np.testing.assert_allclose(rate(pool, moving), rate(pool, own), rtol=1e-9, atol=1e-8)


def test_viscosity_of_a_pair():
    """Eq. 8 by hand, and nothing between particles that part."""
    pool, h = block(2, 2, reach=2.6), 0.13
    pool.x = np.array([[0.0, 0.0], [0.09, 0.0], [5.0, 0.0], [9.0, 0.0]])
    pool.relist()
    rho = np.array([1000.0, 1010.0, 1.0, 1.0])
    u = np.array([[1.0, 0.5], [-1.0, 0.0], [0.0, 0.0], [0.0, 0.0]])
    mu = h * (2.0 * -0.09) / (0.09**2 + 0.01 * h**2)
    expected = -10.0 * -0.3 * SOUND * mu / 1005.0 * cubic_spline_slope(0.09, h, 2) * -0.09
    own = state(pool, u, h, rho=rho, mass=10.0)
    out = accelerated(pool, own, 0.3)
    np.testing.assert_allclose(out[0], [expected, 0.0], rtol=1e-13)
    assert out[0, 0] < 0.0 and out[1, 0] == -out[0, 0]
    assert np.all(accelerated(pool, own._replace(u=-u), 0.3) == 0.0)
    change = smoothed(pool, own, 0.01)[0] - u[0]
    np.testing.assert_allclose(change, -0.01 * 10.0 / 1005.0 * cubic_spline(0.09, h, 2) * np.array([2.0, 0.5]),
                               rtol=1e-12)


# -- at rest in a basin ----------------------------------------------------------------------------------


def basin(dim, wide, deep, h):
    """Return an open tank of water whose lists reach 2 h, its level [m], and the force of gravity (n, dim)."""
    pool = tank((wide,) * (dim - 1) + (deep,), reach=2.0 * h)
    force = np.zeros_like(pool.x)
    force[:, -1] = -G
    return pool, (deep + 0.5) * pool.spacing, force


def wall_pressure(pool, own):
    out = np.where(pool.fluid, own.p, np.nan)
    weakly.wall_pressure(out, pool.cloud, own)
    return out


@dims
@pytest.mark.parametrize("h", [1.3, 1.8])
def test_water_at_rest_stays_at_rest(dim, h):
    pool, level, force = basin(dim, 8 if dim == 2 else 6, 10, h)
    exact = RHO * G * (level - pool.x[:, -1])
    own = state(pool, np.zeros_like(pool.x), h * pool.spacing, np.where(pool.fluid, exact, 0.0), force=force)
    p = wall_pressure(pool, own)
    np.testing.assert_allclose(p[~pool.fluid], exact[~pool.fluid], atol=1e-9 * RHO * G)
    out = accelerated(pool, own._replace(p=p), 0.3)
    deep = pool.fluid & (pool.index[:, -1] <= 6)
    assert np.abs((out + force)[deep]).max() < 0.015 * G
    assert np.abs((out + force)[pool.fluid]).max() < 0.25 * G, "at the surface, where half of the support is missing"


@dims
def test_a_lid_does_not_pull_at_fluid_without_pressure(dim):
    """Still fluid at a reflection in the lid would have a negative pressure, in the bed a positive one."""
    pool = tank((6,) * (dim - 1) + (9,), lid=True)
    force = np.tile(-G * np.eye(dim)[-1], (pool.n, 1))
    out = accelerated(pool, state(pool, np.zeros_like(pool.x), 1.3 * pool.spacing, force=force))
    layer = pool.index[:, -1]
    assert np.all(out[pool.fluid & (layer > 4)] == 0.0) and np.all(out[pool.fluid & (layer == 1), -1] > 0.0)


def test_steps_of_the_longest_length_keep_water_still():
    pool, level, force = basin(2, 8, 8, 1.8)
    wet, h = pool.fluid, 1.8 * pool.spacing
    u, rho = np.zeros_like(pool.x), np.full(pool.n, RHO)
    rho[wet] = weakly.tait_density(RHO * G * (level - pool.x[wet, 1]), SOUND, RHO)
    dt = weakly.longest_step(h, SOUND, 0.0, 0.3, G)
    for _ in range(int(1.0 / dt)):
        own = state(pool, u, h, np.where(wet, weakly.tait_pressure(rho, SOUND, RHO), 0.0), rho, force)
        p = wall_pressure(pool, own)
        rho[~wet] = weakly.tait_density(p[~wet], SOUND, RHO)
        u[wet] += dt * (accelerated(pool, own._replace(p=p, rho=rho), 0.3) + force)[wet]
        pool.x[wet] += dt * u[wet]
        rho[wet] += dt * rate(pool, own._replace(u=u))[wet]
    deep = wet & (pool.index[:, 1] <= 5)
    np.testing.assert_allclose(weakly.tait_pressure(rho, SOUND, RHO)[deep], RHO * G * (level - pool.x[deep, 1]),
                               atol=0.1 * RHO * G * level)
    assert np.abs(u[wet]).max() < 0.02 * np.sqrt(G * level)
