"""The corrected stepping: frequency and damping of an oscillator, and how far its correction goes."""

import numpy as np
import pytest
from mpi4py import MPI

from parisph.base.fields import WALL, FieldSet
from parisph.methods.stepping import SHARE, STEPPINGS, Accelerations
from parisph.parallel.particles import Particles


def particles(n=1):
    p = Particles(MPI.COMM_SELF, 2, FieldSet(Accelerations.fields))
    p.assign({"x": np.zeros((n, 2))})
    return p


def oscillation(dt, corrected, wave_time=np.inf, end=60.0):
    """Return the times and positions of x'' = -x from x = 1 at rest, stepped as a projection steps."""
    p, earlier = particles(), Accelerations()
    p.x[:] = 1.0, 0.0
    found = [1.0]
    for k in range(round(end / dt)):
        middle = (k + 0.5) * dt
        at = p.x + 0.5 * dt * p.u
        if corrected:
            at += earlier.ahead(p, middle, dt, wave_time)
        start, a = p.u.copy(), -at
        earlier.remember(p, a, middle, dt, dt)
        p.u += dt * a
        p.x += 0.5 * dt * (start + p.u)
        found.append(p.x[0, 0])
    return dt * np.arange(len(found)), np.array(found)


def frequency_error(dt, corrected):
    """Return the relative error of the frequency, from the last zero of x."""
    t, x = oscillation(dt, corrected)
    k = np.flatnonzero(x[:-1] * x[1:] < 0.0)[-1]
    zero = np.interp(0.0, *zip(*sorted(((x[k], t[k]), (x[k + 1], t[k + 1])))))
    return abs((np.round(zero / np.pi - 0.5) + 0.5) * np.pi / zero - 1.0)


def test_the_frequency_is_of_fourth_order_and_that_of_the_midpoint_of_second():
    midpoint, corrected = ([frequency_error(dt, word) for dt in (0.2, 0.1)] for word in (False, True))
    assert midpoint == pytest.approx([0.04 / 24.0, 0.01 / 24.0], rel=0.05)
    assert corrected[0] < 0.05 * midpoint[0]
    assert np.log2(corrected[0] / corrected[1]) > 3.5


def amplitude(t, x):
    """Return the amplitude of a wave of frequency 1."""
    return np.hypot(*np.linalg.lstsq(np.stack([np.cos(t), np.sin(t)], axis=1), x, rcond=None)[0])


def test_it_damps_by_a_part_of_fifth_order():
    lost = {}
    for dt in (0.4, 0.2):
        t, x = oscillation(dt, True)
        early, late = t < 12.0, t > 48.0
        lost[dt] = np.log(amplitude(t[early], x[early]) / amplitude(t[late], x[late])) / 48.0
        assert lost[dt] == pytest.approx(dt**5 / 24.0, rel=0.2)
    assert np.log2(lost[0.4] / lost[0.2]) > 4.5


@pytest.mark.parametrize("dt", [0.5, 0.7, 0.85, 0.95])
def test_the_shortest_deep_water_wave_of_a_lattice_is_not_driven(dt):
    """Its frequency is sqrt(pi g/s); steps of dt sqrt(s/g). Without the fade the last two would drive it."""
    w = np.sqrt(np.pi)
    for wave_time, stable in ((w, True), (np.inf, dt < 0.8)):
        _, x = oscillation(w * dt, True, wave_time)
        assert (np.abs(x).max() < 1.0 + 1e-9) == stable


def test_the_acceleration_of_a_step_cut_short_is_forgotten():
    p, earlier = particles(), Accelerations()
    earlier.remember(p, np.array([[1.0, 2.0]]), 0.1, 0.2, 0.2)
    earlier.remember(p, np.array([[1e3, 0.0]]), 0.2, 1e-4, 0.2)
    assert earlier.times == [0.1] and p.acceleration.tolist() == [[1.0, 2.0]]


def test_steps_of_any_length_extrapolate_a_linear_change():
    p, earlier = particles(3), Accelerations()
    p.kind[2] = WALL
    slope = np.array([[1.0, 2.0], [-1.0, 0.5], [7.0, 7.0]])
    np.testing.assert_array_equal(earlier.ahead(p, 0.1, 0.2, np.inf), 0.0)
    for time in (0.1, 0.35):
        earlier.remember(p, time * slope, time, 0.2, 0.2)
    np.testing.assert_allclose(earlier.ahead(p, 0.5, 0.3, np.inf), SHARE * 0.09 * 0.5 * slope * [[1], [1], [0]],
                               rtol=1e-12)
    # after a short step it goes no farther beyond than the last step went
    earlier.remember(p, 0.36 * slope, 0.36, 0.2, 0.2)
    np.testing.assert_allclose(earlier.ahead(p, 0.6, 0.3, np.inf)[:2], SHARE * 0.09 * 0.37 * slope[:2], rtol=1e-12)


def test_only_this_stepping_needs_fields():
    assert {name: word.fields for name, word in STEPPINGS.items() if word.fields} == {"corrected": Accelerations.fields}
