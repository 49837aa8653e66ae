"""Particles of scenes of several bodies: slices of ranks, roles, weights, volumes, waves at the start."""

import numpy as np
import pytest

from parisph import Box, Case, Disc, Flap, Fluid, Numerics, Obstacle, Piston, Plate, Polygon, Profile, StillWater, Tank
from parisph.base.fields import CONTACT, DRY, FLUID, INNER, SURFACE, WALL, WET
from parisph.case.waves import Airy, SolitaryWave
from parisph.geometry import build, scene_checks
from parisph.geometry.mesh import CONCAVE, CONVEX
from parisph.kernels.packing import volumes

S = 0.05
TANK = Tank(3.0, 1.0)
SILL = Obstacle(Polygon([(1.0, 0.0), (1.2, 0.2), (1.8, 0.2), (2.0, 0.0)]), name="sill")
BASIN = Profile([(0.0, 1.0), (0.5, 0.0), (2.0, 0.1), (3.0, 1.0)], name="basin")
SLOPE = Profile([(-1.0, 1.0), (-1.0, 0.0), (2.0, 0.0), (4.0, 1.0)], name="slope")


def scene(fluid, walls, spacing=S, **numerics):
    return Case(title="scene", fluid=fluid, walls=walls, gravity=(0.0, -9.81), end_time=1.0,
                numerics=Numerics(spacing=spacing, **numerics))


def water(level=0.5, **more):
    return Fluid(StillWater(level), 1000.0, **more)


SCENES = {
    "sill": (scene(water(), (TANK, SILL)), 3.0 * 0.5 - 0.5 * 0.2 * (1.0 + 0.6)),
    "box": (scene(water(), (TANK, Obstacle(Box(0.5, 0.23, at=(1.0, 0.0))))), 3.0 * 0.5 - 0.5 * 0.23),
    "slope": (scene(water(), SLOPE), 3.0 * 0.5 + 0.5 * 0.5 * 1.0),
    "basin": (scene(water(), BASIN), 0.5**2 / 4 + 1.5 * 0.45 + 0.4**2 / 1.8),
    "piston": (scene(water(), (SLOPE, Piston(at=0.0, wave=Airy(0.02, 1.5, 0.5)))), 2.0 * 0.5 + 0.5 * 0.5),
    "wet bed": (scene((Fluid(Box(0.53, 0.6), 1000.0), water(0.2)), TANK), 0.53 * 0.6 + 2.47 * 0.2),
    "hole": (scene(Fluid(Box(1.0, 0.6), 1000.0, holes=(Box(0.3, 0.2, at=(0.4, 0.2)),)), TANK), 0.6 - 0.06),
    "disc and plate": (scene(water(), (TANK, Obstacle(Disc(0.2, at=(1.0, 0.25))), Plate([(2.0, 0.0), (2.0, 0.7)]))),
                       1.5 - np.pi * 0.04),
    "no walls": (scene((Fluid(Disc(0.3), 1000.0), Fluid(Disc(0.2, at=(1.0, 0.0)), 1000.0, velocity=(-1.0, 0.0))), None),
                 np.pi * (0.09 + 0.04)),
}


@pytest.mark.parametrize("name", SCENES)
def test_slices_are_the_same_on_any_number_of_ranks(name):
    case, _ = SCENES[name]
    whole, parts = build.build(case), [build.build(case, rank, 3) for rank in range(3)]
    for field, values in whole.items():
        together = np.concatenate([part[field] for part in parts])
        assert together.dtype == values.dtype and together.tobytes() == values.tobytes(), field
    sizes = [len(part["id"]) for part in parts]
    assert max(sizes) - min(sizes) <= 1
    n = build.counts(case)
    assert np.count_nonzero(whole["kind"] == FLUID) == n["fluid"] and len(whole["id"]) == n["all"]


