"""Neighbour lists against brute force, and the inputs that could break a cell grid."""

import numpy as np
import pytest

from parisph.kernels.cells import _ordered, far_from, nearby, neighbour_lists
from tests.pools import dims


def jittered(dim, side, seed=0):
    index = np.stack(np.meshgrid(*[np.arange(side)] * dim, indexing="ij"), axis=-1).reshape(-1, dim)
    return index + 0.8 * (np.random.default_rng(seed).random(index.shape) - 0.5)


def listed(x, n_owned, radius):
    """Return the lists as sets, having checked the form of the CSR."""
    indptr, indices = neighbour_lists(x, n_owned, radius)
    assert indptr.dtype == np.int32 and indices.dtype == np.int32
    assert indptr.shape == (n_owned + 1,) and indptr[0] == 0 and indptr[-1] == len(indices)
    assert np.all(np.diff(indptr) >= 0)
    rows = [indices[first:last].tolist() for first, last in zip(indptr[:-1], indptr[1:])]
    assert all(len(set(row)) == len(row) for row in rows), "a neighbour stands in a list twice"
    for row in rows:
        owned = [j for j in row if j < n_owned]
        assert row[:len(owned)] == sorted(owned), "owned neighbours come first, in order"
    return [set(row) for row in rows]


def brute(x, n_owned, radius):
    distance2 = ((x[:n_owned, None] - x[None]) ** 2).sum(axis=-1)
    near = distance2 < radius**2
    near[np.arange(n_owned), np.arange(n_owned)] = False
    return [set(np.flatnonzero(row)) for row in near]


@dims
@pytest.mark.parametrize("radius", [0.4, 2.1, 2.6, 3.6, 50.0])
def test_lists_of_jittered_particles(dim, radius):
    x = jittered(dim, 20 if dim == 2 else 8)
    assert listed(x, len(x), radius) == brute(x, len(x), radius)


@dims
def test_lists_of_owned_particles_hold_ghosts_too(dim):
    x = jittered(dim, 16 if dim == 2 else 7, seed=1)
    owned = len(x) // 3
    found = listed(x, owned, 2.1)
    assert found == brute(x, owned, 2.1) and max(max(row) for row in found) >= owned


@dims
def test_points_that_are_left_out_have_no_lists_and_are_in_none(dim):
    x = jittered(dim, 16 if dim == 2 else 7, seed=2)
    left_out, owned = np.random.default_rng(3).random(len(x)) < 0.4, 2 * len(x) // 3
    indptr, indices = neighbour_lists(x, owned, 2.1, left_out)
    every = brute(x, owned, 2.1)
    out = set(np.flatnonzero(left_out))
    for i, (first, last) in enumerate(zip(indptr[:-1], indptr[1:])):
        row = indices[first:last].tolist()
        assert set(row) == (set() if i in out else every[i] - out)
        assert [j for j in row if j < owned] == sorted(j for j in row if j < owned)


@dims
def test_far_points_are_beyond_the_reach_and_all_well_beyond_it_are_far(dim):
    x = 12.0 * np.random.default_rng(4).random((400, dim))
    others, reach = np.random.default_rng(5).random((20, dim)) + 2.0, 3.0
    found = far_from(x, others, reach)
    apart = np.abs(x[:, None] - others[None])
    assert (np.linalg.norm(apart, axis=2).min(axis=1)[found] > reach).all()
    assert found[(apart.max(axis=2) > reach + reach / 3.0).all(axis=1)].all() and 0 < found.sum() < len(x)
    assert far_from(x, others[:0], reach).all()


@dims
@pytest.mark.parametrize("far", [1e3, 1e9, 1e25, 1e100])
def test_a_droplet_far_away(dim, far):
    x = np.vstack([jittered(dim, 10 if dim == 2 else 5), np.full((1, dim), far), np.full((1, dim), far)])
    found = listed(x, len(x), 2.1)
    assert found == brute(x, len(x), 2.1)
    assert found[-1] == {len(x) - 2}


@dims
def test_coincident_particles_are_neighbours_but_not_of_themselves(dim):
    x = np.vstack([jittered(dim, 4), jittered(dim, 4), np.zeros((3, dim))])
    found = listed(x, len(x), 1.3)
    assert found == brute(x, len(x), 1.3)
    n = len(x)
    assert {n - 1, n - 2} <= found[n - 3] and n - 3 not in found[n - 3]


@dims
def test_crowd_in_one_cell_outgrows_the_first_buffer(dim):
    x = 1e-3 * np.random.default_rng(0).random((300, dim))
    assert listed(x, len(x), 1.0) == [set(range(300)) - {i} for i in range(300)]


@dims
def test_points_without_extent_in_some_direction(dim):
    x = np.zeros((50, dim))
    x[:, 0] = np.arange(50)
    assert listed(x, 50, 1.5) == brute(x, 50, 1.5)
    x = x[:, ::-1]  # not contiguous either
    assert listed(x, 50, 1.5) == brute(x, 50, 1.5)
    assert listed(np.zeros((1, dim)), 1, 1.0) == [set()]


@dims
def test_the_radius_itself_is_outside(dim):
    x = np.zeros((2, dim))
    x[1, 0] = 0.5
    assert listed(x, 2, 0.5) == [set(), set()]
    assert listed(x, 2, np.nextafter(0.5, 1.0)) == [{1}, {0}]


@dims
def test_no_particles(dim):
    assert listed(np.empty((0, dim)), 0, 1.0) == []
    assert listed(np.zeros((3, dim)), 0, 1.0) == []


@dims
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("where", [0, -1])
def test_positions_that_are_not_finite_are_refused(dim, bad, where):
    x = jittered(dim, 4)
    x[where, -1] = bad
    with pytest.raises(ValueError, match="finite"):
        neighbour_lists(x, 3, 1.0)


@dims
def test_positions_too_far_apart_for_a_difference_are_refused(dim):
    x = np.zeros((2, dim))
    x[0, 0], x[1, 0] = -1.5e308, 1.5e308
    with pytest.raises(ValueError, match="finite"):
        neighbour_lists(x, 2, 1.0)


@pytest.mark.parametrize("radius", [0.0, -1.0, np.nan])
def test_radius_must_be_positive(radius):
    with pytest.raises(ValueError, match="radius"):
        neighbour_lists(np.zeros((2, 2)), 2, radius)


def test_lists_that_are_not_mutual_are_left_as_they_are():
    """As if one distance were rounded to either side of the radius."""
    for start, listed_ones in (([0, 1, 1], [1]), ([0, 2, 3, 3], [2, 1, 0])):
        indptr, indices = np.array(start, np.int32), np.array(listed_ones, np.int32)
        np.testing.assert_array_equal(_ordered(indptr, indices), indices)


@dims
def test_nearby_finds_all_others_within_the_radius(dim):
    rng = np.random.default_rng(0)
    x, others = rng.random((200, dim)) * 1.4 - 0.2, rng.random((150, dim))
    indptr, indices = nearby(x, others, 0.17)
    near = np.linalg.norm(x[:, None] - others, axis=2) < 0.17
    for i in range(len(x)):
        assert sorted(indices[indptr[i] : indptr[i + 1]]) == np.flatnonzero(near[i]).tolist()
    assert nearby(x, others[:0], 0.1)[0].tolist() == [0] * 201
