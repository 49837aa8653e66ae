"""What a run says of volume and energy: at the end, at their worst, and when that is worth a warning."""

import json
from dataclasses import replace
from math import pi

import numpy as np
import pytest

from parisph import Box, Fluid, Obstacle, Output, Polygon, StillWater, Tank, TankMode
from parisph.driver import describe
from parisph.driver.conservation import Conservation, Range
from parisph.driver.summary import Account
from parisph.io import info as words
from tests.scenes import restart_alone, run_alone, scene, simulated, water


def started(case):
    """Return a Simulation at its start, and its Conservation that has looked at it."""
    s = simulated(case)
    s.solve_start()
    kept = Conservation(s)
    kept.measure(s)
    return s, kept


def test_range_knows_start_end_extremes_and_what_was_missing():
    found = Range()
    for time, value in ((0.0, 2.0), (1.0, 1.0), (2.0, np.nan), (3.0, 5.0), (4.0, np.inf), (5.0, 3.0)):
        found.add(time, value)
    assert (found.start, found.now, found.missing, found.missing_since) == (2.0, 3.0, 2, 2.0)
    assert found.extremes() == {"low": -0.5, "low_time": 1.0, "high": 1.5, "high_time": 3.0}
    assert found.relative(found.now) == 0.5


def test_range_without_a_start_compares_nothing():
    found = Range()
    found.add(0.0, None)
    found.add(1.0, 2.0)
    assert found.start is None and found.extremes() is None and found.relative(2.0) is None


def test_volume_that_was_off_on_the_way_is_named(tmp_path):
    """In steps more than twice as long as usual, the drop on the lattice is 2.8 % off at .75 s, and .9 % at its end."""
    summary = run_alone(scene("free_drop", time_step=0.025), tmp_path / "run")
    assert abs(summary["volume_drift"]) < 0.01 < 0.02 < summary["volume_range"]["high"]
    assert summary["status"] == "completed with warnings" and len(summary["warnings"]) == 1
    assert ("volume" in summary["warnings"][0]
            and f"{summary['volume_range']['high_time']:.4g} s" in summary["warnings"][0])
    assert json.loads((tmp_path / "run" / "summary.json").read_text())["warnings"] == summary["warnings"]
    lines = words.table(summary)
    assert any(line.startswith("warning ") and "volume" in line for line in lines)
    most = 100.0 * summary["volume_range"]["high"]
    assert any(line.startswith("volume drift ") and f"highest +{most:.2f}%" in line for line in lines)
    assert "volume" in (tmp_path / "run" / "run.log").read_text()


def test_energy_that_comes_from_nothing_is_named():
    s, kept = started(scene("rotating_patch", spacing=0.1))
    s.advance()
    kept.step(s)
    assert not kept.passed().values()
    s.particles.u *= 1.01
    kept.step(s)
    s.particles.u /= 1.01
    kept.step(s)
    content = kept.content()
    assert content["energy_range"]["high"] == pytest.approx(0.02, rel=0.1) and content["energy_drift"] < 1e-3
    (line,) = kept.passed().values()
    assert "energy" in line and "%" in line and f"{s.time:.4g} s" in line


@pytest.mark.parametrize("preset", ["gentle", "violent"])
def test_the_remedy_names_the_preset_for_breaking_waves_where_it_is_not_in_use(preset):
    s, kept = started(scene("standing_wave", dict(preset=preset), spacing=0.1))
    s.advance()
    kept.measure(s)
    kept.volume.add(s.time, 1.1 * kept.volume.start)
    assert ('preset="violent"' in kept.passed()["volume high"]) == (preset == "gentle")


def test_energy_of_a_driven_flow_may_rise():
    s, kept = started(scene("free_drop", spacing=0.1, stiffness=1.0))
    s.particles.u *= 2.0
    kept.step(s)
    assert kept.content()["driven"] and not kept.passed().values()


@pytest.mark.parametrize("field", ["u", "x"])
def test_what_is_no_number_is_named(field):
    s, kept = started(scene("rotating_patch", spacing=0.1))
    getattr(s.particles, field)[3] = np.nan
    kept.step(s)
    (line,) = kept.passed().values()
    assert "energy was not a number 1 time, first at t = 0 s" in line
    assert kept.content()["energy_drift"] is None and kept.content()["energy_range"]["high"] == 0.0


@pytest.mark.parametrize("gravity", [(0.0, -9.81), (9.81, 0.0), (0.0, 9.81), (-6.0, 6.0)])
def test_change_of_energy_has_its_sign_in_every_direction_of_gravity(gravity):
    """Where water lies is 0 or more above the lowest corner; .1 m/s of 500 kg/m is a rise, in per cent of the start."""
    s, kept = started(water((1.0, 0.5), (1.0, 1.0, True), 0.1, gravity=gravity))
    start = kept.energy.start
    s.particles.u[s.particles.kind == 0] = (0.1, 0.0)
    kept.step(s)
    assert start > 0.0 and kept.energy.now - start == pytest.approx(2.5, rel=0.01)
    assert (kept.content()["energy_range"]["high"] == kept.content()["energy_drift"]
            == pytest.approx(2.5 / start, rel=0.01))


