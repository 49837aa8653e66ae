"""Scenes in 3D by a breadth: shapes, bodies, motions, sections, checks, JSON."""

import json
import math

import numpy as np
import pytest

from parisph import (
    Box,
    Case,
    CaseError,
    Energy,
    Fluid,
    Heave,
    Numerics,
    PressureTap,
    Roll,
    Sponge,
    SurfaceGauge,
    Sway,
    Tank,
)
from parisph.case import size
from parisph.case.absorb import Relaxation
from parisph.case.bodies import Flap, Obstacle, Piston, Plate, Profile, StillWater
from parisph.case.breadth_checks import gaps, warnings
from parisph.case.expressions import vector_field
from parisph.case.motion import Moved, Series, Tabulated
from parisph.case.sections import cuts, in_section, projected, section, sections
from parisph.case.shapes import Disc, Lid, Polygon
from parisph.case.stored import from_json, to_json
from parisph.case.truths import Truth
from parisph.case.waves import Airy

S, G = 0.055, 9.81
TANK = Tank(width=3.22, height=1.0, breadth=1.0)
BOX = Obstacle(Box(width=0.161, height=0.161, breadth=0.403, at=(0.6635, 0.2985, 0.0)), name="box")
COLUMN = Box(width=1.228, height=0.55, at=(1.992, 0.0))
STEPS = Series(times=(0.0, 1.0, 2.0, 3.0), values=(0.0, 0.1, 0.1, 0.0))


def scene(walls=(TANK, BOX), fluid=None, gravity=(0.0, -G), spacing=S, **others):
    return Case(title="scene", fluid=fluid or Fluid(COLUMN, 1000.0), walls=walls, gravity=gravity,
                numerics=Numerics(spacing=spacing), end_time=1.0, **others)


def test_a_breadth_makes_a_scene_3d():
    case = scene()
    assert (case.dim, case.breadth, case.gravity) == (3, (0.0, 1.0), (0.0, 0.0, -G))
    np.testing.assert_array_equal(case.wall_bounds, [(0.0, 0.0, 0.0), (3.22, 1.0, 1.0)])
    np.testing.assert_allclose(case.fluid_bounds, [(1.992, 0.0, 0.0), (3.22, 1.0, 0.55)])
    assert case.ends == (0.0, 3.22) and not case.closed
    assert scene(Tank(width=3.22, height=1.0)).dim == 2


@pytest.mark.parametrize("walls, fluid, breadth", [
    (Tank(width=4.0, height=1.0, breadth=0.5, at=(0.0, -0.25, 0.0)), None, (-0.25, 0.25)),
    (Tank(width=4.0, height=1.0, breadth=0.5, at=(0.0, 0.0)), None, (0.0, 0.5)),
    (Profile(((0.0, 1.0), (0.0, 0.0), (4.0, 0.0), (5.0, 1.0)), breadth=0.5), None, (0.0, 0.5)),
    ((Profile(((0.0, 0.0), (4.0, 0.0)), across=(0.0, 0.5)), Tank(width=4.0, height=1.0, breadth=2.0)), None,
     (0.0, 2.0)),
    (None, Fluid(Box(width=1.0, height=1.0, breadth=0.5, at=(0.0, 1.0, 0.0)), 1000.0), (1.0, 1.5)),
])
def test_what_gives_the_breadth(walls, fluid, breadth):
    assert scene(walls, fluid or Fluid(StillWater(0.5), 1000.0)).breadth == breadth


def test_extents_and_boxes():
    case = scene((TANK, BOX, Plate(((2.0, 0.0), (2.0, 0.3)), name="p"),
                  Obstacle(Disc(0.1, (1.5, 0.4)), across=(0.2, 0.6))), Fluid(StillWater(0.5), 1000.0))
    tank, box, plate, disc = case.bodies
    assert [case.extent_of(body) for body in case.bodies] == [(0.0, 1.0), pytest.approx((0.2985, 0.7015)), (0.0, 1.0),
                                                              (0.2, 0.6)]
    np.testing.assert_allclose(case.box_of(box), [(0.6635, 0.2985, 0.0), (0.8245, 0.7015, 0.161)])
    np.testing.assert_allclose(case.box_of(plate), [(2.0, 0.0, 0.0), (2.0, 1.0, 0.3)])
    np.testing.assert_allclose(case.box_of(disc), [(1.4, 0.2, 0.3), (1.6, 0.6, 0.5)])
    np.testing.assert_allclose(case.fluid_bounds, [(0.0, 0.0, 0.0), (3.22, 1.0, 0.5)])


