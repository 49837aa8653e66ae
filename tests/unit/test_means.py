"""Means of pressures in time keep their integral."""

import json

import numpy as np
import pytest

from parisph.watch.means import Means

SPANS = np.random.default_rng(4).uniform(0.2, 2.0, 60)
ENDS = np.cumsum(SPANS)
MIDDLES = ENDS - 0.5 * SPANS


def line(pressures, windows, ends=ENDS, means=None):
    """Return the times and values of the line at the middles of all steps, each read as soon as it is known."""
    starts = np.concatenate([[0.0], ends[:-1]])
    middles = 0.5 * (starts + ends)
    means, found = means or Means(0.0, pressures[0]), []
    for number, step in enumerate(zip(starts, ends, middles, pressures, windows)):
        means.add(*step)
        last = number == len(ends) - 1
        while len(found) <= number and (last or middles[len(found)] <= means.known):
            found.append(means.at(middles[len(found)], last)[0])
    return middles, np.array(found)


@pytest.mark.parametrize("window", [0.0, 1.0, 5.0])
def test_pulses_have_their_impulse_however_steps_and_windows_change(window):
    """The pulse of one step, as long as both ends are at rest."""
    windows = window * np.random.default_rng(5).uniform(0.5, 1.5, len(ENDS))
    for number in (20, 21, 22, 35):
        pulse = np.zeros((len(ENDS), 2))
        pulse[number] = 1.0, -3.0
        middles, shown = line(pulse, windows)
        impulse = 0.5 * np.diff(middles) @ (shown[1:] + shown[:-1])
        np.testing.assert_allclose(impulse, SPANS[number] * pulse[number], rtol=1e-12)
        assert shown[:, 0].max() <= 1.0 and (shown[:, 0] >= 0.0).all()


def test_what_is_constant_stays_and_what_grows_evenly_in_even_steps():
    assert line(np.full((60, 1), 7.0), np.full(60, 3.0))[1] == pytest.approx(7.0)
    ends = np.arange(1.0, 61.0)
    for window in (0.5, 1.0):
        middles, shown = line(np.arange(60.0)[:, None] + 0.5, np.full(60, window), ends)
        np.testing.assert_allclose(shown[:, 0], middles)
    middles, shown = line(np.arange(60.0)[:, None] + 0.5, np.full(60, 2.0), ends)
    np.testing.assert_allclose(shown[2:-3, 0], middles[2:-3])    # the last knots are closer


def test_a_restart_goes_on_to_the_last_bit():
    pressures, windows = np.random.default_rng(6).normal(size=(60, 3)), np.full(60, 2.5)
    pressures[30] = np.nan
    whole, other = Means(0.0, pressures[0]), Means(0.0, pressures[0])
    for number, step in enumerate(zip(ENDS - SPANS, ENDS, MIDDLES, pressures, windows)):
        whole.add(*step)
        other = Means.resumed(json.loads(json.dumps(other.state(), default=np.ndarray.tolist)))
        other.add(*step)
        assert other.known == whole.known
        for a, b in zip(whole.at(whole.known), other.at(whole.known)):
            np.testing.assert_array_equal(a, b)
        assert whole.knots == other.knots
    assert np.isfinite(whole.at(whole.known)[0]).all(), "what was no number does not stay"
    assert len(whole._steps) < 10 and len(whole._acted) < 10


def test_what_acted_is_told_too():
    means = Means(0.0, [1.0])
    for end, value in ((1.0, 2.0), (2.0, 9.0), (3.0, 4.0), (4.0, 4.0)):
        means.add(end - 1.0, end, end - 0.5, [value], 0.0)
    assert means.known == 2.5
    mean, acted = means.at(2.5)
    assert acted == 4.0 and mean == pytest.approx(4.0 + 5.0 / 8.0)
    assert means.at(2.0)[1] == 6.5 and means.at(3.5, ended=True)[0] == 4.0
