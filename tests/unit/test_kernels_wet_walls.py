"""Which wall particles touch the fluid."""

import numpy as np
import pytest

from parisph.base.fields import BALLISTIC, CONTACT, DRY, INNER, SURFACE, WALL, WET
from parisph.kernels import wetness
from tests.pools import dims, filled, part, tank


def wetted(pool, closing=True):
    role = np.where(pool.fluid, pool.role, DRY).astype(np.int8)
    closing = np.where((pool.kind == WALL) & closing, wetness.CLOSING, wetness.APART).astype(np.int8)
    wetness.wet_walls(pool.cloud._replace(role=role), closing)
    assert np.array_equal(role[pool.fluid], pool.role[pool.fluid])
    return role


@dims
@pytest.mark.parametrize("jitter", [0.0, 0.4])
def test_tank_filled_in_part(dim, jitter):
    depth = 5
    pool = filled((9,) * dim if dim == 2 else (6, 6, 8), depth, jitter=jitter)
    role, walls = wetted(pool), ~pool.fluid
    height = pool.index[:, -1]
    np.testing.assert_array_equal(role[walls & (height < depth)], WET)
    np.testing.assert_array_equal(role[walls & (height > depth)], DRY)
    # the wall nodes beside the surface, also in vertical edges: the contact line
    line = walls & (height == depth)
    np.testing.assert_array_equal(role[line], CONTACT)
    assert np.count_nonzero(line & (pool.corner == 1)) == (0 if dim == 2 else 4)
    inside = walls & (pool.corner == 1) & (height == 0)
    assert np.count_nonzero(inside) and np.all(role[inside] == WET)


@dims
def test_column_on_a_dry_bed(dim):
    pool = filled((12, 7) if dim == 2 else (10, 5, 7), 5, width=4)
    role = wetted(pool)
    bed = ~pool.fluid & (pool.index[:, -1] == 0) & (pool.corner == 0)
    x = pool.index[:, 0]
    np.testing.assert_array_equal(role[bed & (x < 4)], WET)
    np.testing.assert_array_equal(role[bed & (x == 4)], CONTACT)
    np.testing.assert_array_equal(role[bed & (x > 4)], DRY)
    far = ~pool.fluid & (x == pool.top[0])
    assert np.all(role[far] == DRY)


@dims
def test_empty_tank_is_dry(dim):
    pool = tank((6,) * dim)
    empty = part(pool, ~pool.fluid)
    assert np.all(wetted(empty) == DRY)


def beside_wall(*offsets, role=INNER):
    """Return the role of a bed node with fluid of one role at these offsets from it [s]."""
    pool = tank((12, 8))
    pool = part(pool, ~pool.fluid | ((pool.index[:, 0] < len(offsets) + 1) & (pool.index[:, 1] == 1)))
    i = pool.at(6, 0)
    pool.x[pool.fluid] = pool.x[i] + pool.spacing * np.array(offsets, float)
    pool.role[pool.fluid] = role
    pool.relist()
    return wetted(pool)[i]


@pytest.mark.parametrize(("offsets", "role", "expected"), [
    ([(-0.5, 1.0), (0.5, 1.0)], INNER, WET),
    ([(-0.5, 1.0), (0.5, 1.0)], SURFACE, CONTACT),           # no inner particle near
    ([(-0.5, 1.0), (0.5, 1.0)], BALLISTIC, DRY),             # spray does not wet walls
    ([(0.0, 1.0), (0.5, 1.0)], INNER, DRY),                  # fluid on one side only
    ([(-0.31, 2.0), (0.31, 2.0)], INNER, WET),
    ([(-0.29, 2.0), (0.29, 2.0)], INNER, DRY),               # on neither side
    ([(-0.5, 2.1), (0.5, 2.1)], INNER, DRY),                 # farther than 2.1 spacings
    ([(0.0, 1.0)], SURFACE, CONTACT),
    ([(0.54, 1.4)], SURFACE, CONTACT),
    ([(0.56, 1.4)], SURFACE, DRY),                           # not beside it
    ([(0.0, -1.0)], SURFACE, DRY),                           # behind it
    ([(0.0, 1.6)], SURFACE, DRY),                            # not at the wall
])
def test_limits(offsets, role, expected):
    assert beside_wall(*offsets, role=role) == expected


