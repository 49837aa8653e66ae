"""Which particles lie on the free surface: gap rule, auxiliary functions, density rule."""

import numpy as np
import pytest

from parisph.base.fields import ABSENT, BALLISTIC, DRY, INNER, SURFACE, WALL
from parisph.kernels import surface
from parisph.methods.surfaces import PositionDivergence
from tests.pools import block, dims, free, part, tank

ENTER, LEAVE, THIN = 2.3, 1.4, 0.55
GAP_RADIUS, DOMAIN = 2.0, 2.6
jitters = pytest.mark.parametrize("jitter", [0.0, 0.4])


def by_gap(pool, was=None, alpha=None, enter=ENTER, leave=LEAVE):
    """Return the roles of the fluid by the gap rule (walls keep theirs)."""
    role = pool.role.copy()
    was = np.where(pool.fluid, INNER, pool.role).astype(np.int8) if was is None else was
    surface.surface_by_gap(role, was, pool.cloud, pool.walls, pool.ratio() if alpha is None else alpha,
                           GAP_RADIUS * pool.spacing, surface.Gap(enter, leave, THIN))
    return role


def by_auxiliary(pool, was, alpha=None):
    role = pool.role.copy()
    alpha = pool.ratio() if alpha is None else alpha
    surface.surface_by_auxiliary_functions(role, was.astype(np.int8), pool.cloud, pool.walls, alpha,
                                           DOMAIN * pool.spacing, 0.9)
    return role


def divergence(pool):
    found = np.full(pool.n, np.nan)
    surface.position_divergence(found, pool.cloud, pool.walls, 1.3 * pool.spacing)
    return found


def by_divergence(pool):
    limit = PositionDivergence.limits[pool.dim]
    return np.where(pool.fluid, np.where(divergence(pool) < limit, SURFACE, INNER), pool.role)


def around(*degrees, distance=1.0):
    """Return particle 0 with neighbours in these directions; only particle 0 is meant to be looked at."""
    angle = np.radians(degrees)
    return free(np.vstack([[0.0, 0.0], distance * np.stack([np.cos(angle), np.sin(angle)], axis=1)]))


def first(pool, was=INNER, alpha=1.0, **thresholds):
    """Return the role of particle 0 by the gap rule, given its role before and its density ratio."""
    return by_gap(pool, np.full(pool.n, was, np.int8), np.full(pool.n, alpha), **thresholds)[0]


def square(side):
    return np.stack(np.meshgrid(np.arange(side), np.arange(side), indexing="ij"), axis=-1).reshape(-1, 2)


# -- known shapes, gap rule ---------------------------------------------------------------------------


@jitters
@pytest.mark.parametrize("lid", [False, True])
def test_flat_surface_in_a_tank(jitter, lid):
    pool = tank((14, 10), lid, jitter)
    role = by_gap(pool)
    expected = np.where(pool.fluid & ~lid & (pool.index[:, 1] == 10), SURFACE, INNER)
    np.testing.assert_array_equal(role[pool.fluid], expected[pool.fluid])
    np.testing.assert_array_equal(role[~pool.fluid], pool.role[~pool.fluid])


@jitters
def test_rim_of_a_block_and_its_corners(jitter):
    pool = block(2, 12, jitter)
    role = by_gap(pool)
    rim = ~pool.far_inside(1)
    assert np.all(role[rim] == SURFACE)
    assert np.all(role[~rim] == INNER)


def test_inner_corner_of_a_step():
    index = square(12)
    pool = free(index[(index[:, 0] < 6) | (index[:, 1] < 6)])
    role = by_gap(pool)
    for where in ((5, 11), (5, 8), (8, 5), (11, 5), (0, 0), (11, 0)):
        assert role[pool.at(*where)] == SURFACE, where
    # in the inner corner neighbours leave free one right angle only
    assert role[pool.at(5, 5)] == INNER
    assert role[pool.at(4, 4)] == role[pool.at(3, 9)] == INNER


