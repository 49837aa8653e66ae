"""The fit of a pressure tap by its kernels: few particles, three dimensions, and particles that do not count."""

import numpy as np
import pytest

from parisph.kernels.tap import fitted_at_tap, tap_moments

S = 0.1


def tap(x, p, at, across=(True, False), frame=None, radius=3.0 * S):
    x, at = np.array(x, float), np.array(at, float)
    frame = np.eye(len(at)) if frame is None else frame
    moments = tap_moments(x, np.array(p, float), at, frame, np.array(across), np.full(len(at), 0.5 * S), radius)
    return fitted_at_tap(moments, len(at) + 1 - sum(across))


def test_without_particles_there_is_no_pressure():
    assert np.isnan(tap(np.empty((0, 2)), [], (0.0, 0.0)))
    assert np.isnan(tap([(0.0, 9.0)], [1.0], (0.0, 0.0)))    # out of reach
    assert np.isnan(tap([(S, 0.0)], [1.0], (0.0, 0.0)))      # on another wall


def test_one_particle_gives_its_pressure_and_two_give_the_line():
    assert tap([(0.0, 0.5 * S)], [7.0], (0.0, 0.0)) == pytest.approx(7.0, rel=1e-12)
    assert tap([(0.0, 0.0), (0.0, S)], [1.0, 3.0], (0.0, 0.25 * S)) == pytest.approx(1.5, rel=1e-12)


def test_particles_that_are_no_places_do_not_count():
    assert tap([(0.0, 0.0), (0.0, np.nan)], [5.0, 9.0], (0.0, 0.0)) == 5.0


@pytest.mark.parametrize("radius", [1.2 * S, 3.0 * S])
def test_linear_pressure_on_a_wall_in_space_is_exact(radius):
    y, z = np.meshgrid(S * np.arange(-5, 6), S * np.arange(-5, 6))
    x = np.stack([np.zeros(y.size), y.ravel(), z.ravel()], axis=1)
    for at in ((0.0, 0.01 * S, 0.0), (0.0, 0.37 * S, 0.82 * S)):
        found = tap(x, 3.0 + x @ (9.0, 2.0, -5.0), at, (True, False, False), radius=radius)
        assert found == pytest.approx(3.0 + np.dot(at, (0.0, 2.0, -5.0)), rel=1e-12)


def test_a_wall_that_has_turned_is_like_one_that_has_not():
    turn = np.array([[0.8, 0.6], [-0.6, 0.8]])    # rows: axes across and along
    x = S * np.arange(-4, 5)[:, None] * turn[1]
    along = x @ turn[1]
    assert tap(x, 2.0 + 4.0 * along, 0.3 * S * turn[1], frame=turn) == pytest.approx(2.0 + 1.2 * S, rel=1e-12)
