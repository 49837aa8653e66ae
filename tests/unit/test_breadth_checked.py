"""What `parisph check` says about scenes in 3D: checks by sections, sketch, sizes, and the examples of the README."""

import re

import numpy as np
import pytest

import parisph
from parisph import Box, Case, CaseError, Energy, Fluid, Numerics, Output, PressureTap, Tank, VelocityPoint
from parisph.case import scales
from parisph.case.bodies import Obstacle, Piston, Plate, Profile, StillWater
from parisph.case.motion import Sway
from parisph.case.shapes import Polygon
from parisph.driver import cost
from parisph.driver.preview import describe
from parisph.driver.sketch import sketch
from parisph.geometry import scene_checks
from parisph.geometry.probe_places import Places
from tests.launch import ROOT

G = 9.81
TANK = Tank(width=3.2, height=1.0, breadth=1.0)
WATER = Fluid(StillWater(0.5), 1000.0)


def scene(*walls, fluid=WATER, spacing=0.05, **others):
    return Case(title="scene", fluid=fluid, walls=walls or None, gravity=(0.0, -G), numerics=Numerics(spacing=spacing),
                end_time=1.0, **others)


def pier(*ends, at=1.0, **others):
    return Obstacle(Box(0.2, 0.3, at=(at, 0.0)), across=ends, name="pier", **others)


@pytest.mark.parametrize("case, words", [
    (lambda: scene(TANK, Piston(0.5, motion=Sway(0.3, 3.0), name="maker"), pier(0.3, 0.7, at=0.9)),
     ["walls, maker: its Sway brings it to pier at t = ", "(this is the section from y = 0.3 to 0.7)"]),
    (lambda: scene(Profile(((0.0, 0.3), (0.0, 0.0), (3.0, 0.0), (3.0, 1.0)), breadth=1.0, name="bed")),
     ["bed: it ends in the fluid at (0, 0.3), 0.2 m below its top"]),
    (lambda: scene(TANK, fluid=[Fluid(Box(0.5, 0.5, breadth=0.5), 1.0), Fluid(Box(0.5, 0.5, breadth=0.5, at=(
        2.0, 0.5, 0.0)), 1.0), Fluid(Box(0.5, 0.5, breadth=0.5, at=(1.47, 0.5, 0.0)), 1.0)]),
     ["fluid[2] and fluid[1]: they are 0.03 m apart at (1.98", "(this is the section from y = 0.5 to 1)"]),
    (lambda: scene(TANK, pier(0.3, 0.7), fluid=Fluid(Polygon(((1.05, 0.1), (1.15, 0.1), (1.1, 0.2)),
                                                             across=(0.3, 0.7)), 1.0)),
     ["fluid (polygon): it has no particles", "(this is the section from y = 0.3 to 0.7)"]),
])
def test_faults_are_those_of_sections(case, words):
    found = scene_checks.faults(case())
    assert len(found) == 1 and all(word in found[0] for word in words), found
    with pytest.raises(CaseError):
        scene_checks.check(case())


def test_a_warning_that_holds_all_across_is_given_once():
    low = Obstacle(Box(0.2, 0.2, at=(1.0, 0.06)), name="low")
    everywhere, = scene_checks.warnings(scene(TANK, low))
    assert everywhere.startswith("the gap between") and "section" not in everywhere
    twice, = scene_checks.warnings(scene(TANK, low.model_copy(update={"across": (0.3, 0.7)}), Plate(
        ((2.0, 0.0), (2.0, 0.3)), across=(0.5, 1.0))))
    assert twice.endswith("(this is the section from y = 0.3 to 0.7)"), "of two sections beside each other"
    apart, = scene_checks.warnings(scene(TANK, pier(0.0, 0.3), pier(0.38, 0.7).model_copy(update={"name": "other"})))
    assert apart.startswith("walls, pier and other: only 0.08 m are between their ends across, 1.6 spacings")


def test_places_between_walls():
    places = Places(scene(TANK, pier(0.3, 0.7)), ())
    inside, beside, above, outside = (np.array([x]) for x in ((1.1, 0.5, 0.1), (1.1, 0.2, 0.1), (1.1, 0.5, 0.4),
                                                               (1.1, 1.2, 0.1)))
    assert [places.in_front(x) for x in (inside, beside, above, outside)] == [False, True, True, False]
    assert places.hidden(inside[0]) == ["pier"] and places.hidden(beside[0]) == []
    assert places.hidden(outside[0]) == ["the front or the back of the scene"]
    assert places.in_front(np.array([[1.1, 0.3, 0.1]])), "on the cut plane, where one side is free"


