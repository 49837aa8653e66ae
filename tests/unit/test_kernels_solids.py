"""Walls as elements: visibility, nearest walls, guard, in 2D and 3D."""

import numpy as np
import pytest

from parisph import Box, Polygon, Tank
from parisph.base.fields import FLUID, WALL
from parisph.case.bodies import Obstacle, Plate, StillWater
from parisph.geometry.distance import nearest
from parisph.geometry.mesh import wall_mesh
from parisph.kernels import solids
from parisph.kernels.cells import nearby, neighbour_lists
from parisph.kernels.records import cloud_of, no_walls
from tests.pools import elements_near, mesh_of
from tests.wall_scenes import filled

S = 0.05


def block(*counts):
    """Return the elements of a closed tank of so many spacings, in any dimension."""
    return mesh_of(counts, spacing=S).corners()


def fluid(x, corners, lists=None):
    """Return the Cloud of fluid at points x, with neighbour lists if any are given, and the Walls near them."""
    x = np.atleast_2d(np.array(x, float))
    kind, lists = np.full(len(x), FLUID, np.int8), lists or (np.zeros(len(x) + 1, np.int32), np.zeros(0, np.int32))
    return cloud_of(x, kind, kind, np.zeros_like(x), *lists, S), elements_near(x, corners, 2.6 * S, S)


def walls_of(x, corners):
    """Return for each point the walls that nearest_walls finds: list of (away (dim,), distance)."""
    cloud, walls = fluid(x, corners)
    dim, found = len(cloud.axes), []
    away, member, places = np.empty((dim, dim + 1)), np.empty(dim, np.int64), solids.three_places(cloud.axes)
    for i in range(len(cloud.x)):
        count = solids.nearest_walls(away, member, places, i, cloud, walls, np.inf)
        found.append([(away[w, :dim].copy(), away[w, dim]) for w in range(count)])
    return found


@pytest.mark.parametrize("dim", [2, 3])
def test_nearby_finds_all_others_within_the_radius(dim):
    rng = np.random.default_rng(0)
    x, others = rng.random((200, dim)) * 1.4 - 0.2, rng.random((150, dim))
    indptr, indices = nearby(x, others, 0.17)
    near = np.linalg.norm(x[:, None] - others, axis=2) < 0.17
    for i in range(len(x)):
        assert sorted(indices[indptr[i] : indptr[i + 1]]) == np.flatnonzero(near[i]).tolist()
    assert nearby(x, others[:0], 0.1)[0].tolist() == [0] * 201


@pytest.mark.parametrize("dim", [2, 3])
def test_a_line_is_stopped_by_the_elements_that_it_crosses(dim):
    rng = np.random.default_rng(1)
    x, corners = rng.random((30, dim)), rng.random((6, dim, dim))
    indptr, indices = neighbour_lists(x, len(x), 3.0)
    cloud, walls = fluid(x, corners, (indptr, indices))
    every = np.arange(len(x) + 1, dtype=np.int32) * len(corners), np.tile(np.arange(6, dtype=np.int32), len(x))
    left = solids.seen_neighbours(cloud, walls._replace(indptr=every[0], indices=every[1]))
    seen, n = set(zip(np.repeat(np.arange(len(x)), np.diff(left[0])).tolist(), left[1].tolist())), len(left[1])
    owner = np.repeat(np.arange(len(x)), np.diff(indptr))
    for i, j in zip(owner, indices):
        # p + t (q - p) = the element's corner and its sides: solved at once for t and the place in the element
        stopped = False
        for c in corners:
            t, *place = np.linalg.solve(np.column_stack([x[i] - x[j], *(c[1:] - c[0])]), x[i] - c[0])
            stopped |= 0.0 < t < 1.0 and min(place) >= 0.0 and sum(place) <= 1.0
        assert ((i, j) in seen) != stopped
    assert 0.1 < n / len(indices) < 0.95


def test_plate_without_thickness_separates():
    scene = filled(StillWater(0.9), [Tank(2.0, 1.0), Plate([(1.025, 0.0), (1.025, 1.0)])], S)
    indptr, indices = scene.lists()
    owner = np.repeat(np.arange(len(scene.x)), np.diff(indptr))
    side = np.sign(scene.x[:, 0] + 0.1 * S * scene.normal[:, 0] - 1.025)
    tip = np.concatenate([np.zeros(scene.n), scene.mesh.edge]) == 2    # which looks out over both sides
    assert np.count_nonzero(tip) == 1
    assert np.all((side[owner] == side[indices]) | tip[owner] | tip[indices])
    on_plate = np.abs(scene.x[:, 0] - 1.025) < 1e-9
    assert np.all(np.diff(indptr)[on_plate & (scene.x[:, 1] < 0.8)] > 5)


