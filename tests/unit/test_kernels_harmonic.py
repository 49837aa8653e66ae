"""Derivatives from the fit by harmonic polynomials, one-sided ones above all."""

import numpy as np
import pytest

from parisph.base.fields import CONTACT, DRY, SURFACE
from parisph.kernels import gradient, harmonic
from parisph.kernels.smoothing import quartic_weight
from tests.pools import block, dims, free, harmonic_quadratics, monomials, tank


def coefficients(pool, i, radius=2.6, most=np.inf):
    """Return (success, c (neighbours of i, dim))."""
    c, work, b = harmonic.scratch(pool.indptr, pool.axes)
    c[:] = np.nan
    sound = harmonic.coefficients(c, i, pool.cloud, radius * pool.spacing, most, work, b)
    return sound, c[: pool.indptr[i + 1] - pool.indptr[i]]


def derivative(pool, i, f, radius=2.6):
    sound, c = coefficients(pool, i, radius)
    assert sound
    near = pool.indices[pool.indptr[i]:pool.indptr[i + 1]]
    return c.T @ (f[near] - f[i])


def one_sided(dim, faces, jitter):
    """Return a block and its particle in the middle of a face, of an edge or in a corner."""
    side = 9 if dim == 2 else 7
    pool = block(dim, side, jitter)
    return pool, pool.at(*[0] * faces, *[side // 2] * (dim - faces))


@pytest.mark.parametrize(("dim", "faces"), [(2, 0), (2, 1), (2, 2), (3, 0), (3, 1), (3, 2), (3, 3)])
@pytest.mark.parametrize("jitter", [0.0, 0.4, 0.8])
def test_harmonic_quadratics_are_exact_even_one_sided(dim, faces, jitter):
    pool, i = one_sided(dim, faces, jitter)
    for f, grad in [one[:2] for one in monomials(5.0 + pool.x, 1)] + harmonic_quadratics(pool.x):
        np.testing.assert_allclose(derivative(pool, i, f), grad[i], atol=1e-10)


@dims
def test_what_is_not_harmonic_is_not_exact(dim):
    pool, i = one_sided(dim, 1, 0.0)
    f = (pool.x**2).sum(axis=1)
    error = np.abs(derivative(pool, i, f) - 2.0 * pool.x[i]).max()
    assert error > 0.1 * pool.spacing


def values(d, degree=3):
    """Return the polynomials at places d (k, dim): (terms, k)."""
    axes = tuple(range(d.shape[1]))
    b = np.full((15, len(d)), np.nan)
    b[: len(axes)] = d.T
    if degree > 1:
        harmonic.fill_values(b, len(d), degree, axes)
    n = harmonic.terms(degree, axes)
    assert np.isnan(b[n:]).all() and np.isfinite(b[:n]).all()
    return b[:n]


def slopes(d, normal):
    """Return their derivatives in the directions normal (k, dim): (terms, k)."""
    axes, none = tuple(range(d.shape[1])), np.zeros((1, 3 - d.shape[1]))
    b = np.full((15, len(d)), np.nan)
    for k in range(len(d)):
        harmonic.fill_slopes(b, k, tuple(np.append(d[k], none)), tuple(np.append(normal[k], none)), axes)
    n = harmonic.terms(3, axes)
    assert np.isnan(b[n:]).all() and np.isfinite(b[:n]).all()
    return b[:n]


@dims
@pytest.mark.parametrize("degree", [1, 2, 3])
def test_the_polynomials_are_all_harmonic_ones_up_to_a_degree(dim, degree):
    """Independent, as many as there are, and in the order of their degrees."""
    assert harmonic.terms(degree, tuple(range(dim))) == {2: [2, 4, 6], 3: [3, 8, 15]}[dim][degree - 1]
    assert harmonic.basis_size(tuple(range(dim))) == {2: 4, 3: 8}[dim]
    random = np.random.default_rng(0)
    d = random.normal(size=(60, dim))
    found = values(d, degree)
    np.testing.assert_array_equal(found, values(d)[: len(found)])
    assert np.linalg.cond(found) < 50.0
    around = sum(values(d + side, degree) for side in np.vstack([np.eye(dim), -np.eye(dim)]))
    np.testing.assert_allclose(around, 2.0 * dim * found, atol=1e-11)    # second differences are exact for cubics


@dims
def test_slopes_are_derivatives_of_the_polynomials(dim):
    d, normal = np.random.default_rng(1).normal(size=(2, 20, dim))
    step = 0.5    # central differences, corrected to be exact for cubics
    change = [values(d + t * step * normal) - values(d - t * step * normal) for t in (1.0, 2.0)]
    exact = (8.0 * change[0] - change[1]) / (12.0 * step)
    np.testing.assert_allclose(slopes(d, normal), exact, rtol=1e-11, atol=1e-11)


@dims
@pytest.mark.parametrize("shape", ["alone", "line", "plane", "cross", "few", "coincident"])
def test_neighbours_that_do_not_span_the_basis_are_refused(dim, shape):
    zero, unit = np.zeros((1, dim)), np.eye(dim)
    index = {
        "alone": zero,
        "line": np.arange(-3, 4)[:, None] * unit[:1],
        "plane": np.stack(np.meshgrid(*[np.arange(-2, 3)] * (dim - 1), [0], indexing="ij"), -1).reshape(-1, dim),
        "cross": np.concatenate([zero] + [k * unit for k in (-2, -1, 1, 2)]),  # xy vanishes on it
        "few": np.concatenate([zero, 0.7 + 0.5 * np.random.default_rng(0).random(({2: 4, 3: 8}[dim], dim))]),
        "coincident": np.concatenate([np.zeros((20, dim)), unit]),
    }[shape]
    pool = free(index)
    i = int(np.flatnonzero((pool.index == 0).all(axis=1))[0])
    assert not coefficients(pool, i)[0]


def test_one_neighbour_more_than_polynomials_is_needed():
    angle = 2.0 * np.pi * np.arange(5) / 5
    pentagon = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    pool = free(np.vstack([[0.0, 0.0], pentagon]))
    for f, grad in harmonic_quadratics(pool.x):
        np.testing.assert_allclose(derivative(pool, 0, f), grad[0], atol=1e-12)
    assert not coefficients(free(np.vstack([[0.0, 0.0], pentagon[:4]])), 0)[0]


@dims
def test_the_terms_of_degree_two_raise_the_variance_of_a_slope_by_what_is_said(dim):
    pool, i = one_sided(dim, 1, 0.4)
    near = pool.indices[pool.indptr[i]:pool.indptr[i + 1]]
    d = (pool.x[near] - pool.x[i]) / (2.6 * pool.spacing)
    weight = np.array([quartic_weight(r2, 1.0) for r2 in (d**2).sum(axis=1)])
    basis = values(d, 2)
    moment = basis * weight @ basis.T
    raised = np.trace(np.linalg.inv(moment)[:dim, :dim] @ moment[:dim, :dim]) / dim
    assert raised > 1.1
    assert coefficients(pool, i, most=1.001 * raised)[0] and not coefficients(pool, i, most=0.999 * raised)[0]


@dims
def test_particles_outside_the_stencil_have_no_weight(dim):
    pool, i = one_sided(dim, 0, 0.8)
    near = pool.indices[pool.indptr[i]:pool.indptr[i + 1]]
    pool.role[near[0]], pool.role[near[1]] = DRY, CONTACT
    sound, c = coefficients(pool, i, radius=2.2)
    distance = np.linalg.norm(pool.x[near] - pool.x[i], axis=1)
    out = (distance >= 2.2 * pool.spacing) | np.isin(np.arange(len(near)), (0, 1))
    assert sound and np.all(c[out] == 0.0) and np.all(np.abs(c[~out]).max(axis=1) > 0.0)
    for f, grad in harmonic_quadratics(pool.x):
        np.testing.assert_allclose(derivative(pool, i, f, 2.2), grad[i], atol=1e-10)


@dims
def test_gradient_is_replaced_on_the_surface_only(dim):
    pool = tank((8,) * dim if dim == 2 else (6,) * dim, jitter=0.4)
    out = np.full((pool.n, dim), 7.0)
    f, grad = harmonic_quadratics(pool.x)[0]
    gradient.harmonic_gradient(out, pool.cloud, f, 2.6 * pool.spacing, np.inf, np.inf)
    surface = pool.role == SURFACE
    np.testing.assert_allclose(out[surface], grad[surface], atol=1e-9)
    assert np.all(out[~surface] == 7.0)


def test_the_gradient_says_where_the_terms_of_degree_two_make_it_unsure():
    pool = tank((8, 8), jitter=0.4)
    f, grad = harmonic_quadratics(pool.x)[0]
    out, surface = np.full((pool.n, 2), 7.0), np.flatnonzero(pool.role == SURFACE)
    unsure = gradient.harmonic_gradient(out, pool.cloud, f, 2.6 * pool.spacing, 1.5, np.inf)
    due = [i for i in surface if not coefficients(pool, i, most=1.5)[0]]
    assert 0 < len(due) < len(surface) and np.array_equal(np.flatnonzero(unsure), due)
    np.testing.assert_allclose(out[surface], grad[surface], atol=1e-9)
    out[:] = 7.0
    assert not gradient.harmonic_gradient(out, pool.cloud, f, 2.6 * pool.spacing, 1.5, 1.5).any()
    assert np.all(out[due] == 7.0)


def test_gradient_of_a_surface_without_support_stays():
    pool = free([[0, 0], [1, 0], [2, 0]])
    pool.role[:] = SURFACE
    out = np.full((3, 2), 7.0)
    gradient.harmonic_gradient(out, pool.cloud, np.arange(3.0), 2.6 * pool.spacing, np.inf, np.inf)
    assert np.all(out == 7.0)
