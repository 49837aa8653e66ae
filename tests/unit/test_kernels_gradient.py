"""The pressure gradients and the velocity of wall particles."""

import numpy as np
import pytest

from parisph.base.fields import BALLISTIC, CONTACT, DRY, INNER, SURFACE, WALL, WET
from parisph.kernels import gradient
from parisph.kernels.moments import second_moment
from parisph.kernels.near import Form
from parisph.kernels.smoothing import cubic_spline_slope, quartic_weight
from tests.pools import block, dims, free, monomials, nowhere, tank

powers = pytest.mark.parametrize("power", [0, 2])
RADIUS = {0: 2.6, 2: 2.1}
FLOOR = {0: 0.05, 2: 0.2}


def least_squares(pool, f, power=2, floor=None):
    out = np.full((pool.n, pool.dim), np.nan)
    form = Form(RADIUS[power] * pool.spacing, power, FLOOR[power] if floor is None else floor)
    gradient.least_squares_gradient(out, nowhere(out), pool.cloud, f, form)
    return out


def symmetric(pool, p, h=1.8):
    out = np.full((pool.n, pool.dim), np.nan)
    gradient.symmetric_gradient(out, pool.cloud, p, h * pool.spacing, pool.spacing**pool.dim)
    return out


# -- first-order least squares --------------------------------------------------------------------


@dims
@powers
@pytest.mark.parametrize("jitter", [0.0, 0.4, 1.2])
def test_linear_fields_are_exact_on_any_particles(dim, power, jitter):
    pool = block(dim, 12 if dim == 2 else 6, jitter)
    for f, grad, _ in monomials(pool.x, 1):
        out = least_squares(pool, 3.0 + 2.0 * f, power)
        flying, sound = pool.role == BALLISTIC, pool.quality(RADIUS[power] * pool.spacing, power) >= FLOOR[power]
        assert np.count_nonzero(sound) >= 0.9 * pool.n and not np.any(flying & sound)
        assert np.all(out[flying] == 0.0)
        np.testing.assert_allclose(out[sound], 2.0 * grad[sound], atol=1e-11)
        assert np.linalg.norm(out, axis=1).max() < 2.0 + 1e-11    # a flat neighbourhood only damps the slope


@dims
@powers
def test_walls_take_part_with_their_pressure_and_have_no_gradient(dim, power):
    pool = tank((8,) * dim if dim == 2 else (5,) * dim, jitter=0.8)
    before = pool.role.copy()
    f, grad, _ = monomials(pool.x, 1)[-1]
    f = np.where(pool.role == CONTACT, np.nan, f)  # in no stencil
    out = least_squares(pool, f, power)
    np.testing.assert_allclose(out[pool.fluid], grad[pool.fluid], atol=1e-11)
    assert np.all(out[~pool.fluid] == 0.0)
    np.testing.assert_array_equal(pool.role, before)


@dims
@powers
def test_dry_walls_are_in_no_stencil(dim, power):
    pool = tank((7,) * dim if dim == 2 else (5,) * dim, jitter=0.4)
    dry = (pool.kind == WALL) & (pool.x[:, 0] == 0.0)
    pool.role[dry] = DRY
    f, grad, _ = monomials(pool.x, 1)[0]
    out = least_squares(pool, np.where(dry | (pool.role == CONTACT), np.nan, f), power)
    fluid = pool.fluid & (pool.role != BALLISTIC)
    assert np.count_nonzero(pool.role == BALLISTIC) == 0
    np.testing.assert_allclose(out[fluid], grad[fluid], atol=1e-11)


@dims
@powers
def test_weight_is_that_of_the_papers(dim, power):
    # Zheng et al. 2017: Eq. 29 is least squares with weight W/r^2, Eq. 28 with W
    pool = block(dim, 7, jitter=0.8)
    i = pool.at(*[3] * dim)
    f = np.random.default_rng(3).normal(size=pool.n)
    r = pool.x - pool.x[i]
    r2 = (r**2).sum(axis=1)
    radius2 = (RADIUS[power] * pool.spacing) ** 2
    near = np.flatnonzero((r2 < radius2) & (r2 > 0.0))
    root = np.sqrt([quartic_weight(r2[j], radius2) / (r2[j] if power == 2 else 1.0) for j in near])
    fit = np.linalg.lstsq(root[:, None] * r[near], root * (f[near] - f[i]), rcond=None)[0]
    np.testing.assert_allclose(least_squares(pool, f, power)[i], fit, rtol=1e-9)


