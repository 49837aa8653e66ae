"""Weakly compressible SPH: each equation, its conservation laws, and water at rest between ghost particles."""

import numpy as np
import pytest

from parisph.base.fields import FLUID, WALL
from parisph.kernels import weakly
from parisph.kernels.cells import neighbour_lists
from parisph.kernels.jit import axes_of
from parisph.kernels.smoothing import cubic_spline, cubic_spline_slope
from tests.pools import block

dims = pytest.mark.parametrize("dim", [2, 3])
RHO, SOUND, G = 1000.0, 30.0, 9.81


def lattice(dim, jitter=0.0, side=None, h=1.3):
    """Return (block, h [m], mass) of fluid without walls whose lists reach 2 h."""
    pool = block(dim, side or (11 if dim == 2 else 8), jitter, reach=2.0 * h)
    return pool, h * pool.spacing, np.full(pool.n, RHO * pool.spacing**dim)


def rate(pool, u, h, mass):
    out = np.full(pool.n, np.nan)
    weakly.density_rate(out, u, pool.x, mass, pool.kind, h, *pool.csr)
    return out


def accelerated(pool, u, p, rho, h, mass, omega=0.0, xi=0.0):
    out = np.full((pool.n, pool.dim), np.nan)
    weakly.acceleration(out, u, pool.x, p, rho, mass, pool.kind, h, SOUND, omega, xi, *pool.csr)
    return out


def smoothed(pool, u, rho, h, mass, epsilon):
    out = np.full((pool.n, pool.dim), np.nan)
    weakly.xsph_velocity(out, u, pool.x, rho, mass, pool.kind, h, epsilon, *pool.csr)
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
    pool, h, mass = lattice(dim, 0.6)
    spin = np.random.default_rng(0).normal(size=(dim, dim))
    assert np.abs(rate(pool, pool.x @ (spin - spin.T) + 3.0, h, mass)).max() < 1e-10 * RHO
    for width, within in ((1.3, 0.02), (1.8, 0.01)):
        pool, h, mass = lattice(dim, side=None if dim == 2 else 9, h=width)
        inside = pool.far_inside(int(2.0 * width + 1.0))
        np.testing.assert_allclose(rate(pool, pool.x * np.arange(1.0, dim + 1.0), h, mass)[inside],
                                   -RHO * dim * (dim + 1) / 2, rtol=within)


@dims
def test_momentum_and_energy_are_conserved(dim):
    """The work of the pressure forces is what the change of density takes up: an identity of Eqs. 6 and 7."""
    pool, h, mass = lattice(dim, 0.8)
    random = np.random.default_rng(1)
    u = random.normal(size=(pool.n, dim))
    rho = RHO * (0.95 + 0.1 * random.random(pool.n))
    p = random.normal(size=pool.n) * 1e4
    mass *= 0.5 + random.random(pool.n)
    plain, viscous = accelerated(pool, u, p, rho, h, mass), accelerated(pool, u, p, rho, h, mass, 0.3, 0.1)
    for out in (plain, viscous, smoothed(pool, u, rho, h, mass, 0.4) - u):
        np.testing.assert_allclose(mass @ out, 0.0, atol=1e-10 * np.abs(mass[:, None] * out).sum())
    work = mass @ (u * plain).sum(axis=1)
    assert work == pytest.approx(-mass @ (p / rho**2 * rate(pool, u, h, mass)), rel=1e-10)
    assert mass @ (u * (viscous - plain)).sum(axis=1) < 0.0
    moving = u + np.arange(1.0, dim + 1.0)
    np.testing.assert_allclose(accelerated(pool, moving, p, rho, h, mass, 0.3, 0.1), viscous, rtol=1e-9, atol=1e-8)
    np.testing.assert_allclose(rate(pool, moving, h, mass), rate(pool, u, h, mass), rtol=1e-9, atol=1e-8)


def test_viscosity_of_a_pair():
    """Eq. 8 by hand, and nothing between particles that part."""
    pool, h = block(2, 2, reach=2.6), 0.13
    pool.x = np.array([[0.0, 0.0], [0.09, 0.0], [5.0, 0.0], [9.0, 0.0]])
    pool.relist()
    mass, rho, none = np.full(4, 10.0), np.array([1000.0, 1010.0, 1.0, 1.0]), np.zeros(4)
    u = np.array([[1.0, 0.5], [-1.0, 0.0], [0.0, 0.0], [0.0, 0.0]])
    mu = h * (2.0 * -0.09) / (0.09**2 + 0.01 * h**2)
    size = (-0.3 * SOUND * mu + 0.2 * mu**2) / 1005.0
    expected = -10.0 * size * cubic_spline_slope(0.09, h, 2) * -0.09
    out = accelerated(pool, u, none, rho, h, mass, 0.3, 0.2)
    np.testing.assert_allclose(out[0], [expected, 0.0], rtol=1e-13)
    assert out[0, 0] < 0.0 and out[1, 0] == -out[0, 0]
    assert np.all(accelerated(pool, -u, none, rho, h, mass, 0.3, 0.2) == 0.0)
    change = smoothed(pool, u, rho, h, mass, 0.01)[0] - u[0]
    np.testing.assert_allclose(change, -0.01 * 10.0 / 1005.0 * cubic_spline(0.09, h, 2) * np.array([2.0, 0.5]),
                               rtol=1e-12)


