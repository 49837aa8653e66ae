"""Wall meshes: the nodes of a tank as the product has them; bodies that touch, overlap or stand alone."""

import numpy as np
import pytest

from parisph import Box, Case, Disc, Fluid, Numerics, Polygon, Tank
from parisph.base.errors import CaseError
from parisph.base.fields import WALL
from parisph.case.bodies import Obstacle, Plate, Profile
from parisph.geometry.build import build
from parisph.geometry.distance import area_vectors, unit_normals
from parisph.geometry.mesh import CONCAVE, CONVEX, FLAT, wall_mesh
from parisph.geometry.solid import in_fluid, solid_of
from tests.pools import mesh_of as block

S = 0.1


def mesh_of(*walls, spacing=S):
    return wall_mesh(walls, spacing)


def node(mesh, *at):
    """Return the numbers of the nodes at a place."""
    return np.flatnonzero(np.linalg.norm(mesh.x0 - np.array(at), axis=1) < 1e-9)


def check_sides(mesh, walls, off=0.01):
    """Every element has fluid on its left and none, but for plates, on its right; nodes of an element are near."""
    corners = mesh.corners()
    length = np.linalg.norm(area_vectors(corners), axis=1)
    assert length.max() < 1.5 * S
    middle, unit = corners.mean(axis=1), unit_normals(corners)
    assert in_fluid(walls, middle + off * S * unit).all()
    solid = np.array([not solid_of(walls[number]).two_sided for number in mesh.element_body])
    assert not in_fluid(walls, middle - off * S * unit)[solid].any()
    np.testing.assert_allclose(np.linalg.norm(mesh.normal0, axis=1), 1.0, rtol=1e-12)
    np.testing.assert_allclose(mesh.area.sum(), length.sum(), rtol=1e-12)


@pytest.mark.parametrize("lid", [False, True])
@pytest.mark.parametrize(("size", "spacing", "at"), [
    ((1.0, 0.6), 0.1, (0.0, 0.0)), ((3.22, 1.0), 0.02, (0.3, -0.7)), ((1.0, 1.0), 1 / 30, (0.0, 0.0))])
def test_tank_has_the_wall_particles_of_the_product_to_the_bit(lid, size, spacing, at):
    tank = Tank(*size, lid=lid, at=at)
    case = Case(title="Tank", fluid=Fluid(Box(size[0], 4 * spacing, at=at), 1000.0), walls=tank, gravity=(0.0, -9.81),
                numerics=Numerics(spacing=spacing), end_time=1.0)
    arrays = build(case)
    wall = arrays["kind"] == WALL
    mesh = mesh_of(tank, spacing=spacing)
    assert mesh.x0.tobytes() == arrays["x"][wall].tobytes()
    assert mesh.normal0.tobytes() == arrays["normal"][wall].tobytes()
    np.testing.assert_array_equal((mesh.edge == CONCAVE) | mesh.ends, arrays["corner"][wall] == 1)
    assert not np.any(mesh.edge == CONVEX)
    if spacing == 0.1:
        check_sides(mesh, [tank])


@pytest.mark.parametrize("lid", [False, True])
def test_block_in_3d_has_the_area_and_the_normals_of_its_faces(lid):
    mesh = block((4, 3, 2), lid)
    vectors = area_vectors(mesh.corners())
    faces = 0.01 * (2 * 6 + 2 * 8 + (1 + lid) * 12)
    assert np.linalg.norm(vectors, axis=1).sum() == pytest.approx(faces)
    assert mesh.area.sum() == pytest.approx(faces)
    inside = mesh.corners().mean(axis=1) + 0.01 * unit_normals(mesh.corners())
    assert ((inside > 0.0) & (inside < [0.4, 0.3, 0.2])).all()
    np.testing.assert_allclose(mesh.vector_area.sum(axis=0), vectors.sum(axis=0), atol=1e-14)
    assert sorted(set(mesh.share.tolist())) == [0.125, 0.25, 0.5]


