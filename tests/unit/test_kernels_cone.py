"""Which particles lie on the free surface in 3D: the cone rule."""

import math
from functools import lru_cache

import numpy as np
import pytest

from parisph.base.fields import ABSENT, BALLISTIC, INNER, SURFACE
from parisph.kernels import cone
from parisph.methods.surfaces import free_cone
from tests.pools import block, free, tank

RADIUS = 2.0
jitters = pytest.mark.parametrize("jitter", [0.0, 0.4])


def by_cone(pool, was=INNER, alpha=1.0, rule=None):
    """Return the roles of the fluid by the cone rule (walls keep theirs). was, alpha : one number, or of each"""
    role = pool.role.copy()
    cone.surface_by_cone(role, np.broadcast_to(np.int8(was), pool.n).copy(), pool.cloud, pool.walls,
                         np.broadcast_to(float(alpha), pool.n).copy(), RADIUS * pool.spacing, rule or free_cone())
    return role


@lru_cache(maxsize=1)
def many():
    """Return 20,000 directions, evenly on the sphere."""
    k = np.arange(20000) + 0.5
    z, turn = 1.0 - 2.0 * k / len(k), np.pi * (1.0 + math.sqrt(5.0)) * k
    flat = np.sqrt(1.0 - z**2)
    return np.stack([flat * np.cos(turn), flat * np.sin(turn), z], axis=1)


def widest(pool, i, axes):
    """Return the half angle [degrees] of the widest free cone of particle i along any of the axes (m, 3)."""
    away = pool.x - pool.x[i]
    r = np.linalg.norm(away, axis=1)
    near = (r > 0.0) & (r < RADIUS * pool.spacing)
    return np.degrees(np.arccos(np.clip((axes @ (away[near] / r[near, None]).T).max(axis=1).min(), -1.0, 1.0)))


# -- the tables -------------------------------------------------------------------------------------


def test_directions_are_even():
    axis = cone.directions()
    assert axis.shape == (162, 3)
    np.testing.assert_allclose(np.linalg.norm(axis, axis=1), 1.0, rtol=1e-14)
    np.testing.assert_allclose(axis.sum(axis=0), 0.0, atol=1e-12)
    np.testing.assert_allclose(axis.T @ axis, np.eye(3) * len(axis) / 3.0, atol=1e-11)
    assert np.degrees(np.arccos((many() @ axis.T).max(axis=1))).max() < 12.0


