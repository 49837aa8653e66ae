"""Samples in which a probe had nothing to measure: its place was outside of the water, dry, or above the walls."""

import numpy as np

from parisph.base.arrays import Flags
from parisph.case.schema import Case
from parisph.io.reader import Run
from parisph.truth.recorded import probe_records
from parisph.watch.sampling import ProbeScene


def gaps(case: Case, run: Run) -> dict[str, str]:
    """Return {probe: why it measured nothing, in which share of its samples, and since when}. Not collective.

    No value: its place was outside of the fluid. Emptied: a gauge or tap that first had water. Out of range: a gauge
    whose surface was above the walls. Probes in arrays have names like "gauges.x1".
    """
    found = {}
    scene = ProbeScene.of(case)
    for record in probe_records(case, run, lambda probe: True):
        if not record.columns or not len(record.table):
            continue
        time = record.table["time"]
        values = np.stack([np.asarray(record.table[name], float) for name in record.columns])
        words = [f"{what} in {_share(when)} of its samples, first at t = {time[when][0]:.4g} s"
                 for what, when in record.probe.touched(values, case, scene) if when.any()]
        if words:
            found[record.name] = "; ".join(words)
    return found


def _share(when: Flags) -> str:
    share = float(when.mean())
    return f"{share:.0%}" if share >= 0.01 else "less than 1%"
