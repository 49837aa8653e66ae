"""Neighbours side by side, and the closed form of linear moving least squares."""

import numba
import numpy as np
import pytest

from parisph.base.fields import CONTACT, DRY
from parisph.kernels import near as beside
from parisph.kernels.jit import axes_of
from parisph.kernels.mls import linear_fit, moment_count
from parisph.kernels.near import CLOSE, LANES, room_for
from parisph.kernels.smoothing import quartic_weight
from tests.pools import block, dims, free

# Inlined functions are made for use inside kernels. These two are compiled anew each time: a cache
# would not notice a change in what they inline.
kernel = numba.njit(error_model="numpy")


@kernel
def gathered(near, member, first, i, cloud, radius):
    return beside.gather(near, member, first, i, cloud, radius)


@kernel
def fitted(fit, moments, weighted, near, at, n, power, axes):
    """Weigh and sum the first n columns of near, and fit at the points `at` (dim, points)."""
    m = beside.fill_up(near, n, axes)
    for q in range(at.shape[1]):
        beside.weigh(weighted, near, power, m, axes)
        beside.sum_moments(moments, q, weighted, near, m, axes)
    return linear_fit(fit, moments, at, at.shape[1], axes)


def fit_at(points, at, power=0):
    """Return (number of linear fits, fit, weights) for neighbours (n, dim), weight about the origin, at (k, dim)."""
    n, dim = points.shape
    columns = (n + LANES) // LANES * LANES
    near = np.full((dim, columns), np.nan)
    near[:, :n] = points.T
    axes = axes_of(dim)
    fit = np.full((dim + 1, len(at)), np.nan)
    moments, weighted = np.full((moment_count(axes), len(at)), np.nan), np.full((dim + 1, columns), np.nan)
    linear = fitted(fit, moments, weighted, near, np.ascontiguousarray(at.T), n, power, axes)
    return linear, fit, weighted[0, :n]


def shapes(points, at, power=0):
    """Return (number of linear fits, shape functions (len(at), n))."""
    linear, fit, weight = fit_at(points, at, power)
    return linear, weight * (fit[0][:, None] + fit[1:].T @ points.T)


@dims
def test_fit_is_the_weighted_linear_one(dim):
    random = np.random.default_rng(0)
    points, at = random.uniform(-0.8, 0.8, (17, dim)), random.uniform(-0.5, 0.5, (5, dim))
    weight = np.array([quartic_weight(r @ r, 1.0) for r in points])
    basis = np.hstack([np.ones((17, 1)), points])
    expected = np.hstack([np.ones((5, 1)), at]) @ np.linalg.solve(basis.T * weight @ basis, basis.T * weight)
    linear, phi = shapes(points, at)
    assert linear == 5
    np.testing.assert_allclose(phi, expected, atol=1e-12)


@dims
def test_shape_functions_reproduce_linear_fields(dim):
    random = np.random.default_rng(1)
    points, at = random.uniform(-0.9, 0.9, (23, dim)), random.uniform(-1.0, 1.0, (4, dim))
    _, phi = shapes(points, at)
    np.testing.assert_allclose(phi.sum(axis=1), 1.0, atol=1e-12)
    np.testing.assert_allclose(phi @ points, at, atol=1e-12)


@dims
@pytest.mark.parametrize("shape", ["one", "line", "flat", "thin", "coincident"])
def test_points_that_span_no_space_keep_the_constant(dim, shape):
    unit, random = np.eye(dim), np.random.default_rng(2)
    points = {"one": 0.3 * unit[:1], "line": np.linspace(-0.6, 0.6, 9)[:, None] * (unit[:1] + unit[1:2]),
              "flat": random.uniform(-0.6, 0.6, (12, dim)) * (1.0 - unit[-1]) + 1e-3 * unit[-1],
              "thin": random.uniform(-0.6, 0.6, (12, dim)) * (1.0 - 0.97 * unit[-1]),
              "coincident": np.tile(0.2 * unit[0], (6, 1))}[shape]
    linear, phi = shapes(points, random.uniform(-0.5, 0.5, (3, dim)))
    assert linear == 0
    weight = np.array([quartic_weight(r @ r, 1.0) for r in points])
    np.testing.assert_allclose(phi, np.tile(weight / weight.sum(), (3, 1)), atol=1e-14)


