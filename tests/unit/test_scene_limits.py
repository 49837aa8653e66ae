"""Scenes at their limits: how far fluid and walls reach, and what is refused before any work."""

import numpy as np
import pytest

from parisph import Box, Case, Disc, Flap, Fluid, Numerics, Obstacle, Piston, Plate, Profile, StillWater, Tank
from parisph.base.errors import CaseError
from parisph.base.fields import FLUID
from parisph.case.motion import AtRest, Heave, Moved, Roll, Series, Sway
from parisph.case.waves import Airy
from parisph.driver.preview import describe
from parisph.geometry import build, scene_checks
from parisph.geometry.columns import overlapping
from parisph.geometry.standing import standing
from tests.scenes import simulated

S = 0.05
TANK = Tank(2.0, 1.0)
COLUMN = Fluid(Box(0.5, 0.5, at=(0.5, 0.0)), 1000.0)
WATER = Fluid(StillWater(0.4), 1000.0)


def scene(walls, fluid=WATER, end_time=1.0, spacing=S, **more):
    return Case(title="scene", fluid=fluid, walls=walls, gravity=(0.0, -9.81), end_time=end_time,
                numerics=Numerics(spacing=spacing, **more.pop("numerics", {})), **more)


def sampled(case):
    return sum(volume.sum() for _, volume in build.samples(case, (-9.0, -9.0), (9.0, 9.0)))


@pytest.mark.parametrize("points", [[(0.0, 0.2), (0.0, 0.0), (2.0, 0.0), (2.0, 0.2)], [(0.0, 0.0), (2.0, 0.0)]])
def test_fluid_above_the_highest_wall_has_its_volume(points):
    case = scene(Profile(points), COLUMN)
    assert sampled(case) == pytest.approx(0.25, rel=1e-9)
    assert build.domain(case)[1][1] == 0.5
    assert "0.25 m2 exactly" in describe(case)


@pytest.mark.parametrize("motion, end_time, right", [
    (Sway(0.3, 2.0 * np.pi), 399.0, 2.6),
    (Roll(0.5 * np.pi, 2.0 * np.pi, centre=(2.0, 0.0)), 399.0, 3.0),
    (Moved(Series(times=(0.0, 100.0, 100.1, 100.2, 100.3, 400.0), values=(0.0, 0.0, 0.3, 0.3, 0.0, 0.0))), 400.0, 2.3),
])
def test_walls_are_looked_at_wherever_they_move(motion, end_time, right):
    assert build.domain(scene(Tank(2.0, 1.0, motion=motion), end_time=end_time))[1][0] >= right - 1e-3


def refused(case):
    """Return the one error with which the case is refused, before any work."""
    with pytest.raises(CaseError) as error:
        describe(case)
    return str(error.value)


def test_holes_that_leave_no_fluid_are_named():
    said = refused(scene(TANK, Fluid(Box(0.5, 0.5), 1000.0, holes=(Disc(2.0, at=(0.2, 0.2)),))))
    assert said == "fluid.holes: they leave none of its particles; make them smaller, or leave this fluid out"


def box(motion, at=(1.0, 0.2)):
    return Obstacle(Box(0.2, 0.2, at=at), name="box", motion=motion)


def piston(amplitude, at=0.2):
    return Piston(at=at, motion=Sway(amplitude, 2.0), side="right", name="piston")


def flap(angle):
    return Flap(hinge=(0.5, 0.0), motion=Roll(angle, 2.0, centre=(0.5, 0.0)), side="right", name="flap")


PLATE = Plate([(1.0, 0.0), (1.0, 0.3)], name="plate")


