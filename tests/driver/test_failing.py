"""Runs that cannot begin, or cannot go on: one message, the right exit code, nothing lost."""

import json
import os
from pathlib import Path

import h5py
import pytest
from mpi4py import MPI

from parisph import CaseError, StoreError, load, run
from parisph import __main__ as entry
from parisph.io import checkpoint
from tests.launch import contents, mpirun

CASE = '''
from parisph import Box, Case, Energy, Fluid, Numerics, Output, PressureTap, Tank, Volume

def case(gravity: str = "-9.81", time_step: float | None = 0.002, lid: bool = True, preset: str = "violent",
         spacing: float = 0.1, method: str = "ISPH_R", wall_guard: float | None = None, end_time: float = 0.1) -> Case:
    return Case(
        title="wild", fluid=Fluid(Box(width=0.5, height=1.0), density=1000.0),
        walls=Tank(width=2.0, height=2.0, lid=lid),
        gravity=(0.0, gravity), numerics=Numerics(spacing=spacing, time_step=time_step, preset=preset, method=method,
                                                    wall_guard=wall_guard),
        output=Output(checkpoint_every=0.01, every=0.02), end_time=end_time,
        probes=[Volume("volume"), Energy("energy"), PressureTap("tap", at=(0.0, 0.1))],
    )
'''
NO_SOLVER = [word for name in ("", "gamg_", "asm_", "lu_") for word in (f"-pressure_{name}ksp_max_it", "0")]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder with a case, that is the current one."""
    (tmp_path / "wild.py").write_text(CASE)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def short(folder, capfd):
    """The two checkpoints of a run of .02 s in that folder."""
    assert entry.main(["run", "wild.py", "-o", "run", "-q", "--set", "end_time=0.02"]) == 0
    capfd.readouterr()
    return checkpoint.paths("run/checkpoints")


def fails(words, capfd, code, ranks=1):
    """Run a command line that fails with `code`; return its message."""
    if ranks == 1:
        assert entry.main(words) == code
        out, said = capfd.readouterr()
    else:
        done = mpirun(ranks, ["-m", "parisph", *words])
        assert done.returncode == code, done.stderr
        out, said = done.stdout, done.stderr
    assert said.count("parisph: error: ") == 1 and "Traceback" not in said and "Warning" not in said
    assert out == ""
    return said


def check_summary(steps_at_least, began=True):
    """Check summary.json of a failed run and return its status; the volume is known once it has begun, unless its water
    is scattered (None)."""
    summary = json.loads(open("run/summary.json").read())
    assert summary["status"].startswith("failed: ") and summary["steps"] >= steps_at_least
    assert summary["wall_seconds"] > 0.0
    assert began is None or (summary["volume_drift"] is not None) == began
    assert {"case", "method", "ranks", "particles", "time", "phases", "fallbacks", "peak_memory_mb"} <= set(summary)
    return summary["status"]


@pytest.mark.parametrize(("ranks", "need"), [(1, "223 MB of memory on 1 rank;"), (2, "446 MB of memory on 2 ranks;")])
def test_what_does_not_fit_into_memory_is_refused_before_anything_is_made(folder, ranks, need):
    # a small machine, because a large one may have room for any case that is quick to describe
    (folder / "wild.py").write_text("from parisph.base import memory\nmemory.total = lambda: 10**8\n" + CASE)
    done = mpirun(ranks, ["-m", "parisph", "run", "wild.py"], cwd=folder)
    assert done.returncode == 2 and done.stderr.count("parisph: error: ") == 1 and "Traceback" not in done.stderr
    assert f"makes 130 particles, which take about {need} there is 100 MB" in done.stderr
    assert [path.name for path in folder.iterdir()] == ["wild.py"]


@pytest.mark.parametrize("out", ["new/a/b", "there/a"])
def test_a_run_that_is_refused_leaves_the_folders_as_they_were(folder, capfd, out):
    (folder / "there").mkdir()
    said = fails(["run", "wild.py", "-o", out, "--", "-pressure_ksp_type", "nonsense"], capfd, 2)
    assert "nonsense" in said
    assert sorted(path.name for path in folder.rglob("*")) == ["there", "wild.py"]
    # an earlier run that was moved aside for it comes back
    (folder / out).mkdir(parents=True)
    (folder / out / "case.json").write_text("{}")
    fails(["run", "wild.py", "-o", out, "--overwrite", "--", "-pressure_ksp_type", "nonsense"], capfd, 2)
    assert ([path.name for path in (folder / out).parent.iterdir()] == [Path(out).name]
            and (folder / out / "case.json").exists())


@pytest.mark.parametrize("out", ["", "a\nb", "x" * 300, "wild.py", "wild.py/a"])
def test_a_folder_that_cannot_be_is_refused_by_the_function_as_well(folder, out):
    with pytest.raises((CaseError, StoreError), match="^out = |File exists|Not a directory"):
        run(load("wild.py"), MPI.COMM_SELF, out)
    assert [path.name for path in folder.iterdir()] == ["wild.py"]


@pytest.mark.parametrize("ranks", [1, 2])
def test_body_force_that_becomes_infinite(folder, capfd, ranks):
    words = ["run", "wild.py", "-o", "run", "-q", "--set", "gravity=-9.81/where(t < 0.0501, 1, 0)"]
    said = fails(words, capfd, 3, ranks)
    assert "the body force is not a finite number at t = 0.051 s" in said and "see `gravity`" in said
    assert "step 26, from t = 0.05 s" in said
    assert said.count("    id ") == 5
    good = checkpoint.paths("run/checkpoints")[-1]
    assert f"last good checkpoint: {good}" in said and good.stem == "00000025"
    assert check_summary(25) in " ".join(["failed:", said.partition("error: ")[2].strip()])


def test_body_force_that_has_no_value_and_adaptive_step(folder, capfd):
    said = fails(["run", "wild.py", "-o", "run", "-q", "--set", "gravity=log(0.05 - t)", "--set", "time_step=none"],
                 capfd, 3)
    assert "the body force is not a finite number" in said
    check_summary(2)


@pytest.mark.parametrize(("lid", "ranks"), [("true", 1), ("false", 1), ("false", 2)])
def test_absurd_time_step(folder, capfd, lid, ranks):
    words = ["run", "wild.py", "-o", "run", "-q", "--set", "preset=gentle", "--set", "time_step=0.15", "--set",
             f"lid={lid}", "--set", "end_time=15", "--set", "wall_guard=0"]    # which would keep them inside for long
    said = fails(words, capfd, 3, ranks)
    assert "outside the tank" in said and "particle " in said and "last good checkpoint" in said
    check_summary(0, None)


STEEP = """
from parisph import Box, Case, Fluid, Numerics, Tank

