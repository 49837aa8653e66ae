"""When a probe first passes a value: the `arrivals` of summary.json."""

import numpy as np

from parisph.base.errors import ParisphError
from parisph.case.probes import ProbeArray, singles
from parisph.case.schema import Case
from parisph.truth.recorded import Recorded


def arrivals(case: Case, run: Recorded) -> dict[str, float | None]:
    """Return {probe name: time [s]} of the probes with an arrival, None for one that has not passed it. Not collective.

    run : io.reader.Run. The first column of a probe counts; probes in arrays have names as in "gauges.x1".
    """
    found = {}
    for probe in case.probes:
        for name, one in singles([probe]):
            value = getattr(one, "arrival", None)
            if value is None:
                continue
            try:
                table = run.probe(probe.name)
            except ParisphError:    # no file: the run has not come so far
                found[name] = None
                continue
            columns = [column for column in table.dtype.names or () if column not in ("time", "step")]
            mine = columns[0]
            if isinstance(probe, ProbeArray):
                mine = next(column for column in columns if column == one.name or column.startswith(f"{one.name}_"))
            found[name] = first_passing(table["time"], table[mine], value)
    return found


def first_passing(time: np.ndarray, values: np.ndarray, level: float) -> float | None:
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
