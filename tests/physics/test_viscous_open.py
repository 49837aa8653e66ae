"""Viscous water with a free surface: at rest, below a lid that moves, and in waves that walls damp."""

import numpy as np
import pytest
from mpi4py import MPI

from parisph import Box, Case, CaseError, Fluid, Lid, Numerics, Simulation, SurfaceGauge, Tank
from parisph.base.fields import FLUID
from parisph.watch import instruments
from tests import viscous_flows as flows
from tests.scenes import difference, on_ranks

DEPTH, WIDTH = 0.5, 2.0
G, K = 9.81, np.pi / WIDTH


def open_tank(viscosity, width=1.0, cells=10, top=1.5 * DEPTH, lid=False, no_slip=True, elevation=None, form="viscous",
              **numerics):
    """Return the Case of an open tank, or of one with a lid above the water."""
    s = DEPTH / cells
    step = min(0.01 * 10 / cells, 0.4 * s * s / viscosity)
    fluid = Fluid(Box(width=width, height=DEPTH), density=1000.0, viscosity=viscosity, elevation=elevation)
    return Case(title="tank", fluid=fluid, probes=[SurfaceGauge("end", at=0.0)],
                walls=Tank(width=width, height=top, lid=lid, no_slip=no_slip), gravity=(0.0, -G), end_time=100.0,
                numerics=Numerics(**{"spacing": s, "preset": "gentle", "time_step": step, "rtol": 1e-9,
                                      "forces": ("body", form), **numerics}))


def fastest(case, steps):
    """Return the largest velocity component of the fluid in a number of steps [m/s]."""
    s, found = Simulation(case, MPI.COMM_SELF), 0.0
    for _ in range(steps):
        s.advance()
        found = max(found, np.abs(s.particles.u[s.particles.kind == FLUID]).max())
    s.destroy()
    return found


@pytest.mark.parametrize("form", ["viscous", "viscous_morris"])
@pytest.mark.parametrize(("preset", "no_slip", "jitter"), [
    ("violent", True, 0.4), ("gentle", ("left", "bottom"), 0.4), ("gentle", False, 0.0)])
def test_viscous_water_rests_in_an_open_tank(preset, no_slip, jitter, form):
    assert fastest(open_tank(0.01, no_slip=no_slip, preset=preset, jitter=jitter, seed=1, form=form), 200) < 1e-8


@pytest.mark.parametrize("form", ["viscous", "viscous_morris"])
@pytest.mark.parametrize(("preset", "gap"), [("gentle", 1), ("violent", 1), ("violent", 2)])
def test_a_lid_does_not_drive_water_across_air(preset, gap, form):
    """Its particles, one or two spacings above the water, are within the radius of the viscous force."""
    top = DEPTH * (1.0 + gap / 10)
    assert fastest(open_tank(0.01, top=top, lid=Lid(1.0), preset=preset, form=form), 100) < 1e-8


def test_a_lid_drives_the_water_that_it_touches():
    """A column that fills one half of the tank up to the lid."""
    case = open_tank(0.01, top=DEPTH, lid=Lid(1.0)).changed(
        **{"fluid.shape": Box(width=0.5, height=DEPTH), "gravity": (0.0, 0.0)})
    s = Simulation(case, MPI.COMM_SELF)
    for _ in range(20):
        s.advance()
    p = s.particles
    fluid = (p.kind == FLUID) & (p.x[:, 0] < 0.4)
    above, below = fluid & (p.x[:, 1] > 0.9 * DEPTH - 1e-3), fluid & (p.x[:, 1] < 0.5 * DEPTH)
    assert p.u[above, 0].mean() > 0.25 and np.abs(p.u[below, 0]).max() < 0.15
    s.destroy()


def test_a_lid_below_the_surface_is_refused():
    with pytest.raises(CaseError, match="fluid.shape reaches from y = 0 to 0.5: must lie in the tank, from 0 to 0.4"):
        open_tank(0.01, top=0.4, lid=Lid(1.0))


def damping(viscosity, no_slip):
    """Return the rate [1/s] at which a standing wave, half a length in the tank, is damped from t = 1 to 8 s."""
    case = open_tank(viscosity, width=WIDTH, no_slip=no_slip, elevation=f"0.01*cos(pi*x/{WIDTH})")
    s = Simulation(case, MPI.COMM_SELF)
    gauge, found = instruments.build(case, s.comm)[:1], []
    while s.time < 8.0:
        s.advance()
        found.append((s.time, instruments.sample_all(gauge, s.particles, s.domain, s.time)["end"][0]))
    s.destroy()
    t, y = np.transpose(found)
    return flows.damped_wave(t[t > 1.0], y[t > 1.0], (0.0, 0.5), (2.6, 3.6))[0]


def test_the_exact_waves_have_the_rates_of_boundary_layers():
    """2 nu k^2, and k sqrt(nu omega/2)/sinh(2 k d) for the layer at the bed, as nu -> 0."""
    nu, omega = 1e-4, np.sqrt(G * K * np.tanh(K * DEPTH))
    free, bed = (flows.wave_over_a_bed(K, DEPTH, nu, sticky) for sticky in (False, True))
    assert free[0] == pytest.approx(2.0 * nu * K**2, rel=0.02) and free[1] == pytest.approx(omega, rel=1e-4)
    assert bed[0] - free[0] == pytest.approx(K * np.sqrt(0.5 * nu * omega) / np.sinh(2.0 * K * DEPTH), rel=0.05)


def test_a_sticky_bed_damps_a_wave():
    """What it adds, against exact linear waves; its layer is two spacings thick. With four it errs by 7 %."""
    nu = 0.0159
    exact = flows.wave_over_a_bed(K, DEPTH, nu, True)[0] - flows.wave_over_a_bed(K, DEPTH, nu, False)[0]
    assert damping(nu, ("bottom",)) - damping(nu, False) == pytest.approx(exact, rel=0.15)


def test_sticky_sides_damp_a_wave():
    """What they add, against their laminar layers, of one spacing here and without the motion of the water line."""
    nu, omega = 0.004, np.sqrt(G * K * np.tanh(K * DEPTH))
    moved = (np.sinh(2.0 * K * DEPTH) / (4.0 * K) - 0.5 * DEPTH) / np.sinh(K * DEPTH) ** 2    # mean square times length
    rate = omega**2 * np.sqrt(2.0 * nu * omega) * moved / (G * WIDTH)
    assert 0.6 < (damping(nu, True) - damping(nu, ("bottom",))) / rate < 1.8


RANKS = """
from tests.physics.test_viscous_open import DEPTH, Lid, open_tank
for form in ("viscous", "viscous_morris"):
    case = open_tank(0.01, top=1.1 * DEPTH, lid=Lid(1.0), elevation="0.04*cos(pi*x)", form=form, preset="violent",
                     rtol=1e-13)
    s = Simulation(case, comm)
    for _ in range(20):
        s.advance()
    found = s.gather("x", "u", "p", "role")
    if comm.rank == 0:
        np.savez(f"{form}-{comm.size}.npz", **found)
    s.destroy()
"""


def test_ranks_agree_about_the_walls_that_water_touches(tmp_path):
    """A wave whose crest is at the lid, and which leaves it."""
    for n in (1, 2):
        on_ranks(n, RANKS, tmp_path, timeout=300)
    for form in ("viscous", "viscous_morris"):
        one, two = (np.load(tmp_path / f"{form}-{n}.npz") for n in (1, 2))
        np.testing.assert_array_equal(two["role"], one["role"])
        for field in ("x", "u", "p"):
            assert difference(two[field], one[field]) < 1e-9, field
