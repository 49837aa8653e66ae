"""Friction on walls that water slips along: what it takes, what it leaves alone, and the same on ranks."""

import numpy as np
import pytest
from mpi4py import MPI

from parisph import Box, Case, Fluid, Friction, Lid, Numerics, Output, Tank, open_run
from parisph.base.fields import FLUID
from parisph.case.bodies import StillWater
from parisph.case.stored import from_json, to_json
from parisph.driver.preview import describe
from parisph.io import checkpoint
from parisph.kernels.wall_law import wall_stress
from tests import moving_tanks, solid_scenes
from tests.scenes import after_steps, assert_same, at_end, budget, restart_alone, run_alone, scene, simulated, water

SLOW = Friction(viscosity=1e-3)    # much more than water has, so that a short run shows it


def falling(friction=SLOW, spacing=0.05, end_time=1.9, **numerics):
    case = scene("dam_break", numerics, spacing=spacing, jitter=0.4, end_time=end_time, budget=True)
    return case.changed(friction=friction)


def test_the_budget_knows_what_friction_takes():
    taken = []
    for works, gain in budget(falling()):
        assert sum(works.values()) == pytest.approx(gain, abs=1e-8)
        taken.append(works["work_friction"])
    assert max(taken) <= 0.0 and sum(taken) < -10.0


def test_it_slows_the_front_of_a_dam_break_as_viscosity_grows():
    fronts = []
    for friction in (None, Friction(), SLOW):
        p = at_end(falling(friction, end_time=1.3)).particles
        fronts.append(p.x[p.kind == FLUID, 0].max())
    assert fronts[0] - fronts[1] > 0.005 and fronts[1] - fronts[2] > 0.02


def test_a_layer_loses_the_momentum_that_the_stress_takes():
    """Water that runs along the bed of a long tank: what all its particles lose in a step, far from the ends."""
    s, speed, length = 0.05, 2.0, 4.0
    case = water((length, 0.5), (length, 1.0), dict(spacing=s, time_step=0.0001), velocity=(speed, 0.0),
                 friction=Friction())
    simulation = simulated(case)
    simulation.advance()
    p = simulation.particles
    middle = (p.kind == FLUID) & (np.abs(p.x[:, 0] - 0.5 * length) < 1.0 + 1e-3)
    force = (p.volume[middle] @ p.friction[middle, 0]) * s / (2.0 + s)
    assert force / s == pytest.approx(-wall_stress(speed, s, 1e-6, 0.0), rel=0.01)


def test_a_lid_that_slides_takes_water_along():
    case = water((1.0, 0.5), (1.0, 0.5, Lid(velocity=2.0)), dict(spacing=0.05, preset="closed", time_step=0.005),
                 gravity=(0.0, 0.0), friction=SLOW)
    simulation = simulated(case, 20)
    p = simulation.particles
    top = (p.kind == FLUID) & (p.x[:, 1] > 0.42) & (np.abs(p.x[:, 0] - 0.5) < 0.3)
    assert 0.02 < p.u[top, 0].mean() < 2.0 and "work_friction" not in simulation.columns


@pytest.mark.parametrize("name", ["slope 20", "box"])
def test_water_rests(name):
    case = solid_scenes.still(name, "violent", jitter=0.4).changed(friction=Friction(roughness=0.01))
    speed, error = solid_scenes.errors_at_rest(case, name, 20)
    assert speed.max() < 1e-9 and error.max() < 1e-9


def test_walls_that_move_rub_as_those_of_a_frame_do():
    walls, frame, plain = (moving_tanks.histories(case) for case in (
        *(moving_tanks.gentle("sway", moving, 0.05, 0.2).changed(friction=SLOW) for moving in (True, False)),
        moving_tanks.gentle("sway", False, 0.05, 0.2)))
    assert max(moving_tanks.differences(walls, frame).values()) < 0.01
    assert max(moving_tanks.differences(plain, frame).values()) > 0.02


# -- ranks, restarts, files ---------------------------------------------------------------------------

def still_water(plain):
    shape = Box(1.0, 0.6) if plain else StillWater(0.6)
    return Case(title="box", fluid=Fluid(shape, density=1000.0, velocity=(1.0, 0.0)), friction=Friction(roughness=0.01),
                walls=Tank(1.0, 1.0, lid=Lid(velocity=1.0), no_slip=("left",)) if plain else
                (Tank(1.0, 1.0), solid_scenes.WALLS["box"][1].model_copy(
                    update={"shape": Box(width=0.2, height=0.3, at=(0.4, 0.0))})),
                gravity=(0.0, -9.81), numerics=Numerics(spacing=0.05, time_step=0.002, rtol=1e-13), end_time=1.0,
                output=Output(fields=("u", "p", "friction")))


def test_ranks_have_the_same_friction(tmp_path):
    cases = {"plain": still_water(True), "box": still_water(False)}
    found = after_steps(cases, 20, ("x", "u", "p", "friction"), tmp_path)
    for name in cases:
        assert np.abs(found[name, 1]["friction"]).max() > 0.1
        assert_same(found[name, 1], found[name, 2], 1e-8, found[name, 1])


def test_a_restart_goes_on_as_before(tmp_path):
    case = still_water(True).changed(end_time=0.02, **{"output.checkpoint_every": 0.01})
    run_alone(case, tmp_path / "whole")
    first = checkpoint.paths(tmp_path / "whole" / "checkpoints")[0]
    restart_alone(first, out=tmp_path / "later")
    whole, later = (open_run(tmp_path / name).snapshot(-1) for name in ("whole", "later"))
    assert 0.0 < checkpoint.read(MPI.COMM_SELF, first).time < whole["time"] == later["time"]
    assert_same(whole, later, fields=("x", "u", "p", "friction"))


def test_a_stored_case_has_its_friction():
    case = still_water(False)
    again = from_json(to_json(case))
    assert again.friction == case.friction
    said = describe(case)
    assert "friction" in said.split("stages")[1].split("\n")[0]
    assert "viscosity 1e-06 m2/s, roughness 0.01 m" in said
