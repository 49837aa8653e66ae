"""CISPH1 and CISPH2 pressure rows, Zheng, Ma & Duan (2014), Eqs. 20b-20d."""

import numpy as np
import pytest

from parisph.base.fields import DRY, INNER, SURFACE
from parisph.kernels import schwaiger
from parisph.kernels.smoothing import cubic_spline_slope
from tests.pools import Rows, block, dims, free, monomials

names = pytest.mark.parametrize("name", ["cisph1", "cisph2"])
H = 1.8
DEEP = 4    # layers within the support of the kernel


def filled(pool, name):
    rows, s = Rows(pool), pool.spacing
    if name == "cisph1":
        schwaiger.cisph1_rows(rows.matrix, pool.cloud, H * s, s**pool.dim)
    else:
        schwaiger.cisph2_rows(rows.matrix, pool.cloud, H * s)
    return rows


def cloud(dim, jitter=0.0):
    return block(dim, 12 if dim == 2 else 9, jitter, reach=3.6)


def laplacians(rows, f):
    return rows.applied(f) / -rows.measure


def from_the_paper(pool, i, p, name, sign=2.0):
    """Return Eq. 20b at one particle, term by term, with a sign of its second term (printed: -2)."""
    volume, h = pool.spacing**pool.dim, H * pool.spacing
    r = pool.x[i] - np.delete(pool.x, i, axis=0)    # r_ij = r_i - r_j
    difference = np.delete(p, i) - p[i]
    slope = np.array([cubic_spline_slope(d, h, pool.dim) for d in np.linalg.norm(r, axis=1)])
    grad_w = slope[:, None] * r
    r_dot_grad_w = (r * grad_w).sum(axis=1) / (r * r).sum(axis=1)
    gamma = volume * np.einsum("j,ja,jb->ab", r_dot_grad_w, r, r)
    grad = volume * difference @ grad_w
    if name == "cisph2":
        grad = np.linalg.inv(volume * (-r).T @ grad_w) @ grad
    terms = 2.0 * volume * difference @ r_dot_grad_w + sign * grad @ (volume * grad_w.sum(axis=0))
    return np.trace(np.linalg.inv(gamma)) / pool.dim * terms


@dims
@names
@pytest.mark.parametrize("jitter", [0.0, 0.8])
def test_row_is_the_corrected_sum_of_the_paper(dim, name, jitter):
    pool = cloud(dim, jitter)
    p = np.random.default_rng(0).normal(size=pool.n)
    found = laplacians(filled(pool, name), p)
    for index in (4, 2, 0):     # inside, and at the rim, where the second term matters most
        i = pool.at(*[index] * dim)
        assert found[i] == pytest.approx(from_the_paper(pool, i, p, name), rel=1e-9)


@names
def test_printed_sign_is_wrong(name):
    pool = cloud(2, 0.8)
    f, exact = pool.x[:, 0] ** 2 + pool.x[:, 1] ** 2 + 3.0 * pool.x[:, 0], 4.0
    inside = np.flatnonzero(pool.far_inside(DEEP))
    right, printed = (np.array([from_the_paper(pool, i, f, name, sign) for i in inside]) for sign in (2.0, -2.0))
    np.testing.assert_allclose(laplacians(filled(pool, name), f)[inside], right, rtol=1e-9)
    error, printed_error = (np.sqrt(np.mean((found / exact - 1.0) ** 2)) for found in (right, printed))
    assert error < {"cisph1": 0.06, "cisph2": 0.006}[name], "measured .046, .0042"
    assert printed_error > 1.0, "measured 1.7: it doubles what it should take away"


@dims
@pytest.mark.parametrize("jitter", [0.0, 0.8, 1.2])
def test_cisph2_is_exact_for_linear_pressure_on_any_particles(dim, jitter):
    rows = filled(cloud(dim, jitter), "cisph2")
    for f, _, _ in monomials(rows.pool.x, 1):
        np.testing.assert_allclose(laplacians(rows, 2.0 + f), 0.0, atol=1e-10)


@dims
def test_cisph1_is_exact_for_constants_only_once_particles_are_disordered(dim):
    pool = cloud(dim, 0.8)
    rows, deep = filled(pool, "cisph1"), pool.far_inside(3)
    np.testing.assert_allclose(laplacians(rows, np.full(pool.n, 7.0)), 0.0, atol=1e-9)
    worst = max(np.abs(laplacians(rows, f)[deep]).max() for f, _, _ in monomials(pool.x, 1))
    assert 0.01 < worst < 1.0


@dims
@names
def test_quadratics_on_the_lattice(dim, name):
    pool = cloud(dim)
    rows, inside = filled(pool, name), pool.far_inside(DEEP)
    for f, _, exact in monomials(pool.x - 0.4, 2):
        np.testing.assert_allclose(laplacians(rows, f)[inside], exact, atol=1e-10)


@dims
@names
def test_quadratics_among_disordered_particles_keep_an_error(dim, name):
    # exact only for a Gamma without direction: tr(Gamma) tr(Gamma^-1) >= dim^2
    pool = cloud(dim, 0.8)
    rows, deep = filled(pool, name), pool.far_inside(3)
    found = laplacians(rows, (((pool.x - 0.45) ** 2).sum(axis=1)))[deep]
    worst = np.abs(found / (2.0 * dim) - 1.0).max()
    assert 1e-3 < worst < 0.2


@dims
@names
def test_who_is_in_a_row(dim, name):
    pool = cloud(dim, 1.2)
    pool.role[0], pool.role[1] = DRY, SURFACE
    rows, inner = filled(pool, name), pool.role == INNER
    np.testing.assert_allclose(rows.sums()[inner], 1.0, atol=1e-12)
    assert np.all(rows.count[~inner] == 0) and np.isnan(rows.measure[~inner]).all()
    used = np.concatenate([rows.entries(i)[0] for i in np.flatnonzero(inner)])
    assert 0 not in used and 1 in used
    deep = np.flatnonzero(pool.far_inside(2))
    assert min(rows.entries(i)[1].min() for i in deep) >= 0.0, "not so everywhere at the rim"


@dims
@names
@pytest.mark.parametrize("shape", ["alone", "coincident", "pair", "line"])
def test_rows_without_support_are_empty(dim, name, shape):
    index = {"alone": np.zeros((1, dim)), "coincident": np.zeros((5, dim)), "pair": np.eye(dim)[:1] * [[0], [1]],
             "line": np.arange(9)[:, None] * np.eye(dim)[:1]}[shape]
    pool = free(index, reach=3.6)
    rows = filled(pool, name)
    assert np.all(rows.count == 0) and np.all(rows.measure == 0.0)
