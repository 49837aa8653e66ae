"""Meshes of triangles: solid angles, creases and normals at nodes; and which points are inside."""

import numpy as np
import pytest

from parisph.geometry.inside import floors, winding
from parisph.geometry.mesh import CONCAVE, CONVEX, FLAT, MeshBody
from parisph.geometry.triangle_mesh import edges_of, triangle_mesh
from tests.pools import mesh_of as block
from tests.triangles import box, sheet, sphere

ONE = (MeshBody("one"),)


def merged(corners):
    nodes, index = np.unique(np.round(corners.reshape(-1, 3), 12), axis=0, return_inverse=True)
    return nodes, index.reshape(-1, 3)


def mesh_of(corners):
    nodes, triangles = merged(corners)
    return triangle_mesh(nodes, triangles, np.zeros(len(triangles), np.int32), ONE)


def node(mesh, *at):
    return int(np.argmin(np.linalg.norm(mesh.x0 - np.array(at), axis=1)))


@pytest.mark.parametrize("lid", [False, True])
def test_tank_of_triangles_is_that_of_its_lattice(lid):
    lattice = block((4, 3, 2), lid)
    mesh = triangle_mesh(lattice.x0, lattice.elements, lattice.element_body, ONE)
    np.testing.assert_allclose(mesh.share, lattice.share, atol=1e-12)
    np.testing.assert_allclose(mesh.normal0, lattice.normal0, atol=1e-12)
    np.testing.assert_array_equal(mesh.edge, lattice.edge)
    assert mesh.area.sum() == pytest.approx(lattice.area.sum(), rel=1e-12)
    np.testing.assert_allclose(mesh.vector_area.sum(axis=0), lattice.vector_area.sum(axis=0), atol=1e-14)


def test_box_in_fluid_has_convex_edges_and_seven_eighths_at_its_corners():
    mesh = mesh_of(box((0.2, 0.3, 0.4)))
    np.testing.assert_allclose(mesh.share, 0.875, rtol=1e-12)
    assert np.all(mesh.edge == CONVEX)
    np.testing.assert_allclose(mesh.normal0[node(mesh, 0, 0, 0)], -np.ones(3) / np.sqrt(3.0), rtol=1e-12)


def test_foot_of_a_box_on_a_bed_is_convex_and_has_its_solid_angle():
    """The fluid at the foot of an upright edge is three quarters of the half space above the bed: 3/8."""
    bed = sheet(lambda x, y: 0.0 * x, (-0.1, -0.1), (0.2, 0.2), (3, 3))
    on_it = np.all((bed.mean(axis=1)[:, :2] > 0.0) & (bed.mean(axis=1)[:, :2] < 0.1), axis=1)
    sides = box((0.1, 0.1, 0.1))
    mesh = mesh_of(np.concatenate([bed[~on_it], sides[np.any(sides[:, :, 2] > 0.0, axis=1)]]))
    foot = node(mesh, 0, 0, 0)
    assert mesh.share[foot] == pytest.approx(0.375, rel=1e-12) and mesh.edge[foot] == CONVEX
    np.testing.assert_allclose(mesh.normal0[foot], np.array([-1.0, -1.0, 1.0]) / np.sqrt(3.0), rtol=1e-12)
    top = node(mesh, 0.1, 0, 0.1)
    assert mesh.share[top] == pytest.approx(0.875, rel=1e-12) and mesh.edge[top] == CONVEX


def test_long_concave_crease_has_the_angle_of_the_fluid():
    """A bed that rises by 45 degrees: the fluid has 135 of 360 degrees, also at the rim of the sheet."""
    mesh = mesh_of(sheet(lambda x, y: np.maximum(x, 0.0), (-0.2, 0.0), (0.2, 0.3), (4, 3)))
    toe = np.abs(mesh.x0[:, 0]) < 1e-12
    np.testing.assert_allclose(mesh.share[toe], 0.375, rtol=1e-12)
    np.testing.assert_allclose(mesh.share[~toe], 0.5, rtol=1e-12)
    assert np.all(mesh.edge[toe] == CONCAVE) and np.all(mesh.edge[~toe] == FLAT)


