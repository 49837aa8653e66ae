"""Words that users try first: what works, and what the message says that exists in their place."""

import json
import re

import numpy as np
import pytest

from parisph import Box, Case, Flap, Fluid, Numerics, Obstacle, Piston, Profile, StillWater, Tank
from parisph.base.errors import CaseError
from parisph.case.motion import Heave, Roll, Series, Sway
from parisph.case.stored import from_json, to_json
from parisph.case.waves import Airy
from parisph.geometry import scene_checks
from parisph.parser import build

MEASURED = Series(times=(0.0, 1.0, 2.0, 3.0), values=(0.0, 0.1, 0.1, 0.0))
GOOD = dict(title="t", fluid=Fluid(Box(1.0, 0.5), 1000.0), walls=Tank(2.0, 1.0), gravity=(0.0, -9.81), end_time=3.0,
            numerics=Numerics(spacing=0.05))


@pytest.mark.parametrize("kind", [Sway, Heave, Roll])
def test_oscillations_take_the_same_words(kind):
    one, other = kind(amplitude=0.1, period=2.0, ramp=1.5), kind(0.1, frequency=np.pi, ramp=1.5)
    t = np.linspace(0.0, 8.0, 801)
    law = np.array([one.law(x) for x in t])
    assert one.law(3.3) == other.law(3.3) and one.omega == np.pi
    assert np.gradient(law[:, 0], t)[1:-1] == pytest.approx(law[1:-1, 1], abs=1e-3)
    assert np.gradient(law[:, 1], t)[1:-1] == pytest.approx(law[1:-1, 2], abs=1e-2)
    assert np.abs(law[:, 1]).max() <= 1.1 * one.top_rate and one.instants(99.0)[-1] == pytest.approx(3.5)
    fast = kind(0.1, frequency=np.pi, ramp=0.1)
    assert fast.top_rate >= 0.99 * max(abs(fast.law(x)[1]) for x in t)
    case = Case(**GOOD, frame=one)
    assert from_json(to_json(case)).frame == one
    assert case.changed(**{"frame.period": 3.0}).frame == kind(amplitude=0.1, period=3.0, ramp=1.5)
    with_both = json.loads(to_json(case))    # as cases were stored for some days
    with_both["frame"]["frequency"] = np.pi
    assert from_json(json.dumps(with_both)).frame.law(3.3) == one.law(3.3)


def test_a_roll_has_an_amplitude_and_understands_its_angle():
    assert Roll(angle=0.1, frequency=2.0) == Roll(amplitude=0.1, frequency=2.0) == Roll(0.1, 2.0)
    assert Roll(angle=MEASURED).angle == Roll(MEASURED).amplitude
    stored = json.loads(to_json(Case(**GOOD, frame=Roll(amplitude=0.1, frequency=2.0))))
    stored["frame"] = {"kind": "roll", "angle": 0.1, "frequency": 2.0, "centre": [0.0, 0.0], "ramp": None}
    assert from_json(json.dumps({**stored, "schema": 2})).frame == Roll(amplitude=0.1, frequency=2.0)


