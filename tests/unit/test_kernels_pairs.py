"""Turning and parting of close pairs."""

import numpy as np
import pytest

from parisph.base.fields import INNER, SURFACE
from parisph.kernels import pairs
from tests.pools import block, dims, free, part, tank


def turned(pool, ident, distance=0.7, strength=0.05):
    shift = np.zeros_like(pool.x)
    close = pairs.close_pairs(pool.cloud, pool.spacing)
    pairs.turn_pairs(shift, close, ident, np.full(pool.n, strength * pool.spacing), distance * pool.spacing)
    return shift


def parted(pool, ident, distance=0.6, strength=0.5):
    shift, number = np.full_like(pool.x, np.nan), np.full(pool.n, -1, np.int32)
    close = pairs.close_pairs(pool.cloud, pool.spacing)
    pairs.count_close(number, close, distance * pool.spacing)
    pairs.part_pairs(shift, close, number, ident, distance * pool.spacing, strength)
    return shift


def couple(dim, apart, role):
    """Return two particles `apart` spacings apart in some direction, both of a role."""
    direction = np.random.default_rng(0).normal(size=dim)
    direction /= np.linalg.norm(direction)
    pool = free(np.vstack([np.zeros(dim), apart * direction]))
    pool.role[:] = role
    return pool, direction


@dims
def test_a_pair_turns_by_its_strength_across_its_line(dim):
    pool, direction = couple(dim, 0.35, INNER)
    shift = turned(pool, np.array([7, 3]))
    np.testing.assert_allclose(shift.sum(axis=0), 0.0, atol=1e-16)
    np.testing.assert_allclose(shift @ direction, 0.0, atol=1e-15)
    length = np.linalg.norm(shift[0]) / pool.spacing
    assert length == pytest.approx(0.025) if dim == 2 else 0.0 < length <= 0.025


def test_either_way_is_as_likely_and_the_order_of_ids_does_not_matter():
    side, d = np.empty(2), np.array([1.0, 0.0])
    signs = []
    for first in range(60):
        for second in range(first):
            pairs.across(side, d, first, second, (0, 0))
            signs.append(side[1])
            pairs.across(side, d, second, first, (0, 0))
            assert side[1] == signs[-1] and side[0] == 0.0
    assert abs(np.mean(signs)) < 0.06 and set(signs) == {-1.0, 1.0}


def test_axes_of_turning_have_no_direction_in_3d():
    side, mean = np.empty(3), np.zeros(3)
    for number in range(2000):
        pairs.across(side, np.array([0.0, 0.0, 1.0]), number, 2 * number + 1, (0, 0, 0))
        assert side[2] == 0.0 and np.linalg.norm(side) <= 1.0
        mean += side / 2000
    assert np.linalg.norm(mean) < 0.05


@dims
@pytest.mark.parametrize(("apart", "role"), [(0.71, INNER), (0.5, SURFACE), (0.0, INNER)])
def test_pairs_that_do_not_turn(dim, apart, role):
    pool, _ = couple(dim, apart, role)
    assert np.all(turned(pool, np.arange(2)) == 0.0)


@dims
def test_a_pair_without_pressure_parts_by_what_is_missing(dim):
    pool, direction = couple(dim, 0.4, SURFACE)
    shift = parted(pool, np.array([1, 2]))
    np.testing.assert_allclose(shift.sum(axis=0), 0.0, atol=1e-16)
    gap = (shift[1] - shift[0]) @ direction / pool.spacing
    assert gap == pytest.approx(0.5 * 0.2 * np.cos(np.pi / 6.0))
    pool.role[0] = INNER
    np.testing.assert_array_equal(parted(pool, np.array([1, 2])), shift)
    pool.role[1] = INNER
    assert np.all(parted(pool, np.array([1, 2])) == 0.0)


@dims
def test_a_crowd_parts_by_no_more_than_a_pair_and_keeps_its_centre(dim):
    random = np.random.default_rng(1)
    pool = free(0.3 * random.random((15, dim)))
    pool.role[:] = SURFACE
    shift = parted(pool, np.arange(15))
    np.testing.assert_allclose(shift.sum(axis=0), 0.0, atol=1e-14)
    assert 0.0 < np.linalg.norm(shift, axis=1).max() <= 0.5 * 0.5 * 0.6 * pool.spacing


