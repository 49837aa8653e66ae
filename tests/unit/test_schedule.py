"""When something is due, and the steps that meet it: pure functions of the time, so that restarts cannot notice."""

import math

import numpy as np
import pytest

from parisph.driver.schedule import Times, step_towards


def walk(limit, due, end, time=0.0):
    """Return the steps to the end and the times after them [s], all that is due being met."""
    steps, times = [], []
    while time < end * (1.0 - 1e-9):
        dt, time = step_towards(due.after(time), time, limit)
        steps.append(dt)
        times.append(time)
    return np.array(steps), np.array(times)


@pytest.mark.parametrize("trial", range(20))
def test_what_is_due_is_met_exactly_and_without_a_crumb(trial):
    random = np.random.default_rng(trial)
    limit, every = random.uniform(1e-4, 1e-2), random.uniform(0.011, 0.1)
    steps, times = walk(limit, Times(every), 1.0)
    for k in range(1, int(1.0 / every)):
        assert k * every in times
    assert steps.max() <= 1.001 * limit and steps.min() > 0.5 * limit
    np.testing.assert_allclose(np.cumsum(steps), times, rtol=1e-12)
    # no more than the last ten before each are shorter
    assert np.count_nonzero(steps < limit) <= 10 * (1 + np.count_nonzero(np.isin(times, every * np.arange(1, 200))))


@pytest.mark.parametrize("trial", range(20))
def test_no_step_shortens_by_more_than_a_tenth_where_enough_are_left(trial):
    random = np.random.default_rng(trial)
    limit = random.uniform(1e-3, 2e-3)
    steps, _ = walk(limit, Times(random.uniform(20.0, 30.0) * limit), 1.0)
    assert np.all(steps[1:] > 0.899 * steps[:-1])


def test_a_run_that_goes_on_takes_the_same_steps():
    due = Times(0.11, (0.3, 0.47))
    steps, times = walk(0.016, due, 1.0)
    for number, time in enumerate(times[:-1]):
        again, after = walk(0.016, due, 1.0, time)
        np.testing.assert_array_equal(again, steps[number + 1:])
        np.testing.assert_array_equal(after, times[number + 1:])


@pytest.mark.parametrize(("limit", "number"), [(0.004, 25), (0.1, 1), (1 / 3, 7), (0.0031927, 3)])
def test_a_fixed_step_that_divides_is_not_touched(limit, number):
    steps, times = walk(limit, Times(number * limit), 400 * number * limit)
    assert np.all(steps == limit) and len(steps) == 400 * number
    np.testing.assert_array_equal(times[number - 1::number], np.arange(1, 401) * (number * limit))    # no error adds up


@pytest.mark.parametrize(("left", "step"), [(10.4, 1.0), (9.5, 0.95), (0.7, 0.7)])
def test_the_last_ten_steps_share_what_is_left(left, step):
    assert step_towards(left, 0.0, 1.0) == (step, step)


def test_nothing_due_leaves_the_step_alone():
    assert step_towards(math.inf, 3.0, 0.1) == (0.1, 3.1)
    assert step_towards(2.0, 3.0, 0.1) == (0.1, 3.1)    # a time that has passed


def test_a_time_is_due_after_another():
    due = Times(0.1, (0.25, 0.3, 7.0))
    assert [due.after(t) for t in (0.0, 0.1, 0.2, 0.25)] == [0.1, 0.2, 0.25, pytest.approx(0.3)]
    assert due.after(0.3) == due.after(3 * 0.1) == pytest.approx(0.4)    # .3 and 3 x .1 are one time
    assert Times(None, (0.25,)).after(0.3) == Times(None).after(0.0) == math.inf
