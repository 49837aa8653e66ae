"""Scenes of several bodies and fluids: what a case accepts, what it says, its JSON, and what --set reaches."""

import doctest
import json
import re

import pytest

import parisph
from parisph import Case, CaseError, Fluid, Numerics, PressureTap, Relaxation, Sponge, SurfaceGauge
from parisph.case import stored
from parisph.case.bodies import Flap, Obstacle, Piston, Plate, Profile, StillWater
from parisph.case.motion import Roll, Sway, Tabulated
from parisph.case.scenery import body_names, longest_step, wall_speed
from parisph.case.shapes import Box, Disc, Tank
from parisph.case.time_scales import stable_time_step
from parisph.case.waves import Airy, SolitaryWave
from parisph.driver import describe
from parisph.geometry import scene_checks

TANK, BOX = Tank(3.0, 1.0), Obstacle(Box(0.5, 0.2, at=(1.0, 0.0)), "box")
WATER = Fluid(StillWater(0.5), 1000.0)
SWAY = Sway(amplitude=0.1, frequency=2.0)
AIRY = Airy(height=0.02, period=1.5, depth=0.5)


def shaken(*values):
    """Return a scene with a plate that has a measured motion."""
    motion = Tabulated((0.0, 1.0, 2.0, 3.0), values)
    return scene(walls=(TANK, Plate([(2.0, 0.2), (2.0, 0.8)], motion=motion)))


def scene(fluid=WATER, walls=(TANK, BOX), spacing=0.05, method="ISPH_R", probes=(), **more):
    return Case(title="scene", fluid=fluid, walls=walls, gravity=(0.0, -9.81), end_time=1.0, probes=probes,
                numerics=Numerics(spacing=spacing, method=method), **more)


SCENES = {
    "tank": scene(walls=TANK), "one in a tuple": scene(walls=(TANK,)), "sill": scene(),
    "holes": scene(Fluid(Box(1.0, 0.5), 1000.0, holes=(Disc(0.1, at=(0.5, 0.2)),)), TANK),
    "two": scene((Fluid(Box(0.5, 0.8), 1000.0), Fluid(StillWater(0.3), 1000.0, velocity=(0.1, 0.0)))),
    "piston": scene(walls=(Profile([(-1.0, 0.0), (2.0, 0.0), (4.0, 1.0)]), Piston(at=0.0, wave=AIRY, name="maker"))),
    "flap": scene(walls=(TANK, Flap(hinge=(0.5, 0.0), wave=AIRY))),
    "moving": scene(walls=(TANK, Obstacle(Disc(0.1, at=(1.5, 0.3)), motion=Roll(0.1, frequency=1.0, centre=(1.5, 0.3))),
                           Plate([(2.0, 0.2), (2.0, 0.8)], motion=SWAY))),
}


@pytest.mark.parametrize("name", SCENES)
def test_survives_json(name):
    case = SCENES[name]
    assert Case.model_validate_json(case.model_dump_json()) == case
    assert stored.from_json(stored.to_json(case)) == case
    scene_checks.check(case)


def test_tank_of_an_earlier_release_has_no_kind_name_or_motion():
    case = scene(Fluid(Box(3.0, 0.5), 1000.0), TANK)
    content = json.loads(stored.to_json(case))
    for field in ("kind", "name", "motion"):
        del content["walls"][field]
    del content["fluid"]["holes"]
    assert stored.from_json(json.dumps(content)) == case


def test_parts_of_a_scene():
    case = SCENES["two"]
    assert case.bodies == (TANK, BOX) and len(case.fluids) == 2 and case.tank == TANK and case.lone_tank is None
    assert case.density == 1000.0 and case.viscosity == 0.0 and not case.lidded and not case.driven
    assert scene(Fluid(Box(1.0, 0.5), 1000.0), walls=(TANK,)).lone_tank == TANK
    assert scene(Fluid(Box(1.0, 0.5), 1000.0), walls=None).bodies == ()
    assert scene(Fluid(Box(1.0, 0.5), 1000.0), Tank(3.0, 1.0, motion=SWAY)).lone_tank is None
    lower, upper = SCENES["piston"].fluid_bounds
    assert lower.tolist() == [0.0, 0.0] and upper.tolist() == [4.0, 0.5]
    assert body_names(SCENES["moving"].bodies) == ["tank", "obstacle-1", "plate-2"]


