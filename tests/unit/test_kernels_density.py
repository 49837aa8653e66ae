"""Density beside walls of any shape, completed by nodes and elements."""

import numpy as np
import pytest

from parisph import Box, Disc, Polygon, Tank
from parisph.base.fields import INNER, SURFACE, WALL
from parisph.case.bodies import Obstacle, Plate, Profile, StillWater
from parisph.geometry.mesh import wall_mesh
from parisph.kernels.cells import neighbour_lists
from parisph.kernels.jit import axes_of
from parisph.kernels.surface import lattice_sum
from tests.distances import signed_distance
from tests.pools import mesh_of
from tests.wall_scenes import beside, filled

S, H = 0.05, 0.065


def tank_of(*counts):
    """Return the Scene of a closed tank full of the lattice, in any dimension."""
    index = np.stack(np.meshgrid(*[np.arange(1, n) for n in counts], indexing="ij"), axis=-1).reshape(-1, len(counts))
    return beside(mesh_of(counts, spacing=S), S * index, S)


def solid_alone(scene):
    """Leave out all particles: what remains is the kernel's integral over the solids."""
    scene.weight[:], scene.area[:] = 0.0, 0.0
    return scene.alpha() * lattice_sum(S, H, axes_of(scene.dim)) * S**scene.dim


def integral(solid, at, reach=2.0 * H):
    """Return the kernel's integral over the places for which solid(x) is true, by many samples (2D)."""
    cell = S / 400    # places between multiples of it, so that no cell is cut by the axes
    low, high = np.floor((np.array(at) - reach) / cell), np.ceil((np.array(at) + reach) / cell)
    places = np.meshgrid(*[np.arange(a, b) for a, b in zip(low, high)], indexing="ij")
    x = cell * (0.5 + np.stack(places, axis=-1).reshape(-1, 2))
    r = np.linalg.norm(x - at, axis=1)
    q = r / H
    w = 15.0 / (7.0 * np.pi * H**2) * np.where(q < 1.0, 2 / 3 - q**2 + q**3 / 2, np.maximum(2.0 - q, 0.0) ** 3 / 6)
    return np.sum(w[solid(x)]) * cell**2


@pytest.mark.parametrize(("counts", "flat", "corner"), [((12, 12), 1e-5, 1e-3), ((7, 7, 7), 5e-4, 3e-3)])
def test_lattice_in_a_full_tank(counts, flat, corner):
    scene = tank_of(*counts)
    error, pull = np.abs(scene.alpha() - 1.0), np.linalg.norm(scene.gradient(), axis=1) * S
    x = scene.x[: scene.n] / S
    near = np.sum((x < 2.61) | (np.array(counts) - x < 2.61), axis=1)
    assert error[near == 1].max() < flat
    assert error.max() < corner
    assert pull[near == 1].max() < 10 * flat and pull.max() < 2.5 * corner
    assert error[near == 0].max() < 1e-12


def test_fluid_half_a_spacing_from_the_walls_has_no_node_beside_it():
    mesh = wall_mesh([Tank(1.0, 1.0, lid=True)], S)
    k = S * (np.arange(20) + 0.5)
    scene = beside(mesh, np.stack(np.meshgrid(k, k, indexing="ij"), axis=-1).reshape(-1, 2), S)
    crowded = np.abs(scene.alpha() - 1.0).max()
    scene.weight[scene.kind == WALL] = 0.0
    scene.area *= -0.5
    assert np.abs(scene.alpha() - 1.0).max() < 5e-3 < 0.3 < crowded
    assert np.linalg.norm(scene.gradient(), axis=1).max() * S < 0.01


@pytest.mark.parametrize(("at", "solid", "most"), [
    *(((10.0 + along, height), lambda x: x[:, 1] < 0.0, 1e-3 if height < 0.5 else 1e-4)
      for along in (0.0, 0.31, 0.5) for height in (0.3, 0.5, 0.77, 1.0, 1.5, 2.2)),
    *((at, lambda x: x.min(axis=1) < 0.0, 2e-4) for at in ((0.5, 0.5), (1.0, 1.0), (0.7, 1.6))),
])
def test_solid_behind_a_flat_wall_and_around_a_concave_corner(at, solid, most):
    at = S * np.array([at])
    found = solid_alone(beside(wall_mesh([Tank(1.0, 1.0)], S), at, S))[0]
    assert found == pytest.approx(integral(solid, at[0]), abs=most)


def test_solid_and_its_shadow_at_a_convex_corner():
    mesh = wall_mesh([Obstacle(Box(1.0, 1.0, at=(-1.0, -1.0)))], S)
    at = S * np.array([[0.8, 0.6], [-0.6, 0.7]])
    found = solid_alone(beside(mesh, at, S))
    box = integral(lambda x: x.max(axis=1) < 0.0, at[0])
    assert found[0] == pytest.approx(box, abs=2e-4)
    slope = at[1, 1] / -at[1, 0]    # from beside the corner, the box hides what is below the line through its corner
    hidden = integral(lambda x: (x[:, 1] < 0.0) & ((x[:, 0] < 0.0) | (x[:, 1] < -slope * x[:, 0])), at[1])
    assert found[1] == pytest.approx(hidden, abs=2e-4)