@pytest.mark.parametrize("name", SCENES)
def test_volumes_are_those_of_the_shapes(name):
    case, area = SCENES[name]
    arrays, (lower, upper) = build.build(case), build.domain(case)
    fluid = arrays["x"][arrays["kind"] == FLUID]
    places = list(build.samples(case, lower - 1.0, upper + 1.0))
    assert sum(volume.sum() for _, volume in places) == pytest.approx(area, rel=2e-4)
    own = volumes(fluid, places, S)
    assert own.sum() == pytest.approx(area, rel=2e-4) and own.min() > 0.0
    assert np.median(own) == pytest.approx(S * S, rel=0.05)
    facts = scene_checks.facts(case)
    assert facts is None or facts.volume == pytest.approx(area, rel=2e-4)
    half = 0.5 * (lower + upper)
    left = sum(volume.sum() for _, volume in build.samples(case, lower - 1.0, (half[0], upper[1] + 1.0)))
    right = sum(volume.sum() for _, volume in build.samples(case, (half[0], lower[1] - 1.0), upper + 1.0))
    assert left + right == pytest.approx(area, rel=2e-4)


@pytest.mark.parametrize("name", [name for name in SCENES if name != "no walls"])
def test_nodes_follow_the_fluid_in_the_order_of_the_mesh(name):
    case, _ = SCENES[name]
    arrays, mesh = build.build(case), build.scene_mesh(case)
    wall = arrays["kind"] == WALL
    np.testing.assert_array_equal(arrays["id"], np.arange(len(wall)))
    assert arrays["x"][wall].tobytes() == mesh.x0.tobytes()
    assert arrays["normal"][wall].tobytes() == mesh.normal0.tobytes()
    ends = mesh.ends    # as the foot of a piston
    np.testing.assert_array_equal(arrays["corner"][wall] == 1, (mesh.edge == CONCAVE) | ends)
    np.testing.assert_array_equal(arrays["edge"][wall], mesh.edge)
    np.testing.assert_array_equal(arrays["body"][wall], mesh.body)
    np.testing.assert_allclose(arrays["weight"][wall] * S, mesh.area * mesh.share)
    np.testing.assert_allclose(arrays["area"][wall] * S, mesh.vector_area)
    np.testing.assert_allclose(arrays["weight"][~wall] * S**2, arrays["volume"][~wall])
    assert not arrays["area"][~wall].any()
    assert not np.any(arrays["role"][wall][mesh.edge == CONVEX] != DRY)


@pytest.mark.parametrize(("maker", "level", "normal"), [
    (Piston(at=0.0, wave=Airy(0.02, 1.5, 0.5)), 0.0, (1.0, 1.0)),
    (Flap(hinge=(0.0, 0.0), wave=Airy(0.02, 1.5, 0.5)), 0.0, (1.0, 1.0)),
    (Piston(at=0.0, bottom=0.2, wave=Airy(0.02, 1.5, 0.5)), 0.2, (1.0, 0.0)),
])
def test_a_wavemaker_that_stands_on_the_bed_has_a_corner_there(maker, level, normal):
    mesh = build.scene_mesh(scene(water(), (SLOPE, maker)))
    face, high = mesh.body == 1, mesh.x0[:, 1]
    foot = face & (high < level + 1e-9)
    np.testing.assert_allclose(mesh.normal0[foot], [np.array(normal) / np.linalg.norm(normal)], atol=1e-12)
    np.testing.assert_allclose(mesh.normal0[face & ~foot], [(1.0, 0.0)] * (face.sum() - 1), atol=1e-12)


def test_scenes_without_walls_have_fluid_alone():
    case, _ = SCENES["no walls"]
    arrays = build.build(case)
    assert build.scene_mesh(case) is None and np.all(arrays["body"] == -1)
    right = arrays["x"][:, 0] > 0.5
    assert np.all(arrays["u"][right] == (-1.0, 0.0)) and not arrays["u"][~right].any()


def role_at(arrays, *at):
    return arrays["role"][np.argmin(np.linalg.norm(arrays["x"] - np.array(at), axis=1))]


def test_roles():
    arrays = build.build(SCENES["sill"][0])
    fluid, y = arrays["kind"] == FLUID, arrays["x"][:, 1]
    np.testing.assert_array_equal(arrays["role"][fluid] == SURFACE, y[fluid] > 0.5 - 1e-9)
    assert [role_at(arrays, 0.0, y) for y in (0.45, 0.5, 0.55)] == [WET, CONTACT, DRY]
    assert role_at(arrays, 1.5, 0.2) == WET and role_at(arrays, 1.2, 0.2) == DRY, "a convex edge carries no row"
    arrays = build.build(SCENES["piston"][0])
    assert role_at(arrays, -0.5, 0.0) == DRY and role_at(arrays, 0.5, 0.0) == WET, "the bed behind the piston is dry"
    assert role_at(arrays, 0.0, 0.5) == CONTACT and role_at(arrays, 0.0, 0.25) == WET


