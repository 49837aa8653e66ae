"""ISPH_R rows: the Laplacian from the mean over a circle or a sphere, and the flux divergence."""

import numpy as np
import pytest

from parisph.base.fields import CONTACT, DRY, INNER, SURFACE, WALL
from parisph.kernels import rankine
from parisph.kernels.circle import Circle
from parisph.kernels.smoothing import quartic_weight
from tests.pools import Rows, block, dims, free, monomials, tank

jitters = pytest.mark.parametrize("jitter", [0.0, 0.4, 0.8, 1.2])
CIRCLE, MLS = 0.5, 2.1


def filled(pool, u=None, normalised=True, count=None):
    rows = Rows(pool)
    s = pool.spacing
    circle = Circle(rankine.directions(pool.dim, count), CIRCLE * s, MLS * s)
    rankine.rankine_rows(rows.matrix, rows.flux, pool.cloud, np.zeros_like(pool.x) if u is None else u, circle,
                         normalised)
    return rows


def cloud(dim, jitter):
    """Return a block and which of its particles have a full neighbourhood."""
    pool = block(dim, 13 if dim == 2 else 8, jitter)
    return pool, pool.far_inside(3)


# -- the points of the mean --------------------------------------------------------------------------


@pytest.mark.parametrize(("dim", "count", "degree"), [(2, None, 7), (2, 6, 5), (2, 3, 2), (3, None, 5)])
def test_mean_over_the_points_is_that_over_the_sphere(dim, count, degree):
    unit = rankine.directions(dim, count)
    assert unit.shape == ({2: count or 8, 3: 12}[dim], dim)
    np.testing.assert_allclose(np.linalg.norm(unit, axis=1), 1.0, atol=1e-14)
    random = np.random.default_rng(0)
    for power in range(1, degree + 1):
        for _ in range(5):
            axis = random.normal(size=dim)
            # mean of (a . n)^m over the unit circle or sphere
            exact = 0.0
            if power % 2 == 0:
                m = power // 2
                exact = np.linalg.norm(axis) ** power
                exact *= np.prod([(2 * k - 1) / (2 * k) for k in range(1, m + 1)]) if dim == 2 else 1.0 / (power + 1)
            assert np.mean((unit @ axis) ** power) == pytest.approx(exact, abs=1e-12)


# -- the Laplacian -----------------------------------------------------------------------------------


@dims
@jitters
def test_laplacian_of_any_quadratic_is_exact(dim, jitter):
    pool, inside = cloud(dim, jitter)
    rows = filled(pool)
    assert np.all(rows.measure[inside] > 0.0)
    for degree in (1, 2):
        for f, _, laplacian in monomials(pool.x, degree):
            found = rows.applied(2.0 + f)[inside] / -rows.measure[inside]
            np.testing.assert_allclose(found, laplacian, atol=1e-9)


@dims
@pytest.mark.parametrize("jitter", [0.0, 0.8])
@pytest.mark.parametrize("normalised", [True, False])
def test_entries_sum_to_zero_with_the_diagonal(dim, jitter, normalised):
    pool, _ = cloud(dim, jitter)
    rows = filled(pool, normalised=normalised)
    np.testing.assert_allclose(rows.sums(), 1.0, atol=1e-12)
    assert np.all(rows.measure >= 0.0)


@dims
@jitters
def test_printed_row_is_wrong_by_the_moment_of_its_interpolant(dim, jitter):
    # delta_IJ and R^2/4 with an interpolant that does not pass through the particles
    pool, inside = cloud(dim, jitter)
    rows = filled(pool, normalised=False)
    f = (pool.x**2).sum(axis=1)
    found = rows.applied(f)[inside] / -rows.measure[inside] / (2.0 * dim)
    for i, factor in list(zip(np.flatnonzero(inside), found))[:12]:
        assert factor == pytest.approx(1.0 + interpolant_moment(pool, i) / (CIRCLE * pool.spacing) ** 2, rel=1e-9)
    assert np.all(found > 2.0), "on the lattice 4.1 in 2D and 5.4 in 3D, whatever the spacing"


def interpolant_moment(pool, i):
    """Return m2 = mean over the circle of sum_J Phi_J(x_k) |x_J - x_k|^2, by solving for Phi directly."""
    radius = MLS * pool.spacing
    total = 0.0
    unit = rankine.directions(pool.dim)
    for direction in unit:
        r = pool.x - (pool.x[i] + CIRCLE * pool.spacing * direction)
        r2 = (r**2).sum(axis=1)
        near = np.flatnonzero(r2 < radius**2)
        basis = np.hstack([np.ones((len(near), 1)), r[near] / radius])
        weight = np.array([quartic_weight(value, radius**2) for value in r2[near]])
        phi = np.linalg.solve(basis.T * weight @ basis, basis.T * weight)[0]
        total += phi @ r2[near]
    return total / len(unit)


