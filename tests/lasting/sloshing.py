"""Tanks that sway below and above their first frequency, by little and by much, without breaking."""

import numpy as np

from parisph.case.schema import Sway
from parisph.case.waves import Sloshing, angular_frequency
from tests.hard.table import Line
from tests.lasting.harmonics import by_period
from tests.lasting.long import DEPTH, SAMPLES, G, Long, Record, Setting, common, of_level, tank

LENGTH = 2.0 * DEPTH
GAUGES = 8

# of the sway over the depth; the greater one makes waves as high as 0.09 (ratio 0.8) and 0.15 depths (1.2)
AXES = {"ratio": (0.8, 1.2), "amplitude": (0.001, 0.01), "depth": (10.0, 20.0)}
PERIODS = 200.0
BEATS = 12    # periods of a window: of the forcing, and whole beats of it with the free wave


def long(values: dict[str, float], setting: Setting) -> Long:
    """Return a tank that sways with a ratio of its first frequency, against linear theory."""
    a, first = values["amplitude"] * DEPTH, float(angular_frequency(np.pi / LENGTH, DEPTH, G))
    frequency = values["ratio"] * first
    period, periods = 2.0 * np.pi / frequency, setting.periods or PERIODS
    wave = Sloshing(length=LENGTH, depth=DEPTH, amplitude=a, frequency=frequency)
    places = [0.0, *(np.arange(GAUGES) + 0.5) * LENGTH / GAUGES]
    case = tank("A tank that sways", LENGTH, values, setting, places, periods * period,
                frame=Sway(amplitude=a, frequency=frequency))
    t = np.arange(0.0, BEATS * period, period / SAMPLES)
    height = np.ptp(wave.elevation(0.0, t))    # of the undamped wave, which beats for ever

    def measure(record: Record) -> list[Line]:
        heights = _by_window(record.time, record.gauges[:, 0], BEATS * period) / height
        level = by_period(record.time, record.gauges[:, 1:].mean(axis=1), period)
        found = common(record, period, periods)
        if len(level.mean):
            found += of_level(level.mean, height, "H", 0.05)
        if len(heights):
            found += [Line("height / linear, first 12 periods", heights[0]),
                      Line("last 12 periods", heights[-1]), Line("highest 12 periods", heights.max())]
        return found
    return Long(case, DEPTH, period, measure)


def _by_window(time, values, window):
    """Return the heights (n,) of a signal in whole windows of time [s]."""
    count = int(time[-1] / window + 1e-6)
    return np.array([np.ptp(values[(time >= n * window) & (time <= (n + 1) * window)]) for n in range(count)])


QUICK = {"ratio": (1.2,), "amplitude": (0.001,), "depth": (10.0,)}
QUICK_PERIODS = 24.0
