"""Errors of a run's probes against their truths: the `errors` of summary.json."""

from collections.abc import Callable
from typing import Any, cast

import numpy as np

from parisph.base.arrays import Array, Floats
from parisph.base.errors import ParisphError
from parisph.case.probes import AnyProbe, ProbeArray, SurfaceGauge
from parisph.case.profiles import Profiles
from parisph.case.schema import Case
from parisph.case.truths import PeakBand, Peaks, Truth, WaveTruth, read_truth
from parisph.truth import impacts, norms, profiled
from parisph.truth.recorded import Recorded

# The column that a truth is of; the first one of other probes.
COLUMNS = {"energy": "total", "volume": "cell", "flux": "total"}
SOUGHT = 0.05    # share of the compared time by which the run is shifted either way, for the best shift


def errors(case: Case, run: Recorded) -> dict[str, dict[str, Any]]:
    """Return {probe name: errors} for the probes that have a truth. Not collective.

    case : Case; run : io.reader.Run

    Returns
    -------
    dict of dicts. All but the last two entries are of the series as they are, without any shift of time.
    relative_l2 : of the wave part if Truth.wave is set, in the window of the truth, of what Truth.smooth leaves
    paper : the norm of Zheng, Ma & Duan (2014), Er_p and Er_eta, which includes the depth
    paper_2017 : for waves, that of Zheng et al. (2017), Eq 35 (which decreases with the number of samples)
    points : number of compared samples of the truth, or of the run if the truth is too coarse (norms.on_reference)
    start, end : of what was compared [s]
    peaks : for each band of Truth.peaks: start, end, smooth [s], low, high, when [s], level, the greatest value
        `found`, its `time` [s], whether it is the `last` sample, so that later ones may be greater, whether it is too
        `short` to be resolved, its `mean` over 5 ms (truth.impacts), and by which share of the nearer end it is
        `beyond` the band, 0 inside; both count from `level`
    others : {name: the same, without peaks} of the further references, also for Profiles
    best_shift, shifted_l2 : the shift [s] of the run's time with the least error, and this error; None if it is not
        defined
    shift_sought : the largest shift [s] either way that was tried; a best shift at that end is no minimum
    If nothing can be compared: relative_l2 None, and `reason`. For Peaks there are only `peaks`; for Profiles what
    profiled.errors returns.
    """
    return {probe.name: _error(probe, run) for probe in case.probes if probe.truth is not None}


def series(probe: AnyProbe, run: Recorded) -> tuple[Floats, Floats]:
    """Return the times (n,) [s] and values (n,) of a probe's column that a truth is of."""
    found, column = _recorded(probe, run)
    return found["time"], found[column]


def _recorded(probe: AnyProbe, run: Recorded) -> tuple[Array, str]:
    """Return the table of a probe, and the name of the column that a truth is of."""
    found = run.probe(probe.name)
    own = (name for name in found.dtype.names or () if name not in ("time", "step"))
    return found, COLUMNS.get(probe.kind) or next(own)


def prepared(truth: Truth, time: Floats, values: Floats) -> tuple[tuple[Floats, Floats], tuple[Floats, Floats]]:
    """Return the series of a run and of its truth, (times, values) each, as they are compared.

    Both are smoothed. The truth is cut to its window and sampled evenly there: a file may be denser at an impact, which
    would otherwise weigh more. Raises ValueError if the run does not reach over the window, and CaseError for the file.
    """
    reference = read_truth(truth)
    if truth.smooth is not None:
        values = norms.moving_mean(time, values, truth.smooth)
        reference = reference[0], norms.moving_mean(*reference, truth.smooth)
    if truth.window is not None:
        norms.cut(time, values, truth.window)    # which a run that is too short does not have
        reference = norms.evenly(*norms.cut(*reference, truth.window))
    return (time, values), reference