def test_lattice_row_is_symmetric_and_mostly_positive():
    pool, inside = cloud(2, 0.0)
    rows = filled(pool)
    columns, values = rows.entries(pool.at(6, 6))
    table = {tuple(pool.index[j] - 6): v for j, v in zip(columns, values)}
    for (a, b), value in table.items():
        assert value == pytest.approx(table[(b, a)], abs=1e-14) and value == pytest.approx(table[(-a, b)], abs=1e-14)
    assert values.min() > -1e-3 and table[(1, 0)] == pytest.approx(max(values), rel=1e-12)


def test_two_particles_of_a_small_drop_have_rows_of_their_own():
    # six particles and five conditions leave a single row, the same for each of the particles
    pool = free([[0.0, 0.0], [0.9, 0.1], [-0.6, 0.9], [-0.5, -0.8], [1.5, 0.7], [1.3, -0.9]])
    rows, dense = filled(pool), np.eye(6)
    for i in range(2):
        columns, values = rows.entries(i)
        assert len(columns) == 5 and values.min() > -0.1 - 1e-12 and rows.measure[i] > 0.0
        dense[i, columns] = -values
    pair = dense[:2] / np.linalg.norm(dense[:2], axis=1)[:, None]
    assert abs(pair[0] @ pair[1]) < 0.9, "or the pressure in a drop with p = 0 on the others cannot be found"


def test_rounding_is_no_row():
    # a jet along a bed reaches a corner: five neighbours, one of them without weight, and four conditions
    x = np.array([[0.0, 0.0], [-1.751, -0.006], [0.353, -0.305], [-0.647, -0.305], [-1.647, -0.305], [-2.647, -0.305]])
    for angle in np.linspace(0.0, np.pi, 24):    # turned, the sums are rounded in other ways
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        rows = filled(free(x @ turn.T, reach=3.0))
        columns, values = rows.entries(0)
        np.testing.assert_array_equal(values, [0.25] * 4)    # what is left on one side only is dropped
        assert rows.measure[0] == 0.0


def test_change_towards_isotropy_is_whole_where_neighbours_abound():
    pool, inside = cloud(2, 1.2)
    rows = filled(pool)
    lowest = min(rows.entries(i)[1].min() for i in np.flatnonzero(inside))
    assert -0.1 < lowest < 0.0


# -- the flux divergence -----------------------------------------------------------------------------


@dims
@jitters
def test_flux_divergence_of_linear_velocity_is_exact(dim, jitter):
    pool, _ = cloud(dim, jitter)
    random = np.random.default_rng(5)
    slope, drift = random.normal(size=(dim, dim)), random.normal(size=dim)
    u = pool.x @ slope.T + drift
    rows = filled(pool, u)
    sound = rows.measure > 0.0
    assert np.count_nonzero(sound) > 0.8 * pool.n
    deep = pool.far_inside(2)
    np.testing.assert_allclose(rows.div[deep], np.trace(slope), atol=1e-10)
    again = np.full(pool.n, np.nan)
    rankine.divergence(again, rows.flux, pool.cloud, u)
    np.testing.assert_allclose(again, rows.div, atol=1e-12)
    np.testing.assert_allclose(invariants(pool, u, rows)[2], rows.div, atol=1e-12)


def invariants(pool, u, rows):
    """Return tr(G^2), sqrt(2 G:G) and tr(G) of a velocity."""
    out = np.full((3, pool.n), np.nan)
    rankine.gradient_invariants(rankine.Invariants(*out), rows.flux, pool.cloud, u)
    return out


@dims
@jitters
def test_invariants_of_linear_velocity_are_exact(dim, jitter):
    pool, _ = cloud(dim, jitter)
    slope = np.random.default_rng(7).normal(size=(dim, dim))
    for matrix in (slope, slope - slope.T, np.zeros((dim, dim))):
        u = pool.x @ matrix.T + 1.0
        rows = filled(pool, u)
        pool.role[pool.at(*[4] * dim)] = SURFACE
        found, deep = invariants(pool, u, rows), pool.far_inside(2) & (pool.role == INNER)
        exact = np.trace(matrix @ matrix), np.sqrt(2.0 * (matrix**2).sum()), np.trace(matrix)
        np.testing.assert_allclose(found[:, deep], np.broadcast_to(np.reshape(exact, (3, 1)), (3, deep.sum())),
                                   atol=1e-9)
        assert np.all(found[:, pool.at(*[4] * dim)] == 0.0)


@dims
def test_flux_divergence_is_the_mean_of_the_outflow(dim):
    # (dim/R) mean of n . u over the points, u by moving least squares there
    pool, _ = cloud(dim, 0.8)
    u = np.random.default_rng(6).normal(size=pool.x.shape)
    i, radius = pool.at(*[4] * dim), MLS * pool.spacing
    outflow = []
    for direction in rankine.directions(dim):
        r = pool.x - (pool.x[i] + CIRCLE * pool.spacing * direction)
        near = np.flatnonzero((r**2).sum(axis=1) < radius**2)
        root = np.sqrt([quartic_weight(v, radius**2) for v in (r[near] ** 2).sum(axis=1)])[:, None]
        fit = np.linalg.lstsq(root * np.hstack([np.ones((len(near), 1)), r[near]]), root * u[near], rcond=None)[0]
        outflow.append(fit[0] @ direction)
    expected = dim / (CIRCLE * pool.spacing) * np.mean(outflow)
    assert filled(pool, u).div[i] == pytest.approx(expected, rel=1e-9)


