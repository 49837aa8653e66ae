"""The norms against values worked out by hand, and their guards."""

import numpy as np
import pytest

from parisph.truth import norms
from run_scripts.studies.dam_break_measures import noise_of

T = np.linspace(0.0, 10.0, 1001)


def test_relative_l2_of_a_scaled_series_is_the_scale():
    truth = np.sin(T)
    assert norms.relative_l2(1.03 * truth, truth) == pytest.approx(0.03)


def test_the_wave_part_does_not_see_the_depth_but_z14_does():
    wave = 0.001 * np.sin(T)
    assert norms.relative_l2(0.5 + 1.2 * wave, 0.5 + wave, 0.5) == pytest.approx(0.2)
    flattered = 0.2 * np.linalg.norm(wave) / np.linalg.norm(0.5 + wave)
    assert norms.relative_l2(0.5 + 1.2 * wave, 0.5 + wave) == pytest.approx(flattered)
    assert flattered < 4e-4


def test_z17_divides_an_l2_by_a_sum():
    assert norms.z17_elevation(np.array([1.0, 2.0, 5.0]), np.array([1.0, 2.0, 2.0])) == pytest.approx(3.0 / 5.0)
    with pytest.raises(ValueError, match="adds up to zero"):
        norms.z17_elevation(np.array([1.0, 0.0]), np.array([1.0, -1.0]))


def test_comparison_is_on_the_reference_samples_that_overlap():
    t, found, truth = norms.on_reference([0.0, 1.0, 2.0], [0.0, 10.0, 20.0], [-1.0, 0.5, 1.5, 2.0, 3.0],
                                         [9.0, 5.0, 15.0, 20.0, 9.0])
    np.testing.assert_array_equal(t, [0.5, 1.5, 2.0])
    np.testing.assert_allclose(found, truth)
    t, found, _ = norms.on_reference([0.0, 1.0, 2.0], [0.0, 10.0, 20.0], [-1.0, 0.5, 1.5, 2.0, 3.0],
                                     np.zeros(5), shift=1.0)
    np.testing.assert_array_equal(t, [1.5, 2.0, 3.0])
    np.testing.assert_allclose(found, [5.0, 10.0, 20.0])
    with pytest.raises(ValueError, match="fewer than two"):
        norms.on_reference([0.0, 1.0], [0.0, 1.0], [1.5, 2.5], [0.0, 0.0])


def test_comparison_with_a_coarse_reference_is_on_the_samples_of_the_run():
    """As with a constant, or a ramp, that is given by its ends only."""
    t, found, truth = norms.on_reference([0.0, 1.0, 2.0], [5.0, 6.0, 9.0], [-1.0, 1.0, 1e9], [0.0, 2.0, 1e9 + 1])
    np.testing.assert_array_equal(t, [0.0, 1.0, 2.0])
    np.testing.assert_array_equal(found, [5.0, 6.0, 9.0])
    np.testing.assert_allclose(truth, [1.0, 2.0, 3.0])
    t, found, _ = norms.on_reference([0.0, 1.0, 2.0], [5.0, 6.0, 9.0], [2.0, 1e9], [1.0, 1.0], shift=1.0)
    np.testing.assert_array_equal((t, found), [[2.0, 3.0], [6.0, 9.0]])
    assert norms.judge(T, np.full_like(T, 1.02), [0.0, 1e9], [1.0, 1.0])["relative_l2"] == pytest.approx(0.02)
    with pytest.raises(ValueError, match="fewer than two"):
        norms.on_reference([0.0, 1.0], [0.0, 1.0], [0.5, 0.9e9], [0.0, 0.0], shift=-0.6)


@pytest.mark.parametrize("late", [0.137, -0.05, 0.2])
def test_best_shift_finds_a_late_start(late):
    front = lambda t: 1.0 + 0.5 * t**2  # noqa: E731
    reference_time = np.linspace(0.0, 4.0, 16)
    shift = norms.best_shift(T, front(T), reference_time, front(reference_time - late), limit=0.2)
    assert shift == pytest.approx(late, abs=2e-5)


