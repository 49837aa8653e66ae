"""Bad input on the command line: one clear message, the right exit code, nothing done."""

import json
import sys
import types

import numpy as np
import pytest

from parisph import __main__ as entry
from parisph import cli, load, open_run, parser, verbs
from parisph.base import errors
from parisph.base.text import is_plain
from tests.launch import mpirun, parisph, succeeded

CASE = '''
from parisph import Box, Case, Fluid, Numerics, Tank
def case(spacing: float = 0.1, title: str = "tank") -> Case:
    return Case(title=title, fluid=Fluid(Box(width=1.0, height=0.5), density=1000.0), gravity=(0.0, -9.81),
                walls=Tank(width=1.0, height=1.0), numerics=Numerics(spacing=spacing), end_time=1.0)
'''


@pytest.fixture
def case(tmp_path, monkeypatch):
    """A good case file, in an empty folder that is the current one."""
    path = tmp_path / "tank.py"
    path.write_text(CASE)
    monkeypatch.chdir(tmp_path)
    return path


@pytest.fixture
def driver(monkeypatch):
    """A driver that notes its calls and does nothing, or raises `driver.error`."""
    fake = types.ModuleType("parisph.driver")
    fake.calls, fake.error = [], None

    def call(*args, **options):
        fake.calls.append((args, options))
        if fake.error is not None:
            raise fake.error
        return {"status": "completed", "particles": 12345, "volume_drift": 0.0123}

    fake.run = fake.restart = call
    fake.describe = lambda case, parameters: f"stages of {case.title} {parameters}"
    monkeypatch.setitem(sys.modules, "parisph.driver", fake)
    monkeypatch.setattr("parisph.driver", fake, raising=False)
    return fake


@pytest.mark.parametrize(("words", "says"), [
    ([], "required: VERB"),
    (["swim"], "invalid choice: 'swim'"),
    (["run"], "required: CASE"),
    (["run", "nowhere.py"], "nowhere.py: there is no such case file"),
    (["run", "tank.py", "--set", "spacing"], "must be name=value"),
    (["run", "tank.py", "--set", "spaceing=1"], "did you mean 'spacing'"),
    (["run", "tank.py", "--set", "spacing=wide"], "must be a number"),
    (["run", "tank.py", "--set", "spacing=-1"], "spacing"),
    (["check", "tank.py", "--sets", "spacing=1"], "unknown argument --sets"),
    (["run", "tank.py", "-pressure_ksp_view"], "come after a lone --"),
    (["check", "tank.py", "--", "-pressure_ksp_view"], "takes no options for PETSc"),
    (["run", "tank.py", "-log_view"], "set PETSC_OPTIONS=-log_view before the command"),
    (["run", "tank.py", "--", "-log_view"], "set PETSC_OPTIONS=-log_view before the command"),
    (["run", "tank.py", "--", "-pressure_ksp_view", "--set", "spacing=0.05"],
     "write --set and its value before the --"),
    (["run", "tank.py", "--", "-o", "mine"], "write -o and its value before the --"),
    (["restart", "runs/tank", "--", "--until", "3"], "write --until and its value before the --"),
    (["restart"], "required: DIR"),
    (["restart", "runs/tank", "--until", "late"], "argument --until: 'late': must be a finite number"),
    (["restart", "runs/tank", "--until", "nan"], "argument --until: 'nan': must be a finite number"),
    (["plot", "runs/tank", "--time", "1e999"], "argument --time: '1e999': must be a finite number"),
    (["compare", "runs/tank", "a.csv", "--rest", "nan"], "argument --rest: 'nan': must be a finite number"),
    (["compare", "runs/tank", "a.csv", "--scale", "inf"], "argument --scale: 'inf': must be a finite number"),
    (["run", ""], "argument CASE: '': must not be empty"),
    (["run", "tank.py", "-o", ""], "argument -o/--out: '': must not be empty"),
    (["run", "tank.py", "-o", "a\nb"], r"argument 'a\nb': must be text without line breaks"),
    (["run", "tank.py", "-o", "\udcff"], r"argument '\udcff': must be text without line breaks"),
    (["run", "tank.py", "--set", "title=\x1b[2J"], r"argument 'title=\x1b[2J': must be text without"),
    (["run", "tank.py", "-o", "x" * 300], "is too long: a name has at most 255 bytes"),
    (["run", "tank.py", "-o", "x/" * 3000], "is too long"),
    (["info", "x" * 5000], "argument DIR: 'xxx"),
    (["x" * 5000], "invalid choice: 'xxx"),
    (["run", "tank.py", "--" + "x" * 5000], "unknown argument --xxx"),
    (["run", "tank.py", "--", "--" + "x" * 5000], "is after the lone --"),
    (["run", "."], ".: is a folder; give a case file"),
    (["compare", "runs/tank"], "required: REFERENCE.csv"),
    (["study"], "required: FILE"),
    (["study", "tank.py", "-j", "0"], "argument -j/--jobs: '0': must be a whole number of at least 1"),
    (["study", "tank.py", "--limit", "long"], "argument --limit: 'long': must be a finite number"),
])
def test_bad_usage_is_one_message_and_code_2(case, driver, capsys, words, says):
    assert entry.main(words) == 2
    shown = capsys.readouterr()
    assert shown.err.startswith("parisph: error: ") and says in shown.err
    assert is_plain(shown.err.replace("\n", "")) and max(map(len, shown.err.split("\n"))) < 500
    assert "Traceback" not in shown.err and shown.out == ""
    assert driver.calls == [] and not (case.parent / "runs").exists()