def test_particles_in_one_line_leave_it():
    pool = free(np.arange(6)[:, None] * np.array([[0.4, 0.0]]))
    pool.role[:] = SURFACE
    assert np.abs(parted(pool, np.arange(6))[:, 1]).max() > 0.01 * pool.spacing


@dims
@pytest.mark.parametrize("move", [turned, parted])
def test_result_depends_on_ids_and_not_on_the_order(dim, move):
    pool = block(dim, 6 if dim == 2 else 4, jitter=1.2)
    pool.role[::2] = SURFACE if move is parted else INNER
    order = np.random.default_rng(3).permutation(pool.n)
    shift = move(pool, np.arange(pool.n), distance=0.9)
    assert np.abs(shift).max() > 0.0
    np.testing.assert_allclose(move(part(pool, order), order, distance=0.9), shift[order], atol=1e-15)


def apart(pool, ident, distance=0.45, longest=1.0):
    move = np.zeros_like(pool.x)
    s = pool.spacing
    close = pairs.close_pairs(pool.cloud, s)
    crowded, _ = pairs.keep_apart(move, np.arange(pool.n, dtype=np.int32), close, ident, distance * s, longest * s)
    return move, crowded


@dims
@pytest.mark.parametrize("role", [INNER, SURFACE])
def test_pairs_of_any_role_are_kept_apart(dim, role):
    pool, direction = couple(dim, 0.2, role)
    move, crowded = apart(pool, np.array([7, 3]))
    assert crowded == 2
    np.testing.assert_allclose(move.sum(axis=0), 0.0, atol=1e-16)
    along = (move[1] - move[0]) @ direction / pool.spacing
    assert along == pytest.approx(0.25 * np.cos(pairs.TILT))     # the line turned by TILT
    pool, _ = couple(dim, 0.46, role)
    move, crowded = apart(pool, np.array([7, 3]))
    assert crowded == 0 and np.all(move == 0.0)


def test_a_crowd_is_spread_by_a_few_sweeps_within_the_longest_move():
    rng = np.random.default_rng(3)
    pool = free(0.3 * rng.random((12, 2)))
    ident, least = np.arange(pool.n), []
    for _ in range(60):
        distance = np.linalg.norm(pool.x[:, None] - pool.x[None], axis=2)
        least.append(distance[np.triu_indices(pool.n, 1)].min() / pool.spacing)
        move, crowded = apart(pool, ident, longest=0.15)
        assert np.linalg.norm(move, axis=1).max() <= 0.15 * pool.spacing * (1.0 + 1e-12)
        if not crowded:
            break
        pool.x += move
        pool.relist()
    assert least[0] < 0.05 and least[8] > 0.25 and least[-1] >= 0.449


def test_sweeps_leave_out_what_is_not_near_and_find_the_same():
    pool = block(2, 12, jitter=1.4)
    cloud, ident = pool.cloud, np.arange(pool.n)
    move, near = np.zeros_like(pool.x), np.arange(pool.n, dtype=np.int32)
    for _ in range(4):
        whole = np.zeros_like(pool.x)
        due, _ = pairs.keep_apart(whole, np.arange(pool.n, dtype=np.int32), cloud, ident, 0.045, 0.015)
        crowded, left = pairs.keep_apart(move, near, cloud, ident, 0.045, 0.015)
        assert crowded == due
        np.testing.assert_array_equal(move, whole)
        near = near[:left]
        pool.x += move
    last = np.flatnonzero(move.any(axis=1))
    assert 0 < len(last) <= len(near) < pool.n
    pool.x[:] *= 10.0
    assert pairs.keep_apart(move, near, cloud, ident, 0.045, 0.015) == (0, 0)
    assert np.all(move == 0.0), "also where particles have moved in the sweep before"


@dims
def test_close_pairs_are_the_fluid_neighbours_within_the_distance(dim):
    pool = tank((7,) * dim if dim == 2 else (5,) * dim, jitter=0.8)
    pool.x[1] = pool.x[0]    # in one place: no pair
    close = pairs.close_pairs(pool.cloud, 0.8 * pool.spacing)
    apart = np.linalg.norm(pool.x[:, None] - pool.x, axis=2)
    for i in range(pool.n):
        listed = pool.indices[pool.indptr[i]:pool.indptr[i + 1]]
        want = [j for j in listed if pool.fluid[i] and pool.fluid[j] and 0.0 < apart[i, j] < 0.8 * pool.spacing]
        assert close.indices[close.indptr[i]:close.indptr[i + 1]].tolist() == want
    assert len(close.indices) > 0
