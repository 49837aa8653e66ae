"""Errors of a run's probes against their truths: the `errors` of summary.json."""

from typing import Any

from parisph.base.errors import ParisphError
from parisph.case.probes import WaveTruth, read_truth
from parisph.case.schema import Case
from parisph.truth import norms
from parisph.truth.recorded import Recorded

# The column that a truth is of; the first one of other probes.
COLUMNS = {"energy": "total", "volume": "cell"}


def errors(case: Case, run: Recorded) -> dict[str, dict[str, Any]]:
    """Return {probe name: errors} for the probes that have a truth. Not collective.

    case : Case; run : io.reader.Run

    Returns
    -------
    dict of dicts: relative_l2 (of the wave part if Truth.wave is set); paper, the norm of Zheng, Ma &
    Duan (2014), Er_p and Er_eta, which includes the depth; paper_2017, for waves, that of Zheng et al.
    (2017), Eq 35 (which decreases with the number of samples); points, the number of compared samples of
    the truth, or of the run if the truth is too coarse (errors.on_reference). If nothing can be compared:
    relative_l2 None, and `reason`.
    """
    return {probe.name: _error(probe, run) for probe in case.probes if probe.truth is not None}


def _error(probe, run):
    try:
        found = run.probe(probe.name)
        column = COLUMNS.get(probe.kind, next(name for name in found.dtype.names if name not in ("time", "step")))
        return _judged(probe, found["time"], found[column])
    except (ParisphError, ValueError) as problem:
        # the run is too short, or the file of the truth is missing: the summary is still written
        return {"relative_l2": None, "reason": str(problem)}


def _judged(probe, time, values):
    truth = probe.truth
    if isinstance(truth, WaveTruth):
        return _judged_as_wave(time, values, (time, truth.series(probe.at, time)), truth.level)
    reference = read_truth(truth)
    if not truth.wave:
        found = norms.judge(time, values, *reference)
        return {"relative_l2": found["relative_l2"], "paper": found["z14"], "points": found["samples"]}
    return _judged_as_wave(time, values, reference, truth.offset)


def _judged_as_wave(time, values, reference, level):
    found = norms.judge(time, values, *reference, rest=level)
    _, value, exact = norms.on_reference(time, values, *reference)
    return {"relative_l2": found["relative_l2"], "paper": found["z14"],
            "paper_2017": norms.z17_elevation(value - level, exact - level), "points": found["samples"]}
