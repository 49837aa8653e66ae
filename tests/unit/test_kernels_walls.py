"""Wall rows: the normal derivative at walls and in corners."""

import numpy as np
import pytest

from parisph.base.fields import CONTACT, DRY, WALL, WET
from parisph.kernels import walls
from parisph.kernels.smoothing import quartic_weight
from tests.pools import Rows, dims, harmonic_quadratics, monomials, tank

RADIUS = 2.6


def filled(pool, kind):
    """Return Rows with the wall rows of the kind; "harmonic" after "sfdi", as in a step."""
    rows = Rows(pool)
    walls.sfdi_rows(rows.matrix, pool.cloud, RADIUS * pool.spacing)
    if kind == "harmonic":
        walls.harmonic_rows(rows.matrix, pool.cloud, RADIUS * pool.spacing, np.inf)
    return rows


def pool_of(dim, jitter=0.0, lid=False):
    return tank((8,) * dim if dim == 2 else (5,) * dim, lid, jitter)


def slope(pool, grad):
    return (pool.normal * grad).sum(axis=1)


both = pytest.mark.parametrize("kind", ["sfdi", "harmonic"])


@dims
@both
@pytest.mark.parametrize("jitter", [0.0, 0.8])
@pytest.mark.parametrize("lid", [False, True])
def test_linear_pressure_is_exact_on_walls_and_in_corners(dim, kind, jitter, lid):
    pool = pool_of(dim, jitter, lid)
    rows, wet = filled(pool, kind), pool.role == WET
    assert np.count_nonzero(wet & (pool.corner == 1)) > 0 and np.all(rows.measure[wet] > 0.0)
    for f, grad, _ in monomials(pool.x, 1):
        np.testing.assert_allclose(rows.applied(4.0 + f)[wet], -(rows.measure * slope(pool, grad))[wet], atol=1e-12)


@dims
@pytest.mark.parametrize("jitter", [0.0, 0.8])
@pytest.mark.parametrize("lid", [False, True])
def test_harmonic_rows_are_exact_for_harmonic_quadratics(dim, jitter, lid):
    pool = pool_of(dim, jitter, lid)
    rows, wet = filled(pool, "harmonic"), pool.role == WET
    for f, grad in harmonic_quadratics(pool.x):
        np.testing.assert_allclose(rows.applied(f)[wet], -(rows.measure * slope(pool, grad))[wet], atol=1e-12)


@dims
@both
def test_diagonal_is_minus_the_sum_of_the_rest(dim, kind):
    # Psi_II = -sum Psi_IJ, missing in the printed Eq. A6: with a unit diagonal the values sum to one
    pool = pool_of(dim, 0.8)
    rows, wet = filled(pool, kind), pool.role == WET
    np.testing.assert_allclose(rows.sums()[wet], 1.0, atol=1e-12)
    np.testing.assert_allclose(rows.applied(np.full(pool.n, 9.0))[wet], 0.0, atol=1e-12)


@dims
@both
def test_only_wet_rows_are_written_and_dry_walls_are_in_no_row(dim, kind):
    pool = pool_of(dim, 0.4)
    pool.role[(pool.kind == WALL) & (pool.x[:, 0] == 0.0) & (pool.role == WET)] = DRY
    rows = filled(pool, kind)
    others = pool.role != WET
    assert np.all(rows.count[others] == 0) and np.isnan(rows.measure[others]).all()
    used = np.concatenate([rows.entries(i)[0] for i in np.flatnonzero(~others)])
    assert used.size and not np.isin(pool.role[used], (DRY, CONTACT)).any()
    if kind == "sfdi":
        for f, grad, _ in monomials(pool.x, 1):
            sound = (pool.role == WET) & (rows.measure > 0.0)
            np.testing.assert_allclose(rows.applied(f)[sound], -(rows.measure * slope(pool, grad))[sound], atol=1e-12)


