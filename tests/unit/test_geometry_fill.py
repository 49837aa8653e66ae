"""Filling scenes with fluid: lattices, still water between any walls, holes, and slices of ranks."""

import tracemalloc

import numpy as np
import pytest

from parisph import Box, Disc, Polygon, Tank
from parisph.case.bodies import Obstacle, Plate, Profile, StillWater
from parisph.case.lattice import Lattice
from parisph.geometry.columns import near_pieces, union
from parisph.geometry.distance import nearest
from parisph.geometry.fill import Filling
from parisph.geometry.mesh import wall_mesh
from parisph.geometry.solid import in_fluid

S = 0.05
TRIANGLE = Polygon([(0.32, 0.1), (1.9, 0.4), (0.8, 0.9), (0.7, 0.45)])


def filling(shape, *walls, spacing=S, holes=()):
    return Filling(shape, walls, spacing, holes)


def by_looking(fill, walls, spacing=S):
    """Return the indices of all points of the lattice that keep the rules, each of them looked at."""
    mesh = wall_mesh(walls, spacing)
    lower, upper = mesh.x0.min(axis=0) - spacing, mesh.x0.max(axis=0) + spacing
    first, last = np.floor((lower - fill.origin) / fill.step), np.ceil((upper - fill.origin) / fill.step)
    places = np.meshgrid(*[np.arange(a, b + 1) for a, b in zip(first, last)], indexing="ij")
    index = np.stack(places, axis=-1).reshape(-1, 2)
    x = fill.position(index)
    good = in_fluid(walls, x) & fill.holds(x) & (x[:, 0] >= mesh.x0[:, 0].min()) & (
        x[:, 0] <= mesh.x0[:, 0].max())
    good &= nearest(x, mesh.corners())[0] >= (0.5 - 1e-6) * spacing
    return index[good]


@pytest.mark.parametrize("tank", [None, Tank(2.0, 1.0), Tank(2.0, 1.0, lid=True)])
@pytest.mark.parametrize("shape", [
    Box(1.0, 0.6), Box(1.0, 1.0), Box(0.5, 0.5, at=(0.25, 0.3)), Disc(0.3, at=(0.5, 0.5)), TRIANGLE])
def test_shape_in_a_tank_or_none_has_the_points_of_the_lattice(shape, tank):
    lattice, fill = Lattice(shape, tank, S), filling(shape, *([] if tank is None else [tank]))
    index = lattice.first + np.indices(lattice.counts).reshape(2, -1).T

    def inside(index):
        return shape.inside(lattice.position(index), 0.01 * S)
    index = index[inside(index)]
    np.testing.assert_array_equal(fill.indices(), index)
    assert fill.even and fill.position(index).tobytes() == lattice.position(index).tobytes()
    np.testing.assert_array_equal(
        fill.is_surface(index), ~np.all([inside(index + step) for step in ((1, 0), (-1, 0), (0, 1), (0, -1))], axis=0))


@pytest.mark.parametrize(("shape", "walls"), [
    (Box(0.53, 0.5), [Tank(2.0, 1.0)]), (StillWater(0.5), [Tank(2.0, 1.0)]),
    (Box(0.5, 0.5), [Tank(2.0, 1.0), Obstacle(Box(0.1, 0.1, at=(1.5, 0.0)))]),
])
def test_fluid_off_the_lattice_of_a_lone_tank_is_not_even(shape, walls):
    assert not filling(shape, *walls).even


SCENES = {
    "slope": [Profile([(0.0, 1.0), (0.0, 0.0), (1.0, 0.0), (3.0, 1.1)])],
    "sill": [Tank(3.0, 1.0), Obstacle(Polygon([(1.0, 0.0), (1.2, 0.2), (1.8, 0.2), (2.0, 0.0)]))],
    "disc and plate": [Tank(3.02, 1.0), Obstacle(Disc(0.25, at=(1.5, 0.52))), Plate([(2.22, 0.1), (2.3, 0.7)])],
    "plate between rows": [Tank(3.0, 1.0), Plate([(0.5, 0.33 - 2.5 * S), (2.0, 0.33 - 2.5 * S)])],
}


@pytest.mark.parametrize("scene", SCENES)
def test_still_water_fills_what_the_walls_enclose(scene):
    walls = SCENES[scene]
    fill = filling(StillWater(0.83), *walls)
    index = fill.indices()
    np.testing.assert_array_equal(index, by_looking(fill, walls))
    surface = fill.is_surface(index)
    np.testing.assert_array_equal(surface, index[:, 1] == 0)
    np.testing.assert_allclose(fill.position(index)[surface, 1], 0.83, rtol=1e-15)


