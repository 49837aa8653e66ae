"""A tank that comes to rest: a sponge takes up its waves, and it has to stay at rest."""

import numpy as np

from parisph.case.absorb import Sponge
from parisph.case.waves import angular_frequency, standing_wave_start
from tests.hard.table import Line
from tests.lasting.harmonics import by_period
from tests.lasting.long import DEPTH, G, Long, Record, Setting, common, of_level, tank

LENGTH = 6.0 * DEPTH    # three wavelengths
GAUGES = 12

AXES = {"amplitude": (0.05,), "depth": (10.0, 20.0), "jitter": (0.0, 0.4)}
PERIODS = 60.0


def long(values: dict[str, float], setting: Setting) -> Long:
    """Return a standing wave with a sponge over a third of its tank."""
    k, a, periods = np.pi / DEPTH, values["amplitude"] * DEPTH, setting.periods or PERIODS
    period = 2.0 * np.pi / float(angular_frequency(k, DEPTH, G))
    places = (np.arange(GAUGES) + 0.5) * LENGTH / GAUGES
    case = tank("A tank that comes to rest", LENGTH, values, setting, places, periods * period,
                start={"velocity": standing_wave_start(a, k, DEPTH, G)},
                absorb=Sponge(LENGTH * 2.0 / 3.0, LENGTH / 3.0))

    def measure(record: Record) -> list[Line]:
        level = by_period(record.time, record.gauges.mean(axis=1), period)
        kinetic = by_period(record.time, record.kinetic, period)
        found = common(record, period, periods)
        if len(level.mean):
            found += [*of_level(level.mean, a, "a", 0.05),
                      Line("kinetic energy / start at the end", kinetic.mean[-1] / record.kinetic[0], 1e-3),
                      Line("kinetic energy, highest", record.kinetic.max() / record.kinetic[0], 1.02)]
        return found
    return Long(case, DEPTH, period, measure)
