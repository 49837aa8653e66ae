"""Wall meshes of 3D scenes: closed, exact, with the fluid on the right side, and the shares of corners."""

import numpy as np
import pytest

from parisph import (
    Airy,
    Box,
    Case,
    Disc,
    Fluid,
    Numerics,
    Obstacle,
    Piston,
    Plate,
    Polygon,
    Profile,
    StillWater,
    Sway,
    Tank,
)
from parisph.base.errors import CaseError
from parisph.geometry import extrusion
from parisph.geometry.build import scene_mesh, scene_motions
from parisph.geometry.distance import area_vectors
from parisph.geometry.layers import in_front
from parisph.geometry.mesh import CONCAVE, CONVEX, FLAT, rim_edges
from parisph.geometry.triangles import triangulated

S = 0.1
CLOSED = Tank(1.0, 1.0, breadth=0.8, lid=True)
COLUMN = Box(0.3, 0.2, breadth=0.4, at=(0.3, 0.2, 0.0))
DISC = Disc(0.2, at=(0.5, 0.5))
PLATE = ((0.5, 0.0), (0.5, 0.4))

# scenes: further walls in the closed tank, the volume that they take, and the area of both sides that they add
SCENES = {
    "alone": ((), 0.0, 0.0),
    "box on the bed": ((Obstacle(COLUMN),), 0.3 * 0.2 * 0.4, 1.4 * 0.2),
    "box at the front": ((Obstacle(COLUMN.model_copy(update={"at": (0.3, 0.0, 0.0)})),), 0.024, 2 * 0.08),
    "box across": ((Obstacle(Box(0.3, 0.2, at=(0.3, 0.0))),), 0.048, 2 * 0.2 * 0.8 - 2 * 0.06),
    "box in the water": ((Obstacle(Box(0.3, 0.2, breadth=0.4, at=(0.3, 0.2, 0.4))),), 0.024, 2 * (0.12 + 0.08 + 0.06)),
    "two boxes": ((Obstacle(COLUMN), Obstacle(Box(0.2, 0.4, breadth=0.2, at=(0.6, 0.4, 0.0)))), 0.024 + 0.016, None),
    "box on a box": ((Obstacle(COLUMN), Obstacle(Box(0.3, 0.2, breadth=0.2, at=(0.3, 0.3, 0.2)))), 0.036, None),
    "plate": ((Plate(PLATE, across=(0.2, 0.6)),), 0.0, 2 * 0.4 * 0.4),
    "plate across": ((Plate(PLATE),), 0.0, 2 * 0.4 * 0.8),
    "plate at the front": ((Plate(PLATE, across=(0.0, 0.4)),), 0.0, 2 * 0.4 * 0.4),
    "wedge": ((Obstacle(Polygon(((0.3, 0.0), (0.7, 0.0), (0.7, 0.3))), across=(0.2, 0.6)),), 0.024, None),
}


def scene(*walls, fluid=StillWater(0.5), spacing=S, **fields):
    return Case(title="Scene", fluid=Fluid(fluid, 1000.0), walls=walls, gravity=(0.0, -9.81),
                numerics=Numerics(spacing=spacing), end_time=1.0, **fields)


def node(mesh, *at):
    """Return the only node at a place."""
    found = np.flatnonzero(np.linalg.norm(mesh.x0 - np.array(at), axis=1) < 1e-9)
    assert len(found) == 1
    return int(found[0])


def enclosed(mesh):
    """Return the volume in front of a closed mesh, by the divergence theorem."""
    corners = mesh.corners()
    return -np.sum(corners.mean(axis=1) * area_vectors(corners)) / 3.0