def test_sfdi_is_the_printed_formula():
    # Zheng et al. 2017, Eqs. 29-32: C_k - a_km C_m over 1 - a_12 a_21
    pool = block(2, 7, jitter=0.8)
    i = pool.at(3, 3)
    f = np.random.default_rng(4).normal(size=pool.n)
    radius2 = (RADIUS[2] * pool.spacing) ** 2
    r = pool.x - pool.x[i]
    r2 = (r**2).sum(axis=1)
    near = np.flatnonzero((r2 < radius2) & (r2 > 0.0))
    r, r2, df = r[near], r2[near], (f - f[i])[near]
    w = np.array([quartic_weight(value, radius2) for value in r2])
    n = ((r**2).T * w / r2).sum(axis=1)
    a = (r[:, 0] * r[:, 1] * w / r2).sum() / n
    c = (r.T * df * w / r2).sum(axis=1) / n
    printed = (c - a * c[::-1]) / (1.0 - a[0] * a[1])
    np.testing.assert_allclose(least_squares(pool, f)[i], printed, rtol=1e-9)


@dims
@powers
@pytest.mark.parametrize("shape", ["alone", "pair", "coincident"])
def test_degenerate_neighbourhoods_fly_free(dim, power, shape):
    index = {
        "alone": np.zeros((1, dim)),
        "pair": np.eye(dim)[:1] * [[0], [1]],
        "coincident": np.zeros((6, dim)),
    }[shape]
    pool = free(index)
    out = least_squares(pool, np.arange(pool.n, dtype=float), power)
    assert np.all(pool.role == BALLISTIC) and np.all(out == 0.0)


@dims
@powers
@pytest.mark.parametrize("shape", ["line", "flat"])
def test_flat_neighbourhoods_give_the_slope_along_them_only(dim, power, shape):
    index = {
        "line": np.arange(9)[:, None] * np.eye(dim)[:1],
        "flat": np.stack(np.meshgrid(*[np.arange(7)] * (dim - 1), [0], indexing="ij"), axis=-1).reshape(-1, dim),
    }[shape]
    pool = free(index)
    middle = np.argmin(np.linalg.norm(pool.x - pool.x.mean(axis=0), axis=1))
    f = pool.x[:, 0] + 5.0 * pool.x[:, -1]     # the last does not vary
    out = least_squares(pool, f, power, floor=0.05)
    assert pool.role[middle] == INNER
    assert 0.98 < out[middle, 0] <= 1.0 and np.abs(out[middle, 1:]).max() < 1e-12


@dims
@powers
def test_one_neighbour_more_than_dimensions_is_enough(dim, power):
    corner = np.vstack([np.zeros(dim), np.eye(dim)])
    pool = free(corner)
    f, grad, _ = monomials(pool.x, 1)[0]
    assert np.all(least_squares(pool, f, power)[0] == 0.0) and pool.role[0] == BALLISTIC
    pool = free(np.vstack([corner, -0.8 * np.ones((1, dim))]))
    f, grad, _ = monomials(pool.x, 1)[0]
    np.testing.assert_allclose(least_squares(pool, f, power)[0], grad[0], atol=1e-12)
    assert pool.role[0] == INNER


@powers
def test_the_floor_sets_where_the_slope_across_is_damped(power):
    pool = free(np.stack(np.meshgrid(np.arange(8), [0, 0.35]), axis=-1).reshape(-1, 2))
    i, m = 3, np.empty((2, 2))
    second_moment(m, i, pool.cloud, (RADIUS[power] * pool.spacing) ** 2, power)
    measure = np.linalg.det(m) / (0.5 * np.trace(m)) ** 2
    f, grad, _ = monomials(pool.x, 1)[1]
    out = least_squares(pool, f, power, floor=0.999 * measure)
    assert pool.role[i] == INNER
    np.testing.assert_allclose(out[i], grad[i], atol=1e-10)
    out = least_squares(pool, f, power, floor=1.001 * measure)
    assert pool.role[i] == INNER
    np.testing.assert_allclose(out[i], grad[i], atol=1e-3)      # it begins at nothing below the floor
    assert not np.allclose(out[i], grad[i], atol=1e-8)
    flatter = least_squares(pool, f, power, floor=2.0 * measure)
    assert 0.5 * grad[i, 1] < flatter[i, 1] < out[i, 1] < grad[i, 1]


