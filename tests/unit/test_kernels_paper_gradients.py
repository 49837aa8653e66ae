"""The four pressure gradients of Zheng et al. (2017), Eqs. 25-32, against the printed formulas put right."""

import numpy as np
import pytest

from parisph.base.fields import BALLISTIC
from parisph.kernels import gradient
from parisph.kernels.near import SPLINE, SPLINE_SLOPE, Form
from parisph.kernels.smoothing import cubic_spline, cubic_spline_slope
from tests.pools import block, dims, monomials, nowhere

weights = pytest.mark.parametrize("weight", [SPLINE_SLOPE, SPLINE])
H = 1.8
REACH = 2.0 * H


def cloud(dim, jitter):
    return block(dim, 9 if dim == 2 else 6, jitter, reach=REACH)


def least_squares(pool, f, weight, radius=REACH):
    out = np.full((pool.n, pool.dim), np.nan)
    gradient.least_squares_gradient(out, nowhere(out), pool.cloud, f, Form(radius * pool.spacing, weight, 0.05))
    return out


def symmetric(pool, f):
    out = np.full((pool.n, pool.dim), np.nan)
    gradient.symmetric_gradient(out, pool.cloud, f, H * pool.spacing, pool.spacing**pool.dim)
    return out


def terms(pool, i, f):
    """Return r_j - r_i, f_j - f_i, W and grad_i W of the neighbours of one particle."""
    j = np.delete(np.arange(pool.n), i)
    r, h = pool.x[j] - pool.x[i], H * pool.spacing
    length = np.linalg.norm(r, axis=1)
    w = np.array([cubic_spline(d, h, pool.dim) for d in length])
    grad_w = -np.array([cubic_spline_slope(d, h, pool.dim) for d in length])[:, None] * r
    return r, f[j] - f[i], w, grad_w


def corrected_kernel(pool, i, f, volume_in_inverse):
    """Return Eq. 26 with L of Eq. 27."""
    r, difference, _, grad_w = terms(pool, i, f)
    inverse = np.linalg.inv(volume_in_inverse * r.T @ grad_w)
    return pool.spacing**pool.dim * inverse @ (difference @ grad_w)


def mixed_symmetric(pool, i, f, volume_in_inverse):
    """Return Eq. 28."""
    r, difference, w, _ = terms(pool, i, f)
    inverse = np.linalg.inv(volume_in_inverse * (r.T * w) @ r)
    return pool.spacing**pool.dim * inverse @ ((difference * w) @ r)


PRINTED = {SPLINE_SLOPE: corrected_kernel, SPLINE: mixed_symmetric}


@dims
@weights
def test_gradient_is_the_formula_with_its_missing_volume(dim, weight):
    pool = cloud(dim, 0.8)
    f, volume = np.random.default_rng(0).normal(size=pool.n), pool.spacing**dim
    out = least_squares(pool, f, weight)
    for index in (0, 2, 4):
        i = pool.at(*[index] * dim)
        np.testing.assert_allclose(out[i], PRINTED[weight](pool, i, f, volume), rtol=1e-8)


@dims
@weights
def test_printed_inverse_lacks_the_volume(dim, weight):
    pool = cloud(dim, 0.8)
    f, exact, _ = monomials(pool.x, 1)[0]
    i = pool.at(*[3] * dim)
    printed = PRINTED[weight](pool, i, f, 1.0)
    np.testing.assert_allclose(printed, pool.spacing**dim * exact[i], atol=1e-12)
    assert np.linalg.norm(printed - exact[i]) > 0.9, "only a volume of the gradient"


@dims
@weights
@pytest.mark.parametrize("jitter", [0.0, 0.8, 1.2])
def test_linear_fields_are_exact(dim, weight, jitter):
    pool = cloud(dim, jitter)
    for f, exact, _ in monomials(pool.x, 1):
        np.testing.assert_allclose(least_squares(pool, 5.0 + f, weight), exact, atol=1e-11)
    assert not np.any(pool.role == BALLISTIC)


@dims
def test_printed_symmetric_form_lacks_the_mass(dim):
    # Eq. 25: (p_i + p_j)/rho^2 grad W without m_j, so that it is larger by 1/V
    pool = block(dim, 9, reach=REACH)
    f, exact, _ = monomials(pool.x, 1)[0]
    i = pool.at(*[4] * dim)
    _, difference, _, grad_w = terms(pool, i, f)
    printed = (difference + 2.0 * f[i]) @ grad_w
    np.testing.assert_allclose(symmetric(pool, f)[i], pool.spacing**dim * printed, atol=1e-10)
    np.testing.assert_allclose(symmetric(pool, f)[i], exact[i], atol=0.01)
    assert printed[0] > 50.0 * exact[i, 0]


def test_sfdi_is_the_least_squares_gradient_with_power_2():
    # Eqs. 29-32 in the form (C_k - a_km C_m)/(1 - a_km a_mk), with the weight of this package for W
    pool = block(2, 7, jitter=0.8)
    f, i = np.random.default_rng(4).normal(size=pool.n), pool.at(3, 3)
    r, difference, _, _ = terms(pool, i, f)
    q2 = (r * r).sum(axis=1) / (2.1 * pool.spacing) ** 2
    w = np.where(q2 < 1.0, 1.0 - 6.0 * q2 + 8.0 * q2**1.5 - 3.0 * q2**2, 0.0) / q2
    n = (r.T**2 * w).sum(axis=1)
    a, c = (r[:, 0] * r[:, 1] * w).sum() / n, (r.T * difference * w).sum(axis=1) / n
    np.testing.assert_allclose(least_squares(pool, f, 2, 2.1)[i], (c - a * c[::-1]) / (1.0 - a[0] * a[1]), rtol=1e-9)
