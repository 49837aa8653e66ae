"""Viscous flow against exact solutions: tests/viscous_flows.py says which exist without periodic boundaries."""

import numpy as np
import pytest

from parisph.base.fields import FLUID
from parisph.methods import straining
from parisph.watch import instruments
from tests import viscous_flows as flows
from tests.scenes import scene, simulated

Y = np.linspace(0.0, 1.0, 21)


def rms(difference):
    return float(np.sqrt(np.mean(np.square(difference))))


def order(coarse, fine):
    """Return the order of convergence of errors at spacings that differ by 2."""
    return np.log2(coarse / fine)


def profile(case):
    s = flows.run(case)
    return flows.middle(s)


def test_flow_that_a_lid_starts_between_walls():
    """Start-up of Couette flow in a closed tank, Re = 1: the flow returns below the lid.

    Of first order: see flows.soften_lid, and tests/convergence/test_viscous_start_up.py for a lid without corners.
    Measured 0.0086 and 0.0039. The corners leave as much with half the spacing again, 0.0040.
    """
    exact = flows.started_by_a_lid(Y, 0.05, 1.0)
    coarse, fine = (rms(profile(flows.tank(1.0 / n, 1.0, 0.05, lid=1.0)) - exact) for n in (10, 20))
    assert fine < 0.0045 and order(coarse, fine) > 1.0, (coarse, fine)


def test_flow_that_a_force_starts_between_walls():
    """As Poiseuille flow, but with a force along x that has no mean, because a closed tank has no flux."""
    nu, time = 0.1, 0.25
    exact = np.sin(2.0 * np.pi * Y) * (1.0 - np.exp(-4.0 * np.pi**2 * nu * time))
    coarse, fine = (rms(profile(flows.tank(1.0 / n, nu, time, gravity=flows.forced(1.0, nu))) - exact)
                    for n in (10, 20))
    assert fine < 0.01 and order(coarse, fine) > 1.5, (coarse, fine)


def test_a_vortex_decays():
    """In a square with free-slip walls, Re = 100, while it turns by about one radian: measured 0.025 and 0.006.

    From an exact lattice, whose rows slide past each other, errors are up to twice as large, by chance.
    """
    found = []
    for n in (15, 30):
        s = flows.run(flows.tank(1.0 / n, 0.01, 0.5, no_slip=False, velocity=flows.VORTEX, length=1.0, jitter=0.05,
                                 seed=1))
        fluid = s.particles.kind == FLUID
        exact = np.exp(-2.0 * 0.01 * np.pi**2 * 0.5) * flows.vortex(s.particles.x[fluid])
        found.append(rms(s.particles.u[fluid] - exact))
    assert found[1] < 0.008 and order(*found) > 1.5, found


def test_eddy_viscosity_of_a_shear():
    """nu_t = (C s)^2 |S| for u = (G y, 0), in the field that the force uses."""
    shear, constant, spacing = 3.0, 0.15, 0.1
    case = flows.tank(spacing, 1e-6, 1.0, no_slip=False, velocity=(f"{shear}*y", 0.0), length=1.0, smagorinsky=constant)
    s = simulated(case)
    s.solve_start()
    p, flow = s.particles, s.method.flow
    p.u[:, 0], p.u[:, 1] = shear * p.x[:, 1], 0.0
    flow.domain.update("u")
    straining.begin(flow)
    straining.finish(flow, 0.01)
    s.method.parts.forces[1].add(np.zeros_like(p.x_all), flow, 0.0)
    inside = (p.kind == FLUID) & (np.abs(p.x - 0.5).max(axis=1) < 0.45)
    np.testing.assert_allclose(p.nu[inside], 1e-6 + (constant * spacing) ** 2 * shear, rtol=1e-10)


# u on x = 1/2 and v on y = 1/2 at Re = 100: U. Ghia, K.N. Ghia, C.T. Shin (1982), J. Comput. Phys. 48, 387-411, Tables
# I and II.
GHIA_U = {0.1016: -0.06434, 0.2813: -0.15662, 0.4531: -0.21090, 0.6172: -0.13641, 0.7344: 0.00332, 0.8516: 0.23151,
          0.9531: 0.68717}
GHIA_V = {0.0938: 0.12317, 0.1563: 0.16077, 0.2266: 0.17507, 0.5: 0.05454, 0.8047: -0.24533, 0.8594: -0.22445,
          0.9453: -0.10313}


def test_driven_cavity():
    """Re = 100 with 20 x 20 particles, the mean from t = 6 to 8 side/U."""
    case = scene("lid_driven_cavity", spacing=0.05, end_time=8, time_step=0.5, points=101)
    s = simulated(case)
    samplers, found = instruments.build(case, s.comm)[:2], []
    while s.time < case.end_time - 1e-9:
        s.advance()
        if s.time > 6.0:
            found.append(np.array(list(instruments.sample_all(samplers, s.particles, s.domain, s.time).values())))
    (u, _, _), (_, v, _) = (line.reshape(-1, 3).T for line in np.mean(found, axis=0))
    grid = np.linspace(0.0, 1.0, 101)
    assert rms(np.interp(list(GHIA_U), grid, u) - list(GHIA_U.values())) < 0.03
    assert rms(np.interp(list(GHIA_V), grid, v) - list(GHIA_V.values())) < 0.03
    assert u[-1] == pytest.approx(1.0, abs=0.05) and np.abs(v[[0, -1]]).max() < 0.01
