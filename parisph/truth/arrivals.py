"""The time at which a probe first passes a value: the `arrivals` of summary.json."""

import numpy as np

from parisph.base.arrays import Floats
from parisph.case.probes import singles
from parisph.case.schema import Case
from parisph.truth.recorded import Recorded, probe_records


def arrivals(case: Case, run: Recorded) -> dict[str, float | None]:
    """Return {probe name: time [s] or None} of the probes with an `arrival`. Not collective.

    The first column of a probe counts. A probe of an array is named "gauges.x1".
    """
    found: dict[str, float | None] = {name: None for name, probe in singles(case.probes) if probe.arrival is not None}
    for record in probe_records(case, run, lambda probe: probe.arrival is not None):
        found[record.name] = first_passing(record.table["time"], record.table[record.columns[0]], record.probe.arrival)
    return found


def first_passing(time: Floats, values: Floats, level: float) -> float | None:
    """Return the first time [s] at which a series reaches a level, from either side; None if never.

    time, values : (n,), interpolated linearly; values that are not finite are left out
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
