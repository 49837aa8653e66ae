"""The shifts of the literature as parts of a step: they run where fluid breaks, and spread clusters."""

import numpy as np
import pytest

from parisph.base.fields import FLUID
from parisph.kernels import shifts, wetness
from parisph.methods import lengths, regularising
from parisph.methods.parts import REGULARISERS
from tests.scenes import simulated, water

S = 0.05
SHIFTS = ["shift", "shift_tensile", "shift_xu", "shift_lind", "shift_pressure"]
all_shifts = pytest.mark.parametrize("name", SHIFTS)


def box(width, tank, lid=True, velocity=(0.0, 0.0), **numerics):
    """Return the Simulation of a box of water 0.5 m high in a tank (width, height) [m]."""
    case = water((width, 0.5), (tank[0], tank[1], lid), dict(spacing=S, time_step=0.004, **numerics), velocity=velocity)
    return simulated(case)


@all_shifts
def test_a_column_that_collapses_stays_whole(name):
    s = box(0.5, (1.5, 1.0), jitter=0.4,
            regularisers=("collisions", "wall_guard", "projection", "parting", name, "keep_apart"))
    p = s.particles
    energy = 9.81 * p.x[p.kind == FLUID, 1].sum()
    for _ in range(20):
        report = s.advance()
    fluid = p.kind == FLUID
    assert report.reason >= 0 and np.isfinite(p.x).all()
    assert 0.51 < p.x[fluid, 0].max() < 0.6
    after = 0.5 * (p.u[fluid] ** 2).sum() + 9.81 * p.x[fluid, 1].sum()
    assert abs(after / energy - 1.0) < 0.02


@all_shifts
def test_a_shift_is_the_same_before_and_after_the_position_projection(name):
    moves = []
    for order in (("projection", name), (name, "projection")):
        s = box(0.5, (1.5, 1.0), jitter=0.4, regularisers=("collisions", "wall_guard", *order))
        s.advance()
        flow = s.method.flow
        s.domain.refresh()
        flow.step.strained = np.full(s.particles.n_owned, 0.01)
        regularising.prepare(flow, [REGULARISERS[part] for part in order], 0.004)
        moves.append(REGULARISERS[name].change(flow, 0.004).copy())
    assert np.abs(moves[0]).max() > 1e-6
    np.testing.assert_allclose(moves[0], moves[1], atol=1e-6 * np.abs(moves[0]).max())


def test_the_shift_by_pressure_is_the_move_from_rest_by_its_excess():
    """dt^2/(2 rho) times the excess of the gradient, which the kernel sums."""
    s = box(1.0, (1.0, 0.5), jitter=0.4)
    s.solve_start()
    flow, excess, dt = s.method.flow, np.empty_like(s.particles.x), 1e-3
    walls = flow.walls.present(flow, wetness.FREE)
    shifts.pressure_shift(excess, flow.cloud, walls, s.particles.p_all, 1.0, lengths.MLS * S, np.inf)
    np.testing.assert_allclose(REGULARISERS["shift_pressure"].change(flow, dt), 0.5 * dt**2 * excess / 1000.0)
    assert np.abs(excess).max() > 1e3


def test_the_shift_by_speed_is_in_proportion_to_it_and_to_the_step():
    s = box(1.0, (1.0, 0.5), jitter=0.4)
    flow, fluid, part, moves = s.method.flow, s.particles.kind == FLUID, REGULARISERS["shift_xu"], []
    flow.step.strained = np.full(s.particles.n_owned, 1e-3)
    for speed, dt in ((1.0, 1e-4), (1.0, 2e-4), (4.0, 1e-4)):
        s.particles.u[fluid] = (speed, 0.0)
        regularising.prepare(flow, [part], dt)
        moves.append(part.change(flow, dt))
    np.testing.assert_allclose(moves[1:], np.multiply.outer([2.0, 4.0], moves[0]))
    assert moves[0].any()


def nearest(p):
    """Return the least distance of two particles of fluid, in spacings."""
    x = p.x[p.kind == FLUID]
    d = np.linalg.norm(x[:, None] - x[None], axis=2)
    return d[d > 0.0].min() / S


@all_shifts
def test_a_cluster_in_a_full_tank_is_spread(name):
    """Nine particles at three quarters of their distances, under the weight of still water."""
    s = box(1.0, (1.0, 0.5), shift=0.1, shift_strain=0.0, kappa=0.0)
    s.solve_start()
    p, flow = s.particles, s.method.flow
    cluster = (p.kind == FLUID) & (np.abs(p.x - (0.5, 0.25)).max(axis=1) < 1.5 * S)
    p.x[cluster] = (0.5, 0.25) + 0.75 * (p.x[cluster] - (0.5, 0.25))
    s.domain.refresh()
    p.u[p.kind == FLUID] = (1.0, 0.0)    # a speed, to which one of them is in proportion
    before = nearest(p)
    flow.step.strained = np.ones(p.n_owned)
    for _ in range(20):
        s.domain.update("x")
        regularising.prepare(flow, [REGULARISERS[name]], 0.01)
        regularising.change(flow, [REGULARISERS[name]], 0.01)
    assert before == pytest.approx(0.75)
    assert nearest(p) > 0.8
