"""The shifts of Xu et al., Lind et al. and Sriram & Ma."""

import numpy as np

from parisph.base.fields import BALLISTIC, INNER, SURFACE
from parisph.kernels import shifts, surface
from parisph.kernels.smoothing import cubic_spline
from tests.pools import block, dims, free, tank

H, RADIUS = 1.3, 2.6


def xu(pool, strength=0.01, cap=1e9):
    out = np.full((pool.n, pool.dim), np.nan)
    shifts.xu_shift(out, pool.cloud, pool.walls, np.full(pool.n, strength), RADIUS * pool.spacing, cap)
    return out


def by_pressure(pool, p, strength=1.0, cap=1e9):
    out = np.full((pool.n, pool.dim), np.nan)
    shifts.pressure_shift(out, pool.cloud, pool.walls, p, strength, RADIUS * pool.spacing, cap)
    return out


def gradient(pool, tensile=True):
    if not tensile:
        return pool.concentration()
    h, out = H * pool.spacing, np.full((pool.n, pool.dim), np.nan)
    shifts.tensile_gradient(out, pool.cloud, pool.walls, h, surface.lattice_sum(pool.spacing, h, pool.axes))
    return out


def neighbours(pool, i):
    """Return (x_j - x_i (m, dim), r (m,), j (m,)) within the radius."""
    d = pool.x - pool.x[i]
    r = np.linalg.norm(d, axis=1)
    j = np.flatnonzero((r > 0.0) & (r < RADIUS * pool.spacing))
    return d[j], r[j], j


# -- what all have in common ----------------------------------------------------------------------------


@dims
def test_a_lattice_in_a_tank_stays(dim):
    pool = tank((9,) * dim if dim == 2 else (6,) * dim, lid=True, spacing=0.1)
    p = 1000.0 * (1.0 - pool.x[:, -1])
    for out, scale in ((xu(pool), 0.01), (by_pressure(pool, p), 1e4), (gradient(pool, True), 10.0)):
        np.testing.assert_allclose(out / scale, 0.0, atol=1e-12)


@dims
def test_only_inner_fluid_is_shifted_and_not_beyond_the_cap(dim):
    pool = block(dim, 5, jitter=0.8)
    pool.role[::3], pool.role[1::7] = SURFACE, BALLISTIC
    p = np.random.default_rng(0).random(pool.n)
    for shift in (lambda cap: xu(pool, 0.01, cap), lambda cap: by_pressure(pool, p, 1.0, cap)):
        free_length = np.linalg.norm(shift(1e9), axis=1)
        cap = np.median(free_length[pool.role == INNER])
        np.testing.assert_allclose(np.linalg.norm(shift(cap), axis=1), np.minimum(free_length, cap), rtol=1e-12)
        assert np.all(free_length[pool.role != INNER] == 0.0)


@dims
def test_shifts_even_out_disorder(dim):
    for shift in (lambda pool: xu(pool, 0.002, 0.01), lambda pool: by_pressure(pool, 1.0 * pool.fluid, 2e-3, 0.01)):
        pool = tank((12,) * dim if dim == 2 else (7,) * dim, lid=True, jitter=0.8)
        spread = []
        for _ in range(11):
            spread.append(np.std(pool.ratio()[pool.fluid]))
            pool.x += shift(pool)
            pool.relist()
        assert spread[-1] < 0.7 * spread[0], spread


# -- each formula -----------------------------------------------------------------------------------------


