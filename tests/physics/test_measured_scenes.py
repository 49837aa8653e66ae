"""Scenes that are compared with measured data run to an end, coarse, and keep their water: a few seconds each."""

import numpy as np
import pytest
from mpi4py import MPI

from parisph import open_run, run
from parisph.case import elsewhere
from tests.scenes import made_motion, scene


@pytest.mark.parametrize(("name", "sets"), [
    ("dam_break_zhou", {"spacing": 0.1, "distance": 5.4, "end_time": 3.0}),
    ("dam_break_lobovsky", {"spacing": 0.1, "distance": 5.4, "end_time": 3.0}),
    ("violent_sloshing", {"spacing": 0.02, "end_time": 0.7}),
    ("lateral_roll", {"end_time": 0.05}),
])
def test_runs_to_its_end(tmp_path, monkeypatch, name, sets):
    made_motion(tmp_path)
    monkeypatch.setenv(elsewhere.VARIABLE, str(tmp_path))
    case = scene(name, **sets)
    summary = run(case, MPI.COMM_SELF, tmp_path / "run", progress=False)
    assert summary["status"].startswith("completed") and summary["left"]["particles"] == 0
    drift = summary["volume_range"]
    assert drift is None or -0.05 < drift["low"] <= drift["high"] < 0.05
    made = open_run(tmp_path / "run")
    for probe in case.probes:
        found = made.probe(probe.name)
        assert len(found) > 2 and np.all(np.isfinite(found[found.dtype.names[-1]])), probe.name
