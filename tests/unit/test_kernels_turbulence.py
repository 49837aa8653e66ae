"""Smagorinsky's model on known velocity gradients."""

import numpy as np

from parisph.base.fields import FLUID, WALL
from parisph.kernels import strain, turbulence
from parisph.kernels.jit import axes_of
from tests.pools import block, dims

LENGTH = 0.012


def viscosity(g, kind):
    """Return nu_t of velocity gradients (n, dim, dim)."""
    nu_t = np.full(len(g), np.nan)
    turbulence.eddy_viscosity(nu_t, g, kind, LENGTH, axes_of(g.shape[1]))
    return nu_t


@dims
def test_simple_shear(dim):
    """du/dy = q: nu_t = length^2 q."""
    g = np.zeros((2, dim, dim))
    g[:, 0, 1] = 3.0
    np.testing.assert_allclose(viscosity(g, np.array([FLUID, WALL], np.int8)), [LENGTH**2 * 3.0, 0.0], rtol=1e-14)


@dims
def test_any_gradient_and_its_rotation(dim):
    g = np.random.default_rng(0).normal(size=(20, dim, dim))
    strain_rate, spin = 0.5 * (g + g.transpose(0, 2, 1)), g - g.transpose(0, 2, 1)
    expected = LENGTH**2 * np.sqrt(2.0 * np.einsum("iab,iab->i", strain_rate, strain_rate))
    np.testing.assert_allclose(viscosity(g, np.zeros(20, np.int8)), expected, rtol=1e-13)
    assert np.all(viscosity(spin, np.zeros(20, np.int8)) == 0.0)


def test_of_the_gradient_of_disordered_particles():
    pool = block(2, 7, jitter=0.8)
    g, rate = np.empty((pool.n, 2, 2)), np.empty(pool.n)
    strain.velocity_gradient(g, rate, np.empty((0, 2)), pool.cloud, pool.x[:, ::-1] * [5.0, 0.0], 2.1 * pool.spacing,
                             0.05)
    np.testing.assert_allclose(viscosity(g, pool.kind), LENGTH**2 * 5.0, rtol=1e-11)
