"""What `parisph check` and a run say of a case that is not resolved, hardly meant, or cannot be run."""

from pathlib import Path
from time import process_time

import numpy as np
import pytest

from parisph import Box, Case, CaseError, Fluid, Force, Numerics, Output, Relaxation, RunUp, Sponge, Tank
from parisph.case.bodies import Obstacle, Piston, Plate, StillWater
from parisph.case.doubtful import doubts
from parisph.case.load import load
from parisph.case.motion import Heave, PistonStroke, Roll, Series, Sway
from parisph.case.wave_sizes import size_of, sizes, strain_rate
from parisph.case.waves import Airy, Jonswap, SolitaryWave, StandingWave, Stokes
from parisph.driver import describe, precheck
from tests.lasting import obstacles
from tests.lasting.long import Setting
from tests.scenes import run_alone, simulated

CASES = Path(__file__).parents[2] / "cases"
STILL = Fluid(StillWater(level=0.5), density=1000.0)
TANK = Tank(width=4.0, height=0.9)
AIRY = Airy(height=0.05, period=1.2, depth=0.5)    # 2.05 m long


def scene(fluid=STILL, walls=TANK, preset="gentle", spacing=0.05, **values):
    return Case(**{"title": "scene", "fluid": fluid, "walls": walls, "gravity": (0.0, -9.81), "end_time": 1.0,
                   "numerics": Numerics(preset=preset, spacing=spacing), **values})


def waves(wave, **values):
    return scene(Fluid(StillWater(level=0.5), density=1000.0, wave=wave), **values)


def flume(wave, length, kind=Sponge, **values):
    zone = {Sponge: lambda: Sponge(start=4.0 - length, length=length),
            Relaxation: lambda: Relaxation(start=0.0, length=length, wave=wave)}[kind]()
    maker = () if kind is Relaxation else (Piston(at=0.0, wave=wave),)
    return scene(walls=(Tank(width=4.5, height=0.9, at=(-0.5, 0.0)), *maker), absorb=zone, **values)


def standing(amplitude, phase=0.0, length=2.0, **values):
    return waves(StandingWave(amplitude=amplitude, length=length, depth=0.5, phase=phase), **values)


def still(level, **values):
    return scene(Fluid(StillWater(level=level), density=1000.0), **values)


def rolled(angle, **values):
    return scene(walls=Tank(width=0.9, height=1.0, lid=True), frame=Roll(angle=angle, frequency=3.0), **values)


def series(size):
    return Roll(Series(times=(0.0, 1.0, 2.0, 3.0), values=(0.0, size, size, 0.0)))


def plate(length):
    return Plate(((2.0, 0.25), (2.0 + length, 0.25)), name="rod")


def over(body, **values):
    """Return a solitary wave that comes to a body, a box with so many metres a side or a plate."""
    body = body if isinstance(body, Plate) else Obstacle(Box(width=body, height=body, at=(2.0, 0.2)), name="rod")
    return waves(SolitaryWave(height=0.1, depth=0.5), walls=(TANK, body), **values)


