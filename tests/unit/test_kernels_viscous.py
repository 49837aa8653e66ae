"""The viscous acceleration, against exact fields between walls of both kinds."""

import numpy as np
import pytest

from parisph.base.fields import ABSENT, BALLISTIC, FLUID, WALL
from parisph.kernels import viscous
from tests.manufactured import orders
from tests.pools import block, dims, monomials, tank

forms = pytest.mark.parametrize("form", [viscous.morris, viscous.corrected])
H, RADIUS = 1.3, 2.6


def found(form, pool, u, nu=1.0, no_slip=1):
    """Return the acceleration (n, dim); no_slip : of all walls, or (n,)."""
    s, out = pool.spacing, np.full((pool.n, pool.dim), np.nan)
    slip = ((pool.kind == WALL) * np.asarray(no_slip)).astype(np.int8)
    flowing = viscous.Flowing(u, np.broadcast_to(nu, pool.n) + 0.0, slip)
    radii = (H * s,) if form is viscous.morris else (RADIUS * s, H * s)
    form(out, pool.cloud, pool.walls_with(u, slip), flowing, *radii)
    return out


def full(dim, jitter=0.0, cells=None, seed=0):
    cells = cells or (10 if dim == 2 else 7)
    return tank((cells,) * dim, lid=True, jitter=jitter, spacing=1.0 / cells, seed=seed)


# -- exactness ----------------------------------------------------------------------------------------


@dims
@pytest.mark.parametrize("jitter", [0.0, 0.4, 0.8])
def test_corrected_form_is_exact_for_quadratics_beside_moving_walls(dim, jitter):
    pool = full(dim, jitter)
    for f, _, laplacian in monomials(pool.x, 1) + monomials(pool.x, 2):
        u = np.outer(f, np.arange(1.0, dim + 1.0))
        out = found(viscous.corrected, pool, u, nu=0.3)
        expected = 0.3 * laplacian * np.arange(1.0, dim + 1.0)
        np.testing.assert_allclose(out[pool.fluid], np.broadcast_to(expected, out[pool.fluid].shape), atol=1e-11)
        assert np.all(out[~pool.fluid] == 0.0)


@dims
@pytest.mark.parametrize("jitter", [0.0, 0.6])
def test_profiles_that_a_free_slip_wall_leaves_alone_are_exact(dim, jitter):
    """Tangential velocity even, normal velocity odd across the lower wall; other walls are no-slip."""
    pool = full(dim, jitter)
    height, bottom = pool.x[:, -1], pool.index[:, -1] == 0
    u = np.zeros((pool.n, dim))
    u[:, 0], u[:, -1] = height**2 + pool.x[:, 0], 3.0 * height
    out = found(viscous.corrected, pool, u, no_slip=~bottom | pool.corner.astype(bool))
    np.testing.assert_allclose(out[pool.fluid, 0], 2.0, atol=1e-11)
    np.testing.assert_allclose(out[pool.fluid, 1:], 0.0, atol=1e-11)


@dims
def test_free_slip_walls_do_not_hold_a_uniform_stream(dim):
    pool = full(dim, 0.5)
    ends = (pool.index[:, 0] == 0) | (pool.index[:, 0] == pool.top[0])
    u = np.zeros((pool.n, dim))
    u[:, 0] = 1.0
    for form in (viscous.morris, viscous.corrected):
        out = found(form, pool, u, no_slip=ends)
        np.testing.assert_allclose(out[pool.fluid], 0.0, atol=1e-11)
    wall = pool.kind == WALL
    u[wall & ~ends] = 0.0
    assert np.abs(found(viscous.corrected, pool, u, no_slip=wall)[pool.fluid, 0]).max() > 1.0


@dims
def test_mean_viscosity_of_pairs_is_exact_for_linear_fields(dim):
    """div(nu grad u) = grad nu . grad u."""
    pool = full(dim, 0.6)
    slope, random = np.arange(1.0, dim + 1.0), np.random.default_rng(0)
    g = random.normal(size=(dim, dim))
    out = found(viscous.corrected, pool, pool.x @ g.T, nu=1.0 + pool.x @ slope)
    np.testing.assert_allclose(out[pool.fluid], np.broadcast_to(g @ slope, out[pool.fluid].shape), atol=1e-10)


@dims
def test_profiles_between_walls_on_a_lattice(dim):
    """The form of Morris: Couette flow is kept, Poiseuille flow has its acceleration but for the first
    layer."""
    pool = tank((24, 10) if dim == 2 else (10, 10, 8), lid=True)
    y, u = pool.x[:, -1] / pool.x[:, -1].max(), np.zeros((pool.n, dim))
    inside = pool.fluid & np.all((pool.index[:, :-1] > 3) & (pool.index[:, :-1] < pool.top[:-1] - 3), axis=1)
    first = inside & ((pool.index[:, -1] == 1) | (pool.index[:, -1] == pool.top[-1] - 1))
    u[:, 0] = y
    np.testing.assert_allclose(found(viscous.morris, pool, u)[inside], 0.0, atol=1e-11)
    u[:, 0] = y * (1.0 - y)
    ratio = found(viscous.morris, pool, u)[:, 0] * pool.x[:, -1].max() ** 2 / -2.0
    np.testing.assert_allclose(ratio[inside & ~first], 1.0, atol=0.03)
    np.testing.assert_allclose(ratio[first], 1.0, atol=0.15)


