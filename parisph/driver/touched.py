"""Which probes of a run were touched by what they do not measure: out of the water, dry, or above the walls."""

from collections.abc import Iterator

import numpy as np

from parisph.base.arrays import Flags, Floats
from parisph.case.probes import ColumnHeight, PressureTap, SurfaceGauge
from parisph.case.schema import Case
from parisph.io.reader import Run
from parisph.truth.recorded import probe_records
from parisph.watch.sampling import Scene

DRY = 1e-6    # of the spacing above the bed, or of the greatest pressure: a gauge or a tap with no more is dry


def probes(case: Case, run: Run) -> dict[str, str]:
    """Return {probe: what touched it, for how much of its samples, and when first}. Not collective.

    Without a number: the place was not in the fluid. Emptied: gauges and taps that had water at first. Out of range:
    gauges whose surface was above the walls. Probes in arrays are named as in "gauges.x1".
    """
    found = {}
    scene = Scene.of(case)
    for record in probe_records(case, run, lambda probe: True):
        if not record.columns or not len(record.table):
            continue
        time = record.table["time"]
        values = np.stack([np.asarray(record.table[name], float) for name in record.columns])
        words = [f"{what} in {_share(when)} of its samples, first at t = {time[when][0]:.4g} s"
                 for what, when in _touches(case, scene, record.probe, values) if when.any()]
        if words:
            found[record.name] = "; ".join(words)
    return found


def _touches(case: Case, scene: Scene, probe: object, values: Floats) -> Iterator[tuple[str, Flags]]:
    """Yield what may touch a probe, and at which of its samples (n,) it did. values : (columns, n)"""
    yield "no value, outside the fluid,", ~np.isfinite(values).all(axis=0)
    first = values[0]
    if isinstance(probe, (SurfaceGauge, ColumnHeight)):
        bed = scene.bed_at(np.array([probe.at]))
        moving = scene.now is not None and scene.now.moving
        if bed is not None and not moving and first[0] > bed[0] + case.numerics.spacing:
            yield "emptied", first <= bed[0] + DRY * case.numerics.spacing
        if case.tank is not None and not case.lidded:
            yield "out of range, above the walls,", first > float(case.tank.bounds[1][-1])
    elif isinstance(probe, PressureTap) and first[0] > 0.0:
        yield "emptied", np.abs(first) <= DRY * np.nanmax(np.abs(first))


def _share(when: Flags) -> str:
    share = float(when.mean())
    return f"{share:.0%}" if share >= 0.01 else "less than 1%"
