"""The volumes that have passed the lines of a run's `Flux` probes: the `passed` of summary.json. Not collective."""

from typing import Any

import numpy as np

from parisph.base.arrays import Floats
from parisph.case.schema import Case
from parisph.truth.recorded import Recorded, probe_records


def passed(case: Case, run: Recorded) -> dict[str, dict[str, Any]]:
    """Return {probe name: {"total" [m2], "events": list, None without `pause`}}; in arrays as "lines.over".

    In 3D volumes are in m3, and there is a "unit".
    """
    found: dict[str, dict[str, Any]] = {}
    for record in probe_records(case, run, lambda probe: probe.gate(case.dim) is not None):
        total, pause = record.values("total"), record.probe.pause
        if len(total):
            found[record.name] = {"total": float(total[-1]),
                                  "events": None if pause is None else events(record.table["time"], total, pause),
                                  **({"unit": "m3"} if case.dim == 3 else {})}
    return found


def events(time: Floats, total: Floats, pause: float) -> list[dict[str, float]]:
    """Return [{"start", "end" [s], "volume" [m2]}] of the events in which water passes.

    An event lasts from the last sample before water passes to the first one before a pause. The sum of the volumes is
    the change of `total`.

    time, total : (n,) [s], [m2]; pause : [s]
    """
    changes = np.flatnonzero(np.diff(total) != 0.0)
    if not len(changes):
        return []
    apart = np.flatnonzero(time[changes[1:]] - time[changes[:-1] + 1] >= pause)
    firsts, lasts = changes[np.r_[0, apart + 1]], changes[np.r_[apart, len(changes) - 1]] + 1
    return [{"start": float(time[first]), "end": float(time[last]), "volume": float(total[last] - total[first])}
            for first, last in zip(firsts, lasts)]