@pytest.mark.parametrize(("width", "inner"), [(1, 0), (2, 0), (3, 1), (4, 2)])
def test_jets(width, inner):
    index = np.stack(np.meshgrid(np.arange(20), np.arange(width), indexing="ij"), axis=-1).reshape(-1, 2)
    pool = free(index)
    middle = (index[:, 0] > 2) & (index[:, 0] < 17)
    role = by_gap(pool)[middle]
    assert np.count_nonzero(role == INNER) == inner * len(np.unique(index[middle, 0]))
    assert np.all(role[(index[middle, 1] == 0) | (index[middle, 1] == width - 1)] == SURFACE)


def test_hole():
    index = square(13)
    pool = free(index[np.abs(index - 6).max(axis=1) > 2])
    role, ring = by_gap(pool), np.abs(pool.index - 6).max(axis=1) == 3
    flat = ring & (np.abs(pool.index - 6).min(axis=1) <= 2)
    assert np.count_nonzero(flat) == 20 and np.all(role[flat] == SURFACE)
    assert np.all(role[(np.abs(pool.index - 6).max(axis=1) == 4)] == INNER)


def test_single_vacancy_is_no_surface():
    index = square(9)
    pool = free(index[(index != 4).any(axis=1)])
    role = by_gap(pool)
    assert np.all(role[pool.far_inside(1)] == INNER)


def test_detached_particles_and_drops():
    pool = free(np.vstack([square(8), [[20, 20], [30, 30], [31, 30], [40, 40], [41, 40], [40, 41], [41, 41]]]))
    assert np.all(by_gap(pool)[64:] == SURFACE)


def test_particles_under_an_overturning_crest_close_to_the_surface_below():
    # two bodies of fluid, closer than the radius but with a gap to see between them
    lower, upper = square(10), square(10) + [0, 10.8]
    pool = free(np.vstack([lower, upper]))
    role = by_gap(pool)
    facing = np.isin(pool.index[:, 1], (9, 10.8)) & (np.abs(pool.index[:, 0] - 4.5) < 3)
    assert np.all(role[facing] == INNER), "a slit narrower than the radius is no surface"
    pool = free(np.vstack([lower, upper + [0, 0.4]]))
    role = by_gap(pool)
    facing = np.isin(pool.index[:, 1], (9, 11.2)) & (np.abs(pool.index[:, 0] - 4.5) < 3)
    assert np.all(role[facing] == SURFACE), "a wider one is"


# -- thresholds ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(("gap", "was", "expected"), [
    (2.35, INNER, SURFACE), (2.25, INNER, INNER), (2.25, SURFACE, SURFACE), (2.25, BALLISTIC, SURFACE),
    (1.45, SURFACE, SURFACE), (1.45, BALLISTIC, SURFACE), (1.45, INNER, INNER), (1.35, SURFACE, INNER),
    (1.35, BALLISTIC, INNER), (2.35, SURFACE, SURFACE),
])
def test_hysteresis(gap, was, expected):
    # neighbours at equal angles over the rest of the circle, none within the gap; any orientation
    count = int(np.ceil((2.0 * np.pi - gap) / 0.5))
    for turn in (0.0, 37.0, 181.0, 333.0):
        pool = around(*(turn + np.degrees(np.linspace(gap, 2.0 * np.pi, count + 1))))
        assert first(pool, was) == expected


@pytest.mark.parametrize("was", [INNER, SURFACE])
def test_thresholds_are_arguments(was):
    pool = around(0, 60, 120, 180, 240, 300)  # gaps of 1.047
    assert first(pool, was, enter=1.6, leave=1.1) == INNER
    assert first(pool, was, enter=1.6, leave=1.0) == (SURFACE if was == SURFACE else INNER)


def test_eight_neighbours_all_around_with_a_right_angle_free():
    # every octant is occupied, and yet a gap of 1.5 is free: on the surface it stays there
    pool = around(1, 44, 46, 91 + 43, 136, 181, 226, 271, 316, 359)
    gaps = np.diff(np.sort([1, 44, 46, 134, 136, 181, 226, 271, 316, 359, 361]))
    assert np.radians(gaps.max()) == pytest.approx(1.536, abs=1e-3)
    assert first(pool, SURFACE) == SURFACE and first(pool, INNER) == INNER
    assert first(pool, SURFACE, leave=1.56) == INNER


def test_only_neighbours_within_the_radius_close_the_gap():
    assert first(around(0, 90, 180, 270, distance=1.99)) == INNER
    assert first(around(0, 90, 180, 270, distance=2.01)) == SURFACE


