"""The friction of walls: the law itself, and what it does to the fluid beside them."""

import math

import numpy as np
import pytest

from parisph import Box, Obstacle, Tank
from parisph.base.fields import FLUID
from parisph.case.bodies import StillWater
from parisph.kernels.records import cloud_of
from parisph.kernels.wall_law import Law, rub, wall_stress
from tests.pools import dims, elements_near, tank
from tests.wall_scenes import filled

NU = 1e-6


def wall_units(speed, y, nu=NU, roughness=0.0):
    """Return u+ and y+ (y over the roughness, with one) by the stress that the law gives."""
    shear = math.sqrt(wall_stress(speed, y, nu, roughness))
    return speed / shear, y / roughness if roughness else y * shear / nu


@pytest.mark.parametrize("speed", [0.001, 0.003, 0.01, 0.05, 0.3, 1.0, 10.0])
def test_close_to_a_wall_the_stress_is_viscous_and_farther_off_the_velocity_a_power_of_the_distance(speed):
    u, y = wall_units(speed, 0.005)
    assert (y < 11.8) == (speed < 0.03) and u == pytest.approx(y if y < 11.8 else 8.3 * y ** (1.0 / 7.0), rel=1e-12)


def test_the_two_laws_meet():
    speed = 11.81**2 * NU / 0.005    # u+ y+ = u y / nu
    below, above = (wall_stress(f * speed, 0.005, NU, 0.0) / f**2 for f in (0.999, 1.001))
    assert below == pytest.approx(above, rel=3e-3)


@pytest.mark.parametrize("reynolds, ratio", [(2e4, 1.0), (5e6, 0.6)])    # y+ = 1e3 and 1.3e5
def test_the_power_law_is_that_of_a_logarithm_to_the_accuracy_that_is_promised(reynolds, ratio):
    """u+ = ln(y+)/.41 + 5.1 by iteration; the docstring of Friction says how far apart the laws are."""
    y, speed, shear = 1.0, 1.0, 0.03
    nu = speed * y / reynolds
    for _ in range(100):
        shear = speed / (math.log(y * shear / nu) / 0.41 + 5.1)
    assert wall_stress(speed, y, nu, 0.0) / shear**2 == pytest.approx(ratio, abs=0.1)


def test_roughness_has_the_logarithm_of_nikuradse_where_it_gives_more():
    u, y = wall_units(2.0, 0.05, roughness=0.002)
    assert u == pytest.approx(math.log(y) / 0.41 + 8.5, rel=1e-12)
    assert wall_stress(2.0, 0.05, NU, 1e-9) == wall_stress(2.0, 0.05, NU, 0.0)
    assert wall_stress(2.0, 0.05, 0.0, 0.0) == 0.0
    inside, at = (wall_stress(2.0, y, 0.0, 0.002) for y in (0.0005, 0.002))
    assert inside == at == pytest.approx((2.0 / 8.5) ** 2)


def rubbed(pool, u, wall_u=0.0, no_slip=False, volume=None, dt=0.0, nu=NU, roughness=0.0):
    """Return the acceleration (n, dim) of the particles of a Pool."""
    out, cloud = np.zeros((pool.n, pool.dim)), pool.cloud
    walls = pool.walls._replace(velocity=wall_u + np.zeros((len(pool.nodes), pool.dim)),
                                sticks=np.full(len(pool.nodes), no_slip))
    rub(out, cloud if volume is None else cloud._replace(volume=volume), walls, u, Law(nu, roughness, dt))
    return out


@dims
def test_the_layer_beside_a_wall_gets_the_stress_on_it(dim):
    pool = tank((8,) * dim, lid=True, spacing=0.1)
    u = np.zeros((pool.n, dim))
    u[:, 0] = 2.0
    out, up = rubbed(pool, u), pool.index[:, -1]
    middle = pool.fluid & np.all((pool.index[:, :-1] > 1) & (pool.index[:, :-1] < pool.top[:-1] - 1), axis=1)
    np.testing.assert_allclose(out[middle & (up == 1), 0], -wall_stress(2.0, 0.1, NU, 0.0) / 0.1, rtol=1e-12)
    np.testing.assert_array_equal(out[middle & (up > 1) & (up < pool.top[-1] - 1)], 0.0)
    np.testing.assert_array_equal(out[:, 1:], 0.0)
    assert np.all(out[~pool.fluid] == 0.0)


@dims
def test_the_force_does_not_depend_on_the_volumes_of_particles(dim):
    pool = tank((8,) * dim, lid=True, spacing=0.1)
    u, volume = np.ones((pool.n, dim)), 0.1**dim * np.random.default_rng(1).uniform(0.4, 2.2, pool.n)
    equal, unequal = rubbed(pool, u), rubbed(pool, u, volume=volume)
    np.testing.assert_allclose(volume[:, None] * unequal, 0.1**dim * equal, rtol=1e-12, atol=1e-15)