@dims
def test_no_neighbour_in_reach_leaves_zeros(dim):
    linear, phi = shapes(np.full((3, dim), 2.0), np.zeros((1, dim)))
    assert linear == 0 and np.all(phi == 0.0)


@dims
def test_gathered_neighbours_are_those_of_the_stencils(dim):
    pool = block(dim, 5, jitter=0.8)
    i = pool.at(*[2] * dim)
    listed = pool.indices[pool.indptr[i]:pool.indptr[i + 1]]
    pool.role[listed[[0, 3, -1]]] = DRY, CONTACT, DRY
    room = room_for(pool.indptr)
    near, member = np.full((dim, room), np.nan), np.full(room + 2, -1, np.int32)
    n = gathered(near, member, 2, i, pool.cloud, 2.0 * pool.spacing)
    expected = np.delete(listed, [0, 3, len(listed) - 1])
    np.testing.assert_array_equal(member[2:2 + n], expected)
    np.testing.assert_allclose(near[:, :n].T, (pool.x[expected] - pool.x[i]) / (2.0 * pool.spacing), rtol=1e-13)


@pytest.mark.parametrize("count", range(10))
def test_room_holds_all_neighbours_the_particle_itself_and_whole_lanes(count):
    room = room_for(np.array([0, 0, count, count], np.int32))
    assert room >= count + 1 and room % LANES == 0
    assert room < count + 1 + LANES


@dims
@pytest.mark.parametrize("power", [0, 2])
@pytest.mark.parametrize("n", [5, 8])
def test_weights_and_moments(dim, power, n):
    points = np.random.default_rng(3).uniform(-0.7, 0.7, (n, dim))
    points[2], points[3] = 0.0, 1.5  # the particle itself, and one out of reach
    axes, columns = axes_of(dim), (n + LANES) // LANES * LANES
    near = np.full((dim, columns), np.nan)
    near[:, :n] = points.T
    moments, weighted = np.full((moment_count(axes), 1), np.nan), np.full((dim + 1, columns), np.nan)
    fitted(np.empty((dim + 1, 1)), moments, weighted, near, np.zeros((dim, 1)), n, power, axes)
    r2 = (points**2).sum(axis=1)
    weight = np.array([quartic_weight(value, 1.0) for value in r2])
    if power == 2:
        weight = np.where(r2 > 0.0, weight / np.maximum(r2, CLOSE), 0.0)
    assert weight[3] == 0.0
    np.testing.assert_allclose(weighted[0, :n], weight, atol=1e-13)
    np.testing.assert_allclose(weighted[1:, :n], weight * points.T, atol=1e-13)
    pairs = [(a, b) for a in range(dim) for b in range(a + 1)]
    expected = [weight.sum(), *(weight @ points), *((weight * points[:, a]) @ points[:, b] for a, b in pairs)]
    np.testing.assert_allclose(moments[:, 0], expected, atol=1e-13)


def test_filling_up_adds_no_weight():
    pool = free([[0, 0], [1, 0], [0, 1]])
    assert room_for(pool.indptr) == LANES
    near = np.zeros((2, LANES))
    near[:, :2] = [[0.3, 0.0], [0.0, 0.4]]
    weighted, moments = np.empty((3, LANES)), np.empty((6, 1))
    fitted(np.empty((3, 1)), moments, weighted, near, np.zeros((2, 1)), 2, 0, (0, 1))
    assert np.all(weighted[:, 2:] == 0.0) and np.all(near[:, 2:] > 1.0)