@pytest.mark.parametrize("make, words", [
    (lambda: Roll(), "Roll.amplitude is missing: give amplitude [rad], or a Series"),
    (lambda: Roll(amplitude=0.1), "frequency is missing: give the angular frequency [rad/s], or period [s]"),
    (lambda: Roll(amplitude=0.1, angle=0.1, frequency=1.0), "angle is the earlier name of amplitude; give one of"),
    (lambda: Roll(MEASURED, period=2.0), "period = 2: is that of a harmonic roll; leave it out with a Series"),
    (lambda: Sway(0.1), "Sway.frequency is missing: give angular frequency [rad/s], or period [s]"),
    (lambda: Sway(0.1, 2.0, period=2.0), "frequency = 2 rad/s and period = 2 s: the period of this frequency is 3.141"),
    (lambda: Heave(0.1, period=-1.0), "Heave.period = -1.0: must be greater than 0 (period [s], in place of frequency"),
    (lambda: Sway(0.1, period="2"), "Sway.period = '2': must be a number"),
    (lambda: Sway(0.1, 3.0, stroke=0.2, omega=3.0), "give amplitude, half of the stroke; give frequency "
     "[rad/s] or period [s]"),
    (lambda: Box(1.0, 1.0, depth=2.0, breadth=1.0), "Box has no field 'depth'; a Tank(..., breadth=) or "
     "Profile(..., breadth=) makes a scene 3D, with z up, and other bodies have ends across=(ya, yb); without one it "
     "is 2D, y is up, and forces are per metre of breadth (its fields: width, height, at, breadth)"),
    (lambda: Obstacle(Box(1.0, 1.0), density=500.0, mass=3.0), "Obstacle has no fields 'density', 'mass'; bodies move "
     "only as given, by motion=, and none floats (its fields: shape, name, slip, motion, across)"),
    (lambda: Plain(colour=1, kapa=2, sede=3), "Numerics has no fields 'colour', 'kapa', 'sede'; did you mean 'kappa', "
     "'seed'?"),
    (lambda: Case(**{**GOOD, "gravity": 9.81}), "Case.gravity: must have two components (x, y) [m/s2], of which y "
     "points up, not 9.81; write gravity=(0, -9.81)"),
    (lambda: Case(**{**GOOD, "gravity": (-9.81,)}), "must have 2 components, as the scene is 2D; y points up, as "
     "in gravity=(0, -9.81)"),
    (lambda: Case(**{**GOOD, "fluid": Fluid(Box(3.0, 0.5), 1000.0)}), "or give StillWater(level=0.5), which fills wh"),
])
def test_messages_say_what_exists(make, words):
    with pytest.raises(CaseError) as error:
        make()
    assert words in str(error.value) and "\n" not in str(error.value)


def Plain(**more):
    return Numerics(spacing=0.1, **more)


@pytest.mark.parametrize("maker, side", [
    (Piston(at=0.0, wave=Airy(0.1, 1.0, 0.4), name="maker"), "begin"),
    (Piston(at=0.1, motion=Sway(-0.2, 2.0), side="right", name="maker"), "begin"),
    (Piston(at=1.9, motion=Sway(0.2, 2.0), side="left", name="maker"), "end"),
    (Flap(hinge=(0.0, 0.0), wave=Airy(0.05, 1.2, 0.4), name="maker"), "begin"),
])
def test_a_wavemaker_that_reaches_the_tank_says_where_the_tank_must_begin(maker, side):
    fluid = Fluid(StillWater(0.4), 1000.0)
    said, = scene_checks.faults(Case(**{**GOOD, "fluid": fluid, "walls": (Tank(2.0, 1.0), maker)}))
    tank = re.search(r"(begin|end) the tank behind it, as in Tank\(width=(\S+), height=(\S+), at=\((\S+), (\S+)\)\), "
                     "move less far", said)
    assert tank[1] == side
    width, height, x, y = map(float, tank.groups()[1:])
    case = Case(**{**GOOD, "fluid": fluid, "walls": (Tank(width, height, at=(x, y)), maker)})
    assert scene_checks.faults(case) == [] and scene_checks.warnings(case) == []


def test_a_wavemaker_that_reaches_a_bed_says_where_it_must_begin():
    def faults(left):
        bed = Profile([(left, 1.0), (left, 0.0), (4.0, 0.0), (5.0, 1.0)], name="bed")
        piston = Piston(at=0.0, motion=Sway(-0.2, 2.0), side="right", name="piston")
        return scene_checks.faults(Case(**{**GOOD, "fluid": Fluid(StillWater(0.4), 1000.0), "walls": (bed, piston)}))
    said, = faults(-0.1)
    assert faults(float(re.search(r"begin the bed behind it, at x = (\S+),", said)[1])) == []


@pytest.mark.parametrize("line", [
    "plot run --zoom -1e-1 1 -2.5E+00 .5", "plot run --limits -1e-1 -1e-3", "plot run --time -1e-3",
    "restart run --until -1e-3", "movie run --fps -1e1 --slow -.5e0", "compare run a.csv --offset -1e-3 --scale -1e-3 "
    "--time-scale -1e0 --shift -1e-3 --best-shift -1e-3 --rest -1e-3", "run case --set x=-1e-3", "study s --limit -1e3",
])
def test_negative_numbers_may_have_an_exponent(line):
    args = vars(build().parse_args(line.split()))
    numbers = [value for word in line.split()[2:] if (value := word).startswith("-") and word[1] in ".0123456789"]
    found = [value for item in args.values() for value in (item if isinstance(item, list) else [item])
             if isinstance(value, float) and value < 0.0]
    assert len(found) == len(numbers)
