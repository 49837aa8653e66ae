"""Runs of a study as processes: how they end, which are made again, time limits, and what a stop leaves."""

import os
import sys
from dataclasses import replace

import pytest

from parisph.base import environment
from parisph.base.errors import StoreError
from parisph.io.lock import Lock
from parisph.study import Study, processes, runs
from parisph.study.plan import plan_study
from parisph.study.study_folder import hold
from tests.running import lives
from tests.unit.test_study_plan import CASE

# In place of parisph: it notes its process id and when it begins and ends, leaves a summary, and ends as it is told.
PROGRAM = '''
import os, pathlib, sys, time
out = pathlib.Path(sys.argv[1]); out.mkdir(parents=True, exist_ok=True)
with open(out / "pids", "a") as file: file.write(f"{{os.getpid()}}\\n")
began = time.monotonic()
while len(list(out.parent.glob("*/pids"))) < {together} and time.monotonic() < began + 100.0: time.sleep(0.01)
time.sleep({seconds})
(out / "times").write_text(f"{{began}} {{time.monotonic()}}")
(out / "summary.json").write_text("{{}}")
print("parisph: error: it went wrong")
sys.exit({code})
'''


@pytest.fixture
def bench(tmp_path, monkeypatch):
    """A function that makes runs which end as told, and yields them with their ends; `bench.plan` is their Plan."""
    (tmp_path / "tank.py").write_text(CASE)
    (tmp_path / "level.csv").write_text("t,y\n0,0.5\n10,0.5\n")

    def go(code=0, seconds=0.0, jobs=1, limit=None, renew=lambda: None, together=1):
        monkeypatch.setattr(processes, "command", lambda words, ranks: [
            sys.executable, "-c", PROGRAM.format(code=code, seconds=seconds, together=together),
            words[words.index("-o") + 1]])
        return runs.make(go.plan.runs, replace(go.plan, limit=limit), jobs, renew)

    go.plan = plan_study(Study(case="tank.py", spacings=[0.1, 0.05]), tmp_path / "s.py", out=tmp_path / "the study")
    return go


def done(bench, limit=None):
    """Return the folders of the runs that would not be made again with this limit [s]."""
    ends = runs.ends(replace(bench.plan, limit=limit))
    return [run.folder for run in bench.plan.runs if run.key in ends]


def pids(bench):
    return [int(pid) for path in bench.plan.folder.glob("runs/*/pids") for pid in path.read_text().split()]


@pytest.mark.parametrize(("code", "status", "again"), [
    (0, "completed", False), (3, "diverged", False), (1, "failed", True), (5, "failed", True)])
def test_how_runs_end_and_which_are_made_again(bench, code, status, again):
    ends = [end for _, end in bench(code)]
    assert [(end.code, end.status) for end in ends] == [(code, status)] * 2
    assert len(done(bench)) == (0 if again else 2)
    assert code == 0 or "it went wrong" in ends[0].reason


def test_another_code_or_a_lost_summary_makes_a_run_again(bench):
    list(bench())
    first, second = bench.plan.runs
    (bench.plan.folder / "runs" / first.folder / "summary.json").unlink()
    assert done(bench) == [second.folder]
    path = bench.plan.folder / "ends" / f"{second.folder}.json"
    path.write_text(path.read_text().replace(second.key, "0" * 32))
    assert done(bench) == [], "it does not match its digest"


def test_a_run_is_ended_after_its_time(bench, monkeypatch):
    monkeypatch.setattr(processes, "PATIENCE", 1.0)
    ends = [end for _, end in bench(seconds=60.0, limit=0.5, jobs=2)]
    assert [end.status for end in ends] == ["out of time"] * 2 and ends[0].reason == "out of time after 0.5 s"
    assert not any(map(lives, pids(bench)))
    assert len(done(bench, 0.4)) == len(done(bench, 0.5)) == 2, "with no more time they would not come farther"
    assert done(bench, 5.0) == done(bench) == []


def test_ctrl_c_ends_the_runs_and_nothing_else(bench):
    def stop():
        if len(pids(bench)) == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        list(bench(seconds=60.0, jobs=2, renew=stop))
    assert not any(map(lives, pids(bench))) and lives(os.getpid())
    assert done(bench) == []


@pytest.mark.parametrize("jobs", [1, 2])
def test_jobs_are_how_many_run_at_once(bench, jobs):
    assert len(list(bench(seconds=0.3, jobs=jobs, together=jobs))) == 2
    (_, ended), (began, _) = sorted([float(time) for time in path.read_text().split()]
                                    for path in bench.plan.folder.glob("runs/*/times"))
    assert (began < ended) == (jobs == 2)


def test_one_study_at_a_time_in_a_folder(tmp_path):
    with hold(tmp_path / "s"):
        with pytest.raises(StoreError, match="in use by process"):
            Lock(tmp_path / "s")
    with hold(tmp_path / "s"):
        pass


def test_a_run_starts_outside_of_mpirun():
    found = environment.for_own()
    assert found["PYTHONPATH"] and not [name for name in found if name.startswith("OMPI_COMM_")]
    assert processes.command(["run", "a.json"], 1)[1:] == ["-m", "parisph", "run", "a.json"]
    assert processes.command(["run"], 2)[1:3] == ["-n", "2"]
