"""A scene in a process of its own, so that nothing that becomes of it ends the others."""

import subprocess
import sys
from pathlib import Path

from tests.hard import table
from tests.launch import ROOT, run


def outcome_of(module: str, words: list[object], out: Path, limit: float, scene: str, seed: int = 1) -> table.Outcome:
    """Run `python -m MODULE WORDS`, which writes one Outcome to `out`, and return it, whatever becomes of the process.

    limit : wall time [s] after which the process is ended
    scene, seed : of the Outcome of a process that leaves none
    """
    try:
        process = run([sys.executable, "-m", module, *words], timeout=limit, cwd=ROOT)
    except subprocess.TimeoutExpired:
        return table.Outcome(scene, f"failed: not finished after {limit:g} s", seed=seed)
    died = table.Outcome(scene, f"failed: exit code {process.returncode}", seed=seed)
    outcome = table.load(out)[0] if out.exists() else died
    if not outcome.ended_well and process.stderr.strip():
        print(process.stderr, file=sys.stderr, flush=True)
    return outcome
