"""The work of a displacement in a force field leaves the energy as it was."""

import numpy as np
import pytest

from parisph.base.fields import FLUID, WALL
from parisph.kernels.jit import axes_of
from parisph.kernels.shifting import take_work


@pytest.mark.parametrize("dim", [2, 3])
def test_energy_stays_and_the_direction_too(dim):
    rng = np.random.default_rng(3)
    u = rng.normal(size=(20, dim))
    move = 1e-4 * rng.normal(size=(20, dim))
    force = np.tile([0.0, -9.81, 0.0][:dim], (25, 1))
    before = u.copy()
    take_work(u, move, force, np.full(20, FLUID, np.int8), 0.1, 20, axes_of(dim))
    energy = 0.5 * (u**2).sum(axis=1) - 0.5 * (before**2).sum(axis=1) + 9.81 * move[:, 1]
    assert np.abs(energy).max() < 1e-15 * 1e3
    assert np.abs(u / before - (u / before)[:, :1]).max() < 1e-12
    assert np.abs(u - before).max() > 1e-6


def test_slow_particles_lose_a_limited_share_and_walls_none():
    u = np.array([[1e-3, 0.0], [0.0, 0.0], [1e-3, 0.0]])
    move, force = np.tile([0.0, 1e-3], (3, 1)), np.tile([0.0, -9.81], (3, 1))
    take_work(u, move, force, np.array([FLUID, FLUID, WALL], np.int8), 0.1, 3, axes_of(2))
    assert u[0, 0] == pytest.approx(1e-3 * np.sqrt(0.9))
    assert u[1, 0] == 0.0 and u[2, 0] == 1e-3
