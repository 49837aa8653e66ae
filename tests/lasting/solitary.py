"""A solitary wave between two walls, for ten reflections."""

import numpy as np

from parisph.case.waves import SolitaryWave
from tests.hard.table import Line
from tests.lasting.long import DEPTH, Long, Record, Setting, common, of_level, tank

TAIL = 6.0     # exp(-TAIL): of the height, what is at the walls when the wave starts in the middle
GAUGES = 24    # in the middles of equal parts of the tank

AXES = {"height": (0.1, 0.2, 0.3), "depth": (10.0, 20.0)}
PERIODS = 10.0    # reflections


def long(values: dict[str, float], setting: Setting) -> Long:
    """Return a tank with a wave of a height over the depth in its middle; its period is the way between the walls."""
    s, a = DEPTH / values["depth"], values["height"] * DEPTH
    length = 2.0 * s * round(TAIL / SolitaryWave(a, DEPTH).rate / s)
    wave = SolitaryWave(height=a, depth=DEPTH, at=0.5 * length)
    period, times = length / wave.celerity, setting.periods or PERIODS
    places = [0.5 * length, *(np.arange(GAUGES) + 0.5) * length / GAUGES]
    case = tank("A solitary wave between walls", length, values, setting, places, times * period, "solitary", over=1.0,
                start={"wave": wave})

    def measure(record: Record) -> list[Line]:
        crests = np.array([record.gauges[_passing(record.time, n, period), 0].max() for n in range(1, int(times) + 1)
                           if record.time[-1] >= (n + 0.4) * period or n == times and record.time[-1] >= n * period])
        mean = record.gauges[:, 1:].mean(axis=1)
        start = 2.0 * record.kinetic[0]    # the waves have nearly as much potential energy
        motion = 1.0 + (record.total - record.total[0]) / start
        found = [*common(record, period, times), Line("energy / start, lowest", motion.min()),
                 Line("energy / start, highest", motion.max(), 1.02)]
        if len(crests):
            found += [Line("crest / a, first reflection", crests[0] / a),
                      Line("last reflection", crests[-1] / a), Line("lowest crest / a", crests.min() / a)]
        return [*found, *of_level(mean - mean[0], a, "a", 0.05)]
    return Long(case, DEPTH, period, measure)


def _passing(time, n, period):
    """Return which samples are around the time at which the crest passes the middle once more, (n,) bool."""
    return np.abs(time - n * period) <= 0.4 * period


QUICK = {"height": (0.2,), "depth": (10.0,)}
QUICK_PERIODS = 1.0
