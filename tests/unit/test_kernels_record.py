"""Sums over the particles for the record of a step, and for the time step."""

import numpy as np
import pytest

from parisph.base.fields import FLUID, WALL
from parisph.kernels import record


@pytest.mark.parametrize("dim", [2, 3])
def test_sizes_of_fluid_leave_out_walls(dim):
    rng = np.random.default_rng(1)
    vectors, kind = rng.standard_normal((40, dim)), rng.choice([FLUID, WALL], 40).astype(np.int8)
    vectors[kind == WALL] *= 100.0
    sizes = np.linalg.norm(vectors[kind == FLUID], axis=1)
    np.testing.assert_allclose(record.fluid_sizes(vectors, kind), (sizes.max(), sizes @ sizes, len(sizes)), rtol=1e-14)


@pytest.mark.parametrize("at", [0, 3, 9])
@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_sizes_of_fluid_that_are_not_finite_are_told(at, bad):
    vectors, kind = np.ones((10, 2)), np.full(10, FLUID, np.int8)
    vectors[at, 1] = bad
    found = record.fluid_sizes(vectors, kind)
    np.testing.assert_equal(found, (bad, bad, 10.0))
    kind[at] = WALL
    np.testing.assert_allclose(record.fluid_sizes(vectors, kind), (np.sqrt(2.0), 18.0, 9.0))


def test_sizes_without_fluid_are_zero():
    assert record.fluid_sizes(np.ones((3, 2)), np.full(3, WALL, np.int8)) == (0.0, 0.0, 0.0)
    assert record.fluid_sizes(np.ones((0, 2)), np.zeros(0, np.int8)) == (0.0, 0.0, 0.0)
