"""Bad cases are refused before any work, with one clear line for each problem."""

import math
import time

import pytest

from parisph import Case, CaseError, ColumnHeight, Energy, Fluid, Numerics, Output, PressureTap, SurfaceGauge
from parisph.case.bodies import Obstacle, Profile
from parisph.case.motion import Sway, Tabulated
from parisph.case.shapes import Box, Disc, Polygon, Tank
from parisph.case.truths import Truth
from parisph.geometry import scene_checks

BOX = {"kind": "box", "width": 1.0, "height": 1.0}


def scene(**changes):
    values = {
        "title": "test",
        "fluid": Fluid(Box(1.0, 1.0), density=1000.0),
        "walls": Tank(2.0, 2.0),
        "gravity": (0.0, -9.81),
        "numerics": Numerics(spacing=0.1),
        "end_time": 1.0,
    }
    return Case(**{**values, **changes})


def fluid(**changes):
    return Fluid(**{"shape": Box(1.0, 1.0), "density": 1000.0, **changes})


def numerics(**changes):
    return Numerics(**{"spacing": 0.1, **changes})


@pytest.mark.parametrize("make, message", [
    # numbers
    (lambda: Box(-1.0, 1.0), "Box.width = -1.0: must be greater than 0"),
    (lambda: Box(math.nan, 1.0), "Box.width = nan: must be a finite number"),
    (lambda: Box("wide", 1.0), "Box.width = 'wide': must be a number"),
    (lambda: Box(1.0), "Box.height is missing: give a length"),
    (lambda: Box(1.0, 1.0, (1.0,)), "Box.at = .*: must be at least 2 values, not 1"),
    (lambda: Box(1.0, 1.0, (1.0, 2.0), 3.0, 4.0), "Box takes at most 4 values by position .*, got 5"),
    (lambda: Box(1.0, width=1.0), "Box.width is given twice"),
    (lambda: Disc(0.0), "Disc.radius = 0.0: must be greater than 0"),
    (lambda: Tank(1.0, 1.0, lit=True), r"Tank has no field 'lit'; did you mean 'lid'\?"),
    (lambda: Polygon(((0, 0), (1, 0))), "Polygon.points = .*: must be at least 3 values"),
    (lambda: Polygon(((0, 0), (1, 0), (2, 0))), "enclose no area"),
    # three dimensions
    (lambda: Polygon(((0, 0, 0), (1, 0, 0), (2, 1, 0))), "Polygon.points: every corner must have two coordinates .x, "
     "y., in 3D .x, z.: a Polygon is then a prism with the ends across=.ya, yb."),
    (lambda: Box(1.0, 1.0, (0.0, 2.0, 0.5)), "at = .* has three components, .* give breadth=, or at=.0.0, 0.5. in the"),
    (lambda: Disc(1.0, (0.0, 0.0, 0.0)), "Disc.at: .* a Disc in 3D is a cylinder across the scene; .* across=.ya, yb."),
    (lambda: Tank(2.0, 2.0, at=(0.0, 0.0, 0.0)), "at = .* has three components, .* give breadth="),
    (lambda: Tank(2.0, 2.0, no_slip=("front",)), "no_slip: a tank in 2D has no wall 'front'; .* give breadth="),
    (lambda: Disc(1.0, across=(0.5, 0.5)), "Disc.across: .* the first end must be below the second"),
    (lambda: Profile(((0, 0), (1, 0)), breadth=1.0, across=(0.0, 0.5)), "breadth = 1 and across = .* give one of them"),
    (lambda: Obstacle(Box(1.0, 1.0, breadth=1.0), across=(0.0, 0.5)), "across = .*: the shape reaches from y = 0 to 1"),
    # values that no field may have
    (lambda: Box(True, 1.0), "Box.width = True: must be a number"),
    (lambda: Box("1.0", 1.0), "Box.width = '1.0': must be a number"),
    (lambda: Box(b"1", 1.0), "Box.width = b'1': must be a number"),
    (lambda: Box(1e300, 1.0), r"Box.width = 1e.300: must be at most 1e.30 in size \(a length \[m\]\)"),
    (lambda: Box(10**400, 1.0), "Box.width = 1000.*...0000: must be at most 1e.30 in size"),
    (lambda: Box(5e-324, 1.0), "Box.width = 5e-324: must be at least 1e-30"),
    (lambda: Tank(1.0, 1.0, "yes"), "Tank.lid = 'yes': must be True or False"),
    (lambda: Polygon(((0, 0), (1, 0), (1, True))), r"Polygon.points\[2\]\[1\] = True: must be a number"),
    (lambda: Sway(0.1, True), "Sway.frequency = True: must be a number"),
    (lambda: Truth("a\nb", "t", "v"), r"Truth.file = 'a\\nb': must be one line of text"),
    (lambda: Output(times=(0.0,) * (10**6 + 1)),
     r"Output.times\[1000000\] = 0.0: must be one of at most 1,000,000 values"),
    (lambda: Box("w" * 999, 1.0), "Box.width = 'w{36,40}[.]{3}w*': must be a number"),
    (lambda: Box(**{"a\n" * 99: 1.0, "width": 1.0, "height": 1.0}), r"Box has no field 'a\\n.*[.]{3}.*' "),
    # the fluid
    (lambda: fluid(density=-1.0), "Fluid.density = -1.0: must be greater than 0"),
    (lambda: fluid(density=math.inf), "Fluid.density = inf: must be a finite number"),
    (lambda: fluid(shape=3), "Fluid.shape = 3: must be .* Box, Disc or Polygon"),
    (lambda: fluid(shape={"kind": "blob"}), "of a known kind: 'box', 'disc', 'polygon'"),
    (lambda: fluid(shape={**BOX, "width": -1}), r"Fluid.shape.width = -1: must be greater than 0 \(a length \[m\]\)"),
    (lambda: fluid(velocity=(0.0,)), "velocity = .*: must have 2 components"),
    (lambda: fluid(velocity=("q", 0.0)), "velocity: unknown name 'q' in 'q'; known are x, y, pi"),
    (lambda: fluid(velocity=("t", 0.0)), "velocity: unknown name 't'"),
    (lambda: fluid(velocity=(math.nan, 0.0)), r"Fluid.velocity\[0\] = nan: must be a finite number"),
    (lambda: fluid(elevation="z"), "elevation: unknown name 'z'"),
    (lambda: fluid(shape=Disc(1.0), elevation=0.1), "only a Box or StillWater has a top to raise"),
    # numerics and output
    (lambda: numerics(spacing=0.0), "Numerics.spacing = 0.0: must be greater than 0"),
    (lambda: numerics(method="ISHP"), "Numerics.method: unknown method 'ISHP'; known are ISPH_R, ISPH"),
    (lambda: numerics(preset="calm"), "Numerics.preset: unknown preset 'calm'; known are violent, closed, gentle"),
    (lambda: numerics(kapa=0.1), r"Numerics has no field 'kapa'; did you mean 'kappa'\?"),
    (lambda: numerics(surface_rule="gaps"),
     "Numerics.surface_rule: unknown surface_rule 'gaps'; known are gap, auxiliary"),
    (lambda: numerics(rtol=1.0), "Numerics.rtol = 1.0: must be less than 1"),
    (lambda: numerics(jitter=2.0), "Numerics.jitter = 2.0: must be less than or equal to 1.2"),
    (lambda: numerics(seed=True), "Numerics.seed = True: must be a number"),
    (lambda: numerics(jitter_surface=1), "Numerics.jitter_surface = 1: must be True or False"),
    (lambda: numerics(method="x" * 999), "unknown method 'x*[.]{3}x*'; known are"),
    (lambda: numerics(seed=-1), "Numerics.seed = -1: must be greater than or equal to 0"),
    (lambda: numerics(time_step=-0.1), "Numerics.time_step = -0.1: must be greater than 0"),
    (lambda: numerics(zeta=1.0, zeta_time=0.1), "give only one of them"),
    (lambda: numerics(time_step=0.1, max_time_step=0.1), "limits an adaptive step only"),
    (lambda: Output(fields=("u", "swirl")), "Output.fields: unknown field 'swirl'; known are .*u, volume, p"),
    (lambda: Output(every=0.0), "Output.every = 0.0: must be greater than 0"),
    (lambda: Output(probe_every=0), "Output.probe_every = 0: must be greater than or equal to 1"),
    (lambda: Output(times=(-1.0,)), r"Output.times\[0\] = -1.0: must be greater than or equal to 0"),
    # probes and motions
    (lambda: PressureTap("../../etc", at=(0.0, 0.0)), "PressureTap.name: '../../etc' cannot name a file"),
    (lambda: Energy(""), "Energy.name: '' cannot name a file"),
    (lambda: Energy("a" * 65), "cannot name a file"),
    (lambda: Energy(".hidden"), "cannot name a file"),
    (lambda: Energy("a\n"), "Energy.name = .*: must be one line of text"),
    (lambda: Truth("f", time="t"), "Truth.value is missing"),
    (lambda: Sway(0.1, 0.0), "Sway.frequency = 0.0: must be greater than 0"),
    (lambda: Sway(0.1, 1.0, (0.0, 0.0)), "Sway.direction: .* must not be zero"),
    (lambda: Tabulated((0, 1, 1, 2), (0, 0, 0, 0)), r"times\[2\] = 1.0: must be later"),
    (lambda: Tabulated((0, 1, 2, 3), (0, 0, 0, 0, 0)), "values: 5 displacements for 4 times"),
    (lambda: Tabulated((0, 1), (0, 1, 2, 3)), "Tabulated.times = .*: must be at least 4 values"),
])
def test_parts(make, message):
    with pytest.raises(CaseError, match=message) as error:
        make()
    assert len(str(error.value).split("\n")) == 1
    assert "pydantic" not in str(error.value) and "Input should" not in str(error.value)


