"""What is known of how the pressure bends, in rows of walls and of the surface and in the gradient."""

import numpy as np
import pytest

from parisph.base.fields import INNER, SURFACE, WET
from parisph.kernels import curvature, surface_rows, walls
from parisph.kernels.curvature import Bending
from parisph.kernels.gradient import least_squares_gradient
from parisph.kernels.near import Form
from tests.pools import Rows, dims, free, monomials, nowhere, tank

RADIUS = 2.6


def jittered(dim):
    return tank((8,) * dim if dim == 2 else (6,) * dim, jitter=0.4)


def no_pull(pool):
    return np.empty((0, pool.dim))


def even(pool, laplacian):
    """Return the Bending by a Laplacian that is the same everywhere."""
    return Bending(np.full(pool.n, float(laplacian)), no_pull(pool))


def form(pool, floor):
    return Form(RADIUS * pool.spacing, 0, floor)


@dims
def test_the_laplacian_of_walls_is_the_mean_of_inner_ones(dim):
    pool = jittered(dim)
    laplacian = np.where(pool.role == INNER, 5.0, 70.0)
    curvature.continue_laplacian(laplacian, pool.cloud, RADIUS * pool.spacing)
    np.testing.assert_allclose(laplacian[(pool.role == WET) | (pool.role == SURFACE) | (pool.role == INNER)], 5.0)


@dims
def test_harmonic_wall_rows_are_exact_for_quadratics(dim):
    pool = jittered(dim)
    rows, wet = Rows(pool), pool.role == WET
    walls.sfdi_rows(rows.matrix, pool.cloud, RADIUS * pool.spacing)
    walls.harmonic_rows(rows.matrix, pool.cloud, RADIUS * pool.spacing, np.inf)
    tried = 0
    for f, grad, due in monomials(pool.x, 2):
        right = -rows.measure * (pool.normal * grad).sum(axis=1)
        if due != 0.0:
            assert np.abs(rows.applied(f) - right)[wet].max() > 1e-3, "harmonic rows alone are not"
        curvature.add_at_walls(right, rows.matrix, pool.cloud, even(pool, due))
        np.testing.assert_allclose(rows.applied(f)[wet], right[wet], atol=1e-11)
        tried += due != 0.0
    assert tried == dim


def test_uncertain_wall_rows_stay_of_first_order():
    pool = jittered(2)
    rows, first = Rows(pool), Rows(pool)
    for some in (rows, first):
        walls.sfdi_rows(some.matrix, pool.cloud, RADIUS * pool.spacing)
    walls.harmonic_rows(rows.matrix, pool.cloud, RADIUS * pool.spacing, 1.0)
    wet = pool.role == WET
    assert np.array_equal(rows.measure[wet], first.measure[wet])


@dims
def test_rows_of_first_order_are_exact_for_water_at_rest_in_a_linear_force(dim):
    pool = jittered(dim)
    rows, wet = Rows(pool), pool.role == WET
    walls.sfdi_rows(rows.matrix, pool.cloud, RADIUS * pool.spacing)
    p, pull = at_rest(pool)
    right = -rows.measure * (pool.normal * pull).sum(axis=1)
    curvature.add_at_walls(right, rows.matrix, pool.cloud, Bending(np.zeros(pool.n), pull))
    sound = wet & (rows.measure > 0.0)
    np.testing.assert_allclose(rows.applied(p)[sound], right[sound], atol=1e-9)


def at_rest(pool):
    """Return a quadratic pressure (n,) and the force per volume that balances it (n, dim)."""
    bends = np.arange(1.0, pool.dim**2 + 1.0).reshape(pool.dim, pool.dim) - 3.0
    bends = bends + bends.T
    return 0.5 * np.einsum("ia,ab,ib->i", pool.x, bends, pool.x), pool.x @ bends


@dims
@pytest.mark.parametrize("where", [INNER, SURFACE])
@pytest.mark.parametrize("limit", [np.inf, 0.0], ids=["harmonic", "linear"])
def test_the_gradient_is_exact_for_water_at_rest(dim, where, limit):
    """By the harmonic fit, and where it is too uncertain by what a linear one lacks."""
    pool = jittered(dim)
    p, pull = at_rest(pool)
    out = linear(pool, p)
    curvature.gradient(out, pool.cloud, p, Bending(np.zeros(pool.n), pull), where, form(pool, 0.05), limit, limit)
    here = pool.role == where
    np.testing.assert_allclose(out[here], pull[here], atol=1e-9)


@dims
@pytest.mark.parametrize("where", [INNER, SURFACE])
def test_the_gradient_is_exact_for_quadratics(dim, where):
    pool = jittered(dim)
    here = pool.role == where
    for f, grad, due in monomials(pool.x, 2):
        out = linear(pool, f)
        assert np.abs(out - grad)[here].max() > 1e-3 and np.all(out[~here] == linear(pool, f)[~here])
        curvature.gradient(out, pool.cloud, f, even(pool, due), where, form(pool, 0.05), np.inf, np.inf)
        np.testing.assert_allclose(out[here], grad[here], atol=1e-9)


def linear(pool, f):
    """Return the gradient of a linear fit to f (n,)."""
    out = np.zeros((pool.n, pool.dim))
    least_squares_gradient(out, nowhere(out), pool.cloud._replace(role=pool.role.copy()), f, form(pool, 0.0))
    return out


def test_what_has_no_fit_stays():
    pool = free([[0, 0], [1, 0], [2, 0]])
    pool.role[:] = SURFACE
    out = np.full((3, 2), 7.0)
    curvature.gradient(out, pool.cloud, pool.x[:, 0] ** 2, even(pool, 1.0), SURFACE, form(pool, 0.05), np.inf, np.inf)
    assert np.all(out == 7.0)


def test_rows_of_the_surface_are_exact_across_it():
    """A column of layers whose pressure depends on the depth alone, without neighbours aside."""
    pool = free([[0.0, 0.0], [0.0, -1.0]])
    pool.role[:] = SURFACE, INNER
    rows = Rows(pool)
    surface_rows.surface_rows(rows.matrix, pool.cloud, np.ones(2), 0.6 * pool.spacing, 2.1 * pool.spacing)
    depth = 0.6 * pool.spacing - (pool.x[:, 1] - pool.x[0, 1])
    p, right = 3.0 * depth + 4.0 * depth**2, np.zeros(2)
    for laplacian, pull in ((16.0, no_pull(pool)), (0.0, np.stack([0.0 * depth, -3.0 - 8.0 * depth], axis=1))):
        right[:] = 0.0
        curvature.add_at_surface(right, rows.matrix, pool.cloud, Bending(np.full(2, laplacian), pull))
        assert rows.applied(p)[0] == pytest.approx(right[0], rel=1e-9)
