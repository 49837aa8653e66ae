"""A tank of water at rest over 10,000 steps."""

import numpy as np
from mpi4py import MPI

from parisph.base.fields import DRY, FLUID
from parisph.driver import Simulation
from tests.scenes import scene
from tests.validation.record import Row

STEPS, G = 10_000, 9.81


def rows(bench):
    """Return the rows for a start on the lattice and for two jittered ones."""
    found = []
    for jitter in (0.0, 0.4, 0.8):
        speed, error = histories(jitter)
        name = f"hydrostatic, jitter {jitter:g}, {STEPS} steps"
        fifth = STEPS // 5
        found += [
            Row(f"{name}: max u / sqrt(gd)", speed.max(), 1e-6),
            Row(f"{name}: pressure error / rho g d", error.max(), 1e-6),
            Row(f"{name}: last fifth / second fifth of u", speed[-fifth:].max() / speed[fifth:2 * fifth].max(), 1.1),
            Row(f"{name}: last fifth / second fifth of the pressure error",
                error[-fifth:].max() / error[fifth:2 * fifth].max(), 1.1),
        ]
        print(f"  {name}: done", flush=True)
    return found


def histories(jitter, method="ISPH_R"):
    """Return the largest speed over sqrt(gd), and error of the pressure over rho g d, of each step: (STEPS,)."""
    s = Simulation(scene("hydrostatic", jitter=jitter, method=method), MPI.COMM_SELF)
    speed, error = np.empty(STEPS), np.empty(STEPS)
    for n in range(STEPS):
        s.advance()
        p = s.particles
        speed[n] = np.linalg.norm(p.u[p.kind == FLUID], axis=1).max() / np.sqrt(G)
        error[n] = np.abs(p.p / (1000.0 * G) - np.maximum(1.0 - p.x[:, 1], 0.0))[p.role != DRY].max()
    s.destroy()
    return speed, error
