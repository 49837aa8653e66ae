"""Pressure rows that are exact for quadratics: finite differences, quadratic circle, corrected second derivatives."""

import numpy as np
import pytest

from parisph.base.fields import DRY, INNER, SURFACE
from parisph.kernels import fatehi, gfd, quadratic_circle, rankine, row
from parisph.kernels.circle import Circle
from parisph.kernels.smoothing import cubic_spline_slope, quartic_weight
from tests.pools import Rows, block, dims, free, monomials

names = pytest.mark.parametrize("name", ["gfd", "circle", "fatehi"])
H, RADIUS, CIRCLE = 1.8, 2.6, 1.0


def filled(pool, name):
    rows, s = Rows(pool), pool.spacing
    if name == "gfd":
        gfd.gfd_rows(rows.matrix, pool.cloud, RADIUS * s)
    elif name == "circle":
        circle = Circle(rankine.directions(pool.dim), CIRCLE * s, RADIUS * s)
        quadratic_circle.quadratic_rankine_rows(rows.matrix, pool.cloud, circle)
    else:
        fatehi.fatehi_rows(rows.matrix, pool.cloud, H * s)
    return rows


def cloud(dim, jitter=0.0):
    return block(dim, 9 if dim == 2 else 7, jitter, reach=3.6)


def laplacians(rows, f):
    kept = rows.measure > 0.0
    return rows.applied(f)[kept] / -rows.measure[kept]


@dims
@names
@pytest.mark.parametrize("jitter", [0.0, 0.8, 1.2])
def test_quadratics_are_exact_in_every_row_that_is_kept(dim, name, jitter):
    pool = cloud(dim, jitter)
    rows = filled(pool, name)
    assert np.all(rows.measure[pool.far_inside(1 if jitter == 0.0 else 2)] > 0.0)
    for degree in (1, 2):
        for f, _, exact in monomials(pool.x - 0.3, degree):
            np.testing.assert_allclose(laplacians(rows, 2.0 + f), exact, atol=1e-8)


@dims
@names
def test_rows_given_up_are_those_at_the_rim(dim, name):
    pool = cloud(dim)
    rows = filled(pool, name)
    assert np.all(rows.count[rows.measure == 0.0] == 0) and np.all(rows.count[rows.measure > 0.0] > 0)
    np.testing.assert_array_equal((rows.measure > 0.0) & pool.far_inside(1), pool.far_inside(1))


def test_finite_differences_are_a_least_squares_fit():
    pool = cloud(2, 0.8)
    i, radius = pool.at(4, 4), RADIUS * pool.spacing
    p = np.random.default_rng(1).normal(size=pool.n)
    r = np.delete(pool.x - pool.x[i], i, axis=0)
    root = np.sqrt([quartic_weight(v, radius**2) for v in (r * r).sum(axis=1)])
    x, y = r.T
    fit = np.linalg.lstsq(root[:, None] * np.stack([x, y, 0.5 * x * x, x * y, 0.5 * y * y], axis=1),
                          root * (np.delete(p, i) - p[i]), rcond=None)[0]
    rows = filled(pool, "gfd")
    assert rows.applied(p)[i] / -rows.measure[i] == pytest.approx(fit[2] + fit[4], rel=1e-9)


def test_quadratic_circle_is_the_mean_of_the_fit_over_the_circle():
    pool = cloud(2, 0.8)
    i, radius, circle = pool.at(4, 4), RADIUS * pool.spacing, CIRCLE * pool.spacing
    p, mean = np.random.default_rng(2).normal(size=pool.n), 0.0
    for direction in rankine.directions(2):
        x, y = (pool.x - pool.x[i] - circle * direction).T
        root = np.sqrt([quartic_weight(v, radius**2) for v in x * x + y * y])
        basis = np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=1)
        mean += np.linalg.lstsq(root[:, None] * basis, root * p, rcond=None)[0][0] / 8.0
    rows = filled(pool, "circle")
    assert rows.applied(p)[i] / -rows.measure[i] == pytest.approx(4.0 / circle**2 * (mean - p[i]), rel=1e-8)
    # the share of the particle itself is in the diagonal, and what is left has the moment of the circle
    columns, values = rows.entries(i)
    assert values @ ((pool.x[columns] - pool.x[i]) ** 2).sum(axis=1) == pytest.approx(4.0 * rows.measure[i], rel=1e-10)


