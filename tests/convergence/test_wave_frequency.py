"""Frequencies of standing waves, from the eigenvalues of the method on the lattice at rest.

No time stepping: an error of 0.1 % in omega_1 is an error of about 3 % of the wave in small
sloshing, where other errors hide it.
"""

from functools import lru_cache

import numpy as np
import pytest

from tests.linear_waves import DEPTH, UNIT, StillTank, exact_frequency

ACROSS = (12, 24, 40)
FIRST_ORDER = {"wall_rows": "sfdi", "gradient": "mixed", "surface_gradient": "same"}


@lru_cache(maxsize=None)
def tank(across, **overrides):
    return StillTank(across, **overrides)


@lru_cache(maxsize=None)
def waves(across, first_order=False):
    return tank(across, **(FIRST_ORDER if first_order else {})).waves()


def frequency_error(across, mode=1, first_order=False):
    """Return the relative error of omega_n."""
    values, shapes = waves(across, first_order)
    k, likeness = tank(across).mode(mode, values, shapes)
    assert likeness > 0.99 and abs(values[k].imag) < 1e-9 * abs(values[k])
    return np.sqrt(values[k].real) / exact_frequency(mode) - 1.0


def observed(errors):
    return np.diff(np.log(np.abs(errors))) / -np.diff(np.log(ACROSS))


def test_error_of_the_first_frequency():
    errors = np.array([frequency_error(n) for n in ACROSS])
    assert np.all(np.abs(errors) < [1.6e-3, 2e-4, 1.5e-4]), "measured -.136, -.002, .008 %"


def test_cubic_stencils_beat_those_of_first_order():
    recipe = np.array([frequency_error(n) for n in ACROSS])
    plain = np.array([frequency_error(n, first_order=True) for n in ACROSS])
    assert np.all(np.abs(recipe) < 0.1 * np.abs(plain)), "measured -1.76, -.44, -.15 % for these"
    assert np.all(observed(plain) >= 1.5)


@pytest.mark.parametrize(("across", "mode", "limit"), [(20, 2, 5e-4), (40, 4, 2e-3),    # 20 spacings a wavelength
                                                       (12, 2, 5e-4), (12, 3, 2e-3), (40, 2, 5e-4), (40, 3, 1e-3)])
def test_shorter_waves(across, mode, limit):
    """kd = 3.1, 4.7 and 6.3. Measured -.005, .159; -.026, .156, .034, .080 %."""
    assert abs(frequency_error(across, mode)) < limit


@pytest.mark.parametrize("across", ACROSS)
def test_level_is_neutral(across):
    values, shapes = waves(across)
    k = np.argmin(np.abs(values))
    assert abs(values[k]) < 1e-8 * exact_frequency(1) ** 2
    level = shapes[:, k].real
    np.testing.assert_allclose(level, level.mean(), atol=1e-6 * abs(level.mean()))


def test_matrix_is_what_a_step_does():
    small = StillTank(12, shift=0.0)    # which moves particles in proportion to the square of the motion
    random = np.random.default_rng(0)
    m, n, dt = len(small.surface), len(small.fluid), 0.064 * UNIT
    length = 1e-5 * DEPTH
    state = (length * random.normal(size=m), length / UNIT * random.normal(size=(n, 2)),
             *(length / UNIT**2 * random.normal(size=(2, m))))
    found = 0.5 * (small.step(*state, dt) - small.step(*(-part for part in state), dt))
    expected = small.step_matrix(dt) @ np.concatenate([part.ravel() for part in state])
    small.method.destroy()
    for part in np.split(np.arange(len(found)), [m, m + 2 * n, 2 * m + 2 * n]):
        np.testing.assert_allclose(found[part], expected[part], atol=1e-6 * np.abs(expected[part]).max())


@lru_cache(maxsize=None)
def step_eigenvalues(across, dt, stepping="corrected"):
    """Return eigenvalues and shapes of one step of dt sqrt(g/d).

    Without those that last less than a step: accelerations of no motion, which the next step forgets.
    """
    values, shapes = np.linalg.eig(tank(across, stepping=stepping).step_matrix(dt * UNIT))
    last = np.abs(values) > 0.3
    return values[last], shapes[:, last]


def first_wave(across, dt, stepping="corrected"):
    """Return the relative error of omega_1 and the growth, per omega_1, of its wave in steps of dt sqrt(g/d)."""
    values, shapes = step_eigenvalues(across, dt, stepping)
    k, likeness = tank(across).mode(1, values, shapes)
    assert likeness > 0.99
    scale = dt * UNIT * exact_frequency(1)
    return abs(np.angle(values[k])) / scale - 1.0, np.log(abs(values[k])) / scale


@pytest.mark.parametrize(("across", "dt"), [(12, 0.064), (24, 0.064), (24, 0.128), (24, 0.016)])
def test_frequency_of_the_steps(across, dt):
    error, growth = first_wave(across, dt)
    assert abs(error) < 3e-4, "measured -.009, .018, .020, .011 %"
    lost = {12: 1.2e-3, 24: 1.2e-4}[across]
    assert -lost < growth < 1e-9, "the wave never grows; with 24 spacings it loses .06 % in a period"


@pytest.mark.parametrize(("mode", "limit"), [(1, 3e-4), (2, 1e-3), (3, 2e-3), (4, 3e-3)])
def test_waves_of_a_tank_twenty_spacings_long(mode, limit):
    """As dt -> 0, with the filter: 40 to 10 spacings a wavelength, kd from 1.6 to 6.3."""
    values, shapes = step_eigenvalues(20, 0.016)
    k, likeness = tank(20).mode(mode, values, shapes)
    error = abs(np.angle(values[k])) / (0.016 * UNIT * exact_frequency(mode)) - 1.0
    assert likeness > 0.99 and abs(error) < limit, "measured .005, .048, .139, .192 %"


@pytest.mark.parametrize("dt", [0.064, 0.128, 0.2])
def test_the_correction_removes_the_error_of_second_order(dt):
    between = first_wave(24, dt, "midpoint")[0] - first_wave(24, dt)[0]
    assert between == pytest.approx((dt * UNIT * exact_frequency(1))**2 / 24.0, rel=0.07)


@pytest.mark.parametrize(("across", "dt"), [(12, 0.064), (24, 0.064), (24, 0.128)])
def test_no_motion_grows(across, dt):
    values, _ = step_eigenvalues(across, dt)
    assert np.abs(values).max() < 1.0 + 1e-9


@pytest.mark.parametrize("over", [0.75, 1.0, 1.1])
def test_in_long_steps_short_waves_do_not_grow(over):
    """Steps of up to 1.1 sqrt(s/g); with the midpoint stepping and a fifth of the filter they do."""
    step = over * np.sqrt(2.0 / 24.0) * UNIT
    midpoint, corrected = (np.abs(np.linalg.eigvals(tank(24, stepping=word, filter=0.1).step_matrix(step))).max() - 1.0
                           for word in ("midpoint", "corrected"))
    assert midpoint > 5e-5 and corrected < 1e-9
