"""Regular waves of a piston that break on a slope at each crest."""

import numpy as np

from parisph.case.schema import Case, Fluid, Numerics, Piston, Profile, StillWater
from tests.hard.table import Line
from tests.lasting.flume import BEHIND, DENSITY, DEPTH, TOP, G, wave_of
from tests.lasting.harmonics import by_period
from tests.lasting.long import Long, Record, Setting, common, gauges

AXES = {"height": (0.2,), "kd": (0.6, 1.0), "depth": (10.0, 20.0)}
PERIODS = 20.0
FLAT = 1.25     # wavelengths from the piston to the toe of the slope
SLOPE = 0.1     # surf-similarity of 0.3 to 0.5: waves plunge
LAST = 5        # periods
GAUGES = 8      # over the flat bed


def long(values: dict[str, float], setting: Setting) -> Long:
    """Return a flume that ends with a slope, which the water does not run over."""
    wave, periods = wave_of(values["kd"], values["height"]), setting.periods or PERIODS
    toe = FLAT * wave.length
    bed = [(-BEHIND * DEPTH, 0.0), (toe, 0.0), (toe + TOP * DEPTH / SLOPE, TOP * DEPTH)]
    places = [wave.length, *(np.arange(GAUGES) + 0.5) * toe / GAUGES]
    case = Case(
        title="Waves that break on a slope", fluid=Fluid(StillWater(level=DEPTH), density=DENSITY), gravity=(0.0, -G),
        walls=(Profile(bed, name="bed"), Piston(at=0.0, wave=wave, name="piston")),
        numerics=Numerics(preset=setting.preset or "violent", spacing=DEPTH / values["depth"],
                          time_step=setting.time_step(DEPTH, G)),
        probes=gauges(places), end_time=periods * wave.period)

    def measure(record: Record) -> list[Line]:
        found = common(record, wave.period, periods, apart=None)
        at = by_period(record.time, record.gauges[:, 0], wave.period)
        level = by_period(record.time, record.gauges[:, 1:].mean(axis=1), wave.period)
        if len(at.first) > LAST:
            heights = 2.0 * at.first[LAST:] / wave.height
            found += [Line("lowest height / H", heights.min()), Line("highest height / H", heights.max()),
                      Line("level over the flat bed / H at the end", level.mean[-LAST:].mean() / wave.height)]
        return found
    return Long(case, DEPTH, wave.period, measure)