@pytest.mark.parametrize("changes, message", [
    ({"numerics": numerics(spacing=1e-6)},
     r"makes about 1e.12 particles, 6e.06 of them on walls, which take about 2.5 PB of memory; at most 2.1e.09"),
    ({"walls": Tank(1e8, 1e8)},
     r"makes about 3e.09 particles, 3e.09 of them on walls, which take about 7.5 TB of memory"),
    ({"walls": Tank(1e30, 1e30)}, r"makes about 3e.31 particles"),
    ({"fluid": fluid(shape=Disc(1e6)), "walls": None}, r"makes about 3.14e.14 particles, 0 of them on walls"),
    ({"fluid": fluid(shape=Polygon(((0, 0), (1e9, 1e9), (1e9, 1e9 + 1e-3)))), "walls": None},
     r"makes about 1e.10 particles"),
    ({"fluid": fluid(shape=Box(1.0, 1.0, (1e17, 0.0))), "walls": None},
     r"fluid.shape: reaches 1e.17 m from the origin, at most 1e.09 spacings"),
    ({"walls": Tank(2.0, 2.0, at=(-1e12, 0.0)), "fluid": fluid(shape=Box(1.0, 1.0, (-1e12, 0.0)))},
     "walls: reaches 1e.12 m from the origin"),
    ({"gravity": (0.0, 0.0), "numerics": numerics(method="SPH")},
     "numerics.sound_speed: is not set, and without gravity .* set it to 10 times the highest speed"),
    ({"walls": Tank(2.0, 2.0, no_slip=True), "numerics": numerics(method="SPH")},
     "walls, tank: weakly compressible SPH has no friction on walls; choose a projection method"),
    ({"walls": Tank(2.0, 2.0, motion=Sway(0.01, 1.0)), "numerics": numerics(method="SPH")},
     "walls, tank: weakly compressible SPH has no walls that move; choose a projection method"),
    ({"frame": Sway(1.0, 1e9)}, r"frame = sway reaches 1e.09 m/s, must be below 1480, the speed of sound in water"),
    ({"frame": Sway(1e-6, 1e9), "end_time": 1e5}, r"frame: 50 steps in a period of 6.3e-09 s takes steps of 1.3e-10"),
    ({"frame": Tabulated((0, 1, 1e6, 1e8), (0, 1000, 1000, 1000)), "end_time": 1e5},
     r"frame: a tank that moves at 1e.03 m/s takes steps of 8e-05 s: some 1.2e.09 of them"),
    ({"frame": Sway(1e-12, 1e10)}, r"frame: 50 steps in a period of 6.3e-10 s takes steps of 1.3e-11 s"),
    ({"frame": Tabulated((0, 1e-12, 1, 2), (0, 1, 1, 1))}, r"frame = tabulated reaches 1e.12 m/s"),
    ({"fluid": fluid(velocity=(1e12, 0.0))}, r"fluid.velocity reaches 1e.12 m/s, must be below 1480"),
    ({"fluid": fluid(velocity=(1e3, 0.0)), "end_time": 1e6},
     r"fluid.velocity and numerics.spacing: a step that moves the fastest fluid by 0.8 spacings takes steps of"),
    ({"numerics": numerics(time_step=1e-12)},
     r"numerics.time_step = 1e-12 s takes steps of 1e-12 s: some 1.0e.12 of them until end_time = 1 s, at most 1e.08"),
    ({"numerics": numerics(max_time_step=1e-12)}, "numerics.max_time_step = 1e-12 s takes"),
    ({"end_time": 1e20}, "some .* of them until end_time = 1e.20 s"),
    ({"output": Output(every=1e-9)}, r"output.every = 1e-09 s: makes 1.0e.09 files until end_time = 1 s, "
                                     r"at most 1e.06"),
    ({"output": Output(checkpoint_every=1e-9)}, "output.checkpoint_every = 1e-09 s: makes"),
    ({"fluid": fluid(velocity=("1e200", 0.0))},
     r"fluid.velocity\[0\] = '1e200': is 1e.200, more than 1e.30 in size, at \(0, 0\)"),
    ({"fluid": fluid(shape=Box(1.0, 3.0))}, "reaches from y = 0 to 3: must lie within the walls, from 0 to 2"),
    ({"fluid": fluid(shape=Disc(1.0, (0.5, 1.0)))}, "reaches from x = -0.5 to 1.5: must lie within the walls"),
    ({"fluid": fluid(elevation="0.6*x-0.6")}, "fluid.elevation = '0.6.x-0.6': reaches from -0.6 to 0, "
                                              "must stay between -0.5 and 1"),
    ({"fluid": fluid(elevation="1/x")}, "fluid.elevation = '1/x': is not a finite number at x = 0"),
    ({"fluid": fluid(shape=Box(1.0, 1.8), elevation=0.3), "walls": Tank(2.0, 2.0)},
     "raises the surface to 2.1, above the tank's top at 2"),
    ({"fluid": fluid(velocity=("log(-x-1)", 0.0))},
     r"fluid.velocity\[0\] = 'log\(-x-1\)': is not a finite number at \(0, 0\)"),
    ({"gravity": (0.0,)}, "gravity = .*: must have 2 components"),
    ({"gravity": (0.0, "1/t")}, r"gravity\[1\] = '1/t': is not a finite number"),
    ({"gravity": (0.0, "g")}, "gravity: unknown name 'g' in 'g'; known are x, y, t, pi"),
    ({"gravity": (0.0, math.inf)}, r"Case.gravity\[1\] = inf: must be a finite number"),
    ({"walls": None, "frame": Sway(0.1, 1.0)}, "there is no tank to move"),
    ({"frame": Sway(0.1, 1.0, (1.0, 0.0, 0.0))}, "frame.direction = .*: must have 2 components"),
    ({"end_time": 0.0}, "Case.end_time = 0.0: must be greater than 0"),
    ({"end_time": True}, "Case.end_time = True: must be a number"),
    ({"gravity": (0.0, True)}, r"Case.gravity\[1\] = True: must be a number"),
    ({"title": ""}, "Case.title = ''"),
    ({"title": "x" * 201}, "Case.title = 'x*[.]{3}x*': must be a text of at most 200 characters"),
    ({"title": "a\n2026-01-01 ERROR"}, r"Case.title = 'a\\n2026-01-01 ERROR': must be one line of text"),
    ({"title": "\x1b[2J"}, r"Case.title = '\\x1b\[2J': must be one line of text"),
    ({"gravity": (0.0, "x" + "+x" * 1200)}, "the expression has 2401 characters"),
    ({"numerics": numerics(time_step=0.2)},
     r"numerics.time_step = 0.2 s: is \d+ times the step of .* s that moves the fastest fluid by 0.3 spacings"),
    ({"numerics": numerics(time_step=0.01), "end_time": 0.005}, "numerics.time_step = 0.01 s: is longer than the run"),
    ({"output": Output(times=(2.0,))}, "output.times: 2 s is after the end of the run"),
    ({"probes": [Energy("a"), Energy("a")]}, "probes: the name 'a' is given 2 times"),
    ({"probes": [PressureTap("a", (2.0, 1.0, 0.0))]}, "must have 2 components"),
    ({"probes": [PressureTap("a", (0.0, 1.0))], "walls": None}, "a pressure tap needs a wall"),
    ({"probes": [SurfaceGauge("a", 2.1)]}, "probe 'a': at = 2.1 must lie within the walls, from x = 0 to 2"),
    ({"probes": [ColumnHeight("a", -0.1)]}, "probe 'a': at = -0.1 must lie within the walls"),
    ({"probes": Energy("a")}, r"Case.probes: must be a list; write probes=\[Energy\(...\)\]"),
    ({"probes": [{"kind": "thermometer", "name": "a"}]},
     r"Case.probes\[0\] = .*: must be of a known kind: 'column_height', "),
    ({"probes": [{"kind": "energy", "name": "a", "at": 1}]}, "Energy has no field 'at'"),
    ({"fluid": {"shape": {**BOX, "width": -1.0}, "density": 1.0}},
     "Case.fluid.shape.width = -1.0: must be greater than 0"),
])
def test_whole_cases(changes, message):
    with pytest.raises(CaseError, match=message) as error:
        scene(**changes)
    assert len(str(error.value).split("\n")) == 1
    assert "Input should" not in str(error.value)


