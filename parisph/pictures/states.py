"""The state of a run in the titles of pictures: how it has ended, or that it goes on."""

from typing import Any

import numpy as np

from parisph.base.errors import StoreError
from parisph.io.reader import Run

LONGEST = 140   # characters of a state
LAST = 0.03    # share of the samples at the end of a failed run that may show the failure


def state(run: Run) -> str:
    """Return a line such as "failed after t = 1.2 s: particle 7 ... outside the tank"; "" for a completed run."""
    ends, summary = span(run), _summary(run)
    when = "before its first step" if ends is None else f"after t = {ends[1]:.4g} s"
    if summary is None:
        return f"goes on, or was killed, {when} of {run.scene.end_time:.4g} s"
    words = str(summary.get("status"))
    if words.startswith("completed"):
        return ""
    if words.startswith("failed"):
        why = words.removeprefix("failed").lstrip(": ").splitlines()
        return f"failed {when}" + (f": {why[0]}" if why else "")
    return f"{words} {when}"


def failed(run: Run) -> bool:
    """Return whether a run has failed."""
    return str((_summary(run) or {}).get("status")).startswith("failed")


def span(run: Run) -> tuple[float, float] | None:
    """Return the start of the first and the end of the last step [s] that was completed, None if there is none."""
    try:
        steps = run.steps
    except StoreError:
        return None
    if not len(steps):
        return None
    return float(steps["time"][0] - steps["dt"][0]), float(steps["time"][-1])


def before_failure(samples: int) -> int:
    """Return the number of samples of a failed run without those that may show the failure."""
    return samples - min(max(int(np.ceil(LAST * samples)), 3), samples // 2)


def _summary(run: Run) -> dict[str, Any] | None:
    try:
        return run.summary
    except StoreError:    # parisph info reports the fault
        return {"status": "completed"}
