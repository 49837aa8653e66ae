"""Particles at the start: where they are, what part they play, and that slices do not matter."""

import numpy as np
import pytest

from parisph import Box, Disc, Polygon, Tank
from parisph.base.errors import CaseError
from parisph.base.fields import CONTACT, DRY, FIELDS, FLUID, INNER, SURFACE, WALL, WET
from parisph.case.lattice import Lattice, misfit
from parisph.geometry import build as geometry
from parisph.geometry.mesh import CONCAVE
from tests.scenes import simulated, water


def scene(shape=None, walls=Tank(2.0, 2.0), elevation=None, velocity=(0.0, 0.0), spacing=0.1, **numerics):
    return water(shape or (0.5, 1.0), walls, dict(spacing=spacing, **numerics), elevation=elevation, velocity=velocity)


SCENES = {
    "column": scene(),
    "lid": scene(walls=Tank(2.0, 2.0, lid=True)),
    "full": scene(Box(2.0, 2.0), Tank(2.0, 2.0, lid=True)),
    "drop": scene(Disc(0.5), None),
    "drop in tank": scene(Disc(0.5, at=(1.0, 1.03)), Tank(2.0, 2.0, at=(0.0, -0.1))),
    "triangle": scene(Polygon(((0.0, 0.0), (1.0, 0.0), (0.0, 1.0)))),
    "patch": scene(Box(0.5, 0.5, at=(-0.25, -0.25)), None),
    "wave": scene(Box(2.0, 1.0), elevation="0.1*cos(pi*x)", jitter=0.4),
}


def started(case):
    """Return {field: array by id} of a case when its fluid is in place."""
    return simulated(case).gather("x", "u", "volume", "role", "kind")


def role_at(arrays, x, y, kind=None):
    """Return the role of the particle at (x, y), which must be there once."""
    here = np.hypot(arrays["x"][:, 0] - x, arrays["x"][:, 1] - y) < 1e-9
    if kind is not None:
        here &= arrays["kind"] == kind
    assert np.count_nonzero(here) == 1, (x, y)
    return arrays["role"][here][0]


@pytest.mark.parametrize("name", SCENES)
def test_slices_make_up_the_whole(name):
    case = SCENES[name]
    whole = geometry.build(case)
    for n_ranks in (2, 3, 41):
        parts = [geometry.build(case, rank, n_ranks) for rank in range(n_ranks)]
        for key, value in whole.items():
            assert np.array_equal(np.concatenate([part[key] for part in parts]), value), (n_ranks, key)


@pytest.mark.parametrize("name", SCENES)
def test_arrays_are_those_of_the_registry(name):
    case = SCENES[name]
    arrays = geometry.build(case)
    n = geometry.counts(case)
    assert n["all"] == n["fluid"] + n["wall"] == len(arrays["id"])
    assert np.array_equal(arrays["id"], np.arange(n["all"]))
    assert np.count_nonzero(arrays["kind"] == WALL) == n["wall"]
    for key, value in arrays.items():
        expected = FIELDS[key].empty(n["all"], case.dim)
        assert value.dtype == expected.dtype and value.shape == expected.shape, key
    lower, upper = geometry.domain(case)
    assert np.all(arrays["x"] >= lower - 1e-9) and np.all(arrays["x"] <= upper + 1e-9)


# -- the volume that a particle stands for ---------------------------------------------------------


def volumes(case):
    """Return {(x, y) in spacings: volume in cells} of the fluid."""
    arrays, s = geometry.build(case), case.numerics.spacing
    fluid = arrays["kind"] == FLUID
    assert np.all(arrays["volume"][~fluid] == 0.0) and np.all(arrays["volume"][fluid] > 0.0)
    places = map(tuple, np.round(arrays["x"][fluid] / s).astype(int))
    return dict(zip(places, arrays["volume"][fluid] / s**2))


def test_cells_of_a_column_beside_walls():
    found = volumes(scene(Box(width=0.5, height=1.0)))
    across, up = {1: 1.5, 5: 0.5}, {1: 1.5, 10: 0.5}      # beside a wall 3/2, on the surface 1/2
    assert found == pytest.approx(
        {(i, j): across.get(i, 1.0) * up.get(j, 1.0) for i in range(1, 6) for j in range(1, 11)})


@pytest.mark.parametrize("shape, walls, volume, within", [
    (Box(width=0.5, height=1.0), None, 0.5, 1e-12),
    (Box(width=2.0, height=2.0), Tank(2.0, 2.0, True), 4.0, 1e-12),
    (Disc(radius=0.5, at=(1.0, 1.0)), Tank(2.0, 2.0), 0.25 * np.pi, 1e-3),
    (Disc(radius=0.5), None, 0.25 * np.pi, 1e-3),
    (Polygon(points=((0.0, 0.0), (1.0, 0.0), (0.0, 1.0))), Tank(2.0, 2.0), 0.5, 1e-9),
])
def test_volumes_add_up_to_the_body(shape, walls, volume, within):
    assert started(scene(shape, walls))["volume"].sum() == pytest.approx(volume, rel=within)


