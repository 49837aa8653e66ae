"""Probes of loads and of run-up, and arrays of probes, on particles whose answers are known exactly."""

import numpy as np
import pytest

from parisph import ColumnHeight, Force, PressureTap, ProbeArray, RunUp, SurfaceGauge, VelocityPoint
from parisph.base.errors import CaseError
from parisph.base.fields import BALLISTIC, FLUID, SURFACE
from parisph.case.stored import from_json, to_json
from parisph.geometry import scene_checks
from parisph.watch.instruments import sample_all
from parisph.watch.probes.pressure_tap import disc_mean
from tests.scenes import at_start
from tests.watched import DENSITY, G, Watch, add_fluid, only, scene

S, DEPTH = 0.05, 0.5


def value(probe, change=None, **options):
    return only(Watch(scene([probe], **options), change=change).sample())


def values(probe, change=None, **options):
    found, = Watch(scene([probe], **options), change=change).sample().values()
    return found


def linear(arrays):
    """Give walls a pressure that is linear everywhere, also above the water."""
    arrays["p"][:] = 300.0 + 20.0 * arrays["x"][:, 0] - 50.0 * arrays["x"][:, 1]


def hydrostatic(arrays):
    arrays["p"][:] = DENSITY * G * np.maximum(DEPTH - arrays["x"][:, 1], 0.0)


# -- the mean over a disc -----------------------------------------------------------------

@pytest.mark.parametrize("at, diameter", [
    ((0.0, 0.2), 0.09), ((0.0, 0.213), 0.3), ((1.0, 0.3), 0.02), ((0.35, 0.0), 0.4),
])
def test_the_mean_over_a_disc_is_exact_for_linear_pressure(at, diameter):
    found = value(PressureTap("disc", at=at, diameter=diameter), linear, lid=True, depth=1.0)
    assert found == pytest.approx(300.0 + 20.0 * at[0] - 50.0 * at[1], rel=1e-13)


def test_the_mean_over_a_disc_of_a_parabola_converges_to_a_quarter_of_the_radius_squared():
    for n, error in ((8, 2e-2), (64, 3e-4)):
        z = np.linspace(-1.5, 1.5, 3 * n + 1)
        assert disc_mean(z, z**2, 1.0) == pytest.approx(0.25, rel=error)


def test_half_a_disc_above_the_water_has_the_first_moment_of_half_a_disc():
    """The mean of max(-z, 0) over a disc is 2 R/(3 pi), with a particle at the water's level."""
    z = np.arange(-3, 4) * 0.5
    assert disc_mean(z[::-1], np.maximum(-z, 0.0)[::-1], 1.0) == pytest.approx(2.0 / (3.0 * np.pi), rel=1e-14)
    assert np.isnan(disc_mean(np.array([2.0, 3.0]), np.ones(2), 1.0))


@pytest.mark.parametrize("at, diameter", [((0.0, 0.04), 0.1), ((0.98, 0.0), 0.1), ((0.0, 0.0), 0.01)])
def test_a_disc_lies_on_one_wall(at, diameter):
    with pytest.raises(CaseError, match=f"'disc': a disc of diameter = {diameter:g} .* does not lie on one wall"):
        scene_checks.check(scene([PressureTap("disc", at=at, diameter=diameter)]))


def test_a_tap_is_a_fit_or_a_disc():
    with pytest.raises(CaseError, match="radius = 0.1 and diameter = 0.1: give only one"):
        PressureTap("p", at=(0.0, 0.1), radius=0.1, diameter=0.1)


# -- force and moment ---------------------------------------------------------------------

@pytest.mark.parametrize("side, sign", [("left", -1.0), ("right", 1.0)])
def test_hydrostatic_force_on_a_wall(side, sign):
    fx, fy, moment = values(Force("load", side=side, about=(0.0, 0.0)), hydrostatic)
    assert fx == pytest.approx(sign * 0.5 * DENSITY * G * DEPTH**2, rel=1e-13) and fy == 0.0
    assert moment == pytest.approx(-sign * DENSITY * G * DEPTH**3 / 6.0, rel=1e-12)


@pytest.mark.parametrize("preset", ["gentle", "violent"])
def test_the_force_of_water_at_rest_as_it_is_solved(preset):
    """On disordered particles."""
    probes = [Force("wall", side="right"), Force("bed", side="bed"), PressureTap("disc", at=(0.0, 0.2), diameter=0.1)]
    found = at_start(scene(probes, jitter=0.4).changed(**{"numerics.preset": preset, "numerics.rtol": 1e-12}))
    assert found["wall"][0] == pytest.approx(0.5 * DENSITY * G * DEPTH**2, rel=1e-9)
    assert found["bed"][1] == pytest.approx(-DENSITY * G * DEPTH, rel=1e-9)
    assert found["disc"][0] == pytest.approx(DENSITY * G * 0.3, rel=1e-9)


