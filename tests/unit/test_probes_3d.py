"""Probes in 3D on particles whose answers are known exactly."""

import numpy as np
import pytest
from mpi4py import MPI

from parisph import (
    Box,
    Case,
    CaseError,
    ColumnHeight,
    Energy,
    Fluid,
    Flux,
    Force,
    Numerics,
    Obstacle,
    PressureTap,
    Profile,
    RunUp,
    StillWater,
    SurfaceGauge,
    Tank,
    Truth,
    VelocityProfile,
    Volume,
    WaterFront,
)
from parisph.base.fields import DRY, FLUID, INNER, SURFACE, WALL
from parisph.case.stored import from_json, to_json
from parisph.geometry import scene_checks
from parisph.geometry.build import scene_mesh
from parisph.geometry.upper_faces import UpperFaces
from parisph.kernels.interior_volumes import spiral
from parisph.watch.passages import Passages
from parisph.watch.surface_fit import fitted_height
from tests.watched import DENSITY, G, Watch, add_fluid, at_walls, mirrored, only

S, D = 0.1, 0.5
TANK = Tank(1.0, 1.0, breadth=1.0)
BOX = Obstacle(Box(0.3, 0.3, breadth=0.5, at=(0.4, 0.2, 0.0)), name="box")
PIER = Obstacle(Box(0.3, 0.8, breadth=0.4, at=(0.4, 0.0, 0.0)), name="pier")    # at the front, out of the water
HUNG = Obstacle(Box(0.3, 0.2, breadth=0.4, at=(0.4, 0.3, 0.5)), name="hung")
SLOPE = Profile([(0.0, 1.0), (0.0, 0.0), (1.0, 0.0), (1.0 + np.sqrt(3.0), 1.0)], breadth=0.6, name="bed")


def scene(*probes, walls=TANK, fluid=None, spacing=S, **fields):
    water = Fluid(fluid or StillWater(D), DENSITY, **fields)
    return Case(title="Scene", fluid=water, walls=walls, gravity=(0.0, -G), numerics=Numerics(spacing=spacing),
                end_time=1.0, probes=probes)


def sampled(case, change=None):
    watch = Watch(case, MPI.COMM_SELF, change)
    found = watch.sample()
    watch.destroy()
    return found


def value(probe, change=None, **fields):
    return only(sampled(scene(probe, **fields), change))


def still(arrays):
    """Give all particles the pressure of water at rest; walls above it are dry."""
    arrays["p"][:] = DENSITY * G * np.maximum(D - arrays["x"][:, 2], 0.0)
    arrays["role"][(arrays["kind"] == WALL) & (arrays["x"][:, 2] > D + 1e-9)] = DRY


def stirred(spacing, most):
    """Move each particle of the fluid by up to `most` spacings along each axis, those of the surface along it."""
    def change(arrays):
        fluid = arrays["kind"] == FLUID
        step = most * spacing * np.random.default_rng(3).uniform(-1.0, 1.0, (np.count_nonzero(fluid), 3))
        step[arrays["role"][fluid] == SURFACE, 2] = 0.0
        arrays["x"][fluid] += step
    return change


# -- columns and the surface ---------------------------------------------------------------

@pytest.mark.parametrize("at", [(0.5, 0.5), (0.33, 0.41), (0.7, 0.301)])
def test_on_a_tilted_plane_the_gauge_is_exact_and_the_column_gives_its_highest_particle(at):
    truth = D + 0.2 * (at[0] - 0.5) + 0.1 * (at[1] - 0.5)
    found = sampled(scene(SurfaceGauge("g", at=at), ColumnHeight("c", at=at), fluid=Box(1.0, D),
                          elevation="0.2*(x-0.5)+0.1*(y-0.5)"))
    assert found["g"][0] == pytest.approx(truth, abs=1e-12)
    assert truth < found["c"][0] <= truth + np.hypot(0.2, 0.1) * 1.5 * S


@pytest.mark.parametrize("at", [(0.0, 0.0), (1.0, 0.37), (0.42, 1.0), (0.013, 0.98), (0.52, 0.48)])
def test_level_water_has_its_level_at_walls_and_in_corners_however_stirred(at):
    found = sampled(scene(SurfaceGauge("g", at=at), ColumnHeight("c", at=at)), stirred(S, 0.4))
    assert found["g"][0] == pytest.approx(D, abs=1e-12) and found["c"][0] == pytest.approx(D, abs=1e-12)


