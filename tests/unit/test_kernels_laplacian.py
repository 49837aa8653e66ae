"""SPH pressure rows, Zheng, Ma & Duan (2014), Eq. 20a."""

import numpy as np
import pytest

from parisph.base.fields import DRY, INNER, SURFACE
from parisph.kernels import laplacian
from parisph.kernels.smoothing import cubic_spline_slope
from tests.pools import Rows, block, dims, free

H = 1.8


def filled(pool):
    rows = Rows(pool)
    laplacian.isph_rows(rows.matrix, pool.cloud, H * pool.spacing, pool.spacing**pool.dim)
    return rows


def cloud(dim, jitter=0.0):
    return block(dim, 11 if dim == 2 else 9, jitter, reach=3.6)


@dims
@pytest.mark.parametrize("jitter", [0.0, 0.8])
def test_row_is_the_printed_sum(dim, jitter):
    pool = cloud(dim, jitter)
    i, h = pool.at(*[4] * dim), H * pool.spacing
    p = np.random.default_rng(0).normal(size=pool.n)
    expected = 0.0
    for j in set(range(pool.n)) - {i}:
        r = pool.x[i] - pool.x[j]
        r2 = r @ r
        r_dot_grad_w = r2 * cubic_spline_slope(np.sqrt(r2), h, dim)
        expected += 2.0 * pool.spacing**dim * r_dot_grad_w / (r2 + (0.1 * h) ** 2) * (p[i] - p[j])
    rows = filled(pool)
    assert rows.applied(p)[i] / -rows.measure[i] == pytest.approx(expected, rel=1e-10)


@dims
def test_parabola_on_the_lattice(dim):
    pool = cloud(dim)
    rows, inside = filled(pool), pool.far_inside(4)
    f = (pool.x**2).sum(axis=1)
    found = rows.applied(f)[inside] / -rows.measure[inside]
    # delta and the sum in place of the integral leave an error that no refinement removes
    np.testing.assert_allclose(found, 2.0 * dim, rtol=0.03)
    finer = block(dim, 11 if dim == 2 else 9, spacing=0.01, reach=3.6)
    rows = filled(finer)
    np.testing.assert_allclose((rows.applied((finer.x**2).sum(axis=1)) / -rows.measure)[inside], found, rtol=1e-8)


@dims
def test_linear_pressure_on_the_lattice(dim):
    pool = cloud(dim)
    rows, inside = filled(pool), pool.far_inside(4)
    np.testing.assert_allclose(rows.applied(pool.x @ np.arange(1.0, dim + 1.0))[inside], 0.0, atol=1e-13)


@dims
@pytest.mark.parametrize("jitter", [0.0, 1.2])
def test_rows_have_positive_values_that_sum_to_one(dim, jitter):
    pool = cloud(dim, jitter)
    pool.role[0], pool.role[1] = DRY, SURFACE
    rows = filled(pool)
    inner = pool.role == INNER
    np.testing.assert_allclose(rows.sums()[inner], 1.0, atol=1e-12)
    assert np.all(rows.count[~inner] == 0)
    used, values = zip(*[rows.entries(i) for i in np.flatnonzero(inner)])
    assert 0 not in np.concatenate(used) and 1 in np.concatenate(used)
    assert np.concatenate(values).min() >= 0.0, "a diagonally dominant matrix"


@dims
@pytest.mark.parametrize("index", [[0.0], [0.0, 0.0, 0.0], [0.0, 3.59]])
def test_rows_without_neighbours_in_the_support_stay_finite(dim, index):
    pool = free(np.array(index)[:, None] * np.eye(dim)[:1], reach=3.7)
    rows = filled(pool)
    if len(index) == 2:
        assert np.all(rows.measure > 0.0)
        pool.reach, pool.x[1, 0] = 3.7, 3.65 * pool.spacing
        pool.relist()
        rows = filled(pool)
    assert np.all(rows.measure == 0.0)
    for i in range(pool.n):
        assert np.isfinite(rows.entries(i)[1]).all()