@pytest.mark.parametrize(("jitter", "least"), [(0.0, 1.7), (0.8, 1.1)])
def test_order_of_the_corrected_form(jitter, least):
    errors, cells = [], np.array([16, 32, 64])
    for c in cells:
        pool = full(2, jitter, c)
        f = np.sin(np.pi * (pool.x[:, 0] + 2.0 * pool.x[:, 1]))
        out = found(viscous.corrected, pool, np.stack([f, np.zeros(pool.n)], axis=1))
        errors.append(np.sqrt(np.mean((out[:, 0] / (5.0 * np.pi**2) + f)[pool.fluid] ** 2)))
    assert np.all(orders(1.0 / cells, errors) > least) and errors[-1] < 0.005, errors


@dims
def test_walls_take_the_normal_acceleration_of_the_fluid(dim):
    """A constant exactly; of a slope, less than there is one spacing in front of the wall."""
    pool = tank((8,) * dim if dim == 2 else (6,) * dim)
    sound = (pool.kind == WALL) & (pool.corner == 0) & (pool.index[:, -1] < pool.top[-1])
    for slope in (0.0, 10.0):
        a = np.full((pool.n, dim), np.nan)
        a[pool.fluid] = 2.0 + slope * pool.x[pool.fluid, -1:]
        before = a[pool.fluid].copy()
        viscous.continue_to_walls(a, pool.cloud, RADIUS * pool.spacing)
        np.testing.assert_array_equal(a[pool.fluid], before)
        assert np.all(a[pool.corner == 1] == 0.0)
        if slope == 0.0:
            np.testing.assert_allclose(a[sound], 2.0 * pool.normal[sound] * pool.normal[sound].sum(axis=1)[:, None],
                                       rtol=1e-12)
        else:
            bottom = pool.at(*[3] * (dim - 1), 0)
            assert 2.0 < a[bottom, -1] < 2.0 + slope * pool.spacing and np.all(a[bottom, :-1] == 0.0)


# -- what must be conserved ---------------------------------------------------------------------------


@dims
def test_pairs_conserve_momentum(dim):
    pool = block(dim, 8 if dim == 2 else 6, jitter=0.8)
    random = np.random.default_rng(1)
    out = found(viscous.morris, pool, random.normal(size=(pool.n, dim)), nu=random.random(pool.n))
    assert np.abs(out).max() > 1.0
    np.testing.assert_allclose(out.sum(axis=0), 0.0, atol=1e-10)


@forms
@dims
def test_another_frame_or_numbering_changes_nothing(form, dim):
    pool = tank((9,) * dim if dim == 2 else (6,) * dim, jitter=0.6)
    random = np.random.default_rng(2)
    u, nu, no_slip = random.normal(size=(pool.n, dim)), random.random(pool.n), pool.index[:, 0] == 0
    out = found(form, pool, u, nu, no_slip)
    assert np.isfinite(out).all()
    np.testing.assert_allclose(found(form, pool, u + np.arange(1.0, dim + 1.0), nu, no_slip), out, rtol=1e-8, atol=1e-8)
    order = random.permutation(pool.n)
    for name in ("x", "kind", "corner", "normal", "role", "index"):
        setattr(pool, name, getattr(pool, name)[order])
    pool.relist()
    np.testing.assert_allclose(found(form, pool, u[order], nu[order], no_slip[order]), out[order], rtol=1e-8, atol=1e-8)


# -- where the fit is not possible ----------------------------------------------------------------------


@dims
def test_surface_and_lonely_particles_take_the_form_of_morris(dim):
    pool = tank((8,) * dim if dim == 2 else (6,) * dim)
    u = np.random.default_rng(3).normal(size=(pool.n, dim))
    top = pool.fluid & (pool.index[:, -1] == pool.top[-1])
    plain, fitted = (found(form, pool, u) for form in (viscous.morris, viscous.corrected))
    np.testing.assert_array_equal(plain[top], fitted[top])
    assert not np.any(plain[pool.fluid & ~top] == fitted[pool.fluid & ~top])
    pool = block(dim, 2)    # too few for a quadratic fit
    u = np.random.default_rng(4).normal(size=(pool.n, dim))
    np.testing.assert_array_equal(*(found(form, pool, u) for form in (viscous.morris, viscous.corrected)))


@forms
def test_alone_and_beside_absent_walls_nothing_acts(form):
    pool = tank((6, 6))
    keep = pool.at(1, 3)
    pool.kind[pool.kind == WALL] = ABSENT
    pool.kind[(pool.kind == FLUID) & (np.arange(pool.n) != keep)] = ABSENT
    pool.role[keep] = BALLISTIC
    u = np.random.default_rng(5).normal(size=(pool.n, 2))
    assert np.all(found(form, pool, u) == 0.0)


# -- stability ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("lid", [True, False])
@forms
def test_explicit_steps_of_the_stable_length(form, lid):
    for jitter in (0.0, 1.2):
        pool = tank((9, 9), lid=lid, jitter=jitter, spacing=1.0)
        eigenvalues = np.linalg.eigvals(matrix(form, pool))
        assert np.abs(1.0 + viscous.STABLE * eigenvalues).max() < 1.0
        assert eigenvalues.real.max() < -0.05


def matrix(form, pool):
    """Return the matrix of the acceleration of component 0 of the fluid between no-slip walls."""
    fluid = np.flatnonzero(pool.fluid)
    columns = []
    for j in fluid:
        u = np.zeros((pool.n, 2))
        u[j, 0] = 1.0
        columns.append(found(form, pool, u)[fluid, 0])
    return np.array(columns).T
