"""Errors of a run's probes against their truths: the `errors` of summary.json."""

from collections.abc import Callable
from typing import Any, cast

import numpy as np

from parisph.base.arrays import Array, Floats
from parisph.base.errors import ParisphError
from parisph.case.probes import Probe, ProbeArray
from parisph.case.profiles import Profiles
from parisph.case.schema import Case
from parisph.case.truths import PeakBand, Peaks, Truth, WaveTruth, read_truth
from parisph.truth import impacts, norms, profiled
from parisph.truth.recorded import Recorded, own_columns

SOUGHT = 0.05    # largest shift tried in either direction, over the compared time


def errors(case: Case, run: Recorded) -> dict[str, dict[str, Any]]:
    """Return {probe name: errors} for the probes that have a truth. Not collective.

    The errors are a dict. Only its last entries shift the time:
    relative_l2 : relative to the wave if Truth.wave is set, in the window of the truth, after Truth.smooth
    paper : the norm of Zheng, Ma & Duan (2014), Er_p and Er_eta, relative to the truth with the depth
    paper_2017 : for waves, that of Zheng et al. (2017), Eq 35
    points : number of compared samples, see norms.on_reference
    start, end : of the compared time [s]
    peaks : for each band of Truth.peaks: start, end, smooth [s], low, high, when [s], level; the greatest value `found`
        and its `time` [s]; whether it is the `last` sample, or too `short` to be resolved; its `mean` over 5 ms
        (truth.impacts); `beyond`, its distance from the band over that of the nearer end from `level`, 0 inside
    others : {name: the same, without peaks} of the further references, also for Profiles
    best_shift, shifted_l2 : the shift [s] of the run's time with the least error, and this error; None if not defined
    shift_sought : the largest shift [s] that was tried; there, a best shift is not a minimum
    If nothing can be compared, relative_l2 is None and `reason` says why. Peaks have only `peaks`, and Profiles the
    entries of profiled.errors.
    """
    return {probe.name: _tried(_error, probe, run) for probe in case.probes if probe.truth is not None}


def series(probe: Probe, run: Recorded) -> tuple[Floats, Floats]:
    """Return the times (n,) [s] and values (n,) of a probe that are compared with its truth."""
    found, column = _recorded(probe, run)
    return found["time"], found[column]


def _recorded(probe: Probe, run: Recorded) -> tuple[Array, str]:
    """Return the table of a probe, and the column that is compared with its truth."""
    found = run.probe(probe.name)
    return found, probe.judged or own_columns(found)[0]


def compared_series(truth: Truth, time: Floats, values: Floats) -> tuple[tuple[Floats, Floats], tuple[Floats, Floats]]:
    """Return the series of a run and of its truth, (times, values) each, as they are compared.

    Both are smoothed. The truth is cut to its window and sampled at equal steps, so that dense samples of an impact
    weigh no more. Raises ValueError if the run does not cover the window, and CaseError for the file.
    """
    reference = read_truth(truth)
    if truth.smooth is not None:
        values = norms.moving_mean(time, values, truth.smooth)
        reference = reference[0], norms.moving_mean(*reference, truth.smooth)
    if truth.window is not None:
        norms.cut(time, values, truth.window)    # raises for a run that is too short
        reference = norms.evenly(*norms.cut(*reference, truth.window))
    return (time, values), reference


def _tried(judge: Callable[..., dict[str, Any]], *about: Any) -> dict[str, Any]:
    """Return judge(*about), or the reason why it fails: a run that is too short, a missing file of the truth."""
    try:
        return judge(*about)
    except (ParisphError, ValueError) as problem:
        return {"relative_l2": None, "reason": str(problem)}


