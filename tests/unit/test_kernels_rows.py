"""The pressure matrix of one rank: which row comes from which kernel, and the CSR of it all."""

import numpy as np
import pytest

from parisph.base.fields import BALLISTIC, CONTACT, INNER, SURFACE, WET
from parisph.case.methods import METHODS
from parisph.kernels.records import cloud_of
from parisph.kernels.row import looked_over, split_rows
from tests.made_rows import PROJECTIONS, rows_of_method
from tests.pools import block, dims, tank


def rows_of(pool, method="ISPH_R", wall_rows="sfdi", u=None, made=None, offset=0.0):
    rows = made or rows_of_method(method, pool.dim, wall_rows, offset)
    cells = np.where(pool.fluid, 1.0, 0.0)
    rows.fill(np.zeros_like(pool.x) if u is None else u, pool.cloud, cells)
    return rows


def dense(pool, indptr, columns, values):
    matrix = np.zeros((pool.n, pool.n))
    np.add.at(matrix, (np.repeat(np.arange(pool.n), np.diff(indptr)), columns), values)
    return matrix


def cells(dim):
    return (9, 8) if dim == 2 else (5, 5, 6)


@dims
@pytest.mark.parametrize("wall_rows", ["sfdi", "harmonic"])
@pytest.mark.parametrize("jitter", [0.0, 0.8])
def test_water_at_rest_is_an_exact_solution(dim, wall_rows, jitter):
    # p = rho g depth: no Laplacian, n . grad p = rho n . g at the walls, p = 0 on the surface
    pool = tank(cells(dim), jitter=jitter)
    rows = rows_of(pool, wall_rows=wall_rows)
    depth = pool.top[-1] * pool.spacing - pool.x[:, -1]
    gravity = -np.eye(dim)[-1]
    target = np.where(pool.role == WET, pool.normal @ gravity, 0.0)
    indptr, columns, values, _ = rows.csr(np.arange(pool.n, dtype=np.int32))
    right = rows.right_hand_side(target)
    unknown = np.isin(pool.role, (INNER, WET))
    right[~unknown] = 0.0
    matrix = dense(pool, indptr, columns, values)
    np.testing.assert_allclose(matrix @ np.where(unknown, depth, 0.0), right, atol=1e-13)
    np.testing.assert_allclose(np.linalg.solve(matrix, right)[unknown], depth[unknown], atol=1e-10)


@dims
def test_known_pressures_become_identity_rows_and_leave_the_other_rows(dim):
    pool = tank(cells(dim), jitter=0.4)
    lone = pool.at(*[2] * dim)
    pool.role[lone] = BALLISTIC
    rows = rows_of(pool)
    numbers = np.random.default_rng(0).permutation(1000)[: pool.n].astype(np.int32)
    indptr, columns, values, anchored = rows.csr(numbers)
    assert indptr.dtype == columns.dtype == np.int32 and indptr[-1] == len(columns) == len(values)
    known = np.isin(pool.role, (SURFACE, CONTACT, BALLISTIC))
    local = np.full(1000, -1)
    local[numbers] = np.arange(pool.n)
    for i in range(pool.n):
        row = slice(indptr[i], indptr[i + 1])
        own, = np.flatnonzero(columns[row] == numbers[i])
        assert values[row][own] == 1.0
        others = local[np.delete(columns[row], own)]
        assert np.all(others >= 0) and i not in others and not known[others].any()
        used = rows.rows.columns[rows.cloud.indptr[i]:rows.cloud.indptr[i] + rows.rows.count[i]]
        felt = used[rows.rows.values[rows.cloud.indptr[i]:rows.cloud.indptr[i] + rows.rows.count[i]] != 0.0]
        if known[i]:
            assert len(others) == 0 and anchored[i]
        else:
            assert set(others) == set(felt[~known[felt]]) and anchored[i] == known[felt].any()
            assert values[row].sum() == pytest.approx(0.0, abs=1e-12) or anchored[i]


def test_a_matrix_is_looked_over_in_one_pass():
    indptr, columns, values = np.array([0, 2, 3]), np.array([4, 1, 7]), np.array([1.0, -1e308, 2.0])
    assert looked_over(indptr, columns, values) == (1, 1, 7, True)
    assert looked_over(indptr.astype(np.int32), columns.astype(np.int32), values) == (1, 1, 7, True)
    for broken in (np.nan, np.inf, -np.inf):
        assert not looked_over(indptr, columns, np.array([1.0, broken, 2.0]))[-1]
    assert looked_over(np.array([0, 0, 3]), columns, values)[0] == 0
    assert looked_over(np.array([0]), np.empty(0, int), np.empty(0)) == (0, 0, 0, True)


@pytest.mark.parametrize("dim", [2, 3])
def test_rows_come_in_the_order_of_their_columns(dim):
    pool = tank(cells(dim), jitter=0.4)
    indptr, columns, _, _ = rows_of(pool).csr(np.arange(100, 100 + pool.n, dtype=np.int32))
    assert all(np.all(np.diff(columns[first:last]) > 0) for first, last in zip(indptr[:-1], indptr[1:]))


