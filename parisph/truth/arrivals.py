"""When a probe first passes a value: the `arrivals` of summary.json."""

import numpy as np

from parisph.base.arrays import Floats
from parisph.case.probes import Probe, singles
from parisph.case.schema import Case
from parisph.truth.recorded import Recorded, parts


def arrivals(case: Case, run: Recorded) -> dict[str, float | None]:
    """Return {probe name: time [s]} of the probes with an arrival, None for one that has not passed it. Not collective.

    run : io.reader.Run. The first column of a probe counts; probes in arrays have names as in "gauges.x1".
    """
    found: dict[str, float | None] = {name: None for name, probe in singles(case.probes) if _has_arrival(probe)}
    for part in parts(case, run, _has_arrival):
        found[part.name] = first_passing(part.table["time"], part.table[part.columns[0]], part.probe.arrival)
    return found


def _has_arrival(probe: Probe) -> bool:
    return getattr(probe, "arrival", None) is not None


def first_passing(time: Floats, values: Floats, level: float) -> float | None:
    """Return the first time [s] at which a series is at a level or on its other side than at the start; None if never.

    time, values : (n,); between two samples the series is a straight line. Samples that are no number are left out.
    """
    there = np.isfinite(values)
    time, above = time[there], (values - level)[there]
    if not len(above):
        return None
    passed = np.flatnonzero(np.sign(above) != np.sign(above[0])) if above[0] else np.array([0])
    if not len(passed):
        return None
    k = passed[0]
    if above[k] == 0.0:
        return float(time[k])
    return float(time[k - 1] + (time[k] - time[k - 1]) * above[k - 1] / (above[k - 1] - above[k]))