def test_values_of_one_tank_can_be_changed_as_before():
    case = scene(Fluid(Box(3.0, 0.5), 1000.0), TANK)
    assert case.changed(**{"walls.height": 2.0}).tank.height == 2.0
    assert case.changed(walls=[TANK, BOX]).bodies == (TANK, BOX)


def test_time_steps_know_of_moving_walls():
    case = SCENES["moving"]
    assert case.driven and wall_speed(case) == pytest.approx(0.2)
    assert longest_step(case) == pytest.approx(2.0 * 3.14159265 / 2.0 / 50)
    assert stable_time_step(case)[0] > 0.0


@pytest.mark.parametrize(("make", "words"), [
    (lambda: scene(walls=(TANK, BOX, Obstacle(Disc(0.1, at=(2.0, 0.3)), name="box"))),
     "walls: the name 'box' is given 2 times"),
    (lambda: scene(walls=(TANK, TANK.model_copy(update={"name": "other"}))), "more than one Tank"),
    (lambda: scene(walls=Piston(at=0.0, motion=SWAY)), "a Piston stands on a bed; give a Tank"),
    (lambda: scene(walls=[]), "walls = \\(\\): names no body"),
    (lambda: scene((WATER, Fluid(Disc(0.1, at=(1.5, 0.8)), 900.0))), "fluid\\[1\\].density = 900.0: must be that of"),
    (lambda: scene(Fluid(Box(4.0, 0.5), 1000.0)), "fluid.shape reaches from x = 0 to 4: must lie within the walls"),
    (lambda: scene(Fluid(StillWater(0.5), 1000.0, wave=SolitaryWave(height=0.1, depth=0.4))),
     "fluid.wave.depth = 0.4: the still water is 0.5 m deep"),
    (lambda: scene(walls=(TANK, Piston(at=0.0, wave=AIRY.model_copy(update={"g": 1.62}), name="maker"))),
     "walls, maker: wave.g = 1.62: the gravity of the case must be \\(0, -1.62\\)"),
    (lambda: scene(walls=TANK, absorb=Relaxation(start=0.0, length=1.0, wave=AIRY.model_copy(update={"g": 1.62}))),
     "absorb\\[0\\].wave.g = 1.62: the gravity"),
    (lambda: scene(walls=(TANK, Piston(at=0.5, motion=SWAY, side="right")), absorb=Sponge(start=0.2, length=1.0)),
     "sponge from x = 0.2 to 1.2: must lie within the walls, from x = 0.5 to 3"),
    (lambda: scene(probes=[SurfaceGauge("far", at=3.5)]), "at = 3.5 must lie within the walls"),
    (lambda: Piston(at=0.0), "give either a wave or a motion"),
    (lambda: Piston(at=0.0, wave=AIRY, side="left"), "the wave runs to the right, which must be the side"),
    (lambda: Flap(hinge=(0.0, 0.6), wave=AIRY, bed=0.0), "the hinge must be below the still surface"),
    (lambda: Flap(hinge=(0.0, 0.0), motion=Roll(0.1, frequency=1.0, centre=(1.0, 0.0))),
     "motion.centre = \\(1.0, 0.0\\): must be the hinge"),
    (lambda: Case.model_validate({**SCENES["sill"].model_dump(), "walls": [{"kind": "blob"}]}),
     "Case.walls\\[0\\] = .*: must be of a known kind: 'tank', 'profile', 'obstacle', 'plate', 'piston', 'flap'"),
    (lambda: Case.model_validate({**SCENES["sill"].model_dump(), "walls": 3}), "Case.walls = 3: must be an object"),
    (lambda: scene(Fluid(StillWater(0.5), -1.0)), "Fluid.density = -1.0: must be greater than 0"),
    (lambda: shaken(0.0, 1e10, 0.0, 0.0), "the fastest of the walls reaches 1e\\+10 m/s, must be below 1480"),
    (lambda: shaken(0.1, 0.2, 0.1, 0.1), "plate-1: its motion begins at 0.1, must begin at 0"),
])
def test_faults_of_a_case_are_named(make, words):
    with pytest.raises(CaseError, match=words):
        make()


