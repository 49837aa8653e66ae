"""Scenes with Surfaces: the same walls and fluid as with bodies of the same form, and what is refused or warned of."""

import numpy as np
import pytest
from mpi4py import MPI

from parisph import (
    Box,
    Case,
    Fluid,
    Force,
    Friction,
    Numerics,
    Obstacle,
    Piston,
    Plate,
    Profile,
    RunUp,
    StillWater,
    Surface,
    Sway,
    Tank,
)
from parisph.base.errors import CaseError
from parisph.base.fields import CONTACT, DRY, FLUID, SURFACE, WALL, WET
from parisph.driver.conservation import has_level
from parisph.geometry import build, scene_checks, scene_room
from parisph.geometry.room_filling import below
from parisph.watch.sampling import ProbeScene
from tests.triangles import LIBRARIES, box, sheet, sphere, write_stl
from tests.watched import DENSITY, G, Watch

for name in LIBRARIES:
    pytest.importorskip(name, reason=f"{name} is not installed: pip install 'parisph[surfaces]'")

S, LEVEL = 0.1, 0.6
TANK = Tank(width=2.0, height=1.0, breadth=1.0)


def scene(*walls, level=LEVEL, method="ISPH_R", **fields):
    return Case(title="Surfaces", fluid=Fluid(StillWater(level=level), 1000.0), walls=walls, gravity=(0.0, -9.81),
                numerics=Numerics(spacing=S, method=method), end_time=1.0, **fields)


def surface(folder, corners, **fields):
    return Surface(file=str(write_stl(folder / "a.stl", corners)), **fields)


def test_box_from_a_file_is_that_of_an_obstacle(tmp_path):
    block = surface(tmp_path, box((0.4, 0.3, 0.3), (0.8, 0.3, 0.0)), name="block")
    obstacle = Obstacle(Box(width=0.4, height=0.3, at=(0.8, 0.0)), name="block", across=(0.3, 0.6))
    one, other = scene(TANK, block), scene(TANK, obstacle)
    assert build.volume(one) == pytest.approx(build.volume(other), rel=1e-7)
    assert build.volume(one) == pytest.approx(1.2 - 0.036, rel=1e-7)
    assert build.counts(one)["fluid"] == pytest.approx(build.counts(other)["fluid"], rel=0.03)
    for mesh in (build.scene_mesh(one), build.scene_mesh(other)):
        own = [body.name for body in mesh.bodies].index("block")
        corners = mesh.corners()[mesh.element_body == own]
        vectors = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        assert np.linalg.norm(vectors, axis=1).sum() == pytest.approx(0.12 + 2 * 0.3 * 0.7, rel=1e-6)
        np.testing.assert_allclose(vectors.sum(axis=0), [0.0, 0.0, 0.12], atol=1e-7)
    # the parts of the cells of all nodes inside the fluid are those of the same walls
    volumes = [np.sum(mesh.cell * mesh.share) for mesh in (build.scene_mesh(one), build.scene_mesh(other))]
    assert volumes[0] == pytest.approx(volumes[1], rel=0.02)


def test_particles_keep_away_from_a_surface_and_none_is_inside(tmp_path):
    case = scene(TANK, surface(tmp_path, sphere(4, 0.3, (1.0, 0.5, 0.2)), slip="none"))
    arrays = build.build(case)
    x = arrays["x"][arrays["kind"] == FLUID]
    apart = np.linalg.norm(x - [1.0, 0.5, 0.2], axis=1) - 0.3
    assert 0.4 * S < apart.min() < 0.8 * S
    assert len(x) == build.counts(case)["fluid"]
    lattice = build.counts(scene(TANK))["fluid"]
    cap = np.pi * 0.2**2 * (0.35 - 0.2 / 3.0)    # of a sphere of 0.35 m, below half a spacing above the bed
    assert lattice - len(x) == pytest.approx((4.0 / 3.0 * np.pi * 0.35**3 - cap) / S**3, rel=0.05)
    own = (arrays["kind"] == WALL) & (arrays["body"] == 1)
    assert np.all(arrays["no_slip"][own] == 1) and np.all(arrays["no_slip"][~own] == 0)
    roles = arrays["role"][own]
    assert np.count_nonzero(roles == DRY) < 0.1 * len(roles) and np.count_nonzero(roles == WET) > 0.8 * len(roles)
    assert set(np.unique(arrays["role"][arrays["kind"] == FLUID])) >= {SURFACE}