def test_judge_gives_wave_part_and_the_papers_norm():
    found = norms.judge(T, 0.5 + 0.0012 * np.sin(T), T[::7], 0.5 + 0.001 * np.sin(T[::7]), rest=0.5)
    assert found["relative_l2"] == pytest.approx(0.2, rel=1e-3)
    assert found["z14"] == pytest.approx(2.8e-4, rel=0.05)
    assert (found["samples"], found["start"], found["end"]) == (143, 0.0, 9.94)
    assert norms.judge(T, T + 1, T, T + 1)["relative_l2"] == 0.0


def test_noise_of_a_ripple_on_a_slow_pressure():
    """A ripple of 10 ms on a steady pressure has std a/sqrt(2); its moving mean over 5 periods is nothing."""
    t = np.linspace(0.0, 4.0, 40001)
    p = 1000.0 + 30.0 * np.sin(2 * np.pi * t / 0.01)
    assert noise_of(t, p, (1.0, 3.0)) == pytest.approx(0.03 / np.sqrt(2), rel=0.01)
    assert noise_of(t, 1000.0 + 300.0 * t, (1.0, 3.0)) < 1e-3
    assert noise_of(T, np.where(T < 2.0, 1e6, 1000.0), (2.0, 9.0)) < 1e-12, "it does not look outside its window"


def test_noise_does_not_depend_on_how_the_time_is_cut():
    def trace(t):
        return 1000.0 + 30.0 * np.sin(2 * np.pi * t / 0.02)

    even = np.linspace(0.0, 2.0, 20001)
    uneven = np.unique(np.concatenate((np.linspace(0.0, 1.0, 10001), np.linspace(1.0, 2.0, 40001))))
    assert noise_of(uneven, trace(uneven), (0.2, 1.8)) == pytest.approx(noise_of(even, trace(even), (0.2, 1.8)),
                                                                           rel=1e-3)


def test_the_moving_mean_of_a_line_is_the_line_inside_and_shorter_at_the_ends():
    t = np.sort(np.random.default_rng(1).uniform(0.0, 2.0, 200))
    found = norms.moving_mean(t, 3.0 * t + 1.0, 0.4)
    inside = (t >= t[0] + 0.2) & (t <= t[-1] - 0.2)
    assert found[inside] == pytest.approx(3.0 * t[inside] + 1.0)
    assert found[0] == pytest.approx(3.0 * (t[0] + 0.1) + 1.0), "the mean of the half that is there"


def test_a_cut_has_interpolated_ends_and_must_be_inside():
    t, p = norms.cut(np.array([0.0, 1.0, 2.0]), np.array([0.0, 2.0, 0.0]), (0.5, 1.25))
    assert np.allclose(t, [0.5, 1.0, 1.25]) and np.allclose(p, [1.0, 2.0, 1.5])
    with pytest.raises(ValueError, match="the window from 1 to 3 s is not inside the series"):
        norms.cut(np.array([0.0, 2.0]), np.array([0.0, 2.0]), (1.0, 3.0))


def test_even_times_undo_a_denser_part():
    t = np.concatenate((np.arange(0.0, 1.0, 0.001), np.arange(1.0, 3.01, 0.1)))
    even, p = norms.evenly(t, 2.0 * t)
    assert np.allclose(np.diff(even), 0.001) and even[-1] == pytest.approx(3.0) and np.allclose(p, 2.0 * even)


@pytest.mark.parametrize("value, truth, message",
                         [([1.0, np.nan], [1.0, 1.0], "not numbers"), ([1.0], [1.0, 2.0], "one length"),
                          ([1.0, 2.0], [0.0, 0.0], "at rest"), ([], [], "empty")])
def test_a_series_that_cannot_be_judged_is_refused(value, truth, message):
    with pytest.raises(ValueError, match=message):
        norms.relative_l2(value, truth)
