"""Regular waves of a piston on an obstacle: a submerged one, or one that pierces the surface."""

import numpy as np

from parisph.base.errors import ParisphError
from parisph.case.schema import Box, Obstacle
from parisph.truth.reflection import separated
from tests.hard.table import Line
from tests.lasting.flume import DEPTH, Flume, fronts, level_lines, wave_of
from tests.lasting.harmonics import by_period
from tests.lasting.long import Long, Record, Setting, common

AXES = {"obstacle": ("submerged", "piercing"), "height": (0.05, 0.1), "kd": (1.0,), "depth": (10.0, 16.0)}
PERIODS = 40.0
AT = 2.25       # wavelengths from the piston to the obstacle
BEHIND = 1.5    # wavelengths from its front to the sponge
LAST = 8        # periods that tell the reflection
WIDTH, STEP, DRAFT, BOARD = 1.0, 0.5, 0.4, 0.6    # of the obstacles / d: both; submerged; in and over the water
SEPARATED = np.array([-0.75, -0.6, -0.35])    # gauges before the obstacle, in wavelengths


def long(values: dict[str, float | str], setting: Setting) -> Long:
    """Return a flume with an obstacle a depth wide."""
    wave = wave_of(values["kd"], values["height"])
    length, periods = wave.length, setting.periods or PERIODS
    front = AT * length
    submerged = values["obstacle"] == "submerged"
    size, low = (STEP, 0.0) if submerged else (DRAFT + BOARD, 1.0 - DRAFT)
    shape = Box(width=WIDTH * DEPTH, height=size * DEPTH, at=(front, low * DEPTH))
    flume = Flume("piston", wave, length, front + BEHIND * length, further=(Obstacle(shape, name="obstacle"),))
    places = np.array([*(front + SEPARATED * length), front + WIDTH * DEPTH + 0.75 * length])

    def measure(record: Record) -> list[Line]:
        found = [*common(record, wave.period, periods), *level_lines(record, wave.period, wave.height)]
        regular = (fronts(values["kd"], places[-1:])[0] + 2.0 * AT) * wave.period
        begin = max(record.time[-1] - LAST * wave.period, regular)
        if record.time[-1] < begin + 0.95 * wave.period:
            return found
        late = record.time >= begin
        return found + _reflection(record.time[late], record.gauges[late], places, wave)
    return Long(flume.case(values["depth"], places, setting, periods * wave.period), DEPTH, wave.period, measure)


def _reflection(t, eta, places, wave):
    """Lines on the reflection by three gauges and by two, and on the energy that comes back and goes on."""
    try:
        three = separated(t, eta[:, :3].T, places[:3], wave.period, wave.k)
        two = separated(t, eta[:, 1:3].T, places[1:3], wave.period, wave.k)
    except (ParisphError, ValueError):
        return []
    passed = by_period(t, eta[:, 3], wave.period, t[0]).first.mean() / three.incident
    return [Line("reflection", three.reflection), Line("passed on", passed),
            Line("two gauges less three", abs(two.reflection - three.reflection), 0.03),
            Line("energy that comes back and goes on", three.reflection**2 + passed**2)]