def test_particles_do_not_depend_on_the_number_of_ranks(tmp_path):
    case = scene(TANK, surface(tmp_path, sphere(3, 0.3, (1.0, 0.5, 0.2))))
    whole, parts = build.build(case), [build.build(case, rank, 3) for rank in range(3)]
    for name in ("x", "id", "role", "weight"):
        np.testing.assert_array_equal(np.concatenate([part[name] for part in parts]), whole[name])


def test_bathymetry_is_a_bed_with_fluid_above_it(tmp_path):
    bed = sheet(lambda x, y: 0.2 * x + 0.1 * y, (0.0, 0.0), (2.0, 1.0), (10, 5))
    case = scene(TANK, surface(tmp_path, bed))
    assert build.volume(case) == pytest.approx(2.0 * (LEVEL - 0.2 - 0.05), rel=1e-3)
    arrays = build.build(case)
    x = arrays["x"][arrays["kind"] == FLUID]
    assert np.all(x[:, 2] - 0.2 * x[:, 0] - 0.1 * x[:, 1] > 0.49 * S)
    dry = (arrays["kind"] == WALL) & (arrays["x"][:, 2] > LEVEL + S)
    assert np.all(arrays["role"][dry] == DRY)
    assert np.any(arrays["role"] == CONTACT)


def test_inside_of_a_cylinder_is_a_round_tank(tmp_path):
    angle = np.linspace(0.0, 2.0 * np.pi, 65)
    low = np.stack([1.0 + 0.45 * np.cos(angle), 0.5 + 0.45 * np.sin(angle), 0.0 * angle - 0.1], axis=1)
    high = low + [0.0, 0.0, 2.0]
    a, b, c, d = low[:-1], low[1:], high[1:], high[:-1]
    ends = [np.stack([0 * a + z.mean(axis=0), z[1:][::way], z[:-1][::way]][::1], axis=1)
            for z, way in ((low[:], 1), (high[:], 1))]
    ends[1] = ends[1][:, ::-1]
    cylinder = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1), *ends])
    case = scene(TANK, surface(tmp_path, cylinder, side="inside"))
    area = 32.0 * 0.45**2 * np.sin(2.0 * np.pi / 64)
    assert build.volume(case) == pytest.approx(LEVEL * area, rel=0.01)
    mesh = build.scene_mesh(case)
    sides = mesh.element_body == 1
    assert np.abs(np.linalg.norm(mesh.corners()[sides].mean(axis=1)[:, :2] - [1.0, 0.5], axis=1) - 0.45).max() < 0.02
    assert np.all(mesh.corners()[~sides][..., 2] == 0.0)


def test_volume_below_a_level_is_cut_exactly():
    """A tetrahedron upside down: its volume below a height h is h^3 / 6."""
    corners = np.array([(0, 0, 0), (1, 0, 1), (0, 1, 1), (0, 0, 1)], dtype=float)[
        [(0, 1, 2), (0, 2, 3), (0, 3, 1), (1, 3, 2)]]
    for level in (0.25, 0.5, 1.0):
        assert below(corners[:3], level) == pytest.approx(level**3 / 6.0, rel=1e-12)
    steps = box((1.0, 1.0, 1.0))[:, ::-1]
    assert below(steps, 0.3) == pytest.approx(0.3, rel=1e-12)


