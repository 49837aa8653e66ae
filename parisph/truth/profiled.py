"""Errors of an array of surface gauges against profiles. Not collective."""

from typing import Any

import numpy as np

from parisph.base.arrays import Floats
from parisph.case.probes import ProbeArray, surface_gauges
from parisph.case.profiles import Profiles, height, read_profiles
from parisph.truth.recorded import Recorded

Pair = tuple[float, Floats, Floats, Floats]    # time [s]; places, heights of the run and of the reference (n,) [m]


def pairs(probe: ProbeArray, truth: Profiles, run: Recorded) -> list[Pair]:
    """Return run and reference at each time of the reference that the run has reached. Raises CaseError, StoreError."""
    table = run.probe(probe.name)
    gauges = sorted(surface_gauges(probe.probes).values(), key=lambda one: one.at)
    places, found = np.array([one.at for one in gauges]), []
    for time, x, y in read_profiles(truth):
        if not table["time"][0] <= time <= table["time"][-1]:
            continue
        ours = np.array([np.interp(time, table["time"], table[one.name]) for one in gauges])
        theirs = np.array([np.nan if (value := height(x, y, at)) is None else value for at in places])
        there = np.isfinite(ours) & np.isfinite(theirs)
        if np.count_nonzero(there) > 1:
            found.append((time, places[there], ours[there], theirs[there]))
    return found


def errors(probe: ProbeArray, truth: Profiles, run: Recorded) -> dict[str, Any]:
    """Return the errors against all profiles of a truth together and against each, without a shift of time.

    Returns a dict: relative_l2 of all points; points; start, end [s]; mean and rms of run - reference [m]; profiles :
    list of the same for each, with its time [s].

    Raises ValueError if the run has reached none of the profiles.
    """
    found = pairs(probe, truth, run)
    if not found:
        raise ValueError("the run has reached none of the profiles")
    ours, theirs = (np.concatenate([pair[k] for pair in found]) for k in (2, 3))
    return {
        **_distance(truth, ours, theirs), "points": len(ours), "start": found[0][0], "end": found[-1][0],
        "profiles": [{"time": time, **_distance(truth, run_has, other)} for time, _, run_has, other in found],
    }


def _distance(truth: Profiles, ours: Floats, theirs: Floats) -> dict[str, float]:
    size = float(np.linalg.norm(theirs - (truth.offset if truth.wave else 0.0)))
    if size == 0.0:
        raise ValueError("the reference equals the level at rest: there is no relative error")
    apart = ours - theirs
    return {"relative_l2": float(np.linalg.norm(apart)) / size, "mean": float(apart.mean()),
            "rms": float(np.sqrt(np.mean(apart**2)))}
