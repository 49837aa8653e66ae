"""Water at rest between walls of any shape stays at rest, with hydrostatic pressure."""

import numpy as np
import pytest
from mpi4py import MPI

from parisph.base.fields import FLUID, INNER, SURFACE, WET
from parisph.driver import Simulation
from tests.solid_scenes import DENSITY, WALLS, G, level, still

STEPS = 60


@pytest.mark.parametrize(("preset", "jitter"), [("violent", 0.0), ("violent", 0.4), ("gentle", 0.4)])
@pytest.mark.parametrize("name", WALLS)
def test_water_rests(name, preset, jitter):
    """u in sqrt(g d), p in rho g d, with d = 1 m; ten layers of particles."""
    s = Simulation(still(name, preset, jitter=jitter), MPI.COMM_SELF)
    p, speed = s.particles, 0.0
    for _ in range(STEPS):
        s.advance()
        speed = max(speed, np.abs(p.u[p.kind == FLUID]).max())
    used = np.isin(p.role, (INNER, SURFACE, WET))
    due = DENSITY * G * np.maximum(level(name, p.x, p.normal) - p.x[:, 1], 0.0)
    assert np.abs(p.p - due)[used].max() < 1e-10 * DENSITY * G
    assert speed < 1e-10 * np.sqrt(G)
    assert (p.role == WET).any()
    s.destroy()