@pytest.mark.parametrize("walls", [
    [Tank(2.0, 1.0), Obstacle(Box(0.5, 0.3, at=(0.7, 0.0)))],
    [Tank(2.0, 1.0), Obstacle(Polygon([(0.5, 0.0), (0.9, 0.2), (1.3, 0.2), (1.7, 0.0)]))],
    [Tank(2.0, 1.0), Plate([(0.63, 0.2), (1.1, 0.55)])],
])
def test_who_sees_whom_is_mutual_and_walls_see_their_fluid(walls):
    scene = filled(StillWater(0.9), walls, S)
    indptr, indices = scene.lists()
    owner = np.repeat(np.arange(len(scene.x)), np.diff(indptr))
    pairs = set(zip(owner.tolist(), indices.tolist()))
    assert pairs == {(j, i) for i, j in pairs}
    low = (scene.x[:, 1] < 0.7) & (np.concatenate([np.zeros(scene.n), scene.mesh.edge]) != 2)
    assert np.diff(indptr)[low].min() >= 5


@pytest.mark.parametrize("dim", [2, 3])
def test_lists_of_elements_hold_all_that_are_near(dim):
    corners = block(*(4,) * dim)
    x = np.random.default_rng(2).random((12, dim)) * 4 * S
    _, walls = fluid(x, corners)
    for i in range(len(x)):
        near = [e for e in range(len(corners)) if nearest(x[i : i + 1], corners[e : e + 1])[0][0] < 2.6 * S]
        listed = walls.indices[walls.indptr[i] : walls.indptr[i + 1]]
        assert sorted(listed) == near    # inside a block none hides another
    assert fluid(x, corners[:0])[1].indptr.tolist() == [0] * 13


UPRIGHT = Plate([(0.0, 0.0), (0.0, 1.0)])


@pytest.mark.parametrize(("body", "at", "nearest"), [
    (UPRIGHT, (0.03, 0.51), (0.0, 0.51)),    # its far side is in front of nobody
    (Obstacle(Box(1.0, 0.5)), (1.03, 0.54), (1.0, 0.5)),
    *((UPRIGHT, (x, 1.03), (0.0, 1.0)) for x in (0.0, 0.001, -0.001)),
])
def test_only_the_nearest_place_on_a_plate_a_corner_or_a_tip_counts(body, at, nearest):
    (wall,), = walls_of([at], wall_mesh([body], S).corners())
    away = np.subtract(at, nearest)
    np.testing.assert_allclose(wall[0], away / np.linalg.norm(away), atol=1e-9)
    assert wall[1] == pytest.approx(np.linalg.norm(away))


def test_flat_wall_and_corner_in_2d():
    corners = block(20, 20)
    flat, corner, behind = walls_of([(0.4, 0.03), (0.04, 0.02), (0.41, -0.01)], corners)
    assert len(flat) == 1 and len(corner) == 2
    np.testing.assert_allclose(flat[0][0], [0.0, 1.0], atol=1e-12)
    np.testing.assert_allclose([wall[0] for wall in corner], [[0.0, 1.0], [1.0, 0.0]], atol=1e-12)
    np.testing.assert_allclose([wall[1] for wall in corner], [0.02, 0.04])
    np.testing.assert_allclose(behind[0][0], [0.0, 1.0], atol=1e-12)
    assert behind[0][1] == pytest.approx(-0.01)


def test_edges_and_corners_in_3d():
    corners = block(6, 6, 6)
    walls, = walls_of([(0.04, 0.02, 0.031)], corners)
    np.testing.assert_allclose([wall[0] for wall in walls], np.eye(3)[[1, 2, 0]], atol=1e-12)
    np.testing.assert_allclose([wall[1] for wall in walls], [0.02, 0.031, 0.04])


def test_beyond_an_edge_that_no_other_element_shares_only_the_edge_counts():
    """Water over the rim of a tank is not drawn back into it; behind a corner it is."""
    side = np.array([[[0.0, 0.5], [0.0, 0.0]], [[0.0, 1.0], [0.0, 0.5]]])    # the left side, fluid to its right
    (wall,), = walls_of([(-0.03, 1.04)], side)
    np.testing.assert_allclose(wall[0], (-0.6, 0.8), atol=1e-9)
    assert wall[1] == pytest.approx(0.05)
    corner = np.array([[[0.0, 1.0], [0.0, 0.0]], [[0.0, 0.0], [1.0, 0.0]]])
    assert all(apart < 0.0 for _, apart in walls_of([(-0.03, -0.04)], corner)[0])


def test_depth_behind_the_nearest_wall():
    corners = block(20, 20)
    depth = np.empty(3)
    solids.depths(depth, *fluid(np.array([(0.5, -0.04), (0.5, 0.04), (0.02, -0.03)]), corners))
    np.testing.assert_allclose(depth, [0.04, 0.0, 0.03], atol=1e-12)


