"""Water at rest stays at rest, with hydrostatic pressure, under every method."""

import numpy as np
import pytest

from parisph.base.fields import BALLISTIC, DRY, FLUID, INNER, SURFACE, WET
from parisph.case.methods import METHODS
from parisph.case.schema import Box, Case, Disc, Fluid, Numerics, Tank
from tests.scenes import run_alone, scene, simulated, water
from tests.solid_scenes import errors_at_rest

G, DENSITY = 9.81, 1000.0
STEPS = 1000


@pytest.mark.parametrize("jitter", [0.0, 0.4, 0.8])
def test_open_tank(jitter):
    """Depth 1 m: u in sqrt(gd), p in rho g d, over 10 sqrt(d/g)."""
    speed, error = errors_at_rest(scene("hydrostatic", jitter=jitter), "tank", STEPS)
    assert speed.max() <= 1e-10 and error.max() <= 1e-8    # of solves to 1e-9: 4e-11, 9e-10
    # nothing grows: the last fifth is no worse than the second
    fifth = STEPS // 5
    assert speed[-fifth:].max() < 1.5 * speed[fifth:2 * fifth].max()
    assert error[-fifth:].max() < 1.5 * error[fifth:2 * fifth].max()


@pytest.mark.parametrize("lid", [False, True])
def test_violent_preset_leaves_water_at_rest(lid):
    """Its regularisation must find no gradient of concentration at the water line, or motion grows out of rounding."""
    case = water((1.0, 1.0), (1.0, 1.5, lid), dict(spacing=0.05, time_step=0.01 / np.sqrt(G)), density=DENSITY,
                 title="still", gravity=(0.0, -G), end_time=10.0)
    s = simulated(case)
    p = s.particles
    for _ in range(200):
        s.advance()
        assert np.abs(p.u[p.kind == FLUID]).max() < 1e-6 * np.sqrt(G)


def test_the_case_judges_itself(tmp_path):
    """Its truths are constants, given by two points of which one is later than any run."""
    found = run_alone(scene("hydrostatic", end_time=0.1), tmp_path / "run")["errors"]
    assert all(error["relative_l2"] < 1e-6 for error in found.values())
    # the last pressure of a run is written twice
    assert {name: error["points"] for name, error in found.items()} == {"bed": 12, "middle": 11}


def still(shape, walls, gravity, **numerics):
    """Return the Simulation of a body of fluid at rest, with its pressure at the start."""
    case = Case(title="still", fluid=Fluid(shape, density=DENSITY), walls=walls, gravity=gravity,
                numerics=Numerics(**{"spacing": 0.1, "preset": "gentle", **numerics}), end_time=1.0)
    s = simulated(case)
    s.solve_start()
    return s


@pytest.mark.parametrize("gap", [0.3, 0.7, 1.0, 1.4, 2.0])
@pytest.mark.parametrize("numerics", [{"preset": "gentle"}, {"preset": "violent", "rtol": 1e-9},
                                      {"preset": "violent", "rtol": 1e-9, "surface_rule": "auxiliary"},
                                      {"preset": "violent", "rtol": 1e-9, "surface_rule": "density"}], ids=str)
def test_water_below_a_lid(gap, numerics):
    """The surface is found at any distance [s] of the lid, though wall particles stand where neighbours would be."""
    layers = 10 - int(np.ceil(gap))
    depth = 1.0 - 0.1 * gap
    case = water((1.0, 0.1 * layers), (1.0, 1.0, True), dict(spacing=0.1, **numerics), density=DENSITY,
                 elevation=depth - 0.1 * layers, title="still", gravity=(0.0, -G))
    s = simulated(case)
    s.solve_start()
    p = s.particles
    for step in range(50):
        wet = np.isin(p.role, (INNER, SURFACE, WET))
        error = np.abs(p.p - DENSITY * G * np.maximum(depth - p.x[:, 1], 0.0))[wet].max() / (DENSITY * G * depth)
        assert error < 1e-6, step
        assert p.role[(p.kind == FLUID) & (p.x[:, 1] > depth - 0.01)].tolist() == [SURFACE] * 9
        assert s.advance().isolated == 0
    assert np.abs(p.u[p.kind == FLUID]).max() < 1e-6


@pytest.mark.parametrize("jitter", [0.0, 0.4])
def test_full_closed_box(jitter):
    """No free surface: the pressure is hydrostatic, with a mean of zero."""
    s = still(Box(width=1.0, height=1.0), Tank(width=1.0, height=1.0, lid=True), (0.0, -G),
              time_step=0.01, jitter=jitter)
    assert s.case.closed
    for _ in range(200):
        report = s.advance()
        assert report.fallback == "" and report.surface == report.isolated == 0
    p = s.particles
    assert np.abs(p.u[p.kind == FLUID]).max() < 1e-8
    weight = -DENSITY * G * p.x[:, 1]
    np.testing.assert_allclose(p.p, weight - weight.mean(), atol=1e-6 * DENSITY * G)


