"""Regular waves by a piston, a flap, a relaxation zone and a heaving body, against stream-function theory."""

import numpy as np

from tests.hard.table import Line
from tests.lasting.flume import DEPTH, Flume, fronts, level_lines, wave_of
from tests.lasting.harmonics import by_period
from tests.lasting.long import Long, Record, Setting, common

AXES = {"maker": ("piston", "flap", "zone", "body"), "height": (0.05, 0.1, 0.2), "kd": (0.6, 1.0, 2.0),
        "depth": (8.0, 12.0, 16.0, 20.0)}
PERIODS = 40.0
REACH = 3.25    # wavelengths from the maker to the sponge
LAST = 10       # periods whose means tell the loss and the second harmonic
FINE = 16.0     # depth / s from which on a loss is required


def long(values: dict[str, float], setting: Setting) -> Long:
    """Return a flume with gauges at one, two and three wavelengths from the maker."""
    wave, kd = wave_of(values["kd"], values["height"]), values["kd"]
    periods = setting.periods or PERIODS
    flume = Flume(values["maker"], wave, wave.length, REACH * wave.length)
    places = wave.length * np.arange(1.0, 4.0)

    def measure(record: Record) -> list[Line]:
        start = fronts(kd, places) * wave.period
        found = [by_period(record.time, eta, wave.period, begin) for eta, begin in zip(record.gauges.T, start)]
        return [*common(record, wave.period, periods), *_heights(found[0], wave, values["maker"]),
                *_loss(found, values["depth"]), *level_lines(record, wave.period, wave.height, flume.level)]
    return Long(flume.case(values["depth"], places, setting, periods * wave.period), DEPTH, wave.period, measure)


def _heights(found, wave, maker):
    """Lines on the waves at one wavelength, over the wave that was asked for; a body makes another one."""
    if not len(found.first):
        return []
    t = np.linspace(0.0, wave.period, 201)
    due = by_period(t, wave.elevation(0.0, t), wave.period)
    target = np.median(found.first) if maker == "body" else due.first[0]
    heights, second = found.first / target, found.second[-LAST:].mean() / due.second[0]
    bound = maker != "body"    # which also makes free waves of twice the frequency
    return [Line("lowest height / target", heights.min(), 0.95, least=True),
            Line("highest height / target", heights.max(), 1.05),
            Line("second harmonic / theory", second),
            Line("second harmonic, error", abs(second - 1.0), 0.15 if bound else None)]


def _loss(found, depth):
    if not all(len(one.first) for one in found):
        return []
    near, far = (one.first[-LAST:].mean() for one in (found[0], found[-1]))
    return [Line("loss a wavelength", 1.0 - (far / near) ** (1.0 / (len(found) - 1)), 0.02 if depth >= FINE else None,
                 0.01 if depth >= FINE else None)]


QUICK = {"maker": ("zone",), "height": (0.05,), "kd": (1.0,), "depth": (8.0,)}
QUICK_PERIODS = 12.0
