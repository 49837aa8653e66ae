"""Films of one layer on a wall, against continuity."""

import numpy as np
import pytest

from parisph.base.fields import BALLISTIC, SURFACE
from parisph.kernels import films
from tests.pools import dims, free, tank

G, DT = 10.0, 0.5


def film(dim, layers=1):
    """A tank of one layer of fluid, one spacing above the bed, all surface, and which of it is far from the sides."""
    pool = tank((10,) * (dim - 1) + (layers,))
    pool.role[pool.fluid] = SURFACE
    inside = np.all((pool.index[:, :-1] > 3) & (pool.index[:, :-1] < 7), axis=1) & pool.fluid
    return pool, inside


def settled(pool, u, force=None, dt=DT):
    """Return the change of velocity (n, dim); walls slide with the fluid. force : (dim,), by default down."""
    change = np.full(pool.x.shape, np.nan)
    down = -G * np.eye(pool.dim)[-1] if force is None else np.asarray(force)
    u = np.where(pool.fluid[:, None] | (np.arange(pool.dim) < pool.dim - 1), u, 0.0)
    films.settle(change, pool.cloud, u, np.tile(down, (pool.n, 1)), 2.1 * pool.spacing, 0.05, dt)
    return change


@dims
def test_the_depth_obeys_continuity(dim):
    """dh/dt = -h div u, whatever the velocity across was; slow fluid, so that nothing is held back."""
    pool, inside = film(dim)
    rates = 1e-4 * np.arange(1.0, dim + 1.0)
    u = (pool.x - pool.x[inside].mean(axis=0)) * rates
    u[:, -1] = 1e-3
    found = (u + settled(pool, u))[inside]
    np.testing.assert_allclose(found[:, -1], -pool.spacing * rates[:-1].sum(), rtol=1e-5)
    np.testing.assert_allclose(found[:, :-1], u[inside, :-1])


@pytest.mark.parametrize(("layers", "u", "force"), [
    (1, (0.05, 0.0), None),    # moves along as a whole
    (1, (0.0, 1.0), (0.0, G)), (1, (0.0, 1.0), (G, 0.0)),    # below a wall, and beside it
    (2, (1.0, 1.0), None), (2, (1.0, 1.0, 1.0), None),    # no film
])
def test_what_keeps_its_depth_or_is_no_film_stays_as_it_is(layers, u, force):
    pool, inside = film(len(u), layers)
    assert np.abs(settled(pool, np.full(pool.x.shape, u), force)[inside]).max() < 1e-15


def test_no_more_than_the_force_can_do():
    pool, inside = film(2)
    change = settled(pool, np.full(pool.x.shape, [0.0, 3.0]), dt=0.01)
    np.testing.assert_allclose(change[inside], np.tile([0.0, -G * 0.01], (inside.sum(), 1)))


def test_films_that_flow_are_left_alone():
    """From CALM sqrt(f s) along the wall on; at half of that speed a quarter less is changed."""
    pool, inside = film(2)
    calm = films.CALM * np.sqrt(G * pool.spacing)
    for speed, left in ((0.5 * calm, 0.75), (1.01 * calm, 0.0), (20.0 * calm, 0.0)):
        change = settled(pool, np.full(pool.x.shape, [speed, 0.1]))[inside, 1]
        np.testing.assert_allclose(change, -0.1 * left)


def test_uneven_fluid_is_settled_as_far_as_it_is_a_layer():
    """Every second particle is lifted by .08 s; half of the change is left where det/(trace/2)^2 is half the floor."""
    pool, inside = film(2)
    pool.x[pool.fluid & (pool.index[:, 0] % 2 == 1), 1] += 0.08 * pool.spacing
    near, next_ = (1.0 - q * q * (6.0 - 8.0 * q + 3.0 * q * q) for q in np.array([np.hypot(1.0, 0.08), 2.0]) / 2.1)
    ratio = near * 0.08**2 / (near + 4.0 * next_)    # of the moments across and along the wall
    left = 1.0 - 4.0 * ratio / (1.0 + ratio) ** 2 / 0.05
    np.testing.assert_allclose(settled(pool, np.full(pool.x.shape, [0.0, 0.1]))[inside, 1], -0.1 * left)
    assert 0.4 < left < 0.6


def test_drops_and_fluid_without_walls_are_no_film():
    pool, _ = film(2)
    pool.role[pool.fluid] = BALLISTIC
    assert np.all(settled(pool, np.ones(pool.x.shape)) == 0.0)
    line = free([(k, 0) for k in range(8)])
    line.role[:] = SURFACE
    assert np.all(settled(line, np.ones(line.x.shape)) == 0.0)
