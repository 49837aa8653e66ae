"""The limits on an adaptive time step: by motions, speeds, strains, and for accuracy by the acceleration."""

from math import pi, sqrt

import numpy as np
import pytest
from mpi4py import MPI

from parisph import Box, Case, Fluid, Numerics, Sway, Tank
from parisph.base.errors import SolverDiverged
from parisph.base.fields import FLUID
from parisph.case.time_scales import flow_length
from parisph.driver import describe
from parisph.driver.schedule import SHARING
from parisph.io import checkpoint
from parisph.methods import timestep
from parisph.methods.timestep import STRAIN, first_step
from tests.scenes import scene, simulated, water

PERIOD = 1.0    # [s]
CFL = 0.8       # of the violent preset


def swaying(**numerics):
    """A case of a tank without gravity that sways so little that nothing else limits the step."""
    return water((1.0, 0.5), (1.0, 1.0, True), dict(spacing=0.1, **numerics), gravity=(0.0, 0.0),
                 frame=Sway(amplitude=0.001, frequency=2.0 * pi / PERIOD), end_time=5.0)


@pytest.mark.parametrize(("numerics", "longest"),
                         [({}, PERIOD / 50), ({"max_time_step": 0.01}, 0.01), ({"time_step": 0.04}, 0.04)])
def test_adaptive_step_resolves_the_sway(numerics, longest):
    s = simulated(swaying(**numerics))
    steps = [s.advance() and s.dt for _ in range(4)]
    assert steps == pytest.approx([longest] * 4)
    assert f"{longest:g} s" in describe(s.case)


def still(gravity=(0.0, 0.0), velocity=(0.0, 0.0), walls=None, end_time=1.0, spacing=0.1):
    """A box of fluid with an adaptive step."""
    return Case(title="still", fluid=Fluid(Box(width=1.0, height=1.0), density=1000.0, velocity=velocity), walls=walls,
                gravity=gravity, numerics=Numerics(spacing=spacing), end_time=end_time)


def steps_of(case, count):
    """Return the first steps [s] of a case."""
    s = simulated(case)
    return [s.advance().dt for _ in range(count)]


def test_first_step_knows_the_acceleration_to_come():
    """Column that is let go: from one step to the next the step never falls by more than velocities allow."""
    steps = np.array(steps_of(still((0.0, -9.81), walls=Tank(width=3.0, height=2.0, lid=True), spacing=0.05), 25))
    assert (steps[1:] / steps[:-1]).min() > 0.75 and (steps[1:] / steps[:-1]).max() < 1.1 + 1e-12
    assert 0.5 < steps[:8].max() / steps[0] < 2.0


def test_the_step_does_not_know_when_the_run_ends():
    """Bit for bit, up to the last steps, which share the way to the end."""
    walls, found = Tank(width=2.0, height=2.0, lid=True), []
    for end_time in (0.3, 0.6):
        s = simulated(still((0.0, -9.81), walls=walls, end_time=end_time, spacing=0.05))
        s.solve_start()
        states = []
        while s.time < 0.3 * (1.0 - 1e-12):
            s.advance()
            states.append((s.time, s.gather("x", "u", "p", "role")))
        found.append(states)
    short, long = found
    assert len(short) > SHARING + 6
    for (t, a), (u, b) in zip(short[:-SHARING - 1], long[:len(short) - SHARING - 1], strict=True):
        assert t == u and all(np.array_equal(a[name], b[name]) for name in a)


@pytest.mark.parametrize("rate", [3.0, 6.0])
def test_a_step_strains_the_fluid_by_no_more_than_a_limit(rate):
    """u = rate (x, -y) has sqrt(2 S:S) = 2 rate everywhere; the fluid is free, and nothing else limits its step."""
    steps = steps_of(still(velocity=(f"{rate}*x", f"-{rate}*y")), 4)
    assert steps[1:] == pytest.approx([STRAIN / (2.0 * rate)] * 3, rel=0.1)
    turning = steps_of(still(velocity=(f"{rate}*y", f"-{rate}*x")), 4)
    assert min(turning) > 2.0 * max(steps[1:])    # as a rigid body
    fixed = still(velocity=(f"{rate}*x", f"-{rate}*y")).changed(**{"numerics.time_step": 0.01})
    assert steps_of(fixed, 4) == [0.01] * 4


@pytest.mark.parametrize("end_time", [10.0, 1e3])
def test_what_rests_in_no_field_has_the_step_of_a_fall(end_time):
    first, second = steps_of(still(end_time=end_time), 2)
    assert first == pytest.approx(sqrt(2.0 * CFL * 0.1 / 9.81)) and second == pytest.approx(1.1 * first)


@pytest.mark.parametrize("force", ["0.5*sin(2*t + 1e-9)", "0.5*sin(2*t)"])
def test_force_that_is_almost_nothing_at_the_start(force):
    """The step is what the force at its end allows: a fall of .4 s with .5 m/s2 or so takes .4 s."""
    first = steps_of(still((force, 0.0), end_time=100.0), 1)[0]
    assert 0.05 < first < 0.5


def test_speed_alone_sets_the_step():
    """Of fluid with an acceleration a, the first step has |u| dt + 10 |a| dt^2 = cfl s."""
    case = still(velocity=(2.0, 0.0))
    assert steps_of(case, 1) == pytest.approx([CFL * 0.1 / 2.0])
    s = simulated(case)
    first = first_step(s.comm, s.particles, s.numerics, np.tile([0.0, -10.0], (s.particles.n_owned, 1)), np.inf,
                       lambda t: 0.0)
    assert first == pytest.approx(0.02)    # .04 + .04 = .08 m


def test_restart_at_the_start_has_the_same_first_step(tmp_path):
    case = still((0.0, -9.81), walls=Tank(width=2.0, height=2.0, lid=True))
    s = simulated(case)
    s.solve_start()
    path = checkpoint.write(s.comm, tmp_path, s.particles, 0.0, 0, 0.0, case.model_dump_json(), {}, {})
    first = s.advance().dt
    s = simulated(case, start=checkpoint.read(MPI.COMM_SELF, path))
    assert s.advance().dt == first


def test_flow_out_of_hand_is_named():
    s = simulated(still((0.0, -9.81), walls=Tank(width=2.0, height=2.0, lid=True)))
    s.advance()
    s.particles.u[0] = [1e7, 0.0]
    with pytest.raises(SolverDiverged, match=r"1e\+07 m/s.*far too fast"):
        s.advance()


# -- accuracy -----------------------------------------------------------------------------------------

SPACING, G = 0.05, 9.81


def column(**numerics):
    return water((0.5, 1.0), (2.0, 2.0), dict(spacing=SPACING, **numerics), gravity=(0.0, -G))


def largest(case, count):
    """Return the largest of the first steps of a case [s]."""
    return max(steps_of(case, count))


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
    shortest = min(steps_of(case, 40))     # more than a quarter of a period, that is, to the greatest acceleration
    assert shortest == pytest.approx(0.05 * sqrt(SPACING / (1.5 * acceleration)), rel=0.1)


def test_steps_of_a_wave_do_not_change_with_it():
    """The strain limits these steps, and nearly vanishes twice a period; steps that follow it feed the wave."""
    case = scene("standing_wave", spacing=0.1, preset="gentle", amplitude=0.05, time_step=0.05)
    found = np.array(steps_of(case.changed(**{"numerics.time_step": None}), 90))[10:]
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