@pytest.mark.parametrize("walls, words", [
    ((TANK, box(Sway(2.0, 3.0))), "box: its Sway brings it to tank at t = 0.308 s"),
    ((TANK, box(Heave(-0.2, 3.0))), "box: its Heave brings it to tank"),
    ((Tank(2.0, 1.0, lid=True), piston(3.0)), "piston: its Sway brings it to tank at t = 0.583 s"),
    ((TANK, piston(0.4), box(AtRest(), at=(0.6, 0.0))), "piston: its Sway brings it to box at t = 0.778 s"),
    ((TANK, piston(0.6), PLATE), "piston: its Sway brings it to plate"),
    ((TANK, Piston(at=0.0, wave=Airy(0.1, 1.0, 0.4), name="piston")), "piston: its PistonStroke brings it to tank"),
    ((TANK, flap(2.0)), "flap: its Roll brings it to tank at t = 2.2 s"),
    ((Tank(2.0, 1.0, motion=Sway(0.5, 2.0)), box(AtRest(), at=(1.0, 0.0))),
     "tank: its Sway brings it to box at t = 1.57"),
    ((TANK, box(Sway(0.2, 2.0), at=(0.5, 0.2)), Obstacle(Box(0.2, 0.2, at=(1.3, 0.2)), name="other",
                                                         motion=Sway(-0.2, 2.0))), "box: its Sway brings it to other"),
])
def test_walls_that_move_into_others_are_refused(walls, words):
    said = refused(scene(walls, end_time=3.0))
    assert words in said and "move less far" in said and "\n" not in said


@pytest.mark.parametrize("walls", [
    (TANK, piston(0.4)), (TANK, flap(0.3)), (TANK, piston(0.3, at=0.0)), (TANK, box(Sway(0.3, 2.0), at=(1.0, 0.0))),
    (Tank(2.0, 1.0, motion=Sway(0.5, 2.0)), box(Sway(0.5, 2.0), at=(1.0, 0.0))),
    (TANK, box(Heave(0.4, 2.0), at=(1.0, -0.1))), (TANK, box(Sway(0.3, 2.0), at=(1.0, -0.1))),
    (TANK, Plate([(1.0, 0.0), (1.0, 0.8)], name="gate", motion=Heave(0.4, 3.0))),
])
def test_walls_that_slide_along_others_are_fine(walls):
    assert "brings it" not in describe(scene(walls, end_time=3.0)) and not scene_checks.warnings(
        scene(walls, end_time=3.0))


@pytest.mark.parametrize("walls, words", [
    ((TANK, box(Heave(-0.07, 3.0))), "box: its Heave leaves 0.06 m, 1.2 spacings, between it and tank at t = 1.05 s"),
    ((TANK, piston(0.875)), "piston: its Sway leaves 0.05 m, 1 spacings, between it and tank"),
])
def test_walls_that_move_too_near_to_others_warn(walls, words):
    assert words in "\n".join(scene_checks.warnings(scene(walls, end_time=3.0)))


SILL = Obstacle(Box(0.2, 0.2, at=(1.0, 0.0)), name="sill")


@pytest.mark.parametrize("make, words", [
    (lambda: scene((TANK, Obstacle(Box(0.001, 0.001, at=(1.0, 0.1)), name="grain"))),
     "walls, grain: is 0.001 m thick, 0.02 spacings, must be at least 0.1, 0.005 m; give a Plate, which has no "
     "thickness, make it thicker, or use a spacing of at most 0.01"),
    (lambda: scene((Profile([(0.0, 1.0), (0.0, 0.1), (1.0, 0.1)], name="one"),
                    Profile([(1.0, 0.1), (2.0, 0.0), (2.0, 1.0)], name="two"))),
     "walls, one and two: both end at (1, 0.1), and each goes on straight beyond its end, where the other lies; give "
     "them as one Profile"),
    (lambda: scene((Profile([(0.0, 1.0), (0.0, 0.0), (0.9, 0.0)], name="one"),
                    Profile([(1.0, 0.0), (2.0, 0.0), (2.0, 1.0)], name="two"))),
     "walls, one and two: they lie in one line with a gap from (0.9, 0) to (1, 0); give them as one Profile"),
])
def test_what_run_refuses_check_refuses_in_words_of_the_case(make, words):
    said = refused(make())
    assert said.startswith(words) and "\n" not in said


