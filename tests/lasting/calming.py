"""A tank that comes to rest: a sponge takes up its waves, and it has to stay at rest."""

import numpy as np

from parisph.case.absorb import Sponge
from parisph.case.schema import Box, Case, Fluid, Numerics, Tank
from parisph.case.waves import angular_frequency, standing_wave_start
from tests.hard.table import Line
from tests.lasting.harmonics import by_period
from tests.lasting.long import Long, Record, Setting, common, gauges, walls

G, DEPTH, DENSITY = 9.81, 1.0, 1000.0    # in SI units
LENGTH = 6.0 * DEPTH    # three wavelengths
GAUGES = 12

AXES = {"amplitude": (0.05,), "depth": (10.0, 20.0), "jitter": (0.0, 0.4)}
PERIODS = 60.0


def long(values: dict[str, float], setting: Setting) -> Long:
    """Return a standing wave with a sponge over a third of its tank."""
    k, a, periods = np.pi / DEPTH, values["amplitude"] * DEPTH, setting.periods or PERIODS
    period = 2.0 * np.pi / float(angular_frequency(k, DEPTH, G))
    places = (np.arange(GAUGES) + 0.5) * LENGTH / GAUGES
    case = Case(
        title="A tank that comes to rest", gravity=(0.0, -G),
        walls=Tank(width=LENGTH, height=walls(DEPTH, values["depth"])),
        fluid=Fluid(Box(width=LENGTH, height=DEPTH), density=DENSITY, velocity=standing_wave_start(a, k, DEPTH, G)),
        absorb=Sponge(LENGTH * 2.0 / 3.0, LENGTH / 3.0),
        numerics=Numerics(preset=setting.preset or "gentle", spacing=DEPTH / values["depth"], jitter=values["jitter"],
                          seed=1, time_step=setting.time_step(DEPTH, G)),
        probes=gauges(places), end_time=periods * period)

    def measure(record: Record) -> list[Line]:
        level = by_period(record.time, record.gauges.mean(axis=1), period)
        kinetic = by_period(record.time, record.kinetic, period)
        found = common(record, period, periods)
        if len(level.mean):
            found += [Line("level / a at the end", level.mean[-1] / a),
                      Line("level, largest size", np.abs(level.mean).max() / a, 0.05),
                      Line("kinetic energy / start at the end", kinetic.mean[-1] / record.kinetic[0], 1e-3),
                      Line("kinetic energy, highest", record.kinetic.max() / record.kinetic[0], 1.02)]
        return found
    return Long(case, DEPTH, period, measure)