@pytest.mark.parametrize("shape, inside, outside", [
    (Box(1.0, 0.5, breadth=0.4, at=(0.0, 0.3, 0.1)), (0.5, 0.35, 0.2), (0.5, 0.25, 0.2)),
    (Box(1.0, 0.5), (0.5, 7.0, 0.2), (0.5, 7.0, 0.6)),
    (Disc(0.5, (1.0, 0.0), across=(0.0, 1.0)), (1.2, 0.9, 0.4), (1.2, 1.1, 0.4)),
    (Polygon(((0.0, 0.0), (1.0, 0.0), (0.0, 1.0)), across=(0.0, 1.0)), (0.4, 0.5, 0.5), (0.4, -0.5, 0.5)),
    (Polygon(((0.0, 0.0), (1.0, 0.0), (0.0, 1.0))), (0.4, 9.0, 0.5), (0.6, 9.0, 0.5)),
])
def test_points_in_shapes(shape, inside, outside):
    assert shape.inside(np.array([inside, outside]), 1e-9).tolist() == [True, False]


def test_a_lid_and_sides_across():
    tank = Tank(1.0, 1.0, breadth=1.0, lid=Lid(velocity=1.0), no_slip=True)
    assert tank.sticky == ("left", "right", "bottom", "top", "front", "back")
    assert Tank(1.0, 1.0, no_slip=True).sticky == ("left", "right", "bottom", "top")
    full = scene(tank, Fluid(Box(1.0, 1.0), 1000.0, viscosity=0.1), spacing=0.1)
    assert full.closed and section(full, 0.0, 1.0).tank.sticky == ("left", "right", "bottom", "top")
    two = scene(Tank(1.0, 1.0, breadth=1.0, no_slip=("front", "top")), STILL, spacing=0.1)
    assert section(two, 0.0, 1.0).tank.no_slip == ("top",)


# -- fields -------------------------------------------------------------------------------

def test_velocity_elevation_and_force_in_3d():
    x = np.array([[0.2, 0.3, 0.4], [0.6, 0.7, 0.1]])
    case = scene(TANK, Fluid(Box(3.22, 0.5), 1000.0, velocity=("x*z", "y"), elevation="0.1*x*y"),
                 gravity=("z", "x + t", -G))
    fluid = case.fluids[0]
    np.testing.assert_allclose(fluid.start_velocity(x), np.stack([x[:, 0] * x[:, 2], 0.0 * x[:, 0], x[:, 1]], axis=1))
    np.testing.assert_allclose(fluid.rise(x[:, 0], x[:, 1]), 0.1 * x[:, 0] * x[:, 1])
    np.testing.assert_allclose(case.body_force(x, 2.0), np.stack([x[:, 2], x[:, 0] + 2.0, [-G, -G]], axis=1))
    numbers = scene(TANK, Fluid(Box(3.22, 0.5), 1000.0, velocity=(1, 2, 3)))
    assert numbers.fluids[0].start_velocity(x)[1].tolist() == [1.0, 2.0, 3.0]
    assert (case.start_vorticity(fluid, x) == 0.0).all()


def test_waves_run_along_x():
    wave = Airy(height=0.02, period=1.2, depth=0.5)
    x = np.array([[0.2, 0.3, 0.4], [0.6, 0.7, 0.1]])
    u, w = wave.velocity(x[:, 0], x[:, 2], 0.0)
    case = scene(TANK, Fluid(StillWater(0.5), 1000.0, wave=wave),
                 absorb=[Relaxation(0.0, 1.0, wave=wave), Sponge(2.0, 1.0)])
    np.testing.assert_array_equal(case.fluids[0].start_velocity(x), np.stack([u, 0.0 * u, w], axis=1))
    rate, pull = case.absorber(x, 0.0)
    np.testing.assert_allclose(pull, rate[:, None] * np.stack([u, 0.0 * u, w], axis=1), rtol=1e-14)
    again, _ = case.absorber(x + [0.0, 0.2, 0.0], 0.0)
    assert rate[0] > 0.0 and (again == rate).all(), "all across"


