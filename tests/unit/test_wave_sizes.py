"""The waves of walls with a harmonic motion, by linear theory, as of wavemakers that are given a wave."""

from math import pi

import pytest

from parisph import Airy, Case, Flap, Fluid, Numerics, Piston, Roll, StillWater, Sway, Tank
from parisph.case.motion.wavemaker import flap_ratio, piston_ratio
from parisph.case.wave_sizes import sizes

WAVE = Airy(height=0.05, period=1.2, depth=0.5)
TANK = Tank(width=4.5, height=0.9, at=(-0.5, 0.0))


def size(maker, gravity=(0.0, -9.81)):
    case = Case(title="flume", fluid=Fluid(StillWater(level=0.5), density=1000.0), walls=(TANK, maker),
                gravity=gravity, end_time=1.0, numerics=Numerics(preset="gentle", spacing=0.05))
    found = sizes(case)
    return [(one.height, one.length, one.period) for one in found]


def test_a_piston_that_sways_and_a_flap_that_rolls_make_the_wave_that_is_asked_for():
    due = [pytest.approx((WAVE.height, WAVE.length, WAVE.period))]
    assert size(Piston(0.0, wave=WAVE)) == due
    sway = Sway(amplitude=0.5 * WAVE.height / piston_ratio(WAVE.k, 0.5), period=1.2)
    assert size(Piston(0.0, motion=sway)) == due
    stroke = WAVE.height / flap_ratio(WAVE.k, 0.5, 0.1)
    roll = Roll(amplitude=0.5 * stroke / 0.4, frequency=2.0 * pi / 1.2, centre=(0.0, 0.1))
    assert size(Flap(hinge=(0.0, 0.1), motion=roll)) == due
    assert size(Piston(0.0, motion=Sway(amplitude=5.0, period=1.2))) == []    # one that would break
    assert size(Piston(0.0, motion=sway), gravity=(0.1, -9.81)) == []    # a flume that slopes, by its gravity