def test_fluid_that_misses_all_points_is_refused():
    sliver = Polygon(((0.05, 0.15), (299.0, 299.1), (299.0, 299.102)))    # between the points of the tank's lattice
    with pytest.raises(CaseError, match="no particle fits"):
        geometry.build(scene(sliver, Tank(300.0, 300.0), spacing=0.2))


def test_every_particle_stands_for_something():
    sharp = started(scene(Polygon(points=((0.0, 0.0), (2.0, 0.0), (2.0, 0.02))), walls=None, spacing=0.05))
    assert sharp["volume"].min() > 0.0


def test_stretched_columns_keep_their_share():
    found = geometry.build(scene(Box(width=2.0, height=1.0), elevation="0.1*cos(pi*x)"))
    columns = np.round(found["x"][:, 0] / 0.1).astype(int)
    volume = np.bincount(columns, found["volume"])
    x = 0.1 * np.arange(2, 19)
    assert volume[2:19] == pytest.approx(0.1 * (1.0 + 0.1 * np.cos(np.pi * x)))


@pytest.mark.parametrize("name", SCENES)
def test_no_two_particles_coincide(name):
    arrays = geometry.build(SCENES[name])
    x = arrays["x"]
    distance = np.hypot(*(x[:, None, :] - x[None, :, :]).T)
    np.fill_diagonal(distance, 1.0)
    assert distance.min() > 0.4 * SCENES[name].numerics.spacing


def test_column_of_the_dam_break():
    arrays = geometry.build(SCENES["column"])
    fluid = arrays["x"][arrays["kind"] == 0]
    assert len(fluid) == 5 * 10
    assert fluid.min(axis=0) == pytest.approx([0.1, 0.1]) and fluid.max(axis=0) == pytest.approx([0.5, 1.0])
    assert (role_at(arrays, 0.5, 0.3) == SURFACE and role_at(arrays, 0.2, 1.0) == SURFACE
            and role_at(arrays, 0.4, 0.9) == INNER)
    assert role_at(arrays, 0.0, 1.0) == CONTACT and role_at(arrays, 0.5, 0.0) == CONTACT
    assert role_at(arrays, 0.0, 0.9) == WET and role_at(arrays, 0.4, 0.0) == WET and role_at(arrays, 0.0, 0.0) == WET
    assert role_at(arrays, 0.0, 1.1) == DRY and role_at(arrays, 0.6, 0.0) == DRY and role_at(arrays, 2.0, 0.1) == DRY
    assert np.count_nonzero(arrays["role"] == CONTACT) == 2


def test_walls_have_inward_unit_normals_and_corners():
    for name, corners in (("column", [(0, 0), (2, 0), (0, 2), (2, 2)]), ("lid", [(0, 0), (2, 0), (0, 2), (2, 2)])):
        case, arrays = SCENES[name], geometry.build(SCENES[name])
        wall = arrays["kind"] == WALL
        assert np.linalg.norm(arrays["normal"][wall], axis=1) == pytest.approx(1.0)
        assert not arrays["normal"][~wall].any()
        found = {tuple(x) for x in np.round(arrays["x"][arrays["corner"] == 1], 9)}
        assert found == set(corners)
        in_corner = arrays["normal"][(arrays["corner"] == 1) & (arrays["edge"] == CONCAVE)]
        assert np.allclose(np.abs(in_corner), np.sqrt(0.5))
        # One step along the normal leads into the tank, and every wall particle lies on a plane.
        inside = arrays["x"][wall] + 0.05 * arrays["normal"][wall]
        lower, upper = case.walls.bounds
        points = np.array([lower, lower, upper, upper][: 4 if name == "lid" else 3])
        normals = np.array([(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)][: len(points)])
        height = np.sum((inside[:, None] - points) * normals, axis=2)
        assert np.all(height > -1e-12)
        on = np.abs(np.sum((arrays["x"][wall][:, None] - points) * normals, axis=2)) < 1e-12
        assert np.all(on.any(axis=1))


def test_rim_of_an_open_tank_is_the_end_of_its_sides():
    arrays = geometry.build(SCENES["column"])
    rim = np.abs(arrays["x"][:, 1] - 2.0) < 1e-9
    assert np.count_nonzero(rim) == 2 and arrays["corner"][rim].all() and not arrays["edge"][rim].any()
    assert np.abs(arrays["normal"][rim, 0]) == pytest.approx(1.0)