@pytest.mark.parametrize("frame, expected", [
    (Sway(0.1, 2.0), (1.0, 0.0, 0.0)), (Sway(0.1, 2.0, direction=(3.0, 4.0, 0.0)), (0.6, 0.8, 0.0)),
    (Heave(0.1, 2.0), (0.0, 0.0, 1.0)), (Moved(STEPS, direction=(0.0, 1.0)), (0.0, 0.0, 1.0)),
    (Moved(STEPS, direction=(0.0, 1.0, 0.0)), (0.0, 1.0, 0.0)),
])
def test_directions_of_frames(frame, expected):
    x, t = np.array([[0.2, 0.3, 0.4], [0.6, 0.7, 0.1]]), 0.3
    case = scene(TANK, Fluid(StillWater(0.5), 1000.0), frame=frame)
    shift, rate, second = frame.law(t)
    np.testing.assert_allclose(frame.placed(x, t) - x, np.tile(shift * np.array(expected), (2, 1)), atol=1e-15)
    np.testing.assert_allclose(frame.velocity_at(x, t)[0], rate * np.array(expected), atol=1e-15)
    np.testing.assert_allclose(case.body_force(x, t)[0], np.array([0.0, 0.0, -G]) - second * np.array(expected))


def test_a_roll_turns_the_section():
    x, t, roll = np.array([[0.2, 0.3, 0.4], [0.6, 0.7, 0.1]]), 0.4, Roll(0.3, 2.0, centre=(0.5, 0.1), ramp=0.0)
    flat = x[:, [0, 2]]
    for found, plane in ((roll.placed(x, t), roll.placed(flat, t)), (roll.velocity_at(x, t), roll.velocity_at(flat, t)),
                         (roll.acceleration_at(x, t), roll.acceleration_at(flat, t)),
                         (roll.turned(x, t), roll.turned(flat, t)), (roll.seen(x, t), roll.seen(flat, t))):
        np.testing.assert_array_equal(found[:, [0, 2]], plane)
    assert (roll.placed(x, t)[:, 1] == x[:, 1]).all() and (roll.velocity_at(x, t)[:, 1] == 0.0).all()
    assert (roll.acceleration_at(x, t)[:, 1] == 0.0).all()
    low, high = np.array([0.0, -9.0, 0.0]), np.array([1.0, 9.0, 0.6])
    assert roll.top_speed(low, high) == roll.top_speed(low[[0, 2]], high[[0, 2]])


# -- sections -----------------------------------------------------------------------------

def test_sections_of_a_box_in_a_tank():
    case = scene()
    np.testing.assert_allclose(cuts(case), [0.0, 0.2985, 0.7015, 1.0])
    parts = sections(case)
    assert [[body.name for body in part.bodies] for _, _, part in parts] == [["tank"], ["tank", "box"], ["tank"]]
    _, _, middle = parts[1]
    assert (middle.dim, middle.gravity, middle.probes) == (2, (0.0, -G), ())
    assert middle.tank == Tank(width=3.22, height=1.0, name="tank")
    assert middle.bodies[1] == Obstacle(Box(width=0.161, height=0.161, at=(0.6635, 0.0)), name="box")
    assert middle.fluid == Fluid(COLUMN, 1000.0), "a fluid, not a list"
    assert len(section(case, *cuts(case)[[1, 1]]).bodies) == 2, "in the cut plane there are the bodies of both sides"


def test_ends_that_touch_are_one_cut_and_fluids_end_only_if_asked():
    low, high = (Obstacle(Box(0.2, 0.2, at=(at, 0.0)), name=name, across=ends) for at, name, ends in (
        (0.5, "low", (0.0, 0.4)), (0.5, "high", (0.4 + 1e-6, 1.0 - 1e-6))))
    case = scene((TANK, low, high), Fluid(Box(1.228, 0.55, breadth=0.3, at=(1.992, 0.0, 0.0)), 1000.0))
    np.testing.assert_array_equal(cuts(case), [0.0, 0.4, 1.0])
    assert [[body.name for body in part.bodies[1:]] for _, _, part in sections(case)] == [["low"], ["low"], ["high"]]
    np.testing.assert_array_equal(cuts(case, fluids=True), [0.0, 0.3, 0.4, 1.0])
    assert [len(part.fluids) for _, _, part in sections(case)] == [1, 0, 0]