@pytest.mark.parametrize("at", [(0.0, 0.0), (0.31, 0.77), (1.0, 0.5)])
def test_the_gauge_is_of_fourth_order_on_a_wave_between_walls(at):
    errors = []
    for spacing in (0.1, 0.05):
        found = value(SurfaceGauge("g", at=at), fluid=Box(1.0, D), spacing=spacing,
                      elevation="0.05*cos(pi*x)*cos(pi*y)")
        errors.append(abs(found - D - 0.05 * np.cos(np.pi * at[0]) * np.cos(np.pi * at[1])))
    assert errors[0] < 4e-4 and errors[1] < max(errors[0] / 7.0, 1e-6)


@pytest.mark.parametrize("x, role", [
    ([(0.5, 0.5, 0.72)], SURFACE), ([(0.45, 0.55, 0.72), (0.55, 0.5, 0.73)], SURFACE),    # droplets
    ([(0.52, 0.5, 0.3), (0.6, 0.45, 0.32)], SURFACE),    # a cavity below
])
def test_spray_and_cavities_do_not_touch_the_surface(x, role):
    assert value(SurfaceGauge("g", at=(0.51, 0.52)), lambda arrays: add_fluid(arrays, x, role)) == pytest.approx(D)


def test_at_a_vertical_front_and_on_a_dry_floor():
    box = Obstacle(Box(0.2, 0.3, breadth=0.5, at=(0.7, 0.2, 0.0)), name="box")
    column = {"fluid": Box(0.5, 0.8), "walls": (TANK, box)}
    for at, truth in (((0.2, 0.5), 0.8), ((0.5, 0.5), 0.8), ((0.66, 0.1), 0.0), ((0.8, 0.5), 0.3), ((0.8, 0.1), 0.0)):
        found = sampled(scene(SurfaceGauge("g", at=at), ColumnHeight("c", at=at), **column))
        assert found["g"][0] == found["c"][0] == pytest.approx(truth, abs=1e-12), at


def test_a_fit_is_exact_for_a_parabola_and_needs_a_smooth_surface_on_all_sides():
    random = np.random.default_rng(1)
    x = np.column_stack([random.uniform(-3.0, 3.0, (80, 2)), np.zeros(80)])

    def parabola(a, b):
        return 1.0 + 0.1 * a - 0.2 * b + 0.05 * a**2 - 0.03 * a * b + 0.02 * b**2

    x[:, 2] = parabola(x[:, 0], x[:, 1])
    here = np.array([0.1, -0.2])

    def fitted(points):
        return fitted_height(here, points, 9.0, 1.5, 1.0)

    assert fitted(x) == pytest.approx(parabola(*here), abs=1e-12)
    deep = x[np.linalg.norm(x[:, :2] - here, axis=1) < 2.0][:2] - [0.1, 0.1, 0.8]    # of a second layer
    assert fitted(np.concatenate([x, deep])) == pytest.approx(parabola(*here), abs=1e-12)
    assert fitted(x[x[:, 0] > 0.15]) == 9.0 and fitted(x[:2]) == 9.0
    assert fitted(x + np.column_stack([np.zeros((80, 2)), random.uniform(-0.6, 0.6, 80)])) == 9.0, "rough"
    assert fitted(x + 2.5 * x[:, :1] * [0.0, 0.0, 1.0]) == 9.0, "steep"
    mirrored = x[x[:, 0] > 0.0] * [1.0, 1.0, 0.0]
    assert fitted_height(np.array([0.0, -0.2]), mirrored, 9.0, 1.5, 1.0, [(0, 0.0)]) == pytest.approx(0.0, abs=1e-12)


