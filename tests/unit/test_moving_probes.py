"""Probes on and above walls that move, or that do not stand on the bed."""

from contextlib import nullcontext

import numpy as np
import pytest

from parisph import ColumnHeight, Energy, PressureTap, RunUp, SurfaceGauge, VelocityPoint, WaterFront
from parisph.base.errors import CaseError
from parisph.base.fields import WALL, WET
from parisph.case.bodies import Obstacle, Piston, Plate, Profile, StillWater
from parisph.case.motion import Roll, Sway
from parisph.case.schema import Case, Fluid, Numerics
from parisph.case.shapes import Box, Disc, Tank
from parisph.geometry import scene_checks
from tests.scenes import at_start
from tests.watched import DENSITY, G, Watch

S, LEVEL = 0.05, 0.6
SWAY = Sway(amplitude=0.2, frequency=np.pi)     # at .2 m after half a second


def scene(walls, probes, level=LEVEL):
    return Case(title="moving", fluid=Fluid(StillWater(level), density=DENSITY), walls=walls, gravity=(0.0, -G),
                numerics=Numerics(spacing=S), probes=probes, end_time=1.0)


def sampled(walls, probes, time=0.0, shift=0.0, level=LEVEL):
    """Return {probe: values} of still water that has moved by `shift` along x as one body."""
    def change(arrays):
        arrays["x"][:, 0] += shift
        arrays["role"][arrays["kind"] == WALL] = WET
        arrays["p"][:] = DENSITY * G * np.maximum(level - arrays["x"][:, 1], 0.0)
    watch = Watch(scene(walls, probes, level), change=change)
    try:
        return watch.sample(time)
    finally:
        watch.destroy()


def test_gauges_stand_in_a_tank_that_moves():
    probes = [SurfaceGauge("gauge", at=0.9), ColumnHeight("column", at=1.0), WaterFront("front")]
    found = sampled(Tank(2.0, 1.0, motion=SWAY), probes, time=0.5, shift=0.2)
    assert found["gauge"] == found["column"] == pytest.approx((LEVEL,), abs=1e-9)
    assert found["front"] == pytest.approx((2.2 - S,), abs=1e-9)


@pytest.mark.parametrize("body", [Obstacle(Box(0.4, 0.2, at=(0.8, 0.1))), Plate([(0.8, 0.25), (1.2, 0.25)])])
@pytest.mark.parametrize("motion", [{}, {"motion": SWAY}])
def test_gauges_above_what_is_under_water_have_the_surface(body, motion):
    probes = [SurfaceGauge("gauge", at=1.0), ColumnHeight("column", at=1.0), SurfaceGauge("beside", at=0.4)]
    found = sampled((Tank(2.0, 1.0), body.model_copy(update=motion)), probes)
    assert {name: values[0] for name, values in found.items()} == pytest.approx(
        {"gauge": LEVEL, "column": LEVEL, "beside": LEVEL}, abs=1e-9)


def test_a_gauge_below_a_body_in_the_air_has_the_water_under_it():
    found = sampled((Tank(2.0, 1.2), Obstacle(Box(0.4, 0.2, at=(0.8, 0.8)))), [SurfaceGauge("gauge", at=1.0)])
    assert found["gauge"] == pytest.approx((LEVEL,), abs=1e-9)


PLATE = Plate([(1.0, 0.0), (1.0, 0.8)], name="gate")


def test_a_tap_moves_with_its_body():
    tap = PressureTap("tap", at=(2.0, 0.3)), PressureTap("disc", at=(0.0, 0.3), diameter=0.2)
    found = sampled(Tank(2.0, 1.0, motion=SWAY), tap, time=0.5, shift=0.2)
    assert found == {name: pytest.approx((DENSITY * G * 0.3,), rel=1e-9) for name in ("tap", "disc")}


def test_a_tap_on_a_plate_has_the_pressure_of_its_side():
    taps = [PressureTap(side, at=(1.0, 0.3), side=side) for side in ("left", "right")]

    def higher_on_the_left(arrays):
        arrays["role"][arrays["kind"] == WALL] = WET
        arrays["p"][:] = np.where(arrays["normal"][:, 0] < 0.0, 7000.0, 3000.0)
    watch = Watch(scene((Tank(2.0, 1.0), PLATE), taps), change=higher_on_the_left)
    assert watch.sample() == {"left": pytest.approx((7000.0,)), "right": pytest.approx((3000.0,))}
    watch.destroy()