def test_methods_differ_in_the_rows_of_inner_particles_only():
    pool = tank((9, 8), jitter=0.8, reach=3.6)
    u = np.random.default_rng(0).normal(size=pool.x.shape)
    made = {name: rows_of(pool, name, u=u) for name in PROJECTIONS}
    first = made["ISPH_R"]
    for name, rows in made.items():
        walls = np.flatnonzero(pool.role == WET)
        for i in walls:
            own = slice(rows.cloud.indptr[i], rows.cloud.indptr[i] + rows.rows.count[i])
            np.testing.assert_array_equal(rows.rows.values[own], first.rows.values[own])
        inner = pool.role == INNER
        np.testing.assert_allclose(rows.div[inner], first.div[inner], rtol=1e-11, atol=1e-11)
        if METHODS[name].values["laplacian"] != "rankine":
            assert np.all(rows.rows.measure[: pool.n][inner] != first.rows.measure[: pool.n][inner])
        again = np.empty(pool.n)
        rows.divergence(again, u)
        np.testing.assert_allclose(again[inner], rows.div[: pool.n][inner], atol=1e-11)


def test_right_hand_side_is_minus_measure_times_target():
    pool = block(2, 7, jitter=0.4)
    rows = rows_of(pool)
    target = np.random.default_rng(0).normal(size=pool.n)
    np.testing.assert_array_equal(rows.right_hand_side(target), -rows.rows.measure[: pool.n] * target)
    f = (pool.x**2).sum(axis=1)
    indptr, columns, values, _ = rows.csr(np.arange(pool.n, dtype=np.int32))
    inside = pool.far_inside(3)
    np.testing.assert_allclose((dense(pool, indptr, columns, values) @ f)[inside],
                               rows.right_hand_side(np.full(pool.n, 4.0))[inside], atol=1e-13)


def test_buffers_grow_and_are_used_again():
    small, large = block(2, 5), block(2, 12, jitter=0.8)
    made = rows_of(small)
    kept = made.rows.columns
    rows_of(large, made=made)
    assert len(made.rows.columns) >= len(large.indices) > len(kept)
    grown = made.rows.columns
    fresh = rows_of(small)
    rows_of(small, made=made)
    assert made.rows.columns is grown
    numbers = np.arange(25, dtype=np.int32)
    for a, b in zip(made.csr(numbers), fresh.csr(numbers)):
        np.testing.assert_array_equal(a, b)


def test_no_particles():
    pool = block(2, 5)
    rows = rows_of_method("ISPH_R", 2, "harmonic", 0.5)
    none, kinds = np.empty((0, 2)), np.empty(0, np.int8)
    rows.fill(none, cloud_of(none, kinds, kinds, none, np.zeros(1, np.int32), np.empty(0, np.int32), 0.1), np.empty(0))
    indptr, columns, values, anchored = rows.csr(np.empty(0, np.int32))
    assert indptr.tolist() == [0] and len(columns) == len(values) == len(anchored) == 0
    assert rows.right_hand_side(np.empty(0)).shape == (0,) and pool.n == 25


def test_with_an_offset_surface_particles_are_unknowns():
    pool = block(2, 9)
    pool.role[pool.index[:, 1] == pool.top[1]] = SURFACE
    pinned = np.flatnonzero(pool.role == SURFACE)[4]
    rows = rows_of(pool, offset=0.5)
    rows.pin([pinned])
    numbers = np.arange(pool.n, dtype=np.int32)
    indptr, columns, values, anchored = rows.csr(numbers)
    matrix = dense(pool, indptr, columns, values)
    surface = pool.role == SURFACE
    assert np.all(anchored[surface]) and np.all(matrix.diagonal() == 1.0)
    off = matrix[surface] - np.eye(pool.n)[surface]
    assert off.max() <= 0.0 and np.all(off.sum(axis=1)[pool.index[surface, 0] != 4] < 0.0)
    assert np.all(off.sum(axis=1) > -0.6) and np.all(off[:, surface] == 0.0)     # less than the diagonal: p = 0 outside
    assert np.count_nonzero(matrix[pinned]) == 1
    below = np.flatnonzero((pool.index[:, 1] == pool.top[1] - 1) & (pool.index[:, 0] == 4))
    assert np.all(anchored[below]) and np.any(matrix[below][:, surface] != 0.0)


def test_sorted_rows_split_into_own_and_other_columns():
    random = np.random.default_rng(5)
    n, columns = 7, 20
    table = np.where(random.random((n, columns)) < 0.4, random.normal(size=(n, columns)), 0.0)
    table[2] = 0.0    # a row without entries
    indptr = np.concatenate([[0], np.cumsum(np.count_nonzero(table, axis=1))]).astype(np.int32)
    places = np.concatenate([np.flatnonzero(line) for line in table]).astype(np.int32)
    for first, last in ((5, 12), (0, 20), (8, 8)):
        *own, other_ptr, other_columns, other_values = split_rows(indptr, places.copy(), table[table != 0.0],
                                                                     first, last)
        found = np.zeros_like(table)
        for i in range(n):
            for offset, (ptr, column, value) in ((first, own), (0, (other_ptr, other_columns, other_values))):
                part = slice(ptr[i], ptr[i + 1])
                assert (np.diff(column[part]) > 0).all()
                found[i, offset + column[part]] += value[part]
        np.testing.assert_array_equal(found, table)
        assert own[1].dtype == other_columns.dtype == np.int32 and len(own[2]) == np.count_nonzero(table[:, first:last])