def test_floors_are_found_under_points_edges_and_corners():
    mesh = scene_mesh(scene(walls=(TANK, BOX, HUNG)))
    faces = UpperFaces(mesh.corners())
    for at, heights in (((0.1, 0.1), [0.0]), ((0.5, 0.5), [0.3, 0.7]), ((0.5, 0.25), [0.3]), ((0.4, 0.2), [0.0, 0.3]),
                        ((0.0, 0.0), [0.0]), ((1.0, 0.55), [0.0]), ((1.5, 0.5), [0.0]), ((-9.0, 80.0), [0.0])):
        np.testing.assert_allclose(faces.heights(np.array(at)), heights, atol=1e-12, err_msg=str(at))
    slope = UpperFaces(scene_mesh(scene(walls=SLOPE)).corners())
    at = np.column_stack([np.linspace(0.0, 2.7, 200), np.linspace(0.0, 0.6, 200)])
    np.testing.assert_allclose(slope.highest(at), np.maximum(at[:, 0] - 1.0, 0.0) / np.sqrt(3.0), atol=1e-12)


# -- pressure ------------------------------------------------------------------------------

@pytest.mark.parametrize("walls, at", [
    (TANK, (0.0, 0.42, 0.23)), (TANK, (0.31, 1.0, 0.2)), (TANK, (0.31, 0.0, 0.02)), (TANK, (0.55, 0.34, 0.0)),
    ((TANK, BOX), (0.7, 0.33, 0.141)), ((TANK, BOX), (0.55, 0.7, 0.1)), ((TANK, BOX), (0.52, 0.4, 0.3)),
    ((TANK, BOX), (0.7, 0.21, 0.02)), (SLOPE, (1.0 + 0.3 * np.sqrt(3.0), 0.31, 0.3)),
])
def test_a_tap_on_any_wall_is_exact_for_a_linear_pressure(walls, at):
    def linear(arrays):
        arrays["p"][:] = 10.0 + arrays["x"] @ [3.0, -2.0, 5.0]

    case = scene(PressureTap("tap", at=at), walls=walls)
    assert scene_checks.faults(case) == []
    assert only(sampled(case, linear)) == pytest.approx(10.0 + np.dot(at, [3.0, -2.0, 5.0]), rel=1e-12)


def test_the_force_of_a_linear_pressure_on_a_body_in_the_water_is_its_gradient_times_the_volume():
    """No node of an edge has a pressure; with a gradient in any direction, all are extrapolated exactly."""
    slope = np.array([30.0, -20.0, 50.0])

    def linear(arrays):
        arrays["p"][:] = 100.0 + arrays["x"] @ slope

    middle = (0.55, 0.5, 0.6)
    found = sampled(scene(Force("f", on="hung", about=middle), walls=(TANK, HUNG), fluid=StillWater(0.9)), linear)["f"]
    np.testing.assert_allclose(found, [*(-0.3 * 0.2 * 0.4 * slope), 0.0, 0.0, 0.0], atol=1e-12)


@pytest.mark.parametrize("body, force, moment", [
    (BOX, (0.0, 0.0, -G * 0.2 * 0.3 * 0.5), (-0.45 * 0.2 * 0.15, 0.55 * 0.2 * 0.15, 0.0)),
    # fy is on the back of the pier alone, with the centre of pressure at d/3
    (PIER, (0.0, -G * 0.3 * D**2 / 2, 0.0), (0.3 * D**3 / 6, 0.0, -0.55 * 0.3 * D**2 / 2)),
])
def test_the_force_and_the_moment_of_still_water_on_a_box(body, force, moment):
    probes = Force("f", on=body.name), Force("d", on=body.name, still=D), Force("t", about=(0.5, 0.5, 0.0)), Force("w")
    found = sampled(scene(*probes, walls=(TANK, body)), still)
    np.testing.assert_allclose(found["f"], [*(DENSITY * np.array(force)), *(DENSITY * G * np.array(moment))], atol=1e-9)
    np.testing.assert_allclose(found["d"][6:], 0.0, atol=1e-9)
    np.testing.assert_allclose(np.add(found["f"], found["w"])[:2], 0.0, atol=1e-9)
    wet = min(body.shape.height, D) * 0.3 * body.shape.breadth
    assert found["f"][2] + found["w"][2] == pytest.approx(-DENSITY * G * (D - wet), rel=1e-12)