# -- who takes part, and degenerate neighbourhoods ----------------------------------------------------


@dims
def test_only_inner_rows_are_filled_and_dry_walls_are_in_no_row(dim):
    pool = tank((8,) * dim if dim == 2 else (6,) * dim, jitter=0.8)
    pool.role[(pool.kind == WALL) & (pool.x[:, 0] == 0.0)] = DRY
    rows = filled(pool, u=np.where(np.isin(pool.role, (DRY, CONTACT))[:, None], np.nan, pool.x))
    inner = pool.role == INNER
    assert np.all(rows.count[~inner] == 0) and np.isnan(rows.measure[~inner]).all() and np.isnan(rows.div[~inner]).all()
    used = np.concatenate([rows.entries(i)[0] for i in np.flatnonzero(inner)])
    assert set(pool.role[used]) == {INNER, SURFACE, 2}
    # beside a dry wall all neighbours are on one side, and some rows have no Laplacian
    sound = rows.measure > 0.0
    assert np.all(sound[inner & (pool.index[:, 0] > 1)])
    np.testing.assert_allclose(rows.div[sound], dim, atol=1e-9)
    f = (pool.x**2).sum(axis=1)
    np.testing.assert_allclose(rows.applied(f)[sound], -2.0 * dim * rows.measure[sound], atol=1e-12)


@dims
def test_rows_with_all_neighbours_on_one_side_are_good_or_given_up(dim):
    given_up = 0
    for seed in range(5):
        pool = tank((8,) * dim if dim == 2 else (6,) * dim, jitter=1.2, seed=seed)
        pool.role[pool.kind == WALL] = DRY
        rows = filled(pool)
        measure = rows.measure[pool.role == INNER]
        given_up += np.count_nonzero(measure == 0.0)
        # less than a tenth of the circle's own second moment would divide by a difference
        assert measure[measure > 0.0].min() >= 0.1 * (CIRCLE * pool.spacing) ** 2 / (2.0 * dim)
    assert given_up > 0


@dims
@pytest.mark.parametrize("shape", ["alone", "coincident", "far"])
def test_row_without_support_is_the_mean_of_its_neighbours(dim, shape):
    index = {
        "alone": np.zeros((1, dim)),
        "coincident": np.zeros((4, dim)),
        "far": np.array([[0.0] * dim, [2.55] + [0.0] * (dim - 1)]),  # in the list, beyond the least squares
    }[shape]
    pool = free(index)
    rows = filled(pool, np.random.default_rng(0).normal(size=pool.x.shape))
    assert np.all(rows.count == pool.n - 1) and np.all(rows.measure == 0.0) and np.all(rows.div == 0.0)
    for i in range(pool.n):
        np.testing.assert_allclose(rows.entries(i)[1], 1.0 / max(pool.n - 1, 1), rtol=1e-14)
    assert np.isfinite(rows.flux.flux[: len(pool.indices)]).all()


def test_row_of_fluid_beside_an_edge_without_nodes_is_that_around_its_centre():
    """Neighbours around the point of the sphere nearest to the edge lie in a plane; those of the particle do not."""
    lines = [(0.0, 0.0, 0.0, 1.1), (0.45, -0.45, 0.25, 1.0), (-0.45, 0.55, 0.25, 1.0), (1.5, -0.45, 0.25, 1.0),
             (-0.45, 1.5, 0.25, 1.0), (1.5, 0.8, 0.26, 1.0), (0.8, 1.5, 0.2, 1.0)]
    index = [(x, first + pitch * k, z) for x, z, first, pitch in lines for k in (-2, -1, 0, 1, 2)]
    pool = free(np.array(index))
    rows = filled(pool, u=pool.x)
    i, values = 2, np.concatenate([pool.x.T, (pool.x**2).sum(axis=1)[None]])
    assert np.all(pool.x[i] == 0.0) and rows.measure[i] > 0.0
    found = [rows.applied(f)[i] for f in values]
    np.testing.assert_allclose(found[:3], 0.0, atol=1e-12)
    np.testing.assert_allclose(found[3], -6.0 * rows.measure[i], rtol=1e-9)
    np.testing.assert_allclose(rows.div[i], 3.0, rtol=1e-9)


@dims
def test_thin_jets_give_finite_rows(dim):
    for width in (1, 2):
        cells = np.stack(np.meshgrid(np.arange(9), *[np.arange(width)] * (dim - 1), indexing="ij"), -1).reshape(-1, dim)
        for jitter in (0.0, 0.8):
            pool = free(cells, jitter)
            rows = filled(pool, np.random.default_rng(0).normal(size=pool.x.shape))
            assert np.isfinite(rows.values).all() and np.isfinite(rows.flux.flux).all() and np.isfinite(rows.div).all()
            assert np.all(rows.measure >= 0.0)
            np.testing.assert_allclose(rows.sums(), 1.0, atol=1e-12)
