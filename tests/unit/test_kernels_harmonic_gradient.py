"""The gradient that knows slopes across walls and the Laplacian."""

import numpy as np
import pytest

from parisph.base.fields import SURFACE, WALL
from parisph.kernels.harmonic import Slopes
from parisph.kernels.harmonic_gradient import harmonic_gradient
from tests.pools import block, dims, free, harmonic_cubics, harmonic_quadratics, monomials, tank


def jittered(dim):
    return tank((8,) * dim if dim == 2 else (6,) * dim, jitter=0.4)


def gradient(pool, f, grad, laplacian=None, most=np.inf, walls=True):
    """Return the gradient of f (n,) at fluid, and 7 where there is none.

    grad : (n, dim), from which walls have their slopes, if they are known
    """
    out, known = np.full((pool.n, pool.dim), 7.0), (pool.kind == WALL) & (pool.corner == 0) & walls
    slope = np.where(known, (pool.normal * grad).sum(axis=1), np.nan)
    bent = np.empty(0) if laplacian is None else np.full(pool.n, float(laplacian))
    everywhere, slopes = np.ones(pool.n, np.bool_), Slopes(slope, known)
    found = harmonic_gradient(out, everywhere, pool.cloud, f, slopes, bent, 2.6 * pool.spacing, most)
    np.testing.assert_array_equal(found, np.any(out != 7.0, axis=1))
    return out


@dims
def test_harmonic_cubics_are_exact_up_to_the_corners_of_a_tank(dim):
    pool = jittered(dim)
    here = pool.fluid
    for f, grad, _ in harmonic_cubics(pool.x):
        out = gradient(pool, f, grad)
        np.testing.assert_allclose(out[here], grad[here], atol=1e-8)
        assert np.all(out[~here] == 7.0)


@dims
@pytest.mark.parametrize("faces", [0, 1])
def test_harmonic_cubics_are_exact_without_walls_even_one_sided(dim, faces):
    side = 9 if dim == 2 else 7
    pool = block(dim, side, 0.4)
    i = pool.at(*[0] * faces, *[side // 2] * (dim - faces))
    for f, grad, _ in harmonic_cubics(pool.x):
        np.testing.assert_allclose(gradient(pool, f, grad)[i], grad[i], atol=1e-9)


@dims
def test_with_its_laplacian_every_quadratic_is_exact(dim):
    pool = jittered(dim)
    here = pool.fluid
    for f, grad, due in monomials(pool.x, 2):
        np.testing.assert_allclose(gradient(pool, f, grad, due)[here], grad[here], atol=1e-9)
        if due:
            assert np.abs(gradient(pool, f, grad) - grad)[here].max() > 1e-3, "not without it"


def test_a_slope_across_a_wall_makes_the_gradient_beside_it_more_certain():
    """Of noise in the values, the fit that knows the slope takes less."""
    pool = jittered(2)
    beside = pool.at(1, 4)
    noise = np.random.default_rng(0).normal(size=(200, pool.n))
    spread = [np.std([gradient(pool, f, np.zeros((pool.n, 2)), walls=walls)[beside, 0] for f in noise])
              for walls in (True, False)]
    assert spread[0] < 0.8 * spread[1], "measured .74"


def test_where_few_neighbours_are_the_degree_is_less():
    angle = 2.0 * np.pi * np.arange(5) / 5
    pool = free(np.vstack([[0.0, 0.0], np.stack([np.cos(angle), np.sin(angle)], axis=1)]))
    for f, grad in harmonic_quadratics(pool.x):
        np.testing.assert_allclose(gradient(pool, f, grad)[0], grad[0], atol=1e-12)
    line = free([[0, 0], [1, 0], [2, 0], [3, 0]])
    assert np.all(gradient(line, line.x[:, 0], 0.0 * line.x) == 7.0)


def test_uncertain_terms_are_left_out():
    pool, found = jittered(2), {}
    f, grad, _ = harmonic_cubics(pool.x)[0]
    for most in (1.0, 2.0, np.inf):
        found[most] = gradient(pool, f, grad, most=most)[pool.role == SURFACE]
    assert np.all(found[1.0] == 7.0), "even the terms of degree 2 raise the variance of a slope"
    kept = np.any(found[2.0] != found[np.inf], axis=1)
    assert 0 < kept.sum() and not np.all(found[np.inf] == 7.0)