def _error(probe: Probe, run: Recorded) -> dict[str, Any]:
    truth: Any = probe.truth
    if isinstance(probe, ProbeArray):
        return _of_profiles(probe, run)
    table, column = _recorded(probe, run)
    time, values, seldom = table["time"], table[column], impacts.coarse(table)
    if isinstance(truth, Peaks):
        return {"relative_l2": None, "reason": "the truth has only greatest values",
                "peaks": [_peak(band, time, values, seldom) for band in truth.bands]}
    if isinstance(truth, WaveTruth):
        compared = time if truth.window is None else norms.cut(time, values, truth.window)[0]
        place = getattr(probe, "at"), compared, getattr(probe, "y", None)
        return _judged((time, values), (compared, truth.series(*place)), truth.level)
    found = _against(truth, time, values)
    if truth.peaks:
        found["peaks"] = [_peak(band, time, values, seldom) for band in truth.peaks]
    if truth.others:
        found["others"] = {other.name: _tried(_against, other, time, values) for other in truth.others}
    return found


def _of_profiles(probe: ProbeArray, run: Recorded) -> dict[str, Any]:
    """Return the errors of an array. A run may end before all profiles of its truth, but after some of the others."""
    truth = cast(Profiles, probe.truth)
    found, *others = [_tried(profiled.errors, probe, one, run) for one in (truth, *truth.others)]
    if others:
        found["others"] = {one.name: error for one, error in zip(truth.others, others)}
    return found


def _against(truth: Truth, time: Floats, values: Floats) -> dict[str, Any]:
    return _judged(*compared_series(truth, time, values), truth.offset if truth.wave else None)


def _judged(run: tuple[Floats, Floats], reference: tuple[Floats, Floats], level: float | None) -> dict[str, Any]:
    """Return the errors of two series. level : level at rest of a wave, else None"""
    found = norms.judge(*run, *reference, rest=level)
    result = {"relative_l2": found["relative_l2"], "paper": found["z14"], "points": found["samples"],
              "start": found["start"], "end": found["end"], **_shifted(run, reference, level, found["relative_l2"])}
    if level is not None:
        _, value, exact = norms.on_reference(*run, *reference)
        result["paper_2017"] = norms.z17_elevation(value - level, exact - level)
    return result


def _shifted(run: tuple[Floats, Floats], reference: tuple[Floats, Floats], level: float | None,
             error: float) -> dict[str, Any]:
    """Return the best shift and its error; shift 0 if the loss of samples at the ends makes the error larger."""
    try:
        ours, theirs = run[0], reference[0]
        limit = SOUGHT * (min(ours[-1], theirs[-1]) - max(ours[0], theirs[0]))
        shift = norms.best_shift(*run, *reference, limit)
        shifted = norms.judge(*run, *reference, level, shift)["relative_l2"]
        return {"best_shift": shift if shifted < error else 0.0, "shifted_l2": min(shifted, error),
                "shift_sought": limit}
    except ValueError:    # too few samples stay inside
        return {"best_shift": None, "shifted_l2": None, "shift_sought": None}


def _peak(band: PeakBand, time: Floats, values: Floats, seldom: bool) -> dict[str, float | None]:
    """Return a band and the greatest value in its interval, None if the run ends before it. seldom : as of greatest"""
    found: dict[str, float | None] = {**band.model_dump(), "found": None, "time": None, "last": None, "beyond": None,
                                        "short": None, "mean": None}
    if band.smooth is not None:
        values = norms.moving_mean(time, values, band.smooth)
    inside = np.flatnonzero((time >= band.start) & (time <= band.end)) if time[-1] >= band.end else np.array([], int)
    if len(inside):
        k = inside[np.argmax(values[inside])]
        # the last pressure of a run is written twice; one that is constant for longer no longer rises
        last = k >= inside[-1] - 1 and values[k] == values[inside[-1]]
        short = next(iter(impacts.greatest(time, values, np.isin(np.arange(len(time)), inside), seldom)), None)
        found.update(found=float(values[k]), time=float(time[k]), last=bool(last),
                     short=short is not None and short.short, mean=None if short is None else short.mean)
        if band.low is not None and band.high is not None:
            near = np.clip(values[k], band.low, band.high)
            found["beyond"] = float((values[k] - near) / (near - band.level))
    return found
