"""An adaptive step of moving fluid is limited for accuracy, by the acceleration."""

from math import sqrt

import numpy as np
import pytest

from parisph import Box, Tank
from parisph.base.fields import FLUID
from parisph.case.time_scales import flow_length
from parisph.methods import timestep
from tests.scenes import scene, simulated, water

SPACING, G = 0.05, 9.81


def column(**numerics):
    return water((0.5, 1.0), (2.0, 2.0), dict(spacing=SPACING, **numerics), gravity=(0.0, -G))


def largest(case, count):
    """Return the largest of the first steps of a case [s]."""
    return max(steps(case, count))


def steps(case, count):
    s = simulated(case)
    return [s.advance().dt for _ in range(count)]


def test_water_that_is_set_in_motion_has_short_steps():
    limit = 0.05 * sqrt(SPACING / G)
    assert largest(column(), 25) == pytest.approx(limit)
    assert largest(column(fall=0.025), 25) == pytest.approx(0.5 * limit)
    assert largest(column(fall=0.0), 25) > 1.5 * limit


def test_an_impact_has_shorter_steps():
    """By the acceleration of the fluid as a whole, not by that of its fastest particle alone, nor below LEAST_MOVE."""
    s = simulated(column())

    def step(mean, largest=1000.0 * G):
        return timestep.next_step(s.method.flow, G, accelerations=(largest, mean))
    calm = 0.05 * sqrt(SPACING / G)
    assert step(0.5 * G) == pytest.approx(calm)
    assert step(0.0, 0.24 * G) == pytest.approx(calm / 0.6)    # 1.5 times the largest counts, up to the force
    assert step(12.8 * G) == pytest.approx(calm / 4.0)
    s.particles.u[s.particles.kind == FLUID] = (-2.0, 0.0)
    assert step(1e4 * G) == pytest.approx(timestep.LEAST_MOVE * SPACING / 2.0)


def test_a_flow_of_many_fine_particles_sets_its_own_time_scale():
    """Twenty spacings of its smallest extent are enough for that; coarser particles need shorter steps."""
    assert flow_length(column()) == SPACING
    assert flow_length(column().changed(**{"numerics.spacing": 0.005})) == pytest.approx(0.5 / 20.0)
    fine = column().changed(**{"fluid.shape": Box(width=0.5, height=0.5), "numerics.spacing": 0.0125})
    assert largest(fine, 30) == pytest.approx(0.05 * sqrt(0.025 / G))
    s = simulated(column())
    found = [timestep.next_step(s.method.flow, G, accelerations=(G, 0.5 * G), length=length)
             for length in (None, SPACING, 4.0 * SPACING)]
    assert found[0] == found[1] == pytest.approx(0.5 * found[2])


def test_the_mean_acceleration_is_that_of_all_fluid():
    """Of a round drop that begins to stretch, A^2 r at a distance r; it comes back with a checkpoint's state."""
    case = scene("free_drop", spacing=0.05, time_step=None)
    s, other = (simulated(case) for _ in range(2))
    speed, radius = s.particles.u[:, 0].max(), s.particles.x[:, 0].max()
    rate = speed / radius
    s.advance()
    largest, mean = s.method.accelerations
    assert mean == pytest.approx(rate**2 * radius / sqrt(2.0), rel=0.03) and largest > mean
    other.method.resume(s.method.state())
    assert other.method.accelerations == (largest, mean)


def test_waves_are_limited_by_their_acceleration():
    case = scene("standing_wave", spacing=SPACING, preset="violent", amplitude=0.01, time_step=0.05)
    case = case.changed(**{"numerics.time_step": None})
    acceleration = 0.01 * np.pi * G    # a k g, in deep water
    shortest = min(steps(case, 40))     # more than a quarter of a period, that is, to the greatest acceleration
    assert shortest == pytest.approx(0.05 * sqrt(SPACING / (1.5 * acceleration)), rel=0.1)


def test_steps_of_a_wave_do_not_change_with_it():
    """The strain limits these steps, and nearly vanishes twice a period; steps that follow it feed the wave."""
    case = scene("standing_wave", spacing=0.1, preset="gentle", amplitude=0.05, time_step=0.05)
    found = np.array(steps(case.changed(**{"numerics.time_step": None}), 90))[10:]
    limit = 0.5 * sqrt(0.1 / G)
    assert found.max() < 0.9 * limit
    assert found.max() / found.min() - 1.0 < 0.01


def test_still_water_is_not_limited():
    case = scene("hydrostatic", spacing=SPACING).changed(**{"numerics.preset": "violent", "numerics.time_step": None})
    assert largest(case, 25) > 4.0 * 0.1 * sqrt(SPACING / G)


@pytest.mark.parametrize("closed", [True, False])
def test_a_full_closed_tank_has_numbers_of_its_own(closed):
    height = 1.0 if closed else 0.5
    case = water((1.0, height), (1.0, 1.0, True), dict(spacing=0.1, filter=0.02), gravity=(0.0, 0.0))
    s = simulated(case)
    n = s.numerics
    assert n.filter == 0.02     # the user's own
    assert (n.surface_rule, n.shift, n.kappa_strain) == (("none", 0.06, 70.0) if closed else ("gap", 0.2, 56.0))
    opened = s.case.changed(walls=Tank(width=1.0, height=2.0))
    assert opened.numerics.resolved().shift == 0.2 and opened.numerics.filter == 0.02
