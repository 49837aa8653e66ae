"""Standing waves, from a flat surface with the velocities of linear theory."""

import numpy as np

from parisph.case.waves import angular_frequency, standing_wave_start
from tests.hard.table import Line
from tests.lasting.harmonics import by_period, loss
from tests.lasting.long import DENSITY, DEPTH, G, Long, Record, Setting, common, of_level, tank

GAUGES = 8      # in the middles of equal parts of the tank: their mean is free of the first 15 modes
LONGEST = 2.0   # depths: a tank has as many half waves as it needs to be at least as long

AXES = {"kd": (np.pi, 1.0), "amplitude": (0.002, 0.02, 0.05), "depth": (10.0, 20.0), "jitter": (0.0, 0.4)}
PERIODS, VIOLENT_PERIODS = 100.0, 20.0


def long(values: dict[str, float], setting: Setting) -> Long:
    """Return a standing wave in a tank of whole half waves and spacings."""
    s, preset = DEPTH / values["depth"], setting.preset or "gentle"
    waves = np.ceil(LONGEST / (np.pi / values["kd"]) - 1e-9)
    length = s * round(waves * np.pi / values["kd"] / s)
    k, a = waves * np.pi / length, values["amplitude"] * DEPTH
    period = 2.0 * np.pi / float(angular_frequency(k, DEPTH, G))
    periods = setting.periods or (VIOLENT_PERIODS if preset == "violent" else PERIODS)
    places = (np.arange(GAUGES) + 0.5) * length / GAUGES
    case = tank("A standing wave", length, values, setting, places, periods * period,
                start={"velocity": standing_wave_start(a, k, DEPTH, G)})

    def measure(record: Record) -> list[Line]:
        mode = 2.0 * record.gauges @ np.cos(k * places) / GAUGES
        waves = by_period(record.time, mode, period)
        level = by_period(record.time, record.gauges.mean(axis=1), period)
        return [*common(record, period, periods, None if preset == "violent" else 0.5),
                *_lines(waves, level, a, values, preset), *_energies(record, length, preset)]
    return Long(case, DEPTH, period, measure)


def _lines(waves, level, a, values, preset):
    fine, violent = values["depth"] >= 20.0, preset == "violent"
    if not len(waves.first):
        return []
    lost = (Line("loss in 20 periods", loss(waves.first, 20.0), 0.3 if fine else None, 0.1 if fine else None)
            if violent else
            Line("loss in 50 periods", loss(waves.first, 50.0), 0.15 if fine else 0.4, 0.05 if fine else None))
    return [Line("lowest amplitude / a", waves.first.min() / a), Line("highest amplitude / a", waves.first.max() / a),
            lost, *of_level(level.mean, a, "a", None if violent else 0.03 if fine else 0.05)]


def _energies(record, length, preset):
    """Lines on the energy in motion over that at the start: the kinetic energy and that of the elevation.

    By the heights of all particles, the potential energy is that of the waves only where the level is right to a
    hundredth of a^2/d.
    """
    start = record.kinetic[0]
    waves = (record.kinetic + 0.5 * DENSITY * G * length * (record.gauges**2).mean(axis=1)) / start
    by_particles = (start + record.total - record.total[0]) / start
    return [Line("energy in motion / start, lowest", waves.min()),
            Line("energy in motion, highest", waves.max(), 1.05 if preset == "violent" else 1.02),
            Line("by particles, lowest", by_particles.min()), Line("by particles, highest", by_particles.max())]


QUICK = {"kd": (1.0,), "amplitude": (0.02,), "depth": (10.0,), "jitter": (0.0, 0.4)}
QUICK_PERIODS = 10.0