@pytest.mark.parametrize("walls, probe, place", [
    (Tank(2.0, 1.0, motion=SWAY), RunUp("up", side="right"), (LEVEL, 2.2)),
    (Tank(2.0, 1.0, motion=SWAY), RunUp("up", points=[(0.0, 0.0), (0.0, 1.0)]), (LEVEL, 0.2)),
    ((Tank(2.0, 1.0, motion=SWAY), Obstacle(Box(0.4, 0.8, at=(0.8, 0.0)), name="pier", motion=SWAY)),
     RunUp("up", on="pier", side="left"), (LEVEL, 1.0)),
    ((Tank(2.0, 1.0, motion=SWAY), PLATE.model_copy(update={"motion": SWAY})),
     RunUp("up", on="gate", side="right"), (LEVEL, 1.2)),
    ((Profile([(-1.0, 0.0), (2.0, 0.0), (3.0, 1.0)], motion=SWAY), Piston(at=0.0, motion=SWAY, bottom=0.0, top=1.0,
                                                                           side="right", name="maker")),
     RunUp("up", on="maker"), (LEVEL, 0.2)),
])
def test_the_line_of_a_run_up_moves_with_its_body(walls, probe, place):
    found = sampled(walls, [probe], time=0.5, shift=0.2)
    assert found["up"] == pytest.approx(place, abs=1e-6)


def test_the_side_of_a_tank_that_turns_is_a_line_that_turns():
    roll = Roll(angle=0.1, frequency=np.pi, centre=(0.0, 0.0))
    watch = Watch(scene(Tank(2.0, 1.0, motion=roll), [RunUp("up", side="left")]))
    line = watch.samplers[0].measure
    watch.sample(0.5)
    angle = roll.law(0.5)[0]
    assert line.points[-1] == pytest.approx((-np.sin(angle), np.cos(angle)), abs=1e-9)
    watch.destroy()


TANK, MAKER = Tank(2.0, 1.0), Piston(at=0.5, motion=SWAY, side="right", name="maker")


@pytest.mark.parametrize("walls, probe, words", [
    ((TANK, PLATE), PressureTap("p", at=(1.0, 0.3)), 'gate has two sides; give side="left" or side="right"'),
    (TANK, PressureTap("p", at=(0.0, 0.3), side="left"), "only a plate has two sides, tank has one; leave it out"),
    ((TANK, MAKER), PressureTap("p", at=(0.0, 0.3)), "at = .* is behind maker, which no fluid reaches; move it"),
    ((TANK, Obstacle(Box(0.2, 0.2, at=(1.0, 0.2)))), PressureTap("p", at=(1.1, 0.4), diameter=0.3),
     "a disc of diameter = 0.3 around .* does not lie on one wall"),
    ((TANK, MAKER), RunUp("u", side="left"), "no fluid reaches the left side of tank, which is behind another body"),
    ((TANK, MAKER), RunUp("u", on="maker", side="left"), "maker has fluid on one side only; leave it out"),
    ((TANK, MAKER), RunUp("u", points=[(0.5, 0.0), (0.5, 0.9)]), "its points are on maker, which moves; give on="),
    ((TANK, PLATE), RunUp("u", on="gate"), "give its side, side='left' or 'right', or the points of a line"),
    (TANK, RunUp("u", points=[(10.0, 0.0), (10.0, 0.9)]), r"points = \(10.0, 0.0\) must lie within the walls, from"),
    (TANK, VelocityPoint("v", at=(10.0, 0.2)), r"must lie within the walls, from \(0, 0\) to \(2, inf"),
    ((TANK, Obstacle(Box(0.2, 0.2, at=(1.0, 0.2)))), VelocityPoint("v", at=(1.1, 0.3)), "is not in front of the walls"),
    ((TANK, PLATE), PressureTap("p", at=(1.0, 0.3), side="left"), None),
    ((TANK, Piston(at=0.0, motion=SWAY, side="right", name="maker")), PressureTap("p", at=(0.0, 0.3)), None),
    ((TANK, MAKER), RunUp("u", on="maker", points=[(0.5, 0.0), (0.5, 0.9)]), None),
    ((TANK, MAKER), VelocityPoint("v", at=(0.4, 0.2)), None),
])
def test_places_that_no_fluid_comes_to_are_refused(walls, probe, words):
    with pytest.raises(CaseError, match=words) if words else nullcontext():
        scene_checks.check(scene(walls, [probe]))


@pytest.mark.parametrize("walls, area", [
    (Profile([(0.0, 1.0), (0.6, 0.0), (1.4, 0.0), (2.4, 1.0)]), 0.768),
    ((TANK, Obstacle(Box(0.4, 0.2, at=(0.8, 0.0)))), 1.12),
    ((TANK, Obstacle(Disc(0.1, at=(1.0, 0.25)))), 1.2 - 0.01 * np.pi),
    ((TANK, PLATE), 1.2),
    ((TANK, MAKER), 0.9),
])
def test_current_volumes_end_at_walls_of_any_shape(walls, area):
    found = at_start(scene(walls, [Energy("e", current=True)]))["e"]
    assert found[6] == pytest.approx(area, rel=6e-3)
    assert found[4] == pytest.approx(found[1], rel=1.5e-2)