def test_expressions_in_a_section():
    field = vector_field(("x*y + 2*z - y", "z", "1"), with_time=False)
    flat = vector_field(tuple(in_section(part, -0.3) for part in ("x*y + 2*z - y", "1")), with_time=False)
    np.testing.assert_allclose(field(np.array([[0.2, -0.3, 0.4]]))[:, [0, 2]], flat(np.array([[0.2, 0.4]])))
    case = scene(TANK, Fluid(Box(3.22, 0.5), 1000.0, velocity=("y", "z"), elevation="0.1*y"))
    part = section(case, 0.2, 0.4).fluids[0]
    assert part.rise(np.zeros(1)) == pytest.approx(0.03) and part.start_velocity(np.array([[0, 2.0]]))[0].tolist() == (
        pytest.approx([0.3, 2.0]))


@pytest.mark.parametrize("motion", [Sway(0.1, 2.0, direction=(3.0, 4.0, 0.0)), Heave(0.1, 2.0),
                                    Moved(STEPS, direction=(1.0, 1.0, 1.0)), Roll(0.1, 2.0, centre=(0.5, 0.0)),
                                    Tabulated(STEPS.times, STEPS.values, direction=(1.0, 2.0, 0.0)),
                                    Sway(0.1, 2.0, direction=(0.0, 1.0, 0.0))])
def test_a_motion_in_a_section_is_its_part_there(motion):
    x = np.array([[0.2, 0.3, 0.4]])
    for t in (0.0, 0.3, 1.7):
        np.testing.assert_allclose(projected(motion).velocity_at(x[:, [0, 2]], t),
                                   motion.velocity_at(x, t)[:, [0, 2]], atol=1e-15)


# -- JSON and sizes -----------------------------------------------------------------------

def test_a_case_is_stored_and_read_again():
    for walls in ((TANK, BOX), (TANK, Obstacle(Disc(0.1, (1.0, 0.3)), across=(0.2, 0.4)),
                                Plate(((2.0, 0.0), (2.0, 0.3)), across=(0.0, 0.5)))):
        case = scene(walls, Fluid(StillWater(0.5), 1000.0))
        assert from_json(to_json(case)) == case
    assert case.changed(**{"numerics.spacing": 0.1}).bodies == case.bodies
    flat = scene(Tank(3.22, 1.0))
    assert flat.changed(**{"walls.breadth": 0.5}).breadth == (0.0, 0.5)


def test_a_2d_case_has_no_new_field():
    case = scene((Tank(4.0, 1.0), Obstacle(Disc(0.1, (1.0, 0.3))), Plate(((2.0, 0.0), (2.0, 0.3))),
                  Profile(((0.0, 0.0), (4.0, 0.0))), Piston(0.5, wave=Airy(height=0.02, period=1.2, depth=0.5)),
                  Flap((3.9, 0.0), motion=Roll(0.1, 2.0, centre=(3.9, 0.0)), side="left")),
                 [Fluid(StillWater(0.5), 1000.0, holes=(Box(0.1, 0.1),)),
                  Fluid(Polygon(((0.0, 0.0), (1.0, 0.0), (0.0, 0.1))), 1000.0)])
    text = to_json(case)
    assert "breadth" not in text and "across" not in text
    stored = json.loads(text)
    assert sorted(stored["walls"][0]) == ["at", "height", "kind", "lid", "motion", "name", "no_slip", "width"]
    assert sorted(stored["fluid"][0]["holes"][0]) == ["at", "height", "kind", "width"]
    assert from_json(text) == case


def test_estimated_numbers_of_particles():
    s = 0.05
    count = size.counts(scene(Tank(2.0, 1.0, breadth=1.0), Fluid(Box(1.0, 0.5), 1000.0), spacing=s))
    assert count["fluid"] == pytest.approx(0.5 / s**3, abs=1)
    assert count["wall"] == pytest.approx((2.0 * 1.0 + 2.0 * 1.0 + 4.0) / s**2, abs=1)
    with_box = size.counts(scene((Tank(2.0, 1.0, breadth=1.0), across(0.3, 0.7, at=1.5)), Fluid(Box(1.0, 0.5), 1000.0),
                                 spacing=s))
    assert with_box["wall"] - count["wall"] == pytest.approx((0.8 * 0.4 + 2.0 * 0.04) / s**2, abs=1)
    assert size.memory(1e6, 1, 3) - size.memory(0, 1, 3) == 5.6e9