def test_sfdi_row_is_the_printed_formula():
    # Zheng, Ma & Duan 2014, Eq. A6 for J != I
    pool = pool_of(2, 0.8)
    i = pool.at(4, 0)
    pool.normal[i] = 0.6, 0.8
    rows = filled(pool, "sfdi")
    columns, values = rows.entries(i)
    r = pool.x[columns] - pool.x[i]
    r2 = (r**2).sum(axis=1)
    w = np.array([quartic_weight(value, (RADIUS * pool.spacing) ** 2) for value in r2])
    n_x, n_y, n_xy = (w / r2) @ r[:, 0] ** 2, (w / r2) @ r[:, 1] ** 2, (w / r2) @ (r[:, 0] * r[:, 1])
    b = r.T * w / r2
    psi = ((n_y * b[0] - n_xy * b[1]) * 0.6 + (n_x * b[1] - n_xy * b[0]) * 0.8) / (n_x * n_y - n_xy**2)
    np.testing.assert_allclose(values / rows.measure[i], psi, rtol=1e-10)


@dims
@both
def test_rows_do_not_depend_on_the_direction_of_the_axes(dim, kind):
    pool = pool_of(dim, 0.8)
    turn = np.linalg.qr(np.random.default_rng(0).normal(size=(dim, dim)))[0]
    before = filled(pool, kind)
    pool.x[:], pool.normal[:] = pool.x @ turn.T, pool.normal @ turn.T  # the same lists
    after, wet = filled(pool, kind), pool.role == WET
    np.testing.assert_array_equal(before.count, after.count)
    # SFDI is invariant; the harmonic fit is unique in its space, which turns into itself
    np.testing.assert_allclose(after.measure[wet], before.measure[wet], rtol=1e-9)
    for i in np.flatnonzero(wet):
        np.testing.assert_allclose(after.entries(i)[1], before.entries(i)[1], atol=1e-9)


@dims
@both
def test_wall_whose_neighbours_lie_along_it_takes_their_mean(dim, kind):
    pool = pool_of(dim)
    pool.role[(pool.kind == WALL) & (pool.index[:, -1] > 0)] = DRY
    pool.x[pool.fluid] += 50.0
    pool.relist()
    rows = filled(pool, kind)
    i = pool.at(*[2] * (dim - 1), 0)
    columns, values = rows.entries(i)
    assert rows.measure[i] == 0.0
    assert len(values) >= 4 and np.all(values > 0.0) and values.sum() == pytest.approx(1.0, rel=1e-14)
    near = np.linalg.norm(pool.x[columns] - pool.x[i], axis=1)
    assert np.all(np.diff(values[np.argsort(near)]) <= 1e-12), "nearer neighbours weigh more"


@both
def test_wall_that_leans_on_fluid_beside_it_takes_the_mean(kind):
    # all neighbours within one narrow wedge along the wall: no normal derivative to speak of
    pool = pool_of(2)
    i = pool.at(4, 0)
    keep = (pool.index == [5, 0]).all(axis=1) | (pool.index == [6, 0]).all(axis=1)
    pool.role[(pool.kind == WALL) & ~keep] = DRY
    pool.role[i] = WET
    pool.x[pool.fluid] += 50.0
    pool.x[pool.at(5, 1)] = pool.x[pool.at(5, 0)] + [0.0, 0.02 * pool.spacing]
    pool.relist()
    rows = filled(pool, kind)
    assert rows.measure[i] == 0.0 and rows.count[i] == 3
    assert np.all(rows.entries(i)[1] > 0.0) and rows.entries(i)[1].sum() == pytest.approx(1.0, rel=1e-14)


@both
def test_wall_with_fluid_behind_it_takes_the_mean(kind):
    # the normal derivative would have a diagonal of the wrong sign
    pool = pool_of(2, 0.4)
    pool.role[pool.kind == WALL] = DRY
    i = pool.at(4, 0)
    pool.role[i] = WET
    pool.x[pool.fluid, 1] *= -1.0
    pool.relist()
    rows = filled(pool, kind)
    assert rows.measure[i] == 0.0
    values = rows.entries(i)[1]
    assert len(values) > 6 and np.all(values > 0.0) and values.sum() == pytest.approx(1.0, rel=1e-14)


