"""Regularisation of positions makes and takes no energy, and does not stir what is at rest."""

from types import SimpleNamespace

import numpy as np
import pytest
from mpi4py import MPI

from parisph import Simulation
from parisph.base.fields import FLUID
from parisph.methods import regularise
from tests.scenes import scene

G = 9.81


def energy(p):
    return 0.5 * p.volume @ (p.u**2).sum(axis=1) + G * p.volume @ p.x[:, 1]


@pytest.fixture
def falling():
    """A column that has fallen for a while, with roles, lists and matrix of its last step."""
    s = Simulation(scene("dam_break", spacing=0.05, jitter=0.4), MPI.COMM_SELF)
    for _ in range(40):
        s.advance()
    yield s
    s.destroy()


def test_energy_of_all_fluid_stays(falling):
    p = falling.particles
    before, x, u = energy(p), p.x.copy(), p.u.copy()
    regularise.positions(falling.method, np.tile([0.0, -G], (p.n_all, 1)))
    moved = np.linalg.norm(p.x - x, axis=1) / falling.numerics.spacing
    assert moved.max() > 1e-3 and moved[p.kind != FLUID].max() == 0.0
    assert energy(p) == pytest.approx(before, rel=1e-13)
    factor = p.u[p.kind == FLUID] / u[p.kind == FLUID]
    assert np.ptp(factor) < 1e-12 and factor[0, 0] != 1.0, "all motion pays alike"


@pytest.mark.parametrize(("speed", "share"), [(0.0, 0.0), (0.01, 0.1 * 0.5 * 0.01**2 / (G * 1e-3)), (10.0, 1.0)])
def test_moves_wait_for_the_motion_that_pays(speed, share):
    p = SimpleNamespace(comm=MPI.COMM_SELF, n_owned=3, volume=np.array([1.0, 0.5, 0.0]), u=np.full((3, 2), [speed, 0.0]))
    move, force = np.tile([5e-4, 1e-3], (3, 1)), np.tile([0.0, -G], (4, 1))
    done, scale = regularise._paid(p, move, force)
    assert done == pytest.approx(share)
    lifted, paid = G * done * 1e-3, 0.5 * speed**2 * (1.0 - scale**2)
    assert paid == pytest.approx(lifted, abs=1e-12)


def test_without_a_force_everything_moves():
    p = SimpleNamespace(comm=MPI.COMM_SELF, n_owned=2, volume=np.ones(2), u=np.zeros((2, 2)))
    assert regularise._paid(p, np.ones((2, 2)), np.zeros((2, 2))) == (1.0, 1.0)