def case(preset: str = "gentle", surface_rule: str | None = None, wall_guard: float | None = None):
    return Case(title="column", fluid=Fluid(Box(width=0.5, height=1.0), density=1000.0),
                walls=Tank(width=2.0, height=2.0, lid=True), gravity=(0.0, -9.81),
                numerics=Numerics(spacing=0.1, preset=preset, surface_rule=surface_rule, wall_guard=wall_guard),
                end_time=5.0)
"""


@pytest.mark.parametrize("sets", [[], ["--set", "preset=violent", "--set", "wall_guard=0"]])
def test_kept_surface_beyond_its_range_is_named(folder, capfd, sets):
    """A breaking dam with a surface that keeps its particles."""
    (folder / "steep.py").write_text(STEEP)
    said = fails(["run", "steep.py", "-o", "run", "-q", "--set", "surface_rule=frozen", *sets], capfd, 3)
    assert 'surface_rule="frozen" fails if waves break' in said and 'use surface_rule="gap"' in said


@pytest.mark.parametrize("ranks", [1, 2])
def test_solver_that_never_succeeds(folder, capfd, ranks):
    said = fails(["run", "wild.py", "-o", "run", "-q", "--", *NO_SOLVER], capfd, 3, ranks)
    assert "could not be solved" in said and "direct factors: too many iterations" in said
    assert "step 1, from t = 0 s" in said and "fails if waves break" not in said
    check_summary(0, began=False)


def test_failed_run_goes_on_from_its_last_checkpoint(folder, capfd):
    fails(["run", "wild.py", "-o", "run", "-q", "--set", "gravity=-9.81/where(t < 0.0501, 1, 0)"], capfd, 3)
    said = fails(["restart", "run", "-q"], capfd, 3)
    assert "step 26, from t = 0.05 s" in said      # from the last checkpoint straight into the same wall
    assert entry.main(["restart", "run", "-q", "--until", "0.0501"]) == 2
    assert entry.main(["restart", "run/checkpoints/00000020.h5", "-q", "--until", "0.05", "-o", "later"]) == 0
    assert json.loads(open("later/summary.json").read())["status"] == "completed"


@pytest.mark.parametrize(("words", "says"), [
    (["run", "nowhere.py"], "no such case file"),
    (["run", "wild.py", "--set", "method=ISPH_Q"], "ISPH_R"),
    (["run", "wild.py", "--set", "preset=wild"], "violent"),
    (["run", "wild.py", "--set", "spacing=-0.03"], "spacing"),
    (["run", "wild.py", "--set", "depth=2"], "no parameter 'depth'"),
    (["run", "wild.py", "--set", "time_step=10"], "time_step"),
    (["run", "wild.py", "--set", "gravity=import os"], "import os"),
    (["run", "wild.py", "--set", "gravity=-9.81*height"], "height"),
    (["run", "wild.py", "--", "-ksp_type", "cg"], "-pressure_ksp_type"),
    (["run", "wild.py", "--", "-pressure_ksp_type", "nonsense"], "nonsense"),
    (["run", "wild.py", "--", "-pressure_ksp_rtol", "10"],
     "-pressure_ksp_rtol = 10: must be a number of at least 0 and below 1"),
    (["run", "wild.py", "--", "-pressure_ksp_rtol", "-1"], "-pressure_ksp_rtol = -1: must be"),
])
def test_bad_case_is_refused_before_any_work(folder, capfd, words, says):
    assert says in fails([*words, "-o", "run"] if "--" not in words else [*words[:2], "-o", "run", *words[2:]], capfd,
                         2)
    assert not os.path.exists("run")


@pytest.mark.parametrize(("out", "ranks"), [("wild.py/run", 1), ("wild.py/run", 2), ("/proc/run", 1)])
def test_folder_that_cannot_be_written(folder, capfd, out, ranks):
    said = fails(["run", "wild.py", "-o", out], capfd, 5, ranks)
    assert f"cannot start a run in {out}" in said


@pytest.mark.parametrize(("words", "code", "says"), [
    (["restart", "nowhere"], 5, "nowhere: no such folder or file"),
    (["restart", "."], 5, "holds no run to continue"),
    (["restart", "wild.py"], 5, "not a whole file of parisph"),
])
def test_nothing_to_restart(folder, capfd, words, code, says):
    assert says in fails(words, capfd, code)


def test_restart_of_what_is_finished(folder, short, capfd):
    before = {path: path.stat().st_mtime_ns for path in (folder / "run").rglob("*")}
    assert "ask for more with --until" in fails(["restart", "run"], capfd, 2)
    assert "end_time" in fails(["restart", "run", "--until", "-1"], capfd, 2)
    assert "--until" in fails(["restart", "run", "--until", "nan"], capfd, 2)
    assert "/proc/run" in fails(["restart", "run", "--until", "0.03", "-o", "/proc/run"], capfd, 5)
    assert {path: path.stat().st_mtime_ns for path in (folder / "run").rglob("*")} == before


@pytest.mark.parametrize("ranks", [1, 2])
def test_restart_removes_no_results(folder, capfd, ranks):
    """Neither a run in the folder that is given, nor what came after the checkpoint in its own."""
    for name, end in (("run", "0.03"), ("other", "0.02")):
        assert entry.main(["run", "wild.py", "-o", name, "-q", "--set", f"end_time={end}"]) == 0
    capfd.readouterr()
    before = contents(folder)
    assert "other holds a run already" in fails(["restart", "run", "--until", "0.05", "-o", "other"], capfd, 2, ranks)
    older, last = checkpoint.paths("run/checkpoints")
    for words in ([], ["-o", "run"], ["-o", "other/../run"])[:3 if ranks == 1 else 1]:
        said = fails(["restart", str(older), "--until", "0.02", *words], capfd, 2, ranks)
        assert str(older) in said and str(last) in said and "-o DIR" in said
    assert contents(folder) == before
    if ranks == 1:
        assert entry.main(["restart", str(last), "-q", "--until", "0.04", "-o", "run"]) == 0


def cut_short(path):
    os.truncate(path, os.path.getsize(path) // 2)


def alter(path):
    with h5py.File(path, "r+") as file:
        file["particles/p"][3] += 1.0


@pytest.mark.parametrize(("damage", "ranks"), [(cut_short, 1), (alter, 1), (alter, 2)])
def test_damaged_checkpoint_names_the_sound_one_and_how_to_take_it(folder, short, capfd, damage, ranks):
    older, last = short
    damage(last)
    said = fails(["restart", "run", "--until", "0.03"], capfd, 5, ranks)
    assert str(last) in said and f"the newest sound one beside it is {older}: parisph restart {older} -o DIR" in said
    assert entry.main(["restart", str(older), "-q", "-o", "again"]) == 0
    capfd.readouterr()
    alter(older)
    assert "sound" not in fails(["restart", "run", "--until", "0.03"], capfd, 5)


def test_damaged_older_checkpoint_names_the_last(folder, short, capfd):
    older, last = short
    alter(older)
    assert fails(["restart", str(older)], capfd, 5).endswith(f"parisph restart {last}\n")


def test_restart_clears_away_what_a_killed_run_left(folder, short, capfd):
    for name in (".steps.csv.tmp", ".summary-1.json.tmp", "probes/.tap.csv.tmp", "snapshots/.000001.vtkhdf.tmp",
                 "checkpoints/.00000011.h5.tmp"):
        (folder / "run" / name).touch()
    assert entry.main(["restart", "run", "-q", "--until", "0.03"]) == 0
    assert not list((folder / "run").rglob(".*"))


def test_restart_tells_the_folder_of_the_run(folder, short, capfd):
    last = short[-1]
    assert entry.main(["restart", str(last), "-q", "--until", "0.03"]) == 0
    assert "folder          run\n" in capfd.readouterr().out
