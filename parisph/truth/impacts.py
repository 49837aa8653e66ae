"""The greatest pressures of a run, and how long they last: the `peaks` of summary.json. Not collective.

A peak of one sample, as when a cavity without air collapses, depends on the time step and on chance.
"""

from typing import Any, NamedTuple

import numpy as np

from parisph.base.arrays import Flags, Floats
from parisph.base.errors import ParisphError
from parisph.case.schema import Case
from parisph.case.truths import intervals
from parisph.truth import norms
from parisph.truth.recorded import Recorded, own_columns, probe_records

MEAN = 0.005     # [s] over which the mean about a peak is taken, near the resolution of a sensor and its amplifier
AROUND = 10      # samples on either side of a peak: the larger of their medians is the level around it
ABOVE = 1.5      # least ratio of a spike to that level
VALUES = 2       # most values of a spike above half of its rise
FEW = 3          # steps between samples, beyond which the duration of a peak is not known
STRAIGHT = 1e-6  # largest distance of a value on the line between its neighbours, over the greatest value
MOST = 20        # most short peaks in the search for one that lasts


class Peak(NamedTuple):
    """A maximum of a series.

    value, time [s]; lasts : time [s] above half of its rise over the level around it; mean : over MEAN about it
    short : whether it is a spike, which particles and steps do not resolve
    """

    value: float
    time: float
    lasts: float
    mean: float
    short: bool


def greatest(time: Floats, values: Floats, allowed: Flags | None = None, seldom: bool = False) -> list[Peak]:
    """Return the Peak with the greatest value, followed by lower ones until one is not short.

    Means in time of the pressure are linear between knots (watch.means). Samples on such a line are not values of a
    spike.

    time, values : (n,), finite ones count; allowed : (n,) bool, samples that may be a peak
    seldom : whether samples are too far apart (`coarse`); no peak is short then
    """
    there = np.isfinite(values)
    time, values = time[there], values[there]
    open_ = np.ones(len(time), bool) if allowed is None else allowed[there]
    found: list[Peak] = []
    if len(time) < 3:
        return found
    means, bends = norms.moving_mean(time, values, MEAN), _bends(time, values)
    while open_.any() and len(found) < MOST:
        k = int(np.argmax(np.where(open_, values, -np.inf)))
        first, last, half, short = _extent(values, bends, k)
        short = short and not seldom
        start = _crossing(time, values, max(first - 1, 0), first, half)
        end = _crossing(time, values, min(last + 1, len(time) - 1), last, half)
        found.append(Peak(float(values[k]), float(time[k]), end - start, float(means[k]), short))
        if not short:
            break
        open_ = open_.copy()
        open_[max(first - 1, 0):last + 2] = False
    return found


def peaks(case: Case, run: Recorded) -> dict[str, dict[str, Any]]:
    """Return {probe: the greatest Peak as a dict with its unit, and `lasting`, the greatest one that is not short}.

    Probes are taps and components of forces (by size, named "load.fx"); those in arrays are named "row.P1". Only the
    intervals of a truth count.
    """
    found: dict[str, dict[str, Any]] = {}
    for record in probe_records(case, run, lambda probe: bool(probe.impacts)):
        time, several, units = record.table["time"], len(record.probe.impacts) > 1, run.units(record.file)
        for column in record.probe.impacts:
            if several and record.prefix + column not in record.columns:
                continue    # it exists in 3D only
            values = record.values(column)
            size = np.abs(values) if several else values
            some = greatest(time, size, _allowed(record.probe.truth, time), coarse(record.table))
            if some and some[0].value > 0.0:    # a component without any force has no peak
                lasting = None if some[-1].short else some[-1]._asdict()
                found[f"{record.name}.{column}" if several else record.name] = {
                    **some[0]._asdict(), "unit": units[record.named(column)], "mean_over": MEAN, "lasting": lasting}
    return found


def asked(case: Case, run: Recorded) -> dict[str, dict[str, Any]]:
    """Return {probe: {value, unit, time [s]}}: the greatest value in the first column of each probe with peak=True.

    Only the intervals of its truth count. Probes without a value are left out.
    """
    found: dict[str, dict[str, Any]] = {}
    for probe in case.probes:
        if not probe.peak:
            continue
        try:
            table, units = run.probe(probe.name), run.units(probe.name)
        except ParisphError:    # no file yet
            continue
        column = own_columns(table)[0]
        allowed = _allowed(probe.truth, table["time"])
        values = np.where(True if allowed is None else allowed, table[column], np.nan)
        if np.isfinite(values).any():
            k = int(np.nanargmax(values))
            found[probe.name] = {"value": float(values[k]), "unit": units[column], "time": float(table["time"][k])}
    return found


def coarse(table: Any) -> bool:
    """Return whether samples are farther apart than MEAN or FEW steps."""
    if len(table) < 2:
        return False
    return bool(np.median(np.diff(table["time"])) > MEAN or np.median(np.diff(table["step"])) > FEW)


def _allowed(truth: Any, time: Floats) -> Flags | None:
    where = intervals(truth)
    return np.any([(time >= start) & (time <= end) for start, end in where], axis=0) if where else None


def _bends(time: Floats, values: Floats) -> Flags:
    """Return whether samples are off the line between their neighbours, (n,) bool; True at both ends."""
    share = (time[1:-1] - time[:-2]) / np.maximum(time[2:] - time[:-2], np.finfo(float).tiny)
    line = values[:-2] + share * (values[2:] - values[:-2])
    off = np.abs(values[1:-1] - line) > STRAIGHT * np.abs(values).max(initial=0.0)
    bends: Flags = np.r_[True, off, True]
    return bends


def _extent(values: Floats, bends: Flags, k: int) -> tuple[int, int, float, bool]:
    """Return the first and the last sample of a peak above half of its rise, that half, and whether it is short."""
    sides = values[max(k - AROUND, 0):k], values[k + 1:k + AROUND + 1]    # after an impact the pressure stays high
    around = max((float(np.median(side)) for side in sides if len(side)), default=0.0)
    half = 0.5 * (float(values[k]) + around)
    first = last = k
    while first > 0 and values[first - 1] >= half:
        first -= 1
    while last < len(values) - 1 and values[last + 1] >= half:
        last += 1
    inside = bool(0 < k < len(values) - 1)
    short = inside and values[k] > ABOVE * max(around, 0.0) and np.count_nonzero(bends[first:last + 1]) <= VALUES
    return first, last, half, bool(short)


def _crossing(time: Floats, values: Floats, below: int, above: int, half: float) -> float:
    """Return the time [s] at which the line between two samples is at half of a rise."""
    share = (half - values[below]) / (values[above] - values[below]) if values[above] != values[below] else 1.0
    return float(time[below] + share * (time[above] - time[below]))
