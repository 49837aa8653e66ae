"""Smagorinsky's model on known velocity gradients."""

import numpy as np
import pytest

from parisph.base.fields import FLUID, WALL
from parisph.kernels import strain, turbulence
from parisph.kernels.jit import axes_of
from tests.pools import block

dims = pytest.mark.parametrize("dim", [2, 3])
LENGTH = 0.012


def modelled(g, kind, isotropic=0.0):
    """Return (nu_t, tau/rho) of velocity gradients (n, dim, dim)."""
    nu_t, tau, axes = np.full(len(g), np.nan), np.full(g.shape, np.nan), axes_of(g.shape[1])
    turbulence.eddy_viscosity(nu_t, g, kind, LENGTH, axes)
    turbulence.stress(tau, nu_t, g, kind, LENGTH, isotropic, axes)
    return nu_t, tau


@dims
def test_simple_shear(dim):
    """du/dy = q: nu_t = length^2 q, and only tau_xy = nu_t q."""
    g = np.zeros((2, dim, dim))
    g[:, 0, 1] = 3.0
    nu_t, tau = modelled(g, np.array([FLUID, WALL], np.int8))
    np.testing.assert_allclose(nu_t, [LENGTH**2 * 3.0, 0.0], rtol=1e-14)
    expected = np.zeros((dim, dim))
    expected[0, 1] = expected[1, 0] = (LENGTH * 3.0) ** 2
    np.testing.assert_allclose(tau[0], expected, rtol=1e-14)
    assert np.all(tau[1] == 0.0)


@dims
@pytest.mark.parametrize("isotropic", [0.0, 0.46])
def test_stress_of_any_gradient(dim, isotropic):
    g = np.random.default_rng(0).normal(size=(20, dim, dim))
    nu_t, tau = modelled(g, np.zeros(20, np.int8), isotropic)
    s = 0.5 * (g + g.transpose(0, 2, 1))
    rate = np.sqrt(2.0 * np.einsum("iab,iab->i", s, s))
    np.testing.assert_allclose(nu_t, LENGTH**2 * rate, rtol=1e-13)
    sphere = 2.0 / 3.0 * (nu_t * np.einsum("iaa->i", s) + isotropic * (LENGTH * rate) ** 2)
    np.testing.assert_allclose(tau, 2.0 * nu_t[:, None, None] * s - sphere[:, None, None] * np.eye(dim),
                               rtol=1e-12, atol=1e-18)


@dims
def test_rotation_has_no_stress(dim):
    spin = np.random.default_rng(1).normal(size=(4, dim, dim))
    nu_t, tau = modelled(spin - spin.transpose(0, 2, 1), np.zeros(4, np.int8), isotropic=0.5)
    assert np.all(nu_t == 0.0) and np.all(tau == 0.0)


def test_of_the_gradient_of_disordered_particles():
    pool = block(2, 7, jitter=0.8)
    g, rate = np.empty((pool.n, 2, 2)), np.empty(pool.n)
    strain.velocity_gradient(g, rate, np.empty((0, 2)), pool.cloud, pool.x[:, ::-1] * [5.0, 0.0], 2.1 * pool.spacing,
                             0.05)
    nu_t, tau = modelled(g, pool.kind)
    np.testing.assert_allclose(nu_t, LENGTH**2 * 5.0, rtol=1e-11)
    np.testing.assert_allclose(tau[:, 0, 1], (LENGTH * 5.0) ** 2, rtol=1e-11)