def check_sound(case, mesh):
    """Elements have fluid in front; plates apart, none behind. Normals are units; nodes have the area of elements."""
    corners = mesh.corners()
    area = np.linalg.norm(area_vectors(corners), axis=1)
    unit, middle = area_vectors(corners) / area[:, None], corners.mean(axis=1)
    assert in_front(case, middle + 1e-3 * S * unit).all()
    thin = np.array([isinstance(case.bodies[body], Plate) for body in mesh.element_body])
    assert not in_front(case, middle - 1e-3 * S * unit)[~thin].any()
    np.testing.assert_allclose(np.linalg.norm(mesh.normal0, axis=1), 1.0, rtol=1e-12)
    np.testing.assert_allclose(mesh.area.sum(), area.sum(), rtol=1e-12)
    sides = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
    assert sides.max() < 2.2 * S
    assert np.array_equal(np.unique(mesh.elements), np.arange(len(mesh.x0)))


@pytest.mark.parametrize("name", SCENES)
def test_a_closed_scene_is_watertight_and_exact(name):
    walls, solid, area = SCENES[name]
    case = scene(CLOSED, *walls)
    mesh = scene_mesh(case)
    assert not len(rim_edges(mesh.elements)) and not mesh.ends.any()
    np.testing.assert_allclose(enclosed(mesh), 0.8 - solid, rtol=1e-12)
    np.testing.assert_allclose(mesh.vector_area.sum(axis=0), 0.0, atol=1e-12 * mesh.area.sum())
    if area is not None:
        np.testing.assert_allclose(mesh.area.sum(), 5.2 + area, rtol=1e-12)
    check_sound(case, mesh)


@pytest.mark.parametrize("across", [None, (0.2, 0.6)])
def test_a_cylinder_is_watertight_whatever_its_facets(across):
    case = scene(CLOSED, Obstacle(DISC, across=across))
    mesh = scene_mesh(case)
    assert not len(rim_edges(mesh.elements))
    np.testing.assert_allclose(mesh.vector_area.sum(axis=0), 0.0, atol=1e-12)
    round_ = mesh.corners()[mesh.element_body == 1]
    mantle = np.abs(area_vectors(round_)[:, 1]) < 1e-12
    length = 0.8 if across is None else 0.4
    perimeter = np.linalg.norm(area_vectors(round_[mantle]), axis=1).sum() / length
    facets = 13    # of a length near a spacing
    chord = 0.2 * 2.0 * facets * np.sin(np.pi / facets)
    np.testing.assert_allclose(perimeter, chord, rtol=1e-3)
    np.testing.assert_allclose(enclosed(mesh), 0.8 - length * 0.5 * 0.04 * facets * np.sin(2 * np.pi / facets),
                               rtol=1e-3)


def test_shares_and_edges_of_a_box_on_the_bed():
    mesh = scene_mesh(scene(CLOSED, Obstacle(COLUMN)))
    for at, share, edge in [
            ((0.0, 0.0, 0.0), 1 / 8, CONCAVE), ((1.0, 0.8, 1.0), 1 / 8, CONCAVE),      # corners of the tank
            ((0.1, 0.0, 0.0), 1 / 4, CONCAVE), ((0.0, 0.0, 0.4), 1 / 4, CONCAVE),      # its edges
            ((0.1, 0.0, 0.4), 1 / 2, FLAT), ((0.1, 0.2, 0.0), 1 / 2, FLAT),
            ((0.3, 0.2, 0.2), 7 / 8, CONVEX), ((0.6, 0.6, 0.2), 7 / 8, CONVEX),        # upper corners of the box
            ((0.4, 0.2, 0.2), 3 / 4, CONVEX), ((0.3, 0.4, 0.2), 3 / 4, CONVEX),        # its edges
            ((0.3, 0.2, 0.1), 3 / 4, CONVEX), ((0.4, 0.3, 0.2), 1 / 2, FLAT),
            ((0.4, 0.2, 0.1), 1 / 2, FLAT), ((0.3, 0.3, 0.1), 1 / 2, FLAT),
            ((0.4, 0.2, 0.0), 1 / 4, CONCAVE), ((0.3, 0.3, 0.0), 1 / 4, CONCAVE),      # its foot
            ((0.3, 0.2, 0.0), 3 / 8, CONVEX)]:                                         # and the foot of an edge
        k = node(mesh, *at)
        assert (mesh.share[k], mesh.edge[k]) == (pytest.approx(share, abs=1e-12), edge), at
        np.testing.assert_allclose(mesh.cell[k], S * S, rtol=1e-9)
    np.testing.assert_allclose(mesh.normal0[node(mesh, 0.0, 0.0, 0.0)], np.full(3, 3**-0.5), rtol=1e-12)
    np.testing.assert_allclose(mesh.normal0[node(mesh, 0.4, 0.2, 0.0)], [0.0, -(0.5**0.5), 0.5**0.5], atol=1e-12)
    np.testing.assert_allclose(mesh.normal0[node(mesh, 0.4, 0.2, 0.1)], [0.0, -1.0, 0.0], atol=1e-12)


