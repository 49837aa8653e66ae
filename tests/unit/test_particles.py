"""The struct of arrays [owned | ghost], on one rank."""

import numpy as np
import pytest
from mpi4py import MPI

from parisph.base.errors import CaseError
from parisph.base.fields import FIELDS
from parisph.parallel.particles import Particles


def some(n=5, dim=2):
    p = Particles(MPI.COMM_SELF, dim)
    p.assign({"id": np.arange(n) + 10, "x": np.arange(n * dim, dtype=float).reshape(n, dim), "p": np.arange(n) * 2.0})
    return p


@pytest.mark.parametrize("dim", [2, 3])
def test_every_field_of_the_registry_is_there_with_its_type_and_shape(dim):
    p = some(4, dim)
    for name, field in FIELDS.items():
        for view in (getattr(p, name), getattr(p, f"{name}_all")):
            assert view.shape == field.empty(4, dim).shape and view.dtype == field.dtype, name
    assert (p.n_owned, p.n_ghost, p.n_all, p.offset, p.n_global) == (4, 0, 4, 0, 4)


def test_assigned_values_are_copied_and_the_rest_is_zero_also_the_second_time():
    p = some()
    p.u = 3.0
    p.resize(5, 2)
    x = np.ones((3, 2))
    p.assign({"x": x, "id": [7, 8, 9]})
    x[:] = 5.0
    np.testing.assert_array_equal(p.x, np.ones((3, 2)))
    np.testing.assert_array_equal(p.id, [7, 8, 9])
    assert not p.u.any() and not p.p.any() and p.n_all == p.n_global == 3


def test_setting_a_field_writes_into_the_arrays():
    p = some()
    everything = p.u_all
    p.u = np.full((5, 2), 2.0)
    p.u += 1.0
    p.u[0] *= 2.0
    assert everything is p.u_all
    np.testing.assert_array_equal(everything[:2], [[6.0, 6.0], [3.0, 3.0]])
    with pytest.raises(ValueError):
        p.u = np.zeros((4, 2))


def test_ghosts_stand_behind_the_owned_in_one_array():
    p = some()
    p.resize(5, 40)
    p.p_all[5:] = -1.0
    assert p.n_all == 45 and p.p.shape == (5,) and np.shares_memory(p.p, p.p_all)
    np.testing.assert_array_equal(p.p, [0, 2, 4, 6, 8])
    p.p[:] = 1.0
    np.testing.assert_array_equal(p.p_all, [1.0] * 5 + [-1.0] * 40)


def test_reorder_moves_all_fields_together_and_drops_ghosts():
    p = some()
    p.resize(5, 3)
    p.reorder(np.array([4, 0, 2]))
    assert (p.n_owned, p.n_ghost) == (3, 0)
    np.testing.assert_array_equal(p.id, [14, 10, 12])
    np.testing.assert_array_equal(p.x[:, 0], [8, 0, 4])
    np.testing.assert_array_equal(p.p, [8, 0, 4])


def test_growing_keeps_the_owned():
    p = some()
    for n in (6, 50, 51, 500):
        p.resize(n, n)
        np.testing.assert_array_equal(p.id[:5], np.arange(10, 15))
        assert len(p.x_all) == 2 * n


@pytest.mark.parametrize("arrays, says", [
    ({"x": np.zeros((3, 2)), "velocity": np.zeros(3)}, "no such particle field: velocity"),
    ({"id": np.zeros(3)}, "x is missing"),
    ({"x": np.zeros((3, 3))}, "field x has shape"),
    ({"x": np.zeros((3, 2)), "p": np.zeros((3, 1))}, "field p has shape"),
    ({"x": np.zeros((3, 2)), "u": np.zeros((2, 2))}, "field u has shape"),
])
def test_arrays_that_do_not_fit_are_refused_and_nothing_changes(arrays, says):
    p = some()
    with pytest.raises(CaseError, match=says):
        p.assign(arrays)
    assert p.n_owned == 5 and p.id[0] == 10


def test_other_dimensions_are_refused():
    with pytest.raises(CaseError, match="dimension 4"):
        Particles(MPI.COMM_SELF, 4)