@dims
def test_corrected_second_derivatives_solve_for_the_whole_tensor(dim):
    # sum_j 2V e grad W [(p_i - p_j)/r - e . grad p] for every quadratic, and the tensor B that turns it to 1
    pool = cloud(dim, 0.8)
    i, h, volume = pool.at(*[3] * dim), H * pool.spacing, pool.spacing**pool.dim
    r = pool.x[i] - np.delete(pool.x, i, axis=0)
    length = np.linalg.norm(r, axis=1)
    e = r / length[:, None]
    grad_w = np.array([cubic_spline_slope(d, h, dim) for d in length])[:, None] * r
    inverse = np.linalg.inv(-volume * r.T @ grad_w)

    def tensor_of(p):
        grad = inverse @ (volume * (np.delete(p, i) - p[i]) @ grad_w)
        return 2.0 * volume * np.einsum("ja,jb,j->ab", e, grad_w, (p[i] - np.delete(p, i)) / length - e @ grad)

    quadratics = monomials(pool.x, 2)
    upper = [(a, b) for a in range(dim) for b in range(a + 1)]
    system = np.array([[tensor_of(f)[a, b] * (1.0 if a == b else 2.0) for a, b in upper] for f, _, _ in quadratics])
    b = np.linalg.solve(system, [exact for _, _, exact in quadratics])
    p = np.random.default_rng(3).normal(size=pool.n)
    found = sum(value * tensor_of(p)[pair] * (1.0 if pair[0] == pair[1] else 2.0) for value, pair in zip(b, upper))
    rows = filled(pool, "fatehi")
    assert rows.applied(p)[i] / -rows.measure[i] == pytest.approx(found, rel=1e-8)


@dims
@names
def test_who_is_in_a_row(dim, name):
    pool = cloud(dim, 0.8)
    pool.role[0], pool.role[1] = DRY, SURFACE
    rows, inner = filled(pool, name), pool.role == INNER
    assert np.all(rows.count[~inner] == 0) and np.isnan(rows.measure[~inner]).all()
    kept = np.flatnonzero(inner & (rows.measure > 0.0))
    np.testing.assert_allclose(rows.sums()[kept], 1.0, atol=1e-11)
    used = np.concatenate([rows.entries(i)[0] for i in kept])
    assert 0 not in used and 1 in used


@dims
def test_only_the_quadratic_circle_has_negative_values_inside(dim):
    pool = cloud(dim, 0.8)
    for name, limit in (("gfd", -1e-3), ("fatehi", -1e-3), ("circle", -0.05)):
        rows = filled(pool, name)
        lowest = min(rows.entries(i)[1].min() for i in np.flatnonzero(pool.far_inside(3)))
        assert lowest > limit and (lowest < -1e-3) == (name == "circle")


@dims
@names
@pytest.mark.parametrize("shape", ["alone", "coincident", "line", "few"])
def test_rows_without_support_are_empty(dim, name, shape):
    few = np.random.default_rng(0).uniform(-1.0, 1.0, (5 if dim == 2 else 9, dim))
    index = {"alone": np.zeros((1, dim)), "coincident": np.zeros((12, dim)),
             "line": np.arange(12)[:, None] * np.eye(dim)[:1], "few": np.vstack([np.zeros((1, dim)), few])[:dim + 3]}
    pool = free(index[shape], reach=3.6)
    rows = filled(pool, name)
    assert np.all(rows.count == 0) and np.all(rows.measure == 0.0)


@dims
@names
def test_rows_do_not_depend_on_the_order_of_the_particles(dim, name):
    pool = cloud(dim, 1.2)
    order = np.random.default_rng(0).permutation(pool.n)
    p = np.random.default_rng(1).normal(size=pool.n)
    rows = filled(pool, name)
    expected, measure = rows.applied(p), rows.measure.copy()
    pool.x = pool.x[order]
    pool.relist()
    rows = filled(pool, name)
    np.testing.assert_allclose(rows.measure, measure[order], rtol=1e-7)
    np.testing.assert_allclose(rows.applied(p[order]), expected[order], atol=1e-7)


def test_rows_given_up_can_become_the_mean_of_their_neighbours():
    pool = cloud(2)
    pool.role[0], pool.role[1] = DRY, SURFACE
    rows = filled(pool, "gfd")
    given_up, kept = (pool.role == INNER) & (rows.measure == 0.0), rows.measure > 0.0
    before = rows.applied(pool.x[:, 0])
    row.mean_rows(rows.matrix, pool.cloud, np.inf)
    assert np.count_nonzero(given_up) > 0 and np.all(rows.count[:2] == 0)
    np.testing.assert_array_equal(rows.applied(pool.x[:, 0])[kept], before[kept])
    for i in np.flatnonzero(given_up):
        columns, values = rows.entries(i)
        assert 0 not in columns and rows.measure[i] == 0.0
        np.testing.assert_allclose(values, 1.0 / len(columns), rtol=1e-14)
        listed = pool.indices[pool.indptr[i]:pool.indptr[i + 1]]
        np.testing.assert_array_equal(np.sort(columns), np.setdiff1d(listed, 0))