def test_the_force_on_sides_of_a_tank_and_on_a_slope():
    sides = [Force(side, side=side, about=(0.5, 0.5)) for side in ("left", "front", "bed")]
    found = sampled(scene(*sides), still)
    push = DENSITY * G * D**2 / 2
    np.testing.assert_allclose(found["left"][:3], [-push, 0.0, 0.0], atol=1e-9)
    np.testing.assert_allclose(found["front"][:3], [0.0, -push, 0.0], atol=1e-9)
    np.testing.assert_allclose(found["bed"][:3], [0.0, 0.0, -DENSITY * G * D], atol=1e-9)
    assert found["left"][4] == pytest.approx(-push * (D / 3 - 0.5), rel=1e-12), "about (0.5, 0, 0.5)"
    slope, area = sampled(scene(Force("f", on="bed", about=(0.0, 0.3, 0.0)), walls=SLOPE), still)["f"], D**2 / 2
    weight = DENSITY * G * 0.6
    tip = area * np.sqrt(3.0) * (1.0 + D * np.sqrt(3.0) / 3)    # moment of the water above the slope
    np.testing.assert_allclose(slope, [0.0, 0.0, -weight * (D + area * np.sqrt(3.0)), 0.0, weight * (D / 2 + tip), 0.0],
                               atol=1e-9)


# -- front, run-up, flux, volume ------------------------------------------------------------

@pytest.mark.parametrize("more, front", [
    ([], 0.45), ([(0.9, 0.15, 0.1)], 0.45),    # a droplet ahead, in the same strip
    ([(0.5, 0.15, 0.1), (0.6, 0.15, 0.1)], 0.6),    # a tongue
    ([(0.5, 0.15, 0.4), (0.6, 0.15, 0.4)], 0.45),    # a jet
    ([(0.9, 0.85, 0.1), (0.95, 0.85, 0.1)], 0.45),    # water in another strip without any connection
])
def test_the_front_is_that_of_the_main_body_of_all_strips(more, front):
    case = scene(WaterFront("f"), WaterFront("front", y=0.15), WaterFront("back", y=0.85),
                 fluid=Box(0.45, D, breadth=0.6))
    x = np.reshape(np.array(more, float), (-1, 3))
    found = sampled(case, lambda arrays: add_fluid(arrays, x, SURFACE))
    assert found["f"] == pytest.approx((front,)) and found["front"] == pytest.approx((front,))
    assert np.isnan(found["back"][0]) == (not len(x) or x[0, 1] < 0.5)


def test_a_run_up_at_a_side_is_the_gauge_there_and_on_a_slope_the_waterline():
    found = sampled(scene(RunUp("up", side="right", y=0.3), RunUp("line", points=[(1.0, 0.0), (1.0, 1.0)], y=0.3),
                          SurfaceGauge("g", at=(1.0, 0.3)), fluid=Box(1.0, D), elevation="0.05*cos(pi*x)*cos(pi*y)"))
    assert found["up"] == (found["g"][0], 1.0)
    assert found["line"] == pytest.approx(found["up"], abs=0.01)
    case = scene(RunUp("up", on="bed", side="right", y=0.2), walls=SLOPE)
    assert list(Watch(case).samplers[0].columns) == ["z", "x"]
    assert sampled(case)["up"] == pytest.approx((D, 1.0 + D * np.sqrt(3.0)), abs=1e-9)


# Rates of a velocity (.3, -.2, .1): particles stand for cells, of which walls 1 m apart have 9 between them, and the
# depth 4 and a half.
GATES = {
    "whole": (Flux("f", start=(0.51, 0.0), end=(0.51, 1.0)), 0.3 * 0.9 * 0.45),
    "part": (Flux("f", start=(0.51, 0.0), end=(0.51, 1.0), across=(0.25, 0.65)), 0.3 * 0.4 * 0.45),
    "back": (Flux("f", start=(0.51, 1.0), end=(0.51, 0.0)), -0.3 * 0.9 * 0.45),
    "corners": (Flux("f", start=(0.51, 0.25, 0.0), end=(0.51, 0.65, 0.25)), 0.3 * 0.4 * 0.2),
    "across": (Flux("f", start=(0.25, 0.51, 0.0), end=(0.65, 0.51, 1.0)), 0.2 * 0.4 * 0.45),    # -y is to its right
}


@pytest.mark.parametrize("name", list(GATES))
def test_uniform_flow_has_its_rate_through_a_rectangle(name):
    probe, rate = GATES[name]

    def whole(arrays):
        arrays["volume"][:] = S**3
        arrays["volume"][arrays["role"] == SURFACE] = 0.5 * S**3
        arrays["u"][:] = [0.3, -0.2, 0.1]

    assert sampled(scene(probe), whole)["f"][0] == pytest.approx(rate, rel=1e-12)


