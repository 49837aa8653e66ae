"""What probes show of pressures: means in time with the impulse of the pressures that act."""

import numpy as np
import pytest

from parisph import Disc, Force, Momentum, Output, PressureTap, ProbeArray, Tank
from parisph.base.fields import FLUID
from parisph.case.bodies import Obstacle, StillWater
from parisph.case.motion import Sway
from parisph.io import reader
from parisph.methods.straining import WHOLE
from parisph.methods.timestep import TOLD_MOVE, resolved_time
from tests.scenes import ran, restart_alone, run_alone, scene, simulated, water


def test_the_resolved_time_is_that_of_the_fastest_particle_or_of_the_strongest_force():
    simulation = simulated(scene("dam_break", spacing=0.1, end_time=1.0))
    p, s = simulation.particles, simulation.numerics.spacing

    def told(force, acceleration=0.0, walls=None):
        return resolved_time(p.comm, p, s, np.tile([0.0, force], (p.n_owned, 1)), acceleration, walls)
    assert told(0.0) == 0.0 and told(-9.81) == pytest.approx(WHOLE * np.sqrt(s / 9.81))
    # fluid that nothing pulls, but walls that move
    assert told(0.0, 9.81) == told(-9.81, 2.0) == told(-9.81)
    assert told(0.0, 2.0, np.array([[0.0, 0.0], [9.81, 0.0]])) == told(-9.81)
    one = np.flatnonzero(p.kind == FLUID)[3]
    p.u[one] = (3.0, -4.0)
    assert (told(0.0) == pytest.approx(TOLD_MOVE * s / 5.0)
            and told(-9.81) == pytest.approx(WHOLE * np.sqrt(s / 9.81)))
    p.u[one] = (30.0, -40.0)
    assert told(-9.81) == told(0.0) == pytest.approx(TOLD_MOVE * s / 50.0)
    p.u[one] = np.nan
    assert np.isfinite(told(-9.81)), "what is no number sets no time: the next step says so"


def falling(time_step=None, end=0.16, **output):
    """A block of 12 x 8 spacings that is thrown onto the floor, where it is before t = 0.15 s."""
    taps = ProbeArray("taps", [PressureTap("a", at=(2.0, 0.0)), PressureTap("b", at=(2.2, 0.0), acted=True)])
    return water((1.2, 0.8, (1.4, 0.5)), (4.0, 3.0, True), dict(spacing=0.1, time_step=time_step), velocity=(0.0, -3.0),
                 end_time=end, output=Output(**output),
                 probes=[Momentum("momentum"), Force("floor", side="bed", acted=True), Force("sides"), taps])


@pytest.mark.parametrize("time_step", [None, 0.001])
def test_the_impulse_of_the_force_is_the_momentum_lost(tmp_path, time_step):
    found = ran(falling(time_step, end=0.2), tmp_path / "run")
    force, momentum, steps = found.probe("floor"), found.probe("momentum"), found.steps
    lost = momentum["py"][-1] - momentum["py"][0] + 960.0 * 9.81 * momentum["time"][-1]
    acted = force["fy_acted"][1:-1] @ steps["dt"]
    shown = np.trapz(force["fy"], force["time"])
    assert shown == pytest.approx(acted, rel=0.002)
    assert -shown == pytest.approx(lost, rel=0.06) and lost > 1000.0
    pulse = 0.7 if time_step else 1.0    # of a short step, which particles do not resolve
    assert np.abs(force["fy"]).max() < pulse * np.abs(force["fy_acted"]).max()


def test_a_restart_shows_the_same(tmp_path):
    """From a checkpoint in the impact, with means that are not known yet."""
    case = falling(0.002, end=0.2, checkpoint_every=0.01)
    run_alone(case.changed(end_time=0.13), tmp_path / "part")
    restart_alone(tmp_path / "part", until=0.2)
    part, whole = reader.open_run(tmp_path / "part"), ran(case, tmp_path / "whole")
    for name in ("floor", "sides", "taps"):
        a, b = part.probe(name), whole.probe(name)
        np.testing.assert_array_equal(a["step"], b["step"])
        for column in b.dtype.names[2:]:
            scale = np.abs(b[column]).max()    # pressures are solved to 1e-5
            np.testing.assert_allclose(a[column], b[column], rtol=0, atol=1e-4 * scale, err_msg=column)
    assert list(whole.probe("taps").dtype.names[2:]) == ["a", "b_pressure", "b_pressure_acted"]


@pytest.mark.parametrize("radius, size, amplitude", [(0.3, (2.2, 2.0), 0.03), (0.2, (3.0, 3.0), 0.01)])
def test_without_gravity_the_force_is_in_time(tmp_path, radius, size, amplitude):
    """A disc sways in a full tank: the forces on both are what changes the momentum of the fluid.

    Also where the disc is small: then nearly all fluid is at rest.
    """
    frequency, at = 3.0 * np.pi, (size[1] / 2.0, size[1] / 2.0)
    disc = Obstacle(Disc(radius=radius, at=at), name="disc", motion=Sway(amplitude=amplitude, frequency=frequency))
    case = water(StillWater(level=size[1]), (Tank(*size, lid=True), disc), 0.1, gravity=(0.0, 0.0), end_time=0.68,
                 probes=[Force("disc", on="disc"), Force("tank", on="tank"), Momentum("momentum")])
    found = ran(case, tmp_path / "run")
    on_disc, on_tank, momentum = (found.probe(name) for name in ("disc", "tank", "momentum"))

    def wave(t, values):
        """Return the amplitude of a wave over its first period, as a complex number with its phase."""
        once = t <= 2.0 * np.pi / frequency
        base = np.stack([np.ones(once.sum()), np.cos(frequency * t[once]), np.sin(frequency * t[once])], axis=1)
        return np.linalg.lstsq(base, values[once], rcond=None)[0][1:] @ (1.0, 1.0j)
    force = wave(on_disc["time"], on_disc["fx"] + on_tank["fx"])
    # of A cos wt + B sin wt, the change is w (B cos wt - A sin wt)
    due = -frequency * -1j * wave(momentum["time"], momentum["px"])
    assert abs(force - due) < 0.08 * abs(due)