def test_plate_half_way_between_two_rows_has_both_beside_it():
    walls = [Tank(3.0, 1.0), Plate([(0.5, 0.85 - 5.5 * S), (2.0, 0.85 - 5.5 * S)])]
    fill = filling(StillWater(0.85), *walls)
    rows = fill.indices()
    assert {-5, -6} <= set(rows[rows[:, 0] == 20, 1])
    np.testing.assert_array_equal(rows, by_looking(fill, walls))


@pytest.mark.parametrize("depth", [0.32, 0.325, 0.33, 0.35, 0.83])
@pytest.mark.parametrize("water", [StillWater, lambda depth: Box(0.88, depth)], ids=["still", "box"])
def test_whole_rows_of_whole_cells_at_any_depth(water, depth):
    """Else up to half a cell of each column is too much or too little, and violent flow makes up for it."""
    fill = filling(water(depth), Tank(3.0, 1.0))
    rows = depth / fill.step[1]
    assert rows == pytest.approx(round(rows))
    assert fill.step.prod() == pytest.approx(S * S, rel=0.03)
    assert np.all(np.abs(fill.step - S) < 0.1 * S)


def test_dam_beside_a_sill():
    walls = [Tank(3.0, 1.0), Obstacle(Polygon([(0.5, 0.0), (0.8, 0.3), (1.1, 0.0)]))]
    fill = filling(Box(0.7, 0.5), *walls)
    index = fill.indices()
    np.testing.assert_array_equal(index, by_looking(fill, walls))
    at = fill.position(index)
    assert np.all(fill.is_surface(index) == ((at[:, 1] > 0.49) | (at[:, 0] > 0.69)))


def test_holes_are_left_out():
    hole = Disc(0.2, at=(0.8, 0.5))
    index = filling(Box(1.5, 1.0), holes=[hole]).indices()
    x = S * index
    assert not np.any(hole.inside(x, -0.02 * S))
    every = np.stack(np.meshgrid(np.arange(31), np.arange(21)), -1).reshape(-1, 2)
    assert len(index) == 31 * 21 - np.count_nonzero(hole.inside(S * every, -0.01 * S))


@pytest.mark.parametrize("ranks", [1, 2, 3, 7])
def test_slices_do_not_depend_on_the_number_of_ranks(ranks):
    fill = filling(StillWater(0.83), *SCENES["disc and plate"])
    stops = [fill.count * k // ranks for k in range(ranks + 1)]
    parts = [fill.indices(a, b) for a, b in zip(stops[:-1], stops[1:])]
    np.testing.assert_array_equal(np.concatenate(parts), fill.indices())


@pytest.mark.parametrize(("level", "count"), [(-1.0, 0), (0.0, 0), (0.2 * S, 0), (0.6 * S, 59), (7.0, 59 * 19)])
def test_levels_out_of_the_ordinary(level, count):
    assert filling(StillWater(level), Tank(3.0, 1.0, lid=True)).count == count


def test_a_rank_of_many_holds_its_own_share_only():
    s = 0.002
    walls = [Profile([(0.0, 1.0), (0.0, 0.0), (1.0, 0.0), (3.0, 1.1)])]
    wall_mesh(walls, s)
    tracemalloc.start()
    fill = Filling(StillWater(0.9), walls, s)
    mine = fill.indices(fill.count // 2, fill.count // 2 + 1000)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert fill.count > 350_000 and len(mine) == 1000
    assert peak < 16 * fill.count / 2    # bytes: less than half of all indices


def test_near_pieces_are_all_within_the_reach_and_no_others():
    rng = np.random.default_rng(5)
    a, b = rng.random((2, 40, 2))
    b[::5, 0], b[1::5, 1] = a[::5, 0], a[1::5, 1]    # upright and level pieces
    b[2::5] = a[2::5]                                # and points
    lines, reach = np.linspace(-0.1, 1.1, 13), 0.07
    line, low, high = union(near_pieces(a, b, reach, lines))
    for y in np.linspace(-0.1, 1.1, 49):
        for k, x in enumerate(lines):
            least = min(_apart(np.array([x, y]), p, q) for p, q in zip(a, b))
            inside = bool(np.any((line == k) & (low <= y) & (y <= high)))
            assert inside == (least <= reach) or abs(least - reach) < 1e-9


def _apart(p, a, b):
    along = b - a
    t = np.clip((p - a) @ along / max(along @ along, 1e-300), 0.0, 1.0)
    return np.linalg.norm(p - a - t * along)