def test_edges_of_a_plate():
    mesh = scene_mesh(scene(CLOSED, Plate(PLATE, across=(0.2, 0.6))))
    both = np.flatnonzero(np.linalg.norm(mesh.x0 - [0.5, 0.4, 0.2], axis=1) < 1e-9)
    assert sorted(mesh.normal0[both, 0].tolist()) == [-1.0, 1.0] and not mesh.edge[both].any()
    tip = node(mesh, 0.5, 0.2, 0.2)
    assert mesh.edge[tip] == CONVEX and mesh.share[tip] == 1.0 and mesh.normal0[tip].tolist() == [0.0, -1.0, 0.0]
    foot = np.flatnonzero(np.linalg.norm(mesh.x0 - [0.5, 0.4, 0.0], axis=1) < 1e-9)
    assert len(foot) == 2 and (mesh.edge[foot] == CONCAVE).all()
    np.testing.assert_allclose(mesh.share[foot], 0.25, rtol=1e-12)
    end = node(mesh, 0.5, 0.2, 0.0)
    assert mesh.edge[end] == CONVEX and mesh.share[end] == pytest.approx(0.5)


@pytest.mark.parametrize("lid", [False, True])
def test_a_tank_has_the_same_nodes_extruded_as_on_its_lattice(monkeypatch, lid):
    tank = Tank(1.0, 0.6, breadth=0.8, lid=lid, at=(0.1, -0.2, 0.3))
    lattice = scene_mesh(scene(tank))
    monkeypatch.setattr(extrusion, "_lone", lambda case: None)
    extrusion.extruded.cache_clear()
    mesh = scene_mesh(scene(tank))
    extrusion.extruded.cache_clear()
    assert len(mesh.x0) == len(lattice.x0)
    one, other = (np.lexsort(np.round(m.x0 / S, 3).T) for m in (mesh, lattice))
    for name in ("x0", "normal0", "share", "edge", "vector_area", "area"):
        np.testing.assert_allclose(getattr(mesh, name)[one], getattr(lattice, name)[other], atol=1e-12)
    below = (mesh.x0[one, 2] < 0.9 - 1e-9) | lid    # the rim has no water
    np.testing.assert_allclose(mesh.cell[one][below], lattice.cell[other][below], rtol=1e-12)
    assert np.array_equal(mesh.ends[one], lattice.ends[other])


def test_the_front_of_a_slope_is_as_high_as_its_walls_or_stands_above_the_water():
    beach = Profile(((0.0, 0.6), (0.0, 0.0), (1.0, 0.0), (2.0, 0.5)), breadth=0.5)
    mesh = scene_mesh(scene(beach, fluid=StillWater(0.3)))
    front = area_vectors(mesh.corners())[:, 1]
    np.testing.assert_allclose(front[front > 1e-12].sum(), 2.0 * 0.6 - 0.25, rtol=1e-12)
    np.testing.assert_allclose(front[front < -1e-12].sum(), -2.0 * 0.6 + 0.25, rtol=1e-12)
    assert len(np.unique(rim_edges(mesh.elements))) == mesh.ends.sum()
    toe = node(mesh, 1.0, 0.0, 0.0)
    np.testing.assert_allclose(mesh.share[toe], 0.5 * (np.pi - np.arctan(0.5)) / (2.0 * np.pi), rtol=1e-12)
    flat = scene_mesh(scene(Profile(((0.0, 0.0), (1.0, 0.0)), breadth=0.5), fluid=Box(0.4, 0.4)))
    assert flat.x0[:, 2].max() == pytest.approx(1.5 * 0.4)


