"""Viscous water between walls of any shape: at rest, in a wave, and around a cylinder that turns."""

import numpy as np
import pytest

from parisph import Box, Case, Disc, Fluid, Numerics, SurfaceGauge, Tank
from parisph.base.fields import ABSENT, FLUID
from parisph.case.bodies import Obstacle, Plate, Profile, StillWater
from parisph.case.motion import Roll
from tests import viscous_flows as flows
from tests.scenes import at_end, simulated

G, NU = 9.81, 0.01


def scene(walls, fluid, spacing=0.05, probes=(), **numerics):
    return Case(title="viscous", walls=walls, fluid=fluid, gravity=(0.0, -G), end_time=100.0, probes=probes,
                numerics=Numerics(spacing=spacing, **{"preset": "gentle", "rtol": 1e-9, **numerics}))


@pytest.mark.parametrize("form", ["viscous", "viscous_morris"])
@pytest.mark.parametrize("body", [
    Obstacle(Box(0.3, 0.2, at=(0.8, 0.1)), slip="none"), Obstacle(Disc(0.12, at=(0.6, 0.3))),
    Plate([(1.0, 0.0), (1.0, 0.3)])])
def test_viscous_water_rests_around_bodies(body, form):
    water = Fluid(StillWater(0.6), density=1000.0, viscosity=NU)
    s = simulated(scene((Tank(2.0, 1.0, no_slip=body.slip == "none"), body), water, preset="violent", jitter=0.4,
                        forces=("body", form)), 20)
    assert np.abs(s.particles.u[s.particles.kind == FLUID]).max() < 1e-8


@pytest.mark.parametrize("slip, unseen", [("free", 2), ("none", 0)])
def test_viscous_water_does_not_see_convex_edges_that_it_slips_along(slip, unseen):
    """Their nodes have no row, so the velocity there is unknown."""
    block = Obstacle(Box(0.2, 0.2, at=(0.4, 0.0)), slip=slip)
    s = simulated(scene((Tank(1.0, 1.0), block), Fluid(StillWater(0.5), density=1000.0, viscosity=NU)))
    seen, _ = s.method.flow.walls.viscous(s.method.flow, s.particles.kind_all)
    assert np.count_nonzero(seen == ABSENT) == unseen


def damping(walls):
    """Return the rate [1/s] at which a standing wave loses its height, over one period."""
    water = Fluid(Box(2.0, 0.5), density=1000.0, viscosity=NU, elevation="0.01*cos(pi*x/2)")
    case = scene(walls, water, probes=[SurfaceGauge("end", at=0.0)], time_step=0.01)
    return flows.decay(case, 2.2, "end", (2.6, 3.6), 0.2)[0]


def test_a_profile_damps_a_wave_as_a_tank_of_its_shape_does():
    line = [(0.0, 0.75), (0.0, 0.0), (2.0, 0.0), (2.0, 0.75)]
    assert damping(Profile(line, slip="none")) == pytest.approx(damping(Tank(2.0, 0.75, no_slip=True)), rel=0.01)


A, CENTRE, ROLL = 0.2, np.array([1.0, 0.9]), Roll(angle=0.2, frequency=4.0, centre=(1.0, 0.9), ramp=0.5)


def around_a_cylinder(radii, until, viscosity, outer=1.0, n=200):
    """Return the velocity [m/s] at radii (n,) [m] around a cylinder that turns: dv/dt = nu (v'' + v'/r - v/r^2)."""
    r = np.linspace(A, outer, n + 1)
    v, dr, steps = np.zeros(n + 1), r[1] - r[0], int(until * viscosity / (0.2 * (r[1] - r[0]) ** 2)) + 1
    for k in range(steps):
        v[0] = A * ROLL.law(until * k / steps)[1]
        v[1:-1] += until / steps * viscosity * ((v[2:] - 2.0 * v[1:-1] + v[:-2]) / dr**2 + (v[2:] - v[:-2])
                                               / (2.0 * dr * r[1:-1]) - v[1:-1] / r[1:-1] ** 2)
    return np.interp(radii, r, v)


def test_a_cylinder_that_turns_takes_the_water_with_it():
    errors = []
    for spacing in (0.1, 0.05):
        body = Obstacle(Disc(A, at=tuple(CENTRE.tolist())), slip="none", motion=ROLL)
        case = scene((Tank(2.0, 2.0), body), Fluid(StillWater(1.8), density=1000.0, viscosity=0.02), spacing)
        s = at_end(case.changed(end_time=1.0))
        x, u = (values[s.particles.kind == FLUID] for values in (s.particles.x - CENTRE, s.particles.u))
        r = np.linalg.norm(x, axis=1)
        found, near = (x[:, 0] * u[:, 1] - x[:, 1] * u[:, 0]) / r, r < 0.6
        exact = around_a_cylinder(r[near], 1.0, 0.02)
        errors.append(float(np.sqrt(np.mean((found[near] - exact) ** 2) / np.mean(exact**2))))
    assert errors[1] < 0.04 and errors[0] / errors[1] > 3.0, errors
