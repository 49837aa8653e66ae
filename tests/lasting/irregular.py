"""Irregular waves of a piston with the energies of a JONSWAP spectrum, and a sponge."""

import numpy as np

from parisph.case.waves import Jonswap, angular_frequency
from tests.hard.table import Line
from tests.lasting.flume import DEPTH, Flume, G, fronts, level_lines
from tests.lasting.long import Long, Record, Setting, common

AXES = {"height": (0.05, 0.1), "kd": (1.0,), "depth": (10.0, 16.0)}
PERIODS = 100.0
LAST = 0.6          # share of the run that is measured
REACH = 2.25        # wavelengths of the peak from the piston to the sponge
COMPONENTS = 60     # waves of the sum


def long(values: dict[str, float], setting: Setting) -> Long:
    """Return a flume with waves of a significant height over the depth, and kd of the peak."""
    kd, height = values["kd"], values["height"] * DEPTH
    period, length = 2.0 * np.pi / float(angular_frequency(kd / DEPTH, DEPTH, G)), 2.0 * np.pi * DEPTH / kd
    periods = setting.periods or PERIODS
    wave = Jonswap(height=height, period=period, depth=DEPTH, seed=1, components=COMPONENTS)
    flume = Flume("piston", wave, length, REACH * length)
    places = length * np.arange(1.0, 3.0)

    def measure(record: Record) -> list[Line]:
        start = max((1.0 - LAST) * periods, fronts(kd, places).max()) * period
        late = record.time >= start
        found = common(record, period, periods)
        if record.time[-1] < start + period:
            return found
        t = record.time[late]
        made, due = (4.0 * _deviation(t, eta) for eta in (record.gauges[late, 0], wave.elevation(places[0], t)))
        far = 4.0 * _deviation(t, record.gauges[late, 1])
        return [*found, Line("significant height / that of the sum", made / due),
                Line("significant height, error", abs(made / due - 1.0), 0.05),
                Line("over that of the spectrum", made / height),
                Line("loss a wavelength", 1.0 - far / made),
                *level_lines(record, period, height)]
    return Long(flume.case(values["depth"], places, setting, periods * period), DEPTH, period, measure)


def _deviation(t, values):
    """Return the standard deviation of a signal (n,) that is sampled at any times (n,)."""
    return np.std(np.interp(np.linspace(t[0], t[-1], 4 * len(t)), t, values))