def test_slope_of_a_profile_and_a_rock_on_it(tmp_path):
    beach = Profile(points=[(0.0, 1.0), (0.0, 0.0), (1.0, 0.0), (3.0, 1.0)], breadth=1.0)
    rock = surface(tmp_path, sphere(3, 0.2, (2.0, 0.5, 0.5)), name="rock")
    case = scene(beach, rock)
    room = scene_room.scene_room(case)
    half = 0.5 * 4.0 / 3.0 * np.pi * 0.2**3
    assert below(room.corners, LEVEL) == pytest.approx(LEVEL + 0.5 * 1.2 * LEVEL - 0.75 * half, rel=0.02)
    mesh = build.scene_mesh(case)
    assert [body.name for body in mesh.bodies] == ["profile", "rock"]
    for body in (0, 1):
        assert np.any(mesh.element_body == body)
    assert build.volume(case) == pytest.approx(below(room.corners, LEVEL), rel=1e-12)


def told(case):
    with pytest.raises(CaseError) as error:
        scene_checks.check(case)
    return str(error.value)


def test_file_in_millimetres_is_refused_with_the_scale(tmp_path):
    said = told(scene(TANK, surface(tmp_path, 1000.0 * box((0.4, 0.3, 0.3), (0.8, 0.3, 0.0)), name="rock")))
    assert said.startswith("walls, rock: reaches from (800, 300, 0) to (1200, 600, 300) m, 200 times the size of the ")
    assert "give scale=0.001 if its file is in mm" in said


def test_surface_outside_or_below_the_spacing_is_refused(tmp_path):
    assert "lies outside the scene, from (0, 0, 0) to (2, 1, 1); move it by at=" in told(
        scene(TANK, surface(tmp_path, box((0.4, 0.3, 0.3), (5.0, 0.3, 0.0)))))
    assert "is smaller than a spacing, 0.1 m" in told(
        scene(TANK, surface(tmp_path, box((0.04, 0.03, 0.03), (1.0, 0.3, 0.0)))))


def test_bed_that_does_not_reach_the_walls_is_refused_with_number_and_place(tmp_path):
    bed = sheet(lambda x, y: 0.1 + 0 * x, (0.0, 0.0), (1.5, 1.0), (6, 4))
    said = told(scene(TANK, surface(tmp_path, bed, name="bed")))
    assert "walls, bed: is open, a bed with fluid above it, but has none below 55 of 231 places" in said
    assert "must cover x from 0 to 2 and y from 0 to 1, and reaches from (0, 0) to (1.5, 1)" in said


def test_holes_are_told_by_check(tmp_path):
    assert "has 2 holes with 6 open edges at (" in told(
        scene(TANK, surface(tmp_path, np.delete(box((0.4, 0.3, 0.3), (0.8, 0.3, 0.0)), [0, 2], axis=0))))


def test_what_was_mended_and_what_is_thin_is_warned_of(tmp_path):
    corners = box((0.4, 0.3, 0.3), (0.8, 0.55, 0.0))[:, ::-1]
    found = scene_checks.warnings(scene(TANK, surface(tmp_path, corners, name="rock")))
    assert any("all triangles are reversed" in line for line in found)
    gaps = [line for line in found if "the fluid between them is less than 2 spacings thick" in line]
    assert len(gaps) == 1 and "0.15 m or 1.5 spacings" in gaps[0] and "rock" in gaps[0] and "tank" in gaps[0]
    plate = scene_checks.warnings(scene(TANK, surface(tmp_path, box((0.05, 0.5, 0.5), (1.0, 0.25, 0.0)), name="slab")))
    walls = [line for line in plate if "the solid between two sides is less than 2 spacings thick" in line]
    assert len(walls) == 1 and walls[0].startswith("walls, slab: ") and "0.05 m or 0.5 spacings" in walls[0]


