"""The source of the pressure equation: its parts, each alone."""

import numpy as np
import pytest

from parisph.base.fields import INNER, SURFACE
from parisph.kernels import mixed_source
from parisph.kernels.rankine import Invariants
from parisph.kernels.records import cloud_of

N = 4
ROLE = np.array([INNER, INNER, INNER, SURFACE], np.int8)


def target(div=0.0, square=0.0, rate=0.0, before=0.0, force=0.0, dt=0.01, usual=0.01, zeta=1.0, strain=0.0,
           per_strain=0.0, expansion=(), time=1.0, left=0.0):
    """Return the target over rho/dt of four particles, of numbers or arrays; s = .1 m."""
    out = np.full(N, np.nan)
    div, square, rate, before, left = (np.broadcast_to(np.asarray(one, float), N).copy()
                                       for one in (div, square, rate, before, left))
    pull = np.tile([0.6 * force, -0.8 * force], (N + 1, 1))
    lists, none = np.zeros(N + 2, np.int32), np.zeros((N + 1, 2))
    cloud = cloud_of(none, ROLE, ROLE, none, lists, lists[:0], 0.1)
    mixed_source.mixed(out, np.asarray(expansion, float), cloud, div, left, Invariants(square, rate, before), pull,
                       mixed_source.Weights(1000.0, dt, usual, zeta, strain, per_strain, time))
    return out * dt / 1000.0


def test_divergence_has_its_weight():
    div = np.array([0.0, 1.0, -2.0, 5.0])
    np.testing.assert_allclose(target(div, zeta=0.25), 0.25 * div, rtol=1e-15)


def test_straight_steps_in_a_straining_flow_keep_volume():
    """det(1 + dt G) = 1 + dt div u - dt^2/2 tr(G^2) + ... with G = diag(g, -g) and the divergence that is aimed at."""
    g, dt = 0.5, 0.01
    aimed = -target(square=2.0 * g * g, strain=1.0, dt=dt)    # the target is of what is to be removed
    np.testing.assert_allclose(aimed, dt * g * g, rtol=1e-14)
    half = 0.5 * aimed[0]
    volume = (1.0 + dt * (g + half)) * (1.0 + dt * (half - g))
    assert volume == pytest.approx(1.0, abs=1e-9) and (1.0 + dt * g) * (1.0 - dt * g) < 1.0 - 2e-5


def test_the_strain_source_is_limited():
    for square in (1e9, -1e9):
        np.testing.assert_allclose(target(square=square, strain=1.0), -np.sign(square) * 0.01 / 0.01, rtol=1e-14)


@pytest.mark.parametrize(("rate", "force", "removed"), [(2.0, 0.0, 0.2), (0.0, 0.9, 0.3), (2.0, 0.9, 0.3),
                                                        (50.0, 0.0, 1.0), (0.0, 0.0, 0.0)])
def test_a_residual_is_removed_at_the_rate_of_strain_or_of_free_fall(rate, force, removed):
    """sqrt(g/s) = 3/s for g = .9 m/s^2; ten times as much is removed of it in a step of .01 s."""
    found = target(div=0.7, before=0.5, rate=rate, force=force, per_strain=10.0)
    np.testing.assert_allclose(found, 0.7 - (1.0 - removed) * 0.5, rtol=1e-13)


def test_a_step_shortened_to_meet_a_time_removes_the_same_part_per_time():
    whole = target(before=0.5, rate=50.0, per_strain=10.0)
    short = target(before=0.5, rate=50.0, per_strain=1000.0, dt=0.001)
    np.testing.assert_allclose(whole, 0.0, atol=1e-15)
    np.testing.assert_allclose(short, -0.9 * 0.5, rtol=1e-13)


def test_the_residual_is_beyond_what_the_step_before_aimed_at():
    """It aimed at strain dt/2 tr(G^2), which the flow has reduced by dt tr(G^2) since."""
    for strain in (0.0, 1.0, 0.5):
        before = -(2.0 - strain) * 0.01 * 0.5 * 0.08
        put_off = target(before=before, square=0.08, per_strain=10.0, strain=strain)
        np.testing.assert_allclose(put_off, target(square=0.08, strain=strain), rtol=1e-12, atol=1e-18)


@pytest.mark.parametrize(("left", "before"), [(0.3, 0.3), (0.6, 0.0), (-0.1, 0.7)])
def test_the_volume_made_is_by_the_mean_of_both_divergences_and_given_back_in_a_time(left, before):
    """Ten steps of .001 s with .3/s in the mean, where operators were and where they are next, make .3 %."""
    expansion, inner = np.zeros(N), ROLE == INNER
    for _ in range(10):
        found = target(before=before, left=left, dt=0.001, expansion=expansion, time=2.0)
    np.testing.assert_allclose(expansion[inner], 0.003, rtol=1e-13)
    np.testing.assert_allclose(found[inner], 0.003 / 2.0, rtol=1e-13)
    assert found[~inner] == 0.0 and expansion[~inner] == 0.0


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_volume_that_cannot_be_removed_does_not_grow_for_ever(sign):
    expansion = np.zeros(N)
    for _ in range(5):
        target(before=sign, left=sign, expansion=expansion)
    np.testing.assert_allclose(expansion[ROLE == INNER], sign * mixed_source.EXPANSION, rtol=1e-14)