def test_a_case_with_truths_has_a_hash():
    truth = Truth("p.csv", "t", "p", published={"A": 0.1}, rows={"a": "b"})
    probes = [PressureTap("t", at=(0.0, 0.5, 0.1), truth=truth), Energy("e")]
    assert hash(scene(probes=probes)) == hash(scene(probes=probes))


# -- messages -----------------------------------------------------------------------------

NARROW = Tank(3.22, 1.0, breadth=0.2)
STILL = Fluid(StillWater(0.5), 1000.0)


def across(*ends, at=0.5, name="", **others):
    return Obstacle(Box(0.2, 0.2, at=(at, 0.0)), across=ends, name=name, **others)


@pytest.mark.parametrize("make, words", [
    (lambda: scene(NARROW), "breadth = 0.2 m: is 3.6 spacings, must be at least 4; use a spacing of at most 0.05, or"),
    (lambda: scene((TANK, across(0.5, 1.2, name="wide"))),
     "walls, wide: reaches across from y = 0.5 to 1.2: must lie within the scene, from 0 to 1; move it"),
    (lambda: scene((TANK, across(0.5, 0.52, name="thin"))),
     "walls, thin: only 0.02 m are between the ends y = 0.5 and 0.52, 0.36 spacings, and no wall elements fit there; "
     "let them end at the same y"),
    (lambda: scene((TANK, Profile(((0.0, 0.0), (3.22, 0.1)), breadth=0.9))),
     "walls, profile-1: breadth = 0.9: must be that of the scene, 1 m; change one of them, or give its ends "
     "across=(ya, yb) instead"),
    (lambda: scene((Tank(3.22, 1.0), Profile(((0.0, 0.0), (3.22, 0.1)), breadth=1.0)), STILL),
     "walls, tank: has no breadth, and the scene has one of 1 m; give it breadth=1"),
    (lambda: scene((Tank(3.22, 1.0), across(0.0, 0.5, name="a"))),
     "walls, a: across is for a 3D scene, and this one is 2D; leave it out, or give a Tank or a Profile a breadth"),
    (lambda: scene(Tank(3.22, 1.0), Fluid(Box(1.0, 0.5, breadth=1.0), 1.0)), "fluid.shape: breadth is for a 3D scene"),
    (lambda: scene(None, Fluid(Disc(1.0, across=(0.0, 1.0)), 1.0)), "or give a Box of fluid a breadth"),
    (lambda: scene(Tank(3.22, 1.0), gravity=(0.0, 0.0, -G)),
     "must have 2 components, as the scene is 2D; y points up, as in gravity=(0, -9.81), or give a Tank or a Profile "
     "a breadth, which makes the scene 3D"),
    (lambda: scene(Tank(3.22, 1.0), Fluid(COLUMN, 1000.0, velocity=("z", 0.0))), "fluid: velocity: unknown name 'z'"),
    (lambda: scene(Tank(3.22, 1.0), Fluid(COLUMN, 1000.0, elevation="y")), "fluid: elevation: unknown name 'y'"),
    (lambda: scene(Tank(3.22, 1.0), Fluid(COLUMN, 1000.0, velocity=(1.0, 0.0, 0.0))),
     "fluid: velocity = (1.0, 0.0, 0.0): must have 2 components, as the scene is 2D"),
    (lambda: scene(TANK, Fluid(COLUMN, 1000.0, elevation="z")), "elevation: unknown name 'z'"),
    (lambda: scene(frame=Sway(0.1, 2.0, direction=(1.0, 1.0))),
     "frame.direction = (1.0, 1.0): in 3D z is up, and y across; give three components, (1.0, 1.0, 0.0) across or "
     "(1.0, 0.0, 1.0) upwards"),
    (lambda: scene((TANK, across(0.2, 0.6, name="m", motion=Sway(0.1, 2.0, direction=(0.0, 1.0, 0.0))))),
     "walls, m: motion = sway: the box around it comes within 0 m of tank, must stay 0.11 m clear, 2 spacings, as it "
     "leaves its section; move it away from there, move it less far, or make it smaller"),
    (lambda: scene(TANK, Fluid(Box(1.0, 0.5, breadth=0.6, at=(0.0, 0.5, 0.0)), 1.0)),
     "fluid.shape: reaches across from y = 0.5 to 1.1: must lie within the scene, from 0 to 1"),
    (lambda: scene(Tank(3.22, 1.0), frame=Sway(0.1, 2.0, direction=(1.0, 0.0, 0.0))),
     "frame.direction = (1.0, 0.0, 0.0): must have 2 components, as the scene is 2D"),
    (lambda: scene(TANK, [Fluid(Box(0.5, 0.5, breadth=0.4), 1000.0),
                          Fluid(Box(0.5, 0.5, breadth=0.4, at=(0.2, 0.41, 0.0)), 1000.0)]),
     "fluid[1] and fluid[0]: they are 0.01 m apart across, 0.18 spacings; let them touch, leave a spacing between"),
    (lambda: scene(TANK, Fluid(Box(0.5, 0.5, breadth=0.04), 1000.0)), "fluid.shape: is 0.04 m broad, 0.73 spacings"),
    (lambda: Roll(0.1, 2.0, axis="x"), "Roll has no field 'axis'; a Roll turns the section, in 3D about y; Pitch t"),
    (lambda: scene((TANK, Piston(0.5, motion=Sway(0.1, 3.0), across=(0.0, 0.6), name="maker")), STILL),
     "walls, maker: a wavemaker has no fluid behind it, and beside this one, from y = 0.6 to 1, fluid would come"),
    (lambda: scene(spacing=2e-6), "of memory; at most 2.1e+09 can be numbered"),
    (lambda: scene(probes=[SurfaceGauge("g", at=1.0)]), "at = 1: a gauge of a 3D scene stands at (x, y); give both"),
    (lambda: scene(probes=[PressureTap("t", at=(0.0, 0.1))]), "probe 't': at = (0.0, 0.1) must have 3 components"),
    (lambda: scene(probes=[PressureTap("t", at=(0.0, 0.5, 0.1), diameter=0.1)]), "diameter = 0.1: the disc of a sensor "
     "exists in 2D only; give a radius instead"),
    (lambda: scene(Tank(3.22, 1.0), probes=[SurfaceGauge("g", at=(1.0, 0.5))]),
     "at = (1, 0.5): a gauge of a 2D scene stands at x; leave out y = 0.5"),
    (lambda: scene(Tank(3.22, 1.0), STILL, (0.0, -G), 0.05, probes=[SurfaceGauge("g", at=(1.0, 0.5, 0.2))]), "at = "),
])
def test_messages(make, words):
    with pytest.raises(CaseError) as error:
        make()
    assert words in str(error.value)