DEGREES = "the angle of the Roll reaches 4 rad, 229 degrees: did you mean "
# what is said, a case of which it is said, and one that follows the advice
DOUBTS = {
    "short gentle": ("fluid.wave: its length of 0.4 m is 8 spacings: waves of less than 10 lose 5 %",
                     lambda: standing(0.002, length=0.4), lambda: standing(0.002, length=0.4, spacing=0.04)),
    "short violent": ("fluid.wave: its length of 2.05 m is 19 spacings",
                      lambda: waves(AIRY, preset="violent", spacing=0.11),
                      lambda: waves(AIRY, preset="violent", spacing=0.102)),
    "raised": ("with phase = 1.57 it starts raised by linear theory, without its second harmonic, 15% of its amplitude",
               lambda: standing(0.07, phase=0.5 * np.pi), lambda: standing(0.07)),
    "not linear": ("it is too high for linear theory, by which its second harmonic has 36% of its amplitude, at most "
                   "30%; use an amplitude of at most 0.136", lambda: standing(0.165), lambda: standing(0.136)),
    "Airy": ("fluid.wave: a linear wave of this height lacks its second harmonic, 11% of its amplitude",
             lambda: waves(Airy(height=0.1, period=1.2, depth=0.5)),
             lambda: waves(Stokes(height=0.1, period=1.2, depth=0.5))),
    "standing": ("fluid.wave: length = 3 with at = 0 has no antinode at both walls of the tank, x = 0 and 4: other "
                 "waves will start; use length = 2.66667 and at = 0",
                 lambda: standing(0.01, length=3.0), lambda: standing(0.01, length=8.0 / 3.0)),
    "sponge": ("absorb[0]: the sponge is 1.5 m long, and walls, piston-1: wave has a wave of 2.05 m: more than 2.5 %",
               lambda: flume(AIRY, 1.5), lambda: flume(AIRY, 2.05)),
    "sponge and irregular waves": ("has a wave of 2.05 m", lambda: flume(Jonswap(0.05, 1.2, 0.5), 1.5),
                                   lambda: flume(SolitaryWave(0.05, 0.5), 1.5)),
    "relaxation": ("absorb[0]: the relaxation is 1.5 m long, and absorb[0].wave has a wave of 2.05 m: it leaves "
                   "the zone lower", lambda: flume(AIRY, 1.5, Relaxation), lambda: flume(AIRY, 2.05, Relaxation)),
    "degrees": (f"frame: {DEGREES}radians(4.0), 0.0698 rad?", lambda: rolled(4.0), lambda: rolled(np.radians(4.0))),
    "degrees in a series": (f"{DEGREES}degrees, Series(..., scale=radians(1.0))?",
                            lambda: scene(frame=series(4.0)), lambda: scene(frame=series(0.07))),
    "a paddle in degrees": (f"walls, paddle: motion: {DEGREES}radians(4.0)", lambda: scene(walls=(TANK, Obstacle(
        Box(width=0.2, height=0.2, at=(2.0, 0.15)), name="paddle",
        motion=Roll(angle=4.0, frequency=1.0, centre=(2.1, 0.25))))), lambda: scene()),
    "millimetres": ("frame: its acceleration reaches 250 m/s2, 25 times gravity: did you mean another unit?",
                    lambda: scene(frame=Heave(amplitude=10.0, frequency=5.0)),
                    lambda: scene(frame=Heave(amplitude=0.01, frequency=5.0))),
    "sideways": ("gravity = (0, -9.81, 0): it points sideways, out of an open tank, because z points up",
                 lambda: scene(Fluid(Box(1.0, 0.5), 1000.0), Tank(1.0, 0.8, breadth=0.5), gravity=(0.0, -9.81, 0.0)),
                 lambda: scene(Fluid(Box(1.0, 0.5), 1000.0), Tank(1.0, 0.8, breadth=0.5), gravity=(0.0, 0.0, -9.81))),
    "upwards": ("gravity = (0, 9.81): it points upwards, out of an open tank", lambda: scene(gravity=(0.0, 9.81)),
                lambda: scene(gravity=(0.0, -9.81))),
    "no gravity": ("gravity = (0, 0): nothing keeps the water in an open tank", lambda: scene(gravity=(0.0, 0.0)),
                   lambda: scene(gravity=(0.0, 0.0), walls=Tank(width=4.0, height=0.9, lid=True))),
    "one layer": ("fluid: it is 0.03 m deep, 0.6 spacings: all of it is surface, and the pressure on its bed is 0; use "
                  "a spacing of at most 0.015", lambda: still(0.03), lambda: still(0.03, spacing=0.015)),
    "a small body": ("walls, rod: fluid.wave moves water by 0.5", lambda: over(0.1),
                     lambda: over(0.1, preset="violent")),
    "a plate that lies": ("walls, rod: fluid.wave moves water by 0.5", lambda: over(plate(0.2)),
                          lambda: over(plate(0.6))),
    "snapshots": ("output.every = 1e-05 s: is shorter than a step", lambda: scene(output=Output(every=1e-5)),
                  lambda: scene(output=Output(every=0.1))),
    "a century": ("the run would take about ", lambda: scene(end_time=1e6, spacing=0.005),
                  lambda: scene(end_time=1.0, spacing=0.005)),
}


@pytest.mark.parametrize("name", DOUBTS)
def test_what_is_doubtful_is_said_and_the_advice_helps(name):
    text, make, better = DOUBTS[name]
    told = describe(make())
    assert f"warning     {text}" in told or text in told.partition("warning ")[2]
    assert "warning " not in describe(better())


def test_waves_are_shown_in_spacings_and_steps():
    told = describe(flume(Jonswap(height=0.05, period=1.2, depth=0.5), 2.5))
    assert ("wave        walls, piston-1: wave, significant height 0.05 m (1 spacings), peak length 2.05 m (41), depth "
            "0.5 m (10), about ") in told and "steps in a period of 1.2 s" in told
    assert "wave " not in describe(scene())
    for kind, name in ((Sponge, "walls, piston-1: wave"), (Relaxation, "absorb[0].wave")):
        assert [size.name for size in sizes(flume(AIRY, 2.5, kind))] == [name]
    given = scene(walls=(Tank(width=4.5, height=0.9, at=(-0.5, 0.0)),
                         Piston(at=0.0, motion=PistonStroke(AIRY, place=0.0), name="maker")))
    assert "wave        walls, maker: motion.wave, height 0.05 m" in describe(given)


