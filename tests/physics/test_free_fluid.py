"""Fluid without a tank: momentum and volume are conserved."""

import numpy as np
import pytest

from parisph.case.waves import drop_half_axes, ellipsoid_half_axes
from parisph.watch import instruments
from tests.scenes import scene, simulated


def sampled(s):
    """Return {probe: {column: value}} of now."""
    samplers = instruments.build(s.case, s.comm)
    found = instruments.sample_all(samplers, s.particles, s.domain, s.time)
    return {sampler.name: dict(zip(sampler.columns, found[sampler.name])) for sampler in samplers}


def steps(s, count):
    """Take steps; return what the probes saw before and after."""
    s.solve_start()
    before = sampled(s)
    for _ in range(count):
        s.advance()
    return before, sampled(s)


@pytest.mark.parametrize(("stiffness", "end"), [(0.0, 1.0), (1.0, 2.0)])
def test_drop_in_a_straining_flow(stiffness, end):
    """It stays an ellipse with known half axes; with a central force it oscillates."""
    s = simulated(scene("free_drop", {"time_step": 0.01}, spacing=0.05, stiffness=stiffness))
    _, after = steps(s, round(end / 0.01))
    axes = 2.0 * np.sqrt(np.mean(s.particles.x ** 2, axis=0))     # of an ellipse: <x^2> = a^2/4
    exact = np.ravel([axis[-1] for axis in drop_half_axes(np.array([0.0, s.time]), 1.0, 1.0, stiffness)])
    np.testing.assert_allclose(axes, exact, rtol=0.04)
    assert after["volume"]["cell"] == pytest.approx(1.0, abs=0.01)
    whole = np.pi * 1000.0      # mass times the speed on the rim
    assert np.hypot(after["momentum"]["px"], after["momentum"]["py"]) < 5e-3 * whole


@pytest.mark.parametrize(("stiffness", "rates"), [(0.0, (0.5, 0.5, -1.0)), (1.0, (0.4, -0.1, -0.3))])
def test_drop_in_3d(stiffness, rates):
    """It stays an ellipsoid, and keeps its energy but for the work of the force."""
    s = simulated(scene("drop_3d", {"time_step": 0.02}, spacing=0.2, stiffness=stiffness))
    start = np.mean(s.particles.x ** 2, axis=0)    # of a ball: a^2/5
    _, after = steps(s, 10)
    axes = np.sqrt(np.mean(s.particles.x ** 2, axis=0) / start)
    exact, strain, pressure = ellipsoid_half_axes(np.array([0.0, s.time]), (1.0, 1.0, 1.0), rates, stiffness)
    np.testing.assert_allclose(axes, exact[-1], rtol=0.015)
    assert after["rate"]["u"] == pytest.approx(0.5 * strain[-1, 0], rel=0.03)
    assert after["centre"]["p"] == pytest.approx(1000.0 * pressure[-1], rel=0.15)    # .02 with R/s = 10
    assert np.abs([after["momentum"][f"p{axis}"] for axis in "xyz"]).max() < 1e-3 * 4188.8


def centre_pressure():
    """Pressure in the middle of a square patch in rotation over rho omega^2 L^2 (Colagrossi 2005): a double sine
    series."""
    m = np.arange(1, 400, 2)
    k2 = (m[:, None] ** 2 + m[None, :] ** 2) * np.pi**2
    sign = np.sin(0.5 * np.pi * m)
    return -2.0 * np.sum(16.0 / np.pi**2 * np.outer(sign / m, sign / m) / k2)


@pytest.mark.parametrize("settle", ["solve_start", "advance"])
@pytest.mark.parametrize("preset", ["violent", "gentle"])
def test_first_pressure_of_a_rotating_patch(preset, settle):
    """Of the start, where no step has been made, and of the first step: both are the exact one."""
    s = simulated(scene("rotating_patch", {"time_step": 1e-3, "preset": preset}, spacing=0.05))
    getattr(s, settle)()
    centre = np.argmin(np.linalg.norm(s.particles.x, axis=1))
    assert s.particles.p[centre] / 1000.0 == pytest.approx(centre_pressure(), rel=2e-3)


@pytest.mark.parametrize("stiffness", [0.0, 1.0])
@pytest.mark.parametrize("numerics", [{}, {"strain": 0.0}, {"zeta_time": 0.1}, {"gamma": 0.1}])
def test_first_pressure_of_a_straining_drop(stiffness, numerics):
    """p = rho/2 (1 + B^2) (R^2 - r^2) at the start, whatever the weights of a step are.

    The particles end up to a spacing inside the circle, so the pressure is lower by as much everywhere.
    """
    s = simulated(scene("free_drop", {"time_step": 0.01, **numerics}, spacing=0.025, stiffness=stiffness))
    s.solve_start()
    p = s.particles
    unit = 500.0 * (1.0 + stiffness**2)
    inside = np.linalg.norm(p.x, axis=1) < 0.5
    lower = 1.0 - (p.x[inside] ** 2).sum(axis=1) - p.p[inside] / unit
    assert 0.0 < lower.mean() < 0.05, "2 s/R at most"
    assert np.ptp(lower) < 0.02


def spin(p):
    """Return the angular momentum about the middle over that of one particle a metre from it."""
    return np.sum(p.x[:, 0] * p.u[:, 1] - p.x[:, 1] * p.u[:, 0])


def test_rotating_patch():
    """The pressure in the middle is negative and the corners move outwards, until t omega = 1.4."""
    s = simulated(scene("rotating_patch", spacing=0.05))
    turning = spin(s.particles)
    before, after = steps(s, 88)
    p = s.particles
    assert np.isfinite(p.x).all() and np.isfinite(p.u).all() and len(p.x) == 441
    assert s.time > 1.2
    assert spin(p) == pytest.approx(turning, rel=0.02)
    assert after["energy"]["total"] == pytest.approx(before["energy"]["total"], rel=0.03)
    assert after["volume"]["cell"] == pytest.approx(1.0, abs=0.01)
    assert np.hypot(after["momentum"]["px"], after["momentum"]["py"]) < 1e-3 * before["energy"]["total"]
    assert np.linalg.norm(p.x, axis=1).max() > 0.85       # a corner was at 0.707
    assert p.p.min() < -0.05 * 1000.0
