"""The room between solids: exact volumes and areas, bodies of triangles, and a mesh without holes."""

import numpy as np
import pytest

from parisph.base.errors import CaseError
from parisph.geometry.distance import area_vectors
from parisph.geometry.mesh import CONCAVE, CONVEX, FLAT, MeshBody
from parisph.geometry.room import Piece, prism, room_of
from parisph.geometry.surface_files import sound
from parisph.geometry.triangle_mesh import edges_of, triangle_mesh
from tests.triangles import LIBRARIES, box, sphere, volume

for name in LIBRARIES:
    pytest.importorskip(name, reason=f"{name} is not installed: pip install 'parisph[surfaces]'")

S = 0.1
BODIES = tuple(map(MeshBody, ("tank", "one", "other")))


def piece(places, body, limits=False):
    found = sound(places, "test")
    return Piece(found.points, found.corners, np.full(len(found.corners), body), limits)


def tank(size=(2.0, 1.0, 1.0), lid=False):
    found = piece(box(size), 0, limits=True)
    on_top = np.all(found.points[found.corners][:, :, 2] > size[2] - 1e-9, axis=1)
    found.body[on_top & (not lid)] = -1
    return found


def meshed(*pieces, spacing=S):
    room = room_of(pieces, spacing)
    return room, triangle_mesh(room.nodes, room.triangles, room.body, BODIES)


def area(mesh, body):
    corners = mesh.corners()[mesh.element_body == body]
    return float(np.linalg.norm(area_vectors(corners), axis=1).sum())


def test_box_on_the_bed_has_exact_volume_area_and_shares():
    room, mesh = meshed(tank(), piece(box((0.4, 0.3, 0.3), (0.8, 0.3, 0.0)), 1))
    assert room.volume == pytest.approx(2.0 - 0.036, rel=1e-12)
    assert area(mesh, 0) == pytest.approx(2.0 + 4.0 + 2.0 - 0.12, rel=1e-9)
    assert area(mesh, 1) == pytest.approx(0.12 + 2 * 0.3 * 0.7, rel=1e-9)
    np.testing.assert_allclose(mesh.vector_area.sum(axis=0), [0.0, 0.0, 2.0], atol=1e-12)
    shares = np.unique(np.round(mesh.share, 9))
    # corner of the tank, foot of its edges and upright ones, foot of the box, flat walls, edges and corners of the box
    np.testing.assert_allclose(shares, [0.125, 0.25, 0.375, 0.5, 0.75, 0.875], atol=1e-9)
    np.testing.assert_array_equal(mesh.edge == FLAT, np.abs(mesh.share - 0.5) < 1e-9)
    assert np.all(mesh.edge[mesh.share > 0.51] == CONVEX) and np.all(mesh.edge[mesh.share < 0.26] == CONCAVE)
    rim = edges_of(mesh.elements)
    assert np.all(mesh.x0[rim.nodes[rim.rim], 2] == 1.0)
    assert mesh.area.mean() == pytest.approx(S**2, rel=0.1)


def test_elements_are_about_a_spacing_long_and_face_the_fluid():
    room, mesh = meshed(tank(lid=True), piece(sphere(4, 0.3, (1.0, 0.5, 0.2)), 1))
    corners = mesh.corners()
    assert volume(corners) == pytest.approx(-room.volume, rel=3e-3)
    assert not edges_of(mesh.elements).rim.any()
    length = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2) / S
    assert 0.25 < length.min() and length.max() < 2.2
    middle = corners[mesh.element_body == 1].mean(axis=1)
    assert np.abs(np.linalg.norm(middle - [1.0, 0.5, 0.2], axis=1) - 0.3).max() < 0.02
    assert np.all(np.abs(corners[mesh.element_body == 0] - [1.0, 0.5, 0.5]).max(axis=(1, 2)) > 0.5 - 1e-9)


def test_sphere_leaves_the_volume_outside_it_and_its_inside_holds_the_rest():
    ball = sphere(5, 0.4, (1.0, 0.5, 0.5))
    assert room_of([tank(), piece(ball, 1)], S).volume == pytest.approx(2.0 - volume(ball), rel=1e-12)
    inside = room_of([tank(), piece(ball, 1, limits=True)], S)
    assert inside.volume == pytest.approx(volume(ball), rel=1e-12) and np.all(inside.body == 1)


def test_solids_that_overlap_count_once():
    boxes = [piece(box((0.4, 0.4, 0.4), (x, 0.2, 0.0)), body) for x, body in ((0.5, 1), (0.7, 2))]
    room = room_of([tank(), *boxes], S)
    assert room.volume == pytest.approx(2.0 - 0.6 * 0.4 * 0.4, rel=1e-12)


def test_prism_of_a_slope_has_its_volume():
    points, corners = prism(np.array([(0.0, 0.0), (2.0, 0.0), (2.0, 1.0)]), (-0.5, 1.0))
    assert volume(points[corners]) == pytest.approx(1.5, rel=1e-12)
    assert not edges_of(corners).rim.any()


def test_scene_without_room_is_refused():
    with pytest.raises(CaseError, match="no room is left for the fluid"):
        room_of([tank(), piece(box((3.0, 3.0, 3.0), (-0.5, -0.5, -0.5)), 1)], S)