def test_a_long_path_does_not_fill_the_screen(case, capsys):
    assert entry.main(["info", "y/" * 1900]) == 5
    shown = capsys.readouterr().err
    assert shown.startswith("parisph: error: there is no folder y/y/") and len(shown) < 420


def test_debug_shows_the_traceback(case, capsys):
    assert entry.main(["run", "nowhere.py", "--debug"]) == 2
    assert "Traceback" in capsys.readouterr().err


@pytest.mark.parametrize(("error", "code"), [
    (errors.CaseError("x"), 2), (errors.SolverDiverged("x"), 3), (errors.ParticleLost("x"), 3),
    (errors.Interrupted("x"), 4), (KeyboardInterrupt(), 4), (errors.StoreError("x"), 5),
    (errors.ParisphError("x"), 1), (ZeroDivisionError("x"), 1),
])
def test_exit_codes(case, driver, capsys, error, code):
    driver.error = error
    assert entry.main(["run", "tank.py"]) == code
    meant = isinstance(error, (errors.ParisphError, KeyboardInterrupt))
    shown = capsys.readouterr().err
    assert "parisph: error: " in shown and ("Traceback" in shown) is not meant


def test_several_values_may_follow_one_set(case, driver):
    assert entry.main(["run", "tank.py", "--set", "spacing=0.05", "title=two", "-q"]) == 0
    given = driver.calls[0][0][0]
    assert (given.numerics.spacing, given.title) == (0.05, "two")
    assert entry.main(["run", "tank.py", "title=two"]) == 2, "but none without it"


def test_run_hands_over_the_case_and_petsc_options(case, driver, capsys):
    assert entry.main(["run", "tank.py", "--set", "spacing=0.05", "--set", "title=two = three", "-q", "--",
                       "-pressure_ksp_rtol", "1e-9"]) == 0
    (given, comm, out), options = driver.calls[0]
    assert (given.numerics.spacing, given.title) == (0.05, "two = three")
    assert comm.size == 1 and out == "runs/tank"
    assert options == {"petsc_options": ["-pressure_ksp_rtol", "1e-9"], "progress": False,
                       "overwrite": False, "force": False}
    shown = capsys.readouterr().out
    assert "12,345" in shown and "+1.23%" in shown and "runs/tank" in shown


def test_a_new_run_never_takes_the_folder_of_another(case, driver, capsys):
    (case.parent / "runs" / "tank").mkdir(parents=True)
    (case.parent / "mine").mkdir()
    (case.parent / "mine" / "case.json").write_text("{}")
    assert entry.main(["run", "tank.py"]) == 0
    assert driver.calls[0][0][2] == "runs/tank-2"
    assert entry.main(["run", "tank.py", "-o", "mine"]) == 2
    assert "mine holds a run already" in capsys.readouterr().err and len(driver.calls) == 1


def test_restart_hands_over(driver):
    assert entry.main(["restart", "runs/tank", "--until", "2.5", "-o", "more", "--", "-pressure_ksp_view"]) == 0
    (path, _), options = driver.calls[0]
    assert path == "runs/tank"
    assert options == {"until": 2.5, "out": "more", "petsc_options": ["-pressure_ksp_view"],
                       "progress": True, "force": False}


def test_check_describes(case, driver, capsys):
    assert entry.main(["check", "tank.py", "--set", "spacing=1/20"]) == 0
    assert capsys.readouterr().out == "stages of tank {'spacing': 0.05, 'title': 'tank'}\n"


def test_info_of_what_is_no_run(tmp_path, capsys):
    assert entry.main(["info", str(tmp_path)]) == 5
    assert "is not the folder of a run" in capsys.readouterr().err
    assert entry.main(["info", str(tmp_path / "nothing")]) == 5
    assert f"there is no folder {tmp_path / 'nothing'}" in capsys.readouterr().err


def test_every_verb_explains_itself(capsys):
    for verb in ("run", "restart", "check", "study", "info", "plot", "movie", "compare", "doctor", "completion"):
        with pytest.raises(SystemExit) as end:
            cli.parse([verb, "-h"])
        assert end.value.code == 0 and f"usage: parisph {verb}" in capsys.readouterr().out


