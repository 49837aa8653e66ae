"""The work of a displacement in a force field leaves the energy as it was."""

import numpy as np
import pytest

from parisph.base.fields import FLUID, WALL
from parisph.kernels.jit import axes_of
from parisph.kernels.shifting import limit_work, take_work


@pytest.mark.parametrize("dim", [2, 3])
def test_energy_stays_and_the_direction_too(dim):
    rng = np.random.default_rng(3)
    u = rng.normal(size=(20, dim))
    move = 1e-4 * rng.normal(size=(20, dim))
    force = np.tile([0.0, -9.81, 0.0][:dim], (25, 1))
    before = u.copy()
    take_work(u, move, force, np.full(20, FLUID, np.int8), 20, axes_of(dim))
    energy = 0.5 * (u**2).sum(axis=1) - 0.5 * (before**2).sum(axis=1) + 9.81 * move[:, 1]
    assert np.abs(energy).max() < 1e-15 * 1e3
    assert np.abs(u / before - (u / before)[:, :1]).max() < 1e-12
    assert np.abs(u - before).max() > 1e-6


def test_more_work_than_there_is_speed_stops_the_particle():
    u = np.array([[0.1, 0.0], [0.1, 0.0]])
    take_work(u, np.array([[0.0, 1.0], [0.0, 1.0]]), np.tile([0.0, -9.81], (2, 1)), np.array([FLUID, WALL], np.int8), 2, axes_of(2))
    assert u[0, 0] == 0.0 and u[1, 0] == 0.1


@pytest.mark.parametrize("force", [(0.0, -9.81), (4.0, -9.0)])
def test_slow_particles_are_moved_along_the_force_by_what_their_speed_pays(force):
    u = np.array([[0.1, 0.0], [0.0, 0.0], [0.1, 0.0], [0.0, 0.0], [9.0, 0.0]])
    move = np.array([[2e-3, 1e-2], [2e-3, 1e-2], [2e-3, 1e-2], [2e-3, -1e-2], [2e-3, 1e-2]])
    before, force = move.copy(), np.tile(force, (5, 1))
    limit_work(move, u, force, np.array([FLUID, FLUID, WALL, FLUID, FLUID], np.int8), 0.1, 5, axes_of(2))
    work = (force * move).sum(axis=1)
    assert work[0] == pytest.approx(-0.1 * 0.5 * 0.1**2)
    assert work[[1, 3]] == pytest.approx(0.0, abs=1e-15), "fluid at rest is neither lifted nor lowered"
    across = np.array([-force[0, 1], force[0, 0]])
    assert move @ across == pytest.approx(before @ across), "across the force everything may move"
    assert np.array_equal(move[[2, 4]], before[[2, 4]]), "walls are none of its business, and fast fluid can pay"
