"""Volumes that particles represent now: cells between walls and the free surface."""

import numpy as np
import pytest

from parisph.base.fields import BALLISTIC, DRY, FLUID, INNER, SURFACE, WALL, WET
from parisph.kernels.cells import neighbour_lists
from parisph.kernels.records import cloud_of, no_walls
from parisph.kernels.volumes import current_volumes
from tests.unit.test_kernels_interior import area_of, clipped, lattice

OPEN = (np.full(2, -np.inf), np.full(2, np.inf))


def volumes_of(x, role, walls=OPEN, kind=None, reach=2.6):
    """Return the volumes of points (n, 2) with a spacing of 1."""
    x, role = np.asarray(x, float), np.array(role, np.int8)
    kind = np.full(len(x), FLUID, np.int8) if kind is None else kind
    indptr, indices = neighbour_lists(x, len(x), reach)
    out = np.full(len(x), np.nan)
    cloud, lower, upper = cloud_of(x, kind, role, x, indptr, indices, 1.0), *(np.array(w, float) for w in walls)
    current_volumes(out, cloud, no_walls(len(x), 2), np.empty((0, 2), bool), lower, upper, reach)
    return out


def box_of(side, jitter, role=WET):
    """Return points, kinds and roles of a full box with walls of wall particles, and where they are."""
    fluid = lattice(side - 1, jitter, seed=5) + 0.5
    along = np.arange(side + 1.0)
    walls = np.unique(np.concatenate([np.stack([a, b], axis=1) for c in (0.0, float(side)) for a, b in (
        (along, np.full(side + 1, c)), (np.full(side + 1, c), along))]), axis=0)
    x = np.concatenate([fluid, walls])
    kind = np.repeat(np.array([FLUID, WALL], np.int8), (len(fluid), len(walls)))
    return x, kind, np.repeat([INNER, role], (len(fluid), len(walls))), (np.zeros(2), np.full(2, float(side)))


def test_on_the_lattice_they_are_those_of_the_start():
    """3/2 cells beside a wall, 9/4 in a corner, and so for a box of any disorder exactly all of it."""
    x, kind, role, walls = box_of(8, 0.0)
    found = volumes_of(x, role, walls, kind)
    beside = np.sum((x == 1.0) | (x == 7.0), axis=1)
    np.testing.assert_allclose(found, np.where(kind == FLUID, 1.5**beside, 0.0), rtol=1e-14)


def test_each_cell_in_a_box_against_brute_force():
    """The cell among all fluid particles and their images in the walls."""
    side = 8
    x, kind, role, walls = box_of(side, 0.4)
    found, fluid = volumes_of(x, role, walls, kind)[kind == FLUID], x[kind == FLUID]
    for i, at in enumerate(fluid):
        images = [np.where(np.arange(2) == a, 2.0 * wall - at, at) for a in (0, 1) for wall in (0.0, side)]
        truth = area_of(clipped(np.concatenate([fluid, images]), i))
        assert found[i] == pytest.approx(truth, rel=1e-11)
    assert found.sum() == pytest.approx(side**2, rel=1e-12)


def test_a_dry_wall_bounds_nothing():
    x, kind, role, walls = box_of(8, 0.0, role=DRY)
    role[kind == FLUID] = SURFACE
    found = volumes_of(x, role, walls, kind)
    assert found.sum() == pytest.approx(36.0)      # between the outermost particles


@pytest.mark.parametrize("shear", [0.0, 0.3, -0.7])
def test_a_sheared_box_without_walls_has_its_area(shear):
    """The surface passes through the particles on it; disorder inside changes no sum."""
    side = 12
    x = lattice(side, 0.0)
    edge = np.any((x == 0.5) | (x == side - 0.5), axis=1)
    x[~edge] += 0.4 * (np.random.default_rng(1).random((np.count_nonzero(~edge), 2)) - 0.5)
    x[:, 0] += shear * x[:, 1]
    found = volumes_of(x, np.where(edge, SURFACE, INNER))
    assert found.sum() == pytest.approx((side - 1) ** 2, rel=1e-12)
    # the first moment: particles are not the centres of their cells, with an error of second order in the spacing
    centre = 0.5 * side
    assert found @ x[:, 1] / found.sum() == pytest.approx(centre, rel=0.3 / side**2)


def test_triangles_are_fluid_if_they_are_small():
    """The cells of an obtuse triangle add up to its area; particles in no triangle keep a cell of the lattice."""
    acute = np.array([[0.0, 0.0], [1.0, 0.0], [0.5, 0.9]])
    obtuse = np.array([[0.0, 0.0], [1.2, 0.0], [0.5, 0.35]])
    for x in (acute, obtuse):
        assert volumes_of(x, [SURFACE] * 3).sum() == pytest.approx(0.5 * x[1, 0] * x[2, 1], rel=1e-14)
    np.testing.assert_array_equal(volumes_of(2.0 * acute, [SURFACE] * 3), 1.0)


def test_drops_and_threads_keep_cells_of_the_lattice():
    x = np.array([[0.0, 0.0], [10.0, 0.0], [11.0, 0.0], [12.0, 0.0]])
    np.testing.assert_array_equal(volumes_of(x, [BALLISTIC] + [SURFACE] * 3), 1.0)
    np.testing.assert_array_equal(volumes_of([[3.0, 3.0], [3.0, 3.0]], [SURFACE] * 2), 1.0)     # at one place