@pytest.mark.parametrize("changes, message", [
    ({"numerics": numerics(spacing=0.5), "fluid": fluid(shape=Box(0.5, 0.5))},
     "leaves 1 fluid particles, at least 4 are needed"),
    ({"probes": [PressureTap("a", (1.0, 1.0))]}, r"probe 'a': at = \(1.0, 1.0\) is not on a wall; the nearest place"),
    ({"probes": [PressureTap("a", (1.0, 2.0))]}, "probe 'a': at = .* is not on a wall"),  # no lid
    ({"probes": [PressureTap("a", (2.0, 2.5))]}, "is not on a wall"),
])
def test_what_the_geometry_of_a_case_tells(changes, message):
    with pytest.raises(CaseError, match=message):
        scene_checks.check(scene(**changes))


def test_every_problem_has_its_line():
    with pytest.raises(CaseError) as error:
        scene(probes=[SurfaceGauge("a", 5.0), SurfaceGauge("a", 0.0), ColumnHeight("b", -1.0)])
    assert len(str(error.value).split("\n")) == 3
    with pytest.raises(CaseError) as error:
        Numerics(spacing=-1.0, method="x", cfl=7.0)
    assert len(str(error.value).split("\n")) == 3


def test_many_problems_are_counted():
    with pytest.raises(CaseError) as error:
        Output(times=(-1.0,) * 1000)
    lines = str(error.value).split("\n")
    assert len(lines) == 11 and lines[-1] == "and 990 more problems like these"
    with pytest.raises(CaseError, match="and 990 more problems"):
        scene(output=Output(times=(2.0,) * 1000))