def test_the_force_on_the_bed_is_the_weight_and_on_all_of_the_tank_nothing_else():
    weight = DENSITY * G * DEPTH
    fx, fy, moment = values(Force("load", side="bed", about=(0.25, -0.7)), hydrostatic)
    assert fx == 0.0 and fy == pytest.approx(-weight, rel=1e-13) and moment == pytest.approx(-0.25 * weight, rel=1e-12)
    fx, fy, moment = values(Force("load", about=(0.5, 0.3)), hydrostatic)
    assert fy == pytest.approx(-weight, rel=1e-13) and abs(fx) < 1e-9 * weight and abs(moment) < 1e-9 * weight


def test_a_uniform_pressure_has_no_force_on_a_closed_tank_and_a_gradient_has_archimedes():
    full = {"lid": True, "depth": 1.0}
    fx, fy, moment = values(Force("load"), lambda arrays: arrays["p"].__setitem__(slice(None), 7.0), **full)
    assert max(abs(fx), abs(fy), abs(moment)) < 1e-13
    fx, fy, _ = values(Force("load"), linear, **full)
    assert (fx, fy) == (pytest.approx(20.0, rel=1e-12), pytest.approx(-50.0, rel=1e-12))
    assert values(Force("load", side="lid"), linear, **full)[1] == pytest.approx(300.0 + 10.0 - 50.0, rel=1e-12)


@pytest.mark.parametrize("probe, message", [
    (Force("load", on="gate"), "'load': on = 'gate': there is no body of this name; there is 'tank'"),
    (Force("load", side="lid"), "'load': side = 'lid': the tank has none"),
    (RunUp("up", on="beach", side="left"), "'up': on = 'beach': there is no body"),
    (RunUp("up", points=[(0.0, 0.0), (0.0, 0.0)]), "'up': points: two neighbouring points are equal"),
    (RunUp("up", points=[(0.0, 0.0), (0.0, 1.0, 2.0)]), r"'up': point = \(0.0, 1.0, 2.0\) must have 2 components"),
    (VelocityPoint("u", at=(0.1, 0.2, 0.3)), r"'u': at = \(0.1, 0.2, 0.3\) must have 2 components"),
])
def test_what_a_scene_does_not_have(probe, message):
    with pytest.raises(CaseError, match=message):
        scene([probe])
    if getattr(probe, "side", None):
        with pytest.raises(CaseError, match="there is no (tank|body of this name)"):
            scene([probe], tank=None)


# -- run-up -------------------------------------------------------------------------------

@pytest.mark.parametrize("film, highest", [(None, DEPTH), (1.0, DEPTH), (0.021, DEPTH), (0.019, 0.875), (0.011, 0.875)])
def test_a_torn_film_is_one_where_its_particles_are_no_farther_apart_than_in_the_thinnest_that_counts(film, highest):
    """Three particles above the water, 2.5 spacings apart as in a film of 0.02 m; and one 5 spacings above them."""
    def torn(arrays):
        add_fluid(arrays, [(0.5 * S, y) for y in (0.625, 0.75, 0.875, 1.125)], BALLISTIC)

    probe = RunUp("up", points=[(0.0, 0.0), (0.0, 1.0)], film=film)
    assert values(probe, torn)[0] == pytest.approx(highest, abs=1e-9)


def test_at_a_vertical_side_there_is_no_film():
    with pytest.raises(CaseError, match="'up': film = 0.01 m has no effect at a vertical side"):
        Watch(scene([RunUp("up", side="left", film=0.01)]))


@pytest.mark.parametrize("side, x", [("left", 0.0), ("right", 1.0)])
def test_run_up_at_a_side_is_the_gauge_there(side, x):
    options = {"elevation": "0.05*cos(pi*x)", "spacing": 0.025}
    found = values(RunUp("up", side=side), **options)
    assert found == (value(SurfaceGauge("g", at=x), **options), x)
    assert found[0] == pytest.approx(0.5 + 0.05 * np.cos(np.pi * x), abs=1e-6)


