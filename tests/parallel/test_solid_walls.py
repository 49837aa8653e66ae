"""A scene with an obstacle, a slope and a piston is the same on any number of ranks."""

import numpy as np
import pytest
from mpi4py import MPI

from parisph import Box, Case, Fluid, Numerics, Obstacle, Piston, Polygon, Profile, StillWater, Sway
from parisph.base.fields import FLUID
from parisph.driver import Simulation
from tests import mean_rows

G, S = 9.81, 0.05
BED = ((0.0, 0.9), (0.0, 0.0), (1.6, 0.0), (2.4, 0.8))


def scene(preset):
    return Case(title="piston, sill and slope", fluid=Fluid(StillWater(0.5), density=1000.0), walls=(
        Profile(BED), Obstacle(Polygon([(0.9, -0.1), (0.9, 0.1), (1.0, 0.2), (1.1, 0.2), (1.1, -0.1)])),
        Obstacle(Box(width=0.1, height=0.1, at=(0.6, 0.25))),
        Piston(at=0.12, motion=Sway(amplitude=0.05, frequency=3.0), side="right")), gravity=(0.0, -G),
        numerics=Numerics(spacing=S, preset=preset, jitter=0.4, rtol=1e-13, time_step=0.006), end_time=10.0)


def after(steps, comm, preset):
    """Return all particles after some steps, sorted by id, on every rank."""
    s = Simulation(scene(preset), comm)
    for _ in range(steps):
        s.advance()
    found = comm.bcast(s.gather("x", "u", "p", "role", "kind", "volume", "weight"))
    s.destroy()
    return found


@pytest.mark.parametrize("preset", ["violent", "gentle", "means"])
def test_ranks_agree(comm, preset, monkeypatch):
    """Twenty steps, in which the piston goes a third of a spacing and water at it nearly as fast."""
    if preset == "means":    # of their neighbours: all wall rows in a violent flow
        mean_rows.install(monkeypatch)
        preset = "violent"
    alone = after(20, MPI.COMM_SELF, preset) if comm.rank == 0 else None
    alone, together = comm.bcast(alone), after(20, comm, preset)
    np.testing.assert_array_equal(together["role"], alone["role"])
    np.testing.assert_array_equal(together["volume"], alone["volume"])
    np.testing.assert_allclose(together["weight"], alone["weight"], rtol=1e-12, atol=1e-12)
    fluid = alone["kind"] == FLUID
    assert np.abs(alone["u"][fluid]).max() > 0.05
    for name in ("x", "u", "p"):
        assert np.abs(together[name] - alone[name]).max() < 1e-9 * np.abs(alone[name]).max(), name
