"""Volumes of particles by the places nearest to them."""

import numpy as np
import pytest

from parisph import Box, Disc, Polygon, Tank
from parisph.case.bodies import Obstacle, Plate, Profile, StillWater
from parisph.geometry.fill import Filling
from parisph.geometry.quadrature import fluid_area, samples
from parisph.kernels import packing
from parisph.kernels.cells import nearest_points

S = 0.05


BOX = (-1.0, -1.0), (5.0, 2.0)


def volumes(x, fill, *scene):
    return packing.volumes(x, samples(fill, *scene), S)


BASIN = Profile([(0.0, 1.2), (0.0, 0.0), (1.0, 0.0), (3.4, 1.2)])
SILL = Obstacle(Polygon([(1.0, 0.0), (1.23, 0.2), (1.8, 0.2), (2.0, 0.0)]))


@pytest.mark.parametrize(("shape", "walls", "holes", "area"), [
    (StillWater(0.83), [BASIN], (), 0.83 + 0.83**2),
    (StillWater(0.713), [Tank(3.01, 1.0)], (), 0.713 * 3.01),
    (StillWater(0.713), [Tank(3.01, 1.0), SILL], (), 0.713 * 3.01 - 0.5 * 0.2 * (1.0 + 0.57)),
    (StillWater(0.1), [Tank(3.01, 1.0), SILL], (), 0.1 * 3.01 - 0.1 * (1.0 - 0.05 * (0.23 + 0.2) / 0.2)),
    (StillWater(0.9), [Tank(3.0, 1.0), Obstacle(Disc(0.3, at=(1.5, 0.5)))], (), 2.7 - np.pi * 0.09),
    (StillWater(0.9), [Tank(3.0, 1.0), Plate([(1.31, 0.2), (1.5, 0.7)])], (), 2.7),
    (Box(1.0, 0.6), [Tank(2.0, 1.0)], (), 0.6),
    (Box(1.5, 1.0), [Tank(2.0, 1.0)], (Disc(0.2, at=(0.7, 0.5)),), 1.5 - np.pi * 0.04),
    (Disc(0.52, at=(1.0, 0.8)), [], (), np.pi * 0.52**2),
    (Polygon([(0.32, 0.1), (1.9, 0.4), (0.8, 0.9), (0.7, 0.45)]), [], (), None),
])
def test_sum_is_the_area_of_the_fluid(shape, walls, holes, area):
    fill = Filling(shape, walls, S, holes)
    v = volumes(fill.position(fill.indices()), fill, *BOX)
    area = shape.area if area is None else area
    assert v.sum() == pytest.approx(area, rel=2e-4)
    assert fluid_area(fill, *BOX) == pytest.approx(area, rel=2e-4)
    assert v.min() > 0.0


def test_particles_of_a_tank_stand_for_their_cells():
    fill = Filling(Box(1.0, 0.6), [Tank(2.0, 1.0)], S)
    x = fill.position(fill.indices())
    v = volumes(x, fill, *BOX)
    beside = np.isclose(x[:, 0], S) + 0.0 + np.isclose(x[:, 1], S)    # next to a wall: 3/2 cells
    free = np.isclose(x[:, 0], 1.0) + 0.0 + np.isclose(x[:, 1], 0.6)   # on the surface: 1/2
    np.testing.assert_allclose(v, S**2 * 1.5**beside * 0.5**free, rtol=1e-9)


def test_moved_particles_have_what_is_nearest():
    rng = np.random.default_rng(0)
    x = rng.random((40, 2)) * [1.0, 0.6]
    v = volumes(x, Filling(Box(1.0, 0.6), [], S), (0.0, 0.0), (1.0, 0.6))
    places = (np.stack(np.meshgrid(np.arange(500), np.arange(300), indexing="ij"), axis=-1).reshape(-1, 2) + 0.5) / 500
    nearest = np.argmin(((places[:, None] - x) ** 2).sum(axis=2), axis=1)
    np.testing.assert_allclose(v, np.bincount(nearest, minlength=40) / 500**2, atol=6e-4)


def test_a_rank_finds_for_its_own_particles_what_one_rank_finds():
    fill = Filling(StillWater(0.83), [BASIN], S)
    x = fill.position(fill.indices())
    whole = volumes(x, fill, (0.0, 0.0), (4.0, 1.0))
    for low in (0.0, 1.0, 2.0):
        near = (x[:, 0] > low - 4.0 * S) & (x[:, 0] < low + 1.0 + 4.0 * S)
        own = (x[near, 0] >= low) & (x[near, 0] < low + 1.0)
        found = volumes(x[near], fill, (0.0, 0.0), (4.0, 1.0), (low - 2.0 * S, low + 1.0 + 2.0 * S))
        np.testing.assert_allclose(found[own], whole[near][own], rtol=1e-12)


@pytest.mark.parametrize("dim", [2, 3])
def test_nearest_points_are_those_of_all(dim):
    rng = np.random.default_rng(7)
    x, places = rng.random((150, dim)), rng.random((400, dim)) * 2.0 - 0.5
    apart = np.linalg.norm(places[:, None] - x, axis=2)
    np.testing.assert_array_equal(nearest_points(x, places, 0.1), np.argmin(apart, axis=1))
    np.testing.assert_array_equal(nearest_points(x[:1], places, 0.1), 0)
    with pytest.raises(ValueError, match="there is no point"):
        nearest_points(x[:0], places, 0.1)