def test_slope_has_one_node_at_its_toe_with_the_summed_normal():
    walls = [Profile([(0.0, 0.0), (1.0, 0.0), (2.0, 1.0)])]
    mesh = mesh_of(*walls)
    check_sides(mesh, walls)
    assert len(mesh.x0) == 1 + 10 + 14
    toe = node(mesh, 1.0, 0.0)
    assert toe.size == 1 and mesh.edge[toe[0]] == CONCAVE
    np.testing.assert_allclose(mesh.normal0[toe[0]], [-np.sin(np.pi / 8), np.cos(np.pi / 8)], rtol=1e-12)
    assert mesh.share[toe[0]] == pytest.approx(0.375)
    assert np.all(mesh.edge[[0, -1]] == FLAT) and np.all(mesh.share[[0, -1]] == 0.5)


def test_profile_given_from_right_to_left_is_the_same():
    points = [(0.0, 0.0), (1.0, 0.0), (2.0, 1.0)]
    np.testing.assert_array_equal(mesh_of(Profile(points)).x0, mesh_of(Profile(points[::-1])).x0)


@pytest.mark.parametrize("order", [1, -1])
def test_obstacle_has_convex_corners_whichever_way_round_it_is_given(order):
    walls = [Obstacle(Polygon([(0.0, 0.0), (1.0, 0.0), (1.0, 0.5), (0.0, 0.5)][::order]))]
    mesh = mesh_of(*walls)
    check_sides(mesh, walls)
    assert len(mesh.x0) == 30
    assert np.count_nonzero(mesh.edge == CONVEX) == 4
    corner = node(mesh, 1.0, 0.5)[0]
    np.testing.assert_allclose(mesh.normal0[corner], np.sqrt([0.5, 0.5]), rtol=1e-12)
    assert mesh.share[corner] == pytest.approx(0.75)


def test_disc_is_smooth_and_has_its_area():
    walls = [Obstacle(Disc(0.5, at=(2.0, 1.0)))]
    mesh = mesh_of(*walls)
    check_sides(mesh, walls, off=0.03)    # the middle of a chord is that far inside
    assert len(mesh.x0) == 31 and np.all(mesh.edge == FLAT)
    away = mesh.x0 - [2.0, 1.0]
    np.testing.assert_allclose(np.linalg.norm(away, axis=1), 0.5, rtol=2e-4)
    np.testing.assert_allclose(mesh.normal0, away / np.linalg.norm(away, axis=1)[:, None], atol=0.02)


def test_obstacle_on_the_floor_shares_its_feet_and_hides_the_floor_below():
    walls = [Tank(3.0, 1.0), Obstacle(Polygon([(1.0, 0.0), (1.2, 0.2), (1.8, 0.2), (2.0, 0.0)]), name="sill")]
    mesh = mesh_of(*walls)
    check_sides(mesh, walls)
    assert [body.name for body in mesh.bodies] == ["tank", "sill"]
    for x in (1.0, 2.0):
        foot = node(mesh, x, 0.0)
        assert foot.size == 1 and mesh.edge[foot[0]] == CONCAVE
        assert mesh.share[foot[0]] == pytest.approx(0.375)
    on_floor = mesh.x0[np.abs(mesh.x0[:, 1]) < 1e-12, 0]
    assert not np.any((on_floor > 1.01) & (on_floor < 1.99))
    assert len(mesh.elements) == len(mesh.x0) - 1


def test_overlapping_obstacles_are_one_solid():
    walls = [Tank(3.0, 2.0), Obstacle(Box(1.0, 0.5, at=(1.0, -0.2))), Obstacle(Box(0.4, 0.9, at=(1.3, 0.1)))]
    mesh = mesh_of(*walls)
    check_sides(mesh, walls)
    assert np.count_nonzero(mesh.edge == CONVEX) == 4    # two of each box
    assert np.count_nonzero(mesh.edge == CONCAVE) == 2 + 2 + 2
    inside = (mesh.x0 > [1.31, -0.1]).all(axis=1) & (mesh.x0 < [1.69, 0.29]).all(axis=1)
    assert not inside.any()


def test_obstacle_on_a_slope():
    slope = Profile([(0.0, 0.0), (1.0, 0.0), (3.0, 1.0)])
    block = Obstacle(Polygon([(1.8, 0.2), (1.8, 0.8), (2.2, 0.8), (2.2, 0.3)]))    # its foot is below the slope
    mesh = mesh_of(slope, block)
    check_sides(mesh, [slope, block])
    assert node(mesh, 1.8, 0.4).size == node(mesh, 2.2, 0.6).size == 1


