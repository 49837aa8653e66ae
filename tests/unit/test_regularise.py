"""Regularisation is in proportion to the strain of a step, and leaves what is not strained alone."""

from types import SimpleNamespace

import numpy as np
import pytest

from parisph.base.fields import FLUID, SURFACE
from parisph.case.presets import WITHOUT_FILMS
from parisph.kernels import strain
from parisph.methods import potential, regularising, straining, velocities
from tests.scenes import scene, simulated


@pytest.fixture
def falling():
    """A column that has fallen for a while, with roles, lists and matrix of its last step."""
    s = simulated(scene("dam_break", spacing=0.05, jitter=0.4), 40)
    yield s


def apply(method, regularisers):
    """Apply regularisers after ghosts have their positions."""
    method.flow.domain.update("x")
    regularising.prepare(method.flow, regularisers, 0.01)
    regularising.change(method.flow, regularisers, 0.01)


def strain_of_step(method, dt):
    """Return the strain of a step (n_owned,)."""
    method.flow.step.potential = potential.find(method.flow)
    straining.begin(method.flow, fit=True)
    straining.finish(method.flow, dt)
    return method.flow.step.strained


def moved(s, strained):
    """Return how far `positions` moves the particles, in spacings: (n_owned,)."""
    p = s.particles
    x = p.x.copy()
    s.method.flow.step.strained = strained
    apply(s.method, s.method.parts.position_regularisers)
    lengths = np.linalg.norm(p.x - x, axis=1) / s.numerics.spacing
    p.x[:] = x
    s.domain.update("x")
    return lengths


def test_moves_are_in_proportion_to_the_strain_and_bounded(falling):
    s, p = falling, falling.particles
    strained = strain_of_step(s.method, 1e-3)
    strained *= 1e-3 / strained.max()    # far from the greatest strengths
    small, twice = moved(s, strained), moved(s, 2.0 * strained)
    assert small.max() > 1e-5 and small[p.kind != FLUID].max() == 0.0
    inside = (p.role == 0) & (p.kind == FLUID)
    assert np.linalg.norm(twice[inside]) == pytest.approx(2.0 * np.linalg.norm(small[inside]), rel=0.01)
    large = moved(s, 1e6 * strained)
    assert large.max() < 0.3
    assert p.turn.max() == pytest.approx(0.15 * s.method.flow.step.whole * s.numerics.spacing)    # 3 x .05 s


def test_strain_far_below_that_of_a_fall_counts_with_its_square(falling):
    p, method = falling.particles, falling.method
    u, method.flow.step.by_pressure = p.u.copy(), np.full(p.n_owned, 9.81)
    once = {}
    for factor in (1e-7, 2e-7, 1e4, 2e4):
        p.u[:] = factor * u
        once[factor] = strain_of_step(method, 0.01)
    assert once[1e-7].max() > 0.0
    np.testing.assert_allclose(once[2e-7], 4.0 * once[1e-7], rtol=1e-3)
    fast = once[1e4] > 1.0
    np.testing.assert_allclose(once[2e4][fast], 2.0 * once[1e4][fast], rtol=1e-2)
    method.flow.step.by_pressure = np.zeros(p.n_owned)    # in free fall everything counts
    p.u[:] = 1e-7 * u
    np.testing.assert_allclose(strain_of_step(method, 0.01), 1e-11 * once[1e4], rtol=1e-2)


def test_an_impact_is_remembered_for_a_hundred_times_sqrt_of_spacing_over_acceleration():
    flow = SimpleNamespace(spacing=0.1, mean_acceleration=0.0)
    for acceleration, time, mean in ((40.0, 1.0, 40.0), (10.0, 1.0, 39.6), (0.0, 1.0, 39.6), (10.0, 80.0, 10.0)):
        straining.remember(flow, acceleration, time * 0.1)
        assert flow.mean_acceleration == pytest.approx(mean)


@pytest.mark.parametrize(("acceleration", "closed", "part"), [(10.0, False, 0.5), (1e3, False, 1.0), (0.0, False, 1.0),
                                                              (10.0, True, 1.0)])
def test_steps_below_a_fiftieth_of_sqrt_of_spacing_over_acceleration_regularise_less(acceleration, closed, part):
    flow = SimpleNamespace(spacing=0.1, mean_acceleration=acceleration, closed=closed)
    assert straining.whole(flow, 0.001) == pytest.approx(part)


def test_velocities_do_not_pay_for_moves(falling):
    u = falling.particles.u.copy()
    strain_of_step(falling.method, 0.01)
    apply(falling.method, falling.method.parts.position_regularisers)
    np.testing.assert_array_equal(falling.particles.u, u)


def test_fluid_at_rest_and_in_rigid_motion_is_left_alone(falling):
    s, p = falling, falling.particles
    for velocity in (np.zeros_like(p.x), np.tile([3.0, -2.0], (p.n_owned, 1)), p.x[:, ::-1] * [1.0, -1.0]):
        p.u[:] = velocity
        strained = strain_of_step(s.method, 0.01)
        assert strained.max() < 1e-12
    close = p.role == SURFACE
    assert moved(s, np.zeros(p.n_owned))[~close].max() == 0.0