def _error(probe: AnyProbe, run: Recorded) -> dict[str, Any]:
    truth = probe.truth
    try:
        if isinstance(probe, ProbeArray):
            return _of_profiles(probe, run)
        table, column = _recorded(probe, run)
        time, values, seldom = table["time"], table[column], impacts.coarse(table)
        if isinstance(truth, Peaks):
            return {"relative_l2": None, "reason": "others report only greatest values",
                    "peaks": [_peak(band, time, values, seldom) for band in truth.bands]}
        if isinstance(truth, WaveTruth) and isinstance(probe, SurfaceGauge):
            compared = time if truth.window is None else norms.cut(time, values, truth.window)[0]
            return _judged((time, values), (compared, truth.series(probe.at, compared)), truth.level)
        assert isinstance(truth, Truth)
        found = _against(truth, time, values)
    except (ParisphError, ValueError) as problem:
        return _not_judged(problem)
    if truth.peaks:
        found["peaks"] = [_peak(band, time, values, seldom) for band in truth.peaks]
    if truth.others:
        found["others"] = {other.name: _other(other, time, values) for other in truth.others}
    return found


def _of_profiles(probe: ProbeArray, run: Recorded) -> dict[str, Any]:
    """Return the errors of an array; a run that ends before all profiles of its truth may have come to the others."""
    truth = cast(Profiles, probe.truth)
    found, *others = [_tried(profiled.errors, probe, one, run) for one in (truth, *truth.others)]
    if others:
        found["others"] = {one.name: error for one, error in zip(truth.others, others)}
    return found


def _other(truth: Truth, time: Floats, values: Floats) -> dict[str, Any]:
    return _tried(_against, truth, time, values)


def _tried(judge: Callable[..., dict[str, Any]], *about: Any) -> dict[str, Any]:
    try:
        return judge(*about)
    except (ParisphError, ValueError) as problem:
        return _not_judged(problem)


def _not_judged(problem: Exception) -> dict[str, Any]:
    """The run is too short, or the file of the truth is missing: the summary is still written."""
    return {"relative_l2": None, "reason": str(problem)}


def _against(truth: Truth, time: Floats, values: Floats) -> dict[str, Any]:
    return _judged(*prepared(truth, time, values), truth.offset if truth.wave else None)


def _judged(run: tuple[Floats, Floats], reference: tuple[Floats, Floats], level: float | None) -> dict[str, Any]:
    """Return the errors of two series. level : None, or that of a wave at rest"""
    found = norms.judge(*run, *reference, rest=level)
    result = {"relative_l2": found["relative_l2"], "paper": found["z14"], "points": found["samples"],
              "start": found["start"], "end": found["end"], **_shifted(run, reference, level, found["relative_l2"])}
    if level is not None:
        _, value, exact = norms.on_reference(*run, *reference)
        result["paper_2017"] = norms.z17_elevation(value - level, exact - level)
    return result


def _shifted(run: tuple[Floats, Floats], reference: tuple[Floats, Floats], level: float | None,
             error: float) -> dict[str, Any]:
    """Return the best shift and its error; no shift, where what is left out at the ends would make it worse."""
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
    """Return a band and the greatest value of the series in its interval; None if the run ends before it does.

    seldom : as of impacts.greatest
    """
    found: dict[str, float | None] = {**band.model_dump(), "found": None, "time": None, "last": None, "beyond": None,
                                        "short": None, "mean": None}
    if band.smooth is not None:
        values = norms.moving_mean(time, values, band.smooth)
    inside = np.flatnonzero((time >= band.start) & (time <= band.end)) if time[-1] >= band.end else np.array([], int)
    if len(inside):
        k = inside[np.argmax(values[inside])]
        # the last pressure of a run is written twice; a level value is not one that rises
        last = k >= inside[-1] - 1 and values[k] == values[inside[-1]]
        short = next(iter(impacts.greatest(time, values, np.isin(np.arange(len(time)), inside), seldom)), None)
        found.update(found=float(values[k]), time=float(time[k]), last=bool(last),
                     short=short is not None and short.short, mean=None if short is None else short.mean)
        if band.low is not None and band.high is not None:
            near = np.clip(values[k], band.low, band.high)
            found["beyond"] = float((values[k] - near) / (near - band.level))
    return found
