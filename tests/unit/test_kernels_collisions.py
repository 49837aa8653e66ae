"""Pair collisions and the wall guard."""

import numpy as np
import pytest

from parisph.base.fields import WALL
from parisph.kernels import collisions, nearest_walls
from tests.pools import block, dims, free, part, tank


def collided(pool, u, distance=0.85, restitution=0.2, volume=None, gradient=None):
    """Return (velocity change (n, dim), number of collisions). Pairs that approach in smooth strain do not collide."""
    cloud = pool.cloud._replace(volume=np.ones(pool.n) if volume is None else volume)
    gradient = np.zeros((pool.n, pool.dim, pool.dim)) if gradient is None else gradient
    change, number = np.full((pool.n, pool.dim), np.nan), np.full(pool.n, -1, np.int32)
    collisions.count_collisions(number, cloud, u, distance * pool.spacing)
    pairs = collisions.pair_collisions(change, cloud, number, u, gradient, distance * pool.spacing, restitution)
    assert pairs == number.sum() or gradient.any() and pairs < number.sum()
    return change, pairs


def couple(dim, seed):
    """Return two particles .8 spacings apart, the direction from the first to the second, and the generator."""
    random = np.random.default_rng(seed)
    direction = random.normal(size=dim)
    direction /= np.linalg.norm(direction)
    return free(np.vstack([np.zeros(dim), 0.8 * direction])), direction, random


def guarded(pool, u, distance=0.5, dt=0.01):
    u = u.copy()
    slowed = nearest_walls.guard(u, pool.cloud, pool.walls_with(u, ~pool.fluid), distance * pool.spacing, dt)
    return u, slowed


# -- pair collisions ----------------------------------------------------------------------------------


@dims
@pytest.mark.parametrize("restitution", [0.2, 1.0])
def test_energy_does_not_rise_whatever_the_masses(dim, restitution):
    """Light particles between heavy ones, such as cells in the corners of tanks, that approach from all sides."""
    for seed in range(20):
        random = np.random.default_rng(seed)
        pool = block(dim, 4, jitter=0.8, seed=seed)
        volume = np.where(random.random(pool.n) < 0.5, 27.0 / 8.0, 0.05)
        u = random.normal(size=pool.x.shape) - 3.0 * (pool.x - pool.x.mean(axis=0)) / pool.spacing
        change, pairs = collided(pool, u, distance=1.1, restitution=restitution, volume=volume)
        assert pairs >= 10
        np.testing.assert_allclose(volume @ change, 0.0, atol=1e-12 * pool.n)
        assert volume @ ((u + change) ** 2 - u**2).sum(axis=1) < 0.0


@dims
@pytest.mark.parametrize("restitution", [0.0, 0.2, 1.0])
@pytest.mark.parametrize("volume", [(1.0, 1.0), (0.5, 1.5)])
def test_a_pair_keeps_its_momentum_and_an_elastic_one_its_energy(dim, restitution, volume):
    pool, direction, random = couple(dim, 0)
    u, volume = random.normal(size=(2, dim)), np.array(volume)
    approach = (u[0] - u[1]) @ direction
    u[0] += (1.0 - approach) * direction  # approaching at 1 m/s
    change, pairs = collided(pool, u, restitution=restitution, volume=volume)
    after = u + change
    assert pairs == 2, "once for each particle"
    assert (after[0] - after[1]) @ direction == pytest.approx(-restitution, abs=1e-14)
    np.testing.assert_allclose(volume @ after, volume @ u, atol=1e-14)
    tangential = change - np.outer(change @ direction, direction)
    np.testing.assert_allclose(tangential, 0.0, atol=1e-14)
    lost, reduced = 0.5 * volume @ (u**2 - after**2).sum(axis=1), volume.prod() / volume.sum()
    assert lost == pytest.approx(0.5 * reduced * (1.0 - restitution**2), abs=1e-13)


@dims
@pytest.mark.parametrize(("apart", "speed"), [(0.8, -1.0), (0.8, 0.0), (0.86, 1.0), (0.0, 1.0)])
def test_pairs_that_are_left_alone(dim, apart, speed):
    # receding, sliding past, too far apart, in the same place
    axis = np.eye(dim)[0]
    pool = free(np.vstack([np.zeros(dim), apart * axis]))
    u = np.vstack([speed * axis, np.zeros(dim)]) + np.eye(dim)[1] * [[3.0], [-3.0]]
    change, pairs = collided(pool, u)
    assert pairs == 0 and np.all(change == 0.0)


