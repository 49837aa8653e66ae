"""Lines of sight past walls, and the lists of elements near particles, in 2D and 3D."""

import numpy as np
import pytest

from parisph import Box, Polygon, Tank
from parisph.base.fields import WALL
from parisph.case.bodies import Obstacle, Plate, StillWater
from parisph.geometry import build
from parisph.geometry.distance import nearest
from parisph.kernels import sight
from parisph.kernels.cells import neighbour_lists
from parisph.kernels.elements import plane_numbers, shapes_of
from parisph.kernels.records import no_walls
from tests.pools import mesh_of
from tests.scenes import water
from tests.wall_scenes import filled, fluid

S = 0.05


@pytest.mark.parametrize("dim", [2, 3])
def test_a_line_is_stopped_by_the_elements_that_it_crosses(dim):
    rng = np.random.default_rng(1)
    x, corners = rng.random((30, dim)), rng.random((6, dim, dim))
    indptr, indices = neighbour_lists(x, len(x), 3.0)
    cloud, walls = fluid(x, corners, S, (indptr, indices))
    every = np.arange(len(x) + 1, dtype=np.int32) * len(corners), np.tile(np.arange(6, dtype=np.int32), len(x))
    left = sight.seen_neighbours(cloud, walls._replace(indptr=every[0], indices=every[1]))
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
    corners = mesh_of((4,) * dim, spacing=S).corners()
    x = np.random.default_rng(2).random((12, dim)) * 4 * S
    _, walls = fluid(x, corners, S)
    for i in range(len(x)):
        near = [e for e in range(len(corners)) if nearest(x[i : i + 1], corners[e : e + 1])[0][0] < 2.6 * S]
        listed = walls.indices[walls.indptr[i] : walls.indptr[i + 1]]
        assert sorted(listed) == near    # inside a block none hides another
    assert fluid(x, corners[:0], S)[1].indptr.tolist() == [0] * 13


@pytest.mark.parametrize(("walls", "nothing_hidden"), [
    ([Tank(2.0, 1.0)], True), ([Tank(2.0, 1.0, lid=True)], True),
    ([Tank(2.0, 1.0), Obstacle(Box(0.5, 0.3, at=(0.7, 0.0)))], False),
])
def test_in_an_open_room_the_quick_lists_are_the_full_ones(walls, nothing_hidden):
    scene = filled(StillWater(0.9), walls, S)
    cloud, near = scene.records()
    assert sight.is_open(cloud, near) == nothing_hidden
    lists = [np.empty(len(near.indices), np.int32) for _ in range(2)]
    ends = [np.empty_like(near.indptr) for _ in range(2)]
    none = np.empty(0, np.int32), near.indices
    count = [sight.keep_unhidden(ends[k], lists[k], cloud, near, 2.6 * S, bool(k), none) for k in range(2)]
    if nothing_hidden:
        np.testing.assert_array_equal(lists[0][:count[0]], lists[1][:count[1]])
        np.testing.assert_array_equal(sight.seen_neighbours(cloud, near)[1], cloud.indices)


def test_known_lists_of_nodes_are_those_found_anew():
    scene = filled(StillWater(0.9), [Tank(2.0, 1.0), Obstacle(Box(0.5, 0.3, at=(0.7, 0.0)))], S)
    cloud, _ = scene.records()
    corners = scene.corners
    shapes = shapes_of(corners, plane_numbers(corners, np.zeros(len(corners), np.int64), S))
    near = no_walls(0, 2)._replace(corners=corners, shapes=shapes)
    indptr, indices = sight.near_lists(scene.x, shapes, 3.0 * S)
    near = near._replace(indptr=indptr, indices=indices)
    anew = sight.seen_elements(cloud, near, 2.6 * S, False)
    again = sight.seen_elements(cloud, near, 2.6 * S, False, (anew.indptr, anew.indices))
    np.testing.assert_array_equal(again.indptr, anew.indptr)
    np.testing.assert_array_equal(again.indices, anew.indices)
    without = sight.seen_elements(cloud, near, 2.6 * S, False, sight.no_lists(len(scene.x)))    # so they are taken
    walls = scene.kind == WALL
    assert not np.diff(without.indptr)[walls].any()
    np.testing.assert_array_equal(np.diff(without.indptr)[~walls], np.diff(anew.indptr)[~walls])


def test_lists_of_some_particles_are_replaced():
    indptr, indices = np.array([0, 2, 2, 5], np.int32), np.array([3, 4, 5, 6, 7], np.int32)
    found = sight.replaced(indptr, indices, np.array([0, 1]), np.array([0, 1, 3], np.int32),
                           np.array([8, 9, 1], np.int32))
    assert [list(one) for one in found] == [[0, 1, 3, 6], [8, 9, 1, 5, 6, 7]]


def test_rounding_does_not_change_what_is_seen_beside_a_box():
    """The nearest points of many elements lie in the box's edges, where lines to them would end in other elements."""
    lower, size = np.array([0.4, 0.2, 0.0]), np.array([0.2, 0.3, 0.2])
    box = Obstacle(Box(0.2, 0.2, breadth=0.3, at=tuple(lower)))
    corners = build.scene_mesh(water((1.4, 0.4), (Tank(1.4, 0.6, breadth=0.7), box), 2.0 * S)).corners()
    x = np.random.default_rng(4).random((6000, 3)) * [0.6, 0.7, 0.4] + [0.2, 0.0, 0.0]
    x = x[((x < lower) | (x > lower + size)).any(axis=1)]
    due = fluid(x, corners, 2.0 * S)[1]
    for way in np.concatenate([np.eye(3), -np.eye(3)]):
        found = fluid(x * (1.0 + 2.3e-16 * way), corners, 2.0 * S)[1]
        np.testing.assert_array_equal(found.indptr, due.indptr)
        np.testing.assert_array_equal(found.indices, due.indices)
