"""What a pressure that is not harmonic adds to harmonic fits, at walls and at the surface."""

import numpy as np
import pytest

from parisph.base.fields import SURFACE, WET
from parisph.kernels import curvature, gradient, walls
from tests.pools import Rows, free, monomials, tank

DENSITY, RADIUS = 3.0, 2.6
dims = pytest.mark.parametrize("dim", [2, 3])


def jittered(dim):
    return tank((8,) * dim if dim == 2 else (6,) * dim, jitter=0.4)


def strained(pool):
    """Return a linear velocity (n, dim) and tr((grad u)^2) of it."""
    g = np.arange(1.0, pool.dim**2 + 1.0).reshape(pool.dim, pool.dim) / 7.0
    return pool.x @ g.T, np.trace(g @ g)


def quadratics(pool, laplacian):
    """Yield (f, gradient) of every quadratic monomial that is not harmonic, scaled to have this Laplacian."""
    for f, grad, due in monomials(pool.x, 2):
        if due != 0.0:
            yield f * laplacian / due, grad * laplacian / due


@dims
@pytest.mark.parametrize("outflow", [0.0, 3.0])
def test_laplacian_at_walls_is_that_of_the_flow(dim, outflow):
    pool = jittered(dim)
    u, square = strained(pool)
    force = pool.x * outflow / dim
    found = np.full(pool.n, 7.0)
    curvature.laplacian_at_walls(found, DENSITY, u, force, pool.x, pool.role, RADIUS * pool.spacing, *pool.csr)
    wet = pool.role == WET
    np.testing.assert_allclose(found[wet], DENSITY * (outflow - square), rtol=1e-10)
    assert np.all(found[~wet] == 0.0)


@dims
def test_wall_rows_are_exact_for_quadratics(dim):
    pool, laplacian = jittered(dim), 5.0
    rows, wet = Rows(pool), pool.role == WET
    arguments = (*rows.matrix, pool.x, pool.role, pool.normal, RADIUS * pool.spacing, *pool.csr)
    walls.sfdi_rows(*arguments)
    walls.harmonic_rows(*arguments)
    tried = 0
    for f, grad in quadratics(pool, laplacian):
        right = -rows.measure * (pool.normal * grad).sum(axis=1)
        assert np.abs(rows.applied(f) - right)[wet].max() > 1e-3, "harmonic rows alone are not"
        curvature.add_at_walls(right, np.full(pool.n, laplacian), *rows.matrix[:3], pool.x, pool.role, pool.indptr,
                               pool.axes)
        np.testing.assert_allclose(rows.applied(f)[wet], right[wet], atol=1e-11)
        tried += 1
    assert tried == dim


@dims
@pytest.mark.parametrize("outflow", [0.0, 9.0])
def test_gradient_at_the_surface_is_exact_for_quadratics(dim, outflow):
    pool = jittered(dim)
    u, square = strained(pool)
    force = pool.x * outflow / dim
    surface, tried = pool.role == SURFACE, 0
    for f, grad in quadratics(pool, DENSITY * (outflow - square)):
        out = at_surface(pool, f)
        assert np.abs(out - grad)[surface].max() > 1e-3, "the harmonic gradient alone is not"
        curvature.add_at_surface(out, DENSITY, u, force, pool.x, pool.role, RADIUS * pool.spacing, np.inf, *pool.csr)
        np.testing.assert_allclose(out[surface], grad[surface], atol=1e-9)
        assert np.all(out[~surface] == 0.0)
        tried += 1
    assert tried == dim


def at_surface(pool, f):
    """Return the harmonic gradient of f (n,) at surface particles: (n, dim)."""
    out = np.zeros((pool.n, pool.dim))
    gradient.harmonic_gradient(out, f, pool.x, pool.role, RADIUS * pool.spacing, np.inf, *pool.csr)
    return out


def test_what_has_no_fit_stays():
    pool = free([[0, 0], [1, 0], [2, 0]])
    pool.role[:] = SURFACE
    out = np.full((3, 2), 7.0)
    curvature.add_at_surface(out, DENSITY, pool.x, pool.x, pool.x, pool.role, RADIUS * pool.spacing, np.inf, *pool.csr)
    assert np.all(out == 7.0)