@pytest.mark.parametrize(("alpha", "expected"), [(0.54, SURFACE), (0.56, INNER)])
def test_thin_fluid_lies_on_the_surface(alpha, expected):
    assert first(around(*range(0, 360, 45)), alpha=alpha) == expected


def test_particle_in_the_same_place_closes_no_gap():
    pool = around(*range(90, 271, 30))
    assert first(pool) == SURFACE
    double = free(np.vstack([pool.index, [[0.0, 0.0]]]))
    assert first(double) == SURFACE


def test_surface_keeps_its_particles_on_the_way_down():
    # a vacancy beside particles of the surface: hysteresis keeps them, others do not join
    index = square(9)
    pool = free(index[(index != 4).any(axis=1)])
    pool.x[pool.at(4, 3), 1] -= 0.1 * pool.spacing  # out of the radius of the particle opposite
    was = np.full(pool.n, INNER, np.int8)
    was[pool.at(4, 5)] = SURFACE
    role = by_gap(pool, was)
    assert role[pool.at(4, 5)] == SURFACE and role[pool.at(4, 3)] == role[pool.at(3, 4)] == INNER


# -- walls ---------------------------------------------------------------------------------------------


# fluid along a wall whose particles are three or four times as far apart: its elements stand for it
@pytest.mark.parametrize(("every", "find"), [
    (3, lambda pool: by_gap(pool, alpha=np.ones(pool.n))),
    (4, lambda pool: by_auxiliary(pool, np.where(pool.fluid & (np.arange(pool.n) % 2 == 0), SURFACE, INNER),
                                  np.ones(pool.n)))])
def test_elements_close_the_gap_and_occupy_quadrants_at_a_wall_of_few_particles(every, find):
    pool = tank((12, 10))
    sparse = part(pool, pool.fluid | (pool.index % every == 0).any(axis=1))
    assert np.all(find(sparse)[sparse.fluid & (sparse.index[:, 1] < 10)] == INNER)


def test_drop_touching_a_wall_is_surface_all_round():
    index = np.array([[5, 1], [6, 1], [5, 2], [6, 2]])
    pool = tank((11, 10))
    keep = (pool.kind == WALL) | (pool.index[:, None] == index).all(axis=2).any(axis=1)
    drop = part(pool, keep)
    assert np.all(by_gap(drop)[drop.fluid] == SURFACE)


@jitters
@pytest.mark.parametrize("rule", ["gap", "auxiliary", "density", "divergence"])
def test_absent_lid_one_spacing_above_the_water(rule, jitter):
    """Its particles stand where neighbours would be, and so does what would be across it."""
    pool = tank((14, 10), lid=True, jitter=jitter)
    top = pool.fluid & (pool.index[:, 1] == 9)
    pool.x[top] = pool.spacing * pool.index[top]
    pool.relist()
    lid = ~pool.fluid & (pool.index[:, 1] >= 9)
    was = np.where(top, SURFACE, INNER).astype(np.int8)
    for absent, expected in ((False, INNER), (True, SURFACE)):
        pool.kind[lid] = ABSENT if absent else WALL
        if rule == "gap":
            role = by_gap(pool, was)
        elif rule == "auxiliary":
            role = by_auxiliary(pool, was, pool.ratio())
        elif rule == "divergence":
            role = by_divergence(pool)
        else:
            role = pool.role.copy()
            surface.surface_by_density(role, pool.cloud, pool.ratio(), 0.9)
        assert np.all(role[top] == expected)
        assert rule == "density" or np.all(role[pool.fluid & (pool.index[:, 1] < 8)] == INNER)


# -- auxiliary functions (Zheng, Ma & Duan 2014, Sec. 2.4.2) --------------------------------------------


def was_top(pool):
    return np.where(pool.fluid & (pool.index[:, 1] == pool.top[1]), SURFACE, INNER)


@jitters
def test_auxiliary_functions_find_a_flat_surface(jitter):
    pool = tank((14, 10), jitter=jitter)
    was = np.where(pool.fluid, was_top(pool), pool.role)
    role = by_auxiliary(pool, was)
    top = pool.fluid & (pool.index[:, 1] == 10)
    assert np.all(role[top] == SURFACE)
    if jitter == 0.0:
        assert np.all(role[pool.fluid & ~top] == INNER)
    else:  # a density ratio below 0.9 beside the surface is condition (b)
        below = pool.fluid & ~top & (role == SURFACE)
        assert np.all(pool.ratio()[below] <= 0.9) and np.count_nonzero(below) <= 3


