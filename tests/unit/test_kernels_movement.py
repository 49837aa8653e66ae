"""Changes of fluid alone, and walls that do not count."""

import numpy as np
import pytest

from parisph.base.arrays import sizes
from parisph.base.fields import ABSENT, BALLISTIC, DRY, FLUID, INNER, SURFACE, WALL, WET
from parisph.kernels import balance, movement, record, wetness
from parisph.kernels.records import cloud_of

KIND = np.array([FLUID, WALL, FLUID, WALL, FLUID], np.int8)


@pytest.mark.parametrize("dim", [2, 3])
def test_only_fluid_changes(dim):
    values, change = np.random.default_rng(1).normal(size=(2, len(KIND), dim))
    fluid = (KIND == FLUID)[:, None]
    added, given = values.copy(), values.copy()
    movement.add_to_fluid(added, change, KIND)
    movement.give_to_fluid(given, change, KIND)
    assert np.array_equal(added, np.where(fluid, values + change, values))
    assert np.array_equal(given, np.where(fluid, change, values))


@pytest.mark.parametrize("dim", [2, 3])
def test_a_linear_velocity_is_carried_along_a_move(dim):
    x, move = np.random.default_rng(3).normal(size=(2, 5, dim))
    gradient = np.arange(1.0, dim * dim + 1.0).reshape(dim, dim)
    u = x @ gradient.T
    movement.carry(u, np.tile(gradient, (5, 1, 1)), move)
    np.testing.assert_allclose(u, (x + move) @ gradient.T, rtol=1e-12)


def test_ghosts_keep_their_values():
    values = np.zeros((len(KIND), 2))
    movement.give_to_fluid(values, np.ones((3, 2)), KIND)
    assert values[:, 0].tolist() == [1.0, 0.0, 1.0, 0.0, 0.0]


def test_walls_that_do_not_close_are_absent():
    closing = np.array([0, 0, 0, 2, 0], np.int8)
    seen = wetness.without_walls(KIND, closing, wetness.CLOSING)
    assert seen.dtype == KIND.dtype
    assert seen.tolist() == [FLUID, ABSENT, FLUID, WALL, FLUID]
    assert KIND[1] == WALL


@pytest.mark.parametrize("dim", [2, 3])
def test_sizes_are_those_of_numpy_to_the_last_bit(dim):
    vectors = np.random.default_rng(2).normal(size=(1000, dim)) * 10.0 ** np.arange(-5, 5).repeat(100)[:, None]
    assert np.array_equal(sizes(vectors), np.linalg.norm(vectors, axis=1))
    assert np.isnan(sizes(np.full((1, dim), np.nan))).all()
    assert sizes(np.empty((0, dim))).shape == (0,)


def test_sums_of_a_step():
    role = np.array([INNER, INNER, SURFACE, BALLISTIC, WET, DRY], np.int8)
    kind = np.array([FLUID, FLUID, FLUID, FLUID, WALL, WALL], np.int8)
    div, acceleration = np.array([1.0, 2.0, 50.0, 60.0, 70.0, 80.0]), np.array([4.0, 9.0, 16.0, 0.0, 100.0, 100.0])
    strained = np.array([0.5, 0.25, 1.0, 0.0, 70.0, 80.0])
    assert record.step_sums(div, role, kind, acceleration, strained) == (5.0, 2.0, 2.0, 9.0, 4.0, 1.75)
    assert record.step_sums(div, role, kind, acceleration, np.empty(0)) == (5.0, 2.0, 2.0, 9.0, 4.0, 0.0)


@pytest.mark.parametrize("dim", [2, 3])
def test_fluid_is_accelerated_by_forces_and_pressure(dim):
    kind = np.array([FLUID, WALL, FLUID], np.int8)
    u, grad = np.ones((3, dim)), np.zeros((3, dim))
    force = np.zeros((5, dim))    # also of ghosts
    grad[:, 0], grad[:, 1], force[:, -1] = 3000.0, 4000.0, -9.81
    acceleration, by_pressure = np.full((3, dim), np.nan), np.full(3, np.nan)
    movement.accelerate(u, acceleration, by_pressure, grad, force, 1000.0, 0.1, kind)
    expected = np.zeros(dim)
    expected[0], expected[1] = -3.0, -4.0
    expected[-1] -= 9.81
    np.testing.assert_allclose(acceleration, np.tile(expected, (3, 1)), rtol=1e-14)
    np.testing.assert_allclose(u[kind == FLUID], np.tile(1.0 + 0.1 * expected, (2, 1)), rtol=1e-14)
    np.testing.assert_array_equal(u[1], 1.0)
    np.testing.assert_allclose(by_pressure, 5.0, rtol=1e-14)


@pytest.mark.parametrize("moved", [np.empty(0), np.array([0.0, 2.0, 2.0])])
def test_wet_walls_balance_forces_and_their_own_acceleration(moved):
    role = np.array([INNER, WET, DRY], np.int8)
    target, normal, force = np.full(3, 7.0), np.tile([0.6, 0.8], (3, 1)), np.tile([1.0, -10.0], (4, 1))
    lists = np.zeros(4, np.int32)
    balance.wall_targets(target, cloud_of(normal, role, role, normal, lists, lists[:0], 1.0), force, moved, 1000.0)
    np.testing.assert_allclose(target, [7.0, 1000.0 * (0.6 - 8.0 - moved[1:2].sum()), 7.0])
    right = np.full(5, 7.0)
    balance.without_equation(right, np.array([INNER, WET, DRY, SURFACE, BALLISTIC], np.int8))
    np.testing.assert_array_equal(right, [7.0, 7.0, 0.0, 0.0, 0.0])
