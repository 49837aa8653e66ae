"""The nearest walls of a particle, and what keeps fluid off them, in 2D and 3D."""

import numpy as np
import pytest

from parisph import Box
from parisph.case.bodies import Obstacle, Plate
from parisph.geometry.mesh import wall_mesh
from parisph.kernels import nearest_walls
from tests.pools import mesh_of
from tests.wall_scenes import fluid

S = 0.05
UPRIGHT = Plate([(0.0, 0.0), (0.0, 1.0)])


def block(*counts):
    """Return the elements of a closed tank of so many spacings, in any dimension."""
    return mesh_of(counts, spacing=S).corners()


def walls_of(x, corners):
    """Return for each point the walls that nearest_walls finds: list of (away (dim,), distance)."""
    cloud, walls = fluid(x, corners, S)
    dim, found = len(cloud.axes), []
    away, member, places = np.empty((dim, dim + 1)), np.empty(dim, np.int64), nearest_walls.three_places(cloud.axes)
    for i in range(len(cloud.x)):
        count = nearest_walls.nearest_walls(away, member, places, i, cloud, walls, np.inf)
        found.append([(away[w, :dim].copy(), away[w, dim]) for w in range(count)])
    return found


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
    nearest_walls.depths(depth, *fluid(np.array([(0.5, -0.04), (0.5, 0.04), (0.02, -0.03)]), corners, S))
    np.testing.assert_allclose(depth, [0.04, 0.0, 0.03], atol=1e-12)


def test_moves_end_at_the_distance_from_the_wall():
    corners = block(20, 20)
    x = np.array([(0.5, 0.04), (0.03, 0.03), (0.5, 0.02), (0.5, 0.5)])
    move = np.array([(0.01, -0.03), (-0.02, -0.01), (0.0, -0.01), (0.0, -0.3)])
    nearest_walls.keep_off(move, *fluid(x, corners, S), 0.025)
    np.testing.assert_allclose(move, [(0.01, -0.015), (-0.005, -0.005), (0.0, 0.0), (0.0, -0.3)], atol=1e-12)


def test_guard_is_relative_to_the_wall():
    corners = block(20, 20)
    x = np.array([(0.5, 0.04), (0.5, 0.025), (0.5, 0.5)])
    cloud, walls = fluid(x, corners, S)
    u = np.array([(2.0, -5.0), (2.0, -1.2), (0.0, -9.0)])
    wall_u = np.tile([0.3, -1.0], (len(corners), 1))
    slowed = nearest_walls.guard(u, cloud, walls._replace(velocity=wall_u), 0.025, 0.01)
    assert slowed == 2
    np.testing.assert_allclose(u, [(2.0, -2.5), (2.0, -1.0), (0.0, -9.0)], rtol=1e-9)