@pytest.mark.parametrize("name, counts", [
    ("whole", [1, -1, 1, 1, 0]), ("part", [1, -1, 0, 1, 0]), ("back", [-1, 1, -1, -1, 0]),
    ("corners", [1, -1, 0, 0, 0]), ("across", [0, 0, 0, 0, -1]),
])
def test_what_goes_through_a_rectangle_counts_and_what_passes_beside_it_does_not(name, counts):
    gate = GATES[name][0].gate(3)
    before = np.array([[0.4, 0.4, 0.1], [0.6, 0.4, 0.1], [0.4, 0.7, 0.1], [0.4, 0.4, 0.3], [0.4, 0.4, 0.1]])
    after = before + np.array([[0.2, 0.1, 0.0], [-0.2, 0.1, 0.0], [0.2, 0.1, 0.0], [0.2, 0.1, 0.1], [0.0, 0.2, 0.0]])
    found = [gate.passed(a[None], b[None], np.ones(1)) for a, b in zip(before, after)]
    assert found == counts
    passages = Passages(scene(GATES[name][0]), MPI.COMM_SELF, {gate.key: 2.5})
    assert passages.mine(gate) == 2.5 and passages.state() == {gate.key: 2.5}


def ends_of(k, x, toward):
    """Return how far the Voronoi cell of x[k] reaches in directions (3, m): (m,)."""
    way = np.delete(x, k, axis=0) - x[k]
    way = way[np.linalg.norm(way, axis=1) < 4.0 * S]
    return 1.0 / (2.0 * way @ toward / np.sum(way**2, axis=1)[:, None]).max(axis=0)


def test_the_volume_is_the_mean_voronoi_cell():
    from scipy.spatial import ConvexHull, Voronoi, cKDTree

    case = scene(Volume("v"), walls=Tank(1.0, 1.2, breadth=1.0), fluid=StillWater(1.0))
    walls = [(0, 0.0), (0, 1.0), (1, 0.0), (1, 1.0), (2, 0.0)]
    plain = at_walls(Watch(case, MPI.COMM_SELF), walls)
    mean, count = plain.sample()["v"]
    assert mean == pytest.approx(1.0, abs=5e-4) and count == 7 * (9 * 9 - 4) - 4 * 7    # without those at edges
    watch = at_walls(Watch(case, MPI.COMM_SELF, stirred(S, 0.3)), walls, plain)
    p = watch.particles
    fluid = np.flatnonzero(p.kind == FLUID)
    cells = Voronoi(mirrored(p.x[fluid], walls))
    away = cKDTree(p.x[p.role == SURFACE]).query(p.x[fluid])[0]
    deep = np.flatnonzero((p.role[fluid] == INNER) & (away > 2.1 * S))
    ends = [ends_of(k, cells.points, spiral()) for k in deep]
    deep = deep[np.max(ends, axis=1) < 1.3 * S]    # lists of 2.6 S know no more
    exact = [ConvexHull(cells.vertices[cells.regions[cells.point_region[k]]]).volume for k in deep]
    mean, count = watch.sample()["v"]
    assert count == len(deep)
    assert mean == pytest.approx(np.sum(exact) / np.sum(1.0 + p.beside[fluid[deep]]) / S**3, rel=5e-4)
    assert abs(mean - 1.0) > 1e-3, "disordered cells are others"
    watch.destroy()
    plain.destroy()


def test_a_profile_of_a_linear_velocity_is_exact():
    def sheared(arrays):
        arrays["u"][:] = arrays["x"] @ np.array([[1.0, 0.0, 2.0], [0.5, -1.0, 0.0], [0.0, 3.0, 1.0]])

    probe = VelocityProfile("v", start=(0.3, 0.3, 0.2), end=(0.6, 0.5, 0.3), points=3)
    found = np.reshape(sampled(scene(probe), sheared)["v"], (3, 4))[:, :3]
    np.testing.assert_allclose(found, probe.places @ [[1.0, 0.0, 2.0], [0.5, -1.0, 0.0], [0.0, 3.0, 1.0]], atol=1e-12)


# -- descriptions ---------------------------------------------------------------------------