@pytest.mark.parametrize("preset", ["gentle", "violent"])
def test_closed_box_looks_for_no_surface(preset):
    s = still(Box(width=1.0, height=1.0), Tank(width=1.0, height=1.0, lid=True), (0.0, -G), preset=preset)
    assert s.numerics.surface_rule == "none"
    assert not np.isin(s.particles.role, (SURFACE, BALLISTIC, DRY)).any()


def test_body_force_of_the_box_is_balanced_in_any_direction():
    s = still(Box(width=1.0, height=1.0), Tank(width=1.0, height=1.0, lid=True), (3.0, "2 + 0*x"), time_step=0.01)
    s.advance()
    p = s.particles
    due = DENSITY * (3.0 * p.x[:, 0] + 2.0 * p.x[:, 1])
    np.testing.assert_allclose(p.p, due - due.mean(), atol=1e-5 * DENSITY)


@pytest.mark.parametrize("jitter", [0.0, 0.4])
def test_free_fluid_without_gravity_rests(jitter):
    """Nothing limits the adaptive step here: no velocity, no force."""
    s = still(Disc(radius=1.0), None, (0.0, 0.0), jitter=jitter)
    start = s.gather("x")["x"]
    while not s.finished():
        s.advance()
    end = s.gather("x", "u", "p")
    assert s.time == 1.0 and 5 <= s.steps <= 20
    np.testing.assert_array_equal(end["x"], start)
    assert not end["u"].any() and not end["p"].any()


def test_free_fall_of_a_drop():
    """A drop in uniform gravity falls as one body, without pressure."""
    s = still(Disc(radius=1.0), None, (0.0, -G), time_step=0.01, preset="violent", kappa=0.0, shift=0.0)
    start = s.gather("x")["x"]
    for _ in range(50):
        s.advance()
    end = s.gather("x", "u", "p")
    np.testing.assert_allclose(end["u"], np.broadcast_to([0.0, -G * s.time], end["u"].shape), atol=1e-9)
    np.testing.assert_allclose(end["x"] - start, np.broadcast_to([0.0, -0.5 * G * s.time**2], start.shape), atol=1e-9)
    assert np.abs(end["p"]).max() < 1e-6


@pytest.mark.parametrize("preset", ["violent", "gentle"])
def test_water_under_a_force_with_a_divergence_rests(preset):
    """Its surface is a parabola. What rows and gradients do not know of the pressure would lift it, by 5 % in a second.
    """
    rate = 2.0
    bowl = f"{rate**2 / (2 * G)} * ((x-0.6)**2 - 0.12)"
    case = water((1.2, 0.4), (1.2, 0.8), dict(spacing=0.1, preset=preset, jitter=0.3), elevation=bowl, density=DENSITY,
                 gravity=(f"{rate ** 2} * (x-0.6)", -G))
    simulation = simulated(case)
    simulation.solve_start()
    for _ in range(20):
        simulation.advance()
    assert np.abs(simulation.particles.u).max() < 1e-4 * np.sqrt(G * 0.4)


# -- every method -----------------------------------------------------------------------------------

# Methods with a warning say what moves.
STILL = [name for name, method in METHODS.items() if method.step == "projection"
         and (not method.warning or name == "ISPH_R_printed")]


def fastest(method, steps):
    """Return the speed of the fastest particle after some steps of a hydrostatic tank, over sqrt(g d)."""
    s = simulated(scene("hydrostatic", spacing=0.1, method=method, jitter=0.4, seed=1, end_time=1e3), steps)
    return np.linalg.norm(s.particles.u, axis=1).max() / np.sqrt(9.81)


@pytest.mark.parametrize("method", STILL)
def test_a_jittered_tank_rests(method):
    assert fastest(method, 200) < 1e-8


def test_weakly_compressible_water_stays_nearly_at_rest():
    """Sums over pairs do not balance on disordered particles: they find new places first."""
    assert fastest("SPH", 400) < 0.03


def test_rows_of_constants_alone_need_the_balance(monkeypatch):
    """Without it, a Laplacian that is not exact for linear pressure stirs the water."""
    from parisph.methods.operators import Sph
    monkeypatch.setattr(Sph, "linear", True)
    assert fastest("ISPH", 100) > 1e-3