@dims
def test_sum_of_xu(dim):
    pool = block(dim, 5, jitter=0.8)
    out = xu(pool, 0.02)
    for i in (0, pool.n // 2, pool.n - 1):
        d, r, _ = neighbours(pool, i)
        expected = -0.02 * r.mean() ** 2 * (d / r[:, None] ** 3).sum(axis=0)
        np.testing.assert_allclose(out[i], expected, rtol=1e-11)


@dims
def test_tensile_term_acts_on_close_pairs(dim):
    pool = block(dim, 5, jitter=0.8)
    h, plain, tensile = H * pool.spacing, gradient(pool, False), gradient(pool, True)
    i, step = pool.n // 2, 1e-6 * pool.spacing
    d, r, _ = neighbours(pool, i)
    full = surface.lattice_sum(pool.spacing, h, pool.axes)
    slope = np.array([(cubic_spline(q + step, h, dim) - cubic_spline(q - step, h, dim)) / (2.0 * step) for q in r])
    ratio = np.array([cubic_spline(q, h, dim) for q in r]) / cubic_spline(pool.spacing, h, dim)
    extra = -(0.2 * ratio**4 * slope / full)[:, None] * d / r[:, None]
    np.testing.assert_allclose(tensile[i] - plain[i], extra.sum(axis=0), atol=1e-6 / pool.spacing)
    pair = free(np.eye(dim, dtype=int)[:1] * [[0], [1]], spacing=0.1)
    pair.x[1] *= 0.5
    pair.relist()
    assert gradient(pair, True)[0, 0] > gradient(pair, False)[0, 0] > 0.0


@dims
def test_shift_along_and_across_a_surface(dim):
    n, random = 6, np.random.default_rng(1)
    g, normal = random.normal(size=(n, dim)), random.normal(size=(n, dim))
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    role = np.array([INNER, SURFACE, INNER, SURFACE, INNER, BALLISTIC], np.int8)
    close = np.array([False, True, True, True, True, True])
    pool = free(np.eye(n, dim), spacing=1.0)
    pool.role = role

    def shifted(cap=1e9):
        out = np.full((n, dim), np.nan)
        shifts.surface_shift(out, pool.cloud, g, normal, close, np.full(n, 0.3), cap)
        return out
    kept, along = shifted(), np.einsum("ia,ia->i", g, normal)
    np.testing.assert_allclose(kept[0], -0.3 * g[0], rtol=1e-13)
    np.testing.assert_allclose(kept[1:5], -0.3 * (g - along[:, None] * normal)[1:5], atol=1e-14)
    assert np.all(kept[5] == 0.0) and np.linalg.norm(shifted(0.01), axis=1).max() < 0.01 + 1e-15


@dims
def test_directions_of_a_surface(dim):
    pool = block(dim, 5, jitter=0.4)
    pool.role[pool.index[:, -1] == pool.index[:, -1].max()] = SURFACE
    pool.kind[0] = 1
    g = np.random.default_rng(4).normal(size=(pool.n, dim))
    normal, close = np.full((pool.n, dim), np.nan), np.empty(pool.n, bool)
    reach = 2.0 * pool.spacing
    shifts.surface_normals(normal, close, pool.cloud, g, reach)
    for i in range(1, pool.n):
        d = np.linalg.norm(pool.x - pool.x[i], axis=1)
        j = np.flatnonzero((pool.role == SURFACE) & (d > 0.0) & (d < reach) & (pool.kind == 0))
        expected = g[i] if pool.role[i] == SURFACE else (g[j] / d[j, None] ** 2).sum(axis=0)
        assert close[i] == (pool.role[i] == SURFACE or len(j) > 0)
        if close[i]:
            np.testing.assert_allclose(normal[i], expected / np.linalg.norm(expected), rtol=1e-10, atol=1e-12)
    assert not close[0] and not normal[~close].any()


@dims
def test_sum_of_the_pressure_shift(dim):
    pool = block(dim, 5, jitter=0.8)
    p = 10.0 + np.random.default_rng(2).random(pool.n)
    out = by_pressure(pool, p, 0.3)
    np.testing.assert_allclose(by_pressure(pool, p + 1e3, 0.3), out, rtol=1e-9, atol=1e-9)
    for i in (0, pool.n // 2, pool.n - 1):
        d, r, j = neighbours(pool, i)
        q = r / (RADIUS * pool.spacing)
        w = 1.0 - 6.0 * q**2 + 8.0 * q**3 - 3.0 * q**4
        excess = p[i] - min(p[i], p[j].min())
        expected = -0.3 * dim * excess * (w[:, None] * d / r[:, None] ** 2).sum(axis=0) / w.sum()
        np.testing.assert_allclose(out[i], expected, rtol=1e-9, atol=1e-12)