def on_slope(angle, spacing):
    """Remove the fluid that is nearer than half a spacing to a slope through (0.4, 0), or below it."""
    def change(arrays):
        normal = np.array([-np.sin(angle), np.cos(angle)])
        gone = ((arrays["x"] - (0.4, 0.0)) @ normal < 0.5 * spacing) & (arrays["kind"] == FLUID)
        for name in arrays:
            arrays[name] = arrays[name][~gone]
    return change


@pytest.mark.parametrize("degrees", [20.0, 30.0, 45.0, 60.0, 85.0])
@pytest.mark.parametrize("tilt", [0.0, 0.1])
def test_run_up_on_a_slope_is_exact_for_a_plane_surface(degrees, tilt):
    """Also along a line that has more points than its ends."""
    angle, spacing = np.radians(degrees), 0.025
    end = np.array([0.4, 0.0]) + 1.2 * np.array([np.cos(angle), np.sin(angle)])
    line = RunUp("up", points=[(0.4, 0.0), tuple(0.3 * end + 0.7 * np.array([0.4, 0.0])), tuple(end)])
    y, x = values(line, on_slope(angle, spacing), spacing=spacing, width=2.0, tank=(2.0, 1.0), depth=0.3,
                  elevation=f"{tilt}*(x - 0.5)")
    exact = (0.3 - tilt * 0.5 + tilt * 0.4) / (1.0 - tilt / np.tan(angle))
    assert y == pytest.approx(exact, abs=1e-12)
    assert x == pytest.approx(0.4 + exact / np.tan(angle), abs=1e-12)


def test_run_up_leaves_out_drops_and_a_dry_line_has_its_first_point():
    def drop(arrays):
        on_slope(np.radians(45.0), S)(arrays)
        top = np.flatnonzero((arrays["kind"] == FLUID) & (arrays["role"] == SURFACE))[:1]
        arrays["x"][top] = (0.85, 0.5)

    slope = RunUp("up", points=[(0.4, 0.0), (1.4, 1.0)])
    options = {"width": 2.0, "tank": (2.0, 1.0), "depth": 0.3}
    assert values(slope, drop, **options) == pytest.approx((0.3, 0.7))
    assert values(RunUp("up", points=[(1.0, 0.6), (1.0, 1.0)]), **options) == (0.6, 1.0)


def test_a_run_up_needs_a_side_or_a_line():
    for options in ({}, {"side": "left", "points": [(0.0, 0.0), (0.0, 1.0)]}):
        with pytest.raises(CaseError, match="give either a side of the tank"):
            RunUp("up", **options)


# -- arrays, points -----------------------------------------------------------------------

ARRAY = ProbeArray("several", [
    SurfaceGauge("x1", at=0.2), SurfaceGauge("x2", at=0.8), ColumnHeight("c", at=0.5),
    VelocityPoint("u", at=(0.5, 0.25)), PressureTap("p", at=(0.0, 0.2), diameter=0.1), Force("load", side="right")])


def test_an_array_has_the_columns_of_its_probes_and_their_values():
    options = {"elevation": "0.05*cos(pi*x)", "velocity": ("0.3 + y", "-x")}
    watch = Watch(scene([ARRAY, *ARRAY.probes], **options), change=hydrostatic)
    found = watch.sample()
    assert list(watch.samplers[0].columns) == ["x1", "x2", "c", "u_u", "u_v", "u_p", "p", "load_fx", "load_fy",
                                               "load_moment"]
    assert found["several"] == sum((found[probe.name] for probe in ARRAY.probes), ())
    assert sample_all(watch.samplers[:1], watch.particles, watch.domain, 0.0) == {"several": found["several"]}
    assert found["u"][:2] == (pytest.approx(0.55, abs=1e-2), pytest.approx(-0.5, abs=1e-2))


def test_an_array_is_stored_and_its_places_are_checked():
    case = scene([ARRAY])
    assert from_json(to_json(case)) == case
    with pytest.raises(CaseError, match="'several.x9': at = 9 must lie within the walls"):
        scene([ProbeArray("several", [SurfaceGauge("x9", at=9.0)])])


@pytest.mark.parametrize("probes, message", [
    ([SurfaceGauge("a", at=0.1), SurfaceGauge("a", at=0.2)], "the name 'a' is given 2 times"),
    ([SurfaceGauge("a", at=0.1, peak=True)], "'a': a truth, peak=True or every=N is for a probe with a file"),
    ([ProbeArray("b", [SurfaceGauge("a", at=0.1)])], "'b' is an array itself"),
])
def test_what_an_array_cannot_hold(probes, message):
    with pytest.raises(CaseError, match=message):
        ProbeArray("several", probes)
