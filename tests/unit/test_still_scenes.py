"""Hydrostatic pressure solves the rows on any particles between any walls.

Rows are exact for linear fields, but for those at walls that are means, or mixed with them: these are made exact for
the pressure of water at rest.
"""

import numpy as np
import pytest

from parisph import Box, Disc, Polygon, Tank
from parisph.base.fields import CONTACT, DRY, INNER, WET
from parisph.case.bodies import Obstacle, Plate, Profile, StillWater
from parisph.geometry.mesh import CONVEX
from parisph.kernels import balance, rankine, walls
from parisph.kernels.circle import Circle
from parisph.kernels.nearest_walls import keep_off
from parisph.kernels.records import DivergenceRows, Rows
from parisph.methods import lengths
from tests.wall_scenes import filled

S = 0.05


def beach(degrees):
    return [Profile([(0.0, 1.2), (0.0, 0.0), (1.0, 0.0), (1.0 + 0.9 / np.tan(np.radians(degrees)), 0.9)])]


SCENES = {
    "slope 15": beach(15.0), "slope 30": beach(30.0), "slope 60": beach(60.0),
    "sill": [Tank(3.0, 1.2), Obstacle(Polygon([(0.5, 0.0), (1.1, 0.3), (1.6, 0.3), (2.2, 0.0)]))],
    "box": [Tank(2.02, 1.2), Obstacle(Box(0.63, 0.32, at=(0.713, 0.0)))],
    "disc": [Tank(2.02, 1.2), Obstacle(Disc(0.2, at=(1.0, 0.33)))],
    "plate": [Tank(2.02, 1.2), Plate([(1.02, 0.0), (1.13, 0.5)])],
}


def lowest_values(values, indptr, count):
    return np.array([values[first:first + k].min(initial=0.0) for first, k in zip(indptr, count)])


def buffers(scene, role):
    """Return empty Rows and the Cloud of a scene."""
    cloud, _ = scene.records()
    n, nnz = len(scene.x), len(cloud.indices)
    rows = Rows(np.zeros(n, np.int32), np.zeros(nnz, np.int32), np.zeros(nnz), np.zeros(n))
    return rows, cloud._replace(role=role)


def error(scene, level):
    """Return the greatest error of the pressure over that at the bed, and how many wall rows lack a normal derivative.

    level : (n,) height of the water over each particle [m]
    """
    s, n, above = scene.spacing, len(scene.x), scene.x[:, 1] - level
    role = scene.role.copy()
    node = np.arange(n) >= scene.n
    role[node] = np.select([scene.mesh.edge == CONVEX, above[node] < -0.5 * s, above[node] < 0.5 * s],
                           [DRY, WET, CONTACT], DRY)
    rows, cloud = buffers(scene, role)
    (count, columns, values, measure), indptr = rows, cloud.indptr
    flux = DivergenceRows(count, columns, np.zeros((len(columns), 2)), np.zeros(n))
    circle = Circle(rankine.directions(2), lengths.CIRCLE * s, lengths.MLS * s)
    rankine.rankine_rows(rows, flux, cloud, np.zeros((n, 2)), circle, True)
    walls.sfdi_rows(rows, cloud, lengths.MLS * s)
    matrix, right = np.eye(n), np.where(role == WET, measure * scene.normal[:, 1], 0.0)
    before, lowest = right.copy(), lowest_values(values, indptr, count)
    balance.add_linear_part_at_walls(right, rows, cloud, np.tile([0.0, -1.0], (n, 1)), 1.0)
    mended = (measure == 0.0) | (lowest < 1e-9 - walls.UNSOUND)
    np.testing.assert_array_equal(right[~mended], before[~mended], "a normal derivative needs no mending")
    for i in np.flatnonzero((role == INNER) | (role == WET)):
        own = slice(indptr[i], indptr[i] + count[i])
        np.subtract.at(matrix[i], columns[own], values[own])
    p = np.linalg.solve(matrix, right)
    solved = (role == INNER) | (role == WET)
    return np.abs(p + above)[solved].max() / level.max(), np.count_nonzero((role == WET) & (measure == 0.0))


@pytest.mark.parametrize("name", SCENES)
def test_pressure_of_still_water(name):
    level = 0.8
    scene = filled(StillWater(level), SCENES[name], S)
    water = np.full(len(scene.x), level)
    assert error(scene, water) == (pytest.approx(0.0, abs=1e-12), 0)
    scene.pack()
    assert error(scene, water) == (pytest.approx(0.0, abs=1e-12), 0)
    move = np.zeros_like(scene.x)
    inner = scene.role == INNER
    move[inner] = 0.4 * S * (np.random.default_rng(2).random((np.count_nonzero(inner), 2)) - 0.5)
    keep_off(move, *scene.records(), 0.5 * S)
    scene.x += move
    assert error(scene, water) == (pytest.approx(0.0, abs=1e-12), 0)


def test_means_in_the_tip_of_a_flat_beach_are_exact_for_still_water():
    # a wedge of 2.3 degrees, less than a spacing deep: some rows have no normal derivative
    scene = filled(StillWater(0.4), [Profile([(0.0, 1.2), (0.0, 0.0), (0.5, 0.0), (23.0, 0.9)])], S)
    found, means = error(scene, np.full(len(scene.x), 0.4))
    assert found == pytest.approx(0.0, abs=1e-12) and means > 1


def test_exact_wall_rows_stay_as_they_are():
    scene = filled(StillWater(0.8), SCENES["box"], S)
    n, s = len(scene.x), scene.spacing
    role = np.where((np.arange(n) >= scene.n) & (scene.x[:, 1] < 0.7), WET, INNER).astype(scene.role.dtype)
    rows, cloud = buffers(scene, role)
    walls.sfdi_rows(rows, cloud, lengths.MLS * s)
    right = np.random.default_rng(1).random(n)
    before = right.copy()
    balance.add_linear_part_at_walls(right, rows, cloud, np.tile([3.0, -9.81], (n, 1)), 1000.0)
    lowest = lowest_values(rows.values, cloud.indptr, rows.count)
    exact = (role == WET) & (rows.measure > 0.0) & (lowest > 1e-9 - walls.UNSOUND)
    assert np.count_nonzero(exact) > 50 and np.count_nonzero(role == WET) - np.count_nonzero(exact) < 10
    np.testing.assert_array_equal(right[exact | (role != WET)], before[exact | (role != WET)])


def test_plate_without_thickness_holds_back_the_higher_water():
    levels, at = (0.8, 0.4), 1.0
    scene = filled((Box(at, levels[0]), Box(at, levels[1], at=(at, 0.0))),
                   [Tank(2.0, 1.2), Plate([(at, 0.0), (at, 1.2)])], S)
    right = scene.x[:, 0] + 0.1 * S * scene.normal[:, 0] > at
    assert error(scene, np.where(right, *levels[::-1])) == (pytest.approx(0.0, abs=1e-12), 0)
