"""The pressure of steps that are shorter than what particles resolve."""

import numpy as np
import pytest
from mpi4py import MPI

from parisph.base.fields import FLUID, INNER, WET
from parisph.driver import Simulation
from parisph.methods.timestep import TOLD_FALL, TOLD_MOVE, resolved_time
from tests.scenes import scene


def test_the_resolved_time_is_that_of_the_fastest_particle_or_of_the_strongest_force():
    simulation = Simulation(scene("dam_break", spacing=0.1, end_time=1.0), MPI.COMM_SELF)
    p, s = simulation.particles, simulation.numerics.spacing

    def told(force):
        return resolved_time(p.comm, p, s, np.tile([0.0, force], (p.n_owned, 1)))
    assert told(0.0) == 0.0 and told(-9.81) == pytest.approx(TOLD_FALL * np.sqrt(s / 9.81))
    one = np.flatnonzero(p.kind == FLUID)[3]
    p.u[one] = (3.0, -4.0)
    assert (told(0.0) == pytest.approx(TOLD_MOVE * s / 5.0)
            and told(-9.81) == pytest.approx(TOLD_FALL * np.sqrt(s / 9.81)))
    p.u[one] = (30.0, -40.0)
    assert told(-9.81) == told(0.0) == pytest.approx(TOLD_MOVE * s / 50.0)
    p.u[one] = np.nan
    assert np.isfinite(told(-9.81)), "what is no number sets no time: the next step says so"
    simulation.destroy()


def pulses(mean):
    """Return the velocities, and the size of the changes of pressure from step to step over that of pressure."""
    case = scene("dam_break", {"pressure_mean": mean}, spacing=0.1, jitter=0.8, seed=3, time_step=0.001, end_time=1.0)
    simulation, found = Simulation(case, MPI.COMM_SELF), []
    simulation.solve_start()
    for _ in range(80):
        simulation.advance()
        found.append(simulation.gather("p", "u"))
    simulation.destroy()
    p = np.array([step["p"] for step in found])[20:]
    return found[-1]["u"], np.linalg.norm(np.diff(p, axis=0)) / np.linalg.norm(p)


def test_short_steps_show_no_pulses_and_move_the_same():
    u, rough = pulses(0.0)
    v, smooth = pulses(1.0)
    np.testing.assert_allclose(v, u, atol=1e-4 * np.abs(u).max())   # what is shown does not change what happens
    assert smooth < 0.6 * rough


def test_walls_average_over_twice_the_time():
    simulation = Simulation(scene("dam_break", spacing=0.1, end_time=1.0), MPI.COMM_SELF)
    simulation.advance()
    p, method = simulation.particles, simulation.method
    method.flow.usual = 1e-6
    time, at_walls = method._mean_times(1e-6)
    assert at_walls == 2.0 * time > 0.0
    p.p[:] = 0.0
    method._average_pressure(np.ones(p.n_owned), 0.25 * time, time, at_walls)
    np.testing.assert_allclose(p.p[p.role == INNER], 0.75)
    np.testing.assert_allclose(p.p[p.role == WET], 0.875)
    p.p[:] = 0.0
    method._average_pressure(np.ones(p.n_owned), 1.5 * time, time, at_walls)
    assert not p.p[p.role == INNER].any()
    np.testing.assert_allclose(p.p[p.role == WET], 0.25)
    simulation.destroy()
