"""Walls that move: the same flow as in the frame of a tank that does, and the waves of a piston."""

import numpy as np
import pytest
from mpi4py import MPI

from parisph import Box, Obstacle, Roll, StillWater, Sway, Tank
from parisph.base.fields import FLUID
from parisph.io import checkpoint
from tests import moving_tanks
from tests.scenes import sampled, scene, simulated, water

G, DEPTH = 9.81, 0.4


def sloshing(motion, preset, moving):
    """Return the Simulation of a tank that moves: its walls do, or all is seen from it (a block aloft makes both
    alike)."""
    tank, block = Tank(1.0, 0.8), Obstacle(Box(width=0.1, height=0.1, at=(0.45, 0.65)))
    walls = (tank.model_copy(update={"motion": motion}), block.model_copy(update={"motion": motion}))
    numerics = dict(spacing=0.05, preset=preset, time_step=0.004)
    case = water(StillWater(DEPTH), walls if moving else (tank, block), numerics, gravity=(0.0, -G), end_time=0.5,
                 **({} if moving else {"frame": motion}))
    return simulated(case)


def apart(motion, preset):
    """Return the difference of the velocities at the end of `sloshing` with walls and with a frame that move: relative
    L2, seen from the tank."""
    walls, frame = sloshing(motion, preset, True), sloshing(motion, preset, False)
    while not walls.finished():
        walls.advance()
        frame.advance()
    found, due = walls.gather("x", "u", "kind"), frame.gather("u")
    fluid, t = found["kind"] == FLUID, walls.time
    seen = motion.seen(found["u"] - motion.velocity_at(found["x"], t), t)[fluid]
    assert np.abs(due["u"]).max() > 0.04
    return np.linalg.norm(seen - due["u"][fluid]) / np.linalg.norm(due["u"][fluid])


@pytest.mark.parametrize(("motion", "preset", "bound"), [
    (Sway(amplitude=0.02, frequency=5.5), "gentle", 1e-3), (Sway(amplitude=0.02, frequency=5.5), "violent", 1e-3),
    (Roll(angle=0.05, frequency=5.5, centre=(0.5, 0.0)), "gentle", 4e-3),
    (Roll(angle=0.05, frequency=5.5, centre=(0.5, 0.0)), "violent", 4e-3)])
def test_moving_walls_are_a_moving_frame(motion, preset, bound):
    assert apart(motion, preset) < bound


@pytest.mark.parametrize("kind", ["sway", "roll"])
def test_gentle_motion_over_three_periods_by_walls_and_by_the_frame(kind):
    """Levels and pressures at both ends; seen from the tank, its walls are those of a plain tank."""
    walls, frame = (moving_tanks.histories(moving_tanks.gentle(kind, moving, 0.05, 0.2)) for moving in (True, False))
    found = moving_tanks.differences(walls, frame)
    assert max(found.values()) < 0.01
    assert max(apart for what, apart in found.items() if "level" not in what) < 0.005
    assert np.ptp(frame[1][0]) > 0.09 * moving_tanks.DEPTH


def test_violent_motion_until_the_impact_by_walls_and_by_the_frame():
    """Pressures and mean levels at both ends; water has left the left wall when the bore comes."""
    walls, frame = (moving_tanks.histories(moving_tanks.violent("sway", moving, 0.015)) for moving in (True, False))
    found = moving_tanks.differences(walls, frame)
    assert max(apart for what, apart in found.items() if "gauge" not in what) < 0.05
    assert np.ptp(frame[1][2]) > 0.5 * frame[1][2, 0]


def test_piston_makes_a_solitary_wave():
    """The crest after six depths, a/d = 0.2, s = d/16: its height to 1 %, its time to that of a tenth of the depth."""
    case = scene("solitary_piston", length=3.0, end_time=2.7)
    simulation, gauge = simulated(case), case.probes[0]
    rows = [(simulation.time, *found[gauge.name]) for found, _ in sampled(simulation, gauge)]
    (time, level), wave = np.transpose(rows), gauge.truth.of
    d, height = gauge.truth.level, wave.height
    assert gauge.at == 6.0 * d and abs(level.max() - d - height) < 0.01 * height
    assert abs(wave.celerity * time[level.argmax()] - (gauge.at - wave.at)) < 0.1 * d


def test_restart_in_the_middle_of_a_motion(tmp_path):
    motion = Roll(angle=0.05, frequency=5.5, centre=(0.5, 0.0))
    straight = sloshing(motion, "violent", True)
    for _ in range(20):
        straight.advance()
    path = checkpoint.write(straight.comm, tmp_path, straight.particles, straight.time, straight.steps, straight.dt,
                            straight.case.model_dump_json(), straight.method.state(), {})
    again = simulated(straight.case, start=checkpoint.read(MPI.COMM_SELF, path))
    for _ in range(20):
        straight.advance()
        again.advance()
    found, due = again.gather("x", "u"), straight.gather("x", "u")
    assert again.time == straight.time
    for name in found:
        assert np.abs(found[name] - due[name]).max() < 1e-6 * np.abs(due[name]).max()
