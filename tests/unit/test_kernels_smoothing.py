"""Smoothing kernels and the weight of the least squares."""

import numpy as np
import pytest

from parisph.kernels import smoothing
from tests.pools import dims

H = 0.7
VALUE, SLOPE = smoothing.cubic_spline, smoothing.cubic_spline_slope


def sampled(function, r, dim, h=H):
    return np.array([function(value, h, dim) for value in r])


@dims
def test_integral_is_one(dim):
    # Gauss points on each polynomial piece: exact up to rounding
    nodes, weights = np.polynomial.legendre.leggauss(12)
    total = 0.0
    for lower in (0.0, H):
        r = lower + 0.5 * H * (nodes + 1.0)
        shell = 2.0 * np.pi * r if dim == 2 else 4.0 * np.pi * r**2
        total += 0.5 * H * weights @ (shell * sampled(VALUE, r, dim))
    assert total == pytest.approx(1.0, abs=1e-13)


@dims
def test_slope_is_the_derivative_over_r(dim):
    r = np.linspace(0.02, 2.2, 137) * H  # not on the knots 1 and 2, where the third derivative jumps
    d = 1e-5 * H
    difference = (sampled(VALUE, r + d, dim) - sampled(VALUE, r - d, dim)) / (2.0 * d * r)
    scale = abs(sampled(SLOPE, np.zeros(1), dim)[0])
    np.testing.assert_allclose(sampled(SLOPE, r, dim), difference, atol=1e-8 * scale)


@dims
def test_slope_is_finite_where_particles_coincide(dim):
    at, near = SLOPE(0.0, H, dim), SLOPE(1e-7 * H, H, dim)
    assert np.isfinite(at) and at < 0.0 and near == pytest.approx(at, rel=1e-6)


@dims
def test_support_is_compact_and_values_fall(dim):
    inside = sampled(VALUE, np.linspace(0.0, 1.999, 200) * H, dim)
    assert np.all(np.diff(inside) < 0.0) and inside[-1] > 0.0
    for q in (2.0, 2.0000001, 3.0, 1e9):
        assert VALUE(q * H, H, dim) == 0.0 and SLOPE(q * H, H, dim) == 0.0
    assert inside[-1] < 1e-6 * inside[0], "no jump at the edge of the support"


@dims
def test_value_scales_with_the_smoothing_length(dim):
    for q in (0.0, 0.3, 1.0, 1.7):
        assert VALUE(3.0 * q, 3.0, dim) == pytest.approx(VALUE(q, 1.0, dim) / 3.0**dim, rel=1e-14)
        assert SLOPE(3.0 * q, 3.0, dim) == pytest.approx(SLOPE(q, 1.0, dim) / 3.0 ** (dim + 2), rel=1e-14)


def test_cubic_spline_is_that_of_the_paper():
    scale = 15.0 / (7.0 * np.pi * H**2)
    assert smoothing.cubic_spline(0.0, H, 2) == pytest.approx(scale * 2.0 / 3.0, rel=1e-14)
    assert smoothing.cubic_spline(0.5 * H, H, 2) == pytest.approx(scale * (2.0 / 3.0 - 0.25 + 0.0625), rel=1e-14)
    assert smoothing.cubic_spline(1.5 * H, H, 2) == pytest.approx(scale * 0.125 / 6.0, rel=1e-14)
    below, above = (smoothing.cubic_spline((1.0 + sign * 1e-12) * H, H, 2) for sign in (-1, 1))
    assert below == pytest.approx(above, rel=1e-10)


def test_least_squares_weight_is_smooth_at_its_edge():
    radius2 = 0.81
    q = np.linspace(0.0, 1.0, 201)
    weight = np.array([smoothing.quartic_weight(value**2 * radius2, radius2) for value in q])
    np.testing.assert_allclose(weight, 1.0 - 6.0 * q**2 + 8.0 * q**3 - 3.0 * q**4, atol=1e-14)
    assert weight[0] == 1.0 and np.all(np.diff(weight) < 0.0)
    # (1 - q)^3 (1 + 3 q): value, first and second derivative vanish at the edge
    np.testing.assert_allclose(weight, (1.0 - q) ** 3 * (1.0 + 3.0 * q), atol=1e-14)
    for q_outside in (1.0, 1.1, 100.0):
        assert smoothing.quartic_weight(q_outside**2 * radius2, radius2) == 0.0