def test_what_nothing_needs_is_not_computed():
    off = {"filter_strain": 0.0, "collision_distance": 0.0, "kappa": 0.0, "shift": 0.0,
           "regularisers": ("film", *WITHOUT_FILMS)}
    s = simulated(scene("dam_break", off, spacing=0.1))
    assert not s.method.parts.measures_strain
    assert not {"grad_u", "strain_rate", "pairs", "phi", "turn"} & set(s.particles.fields)
    s.advance()     # the filter with a fixed strength needs no strain
    assert not s.method.flow.step.strained.any()


def test_strain_is_rapid_beside_the_pressure_of_calm_fluid():
    """Below a wave it is calm; in rapid strain and in free fall everything is compression."""
    a, spacing, dt = np.full(4, 9.81), 0.05, 0.01
    rate = np.sqrt(a / spacing) * np.array([0.0, 0.02, straining.RAPID, 10.0])
    strained, rapid, doubt = judged(rate, a, spacing, dt)
    np.testing.assert_allclose(rapid, [0.0, 0.0, 0.5, 1.0], atol=0.02)
    np.testing.assert_allclose(doubt, straining.DOUBT * (1.0 - rapid), rtol=1e-12)
    np.testing.assert_allclose(strained, dt * rate * [1.0, 0.8, 0.97, 1.0], rtol=0.01)    # less of what is slow
    strained, rapid, doubt = judged(rate, np.zeros(4), spacing, dt)
    np.testing.assert_array_equal(rapid, 1.0)
    np.testing.assert_array_equal(doubt, 0.0)
    np.testing.assert_allclose(strained, dt * rate, rtol=1e-14)


def judged(rate, by_pressure, spacing, dt):
    out = np.full((3, len(rate)), np.nan)
    strain.judge(out, rate, by_pressure, spacing, dt, straining.REST, straining.RAPID, straining.DOUBT)
    return out


def test_rotation_is_removed_at_the_rate_of_the_filter_and_less_in_rapid_flow():
    """filter dt sqrt(a/s) is .1 for the first two, and more than 1 for the last."""
    beyond = np.array([[1.0, -2.0], [1.0, -2.0], [3.0, 0.0]])
    step = SimpleNamespace(potential=SimpleNamespace(beyond=beyond), by_pressure=np.array([10.0, 10.0, 1e5]),
                           rapid=np.array([0.0, 0.6, 0.5]))
    flow = SimpleNamespace(step=step, spacing=0.1, numerics=SimpleNamespace(filter=0.5, filter_strain=0.0))
    np.testing.assert_allclose(potential.Irrotational().change(flow, 0.02), -np.array([[0.1], [0.04], [0.5]]) * beyond)


def test_fluid_moves_with_no_velocity_that_takes_it_into_a_wall(falling):
    s, p = falling, falling.particles
    s.domain.update("x")
    kept = velocities.keep_in_tank(s.method.flow, np.full_like(p.u, -5.0), 0.01)
    fluid = p.kind == FLUID
    room = s.numerics.wall_guard * s.numerics.spacing
    assert (p.x + 0.01 * kept)[fluid].min() > (1.0 - 1e-9) * min(room, p.x[fluid].min())
    assert np.all(kept[fluid] <= 1e-12) and kept[fluid].min() == -5.0


def test_moves_together_lead_no_farther_than_the_cap_but_for_a_free_one():
    one = np.array([[0.03, 0.0], [0.08, 0.0], [0.1, 0.0]])
    free = np.array([[0.0, 0.04], [0.09, 0.0], [0.4, 0.0]])
    regularising.cap_together({"projection": one, "parting": free}, ["parting"], 0.1)
    np.testing.assert_allclose(np.linalg.norm(one + free, axis=1), [0.05, 0.1, 0.4])


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("names", ["ab", "abc", "abcd"])
def test_moves_keep_their_directions_and_their_shares(dim, names):
    random = np.random.default_rng(3)
    moves = {name: random.normal(size=(50, dim)) * random.uniform(0.0, 0.1, size=(50, 1)) for name in names}
    before = {name: move.copy() for name, move in moves.items()}
    regularising.cap_together(moves, ["b"], 0.1)
    whole = np.linalg.norm(sum(before.values()), axis=1)
    longest = np.maximum(0.1, np.linalg.norm(before["b"], axis=1))
    share = np.minimum(1.0, longest / whole)
    assert 0 < np.count_nonzero(share < 1.0) < 50
    for name in names:
        np.testing.assert_allclose(moves[name], share[:, None] * before[name], rtol=1e-12)


def test_each_preparation_finds_the_pairs_where_particles_are(falling):
    s, p = falling, falling.particles
    regularising.prepare(s.method.flow, s.method.parts.position_regularisers, 1e-3)
    before = len(s.method.flow.close_pairs(0.7).indices)
    assert len(s.method.flow.close_pairs(0.7).indices) == before > 0
    x = p.x.copy()
    p.x[:] *= 10.0
    regularising.prepare(s.method.flow, (), 1e-3)
    assert len(s.method.flow.close_pairs(0.7).indices) == 0
    p.x[:] = x