@pytest.mark.parametrize(("case", "words"), [
    (lambda: scene(walls=(Profile([(0.5, 0.0), (3.0, 0.0)]), Piston(at=0.0, motion=SWAY))),
     "piston-1: there is no bed below x = 0"),
    (lambda: scene(walls=(TANK, Flap(hinge=(0.5, 0.2), wave=AIRY, bed=0.0))), "hinge at .* is not on a wall"),
    (lambda: scene(walls=(TANK, Piston(at=0.5, motion=SWAY, top=0.0))), "its upper end at y = 0 is not above"),
    (lambda: scene(walls=(Profile([(0.0, 0.0), (3.0, 0.3)]),)), "profile: it ends in the fluid at \\(0, 0\\)"),
    (lambda: scene(probes=[PressureTap("tap", at=(1.2, 0.3))]),
     "probe 'tap': at = \\(1.2, 0.3\\) is not on a wall; the nearest place on one is \\(1.2, 0.2\\) on box"),
    (lambda: scene(walls=(TANK, Obstacle(Box(0.5, 1.5, at=(1.0, 0.0)))), probes=[SurfaceGauge("dry", at=1.2)]),
     "probe 'dry': at = 1.2: there is no room for fluid"),
    (lambda: scene(walls=(TANK, Piston(at=0.0, wave=AIRY.model_copy(update={"depth": 1.5}), name="maker"))),
     "walls, maker: wave.depth = 1.5: the water is 0.5 m deep there; change one of them"),
    (lambda: scene(walls=TANK, absorb=Relaxation(start=0.0, length=1.0, wave=AIRY.model_copy(update={"depth": 3.0}))),
     "absorb\\[0\\]: wave.depth = 3: the water is 0.5 m deep there"),
    (lambda: scene(Fluid(Box(3.0, 0.4), 1000.0), TANK, absorb=Relaxation(start=0.0, length=1.0, wave=AIRY)),
     "absorb\\[0\\]: wave.depth = 0.5: the water is 0.4 m deep there"),
    (lambda: scene(Fluid(Box(0.4, 0.1, at=(1.05, 0.05)), 1000.0)), "fluid \\(box\\): it has no particles"),
])
def test_faults_of_the_geometry_are_named(case, words):
    with pytest.raises(CaseError, match=words):
        scene_checks.check(case())


@pytest.mark.parametrize(("case", "words"), [
    (lambda: scene(walls=(TANK, Obstacle(Box(0.5, 0.3, at=(1.0, 0.08)), name="box"))), "gap between"),
    (lambda: scene(walls=Profile([(0.0, 1.0), (0.0, 0.0), (1.0, 0.0), (9.0, 1.0)])), "ends in a wedge of 7.1 degrees"),
    (lambda: scene(Fluid(Box(0.53, 0.13), 1000.0)), "height = 0.13 is 2.6 spacings: .* 0.0433 m apart, not 0.05"),
    (lambda: scene(Fluid(Box(3.0, 0.5), 1000.0, elevation="-0.06"), Tank(3.0, 0.5, lid=True)), "no fluid particle"),
])
def test_what_can_be_computed_is_a_warning(case, words):
    scene_checks.check(case())
    found = [*scene_checks.warnings(case()), *scene_checks.airless(case())]
    assert any(re.search(words, line) for line in found)


def test_sound_scenes_have_no_warnings():
    assert [scene_checks.warnings(SCENES[name]) for name in ("tank", "sill", "piston", "flap", "two")] == [[]] * 5


def test_check_says_and_draws_what_there_is():
    text = describe(scene(probes=[SurfaceGauge("gauge", at=2.0)]))
    assert "walls       tank, box: " in text and "thinnest gap 1 m, 20 spacings, between tank and box" in text
    assert "volume      1.4 m2 exactly" in text
    rows = [line[12:] for line in text.splitlines() if line.endswith("|")]
    assert len({len(row) for row in rows}) == 1 and "1 gauge" in text
    assert rows[0].count("1") == 1 and "~" not in rows[0] and "#" in rows[-1] and "~" in rows[-1]
    assert rows[-1].index("#") / len(rows[-1]) == pytest.approx(1.0 / 3.0, abs=0.02)


@pytest.mark.parametrize("kind", [Fluid, Piston, Flap])
def test_examples_hold(kind):
    names = {name: getattr(parisph, name) for name in ("Airy", "Box", "Disc", "SolitaryWave", "Sway")}
    test = doctest.DocTestParser().get_doctest(kind.__doc__, {**names, kind.__name__: kind}, kind.__name__, None, None)
    assert test.examples and doctest.DocTestRunner(verbose=False).run(test).failed == 0
