"""Waves in 3D: along a direction, and standing between four walls."""

import numpy as np
import pytest

from parisph import (
    Airy,
    Box,
    Case,
    CaseError,
    Fluid,
    Jonswap,
    Numerics,
    Piston,
    Profile,
    Relaxation,
    SolitaryWave,
    StandingWave,
    StillWater,
    Stokes,
    StreamFunction,
    SurfaceGauge,
    Tank,
    TankMode,
    WaveTruth,
)
from parisph.base.fields import SURFACE
from parisph.case.stored import from_json, to_json
from parisph.geometry import build

WAY = (0.6, 0.8)
ALONG = (3.0, 4.0, 0.0)
X = np.array([[0.2, 0.3, 0.4], [1.6, 0.7, 0.1], [0.9, 0.0, 0.5]])
MODE = TankMode(amplitude=0.002, modes=(1, 1), length=1.0, breadth=0.8, depth=0.5, phase=0.4, at=(0.1, -0.2))
STEP = 1e-4


def scene(fluid, walls=None, absorb=(), probes=(), spacing=0.1):
    return Case(title="waves", fluid=fluid, walls=walls or Tank(width=2.0, height=0.8, breadth=0.8),
                gravity=(0.0, 0.0, -9.81), absorb=absorb, probes=probes,
                numerics=Numerics(spacing=spacing, preset="gentle"), end_time=0.1)


@pytest.mark.parametrize("kind, values", [
    (Airy, {"height": 0.02, "period": 1.2}), (Stokes, {"height": 0.02, "period": 1.2, "at": 0.3, "leftward": True}),
    (StreamFunction, {"height": 0.05, "period": 2.0}), (SolitaryWave, {"height": 0.05, "at": 0.7}),
    (Jonswap, {"height": 0.03, "period": 1.2, "components": 5}), (StandingWave, {"amplitude": 0.01, "length": 1.0}),
])
def test_a_wave_along_a_direction_is_the_same_wave_turned(kind, values):
    plane, turned = kind(depth=0.5, **values), kind(depth=0.5, direction=ALONG, **values)
    along = X[:, :2] @ WAY
    np.testing.assert_allclose(turned.surface(X[:, 0], X[:, 1], 0.3), plane.elevation(along, 0.3), rtol=1e-14)
    u, w = plane.velocity(along, X[:, 2] + 0.1, 0.3)
    np.testing.assert_allclose(turned.flow(X, -0.1, 0.3), np.stack([0.6 * u, 0.8 * u, w], axis=1), rtol=1e-14)


def test_a_mode_has_the_frequency_of_its_wave_number_and_moves_no_wall():
    assert MODE.omega == pytest.approx(6.97802889, rel=1e-9)    # of a box 1 m x .8 m x .5 m, mode (1, 1)
    assert TankMode(0.002, (1, 0), 1.0, 0.8, 0.5).omega == pytest.approx(5.316553374, rel=1e-9)
    walls = np.array([[0.1, 0.3, 0.2], [1.1, 0.0, 0.4], [0.5, -0.2, 0.2], [0.4, 0.6, 0.1], [0.3, 0.2, 0.0]])
    u = MODE.flow(walls, 0.0, 0.2)
    np.testing.assert_allclose([u[0, 0], u[1, 0], u[2, 1], u[3, 1], u[4, 2]], 0.0, atol=1e-16)
    # the surface moves with the fluid, which has no divergence and no vorticity
    x = np.array([[0.42, 0.11, 0.5]])
    rate = (MODE.surface(0.42, 0.11, 0.2 + STEP) - MODE.surface(0.42, 0.11, 0.2 - STEP)) / (2.0 * STEP)
    assert MODE.flow(x, 0.0, 0.2)[0, 2] == pytest.approx(rate, rel=1e-6)
    slope = np.array([(MODE.flow(x + way, 0.0, 0.2) - MODE.flow(x - way, 0.0, 0.2))[0] / (2.0 * STEP)
                      for way in STEP * np.eye(3)])
    assert np.trace(slope) == pytest.approx(0.0, abs=1e-6 * np.abs(slope).max())
    np.testing.assert_allclose(slope, slope.T, atol=1e-6 * np.abs(slope).max())