@pytest.mark.parametrize("angle", [42.0, 60.0])
def test_masks_hold_what_all_directions_of_a_bin_cover_and_hardly_less(angle):
    """A bin is at most 7.2 degrees wide in each direction: directions nearer by its diagonal are in its mask."""
    mask, axis = cone.masks(math.radians(angle)), cone.directions()
    cosine = many() @ axis.T
    bins = np.array([cone._bin(*one) for one in many()])
    assert len(np.unique(bins)) == len(mask)
    k = np.arange(len(axis))
    held = (mask[bins][:, k // 64] >> (k % 64).astype(np.uint64)) & np.uint64(1) == 1
    assert np.all(cosine[held] >= math.cos(math.radians(angle)))
    assert np.all(held[cosine > math.cos(math.radians(angle - 10.2))])


# -- known arrangements -----------------------------------------------------------------------------


@pytest.mark.parametrize("was, limit", [(INNER, 60.0), (SURFACE, 42.0), (BALLISTIC, 42.0)])
def test_role_is_that_of_the_widest_cone(was, limit):
    """Against all neighbours and axes, without the tables, on arrangements of any density."""
    random = np.random.default_rng(4)
    found, due = [], []
    for number in random.integers(6, 60, 300):
        away = random.normal(size=(number, 3))
        away *= (random.uniform(0.2, 1.9, number) / np.linalg.norm(away, axis=1))[:, None]
        pool = free(np.vstack([np.zeros(3), away]))
        found.append(by_cone(pool, was)[0])
        due.append(SURFACE if widest(pool, 0, cone.directions()) > limit else INNER)
    assert min(np.bincount(due, minlength=2)[:2]) > 30
    np.testing.assert_array_equal(found, due)


@pytest.mark.parametrize("half, role", [(74.0, SURFACE), (58.0, INNER)])
def test_a_cone_along_no_axis_is_seen_to_within_their_distance(half, role):
    """The widest cone is up to 12 degrees wider than that along the nearest axis."""
    for ahead in many()[::1000]:
        rest = many()[many() @ ahead < math.cos(math.radians(half))][::40]
        assert by_cone(free(np.vstack([np.zeros(3), rest])))[0] == role


@pytest.mark.parametrize("normal", [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (2.0, 1.0, 0.0)])
def test_rounding_does_not_decide_where_a_wall_is_on_the_side_of_a_cone(normal):
    """Some axes are exactly 60 degrees from the normals of walls along coordinate planes, and of a slope of 1:2."""
    toward = np.array(normal) / np.linalg.norm(normal)
    tied = cone.directions()[np.abs(cone.directions() @ toward - 0.5) < 1e-12]
    assert len(tied) >= 2
    places = [toward + 1.2e-16 * way for way in np.concatenate([np.zeros((1, 3)), np.eye(3), -np.eye(3)])]
    for axis in tied[:2]:
        wide = many()[many() @ axis < math.cos(math.radians(60.5))][::40]
        assert by_cone(free(np.vstack([np.zeros(3), wide])))[0] == SURFACE
        for place in places:
            assert by_cone(free(np.vstack([np.zeros(3), wide, place])))[0] == INNER


@jitters
@pytest.mark.parametrize("lid", [False, True])
def test_flat_surface_in_a_tank(jitter, lid):
    """Also in its corners and along its edges, and no particle below it."""
    pool = tank((8, 7, 6), lid, jitter)
    role = by_cone(pool)
    expected = np.where(pool.fluid & ~lid & (pool.index[:, 2] == 6), SURFACE, INNER)
    np.testing.assert_array_equal(role[pool.fluid], expected[pool.fluid])
    np.testing.assert_array_equal(role[~pool.fluid], pool.role[~pool.fluid])


@jitters
def test_rim_of_a_block_its_edges_and_corners(jitter):
    pool = block(3, 8, jitter)
    role = by_cone(pool)
    rim = ~pool.far_inside(1)
    assert np.all(role[rim] == SURFACE)
    assert np.all(role[~rim] == INNER)


@pytest.mark.parametrize("jitter, inside, below, on_top", [(0.4, 45.0, 45.0, 60.0), (0.8, 55.0, 58.0, 42.0)])
def test_cones_of_disorder_leave_room_for_both_limits(jitter, inside, below, on_top):
    """Of a block with a flat top: far inside, one layer below the top, and on top, the widest cones [degrees]."""
    pool = block(3, 12, jitter)
    middle = np.all((pool.index[:, :2] > 2) & (pool.index[:, :2] < 9), axis=1)
    level = pool.index[:, 2]

    def cones(where):
        return np.array([widest(pool, i, cone.directions()) for i in np.flatnonzero(where)])

    assert cones(middle & (level > 2) & (level < 9)).max() < inside
    assert cones(middle & (level == 10)).max() < below
    assert cones(middle & (level == 11)).min() > on_top


def test_few_neighbours_and_low_density():
    ball = many()[::400]
    assert by_cone(free(np.vstack([np.zeros(3), ball])))[0] == INNER
    assert by_cone(free(np.vstack([np.zeros(3), ball])), alpha=0.54)[0] == SURFACE
    six = np.vstack([np.eye(3), -np.eye(3)])    # the widest cone is 54.7 degrees
    assert by_cone(free(np.vstack([np.zeros(3), six])))[0] == INNER
    assert by_cone(free(np.vstack([np.zeros(3), six[:5]])))[0] == SURFACE


def test_absent_and_coincident_particles_do_not_count():
    pool = free(np.vstack([np.zeros((2, 3)), many()[::400]]))
    assert by_cone(pool)[0] == INNER
    pool.kind[pool.x[:, 2] > 0.3 * pool.spacing] = ABSENT
    assert by_cone(pool)[0] == SURFACE


def test_presence_of_an_element_closes_the_cone_towards_it():
    """A layer beside a wall without nodes of its own: the wall is seen by its elements alone."""
    pool = tank((8, 8, 8), True)
    beside = pool.at(1, 4, 4)
    assert by_cone(pool)[beside] == INNER
    pool.x[beside, 0] = 0.8 * pool.spacing
    pool.relist()
    for present, due in ((1.0, INNER), (0.0, SURFACE)):
        role, walls = pool.role.copy(), pool.walls
        cloud = pool.cloud._replace(kind=np.where(pool.fluid, pool.kind, np.int8(ABSENT)))
        cone.surface_by_cone(role, np.full(pool.n, INNER, np.int8), cloud,
                             walls._replace(present=np.full(len(walls.present), present)), np.ones(pool.n),
                             RADIUS * pool.spacing, free_cone())
        assert role[beside] == due
