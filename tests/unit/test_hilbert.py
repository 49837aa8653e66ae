"""The space-filling curve."""

import numpy as np
import pytest

from parisph.parallel.hilbert import KEY_BITS
from tests.clouds import keys_of_cells


def all_cells(dim, bits):
    return np.stack(np.meshgrid(*[np.arange(2**bits)] * dim, indexing="ij"), axis=-1).reshape(-1, dim)


@pytest.mark.parametrize("dim, bits", [(2, 1), (2, 2), (2, 5), (3, 1), (3, 2), (3, 4), (4, 2)])
def test_each_key_belongs_to_one_cell_and_successive_keys_to_adjacent_cells(dim, bits):
    cells = all_cells(dim, bits)
    keys = keys_of_cells(cells, bits)
    np.testing.assert_array_equal(np.sort(keys), np.arange(2 ** (dim * bits)))
    steps = np.abs(np.diff(cells[np.argsort(keys)], axis=0)).sum(axis=1)
    assert (steps == 1).all()


@pytest.mark.parametrize("dim, bits", [(2, 5), (3, 3)])
def test_the_key_of_a_cell_begins_with_the_key_of_the_cell_around_it(dim, bits):
    cells = all_cells(dim, bits)
    np.testing.assert_array_equal(keys_of_cells(cells, bits) >> dim, keys_of_cells(cells >> 1, bits - 1))


@pytest.mark.parametrize("dim", [2, 3])
def test_largest_grid_still_has_different_positive_keys(dim):
    bits = KEY_BITS // dim
    ends = np.array([0, 1, 2**bits - 2, 2**bits - 1])
    cells = np.stack(np.meshgrid(*[ends] * dim), axis=-1).reshape(-1, dim)
    keys = keys_of_cells(cells, bits)
    assert len(np.unique(keys)) == len(cells) and keys.min() == 0 and keys.max() < 2 ** (dim * bits)
