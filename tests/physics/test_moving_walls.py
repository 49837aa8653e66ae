"""Walls that move: the same flow as in the frame of a tank that does, and the waves of a piston."""

import numpy as np
import pytest
from mpi4py import MPI

from parisph import Box, Case, Fluid, Numerics, Obstacle, Piston, Roll, SolitaryWave, StillWater, Sway, Tank
from parisph.base.fields import FLUID, INNER
from parisph.driver import Simulation
from parisph.io import checkpoint

G, DEPTH = 9.81, 0.4


def sloshing(motion, preset, moving):
    """Return the Simulation of a tank that moves: its walls do, or all is seen from it (a block aloft makes both
    alike)."""
    tank, block = Tank(1.0, 0.8), Obstacle(Box(width=0.1, height=0.1, at=(0.45, 0.65)))
    walls = (tank.model_copy(update={"motion": motion}), block.model_copy(update={"motion": motion}))
    case = Case(title="sloshing", fluid=Fluid(StillWater(DEPTH), density=1000.0), walls=walls if moving else
                (tank, block), gravity=(0.0, -G), numerics=Numerics(spacing=0.05, preset=preset, time_step=0.004),
                end_time=0.5, **({} if moving else {"frame": motion}))
    return Simulation(case, MPI.COMM_SELF)


@pytest.mark.parametrize(("motion", "preset", "bound"), [
    (Sway(amplitude=0.02, frequency=5.5), "gentle", 1e-3), (Sway(amplitude=0.02, frequency=5.5), "violent", 1e-3),
    (Roll(angle=0.05, frequency=5.5, centre=(0.5, 0.0)), "gentle", 4e-3),
    (Roll(angle=0.05, frequency=5.5, centre=(0.5, 0.0)), "violent", 4e-3)])
def test_moving_walls_are_a_moving_frame(motion, preset, bound):
    walls, frame = sloshing(motion, preset, True), sloshing(motion, preset, False)
    while not walls.finished():
        walls.advance()
        frame.advance()
    found, due = walls.gather("x", "u", "kind"), frame.gather("u")
    fluid, t = found["kind"] == FLUID, walls.time
    seen = motion.seen(found["u"] - motion.velocity_at(found["x"], t), t)[fluid]
    assert np.linalg.norm(seen - due["u"][fluid]) < bound * np.linalg.norm(due["u"][fluid])
    assert np.abs(due["u"]).max() > 0.04
    walls.destroy()
    frame.destroy()


def test_piston_makes_a_solitary_wave():
    """The crest after six depths, a/d = 0.2, s = d/16."""
    d, s = 0.25, 0.25 / 16.0
    case = Case(title="solitary", fluid=Fluid(StillWater(d), density=1000.0), gravity=(0.0, -G), walls=(
        Tank(12.0 * d, 1.5 * d), Piston(at=2.0 * s, wave=SolitaryWave(height=0.2 * d, depth=d))),
        numerics=Numerics(spacing=s, preset="gentle"), end_time=2.58)
    found = Simulation(case, MPI.COMM_SELF)
    while not found.finished():
        found.advance()
    p = found.particles
    top = p.x[(p.kind == FLUID) & (p.role != INNER)]
    crest = top[top[:, 1].argmax()]
    assert abs(crest[0] / d - 6.0) < 0.3
    assert abs((crest[1] - d) / d - 0.2) < 0.01 * 0.2
    found.destroy()


def test_restart_in_the_middle_of_a_motion(tmp_path):
    motion = Roll(angle=0.05, frequency=5.5, centre=(0.5, 0.0))
    straight = sloshing(motion, "violent", True)
    for _ in range(20):
        straight.advance()
    path = checkpoint.write(straight.comm, tmp_path, straight.particles, straight.time, straight.steps, straight.dt,
                            straight.case.model_dump_json(), straight.method.state(), {})
    again = Simulation(straight.case, MPI.COMM_SELF, start=checkpoint.read(MPI.COMM_SELF, path))
    for _ in range(20):
        straight.advance()
        again.advance()
    found, due = again.gather("x", "u"), straight.gather("x", "u")
    assert again.time == straight.time
    for name in found:
        assert np.abs(found[name] - due[name]).max() < 1e-6 * np.abs(due[name]).max()
    straight.destroy()
    again.destroy()