@pytest.mark.parametrize("make, words", [
    (lambda: Piston(at=0.2, wave=Airy(0.1, 5.0, 0.4)).moved, "as motion a PistonStroke with second_order=False"),
    (lambda: scene((TANK, Piston(at=0.4, motion=Sway(0.3, 20.0), side="right")), numerics={"time_step": 0.02}),
     "numerics.time_step = 0.02 s: a wall at its greatest speed of 6 m/s moves 2.4 spacings in a step, at most 0.5; "
     "use at most 0.0042 s, or None to adapt it"),
    (lambda: scene(LIDDED, Fluid(StillWater(1.5), 1000.0)),
     "fluid.shape.level = 1.5: is above the lid of the tank, must be at most 1"),
    (lambda: scene((LIDDED, piston(0.1)), FULL),
     "walls, piston: the fluid fills the tank up to its lid, and has no room for"),
])
def test_what_a_case_cannot_have_is_said_when_it_is_made(make, words):
    with pytest.raises(CaseError) as error:
        make()
    assert words in str(error.value)


@pytest.mark.parametrize("others, foot", [
    ((), 0.0), ((Obstacle(Box(0.4, 0.1, at=(0.0, 0.5))),), 0.0),
    ((Obstacle(Box(0.4, 0.1)), Obstacle(Box(0.4, 0.1, at=(0.0, 0.1)))), 0.2),
])
def test_a_piston_stands_on_the_bed_not_on_what_hangs_above(others, foot):
    face = standing(scene((TANK, *others, piston(0.1))))[-1]
    assert min(y for _, y in face.points) == pytest.approx(foot)


@pytest.mark.parametrize("fluid", [WATER, Fluid(StillWater(0.4), 1000.0, elevation="0.1*cos(pi*x) + 0.02"),
                                   (Fluid(Box(0.5, 0.5), 1000.0), WATER)])
def test_exact_volume_is_that_of_all_places(fluid):
    case = scene((TANK, SILL), fluid)
    assert build.volume(case) == pytest.approx(sampled(case), rel=1e-9)


@pytest.mark.parametrize("some", [1, 50, 10**6])
def test_all_boxes_that_overlap_are_found_once(some):
    lower = np.random.default_rng(1).random((60, 2))
    upper = lower + 0.2 * np.random.default_rng(2).random((60, 2))
    found = [tuple(sorted(pair)) for one, other in overlapping(lower, upper, some) for pair in zip(one, other)]
    expected = [(i, j) for i in range(60) for j in range(i + 1, 60)
                if np.all(lower[i] <= upper[j]) and np.all(lower[j] <= upper[i])]
    assert sorted(found) == expected


def test_the_mesh_of_the_same_walls_is_made_once():
    case = scene((TANK, SILL))
    assert build.scene_mesh(case) is build.scene_mesh(case.changed(end_time=2.0))


LIDDED = Tank(2.0, 1.0, lid=True)
FULL = Fluid(StillWater(1.0), 1000.0)


def test_still_water_up_to_the_lid_is_closed_beside_any_walls():
    case = scene((LIDDED, box(AtRest(), at=(0.8, 0.3))), FULL, spacing=0.1)
    assert case.closed and "null space" in describe(case) and not scene_checks.warnings(case)
    run = simulated(case)
    while run.steps < 3:
        run.advance()
    p, fluid = run.particles, run.particles.kind == FLUID
    head = p.p[fluid] + 9810.0 * p.x[fluid, 1]
    assert np.ptp(head) < 1e-3 * 9810.0 and p.volume.sum() == pytest.approx(1.96)


@pytest.mark.parametrize("make, words", [
    (lambda: refused(scene((LIDDED, SILL), Fluid(Box(2.0, 1.0), 1000.0))),
     "fluid: it fills the tank up to its lid at y = 1, and none of it has a surface; give StillWater(level=1), which"),
])
def test_full_tanks_that_are_not_computed_are_refused(make, words):
    assert words in make()