def test_volume_of_a_thin_layer_is_said_to_be_unknown():
    s, kept = started(water((1.0, 0.15), (1.0, 1.0), 0.05))
    lines = words.table(kept.content())
    assert any(line.startswith("volume drift ") and "not measured: nothing was 2.1 spacings inside" in line
               for line in lines)


def test_a_body_that_loses_its_surface_on_the_way_is_named():
    s = simulated(scene("dam_break", spacing=0.05))
    s.solve_start()
    account = Account()
    account.start(s)
    report = s.advance()
    account.step(s, replace(report, isolated=2))
    assert not account.warnings()
    account.step(s, replace(report, isolated=20))
    resumed = Account(json.loads(json.dumps(account.state(s))))
    resumed.start(s)
    for known in (account, resumed):
        (line,) = known.warnings()
        assert "20 particles had no contact with a free surface at t = " in line


# -- energy in motion -------------------------------------------------------------------------------


def in_motion(case):
    s, kept = started(case)
    return kept.content()["energy_in_motion"]


def test_energy_in_motion_of_a_standing_wave():
    """rho g a^2 L/4 of a wave whose water is far more, at the start all kinetic; the same if it is raised instead."""
    due = 0.25 * 1000.0 * 9.81 * 0.025**2 * 2.0
    assert in_motion(scene("standing_wave", spacing=0.025))["start"] == pytest.approx(due, rel=0.02)
    raised = water((2.0, 1.0), (2.0, 1.5), 0.025, elevation="0.025*cos(pi*x)", title="raised")
    assert in_motion(raised)["start"] == pytest.approx(due, rel=0.03)


def test_energy_in_motion_of_water_at_rest_and_of_a_column():
    assert in_motion(scene("hydrostatic", spacing=0.1))["start"] == pytest.approx(0.0, abs=1e-9)
    full = water((1.0, 1.0), (1.0, 1.0, True), 0.1)
    assert in_motion(full)["start"] == pytest.approx(0.0, abs=1e-8)
    column = in_motion(scene("dam_break", spacing=0.05))["start"]    # H^2 L/2 - (L H/D)^2 D/2
    assert column == pytest.approx(9810.0 * (0.25 - 0.0625), rel=0.01)


@pytest.mark.parametrize("preset", ["gentle", "violent"])
def test_energy_in_motion_of_still_water_with_a_wave(preset):
    """In a tank alone it is that of the surface, whatever the preset; not where a body stands in the water."""
    due = 0.25 * 1000.0 * 9.81 * 0.025**2 * 2.0
    raised = water(StillWater(level=1.0), (2.0, 1.5), dict(spacing=0.1, preset=preset), elevation="0.025*cos(pi*x)",
                   title="raised")
    assert in_motion(raised)["start"] == pytest.approx(due, rel=0.05)
    pier = Obstacle(Box(width=0.3, height=1.4, at=(0.8, 0.0)), name="pier")
    assert in_motion(raised.changed(walls=(raised.walls, pier))) is None


def test_energy_in_motion_of_low_waves_knows_no_moves_of_particles():
    """By the places of particles it would have grown by half after two periods; measured -.04."""
    s, kept = started(scene("standing_wave", spacing=0.1, preset="gentle"))
    while s.time < 2.26:
        s.advance()
        kept.step(s)
    kept.measure(s)
    assert -0.1 < kept.content()["energy_in_motion"]["drift"] < 0.0


def test_energy_in_motion_of_a_low_wave_in_3d_knows_no_moves_of_particles():
    """rho g a^2 L B/8 of a mode of the tank; by the places of particles it would be five times as much after 1.5 s."""
    def mode(spacing):
        wave = TankMode(amplitude=0.01, modes=(1, 1), length=1.0, breadth=0.7, depth=0.5, phase=pi / 2)
        return water(Fluid(Box(1.0, 0.5, breadth=0.7), density=1000.0, wave=wave), Tank(1.0, 0.8, breadth=0.7),
                     dict(spacing=spacing, preset="gentle"), title="mode")

    due = 1000.0 * 9.81 * 1e-4 * 0.7 / 8.0    # less (k s)^2/2, as water at a wall has the level of the last particle
    assert in_motion(mode(0.05))["start"] == pytest.approx(due, rel=0.08)
    s, kept = started(mode(0.1))
    assert kept.motion.start == pytest.approx(due, rel=0.2)
    while s.time < 1.5:
        s.advance()
        kept.step(s)
    kept.measure(s)
    assert -0.2 < kept.content()["energy_in_motion"]["drift"] < 0.2 and kept.energy.now - kept.energy.start > 2.0 * due