def test_both_sides_may_be_surface_if_one_inner_particle_is_near():
    pool = tank((12, 8))
    pool = part(pool, ~pool.fluid | ((pool.index[:, 0] < 4) & (pool.index[:, 1] == 1)))
    i = pool.at(6, 0)
    fluid = np.flatnonzero(pool.fluid)
    pool.x[fluid] = pool.x[i] + pool.spacing * np.array([(0.0, 1.2), (-1.0, 1.0), (1.0, 1.0)])
    pool.role[fluid] = [INNER, SURFACE, SURFACE]
    pool.relist()
    assert wetted(pool)[i] == WET
    pool.role[fluid[0]] = SURFACE
    assert wetted(pool)[i] == CONTACT


@dims
def test_corner_needs_an_inner_particle_only(dim):
    pool = tank((8,) * dim)
    one = part(pool, ~pool.fluid | (pool.index == 1).all(axis=1))
    i = one.at(*[0] * dim)
    for role, expected in ((INNER, WET), (SURFACE, DRY)):
        one.role[one.fluid] = role
        found = wetted(one)[i]
        assert found == expected or (role == SURFACE and found == CONTACT)


def test_wall_in_three_dimensions_needs_fluid_on_all_four_sides():
    pool = tank((8, 8, 8))
    i_index = np.array([4, 4, 0])
    sides = i_index + np.array([[1, 0, 1], [-1, 0, 1], [0, 1, 1], [0, -1, 1]])
    keep = ~pool.fluid | (pool.index[:, None] == sides).all(axis=2).any(axis=1)
    four = part(pool, keep)
    four.role[four.fluid] = INNER
    assert wetted(four)[four.at(*i_index)] == WET
    three = part(four, ~(four.index == sides[3]).all(axis=1))
    assert wetted(three)[three.at(*i_index)] == DRY


def test_slanting_wall():
    # a wall at 45 degrees: both sides along it, not along the axes
    pool = tank((12, 8))
    turn = np.array([[1.0, -1.0], [1.0, 1.0]]) / np.sqrt(2.0)
    pool.x, pool.normal = pool.x @ turn.T, pool.normal @ turn.T
    pool.relist()
    straight = tank((12, 8))
    np.testing.assert_array_equal(wetted(pool), wetted(straight))


def test_node_beside_a_corner_has_the_other_wall_at_its_side():
    # fluid starts one spacing from the walls: none fits between the corner and the node beside it
    pool = filled((9, 9), 6)
    role = wetted(pool)
    for index in ((1, 0), (0, 1), (8, 0), (9, 1), (0, 0), (9, 0)):
        assert role[pool.at(*index)] == WET, index
    # two spacings from the corner a pocket of air fits in
    pocket = part(pool, ~pool.fluid | (pool.index[:, 0] > 2))
    role = wetted(pocket)
    assert role[pocket.at(2, 0)] == role[pocket.at(1, 0)] == DRY and role[pocket.at(4, 0)] == WET


# -- which walls close the fluid off ------------------------------------------------------------------


def test_wall_that_does_not_close_the_fluid_off_is_not_wet():
    pool = filled((9, 9), 6)
    assert not (wetted(pool, closing=False) == WET).any()


GRAVITY = np.array([0.0, -10.0])


def closing(pool, u=0.0, dt=0.01, force=GRAVITY):
    """Return which particles close the fluid off, with the roles of the pool as those of the last step; u [m/s] up."""
    out = np.full(pool.n, 9, np.int8)
    velocity = np.where(pool.fluid[:, None], [0.0, u], 0.0)
    wetness.closing_walls(out, pool.cloud, velocity, np.tile(force, (pool.n, 1)), dt)
    assert not out[pool.fluid].any() and set(out) <= {wetness.APART, wetness.FREE, wetness.CLOSING}
    return out == wetness.CLOSING


def under_a_lid(gap):
    """Return a closed tank with water up to `gap` spacings below its lid, at rest: (pool, its lid)."""
    pool = tank((12, 10), lid=True)
    pool = part(pool, (pool.kind == WALL) | (pool.index[:, 1] <= 8))
    top = pool.fluid & (pool.index[:, 1] == 8)
    pool.x[pool.fluid, 1] += (2.0 - gap) * pool.spacing
    pool.role[top] = SURFACE
    pool.role[~pool.fluid] = np.where(pool.index[~pool.fluid, 1] < 8, WET, DRY)
    pool.relist()
    return pool, pool.index[:, 1] == 10


