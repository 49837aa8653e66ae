"""The limits on an adaptive time step."""

from math import pi, sqrt

import numpy as np
import pytest
from mpi4py import MPI

from parisph import Box, Case, Fluid, Numerics, Sway, Tank
from parisph.base.errors import SolverDiverged
from parisph.driver import describe
from parisph.driver.schedule import SHARING
from parisph.io import checkpoint
from parisph.methods.timestep import STRAIN, first_step
from tests.scenes import simulated, water

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