def ring(*degrees, was_centre=INNER, was_ring=INNER, alpha=1.0, one_on_surface=True):
    """Return the role of particle 0 with neighbours in these directions, the last of them on the surface before."""
    pool = around(*degrees)
    was = np.full(pool.n, was_ring)
    was[0] = was_centre
    if one_on_surface:
        was[-1] = SURFACE
    return by_auxiliary(pool, was, np.full(pool.n, alpha))[0]


ALL_ROUND = (10, 55, 100, 145, 190, 235, 280, 325)


def test_condition_a_no_inner_particle_near():
    assert ring(*ALL_ROUND, was_ring=SURFACE) == SURFACE
    assert ring(*ALL_ROUND) == INNER


@pytest.mark.parametrize(("alpha", "expected"), [(0.9, SURFACE), (0.901, INNER)])
def test_condition_b_thin_and_near_the_surface(alpha, expected):
    assert ring(*ALL_ROUND, alpha=alpha) == expected


@pytest.mark.parametrize(("degrees", "role"), [
    # condition (c): all four sectors about the axes hold a particle, the quadrant x, y > 0 does not
    ((-40, -44, 134, 136, 170, 225, 226, 271, -10, 100), SURFACE),
    ((-40, -44, 134, 136, 170, 225, 226, 271, -10, 100, 45), INNER),
    # condition (d): all four quadrants hold a particle, the sector about +y does not
    ((30, 40, 140, 150, 200, 250, 290, 340), SURFACE), ((30, 40, 140, 150, 200, 250, 290, 340, 91), INNER),
    # a neighbour on an axis occupies both sides
    ((0, 90, 180, 270), INNER), ((45, 135, 225, 315), INNER), ((0, 90, 180), SURFACE),
])
def test_empty_quadrants_and_sectors_about_an_axis(degrees, role):
    assert ring(*degrees) == role


@pytest.mark.parametrize("alpha", [0.5, 1.0])
def test_only_the_surface_and_its_neighbours_are_candidates(alpha):
    # condition (e) included: a particle that was deep inside is no candidate, however thin
    assert ring(0, 10, alpha=alpha, one_on_surface=False) == INNER
    assert ring(0, 10, alpha=alpha, one_on_surface=False, was_centre=SURFACE) == SURFACE
    assert ring(0, 10, alpha=alpha, one_on_surface=False, was_centre=BALLISTIC) == SURFACE


def test_condition_e_is_within_the_others():
    # thin, at most two quadrants and two sectors: a former surface particle counts itself (NumA >= 1)
    assert ring(80, 100, alpha=0.5, one_on_surface=False, was_centre=SURFACE) == SURFACE


def test_particle_in_the_same_place_occupies_no_quadrant():
    pool = free(np.vstack([around(170, 190, 200).index, [[0.0, 0.0]]]))
    was = np.array([INNER, INNER, INNER, SURFACE, INNER])
    assert by_auxiliary(pool, was, np.ones(5))[0] == SURFACE


# -- density rule --------------------------------------------------------------------------------------


@pytest.mark.parametrize("dim", [2, 3])
def test_density_rule(dim):
    pool = tank((10, 8) if dim == 2 else (7, 7, 7))
    role = pool.role.copy()
    surface.surface_by_density(role, pool.cloud, pool.ratio(), 0.9)
    np.testing.assert_array_equal(role, pool.role)
    pool.role[pool.kind == WALL] = DRY
    alpha = np.where(np.arange(pool.n) % 2 == 0, 0.9, np.nextafter(0.9, 0.0))
    surface.surface_by_density(role, pool.cloud, alpha, 0.9)
    np.testing.assert_array_equal(role[pool.fluid] == SURFACE, alpha[pool.fluid] < 0.9)


# -- divergence of position ------------------------------------------------------------------------------

SIDES = {2: (14, 10), 3: (8, 8, 8)}