def test_a_mode_without_half_waves_across_is_a_standing_wave():
    mode, plane = TankMode(0.01, (2, 0), 1.0, 0.8, 0.5, phase=0.3), StandingWave(0.01, 1.0, 0.5, phase=0.3)
    np.testing.assert_allclose(mode.surface(X[:, 0], X[:, 1], 0.1), plane.elevation(X[:, 0], 0.1), rtol=1e-13)
    np.testing.assert_allclose(mode.flow(X, 0.0, 0.1), plane.flow(X, 0.0, 0.1), rtol=1e-13, atol=1e-17)
    assert not mode.varies_across and MODE.varies_across


@pytest.mark.parametrize("wave", [
    TankMode(0.02, (1, 2), 2.0, 0.8, 0.5, phase=1.2), Airy(height=0.05, period=1.2, depth=0.5, direction=ALONG)])
@pytest.mark.parametrize("shape", [Box(width=2.0, height=0.5), StillWater(level=0.5)])
def test_water_starts_with_a_wave_that_varies_across(shape, wave):
    case = scene(Fluid(shape, 1000.0, wave=wave))
    found = build.build(case)
    fluid = found["kind"] == 0
    x = found["x"][fluid]
    top = fluid & (found["role"] == SURFACE)
    assert top.any()
    np.testing.assert_allclose(found["u"][fluid], wave.flow(x, 0.0, 0.0), atol=1e-12)
    x = found["x"][top]
    np.testing.assert_allclose(x[:, 2], 0.5 + wave.surface(x[:, 0], x[:, 1], 0.0), atol=1e-9)
    if isinstance(wave, TankMode):    # whole half waves keep the volume
        assert build.volume(case) == pytest.approx(0.8, rel=1e-6)
    assert from_json(to_json(case)) == case


def test_a_zone_makes_a_wave_along_a_direction_and_a_gauge_knows_it():
    wave = Airy(height=0.01, period=1.0, depth=0.5, direction=ALONG)
    gauge = SurfaceGauge("gauge", at=(0.2, 0.3), truth=WaveTruth(wave, level=0.5))
    case = scene(Fluid(StillWater(0.5), 1000.0), absorb=Relaxation(0.0, 1.8, wave=wave), probes=[gauge])
    rate, pull = case.absorber(X[:1], 0.4)
    np.testing.assert_allclose(pull, rate[:, None] * wave.flow(X[:1], 0.0, 0.4), rtol=1e-14)
    times = np.array([0.0, 0.1])
    np.testing.assert_allclose(gauge.truth.series(0.2, times, 0.3), 0.5 + wave.elevation(0.36, times), rtol=1e-14)


@pytest.mark.parametrize("make, message", [
    (lambda: Airy(0.02, 1.2, 0.5, direction=(1.0, 0.0, 0.5)), "must be horizontal"),
    (lambda: Airy(0.02, 1.2, 0.5, direction=(0.0, 0.0, 0.0)), "not zero"),
    (lambda: TankMode(0.02, (0, 0), 1.0, 1.0, 0.5), "level water"),
    (lambda: TankMode(0.02, (1, 0), 1.0, 1.0, 0.5, direction=ALONG), "leave it out"),
    (lambda: scene(Fluid(Box(2.0, 0.5), 1000.0, wave=MODE), Tank(2.0, 0.8)), "TankMode is for a 3D scene"),
    (lambda: scene(Fluid(StillWater(0.5), 1000.0, wave=MODE), Tank(1.0, 0.8, breadth=0.7, at=(0.1, 0.0))),
     "fluid.wave.breadth = 0.8: the tank has 0.7; change one of them"),
    (lambda: scene(Fluid(Box(2.0, 0.5), 1000.0, wave=Airy(0.02, 1.2, 0.5, direction=ALONG)), Tank(2.0, 0.8)),
     "direction: is for a 3D scene"),
    (lambda: scene(Fluid(StillWater(0.5), 1000.0), (
        Profile([(-0.5, 1.0), (-0.5, 0.0), (4.0, 0.0), (4.0, 1.0)], breadth=0.8),
        Piston(at=0.0, wave=Airy(0.02, 1.2, 0.5, direction=ALONG)))), "wavemaker makes waves along x only"),
])
def test_refused(make, message):
    with pytest.raises(CaseError, match=message):
        make()
