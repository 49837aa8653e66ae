"""Voronoi cells of particles in the plane."""

import numpy as np
import pytest

from parisph.kernels.cells import neighbour_lists
from parisph.kernels.voronoi import cell_areas


def areas(x, reach, chosen=None, n=None):
    n = len(x) if n is None else n
    indptr, indices = neighbour_lists(x, n, reach)
    area = np.full(n, np.nan)
    cell_areas(area, np.ones(n, bool) if chosen is None else chosen, x, reach, indptr, indices)
    return area


def periodic(x, side, reach):
    """Return x followed by its copies around the square of this side, out to the reach."""
    copies = [x] + [x + side * np.array([a, b]) for a in (-1, 0, 1) for b in (-1, 0, 1) if (a, b) != (0, 0)]
    everything = np.concatenate(copies)
    near = np.all((everything > -reach) & (everything < side + reach), axis=1)
    near[: len(x)] = True
    return everything[near]


def lattice(side, jitter, seed=0):
    x = np.stack(np.meshgrid(np.arange(side), np.arange(side)), axis=-1).reshape(-1, 2) + 0.5
    return x + jitter * (np.random.default_rng(seed).random(x.shape) - 0.5)


def clipped(x, i):
    """Return the area of the cell of x[i], by cutting a large square with every bisector."""
    polygon = 50.0 * np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])
    for d in np.delete(x, i, axis=0) - x[i]:
        side = polygon @ d - 0.5 * d @ d
        kept = []
        for a, b, p, q in zip(side, np.roll(side, -1), polygon, np.roll(polygon, -1, axis=0)):
            if a <= 0.0:
                kept.append(p)
            if a * b < 0.0:
                kept.append(p + a / (a - b) * (q - p))
        polygon = np.array(kept)
    px, py = polygon.T
    return 0.5 * (px @ np.roll(py, -1) - py @ np.roll(px, -1))


@pytest.mark.parametrize("spacing", [1.0, 0.0125])
def test_cells_of_a_lattice(spacing):
    x = spacing * lattice(9, 0.0)
    inside = np.all((x > 2.1 * spacing) & (x < 6.9 * spacing), axis=1)
    np.testing.assert_allclose(areas(x, 2.6 * spacing, inside)[inside], spacing**2, rtol=1e-12)


@pytest.mark.parametrize("jitter", [0.4, 0.8, 1.2, 2.0])
def test_cells_fill_the_plane(jitter):
    side, reach = 12, 5.0
    x = periodic(lattice(side, jitter), side, reach)
    area = areas(x, reach, n=side * side)
    assert np.all(area > 0.0) and area.sum() == pytest.approx(side * side, rel=1e-12)
    assert np.std(area) > 0.02


@pytest.mark.parametrize("jitter", [0.8, 2.0])
def test_cells_against_brute_force(jitter):
    x = lattice(11, jitter, seed=4)
    area = areas(x, 6.0)
    closed = np.flatnonzero(area > 0.0)
    assert len(closed) > 30
    for i in closed[::3]:
        assert area[i] == pytest.approx(clipped(x, i), rel=1e-11)


def test_open_cells_are_zero():
    x = lattice(9, 0.4)
    area = areas(x, 2.6)
    rim = np.any((x < 1.1) | (x > 7.9), axis=1)
    assert np.count_nonzero(rim) >= 30 and np.all(area[rim] == 0.0)
    assert areas(x[:1], 2.6)[0] == 0.0 and np.all(areas(x[:3], 2.6) == 0.0)


def test_cell_that_the_lists_cannot_close_is_zero():
    # closed by neighbours at two spacings: their bisectors meet beyond half the reach
    x = np.array([(0.0, 0.0), (2.0, 0.0), (0.0, 2.0), (-2.0, 0.0), (0.0, -2.0)])
    assert areas(x, 2.6)[0] == 0.0
    assert areas(x, 2.9)[0] == pytest.approx(4.0, rel=1e-12)


def test_only_chosen_cells_are_measured():
    x = lattice(9, 0.4)
    chosen = np.arange(81) % 2 == 0
    some, every = areas(x, 2.6, chosen), areas(x, 2.6)
    np.testing.assert_array_equal(some[chosen], every[chosen])
    assert np.all(some[~chosen] == 0.0)


@pytest.mark.parametrize("count", [12, 60, 400])
def test_cell_with_more_corners_than_fit_is_given_up(count):
    angle = 2.0 * np.pi * np.arange(count) / count
    x = np.vstack([[0.0, 0.0], np.stack([np.cos(angle), np.sin(angle)], axis=1)])
    area = areas(x, 2.6, np.arange(count + 1) == 0)[0]
    exact = 0.25 * count * np.tan(np.pi / count)
    assert area == (0.0 if count == 400 else pytest.approx(exact, rel=1e-9))