def test_every_verb_has_work():
    known = next(action for action in parser.build()._actions if action.choices).choices
    assert list(verbs.WORK) == list(known)


MOODY = CASE + """
import os, time, uuid
with open("loaded.txt", "a") as file:
    file.write(os.environ.get("OMPI_COMM_WORLD_RANK", os.environ.get("PMI_RANK", "?")))
plain = case
def case(spacing: float = 0.1) -> Case:
    rank = int(os.environ.get("OMPI_COMM_WORLD_RANK", os.environ.get("PMI_RANK", 0)))
    width = 1.0 + 0.1 * rank
    return plain(spacing, f"tank {time.time_ns()} {os.getpid()} {uuid.uuid4()}").changed(
        **{"fluid.shape.width": width, "walls.width": width, "end_time": 0.02, "output.every": 0.02,
           "numerics.time_step": 0.02 / (5 + rank)})
"""


def test_case_that_differs_from_rank_to_rank_is_loaded_on_one(case):
    """By rank, process and clock: each rank would have particles, steps and a title of its own."""
    case.write_text(MOODY)
    succeeded(mpirun(2, ["-m", "parisph", "run", "tank.py", "-q", "-o", "run"], cwd=case.parent, timeout=120))
    assert (case.parent / "loaded.txt").read_text() == "0"
    stored = load("run/case.json")
    summary = json.loads((case.parent / "run" / "summary.json").read_text())
    assert stored.walls.width == 1.0 and summary["case"] == stored.title
    assert summary["steps"] == round(0.02 / stored.numerics.time_step)
    succeeded(mpirun(1, ["-m", "parisph", "run", "run/case.json", "-q", "-o", "again"], cwd=case.parent))
    first, second = (open_run(name).snapshot(-1) for name in ("run", "again"))
    np.testing.assert_array_equal(first["id"], second["id"])
    assert np.abs(first["x"] - second["x"]).max() < 1e-6


# the import starts PETSc, which all ranks must do together, and one rank loads the case
STARRED = CASE.replace("from parisph import Box, Case, Fluid, Numerics, Tank", "from parisph import *")
ON_THE_FIRST = CASE + "\nimport os\nif os.environ.get('OMPI_COMM_WORLD_RANK', os.environ.get('PMI_RANK')) == '0': {}\n"


@pytest.mark.parametrize(("text", "words", "says"), [
    (CASE, ["run", "tank.py", "--set", "depth=1"], "no parameter 'depth'"),
    (CASE, ["check", "tank.py"], "start it without mpirun"),
    (STARRED, ["run", "tank.py", "--set", "spacing=-1"], "spacing = -1"),
    (ON_THE_FIRST.format("assert False, 'no such file here'"), ["run", "tank.py"], "no such file here"),
    (ON_THE_FIRST.format("raise SystemExit('no such file here')"), ["run", "tank.py"], "no such file here"),
])
def test_what_is_wrong_on_two_ranks_is_said_once(case, text, words, says):
    case.write_text(text)
    done = mpirun(2, ["-m", "parisph", *words], cwd=case.parent)
    assert done.returncode == 2 and not (case.parent / "runs").exists()
    assert done.stderr.count("parisph: error: ") == 1 and says in done.stderr and "Traceback" not in done.stderr


FAULT = '''
import sys, types
from mpi4py import MPI
def run(case, comm, out, **options):
    if comm.rank == 1:
        raise {error}
    comm.barrier()
driver = types.ModuleType("parisph.driver")
driver.run = run
sys.modules["parisph.driver"] = driver
import parisph
parisph.driver = driver
from parisph.__main__ import main
from parisph.base.errors import StoreError
sys.exit(main(["run", "tank.py"]))
'''


@pytest.mark.parametrize(("error", "code", "says"), [
    ("ZeroDivisionError('at the rank')", 1, "ZeroDivisionError: at the rank"),
    ("StoreError('disk of one rank')", 5, "parisph: error: disk of one rank"),
])
def test_fault_of_one_rank_ends_the_others(case, error, code, says):
    """The other rank waits in a collective that never comes."""
    program = case.parent / "fault.py"
    program.write_text(FAULT.format(error=error))
    done = mpirun(2, [program], cwd=case.parent)
    assert done.returncode == code
    assert says in done.stderr and "Traceback" in done.stderr


def test_mpirun_of_another_mpi_library_is_noticed(case):
    """Each process would take itself for the only rank, and all would write into one folder."""
    done = parisph("run", "tank.py", cwd=case.parent, PMI_RANK="0", PMI_SIZE="2")
    assert done.returncode == 1
    assert "belong to different MPI libraries" in done.stderr
    assert not (case.parent / "runs").exists()