@dims
def test_impulses_are_halved_where_a_particle_is_hit_from_both_sides(dim):
    line = np.outer([-1.0, 0.0, 1.0], np.eye(dim)[0])
    change, pairs = collided(free(0.8 * line), -line, restitution=0.2)
    assert pairs == 4
    np.testing.assert_allclose(change, 0.3 * line, atol=1e-14)


@dims
def test_momentum_of_a_crowd_is_conserved_and_energy_lost(dim):
    pool = block(dim, 8 if dim == 2 else 5, jitter=1.2)
    u = np.random.default_rng(1).normal(size=pool.x.shape)
    change, pairs = collided(pool, u, restitution=0.2)
    assert pairs > 20 and pairs % 2 == 0
    np.testing.assert_allclose(change.sum(axis=0), 0.0, atol=1e-12)
    assert ((u + change) ** 2).sum() < (u**2).sum()


@dims
@pytest.mark.parametrize("seed", range(5))
def test_energy_never_rises_however_many_collide_at_once(dim, seed):
    """Particles in nearly one point, masses within a factor of 1.2: (1 + .2) m/(m + m) < 1, as the limit needs."""
    random = np.random.default_rng(seed)
    pool = free(0.3 * random.random((12, dim)))
    u, volume = random.normal(size=pool.x.shape), random.uniform(1.0, 1.2, size=12)
    change, pairs = collided(pool, u, volume=volume)
    assert pairs > 40
    assert volume @ ((u + change) ** 2).sum(axis=1) < volume @ (u**2).sum(axis=1)
    np.testing.assert_allclose(volume @ change, 0.0, atol=1e-12)


@dims
def test_smooth_strain_never_collides(dim):
    """A lattice compressed by 20 % along one axis goes on to be compressed, as in an ideal flow."""
    pool = block(dim, 8 if dim == 2 else 5)
    pool.x[:, 0] *= 0.8
    pool.relist()
    gradient = np.zeros((dim, dim))
    gradient[0, 0], gradient[1, 1], gradient[0, 1] = -1.0, 1.0, 3.0
    u = pool.x @ gradient.T
    _, without = collided(pool, u)
    change, pairs = collided(pool, u, gradient=np.tile(gradient, (pool.n, 1, 1)))
    assert without > 20 and pairs == 0 and np.all(change == 0.0)


@dims
def test_only_what_is_beyond_a_linear_velocity_collides(dim):
    pool, direction, _ = couple(dim, 3)
    gradient = -1.5 * np.eye(dim)                  # of the approach at 1 m/s, 1.5 * .8 is more than all of it
    u = np.vstack([direction, np.zeros(dim)])
    strained = np.tile(gradient, (2, 1, 1)) / pool.spacing
    assert collided(pool, u, gradient=strained)[1] == 0
    change, _ = collided(pool, u, gradient=0.25 * strained / 1.5)   # here .25 * .8 = .2 is smooth
    assert (change[0] - change[1]) @ direction == pytest.approx(-1.2 * 0.8)
    # a smooth velocity that recedes takes nothing away from what approaches
    change, _ = collided(pool, u, gradient=-strained)
    assert (change[0] - change[1]) @ direction == pytest.approx(-1.2)


@dims
def test_result_does_not_depend_on_the_order(dim):
    pool = block(dim, 6 if dim == 2 else 4, jitter=1.2)
    u = np.random.default_rng(2).normal(size=pool.x.shape)
    change, pairs = collided(pool, u)
    order = np.random.default_rng(3).permutation(pool.n)
    other = part(pool, order)
    mixed, again = collided(other, u[order])
    assert again == pairs
    np.testing.assert_allclose(mixed, change[order], atol=1e-14)


def test_walls_take_no_part():
    pool = tank((5, 5))
    pool.x[pool.fluid, 0] -= 0.4 * pool.spacing
    pool.relist()
    u = np.where(pool.fluid[:, None], [-1.0, 0.0], [5.0, 0.0])
    change, pairs = collided(pool, u, distance=0.9)
    assert pairs == 0 and np.all(change == 0.0)