def test_gradient_is_the_slope_of_the_sum():
    scene = filled(StillWater(0.9), [Tank(1.0, 1.0)], S)
    rng = np.random.default_rng(4)
    scene.x[: scene.n] += 0.3 * S * (rng.random((scene.n, 2)) - 0.5)
    gradient = scene.gradient()
    for i in rng.choice(np.flatnonzero(scene.x[: scene.n].min(axis=1) < 2.5 * S), 12):
        step = 1e-4 * S
        for axis in range(2):
            values = []
            for sign in (1.0, -1.0):
                scene.x[i, axis] += sign * step
                values.append(scene.alpha()[i])
                scene.x[i, axis] -= sign * step
            assert (values[0] - values[1]) / (2.0 * step) * S == pytest.approx(gradient[i, axis] * S, abs=4e-3)


def test_box_on_the_lattice_has_the_density_of_the_lattice():
    scene = filled(StillWater(1.0), [Tank(3.0, 1.2), Obstacle(Box(0.6, 0.4, at=(1.2, 0.0)))], S)
    deep = scene.x[: scene.n, 1] < 1.0 - 2.65 * S
    alpha = scene.alpha()[deep]
    assert 0.999 < alpha.min() and alpha.max() < 1.003
    assert np.linalg.norm(scene.gradient()[deep], axis=1).max() * S < 0.01


def test_plate_hides_the_water_behind_it():
    scene = filled(StillWater(1.0), [Tank(2.0, 1.2), Plate([(1.0, 0.0), (1.0, 1.2)])], S)
    deep = scene.x[: scene.n, 1] < 1.0 - 2.65 * S
    before = scene.alpha()[: scene.n]
    np.testing.assert_allclose(before[deep], 1.0, atol=1e-3)
    scene.x[: scene.n][scene.x[: scene.n, 0] > 1.0, 0] += 5.0    # what is behind the plate goes elsewhere
    left = deep & (scene.x[: scene.n, 0] < 1.0)
    np.testing.assert_array_equal(scene.alpha()[left], before[left])


def packed(scene):
    """Pack a scene; return the density ratio of what is deep below the level."""
    scene.pack()
    return scene.alpha()[scene.x[: scene.n, 1] < scene.level - 2.65 * S]


def sill(slope):
    foot = 0.4 / slope
    corners = [(1.0, 0.0), (1.0 + foot, 0.4), (1.6 + foot, 0.4), (1.6 + 2.0 * foot, 0.0)]
    return [Tank(4.0, 1.3), Obstacle(Polygon(corners))]


def beach(degrees):
    return [Profile([(0.0, 1.3), (0.0, 0.0), (1.5, 0.0), (1.5 + 1.2 / np.tan(np.radians(degrees)), 1.2)])]


@pytest.mark.parametrize(("walls", "low", "high"), [
    (beach(15.0), 0.98, 1.02), (beach(30.0), 0.98, 1.02), (beach(45.0), 0.99, 1.03), (beach(60.0), 0.99, 1.025),
    (sill(1.0), 0.99, 1.02), (sill(0.5), 0.98, 1.01),
    ([Tank(3.02, 1.3), Obstacle(Disc(0.2, at=(1.5, 0.5)))], 0.97, 1.015)],
    ids=["slope 15", "slope 30", "slope 45", "slope 60", "sill 45", "sill 26.6", "disc"])
def test_packed_scene_is_even(walls, low, high):
    scene = filled(StillWater(1.0), walls, S)
    start = scene.x.copy()
    alpha = packed(scene)
    assert low < alpha.min() and alpha.max() < high
    fixed = scene.role != INNER
    np.testing.assert_array_equal(scene.x[fixed], start[fixed])
    assert np.all(scene.x[: scene.n][scene.role[: scene.n] == SURFACE, 1] == 1.0)
    near = (start[: scene.n, 1] > 1.0 - 2.05 * S)
    np.testing.assert_array_equal(scene.x[: scene.n][near, 1], start[: scene.n][near, 1])
    assert signed_distance(scene.x[: scene.n], scene.corners).min() > 0.49 * S


def test_packing_leaves_the_lattice_of_a_tank():
    scene = filled(StillWater(1.0), [Tank(2.0, 1.3)], S)
    start = scene.x.copy()
    packed(scene)
    assert np.abs(scene.x - start).max() < 0.015 * S
    deep = start[:, 1] < 1.0 - 3.0 * S
    assert np.abs(scene.x - start)[deep].max() < 0.01 * S


def test_lists_reach_as_far_as_the_kernel():
    scene = filled(Box(1.0, 0.5), [Tank(1.0, 1.0)], S)
    indptr, indices = scene.lists()
    every = neighbour_lists(scene.x, len(scene.x), 2.6 * S)
    np.testing.assert_array_equal(indptr, every[0])    # in a tank all see each other
    np.testing.assert_array_equal(indices, every[1])