def test_stored_text_is_checked_like_a_case():
    text = scene().model_dump_json()
    with pytest.raises(CaseError, match="Case.fluid.density = -1000.0: must be greater than 0"):
        Case.model_validate_json(text.replace('"density":1000.0', '"density":-1000.0'))
    with pytest.raises(CaseError, match="Case cannot be read: Invalid JSON"):
        Case.model_validate_json(text[:-5])
    with pytest.raises(CaseError, match="Case has no field 'colour'"):
        Case.model_validate_json(text[:-1] + ',"colour":1}')


@pytest.mark.filterwarnings("error")
def test_sizes_without_a_limit_are_refused_at_once_and_without_warnings():
    begun = time.process_time()
    for length in (1e6, 1e8, 1e15, 2e29):
        for shape in (Box(length, length), Disc(length), Polygon(((0, 0), (length, 0), (0, length)))):
            for walls in (None, Tank(4 * length, 4 * length, at=(-2 * length, -2 * length))):
                for spacing in (1e-30, 1e-3):
                    with pytest.raises(CaseError, match="makes about .* particles|must divide|reaches"):
                        scene(fluid=fluid(shape=shape), walls=walls, numerics=numerics(spacing=spacing))
    assert time.process_time() - begun < 5.0


@pytest.mark.parametrize("shape", [
    Polygon(((0, 0), (900, 0), (900, 900))), Box(900.0, 900.0), Disc(450.0, (450.0, 450.0)),
    Polygon(((0, 0), (300, 300), (300, 300.1))),
])
def test_large_bodies_that_fill_their_rectangle_and_small_ones_are_let_through(shape):
    scene(fluid=fluid(shape=shape), walls=None, numerics=numerics(spacing=0.05))


def test_good_edges_are_let_through():
    scene(walls=Tank(1e6, 1e6), numerics=numerics(spacing=0.05))     # 6e7 wall particles: for a large machine
    scene(fluid=fluid(shape=Disc(100.0)), walls=None, numerics=numerics(spacing=0.01))
    scene(fluid=fluid(shape=Box(1.0, 1.0, (1e-8, 0.0))), walls=Tank(1.0 + 1e-8, 2.0), numerics=numerics(spacing=0.05))
    scene(walls=Tank(2.0, 2.0, lid=True), probes=[PressureTap("lid", (1.0, 2.0)), SurfaceGauge("wall", 2.0)])
    scene(fluid=fluid(shape=Box(2.0, 2.0)))
    scene(walls=None, fluid=fluid(shape=Disc(0.55)), gravity=("-x", "-y"))
    scene(numerics=numerics(spacing=1.0 / 3.0, time_step=0.05))