@dims
@pytest.mark.parametrize("jitter", [0.0, 0.4, 0.8])
def test_divergence_of_position_inside_is_the_number_of_dimensions(dim, jitter):
    pool = tank(SIDES[dim], lid=True, jitter=jitter)
    found = divergence(pool)
    assert np.all(found[~pool.fluid] == dim)
    np.testing.assert_allclose(found[pool.fluid], dim, atol=0.012 * dim if jitter == 0.0 else 0.5 * jitter * dim)
    assert found[pool.fluid].mean() == pytest.approx(dim, rel=0.03)
    assert np.all(by_divergence(pool)[pool.fluid] == INNER)


@dims
@pytest.mark.parametrize("jitter", [0.0, 0.4, 0.8])
def test_divergence_finds_a_flat_surface_in_a_tank(dim, jitter):
    """Also beside the walls, which are neighbours, as is what is across them."""
    pool = tank(SIDES[dim], jitter=jitter)
    top = pool.fluid & (pool.index[:, -1] == pool.top[-1])
    role = by_divergence(pool)
    assert np.all(role[top] == SURFACE) and np.all(role[pool.fluid & ~top] == INNER)


def test_divergence_on_a_lattice_with_a_surface():
    """The row itself, and half of all others; the spline with h = 1.3 s reaches two rows far."""
    pool = tank(SIDES[2])
    h, s = 1.3, pool.spacing
    a = np.arange(-2, 3)
    r = np.hypot(*np.meshgrid(a, a, indexing="ij"))
    q = r / h
    # of W, over the scale
    slope = np.where(q < 1.0, 1.5 * q**2 - 2.0 * q, np.where(q < 2.0, -0.5 * (2.0 - q) ** 2, 0.0))
    part_of = -15.0 / (7.0 * np.pi * h**2) * slope * q
    found = divergence(pool)
    assert found[pool.at(7, 10)] == pytest.approx(part_of[:, :3].sum(), rel=1e-12)
    assert found[pool.at(7, 9)] == pytest.approx(part_of[:, :4].sum(), rel=1e-12)
    assert found[pool.at(7, 5)] == pytest.approx(part_of.sum(), rel=1e-12) and s == 0.1


@dims
@pytest.mark.parametrize("jitter", [0.0, 0.4])
def test_divergence_finds_the_rim_of_a_block_and_its_corners(dim, jitter):
    pool = block(dim, 12 if dim == 2 else 8, jitter)
    role, rim = by_divergence(pool), ~pool.far_inside(1)
    assert np.all(role[rim] == SURFACE) and np.all(role[~rim] == INNER)
    corner = pool.at(*[0] * dim)
    assert divergence(pool)[corner] < 0.5 * dim


def test_divergence_in_an_inner_corner_at_a_hole_and_at_a_vacancy():
    index = square(12)
    step = free(index[(index[:, 0] < 6) | (index[:, 1] < 6)])
    role = by_divergence(step)
    for where in ((5, 11), (5, 8), (8, 5), (11, 5), (0, 0), (11, 0)):
        assert role[step.at(*where)] == SURFACE, where
    assert role[step.at(5, 5)] == role[step.at(4, 4)] == INNER
    index = square(13)
    hole = free(index[np.abs(index - 6).max(axis=1) > 2])
    distance = np.abs(hole.index - 6).max(axis=1)
    flat = (distance == 3) & (np.abs(hole.index - 6).min(axis=1) <= 1)
    role = by_divergence(hole)
    assert np.all(role[flat] == SURFACE) and np.all(role[distance == 4] == INNER)
    vacancy = free(index[(index != 6).any(axis=1)])
    assert np.all(by_divergence(vacancy)[vacancy.far_inside(1)] == INNER)


@dims
def test_divergence_of_particles_that_are_alone(dim):
    """Alone, in a pair, and with one that lies in the same place, which has no direction."""
    far = np.array([10.0, *[0.0] * (dim - 1)])
    pool = free(np.vstack([0.0 * far, far, far + np.eye(dim)[0], 2.0 * far, 2.0 * far]))
    found = divergence(pool)
    assert found[0] == found[3] == found[4] == 0.0 and 0.0 < found[1] == found[2] < 0.25 * dim
    assert np.all(by_divergence(pool) == SURFACE)