def test_the_section_with_most_bodies_is_drawn():
    lines = sketch(scene(TANK, pier(0.3, 0.7), probes=[VelocityPoint("v", at=(2.0, 0.5, 0.2))])).splitlines()
    assert lines[-1] == ("breadth 1 m, from y = 0 to 1 m; this is the section from y = 0.3 to 0.7 m, one of 3")
    assert lines[-3:-1] == ["x from 0 to 3.2 m, z from 0 to 1 m", "1 v"]
    assert any("#" in line for line in lines[:-3]) and sum("1" in line for line in lines[:-3]) == 1
    assert sketch(scene(TANK)).endswith("breadth 1 m, from y = 0 to 1 m, alike all across")


def test_what_exists_in_2d_only_is_refused_before_a_run():
    for change, words in (({"probes": [Energy("e", current=True)]}, "current volumes exist in 2D only"),
                          ({"output": Output(fields=("u", "vorticity"))}, "'vorticity' exists in 2D only")):
        with pytest.raises(CaseError, match=words):
            scene(TANK, **change)


def test_the_cost_of_a_step_in_3d(monkeypatch, tmp_path):
    monkeypatch.setattr(cost, "_file", lambda: tmp_path / "costs.json")
    monkeypatch.setattr(cost, "yardstick", lambda: cost.YARDSTICK)
    numerics = Numerics(spacing=0.1).resolved()
    assert cost.seconds_per_step(numerics, 10**6, 3)[0] == pytest.approx(20.0, rel=1e-3)
    assert cost.seconds_per_step(numerics, 10**6)[0] == pytest.approx(3.6, rel=1e-3)
    clock = cost.Clock()
    clock._start, clock._last, clock._steps = 0.0, 40.0, 10
    clock.remember(numerics, 10**5, 1, 3)    # twice the time of the reference
    assert cost.seconds_per_step(numerics, 10**6, 3) == (pytest.approx(40.0, rel=1e-2),
                                                         "an earlier run of 100000 particles on this processor")
    assert cost.seconds_per_step(numerics, 10**6)[1] == "an earlier run of 100000 particles in 3D on this processor"


@pytest.mark.parametrize("fluid, frame, length", [
    (Fluid(Box(3.2, 0.5), 1.0, elevation="0.02*cos(pi*x/3.2)"), None, 6.4),
    (Fluid(Box(3.2, 0.5), 1.0, elevation="0.02*cos(pi*y)"), None, 2.0),
    (Fluid(Box(3.2, 0.5), 1.0), Sway(0.01, 3.0), 6.4),
    (Fluid(Box(3.2, 0.5), 1.0), Sway(0.01, 3.0, direction=(0.0, 1.0, 0.0)), 2.0),
])
def test_expected_waves_along_and_across(fluid, frame, length):
    found = scales.expected(scene(TANK, fluid=fluid, **({"frame": frame} if frame else {})))
    assert found.wave is not None and found.wave.length == pytest.approx(length, rel=2e-2)
    assert found.speeds.max() > 0.01


def readme_examples():
    text = (ROOT / "cases" / "README.md").read_text(encoding="utf-8")
    section = text.partition("## Three dimensions")[2].partition("\n## ")[0]
    return re.findall(r"```python\n(.*?)```", section, re.DOTALL)


@pytest.mark.parametrize("number", [0, 1])
def test_the_examples_of_the_readme(number):
    names = {name: getattr(parisph, name) for name in parisph.__all__}
    case = eval(readme_examples()[number], names)    # noqa: S307
    assert case.dim == 3
    said = describe(case)
    assert f"breadth {case.breadth[1]:g} m, from y = 0 to {case.breadth[1]:g} m" in said
    assert re.search(r"volume +\S+ m3 exactly", said) and "fluid," in said


def test_a_tap_is_on_a_wall_in_3d():
    taps = [PressureTap("front", at=(1.0, 0.0, 0.2)), PressureTap("pier", at=(1.0, 0.5, 0.2)),
            PressureTap("end", at=(1.1, 0.3, 0.2))]
    assert scene_checks.faults(scene(TANK, pier(0.3, 0.7), probes=taps)) == []
    off, = scene_checks.faults(scene(TANK, pier(0.3, 0.7), probes=[PressureTap("off", at=(2.0, 0.5, 0.1))]))
    assert off == "probe 'off': at = (2.0, 0.5, 0.1) is not on a wall; the nearest place on one is (2, 0.5, 0) on tank"


def test_the_picture_of_a_case_in_3d_is_its_section(tmp_path):
    from parisph.pictures.bodies_view import plot_scene

    case = scene(TANK, pier(0.3, 0.7), probes=[VelocityPoint("v", at=(2.0, 0.5, 0.2))])
    axes, = plot_scene(case, tmp_path / "scene.png").axes
    assert axes.get_title(loc="left") == "scene: section from y = 0.3 to 0.7 m" and axes.get_ylabel() == "$z$ [m]"
    dot, = (line for line in axes.lines if line.get_gid() == "v")
    np.testing.assert_array_equal(dot.get_xydata(), [(2.0, 0.2)])
    assert {text.get_text() for text in axes.texts} >= {"v", "pier", "tank"}
