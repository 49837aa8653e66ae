"""Scenes of water between walls of any shape, as cases. The water is 1 m deep."""

import numpy as np
from mpi4py import MPI

from parisph import Box, Case, Fluid, Numerics, Obstacle, Plate, Polygon, Profile, StillWater, Tank
from parisph.base.fields import FLUID, INNER, SURFACE, WET
from parisph.driver import Simulation

G, DENSITY = 9.81, 1000.0


def beach(degrees):
    end = 1.2 / np.tan(np.radians(degrees))
    return (Profile([(0.0, 1.3), (0.0, 0.0), (1.5, 0.0), (1.5 + end, 1.2)]),)


WALLS = {
    "slope 3": beach(3.0), "slope 15": beach(15.0), "slope 20": beach(20.0), "slope 30": beach(30.0),
    "slope 45": beach(45.0), "slope 60": beach(60.0),
    "sill": (Tank(4.0, 1.3), Obstacle(Polygon([(1.0, 0.0), (1.4, 0.4), (2.0, 0.4), (2.4, 0.0)]))),
    "box": (Tank(3.0, 1.3), Obstacle(Box(width=0.5, height=0.5, at=(1.2, 0.0)))),
    "plate": (Tank(2.0, 1.3), Plate([(1.0, 0.0), (1.0, 1.2)])),
    "basin": (Profile([(0.0, 1.3), (0.2, 0.5), (0.7, 0.1), (1.2, 0.0), (1.9, 0.2), (2.1, 0.8), (2.2, 1.3)]),),
}


def still(name, preset, spacing=0.1, **numerics):
    """Return the Case of water at rest in one of these scenes; behind the plate it is half as deep."""
    water = (Fluid(StillWater(1.0), density=DENSITY),)
    if name == "plate":
        water = (Fluid(Box(width=1.0, height=1.0), density=DENSITY),
                 Fluid(Box(width=1.0, height=0.5, at=(1.0, 0.0)), density=DENSITY))
    step = 0.01 if preset == "gentle" else 0.008
    return Case(title=name, fluid=water, walls=WALLS[name], gravity=(0.0, -G), end_time=100.0, numerics=Numerics(
        spacing=spacing, preset=preset, rtol=1e-12, time_step=step / np.sqrt(G), **numerics))


def level(name, x, normal):
    """Return the level [m] of the water at x (n, dim) [m], with the normals (n, dim) of wall particles there."""
    return np.where((name == "plate") & (x[:, 0] + 1e-3 * normal[:, 0] > 1.0), 0.5, 1.0)


def errors_at_rest(case, name, steps):
    """Return of each step the greatest speed over sqrt(g d) and pressure error over rho g d, (steps,) each.

    case : of `still`, or of other water with the level 1 m
    """
    s = Simulation(case, MPI.COMM_SELF)
    p, speed, error = s.particles, np.empty(steps), np.empty(steps)
    for n in range(steps):
        s.advance()
        speed[n] = np.linalg.norm(p.u[p.kind == FLUID], axis=1).max() / np.sqrt(G)
        depth = level(name, p.x, p.normal) - p.x[:, -1]
        # beside walls meshed anew a node just above the level may be wet: its pressure goes on as below
        used = np.isin(p.role, (INNER, SURFACE)) | ((p.role == WET) & (depth > -1e-9))
        due = DENSITY * G * np.maximum(depth, 0.0)
        error[n] = np.abs(p.p - due)[used].max() / (DENSITY * G)
    assert (p.role == WET).any()
    s.destroy()
    return speed, error
