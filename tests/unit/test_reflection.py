"""Incident and reflected waves from gauges, for waves that are known."""

import numpy as np
import pytest

from parisph.truth.reflection import separated

K, PERIOD = 3.0, 1.3
TIMES = np.linspace(2.0, 2.0 + 3.0 * PERIOD, 200)


def elevations(places, incident, reflected, phase=0.7):
    """Return both waves with a second harmonic, a level and a trend."""
    omega, x, t = 2.0 * np.pi / PERIOD, np.asarray(places)[:, None], TIMES
    eta = incident * np.cos(K * x - omega * t) + reflected * np.cos(K * x + omega * t + phase)
    return eta + 0.1 * incident * np.cos(2.0 * (K * x - omega * t)) + 0.4 + 0.01 * t


@pytest.mark.parametrize("places", [(0.0, 0.5), (1.0, 1.3, 1.7), (0.2, 0.3, 0.9, 2.5)])
@pytest.mark.parametrize("share", [0.0, 0.05, 1.0, 3.0])
def test_both_waves_are_found_to_rounding(places, share):
    found = separated(TIMES, elevations(places, 0.02, share * 0.02), places, PERIOD, K)
    assert found.incident == pytest.approx(0.02, abs=1e-13)
    assert found.reflected == pytest.approx(share * 0.02, abs=1e-13)
    assert found.reflection == pytest.approx(share, abs=1e-11) and found.residual < 1e-11


def test_a_wave_of_another_length_is_a_residual():
    places = (0.0, 0.4, 0.9)
    assert separated(TIMES, elevations(places, 0.02, 0.0), places, PERIOD, 1.2 * K).residual > 0.05


@pytest.mark.parametrize("places", [(0.0, np.pi / K), (0.3, 0.3), (0.3,)])
def test_gauges_that_cannot_tell_them_apart(places):
    with pytest.raises(ValueError, match="cannot tell the waves apart"):
        separated(TIMES, elevations(places, 0.02, 0.01), places, PERIOD, K)


def test_too_short_a_time_or_another_shape():
    with pytest.raises(ValueError, match="less than a period"):
        separated(TIMES[:40], elevations((0.0, 0.5), 0.02, 0.0)[:, :40], (0.0, 0.5), PERIOD, K)
    with pytest.raises(ValueError, match="not one row for each"):
        separated(TIMES, elevations((0.0, 0.5), 0.02, 0.0).T, (0.0, 0.5), PERIOD, K)