def test_full_tank_is_closed_and_has_no_surface():
    assert SCENES["full"].closed and not SCENES["lid"].closed and not SCENES["drop"].closed
    arrays = geometry.build(SCENES["full"])
    assert set(arrays["role"]) == {INNER, WET}
    assert not scene(Box(2.0, 2.0), Tank(2.0, 2.0)).closed


@pytest.mark.parametrize("gap", [1, 2])
def test_water_below_a_lid_has_a_surface_at_any_gap(gap):
    arrays = geometry.build(scene(Box(2.0, 2.0 - 0.1 * gap), Tank(2.0, 2.0, lid=True)))
    fluid, top = arrays["kind"] == 0, np.abs(arrays["x"][:, 1] - (2.0 - 0.1 * gap)) < 1e-9
    assert np.all(arrays["role"][fluid & top] == SURFACE) and np.all(arrays["role"][fluid & ~top] == INNER)
    assert WET not in arrays["role"][arrays["x"][:, 1] > 1.99 - 0.1 * gap]


@pytest.mark.parametrize("rise", [0.02, 0.07])
def test_water_raised_to_less_than_a_spacing_below_a_lid(rise):
    arrays = geometry.build(scene(Box(2.0, 1.9), Tank(2.0, 2.0, lid=True), elevation=str(rise)))
    lid = np.abs(arrays["x"][:, 1] - 2.0) < 1e-9
    assert set(arrays["role"][lid]) <= {DRY, CONTACT} and np.count_nonzero(arrays["role"] == SURFACE) == 19
    assert role_at(arrays, 0.0, 1.8) == WET


def test_column_one_spacing_from_a_wall_has_a_surface_there():
    arrays = geometry.build(scene(Box(0.9, 1.0, at=(0.1, 0.0)), Tank(2.0, 2.0)))
    assert (role_at(arrays, 0.1, 0.5) == SURFACE and role_at(arrays, 0.0, 0.5) == DRY
            and role_at(arrays, 0.2, 0.5) == INNER)
    touching = geometry.build(scene(Box(1.0, 1.0), Tank(2.0, 2.0)))
    assert role_at(touching, 0.1, 0.5) == INNER and role_at(touching, 0.0, 0.5) == WET


def test_fluid_fills_an_open_tank_to_the_brim():
    arrays = geometry.build(scene(Box(2.0, 2.0)))
    assert role_at(arrays, 1.0, 2.0) == SURFACE and role_at(arrays, 0.0, 2.0) == CONTACT


def test_bodies_without_a_tank_lie_on_their_edge():
    patch = geometry.build(SCENES["patch"])
    assert len(patch["id"]) == 36 and np.count_nonzero(patch["role"] == SURFACE) == 20
    drop = geometry.build(SCENES["drop"])
    assert role_at(drop, 0.0, 0.0) == INNER and role_at(drop, 0.5, 0.0) == SURFACE
    assert np.linalg.norm(drop["x"], axis=1).max() < 0.5 + 1e-3
    assert len(drop["id"]) * 0.01 == pytest.approx(np.pi * 0.25, rel=0.05)


def test_drop_in_a_tank_uses_the_tanks_lattice():
    arrays = geometry.build(SCENES["drop in tank"])
    fluid = arrays["x"][arrays["kind"] == 0]
    assert np.allclose(np.round(fluid * 10), fluid * 10)
    assert set(arrays["role"][arrays["kind"] == WALL]) == {DRY}


def test_triangle_on_the_bed():
    arrays = geometry.build(SCENES["triangle"])
    assert role_at(arrays, 0.5, 0.5) == SURFACE and role_at(arrays, 0.1, 0.1) == INNER
    assert role_at(arrays, 0.0, 0.5, WALL) == WET and role_at(arrays, 0.0, 1.0, WALL) == CONTACT
    assert role_at(arrays, 0.0, 1.1, WALL) == DRY


def test_polygon_either_way_round_is_the_same():
    points = ((0.0, 0.0), (1.0, 0.0), (1.0, 0.6), (0.3, 1.0))
    one, other = (geometry.build(scene(Polygon(p), None)) for p in (points, points[::-1]))
    assert np.array_equal(one["x"], other["x"]) and len(one["id"]) > 60