def test_less_is_felt_from_one_spacing_on_and_nothing_from_one_and_a_half():
    pool = tank((9, 9), lid=True, spacing=0.1)
    i = int(np.flatnonzero(np.all(pool.index == 4, axis=1))[0])
    felt = []
    for y in (0.3, 0.99, 1.25, 1.499, 1.501):
        pool.x[i] = 0.4, 0.1 * y
        pool.relist()
        u = np.zeros((pool.n, 2))
        u[i, 0] = 1.0
        felt.append(-rubbed(pool, u)[i, 0] * 0.1 / wall_stress(1.0, 0.1 * y, NU, 0.0))
    np.testing.assert_allclose(felt, [1.0, 1.0, 0.5, 0.002, 0.0], rtol=1e-9, atol=1e-12)


def test_friction_is_that_of_the_velocity_relative_to_the_wall():
    pool = tank((8, 8), lid=True, spacing=0.1)
    u = np.tile([0.7, 0.0], (pool.n, 1))
    assert np.abs(rubbed(pool, u, wall_u=[0.7, 0.0])[:, 0]).max() == 0.0
    assert rubbed(pool, u, wall_u=[1.7, 0.0])[pool.fluid, 0].max() > 0.0
    np.testing.assert_array_equal(rubbed(pool, u, no_slip=True), 0.0)


def test_no_step_turns_the_velocity_round():
    pool = tank((8, 8), lid=True, spacing=0.1)
    u = np.tile([1.0, 0.0], (pool.n, 1))
    for dt in (1.0, 1e3, 1e6):
        left = 1.0 + dt * rubbed(pool, u, dt=dt, nu=1.0)[pool.fluid, 0]
        assert left.min() >= 0.0
    assert left.min() < 1e-3


# -- walls of any shape -------------------------------------------------------------------------------


def beside(scene, x, u, sticks=False):
    """Return the friction (n, 2) on points x (n, 2) with velocities u (n, 2) beside the elements of a scene."""
    out, kind, s = np.zeros_like(x), np.full(len(x), FLUID, np.int8), scene.spacing
    walls = elements_near(x, scene.corners, 2.6 * s, s)
    walls.sticks[:] = sticks
    cloud = cloud_of(x, kind, kind, np.zeros_like(x), walls.indptr, walls.indices, s)
    rub(out, cloud, walls, u, Law(NU, 0.0, 0.0))
    return out


BOX = (Tank(4.0, 2.0), Obstacle(Box(width=1.0, height=0.8, at=(1.5, 0.0))))
SCENE = filled(StillWater(1.4), BOX, 0.1)


def test_friction_on_the_bed_and_on_the_sides_of_a_box():
    x = np.array([[0.5, 0.08], [2.0, 0.88], [2.58, 0.4], [2.0, 0.6 + 0.35]])
    out = beside(SCENE, x, np.ones_like(x))
    due = wall_stress(1.0, 0.08, NU, 0.0) / 0.1
    np.testing.assert_allclose(out[:3], [[-due, 0.0], [-due, 0.0], [0.0, -due]], rtol=1e-9, atol=1e-12)
    assert -due < out[3, 0] < 0.0 and out[3, 1] == 0.0
    np.testing.assert_array_equal(beside(SCENE, x, np.ones_like(x), sticks=True), 0.0)


def test_past_a_corner_of_a_box_there_is_no_wall():
    """Around the upper right corner: above the lid of the box along x, beside its face along y, past it nothing."""
    rng = np.random.default_rng(3)
    x = np.array([2.5, 0.8]) + 0.2 * rng.uniform(-1.0, 1.0, (400, 2))
    x = x[(x[:, 0] > 2.5) | (x[:, 1] > 0.8)]
    out = beside(SCENE, x, np.ones_like(x))
    above, aside = x[:, 0] < 2.5, x[:, 1] < 0.8
    past = ~above & ~aside
    angle = np.degrees(np.arctan2(*(x - [2.5, 0.8]).T))    # from the face's normal
    clear = past & (np.abs(angle - 45.0) < 30.0)           # nearer to a face, the edge is as one of a curved wall
    np.testing.assert_array_equal(out[above, 1], 0.0)
    np.testing.assert_array_equal(out[aside, 0], 0.0)
    assert clear.sum() > 50
    np.testing.assert_array_equal(out[clear], 0.0)
    assert np.abs(out[past]).min(axis=1).max() < 0.25 * np.abs(out[past]).max()
    far = (above & (x[:, 1] > 0.95)) | (aside & (x[:, 0] > 2.65))
    np.testing.assert_array_equal(out[far], 0.0)
    assert np.all(out[above & ~far, 0] < 0.0) and np.all(out[aside & ~far, 1] < 0.0)


def test_both_walls_of_a_corner_of_the_tank_are_felt():
    out = beside(SCENE, np.array([[0.07, 0.07]]), np.ones((1, 2)))
    assert np.all(out < 0.0) and out[0, 0] == pytest.approx(out[0, 1])