@both
def test_wall_alone_has_an_empty_row(kind):
    pool = pool_of(2)
    i = pool.at(4, 0)
    pool.role[pool.kind == WALL] = DRY
    pool.role[i] = WET
    pool.x[pool.fluid] += 50.0
    pool.relist()
    rows = filled(pool, kind)
    assert rows.count[i] == 0 and rows.measure[i] == 0.0


def test_harmonic_rows_leave_sfdi_where_neighbours_are_few():
    pool = pool_of(2)
    keep = (np.abs(pool.index - [4, 1]) <= [0, 0]).all(axis=1) | (pool.index == [3, 1]).all(axis=1)
    pool.role[(pool.kind == WALL) & (np.abs(pool.index - [4, 0]) > [1, 0]).any(axis=1)] = DRY
    pool.x[pool.fluid & ~keep] += 50.0
    pool.relist()
    i = pool.at(4, 0)
    first, second = filled(pool, "sfdi"), filled(pool, "harmonic")
    assert first.count[i] == second.count[i] == 4 and first.measure[i] > 0.0
    np.testing.assert_array_equal(first.entries(i)[1], second.entries(i)[1])
    assert first.measure[i] == second.measure[i]


@pytest.mark.parametrize("kind", ["sfdi", "harmonic"])
def test_no_value_of_any_row_in_a_corner_is_below_the_limit(kind):
    """A few particles anywhere in a corner; harmonic rows without the limit have values down to -63."""
    random, mixed = np.random.default_rng(1), 0
    for _ in range(60):
        pool = pool_of(2)
        n, corner = random.integers(4, 9), pool.x[pool.at(0, 0)].copy()
        pool.role[pool.kind == WALL] = DRY
        pool.role[[pool.at(k, 0) for k in range(4)] + [pool.at(0, k) for k in range(1, 4)]] = WET
        pool.x[pool.fluid] += 50.0
        for m, place in enumerate(random.uniform(0.3, 3.0, (n, 2))):
            pool.x[pool.at(1 + m % 6, 1 + m // 6)] = corner + place * pool.spacing
        pool.relist()
        rows = filled(pool, kind)
        lowest = np.array([rows.entries(i)[1].min(initial=0.0) for i in np.flatnonzero(pool.role == WET)])
        assert lowest.min() > -walls.UNSOUND - 1e-9
        mixed += np.count_nonzero(lowest < 1e-9 - walls.UNSOUND)
    assert mixed > 10


def test_wall_above_all_of_the_water_in_a_corner_extrapolates_only_so_far():
    # what was left of a cavity that closed in a corner: the sum of the values was one by 11 and -6
    pool = pool_of(2)
    i, s = pool.at(0, 2), pool.spacing
    pool.role[(pool.kind == WALL)] = DRY
    pool.role[[pool.at(0, 0), pool.at(1, 0), i]] = WET
    pool.x[pool.fluid] += 50.0
    corner = pool.x[pool.at(0, 0)].copy()
    for m, place in enumerate([(0.97, 0.35), (0.32, 0.32), (1.52, 0.29), (2.29, 3.13)]):
        pool.x[pool.at(1 + m, 1)] = corner + np.array(place) * s
    pool.relist()
    rows = filled(pool, "sfdi")
    columns, values = rows.entries(i)
    assert len(values) == 6 and values.sum() == pytest.approx(1.0, rel=1e-14)
    assert values.min() == pytest.approx(-walls.UNSOUND, rel=1e-12) and 0.0 < rows.measure[i] < 2.0 * s
    # the share of the mean follows from what the row finds along the wall, and explains what it finds across
    x, y = ((pool.x[columns] - pool.x[i]) / s).T
    weight = np.array([quartic_weight(value, RADIUS**2) / value for value in x**2 + y**2])
    mean = weight / weight.sum()
    of_mean = (values @ y) / (mean @ y)
    assert 0.8 < of_mean < 1.0
    assert values @ x - of_mean * (mean @ x) == pytest.approx(rows.measure[i] / s, rel=1e-9)