def _of_corners(x):
    """Return the normals (n, 3) of a piston between front, back (y = 0, .5) and bed (z = 0)."""
    sides = np.stack([np.ones(len(x)), np.where(x[:, 1] == 0.0, 1.0, np.where(x[:, 1] == 0.5, -1.0, 0.0)),
                      np.where(x[:, 2] == 0.0, 1.0, 0.0)], axis=1)
    return sides / np.linalg.norm(sides, axis=1)[:, None]


def test_walls_that_move_have_a_mesh_and_a_motion_of_their_own():
    piston = Piston(0.0, wave=Airy(height=0.02, period=1.0, depth=0.3))
    case = scene(Profile(((-0.5, 0.6), (-0.5, 0.0), (2.0, 0.0), (2.0, 0.6)), breadth=0.5), piston,
                 fluid=StillWater(0.3))
    mesh = scene_mesh(case)
    face = mesh.body == 1
    assert [body.motion for body in mesh.bodies] == [0, 1] and len(scene_motions(case)) == 2
    assert np.all(mesh.x0[face, 0] == 0.0)
    np.testing.assert_allclose(mesh.normal0[face], _of_corners(mesh.x0[face]), atol=1e-12)
    np.testing.assert_allclose(mesh.area[face].sum(), 0.5 * 0.6, rtol=1e-12)
    speed = scene_motions(case)[1].velocity_at(mesh.x0[face], 0.3)
    assert np.all(speed[:, 1:] == 0.0) and np.all(speed[:, 0] == speed[0, 0]) and speed[0, 0] != 0.0


def test_a_body_that_moves_in_the_water_is_closed():
    case = scene(CLOSED, Obstacle(Box(0.2, 0.2, breadth=0.4, at=(0.4, 0.2, 0.4)), motion=Sway(0.05, frequency=1.0)))
    mesh = scene_mesh(case)
    assert not len(rim_edges(mesh.elements))
    np.testing.assert_allclose(enclosed(mesh), 0.8 - 0.016, rtol=1e-12)
    check_sound(case, mesh)


def test_a_front_needs_one_bed():
    two = (Profile(((0.0, 0.0), (1.0, 0.0)), breadth=0.5), Profile(((0.0, 1.0), (1.0, 1.0)), side="right"))
    with pytest.raises(CaseError, match="one bed from end to end.*join them, or give a Tank"):
        scene_mesh(scene(*two, fluid=Box(0.4, 0.4)))


def test_triangles_keep_every_edge_of_a_star():
    angle = np.arange(20) * np.pi / 10
    star = np.stack([np.cos(angle), np.sin(angle)], axis=1) * np.where(np.arange(20) % 2, 0.15, 1.0)[:, None]
    edges = np.stack([np.arange(20), (np.arange(20) + 1) % 20], axis=1)

    def inside(x):
        turn = np.arctan2(x[:, 1], x[:, 0]) % (np.pi / 5)
        near = np.minimum(turn, np.pi / 5 - turn)      # from a tip
        tip, notch = np.array([1.0, 0.0]), 0.15 * np.array([np.cos(np.pi / 10), np.sin(np.pi / 10)])
        at = np.linalg.norm(x, axis=1)[:, None] * np.stack([np.cos(near), np.sin(near)], axis=1)
        way = notch - tip
        return way[0] * (at[:, 1] - tip[1]) - way[1] * (at[:, 0] - tip[0]) > 0.0

    inner, triangles = triangulated(star, edges, inside, 0.1, "here")
    x = np.concatenate([star, inner])
    a, b, c = (x[triangles[:, k]] for k in range(3))
    area = 0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])
    assert (area > 0.0).all()
    np.testing.assert_allclose(area.sum(), 20 * 0.5 * 0.15 * np.sin(np.pi / 10), rtol=1e-12)