def test_a_box_beside_still_water_is_one_fluid():
    case, _ = SCENES["wet bed"]
    arrays = build.build(case)
    x, role = arrays["x"][arrays["kind"] == FLUID], arrays["role"][arrays["kind"] == FLUID]
    apart = np.linalg.norm(x[:, None] - x[None], axis=2) + 9.0 * np.eye(len(x))
    assert apart.min() > 0.5 * S
    gate = np.abs(x[:, 0] - 0.53) < 1e-9
    assert np.all(role[gate & (x[:, 1] > 0.25)] == SURFACE) and np.all(role[gate & (x[:, 1] < 0.15)] == INNER)
    assert x[gate][:, 1].max() == pytest.approx(0.6), "its surface is where the user has it"


def test_surface_hangs_from_the_level_whatever_the_spacing():
    for spacing in (0.043, 0.05, 0.061):
        case = scene(water(0.47), (TANK, SILL), spacing)
        arrays = build.build(case)
        y = arrays["x"][arrays["role"] == SURFACE, 1]
        np.testing.assert_allclose(y, 0.47, rtol=1e-12)


def test_a_wave_on_still_water_over_a_slope():
    wave = SolitaryWave(height=0.1, depth=0.5, at=0.3)
    case = scene(water(wave=wave), SLOPE)
    arrays = build.build(case)
    fluid = arrays["kind"] == FLUID
    x, eta = arrays["x"][fluid], wave.elevation(arrays["x"][fluid, 0], 0.0)
    rows = (0.5 + eta - x[:, 1]) / S
    np.testing.assert_allclose(rows, np.round(rows), atol=1e-9)
    np.testing.assert_array_equal(arrays["role"][fluid] == SURFACE, np.round(rows) == 0)
    flat = (x[:, 0] > -0.9) & (x[:, 0] < 1.9)
    assert 0.5 * S - 1e-6 < x[flat, 1].min() < 0.6 * S and x[flat, 1].max() == pytest.approx(0.6, abs=1e-3)
    assert role_at(arrays, -1.0, 0.5) == WET, "the surface there is higher"
    u = np.stack(wave.velocity(x[:, 0], x[:, 1], 0.0), axis=1)
    np.testing.assert_allclose(arrays["u"][fluid], u)
    lower, upper = build.domain(case)
    total = sum(volume.sum() for _, volume in build.samples(case, lower - 1.0, upper + 1.0))
    shore = np.linspace(-1.0, 3.0, 4001)
    assert total == pytest.approx(1.75 + np.trapz(wave.elevation(shore, 0.0), shore), rel=1e-3)
    assert arrays["volume"][fluid].sum() == pytest.approx(total, rel=0.01)
    own = volumes(x, build.samples(case, lower - 1.0, upper + 1.0), S)
    assert own.sum() == pytest.approx(total, rel=1e-6) and own.min() > 0.1 * S * S


def test_jitter_is_for_after_the_packing():
    case = scene(water(), (TANK, SILL), jitter=0.4, seed=3)
    assert build.build(case)["x"].tobytes() == build.build(SCENES["sill"][0])["x"].tobytes()
    number = np.arange(200)
    move = build.jitter(case, number, number % 2 == 0)
    assert not move[::2].any() and np.abs(move).max() <= 0.2 * S and np.ptp(move) > 0.3 * S
    np.testing.assert_array_equal(build.jitter(case, number[50:], number[50:] % 2 == 0), move[50:])


def test_domain_holds_walls_wherever_they_move():
    case = scene(water(), (Profile([(0.0, 0.0), (2.0, 0.0), (4.0, 1.0)]),
                           Piston(at=0.0, wave=SolitaryWave(height=0.1, depth=0.5), top=1.2)))
    case = case.changed(end_time=20.0)
    lower, upper = build.domain(case)
    assert lower == pytest.approx([0.0, 0.0], abs=1e-9) and upper == pytest.approx([4.0, 1.2])
    motions = build.scene_motions(case)
    assert len(motions) == 2 and [body.motion for body in build.scene_mesh(case).bodies] == [0, 1]
    assert motions[1].law(20.0)[0] > 0.2