@pytest.mark.parametrize("probe, words", [
    (SurfaceGauge("p", at=0.5), "at = 0.5: a gauge of a 3D scene stands at (x, y); give both"),
    (ColumnHeight("p", at=(0.5, 1.2)), "must lie within the walls, from y = 0 to 1"),
    (PressureTap("p", at=(0.0, 0.1)), "at = (0.0, 0.1) must have 3 components"),
    (RunUp("p", side="left"), "measured in one section; give its place across: y=..."),
    (RunUp("p", side="left", y=1.5), "y = 1.5 must lie within the breadth, from y = 0 to 1; move it"),
    (RunUp("p", points=[(0.0, 0.1, 0.0), (0.0, 0.1, 1.0)], y=0.5), "must have 2 components, of the section"),
    (WaterFront("p", y=-0.1), "y = -0.1 must lie within the breadth, from y = 0 to 1"),
    (Flux("p", start=(0.5, 0.0), end=(0.5, 0.5, 0.5)), "give both as (x, z), for a line of the section, or both as"),
    (Flux("p", start=(0.5, 0.0), end=(0.5, 0.0)), "must be two points"),
    (Flux("p", start=(0.5, 0.0), end=(0.5, 1.0), across=(0.5, 1.5)), "across = (0.5, 1.5) must lie within the breadth"),
    (Flux("p", start=(0.5, 0.0, 0.0), end=(0.5, 0.5, 0.5), across=(0.1, 0.5)), "the corners (x, y, z) give the"),
    (Flux("p", start=(0.5, 0.0, 0.2), end=(0.5, 0.5, 0.2)), "opposite corners of a vertical rectangle"),
    (Flux("p", start=(1.5, 0.0), end=(1.5, 0.5)), "the middle of the rectangle"),
    (Energy("p", current=True), "current volumes exist in 2D only; leave out current=True"),
    (Force("p", on="none"), "there is no body of this name; there is 'tank'"),
])
def test_what_3d_refuses(probe, words):
    with pytest.raises(CaseError) as error:
        scene(probe)
    assert "probe 'p': " in str(error.value) and words in str(error.value)


@pytest.mark.parametrize("probe, words", [
    (WaterFront("p", y=0.1), "y = 0.1: only a 3D scene has places across; leave it out"),
    (RunUp("p", side="left", y=0.1), "y = 0.1: only a 3D scene has places across; leave it out"),
    (Flux("p", start=(0.5, 0.0), end=(0.5, 1.0), across=(0.0, 0.1)), "only a 3D scene has places across; leave it out"),
    (Force("p", side="front"), "side = 'front': only a 3D scene has one; choose another side"),
])
def test_what_2d_refuses(probe, words):
    with pytest.raises(CaseError) as error:
        scene(probe, walls=Tank(1.0, 1.0))
    assert words in str(error.value)


@pytest.mark.parametrize("probe, words", [
    (SurfaceGauge("p", at=(0.55, 0.1)), "at = (0.55, 0.1): there is no room for fluid above or below it; move it"),
    (RunUp("p", on="high", side="left", y=0.8), "y = 0.8: high does not reach there; move it"),
    (RunUp("p", points=[(0.4, 0.0), (0.4, 1.0)], on="nobody", y=0.2), "there is no body of this name"),
])
def test_misplaced_probes(probe, words):
    high = Obstacle(Box(0.3, 1.2, breadth=0.4, at=(0.4, 0.0, -0.1)), name="high")
    try:
        found = scene_checks.faults(scene(probe, walls=(Tank(1.0, 1.0, breadth=1.0, lid=True), high)))
    except CaseError as error:
        found = [str(error)]
    assert len(found) == 1 and words in found[0]


def test_stored_cases_keep_the_places_across_and_those_of_2d_know_none():
    probes = [RunUp("r", side="left", y=0.3), WaterFront("f", y=0.2), GATES["part"][0].model_copy(update={"name": "p"}),
              SurfaceGauge("g", at=(0.5, 0.2), truth=Truth("series.csv", time="t", value="y", published={"x": 0.1}))]
    case = scene(*probes)
    assert from_json(to_json(case)).probes == case.probes
    for probe in (RunUp("r", side="left"), WaterFront("f"), Flux("p", start=(0.5, 0.0), end=(0.5, 1.0))):
        assert not {"y", "across"} & set(probe.model_dump())
    assert scene_checks.faults(case) == [], "a truth is no part of the walls"
