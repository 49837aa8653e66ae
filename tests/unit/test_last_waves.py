"""The largest strain rate of the last waves."""

import numpy as np

from parisph.methods.last_waves import WAVES, LastWaves


def test_a_peak_counts_for_one_span_at_least_and_for_two_at_most():
    memory, dt = LastWaves(), 0.1 * WAVES
    memory.take(5.0, dt, 1.0)
    for _ in range(10):
        memory.take(1.0, dt, 1.0)
        assert memory.largest == 5.0
    for _ in range(11):
        memory.take(1.0, dt, 1.0)
    assert memory.largest == 1.0


def test_no_waves_leave_no_memory():
    memory = LastWaves()
    for rate in (5.0, 1.0):
        memory.take(rate, 0.1, np.inf)
    assert memory.largest == 1.0


def test_it_goes_on_from_its_state():
    memory, other = LastWaves(), LastWaves()
    memory.take(5.0, 0.9 * WAVES, 1.0)
    other.resume(memory.state())
    for each in (memory, other):
        each.take(1.0, 0.2 * WAVES, 1.0)
        assert each.largest == 5.0
        each.take(1.0, 1.1 * WAVES, 1.0)
        assert each.largest == 1.0