def test_thinnest_gap_is_told_with_its_place_also_if_it_is_wide(tmp_path):
    """The rock is .35 m from the back of the tank, .4 m from its front, and .8 m from its ends."""
    rock = surface(tmp_path, box((0.4, 0.25, 0.3), (0.8, 0.4, 0.0)), name="rock")
    facts = scene_checks.facts(scene(TANK, rock))
    assert facts.gap == pytest.approx(0.35, rel=1e-6) and facts.between == ("rock", "tank")
    assert facts.at[1] == pytest.approx(0.825, abs=1e-5) and 0.7 < facts.at[0] < 1.3 and 0.0 < facts.at[2] < 0.4


@pytest.mark.parametrize(("at", "size", "remedy"), [
    (0.68, 0.3, "the fluid between them is less than 2 spacings thick"), (0.5, 0.02, "the solid between two sides")])
def test_walls_that_nearly_touch_should_overlap_or_be_moved(tmp_path, at, size, remedy):
    found = scene_checks.warnings(scene(TANK, surface(tmp_path, box((0.4, size, 0.3), (0.8, at, 0.0)), name="rock")))
    line, = (line for line in found if remedy in line)
    assert "spacing of at most" not in line and line.endswith(
        "; make it thicker, or leave it out" if size < 0.1 else "; let them overlap, or move them apart")


def test_water_below_its_bed_is_told_with_both_heights(tmp_path):
    bed = surface(tmp_path, sheet(lambda x, y: 0.7 + 0 * x, (0.0, 0.0), (2.0, 1.0), (4, 2)), name="bed")
    assert "reaches up to z = 0.6 m, but the walls leave room from z = 0.7 m on, above bed; raise its level" in told(
        scene(TANK, bed))


def test_bed_far_larger_than_the_scene_is_warned_of_with_the_scale(tmp_path):
    bed = surface(tmp_path, sheet(lambda x, y: 0.2 + 0 * x, (-30.0, -30.0), (30.0, 30.0), (4, 4)), name="bed")
    assert "walls, bed: is 30 times as large as the scene, and cut by it; give scale=0.001 if its file is in mm" in (
        scene_checks.warnings(scene(TANK, bed)))


def test_lost_details_and_crossing_triangles_are_warned_of(tmp_path):
    spike = np.concatenate([box((0.4, 0.3, 0.3), (0.8, 0.3, 0.0)), box((0.02, 0.02, 0.2), (1.0, 0.4, 0.2))])
    found = scene_checks.warnings(scene(TANK, surface(tmp_path, spike, name="rock")))
    assert any("triangles of the file cross others, the first at" in line for line in found)
    assert any("points of surfaces are more than 0.3 spacings from the mesh" in line for line in found)


def test_scenes_that_surfaces_do_not_fit_are_refused(tmp_path):
    rock = surface(tmp_path, box((0.4, 0.3, 0.3), (0.8, 0.3, 0.0)), name="rock")
    with pytest.raises(CaseError, match="a Surface is for 3D scenes; give the Tank or the Profile around it a breadth"):
        scene(Tank(width=2.0, height=1.0), rock)
    with pytest.raises(CaseError, match="cannot be in a scene with Surfaces so far; give an Obstacle"):
        scene(TANK, rock, Plate(points=((0.5, 0.0), (0.5, 0.5))))
    with pytest.raises(CaseError, match="the name 'rock' is given 2 times"):
        scene(TANK, rock, rock)
    with pytest.raises(CaseError, match="walls, rock: weakly compressible SPH has no friction on walls"):
        scene(TANK, rock.model_copy(update={"slip": "none"}), method="SPH")
    with pytest.raises(CaseError, match="on = 'rock': a Surface has no section in which this is measured; give"):
        scene(TANK, rock, probes=[RunUp("up", on="rock", side="left", y=0.4)])
    with pytest.raises(CaseError, match="side = 'left': only a tank has sides"):
        scene(TANK, rock, probes=[Force("load", on="rock", side="left")])


@pytest.mark.parametrize(("size", "at"), [((0.6, 0.5, 0.4), (0.7, 0.25, 0.25)),
                                          ((0.6, 0.3, 0.3), (0.733, 0.281, 0.233))])    # three spacings wide