def test_energy_in_motion_shows_no_rounding():
    s, kept = started(scene("hydrostatic", spacing=0.1))
    whole = kept.energy.start
    for motion, shown in ((-2e-16 * whole, 0.0), (9e-13 * whole, 0.0), (1e-11 * whole, 1e-11 * whole), (None, None)):
        kept.motion = Range(start=motion, now=motion, low=0.0, low_time=0.0, high=motion, high_time=0.0)
        found = kept.content()["energy_in_motion"]
        assert [found[name] for name in ("start", "end", "high")] == 3 * [shown]
        assert (found["drift"] is None) == (not shown)


def test_energy_in_motion_where_nothing_pulls_is_the_kinetic_one():
    found = in_motion(scene("rotating_patch", spacing=0.1))
    assert found["start"] == pytest.approx(1000.0 / 12.0, rel=0.03) and found["drift"] == 0.0


def test_energy_in_motion_means_nothing_without_a_level():
    assert in_motion(scene("free_drop", spacing=0.1)) is None
    tilted = scene("hydrostatic", spacing=0.1).changed(gravity=(1.0, -9.81))
    assert in_motion(tilted) is None


# -- over a restart, and of a run that has no surface ---------------------------------------------------


def column(end_time, rtol=None):
    return water((0.5, 0.5), (1.0, 1.0, True), dict(spacing=0.05, time_step=0.005, rtol=rtol),
                 output=Output(checkpoint_every=0.1), end_time=end_time)


def test_extremes_go_on_over_a_restart(tmp_path):
    """Solved to round-off, as a restarted solver meets a loose tolerance at another iterate."""
    whole = run_alone(column(0.3, 1e-13), tmp_path / "whole")
    first = run_alone(column(0.2, 1e-13), tmp_path / "parts")
    both = restart_alone(tmp_path / "parts", until=0.3)
    for name in ("volume_range", "energy_range", "energy_in_motion"):
        for key, value in whole[name].items():
            assert (both[name][key] == (value if isinstance(value, str)
                                        else pytest.approx(value, rel=1e-6, abs=1e-9))), (name, key)
    assert both["energy_range"]["high"] >= first["energy_range"]["high"]


def test_account_of_an_older_run_is_taken_up():
    """It knows volume and energy at the start alone."""
    s = simulated(column(0.3))
    s.solve_start()
    account = Account({"account": {"wall": 1.0, "cpu": 1.0, "phases": {}, "cpu_phases": {}, "fallbacks": 0,
                                           "energy": 2000.0, "volume": 1.0}})
    account.start(s)
    content = account.diagnostics.conservation.content()
    assert content["energy_drift"] == pytest.approx(account.diagnostics.conservation.energy.now / 2000.0 - 1.0)
    assert set(account.state(s)["account"]["conservation"]) == {"energy", "motion", "kinetic", "volume"}


def without_surface():
    """A polygon that fills a tank with a lid: no particle of it lies on a surface."""
    corners = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))
    return water(Polygon(corners), (1.0, 1.0, True), dict(spacing=0.1, preset="gentle"), end_time=0.1)


def test_fluid_without_a_surface_is_announced(tmp_path):
    case = without_surface()
    assert "warning" in describe(case) and "no fluid particle is on a free surface" in describe(case)
    assert "warning" not in describe(column(0.3))
    for air, said in ((0.15, "0.15 m thick in the mean, 1.5 spacings; with less than 2"), (0.2, "")):
        little = water(Box(1.0, 1.0 - air), (1.0, 1.0, True), dict(spacing=0.1), end_time=0.1)
        assert said in describe(little) and ("warning" in describe(little)) == bool(said)
    summary = run_alone(case, tmp_path / "run")
    assert summary["status"] == "completed with warnings"
    assert any("121 particles had no contact with a free surface at the start (of 81 fluid particles and the "
               "walls)" in line for line in summary["warnings"])


def test_fluid_without_a_surface_rests_all_the_same():
    """p = 0 at one particle of the highest ones, and the weight of the water below it."""
    s = simulated(without_surface())
    assert s.solve_start() == 121
    for _ in range(20):
        s.advance()
    p = s.particles
    np.testing.assert_allclose(p.p - p.p.max(), 9810.0 * -p.x[:, 1], atol=1e-3 * 9810.0)
    top = p.p[np.abs(p.x[:, 1] - 0.9) < 1e-3]
    assert np.abs(top).max() < 1e-3 * 9810.0
    assert np.abs(p.u).max() < 1e-6