def test_moves_end_at_the_distance_from_the_wall():
    corners = block(20, 20)
    x = np.array([(0.5, 0.04), (0.03, 0.03), (0.5, 0.02), (0.5, 0.5)])
    move = np.array([(0.01, -0.03), (-0.02, -0.01), (0.0, -0.01), (0.0, -0.3)])
    solids.keep_off(move, *fluid(x, corners), 0.025)
    np.testing.assert_allclose(move, [(0.01, -0.015), (-0.005, -0.005), (0.0, 0.0), (0.0, -0.3)], atol=1e-12)


def test_guard_is_relative_to_the_wall():
    corners = block(20, 20)
    x = np.array([(0.5, 0.04), (0.5, 0.025), (0.5, 0.5)])
    cloud, walls = fluid(x, corners)
    u = np.array([(2.0, -5.0), (2.0, -1.2), (0.0, -9.0)])
    wall_u = np.tile([0.3, -1.0], (len(corners), 1))
    slowed = solids.guard(u, cloud, walls._replace(velocity=wall_u), 0.025, 0.01)
    assert slowed == 2
    np.testing.assert_allclose(u, [(2.0, -2.5), (2.0, -1.0), (0.0, -9.0)], rtol=1e-9)


@pytest.mark.parametrize(("walls", "nothing_hidden"), [
    ([Tank(2.0, 1.0)], True), ([Tank(2.0, 1.0, lid=True)], True),
    ([Tank(2.0, 1.0), Obstacle(Box(0.5, 0.3, at=(0.7, 0.0)))], False),
])
def test_in_an_open_room_the_quick_lists_are_the_full_ones(walls, nothing_hidden):
    scene = filled(StillWater(0.9), walls, S)
    cloud, near = scene.records()
    assert solids.is_open(cloud, near) == nothing_hidden
    lists = [np.empty(len(near.indices), np.int32) for _ in range(2)]
    ends = [np.empty_like(near.indptr) for _ in range(2)]
    none = np.empty(0, np.int32), near.indices
    count = [solids.keep_unhidden(ends[k], lists[k], cloud, near, 2.6 * S, bool(k), none) for k in range(2)]
    if nothing_hidden:
        np.testing.assert_array_equal(lists[0][:count[0]], lists[1][:count[1]])
        np.testing.assert_array_equal(solids.seen_neighbours(cloud, near)[1], cloud.indices)


def test_elements_in_one_plane_share_its_number():
    corners = block(4, 4, 4)
    numbers = solids.plane_numbers(corners, np.zeros(len(corners), np.int64), S)
    shapes = solids.shapes_of(corners, numbers)
    assert len(set(numbers)) == 6
    for number in range(6):
        plane = shapes.plane[numbers == number]
        np.testing.assert_allclose(plane, np.broadcast_to(plane[0], plane.shape), atol=1e-14)
    motion = (np.arange(len(corners)) % 2).astype(np.int64)    # what moves does not stay in the plane
    assert len(set(solids.plane_numbers(corners, motion, S))) == 12
    np.testing.assert_allclose(shapes.middle, corners.mean(axis=1), atol=1e-15)
    np.testing.assert_allclose(shapes.size, S * np.sqrt(5.0) / 3.0)    # of half a square


def test_known_lists_of_nodes_are_those_found_anew():
    scene = filled(StillWater(0.9), [Tank(2.0, 1.0), Obstacle(Box(0.5, 0.3, at=(0.7, 0.0)))], S)
    cloud, _ = scene.records()
    corners = scene.corners
    shapes = solids.shapes_of(corners, solids.plane_numbers(corners, np.zeros(len(corners), np.int64), S))
    near = no_walls(0, 2)._replace(corners=corners, shapes=shapes)
    indptr, indices = solids.near_lists(scene.x, shapes, 3.0 * S)
    near = near._replace(indptr=indptr, indices=indices)
    anew = solids.seen_elements(cloud, near, 2.6 * S, False)
    again = solids.seen_elements(cloud, near, 2.6 * S, False, (anew.indptr, anew.indices))
    np.testing.assert_array_equal(again.indptr, anew.indptr)
    np.testing.assert_array_equal(again.indices, anew.indices)
    without = solids.seen_elements(cloud, near, 2.6 * S, False, solids.no_lists(len(scene.x)))    # so they are taken
    walls = scene.kind == WALL
    assert not np.diff(without.indptr)[walls].any()
    np.testing.assert_array_equal(np.diff(without.indptr)[~walls], np.diff(anew.indptr)[~walls])


def test_lists_of_some_particles_are_replaced():
    indptr, indices = np.array([0, 2, 2, 5], np.int32), np.array([3, 4, 5, 6, 7], np.int32)
    found = solids.replaced(indptr, indices, np.array([0, 1]), np.array([0, 1, 3], np.int32),
                            np.array([8, 9, 1], np.int32))
    assert [list(one) for one in found] == [[0, 1, 3, 6], [8, 9, 1, 5, 6, 7]]
