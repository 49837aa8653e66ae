"""`parisph study` with real runs: two methods, two spacings, two ranks, one that blows up; what is made again."""

import csv
import json
import os
import signal
import subprocess
import sys
import time

import pytest

from tests.launch import HANGS, ROOT, clean_environment, parisph

STUDY = f'''
from parisph.study import FinestError, OtherCodes, Quantity, Required, Study, TruthError, Variant
study = Study(
    case={str(ROOT / "cases" / "small_sloshing.py")!r}, title="Short sloshing",
    spacings=[0.1, 0.05], parameters={{"end_time": 0.5, "numerics.rtol": 1e-7}}, warm_up=False,
    variants=[
        Variant(methods=["ISPH", "ISPH_R"], time_steps=[0.032]),
        Variant(methods=["ISPH_R"], spacings=[0.1], time_steps=[0.032], ranks=[2], label="two ranks"),
        Variant(methods=["Z17_ISPH"], spacings=[0.05], time_steps=[0.032], parameters={{"jitter": 0.4}},
                label="no balance"),
    ],
    errors=[TruthError("left"), Quantity("volume_drift", absolute=True, name="volume"), FinestError("left")],
    required=[Required("left", must=1e-9, where={{"label": "two ranks"}})],
    others=[OtherCodes("others.csv")], histories=["left"],
)
'''


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """The folder of a study that has been carried out, and what the command said."""
    folder = tmp_path_factory.mktemp("a study") / "with spaces"
    folder.mkdir()
    (folder / "short study.py").write_text(STUDY)
    (folder / "others.csv").write_text("code,spacing,error,cpu_seconds\nanother,0.1,0.2,3\n")
    done = parisph("study", "short study.py", "-o", "the results", cwd=folder, timeout=200)
    return folder, done


def test_table_files_and_verdict(made):
    folder, done = made
    out = folder / "the results"
    assert done.returncode == 1, done.stderr    # the limit cannot be met
    assert "required and not met:\n  left of two ranks, spacing 0.1" in done.stderr and "Traceback" not in done.stderr
    assert done.stderr.count("[6/6]") == 1 and "CPU s" in done.stderr
    assert "Fitted order in the spacing, ISPH_R: left" in done.stdout and done.stdout.count("| ISPH_R ") >= 2
    with open(out / "results.csv", newline="") as file:
        lines = list(csv.DictReader(file))
    content = json.loads((out / "results.json").read_text())
    assert len(lines) == len(content["runs"]) == 6 and content["missing"] == 0
    assert [line["label"] for line in lines] == ["ISPH", "ISPH", "ISPH_R", "ISPH_R", "two ranks", "no balance"]
    assert all(0.0 < line["left"] < 1.0 for line in content["runs"] if line["label"] == "ISPH_R")
    one, two = content["runs"][2], content["runs"][4]
    assert two["ranks"] == 2 and two["left"] == pytest.approx(one["left"], rel=1e-3) and two["steps"] == one["steps"]
    assert one["left against the finest"] > 0.0 and content["runs"][3]["left against the finest"] is None
    assert "Short sloshing" in (out / "results.md").read_text()
    for name in ("error_left.png", "error_volume.png", "history_left.png"):
        assert (out / name).stat().st_size > 5_000


def test_a_run_that_blows_up_is_a_result(made):
    line = json.loads((made[0] / "the results" / "results.json").read_text())["runs"][5]
    assert line["survived"] is False and line["left"] is None and "(reached t = " in line["reason"]
    assert json.loads(next((made[0] / "the results" / "ends").glob("no_balance*.json")).read_text())["code"] == 3


def test_nothing_is_made_twice(made):
    folder, _ = made
    stamps = {path: path.stat().st_mtime_ns for path in (folder / "the results").glob("runs/*/summary.json")}
    again = parisph("study", "short study.py", "-o", "the results", "--only", "ISPH_R", cwd=folder)
    assert again.returncode == 1 and again.stderr.count("there already") == 3
    assert {path: path.stat().st_mtime_ns for path in stamps} == stamps and len(stamps) == 6
    listed = parisph("study", "short study.py", "-o", "the results", "--list", cwd=folder)
    assert listed.returncode == 0 and "6 runs, 0 to do" in listed.stdout and "diverged" in listed.stdout


def test_a_study_with_a_bad_run_begins_nothing(tmp_path):
    (tmp_path / "bad.py").write_text(STUDY.replace('methods=["ISPH", "ISPH_R"]', 'methods=["ISPH_R", "MPS"]'))
    (tmp_path / "others.csv").write_text("code,spacing,error,cpu_seconds\n")
    done = parisph("study", "bad.py", cwd=tmp_path)
    assert done.returncode == 2 and "unknown method 'MPS'" in done.stderr and done.stderr.count("parisph: error: ") == 1
    assert not (tmp_path / "studies").exists()


def test_a_stop_ends_the_runs_and_leaves_a_table(tmp_path):
    text = STUDY.replace('"end_time": 0.5', '"end_time": 5000.0').replace("others=[OtherCodes(\"others.csv\")], ", "")
    (tmp_path / "long.py").write_text(text)
    study = subprocess.Popen([sys.executable, "-m", "parisph", "study", "long.py"], cwd=tmp_path, text=True,
                             env=clean_environment(), stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    try:
        locks = tmp_path / "studies" / "long" / "runs"
        deadline = time.monotonic() + HANGS
        while not list(locks.glob("*/steps.csv")):
            assert study.poll() is None and time.monotonic() < deadline
            time.sleep(0.05)
        process = json.loads(next(locks.glob("*/run.lock")).read_text())["process"]
        study.send_signal(signal.SIGTERM)    # as Ctrl-C, which a shell sends to a whole group
        out, err = study.communicate(timeout=HANGS)
    finally:
        study.kill()
    assert study.returncode == 4 and "stopped with 6 of 6 runs to do; repeat the command" in err
    assert "Traceback" not in err
    assert "no run has a result yet" in out and (tmp_path / "studies" / "long" / "results.json").exists()
    with pytest.raises(ProcessLookupError):
        os.kill(process, 0)
