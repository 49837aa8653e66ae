"""Flaps and pistons make the waves that they are asked for, in coarse flumes with a sponge."""

import numpy as np
import pytest

from parisph import Case, Fluid, Numerics, Output, Sponge, SurfaceGauge, WaveTruth, open_run
from parisph.case.bodies import Flap, Piston, Profile, StillWater
from parisph.case.waves import Jonswap, Stokes
from tests.scenes import run_alone

DEPTH, PERIOD, AT, END = 0.25, 1.1, 1.0, 6.0    # [m], [s]
CALM = 3.0    # [s] until the ramp and the first waves are past the gauge


def flume(maker):
    """Return the case of a flume of 2.5 m of water and a sponge of one wave, s = 0.025 m."""
    bed = [(-0.4, 0.0), (4.3, 0.0), (4.3, 0.4)]
    return Case(
        title="Waves of a wavemaker", fluid=Fluid(StillWater(level=DEPTH), density=1000.0), gravity=(0.0, -9.81),
        walls=(Profile(bed, name="bed"), maker), absorb=Sponge(2.5, 1.8),
        numerics=Numerics(preset="gentle", spacing=0.025, time_step=None),
        output=Output(every=2.0),
        probes=[SurfaceGauge("x", at=AT, truth=WaveTruth(maker.wave, level=DEPTH, window=(CALM, END)))], end_time=END)


@pytest.mark.parametrize(("maker", "limit"), [
    (Flap(hinge=(0.0, 0.0), wave=Stokes(height=0.02, period=PERIOD, depth=DEPTH)), 0.055),
    (Piston(at=0.0, wave=Stokes(height=0.02, period=PERIOD, depth=DEPTH)), 0.055),
    (Piston(at=0.0, wave=Jonswap(height=0.02, period=PERIOD, depth=DEPTH, seed=2, components=20)), 0.16),
])
def test_makes_the_wave(tmp_path, maker, limit):
    summary = run_alone(flume(maker), tmp_path / "run")
    assert summary["status"].startswith("completed")
    assert summary["errors"]["x"]["relative_l2"] < limit
    probe = open_run(tmp_path / "run").probe("x")
    assert np.ptp(probe["y"][probe["time"] > CALM]) > 0.01