def test_only_owned_rows_are_written():
    pool = block(2, 6)
    out = np.full((5, 2), np.nan)
    gradient.least_squares_gradient(out, nowhere(out), pool.cloud._replace(indptr=pool.indptr[:6]),
                                    pool.x[:, 0].copy(), Form(2.1 * pool.spacing, 2, 0.05))
    np.testing.assert_allclose(out, np.tile([1.0, 0.0], (5, 1)), atol=1e-12)


# -- the symmetric form ----------------------------------------------------------------------------


@dims
def test_symmetric_gradient_conserves_momentum(dim):
    pool = block(dim, 9 if dim == 2 else 5, jitter=1.2, reach=3.6)
    pool.role[: pool.n // 3] = SURFACE
    p = np.random.default_rng(0).normal(size=pool.n)
    out = symmetric(pool, p)
    assert np.abs(out.sum(axis=0)).max() < 1e-13 * np.abs(out).sum()
    # pair by pair: the forces on two particles are opposite
    two = free([[0.0] * dim, [0.7] * dim], reach=3.6)
    force = symmetric(two, np.array([1.0, 3.0]))
    np.testing.assert_allclose(force[0], -force[1], rtol=1e-14)
    assert np.all(force[0] > 0.0), "pressure pushes the first particle away from the second"


@dims
def test_symmetric_gradient_is_the_printed_sum(dim):
    pool = block(dim, 6 if dim == 2 else 4, jitter=0.8, reach=3.6)
    pool.role[1] = DRY
    p = np.random.default_rng(1).normal(size=pool.n)
    h, volume = 1.8 * pool.spacing, pool.spacing**dim
    i = pool.at(*[2] * dim)
    expected = np.zeros(dim)
    for j in set(range(pool.n)) - {i, 1}:
        r = pool.x[i] - pool.x[j]
        expected += volume * (p[i] + p[j]) * cubic_spline_slope(np.linalg.norm(r), h, dim) * r
    out = symmetric(pool, p)
    np.testing.assert_allclose(out[i], expected, rtol=1e-11)
    assert np.all(out[1] == 0.0)


@dims
def test_symmetric_gradient_inside_a_lattice(dim):
    pool = block(dim, 11 if dim == 2 else 9, reach=3.6)
    inside = pool.far_inside(4)
    assert np.abs(symmetric(pool, np.full(pool.n, 7.0))[inside]).max() < 1e-11, "constant pressure"
    f, grad, _ = monomials(pool.x, 1)[0]
    np.testing.assert_allclose(symmetric(pool, f)[inside], grad[inside], atol=0.01)


# -- walls -----------------------------------------------------------------------------------------


def moved_walls(pool, u, wall_u):
    u = u.copy()
    gradient.wall_velocity(u, pool.cloud, wall_u, np.zeros_like(wall_u), 2.6 * pool.spacing)
    if pool.dim == 3:
        gradient.slip_along_edges(u, pool.cloud, wall_u, 2.6 * pool.spacing)
    return u


@dims
def test_wall_velocity_has_the_walls_normal_part_and_the_fluids_tangential_part(dim):
    pool = tank((7,) * dim if dim == 2 else (5,) * dim, jitter=0.8)
    flow, wall_u = np.arange(1.0, dim + 1.0), np.tile(np.linspace(-0.5, 0.5, dim), (pool.n, 1))
    u = np.where(pool.fluid[:, None], flow, np.nan)
    out = moved_walls(pool, u, wall_u)
    np.testing.assert_array_equal(out[pool.fluid], u[pool.fluid])
    flat = (pool.role == WET) & (pool.corner == 0)
    n = pool.normal
    along = ((wall_u - flow) * n).sum(axis=1)[:, None] * n + flow
    np.testing.assert_allclose(out[flat], along[flat], atol=1e-12)
    planes = ((pool.index == 0) | ((pool.index == pool.top) & (np.arange(dim) < dim - 1))).sum(axis=1)
    edges = (pool.role == WET) & (planes == 2) & (dim == 3)    # fluid slips along them
    free_axis = np.abs(n) < 1e-9
    np.testing.assert_allclose(out[edges], np.where(free_axis, flow, wall_u)[edges], atol=1e-12)
    assert dim == 2 or edges.sum() > 20
    others = (pool.kind == WALL) & ~flat & ~edges  # corners, and the contact line: in no stencil
    np.testing.assert_array_equal(out[others], wall_u[others])


@pytest.mark.parametrize("degrees", [10.0, 30.0, 90.0, 150.0])
def test_fluid_slips_along_an_edge_of_any_angle_and_direction(degrees):
    """A node on a slanting edge, with further ones beside it. Those of other walls and edges do not count."""
    turn, flow = np.radians(degrees), np.array([1.0, 2.0, -3.0])
    along, first, side = np.linalg.qr(np.random.default_rng(2).normal(size=(3, 3)))[0]
    second = np.cos(turn) * first + np.sin(turn) * side
    fluid = np.random.default_rng(3).normal(size=(40, 3))
    edge = [(0.0 * along, first + second, 1), (along, first + second, 1), (-1.1 * along, first + second, 1)]
    further = [(1.3 * np.cross(along, first), first, 0), (along + first + second, first + second, 1)]
    for wall, slips in ((edge[:1], False), (edge[:2], True), (edge + further, True)):
        pool = free(np.vstack([*(place for place, _, _ in wall), fluid]))
        n = len(wall)
        pool.kind[:n], pool.role[:n], pool.corner[:n] = WALL, WET, [corner for _, _, corner in wall]
        pool.normal[:n] = [normal / np.linalg.norm(normal) for _, normal, _ in wall]
        wall_u = np.tile([0.3, 0.2, 0.1], (pool.n, 1))
        out = moved_walls(pool, np.where(pool.fluid[:, None], flow, np.nan), wall_u)
        np.testing.assert_allclose(out[0], wall_u[0] + slips * ((flow - wall_u[0]) @ along) * along, atol=1e-12)


@dims
def test_a_velocity_that_changes_along_a_wall_is_continued_beside_corners_too(dim):
    """u = (x, ...) above the bed. The mean of the fluid is .5 s off beside a corner, the damped slope .08 s."""
    pool = tank((9,) * dim if dim == 2 else (6,) * dim)
    u = np.zeros((pool.n, dim))
    u[:, 0] = pool.x[:, 0]
    bed = (pool.role == WET) & (pool.corner == 0) & (pool.normal[:, -1] > 0.9)
    out = moved_walls(pool, np.where(pool.fluid[:, None], u, np.nan), np.zeros_like(u))
    error = np.abs(out - u)[bed].max(axis=1) / pool.spacing
    assert error.max() < 0.1
    assert error[np.abs(pool.index[bed, 0] - 0.5 * pool.top[0]) < 1.6].max() < 5e-3, "in the middle"


def test_wall_velocity_without_fluid_is_the_walls_own():
    pool = tank((7, 7))
    pool.x[pool.fluid] += 100.0
    pool.relist()
    wall_u = np.random.default_rng(0).normal(size=pool.x.shape)
    out = moved_walls(pool, np.ones((pool.n, 2)), wall_u)
    np.testing.assert_array_equal(out[~pool.fluid], wall_u[~pool.fluid])


def test_tangential_extrapolation_sees_shear_and_damps_disorder():
    pool = tank((9, 9))
    bed = pool.at(4, 0)
    layers = np.where(pool.fluid, pool.index[:, 1], 0.0)
    shear = np.stack([layers, np.zeros(pool.n)], axis=1)
    found = moved_walls(pool, shear, np.zeros_like(shear))[bed, 0]
    # a full linear fit would give 0, none at all the weighted mean of the layers 1 and 2
    assert 0.0 < found < 1.0
    noise = np.random.default_rng(0).normal(size=(300, pool.n, 2))
    spread = np.std([moved_walls(pool, u, np.zeros_like(u))[bed, 0] for u in noise])
    assert spread < 0.7, "the noise of the fluid is averaged, not amplified"
