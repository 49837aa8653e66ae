"""Distance from elements, side, winding number."""

import numpy as np
import pytest

from parisph import Box, Disc, Polygon, Tank
from parisph.case.bodies import Obstacle, Plate, Profile
from parisph.geometry.distance import area_vectors, nearest
from parisph.geometry.mesh import wall_mesh
from parisph.geometry.solid import in_fluid
from tests.distances import signed_distance
from tests.pools import mesh_of

S = 0.05
SCENES = {
    "sill": [Tank(3.0, 1.0), Obstacle(Polygon([(1.0, 0.0), (1.2, 0.2), (1.8, 0.2), (2.0, 0.0)]))],
    "lid and disc": [Tank(3.0, 1.0, lid=True), Obstacle(Disc(0.3, at=(1.5, 0.5)))],
    "sharp wedge": [Tank(3.0, 1.0), Obstacle(Polygon([(1.0, 0.2), (2.0, 0.5), (1.0, 0.25)]))],
    "beach": [Profile([(0.0, 1.0), (0.0, 0.0), (1.0, 0.0), (3.0, 1.0)])],
}


def points(n, seed=0):
    return np.random.default_rng(seed).random((n, 2)) * [3.4, 1.4] - 0.2


@pytest.mark.parametrize("scene", SCENES)
def test_sign_is_that_of_the_outlines(scene):
    walls = SCENES[scene]
    corners = wall_mesh(walls, S).corners()
    x = points(4000)
    x = x[x[:, 1] < 0.99]    # higher up an open wall ends, and the nearest element of another decides
    signed = signed_distance(x, corners)
    off = np.abs(signed) > 0.1 * S    # a disc of chords has another edge
    np.testing.assert_array_equal(signed[off] > 0.0, in_fluid(walls, x)[off])
    assert np.count_nonzero(off) > 3000


@pytest.mark.parametrize("scene", SCENES)
def test_distance_is_the_least_of_all_samples(scene):
    corners = wall_mesh(SCENES[scene], S).corners()
    x = points(300, seed=1)
    distance, element, foot = nearest(x, corners)
    t = np.linspace(0.0, 1.0, 401)[:, None, None]
    samples = (corners[:, 0] + t * (corners[:, 1] - corners[:, 0])).reshape(-1, 2)
    least = np.array([np.linalg.norm(samples - p, axis=1).min() for p in x])
    np.testing.assert_allclose(distance, least, atol=2e-4 * S + 1e-9, rtol=1e-3)
    np.testing.assert_allclose(np.linalg.norm(x - foot, axis=1), distance, rtol=1e-12)
    assert element.min() >= 0


def test_far_points_are_left_out():
    corners = wall_mesh(SCENES["sill"], S).corners()
    x = points(1000)
    all_, near = nearest(x, corners), nearest(x, corners, within=2.0 * S)
    inside = all_[0] <= 2.0 * S
    np.testing.assert_array_equal(near[0][inside], all_[0][inside])
    np.testing.assert_array_equal(near[1] >= 0, inside)
    assert np.all(np.isinf(near[0][~inside])) and 0 < np.count_nonzero(inside) < 900


def test_plate_has_fluid_on_both_sides():
    corners = wall_mesh([Plate([(1.0, 0.0), (1.0, 1.0)])], S).corners()
    x = points(1000)
    assert np.all(signed_distance(x, corners) >= 0.0)
    distance, element, foot = nearest(np.array([[0.9, 0.5], [1.1, 0.5]]), corners)
    np.testing.assert_allclose(area_vectors(corners[element])[:, 0], [-S, S], rtol=1e-12)


def test_block_in_3d():
    mesh, size = mesh_of((6, 5, 4)), np.array([0.6, 0.5, 0.4])
    rng = np.random.default_rng(3)
    x = rng.random((500, 3)) * (size + 0.4) - 0.2
    below, above = x.min(axis=1), (size - x).min(axis=1)
    inside = (below > 0.0) & (above > 0.0)
    outside = np.maximum(np.maximum(-x, x - size), 0.0)
    expected = np.where(inside, np.minimum(below, above), -np.linalg.norm(outside, axis=1))
    np.testing.assert_allclose(signed_distance(x, mesh.corners()), expected, atol=1e-12)


def test_box_around_a_point_has_the_nearest_face():
    corners = wall_mesh([Tank(1.0, 1.0, lid=True), Obstacle(Box(0.2, 0.2, at=(0.4, 0.4)))], S).corners()
    distance, element, foot = nearest(np.array([[0.5, 0.75], [0.1, 0.5]]), corners)
    np.testing.assert_allclose(distance, [0.15, 0.1], rtol=1e-12)
    np.testing.assert_allclose(foot, [[0.5, 0.6], [0.0, 0.5]], atol=1e-12)


@pytest.mark.parametrize("seed", range(12))
def test_any_pile_of_boxes_is_one_solid(seed):
    """Boxes at any angle, and every other at a round place, so that some of them touch."""
    rng = np.random.default_rng(seed)
    walls = [Tank(3.0, 2.0, lid=bool(seed % 2))]
    for k in range(rng.integers(1, 5)):
        w, h = np.round(rng.uniform(0.3, 1.2, 2), 1)
        angle = rng.choice([0.0, 0.25 * np.pi, rng.uniform(0.0, 3.0)])
        at = rng.uniform(0.0, [3.0, 2.0])
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        corners = np.array([(-w, -h), (w, -h), (w, h), (-w, h)]) / 2 @ turn.T + (np.round(at, 1) if k % 2 else at)
        walls.append(Obstacle(Polygon([tuple(corner) for corner in corners.tolist()])))
    x = rng.uniform([-0.1, -0.1], [3.1, 1.99], (1500, 2))
    signed = signed_distance(x, wall_mesh(walls, S).corners())
    np.testing.assert_array_equal(signed > 0.0, in_fluid(walls, x))
