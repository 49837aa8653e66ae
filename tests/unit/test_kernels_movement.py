"""Changes of fluid alone, and walls that do not count."""

import numpy as np
import pytest

from parisph.base.arrays import sizes
from parisph.base.fields import ABSENT, BALLISTIC, DRY, FLUID, INNER, SURFACE, WALL, WET
from parisph.kernels import movement, record, wetness

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
    assert record.step_sums(div, role, kind, acceleration) == (5.0, 2.0, 2.0, 9.0, 4.0)
