"""A tank of water at rest over 10,000 steps by every method that keeps it still, from a jittered start."""

import numpy as np
from mpi4py import MPI

from parisph.base.fields import FLUID
from parisph.driver import Simulation
from tests.scenes import scene
from tests.validation.record import Row

STEPS, ASKED, JITTER, G = 10_000, 1e-6, 0.4, 9.81
METHODS = ("ISPH_R", "ISPH", "CISPH1", "CISPH2", "GFD", "ISPH_R2", "FM")


def rows(bench):
    """Return the largest speed with each method, with the preset for waves that do not break."""
    found = []
    for method in METHODS:
        speed = _largest_speed(method)
        found.append(Row(f"hydrostatic, {method}, jitter {JITTER:g}, {STEPS} steps: max u / sqrt(gd)", speed, ASKED))
        print(f"  {method}: {speed:.1e}", flush=True)
    return found


def _largest_speed(method):
    s = Simulation(scene("hydrostatic", method=method, jitter=JITTER), MPI.COMM_SELF)
    largest = 0.0
    for _ in range(STEPS):
        s.advance()
        p = s.particles
        largest = max(largest, float(np.linalg.norm(p.u[p.kind == FLUID], axis=1).max()))
    s.destroy()
    return largest / np.sqrt(G)