@pytest.mark.parametrize("gap", [0.2, 0.7, 1.0, 1.5, 2.0])
def test_lid_above_water_at_rest_does_not_close_it_off(gap):
    pool, lid = under_a_lid(gap)
    assert not closing(pool)[lid].any() and closing(pool)[pool.role == WET].all()


@pytest.mark.parametrize(("gap", "u", "expected"), [
    (1.0, 10.0, True),          # it reaches the lid in this step
    (1.0, 1.0, False),          # not yet
    (0.5, 1.0, True), (0.5, 0.2, True),
    (0.5, 0.005, False),        # it hardly moves, and gravity pulls it back
    (0.5, -1.0, False),
])
def test_water_that_runs_into_the_lid(gap, u, expected):
    pool, lid = under_a_lid(gap)
    nodes = lid & (pool.corner == 0)
    assert np.all(closing(pool, u)[nodes] == expected)


def test_water_line_moves_on_along_the_wall_by_one_particle():
    pool = filled((9, 9), 6)
    pool.role[~pool.fluid] = np.where(pool.index[~pool.fluid, 1] < 5, WET, DRY)     # one less than there is water
    side = (pool.index[:, 0] == 0)
    np.testing.assert_array_equal(closing(pool)[side], pool.index[side, 1] < 6)
    pool.role[pool.fluid] = SURFACE
    np.testing.assert_array_equal(closing(pool)[side], pool.index[side, 1] < 5)


def test_bed_under_falling_water_closes_it_off():
    """Without a velocity of its own: the body force brings it down."""
    pool = filled((12, 9), 3, width=5)
    pool.role[~pool.fluid] = DRY
    pool.x[pool.fluid, 1] -= 0.5 * pool.spacing
    pool.relist()
    bed = (pool.index[:, 1] == 0) & (pool.corner == 0)
    np.testing.assert_array_equal(closing(pool)[bed], pool.index[bed, 0] <= 5)
    assert not closing(pool, force=-GRAVITY)[bed].any()


@pytest.mark.parametrize("gap", [1.0, 2.0])
def test_lid_is_apart_and_walls_above_the_water_line_are_free(gap):
    pool, lid = under_a_lid(gap)
    out = np.full(pool.n, 9, np.int8)
    still = np.zeros_like(pool.x)
    pool.role[closing(pool)] = WET
    wetness.closing_walls(out, pool.cloud, still, np.tile(GRAVITY, (pool.n, 1)), 0.01)
    assert np.all(out[lid & (pool.corner == 0)] == wetness.APART)
    above = (pool.kind == WALL) & ~lid & (pool.index[:, 1] == 9)
    assert np.all(out[above] != wetness.APART)


def touched(pool, role):
    out = np.full(pool.n, 7, np.int8)
    wetness.touched_walls(out, pool.cloud._replace(role=role))
    return out


@dims
def test_walls_that_water_touches(dim):
    """The wet ones, and those above the water line as far as lists reach, 2.6 spacings, also in vertical edges."""
    depth = 4
    pool = filled((9,) * dim if dim == 2 else (6, 6, 9), depth)
    found, height, walls = touched(pool, wetted(pool)), pool.index[:, -1], ~pool.fluid
    assert np.all(found[pool.fluid] == 1)
    np.testing.assert_array_equal(found[walls], height[walls] <= depth - 1 + 2)


@pytest.mark.parametrize("gap", [1, 2])
def test_a_lid_above_water_is_not_touched_until_fluid_is_near(gap):
    pool = tank((8, 8), lid=True)
    pool = part(pool, (pool.kind == WALL) | (pool.index[:, 1] <= 8 - gap))
    pool.role[pool.fluid & (pool.index[:, 1] == 8 - gap)] = SURFACE
    role = np.where((pool.kind == WALL) & (pool.index[:, 1] > 7 - gap), DRY, pool.role).astype(np.int8)
    lid = (pool.index[:, 1] == 8) & (pool.corner == 0)
    assert not touched(pool, role)[lid].any()
    i = pool.at(4, 8 - gap)
    pool.x[i, 1] = pool.spacing * 7.3
    pool.relist()
    np.testing.assert_array_equal(np.flatnonzero(touched(pool, role) * lid), [pool.at(4, 8)])
    role[pool.at(4, 8)] = WET
    assert touched(pool, role)[lid].sum() == 5      # two on either side