def test_plate_has_two_faces_and_a_node_at_each_tip():
    walls = [Plate([(0.0, 0.0), (0.0, 1.0)])]
    mesh = mesh_of(*walls)
    check_sides(mesh, walls)
    assert len(mesh.x0) == 20 == len(mesh.elements)
    for y in (0.1, 0.5):
        both = node(mesh, 0.0, y)
        assert both.size == 2
        np.testing.assert_allclose(mesh.normal0[both].sum(axis=0), 0.0, atol=1e-15)
    for y, up in ((0.0, -1.0), (1.0, 1.0)):
        tip = node(mesh, 0.0, y)
        assert tip.size == 1 and mesh.edge[tip[0]] == CONVEX and mesh.share[tip[0]] == 1.0
        np.testing.assert_allclose(mesh.normal0[tip[0]], [0.0, up])


def test_plate_on_the_floor_has_a_node_on_each_side_of_its_foot():
    walls = [Tank(2.0, 1.0), Plate([(1.0, 0.0), (1.0, 0.6)])]
    mesh = mesh_of(*walls)
    check_sides(mesh, walls)
    feet = node(mesh, 1.0, 0.0)
    assert feet.size == 2 and np.all(mesh.edge[feet] == CONCAVE)
    np.testing.assert_allclose(np.sort(mesh.normal0[feet, 0]), np.sqrt(0.5) * np.array([-1.0, 1.0]), rtol=1e-12)


def test_plate_from_floor_to_lid_makes_two_basins():
    walls = [Tank(2.0, 1.0, lid=True), Plate([(1.0, 0.0), (1.0, 1.0)])]
    mesh = mesh_of(*walls)
    check_sides(mesh, walls)
    assert not np.any(mesh.edge == CONVEX)
    assert np.count_nonzero(mesh.edge == CONCAVE) == 8


def test_boxes_side_by_side_have_no_wall_between_them():
    walls = [Obstacle(Box(1.0, 0.5)), Obstacle(Box(1.0, 0.5, at=(1.0, 0.0)))]
    mesh = mesh_of(*walls)
    check_sides(mesh, walls)
    between = (np.abs(mesh.x0[:, 0] - 1.0) < 1e-9) & (mesh.x0[:, 1] > 0.01) & (mesh.x0[:, 1] < 0.49)
    assert not between.any()
    assert mesh.edge[node(mesh, 1.0, 0.5)[0]] == FLAT
    assert mesh.area.sum() == pytest.approx(5.0)


def test_tank_that_nothing_touches_keeps_its_lattice():
    tank = Tank(3.0, 1.0)
    alone = mesh_of(tank)
    mesh = mesh_of(Obstacle(Box(0.3, 0.3, at=(1.0, 0.4))), tank)
    own = mesh.body == 1
    assert mesh.x0[own].tobytes() == alone.x0.tobytes()
    assert set(mesh.body[mesh.elements[mesh.element_body == 1]].ravel()) == {1}
    assert np.count_nonzero(~own) == 12


def test_bodies_that_leave_no_wall_are_refused():
    with pytest.raises(CaseError, match="walls: no fluid touches any of"):
        wall_mesh([Obstacle(Box(5.0, 5.0)), Tank(2.0, 2.0, at=(1.0, 1.0), lid=True)], S)


def test_inside_of_every_open_outline():
    beach = solid_of(Profile([(0.0, 0.0), (5.0, 0.0), (10.0, 1.0)]))
    x = np.array([(-3.0, 0.5), (5.0, 5.0), (9.0, 0.9), (9.0, 0.7), (12.0, 1.3), (12.0, 1.5), (-3.0, -0.1)])
    assert beach.in_front(x).tolist() == [True, True, True, False, False, True, False]
    tank = solid_of(Tank(2.0, 1.0))
    x = np.array([(1.0, 0.5), (1.0, 7.0), (0.01, 1.0), (-0.01, 1.0), (1.0, -0.1), (3.0, 9.0)])
    assert tank.in_front(x).tolist() == [True, True, True, False, False, False]
    wall = solid_of(Profile([(1.0, 0.0), (1.0, 2.0)], side="left"))
    assert wall.in_front(np.array([(0.0, 1.0), (2.0, 1.0), (0.9, 8.0)])).tolist() == [True, False, True]