def test_sphere_is_smooth_and_its_normals_point_from_its_centre():
    mesh = mesh_of(sphere(3, 0.5))
    assert np.all(mesh.edge == FLAT)
    assert np.abs(np.sum(mesh.normal0 * mesh.x0, axis=1) / np.linalg.norm(mesh.x0, axis=1) - 1.0).max() < 2e-3
    np.testing.assert_allclose(mesh.vector_area.sum(axis=0), 0.0, atol=1e-14)


def test_octahedron_leaves_the_fluid_what_is_beside_its_sharp_corners():
    """The solid angle of a corner of an octahedron is 4 arcsin(1/3)."""
    mesh = mesh_of(sphere(0, 0.5))
    np.testing.assert_allclose(mesh.share, 1.0 - np.arcsin(1.0 / 3.0) / np.pi, rtol=1e-12)
    assert np.all(mesh.edge == CONVEX)


def test_node_belongs_to_the_body_with_most_of_its_wall():
    nodes, triangles = merged(sheet(lambda x, y: 0.0 * x, (0.0, 0.0), (2.0, 1.0), (2, 1)))
    body = np.where(nodes[triangles].mean(axis=1)[:, 0] > 1.0, 4, 1).astype(np.int32)
    mesh = triangle_mesh(nodes, triangles, body, ONE)
    np.testing.assert_array_equal(mesh.body[mesh.x0[:, 0] > 1.5], 4)
    np.testing.assert_array_equal(mesh.body[mesh.x0[:, 0] < 0.5], 1)


def test_more_than_two_triangles_at_an_edge_are_refused():
    with pytest.raises(ValueError, match="1 edges belong to more than two"):
        edges_of(np.array([(0, 1, 2), (1, 0, 3), (0, 1, 4)]))


def test_winding_number_counts_how_often_a_surface_surrounds_a_point():
    surface = np.concatenate([box((1.0, 1.0, 1.0)), sphere(2, 0.3, (0.5, 0.5, 0.5))])
    x = np.array([(0.5, 0.5, 0.5), (0.1, 0.1, 0.1), (1.5, 0.5, 0.5), (0.5, 0.5, -9.0)])
    np.testing.assert_allclose(winding(x, surface), [2, 1, 0, 0], atol=1e-12)


@pytest.mark.parametrize("cell", [0.02, 0.3, 5.0])
def test_floors_agree_with_winding_numbers_at_many_points(cell):
    """Normals into the fluid: outward of the sphere, inward of the room."""
    room = np.concatenate([box((1.0, 1.0, 1.0))[:, ::-1], sphere(3, 0.3, (0.5, 0.4, 0.3))])
    x = np.random.default_rng(3).uniform(-0.2, 1.2, (4000, 3))
    x = x[x[:, 2] < 1.0]
    np.testing.assert_array_equal(floors(x, room, cell), np.round(-winding(x, room)))


def test_floors_count_a_lattice_that_meets_edges_and_corners():
    room = np.concatenate([box((1.0, 1.0, 1.0))[:, ::-1], box((0.2, 0.2, 0.2), (0.4, 0.4, 0.0))])
    x = np.stack(np.meshgrid(*[np.arange(1, 10) / 10.0] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    away = np.max(np.abs(x - [0.5, 0.5, 0.1]), axis=1) > 0.1 + 1e-9
    inside = floors(x, room, 0.1)
    np.testing.assert_array_equal(inside[away], 1)
    assert inside[np.argmin(np.linalg.norm(x - [0.5, 0.5, 0.1], axis=1))] == 0


def test_point_above_the_rim_of_an_open_room_is_in_front_of_it():
    room = box((1.0, 1.0, 1.0))[:, ::-1]
    room = room[np.any(room[:, :, 2] < 1.0, axis=1)]
    np.testing.assert_array_equal(floors(np.array([(0.5, 0.5, 3.0), (1.5, 0.5, 3.0), (0.5, 0.5, -1.0)]), room, 0.1),
                                  [1, 0, 0])