def test_force_on_a_surface_is_the_weight_of_the_water_in_its_place(tmp_path, size, at):
    """A linear pressure is known exactly, so that the sides push alike, and there is no moment about the middle."""
    rock = surface(tmp_path, box(size, at), name="rock")
    (x, y, z), height = np.array(at) + 0.5 * np.array(size), 0.9
    case = scene(TANK, rock, level=height, probes=[Force("load", on="rock", about=(x, y, z))])

    def still(arrays):
        arrays["p"][:] = DENSITY * G * (height - arrays["x"][:, 2])

    watch = Watch(case, MPI.COMM_SELF, still)
    found = watch.sample()["load"]
    watch.destroy()
    weight = DENSITY * G * np.prod(size)
    assert found[2] == pytest.approx(weight, rel=1e-6)
    np.testing.assert_allclose(np.delete(found, 2), 0.0, atol=1e-5 * weight)


def test_friction_acts_on_a_surface_in_a_tank_to_which_fluid_sticks(tmp_path):
    rock = surface(tmp_path, box((0.4, 0.3, 0.3), (0.8, 0.3, 0.0)), name="rock")
    sticky = Tank(width=2.0, height=1.0, breadth=1.0, no_slip=True)
    assert scene(sticky, rock, friction=Friction()).physics == {"friction"}
    with pytest.raises(CaseError, match="along which fluid slips, and this scene has none"):
        scene(sticky, rock.model_copy(update={"slip": "none"}), friction=Friction())


def test_bodies_that_move_into_a_surface_are_refused_with_time_and_place(tmp_path):
    """The obstacle is .3 m from the rock, and is a quarter of a spacing inside when it has swayed by .325 m."""
    rock = surface(tmp_path, box((0.4, 0.4, 0.3), (1.3, 0.3, 0.0)), name="rock")

    def moving(amplitude):
        block = Obstacle(Box(0.4, 0.2, at=(0.6, 0.05)), across=(0.3, 0.7), name="block",
                         motion=Sway(amplitude, 2.0))
        return scene(TANK, rock, block)

    said = told(moving(0.4))
    assert said.startswith("walls, block: its Sway brings it into rock at t = 0.") and "at (1.3" in said
    scene_checks.check(moving(0.2))


def test_bodies_that_move_into_a_bed_are_refused_but_for_the_feet_of_wavemakers(tmp_path):
    """The bed rises 1 : 2 from x = .8 m on: a piston that goes to x = 1 m has only its foot in it, .1 m deep."""
    def bed(x, y):
        return 0.5 * np.clip(x - 0.8, 0.0, None)

    slope = surface(tmp_path, sheet(bed, (0.0, 0.0), (2.0, 1.0), (20, 2)), name="bed")

    def piston(amplitude):
        return scene(TANK, slope, Piston(at=0.5, side="right", motion=Sway(amplitude, 2.0)))

    def block(amplitude):
        return scene(TANK, slope, Obstacle(Box(0.3, 0.2, at=(0.4, 0.1)), across=(0.3, 0.7), name="block",
                                           motion=Sway(amplitude, 2.0)))

    for made, name, low, high in ((piston, "piston-1", 0.35, 0.7), (block, "block", 0.2, 0.5)):
        assert f"walls, {name}: its Sway brings it into bed at t = " in told(made(high))
        scene_checks.check(made(low))


def test_stored_case_gives_the_same_scene(tmp_path):
    case = scene(TANK, surface(tmp_path, box((0.4, 0.3, 0.3), (0.8, 0.3, 0.0)), scale=1.0, name="rock"))
    assert Case.model_validate_json(case.model_dump_json()) == case


def test_water_around_a_surface_has_no_level_that_its_volume_gives(tmp_path):
    rock = surface(tmp_path, box((0.4, 0.3, 0.3), (0.8, 0.3, 0.0)))
    for walls, level in (((TANK,), True), ((TANK, rock), False)):
        case = scene(*walls)
        assert has_level(case, ProbeScene.of(case)) is level