def test_the_strain_of_a_wave_is_that_of_its_potential():
    """In deep water the mean of sqrt(2 S:S) = 2 a k w exp(k y) |...| over depth is 2 a w/d."""
    deep = size_of("", Airy(height=0.02, period=1.0, depth=3.0), 0.0)
    assert strain_rate(deep, 50.0) == pytest.approx(2.0 * 0.01 * 2.0 * np.pi / 3.0, rel=0.05)
    lasting = size_of("", StandingWave(amplitude=0.01, length=deep.length, depth=3.0), 0.0)
    assert strain_rate(lasting, 50.0) == pytest.approx(strain_rate(deep, 50.0), rel=0.1)
    alone = size_of("", SolitaryWave(height=0.2, depth=1.0), 0.0)
    assert strain_rate(alone, 60.0) == pytest.approx(0.5 * strain_rate(alone, 30.0), rel=1e-9)


ROD = Obstacle(Box(width=0.2, height=0.2, at=(2.0, 0.0)))
FAST = "must be below 1480, the speed of sound in water"
# what is said, and a case that neither check nor run accept
FAULTS = {
    "viscosity": ("fluid.viscosity = 1e.20 m2/s: takes steps of ",
                  lambda: scene(Fluid(StillWater(level=0.5), density=1000.0, viscosity=1e20))),
    "sway": (FAST, lambda: scene(frame=Sway(amplitude=1e6, frequency=1.0))),
    "roll": (f"frame = roll reaches 4.04e.06 m/s, {FAST}", lambda: rolled(1e6)),
    "wall": (f"the fastest of the walls reaches 1e.06 m/s, {FAST}",
             lambda: scene(walls=(TANK.model_copy(update={"motion": Sway(amplitude=1e6, frequency=1.0)}), ROD))),
    "velocity": (f"fluid.velocity reaches 1e.05 m/s, {FAST}",
                 lambda: scene(Fluid(Box(width=4.0, height=0.5), density=1000.0, velocity=(1e5, 0.0)))),
    "gravity": (f"gravity = 1e.08 m/s2: a fall of 0.5 m, the height of the fluid, reaches 1e.04 m/s, {FAST}",
                lambda: scene(gravity=(0.0, -1e8))),
    "film": ("probe 'up': film = 1e.09 m has no effect at a vertical side",
             lambda: scene(probes=[RunUp("up", side="right", film=1e9)])),
    "film beside a rod": ("probe 'up': film = 0.01 m has no effect",
                          lambda: scene(walls=(TANK, ROD), probes=[RunUp("up", side="left", film=0.01)])),
    "viscous SPH": ("fluid.viscosity = 0.001: weakly compressible SPH has its artificial viscosity alone",
                    lambda: scene(Fluid(Box(width=4.0, height=0.5), density=1000.0, viscosity=1e-3),
                                  numerics=Numerics(spacing=0.05, method="SPH"))),
    "force": ("probe 'dry': no fluid touches the left side of tank",
              lambda: scene(walls=(TANK, Obstacle(Box(width=0.6, height=0.9))), probes=[Force("dry", side="left")])),
}


@pytest.mark.parametrize("name", FAULTS)
def test_a_run_and_its_check_refuse_the_same(name):
    text, make = FAULTS[name]
    for use in (describe, lambda case: simulated(case)):
        with pytest.raises(CaseError, match=text):
            use(make())


def test_the_viscosity_that_is_advised_is_accepted():
    case = scene(Fluid(StillWater(level=0.5), density=1000.0, viscosity=1e20))
    with pytest.raises(CaseError, match="use at most ") as refused:
        precheck.check(case)
    most = float(str(refused.value).partition("use at most ")[2].split()[0])
    assert "about " in describe(case.changed(**{"fluid.viscosity": most}))


def test_irregular_waves_for_days_are_checked_at_once():
    """Their motion was looked at up to the end: some minutes for each day."""
    begun = process_time()
    assert "piston" in describe(flume(Jonswap(height=0.05, period=1.2, depth=0.5), 2.5, end_time=2e5))
    assert process_time() - begun < 30.0


def test_a_run_carries_what_was_doubtful(tmp_path):
    case = still(0.03, numerics=Numerics(spacing=0.05), end_time=0.05)
    told = [text for text in precheck.early_warnings(case, {"all": 1}, precheck.scales.expected(case))]
    summary = run_alone(case, str(tmp_path / "run"))
    assert len(told) == 1 and summary["warnings"] == told and summary["status"] == "completed with warnings"
    assert told[0] in (tmp_path / "run" / "run.log").read_text()


def test_waves_past_bodies_that_are_large_enough_are_not_doubtful():
    """The bar is a bed; the obstacles last for 40 periods (tests/lasting)."""
    for case in (load(CASES / "submerged_bar.py"),
                 *(obstacles.long({"obstacle": kind, "height": 0.1, "kd": 1.0, "depth": 10.0},
                                  Setting(None, None, 40.0)).case for kind in ("submerged", "piercing"))):
        assert not any("moves water" in line for line in doubts(case, sizes(case)))