def test_elevation_stretches_the_columns():
    case = scene(Box(2.0, 1.0), elevation="0.1*cos(pi*x)")
    arrays = geometry.build(case)
    for x in (0.1, 1.0):
        column = arrays["x"][(arrays["kind"] == 0) & (np.abs(arrays["x"][:, 0] - x) < 1e-9), 1]
        top = 1.0 + 0.1 * np.cos(np.pi * x)
        assert column == pytest.approx(top * np.arange(1, 11) / 10)
    # Wall particles do not move: the one nearest to the surface is the contact line.
    assert (role_at(arrays, 0.0, 1.1) == CONTACT and role_at(arrays, 0.0, 1.0) == WET
            and role_at(arrays, 0.0, 1.2) == DRY)
    assert np.count_nonzero(arrays["role"] == CONTACT) == 2


def test_start_velocity_is_that_of_the_expression_at_the_particle():
    arrays = started(scene(velocity=("x*y", -2), jitter=0.5))
    fluid = arrays["kind"] == 0
    x = arrays["x"][fluid]
    assert np.array_equal(arrays["u"][fluid], np.stack([x[:, 0] * x[:, 1], np.full(len(x), -2.0)], axis=1))
    assert not arrays["u"][~fluid].any()


def test_jitter_moves_inner_fluid_within_its_bounds_only():
    plain, rough = geometry.build(SCENES["column"]), started(scene(jitter=0.4, seed=1))
    move = rough["x"] - plain["x"]
    inner = (plain["role"] == INNER) & (plain["kind"] == 0)
    assert not move[~inner].any() and np.all(move[inner] != 0.0)
    assert np.abs(move).max() <= 0.5 * 0.4 * 0.1
    assert np.array_equal(rough["role"], plain["role"])
    other = started(scene(jitter=0.4, seed=2))
    assert not np.allclose(other["x"], rough["x"])
    wild = started(scene(jitter=0.4, seed=1, jitter_surface=True))
    assert (wild["x"] - plain["x"])[plain["role"] == SURFACE].any()
    assert np.array_equal(wild["x"][inner], rough["x"][inner])


def test_random_numbers_are_uniform_and_independent():
    r = geometry.uniform(7, np.arange(200_000), 2)
    assert r.min() >= 0.0 and r.max() < 1.0
    assert r.mean(axis=0) == pytest.approx(0.5, abs=3e-3) and r.var(axis=0) == pytest.approx(1 / 12, abs=1e-3)
    for a, b in ((r[:, 0], r[:, 1]), (r[:-1, 0], r[1:, 0]),
                 (r[:, 0], geometry.uniform(8, np.arange(200_000), 2)[:, 0])):
        assert abs(np.corrcoef(a, b)[0, 1]) < 0.01


def test_rounded_spacing_still_ends_on_the_wall():
    arrays = geometry.build(scene(Box(2.0, 1.0), spacing=0.0416667))
    assert arrays["x"][arrays["kind"] == WALL].max(axis=0) == pytest.approx([2.0, 2.0], abs=1e-12)
    assert len({*np.round(arrays["x"][:, 0], 9)}) == 49
    assert misfit(1.0, 0.0416667) < 1e-3 < misfit(1.0, 0.0417)


class Brick(Box):
    """A box in three dimensions: the scenes have none yet, the lattice must not care."""

    @property
    def size(self):
        return np.array([0.4, 0.3, self.height])

    @property
    def bounds(self):
        return np.zeros(3), self.size


class Basin(Tank):
    @property
    def size(self):
        return np.array([0.8, 0.3, self.height])

    @property
    def bounds(self):
        return np.zeros(3), self.size


@pytest.mark.parametrize("lid", [False, True])
@pytest.mark.parametrize("shape, tank", [(Box, Tank), (Brick, Basin)])
def test_walls_are_the_faces_of_the_tank(shape, tank, lid):
    points = Lattice(shape(0.4, 0.5), tank(0.8, 0.7, lid), 0.1)
    block = np.stack(np.meshgrid(*[np.arange(n + 1) for n in points.top], indexing="ij"),
                     axis=-1).reshape(-1, len(points.top))
    on_lower, on_upper = block == 0, block == points.top
    on_upper[:, -1] &= lid
    faces = (on_lower | on_upper).any(axis=1)
    index, inward = points.wall_indices()
    assert np.array_equal(index, block[faces])
    assert np.array_equal(inward, on_lower[faces].astype(int) - on_upper[faces])


def test_lattice_in_three_dimensions():
    points = Lattice(Brick(0.4, 0.5), Basin(0.8, 1.0, True), 0.1)
    assert points.counts.tolist() == [4, 2, 5]    # walls at both sides in y
    wall, inward = points.wall_indices()
    assert len(wall) == 9 * 4 * 11 - 7 * 2 * 9
    faces = np.abs(inward).sum(axis=1)
    assert np.count_nonzero(faces == 3) == 8 and np.count_nonzero(faces == 2) == 4 * (7 + 2 + 9)