def test_gauges_of_a_2d_scene_are_stored_as_before():
    gauge = SurfaceGauge("g", at=1.0)
    assert "y" not in gauge.model_dump() and gauge.place == (1.0,)
    across_it = SurfaceGauge("g", at=(1.0, 0.5))
    assert (across_it.at, across_it.y, across_it.where) == (1.0, 0.5, "x = 1, y = 0.5 m")
    assert SurfaceGauge.model_validate(across_it.model_dump()) == across_it


def test_wavemakers_may_stand_side_by_side():
    pair = [Piston(0.5, motion=Sway(0.1, 3.0), across=ends, name=name)
            for name, ends in (("front", (0.0, 0.6)), ("back", (0.6, 1.0)))]
    assert len(section(scene((TANK, *pair), STILL), 0.6, 1.0).bodies) == 2


def test_a_narrow_gap_across_is_a_warning():
    case = scene((TANK, across(0.0, 0.4, name="one"), across(0.48, 1.0, name="two", at=0.6)))
    apart = scene((TANK, across(0.0, 0.4, name="one"), across(0.48, 1.0, name="two", at=1.0)))
    assert warnings(apart) == [], "they do not face each other"
    assert [line.partition(": flow")[0] for line in warnings(case)] == [
        "walls, one and two: only 0.08 m are between their ends across, 1.5 spacings"]
    assert gaps(scene())[0] == (pytest.approx(0.2985), ("box", "the back"))
    assert warnings(scene()) == [] and math.isclose(cuts(scene())[1], 0.2985)