# -- at rest between ghost particles ---------------------------------------------------------------------


class Basin:
    """Water on a lattice in a basin with two layers of ghost particles behind its walls."""

    def __init__(self, dim, wide, deep, h, spacing=0.1):
        ranges = [np.arange(-2, wide + 3)] * (dim - 1) + [np.arange(-2, deep + 3)]
        index = np.stack(np.meshgrid(*ranges, indexing="ij"), axis=-1).reshape(-1, dim)
        between = np.all((index[:, :-1] > 0) & (index[:, :-1] < wide), axis=1)
        index = index[~between | (index[:, -1] <= deep)]
        between = np.all((index[:, :-1] > 0) & (index[:, :-1] < wide), axis=1)
        self.fluid = between & (index[:, -1] > 0)
        self.kind = np.where(self.fluid, FLUID, WALL).astype(np.int8)
        self.x, self.h, self.index, self.dim = spacing * index, h * spacing, index, dim
        self.n, self.axes = len(index), axes_of(dim)
        self.mass = np.full(self.n, RHO * spacing**dim)
        self.level = (deep + 0.5) * spacing
        self.indptr, self.indices = neighbour_lists(self.x, self.n, 2.0 * self.h)

    @property
    def csr(self):
        return self.indptr, self.indices, self.axes

    def wall_pressure(self, p, force, wall_force=None):
        out = np.where(self.fluid, p, np.nan)
        wall_force = np.zeros_like(self.x) if wall_force is None else wall_force
        weakly.wall_pressure(out, self.x, p, np.full(self.n, RHO), force, wall_force, self.kind, self.h, *self.csr)
        return out

    def touched(self):
        """Return which walls have fluid within the kernel's reach, (n,)."""
        rows = np.repeat(np.arange(self.n), np.diff(self.indptr))
        return ~self.fluid & (np.bincount(rows, self.fluid[self.indices], minlength=self.n) > 0)


@dims
@pytest.mark.parametrize("h", [1.3, 1.8])
def test_water_at_rest_stays_at_rest(dim, h):
    basin = Basin(dim, 8 if dim == 2 else 6, 10, h)
    force = np.zeros_like(basin.x)
    force[:, -1] = -G
    exact = RHO * G * (basin.level - basin.x[:, -1])
    p = basin.wall_pressure(np.where(basin.fluid, exact, 0.0), force)
    touched = basin.touched()
    np.testing.assert_allclose(p[touched], np.maximum(exact[touched], 0.0), atol=1e-9 * RHO * G)
    out = np.empty_like(basin.x)
    weakly.acceleration(out, np.zeros_like(out), basin.x, p, np.full(basin.n, RHO), basin.mass,
                        basin.kind, basin.h, SOUND, 0.3, 0.0, *basin.csr)
    deep = basin.fluid & (basin.index[:, -1] <= 6)
    assert np.abs((out + force)[deep]).max() < 0.015 * G
    assert np.abs((out + force)[basin.fluid]).max() < 0.25 * G, "at the surface, where half of the support is missing"


def test_pressure_of_walls_in_a_tank_that_is_pushed():
    """In the frame of the room, walls that accelerate with the water feel g - a."""
    basin, a = Basin(2, 8, 10, 1.8), np.array([2.0, 0.0])
    force = np.tile([0.0, -G], (basin.n, 1))
    exact = 1e5 + RHO * basin.x @ (np.array([0.0, -G]) - a)
    p = basin.wall_pressure(np.where(basin.fluid, exact, 0.0), force, np.tile(a, (basin.n, 1)))
    touched = basin.touched()
    np.testing.assert_allclose(p[touched], exact[touched], rtol=1e-12)


def test_steps_of_the_longest_length_keep_water_still():
    basin = Basin(2, 8, 8, 1.8)
    wet, force = basin.fluid, np.tile([0.0, -G], (basin.n, 1))
    u, x = np.zeros_like(basin.x), basin.x
    rho = np.full(basin.n, RHO)
    rho[wet] = weakly.tait_density(RHO * G * (basin.level - x[wet, 1]), SOUND, RHO)
    dt = weakly.longest_step(basin.h, SOUND, 0.0, 0.3, G)
    change, push = np.empty(basin.n), np.empty_like(u)
    for _ in range(int(1.0 / dt)):
        p = basin.wall_pressure(np.where(wet, weakly.tait_pressure(rho, SOUND, RHO), 0.0), force)
        rho[~wet] = weakly.tait_density(p[~wet], SOUND, RHO)
        weakly.acceleration(push, u, x, p, rho, basin.mass, basin.kind, basin.h, SOUND, 0.3, 0.0, *basin.csr)
        u[wet] += dt * (push + force)[wet]
        x[wet] += dt * u[wet]
        weakly.density_rate(change, u, x, basin.mass, basin.kind, basin.h, *basin.csr)
        rho[wet] += dt * change[wet]
    basin.indptr, basin.indices = neighbour_lists(x, basin.n, 2.0 * basin.h)
    deep = wet & (basin.index[:, 1] <= 5)
    np.testing.assert_allclose(weakly.tait_pressure(rho, SOUND, RHO)[deep], RHO * G * (basin.level - x[deep, 1]),
                               atol=0.1 * RHO * G * basin.level)
    assert np.abs(u[wet]).max() < 0.02 * np.sqrt(G * basin.level)