# -- the wall guard -----------------------------------------------------------------------------------


def crowded(dim):
    return tank((7,) * dim if dim == 2 else (5,) * dim, jitter=0.8)


def rooms(pool, x):
    """Return the distances (n,) from the nearest wall if particles were at x."""
    return np.concatenate([x, (pool.top * pool.spacing - x)[:, :-1]], axis=1).min(axis=1)


@dims
@pytest.mark.parametrize("dt", [1e-4, 0.01, 1.0])
def test_no_particle_gets_nearer_than_the_distance(dim, dt):
    pool = crowded(dim)
    u = np.where(pool.fluid[:, None], np.random.default_rng(0).normal(scale=0.1 / dt, size=pool.x.shape), 0.0)
    after, slowed = guarded(pool, u, dt=dt)
    assert rooms(pool, pool.x + dt * after)[pool.fluid].min() >= 0.5 * pool.spacing * (1.0 - 1e-9)
    changed = np.any(after != u, axis=1)
    assert slowed == np.count_nonzero(changed) > 0
    # a particle that stays away from the wall keeps its velocity
    unhurt = pool.fluid & (rooms(pool, pool.x + dt * u) > 0.5 * pool.spacing * (1.0 + 1e-9))
    assert np.count_nonzero(unhurt) > 0 and not changed[unhurt].any() and not changed[~pool.fluid].any()


@dims
def test_guard_takes_the_part_into_the_wall_only(dim):
    pool = tank((8,) * dim)
    i = pool.at(*[4] * (dim - 1), 1)
    u = np.zeros((pool.n, dim))
    u[i] = np.arange(1.0, dim + 1.0)
    u[i, -1] = -100.0
    after, slowed = guarded(pool, u, dt=0.01)
    assert slowed == 1
    np.testing.assert_array_equal(after[i, :-1], u[i, :-1])
    assert after[i, -1] == pytest.approx(-0.5 * pool.spacing / 0.01, rel=1e-12)


def test_particle_that_is_too_near_may_leave_but_not_come_nearer():
    pool = tank((8, 8))
    i = pool.at(4, 1)
    pool.x[i, 1] = 0.2 * pool.spacing
    pool.relist()
    u = np.zeros((pool.n, 2))
    for velocity, expected in ((-1.0, 0.0), (1.0, 1.0)):
        u[i] = 0.3, velocity
        after, _ = guarded(pool, u)
        np.testing.assert_allclose(after[i], [0.3, expected], atol=1e-15)


def test_guard_in_a_corner_holds_both_walls():
    pool = tank((8, 8))
    i = pool.at(1, 1)
    u = np.zeros((pool.n, 2))
    u[i] = -100.0, -200.0
    after, slowed = guarded(pool, u)
    assert slowed == 1
    np.testing.assert_allclose(after[i], -0.5 * pool.spacing / 0.01, rtol=1e-12)


def test_guard_moves_with_the_wall():
    pool = tank((8, 8))
    i = pool.at(4, 1)
    u = np.zeros((pool.n, 2))
    u[pool.kind == WALL] = 0.0, 2.0
    after, slowed = guarded(pool, u, dt=1.0)
    # the wall comes up by 2 m a second, the particle keeps its distance
    assert slowed > 0 and after[i, 1] == pytest.approx(2.0 - 0.5 * pool.spacing, rel=1e-12)


@dims
def test_displacements_keep_off_walls(dim):
    pool = crowded(dim)
    move = np.random.default_rng(4).normal(scale=0.6 * pool.spacing, size=pool.x.shape)
    before = move.copy()
    nearest_walls.keep_off(move, pool.cloud, pool.walls, 0.5 * pool.spacing)
    assert rooms(pool, pool.x + move)[pool.fluid].min() >= 0.5 * pool.spacing * (1.0 - 1e-9)
    np.testing.assert_array_equal(move[~pool.fluid], before[~pool.fluid])
    unhurt = pool.fluid & (rooms(pool, pool.x + before) > 0.5 * pool.spacing * (1.0 + 1e-9))
    assert np.count_nonzero(unhurt) > 0
    np.testing.assert_array_equal(move[unhurt], before[unhurt])
