"""Option files of libraries: the user's own are read, those that lie in the current folder never."""

import sys

import pytest

from tests.launch import parisph, run, succeeded

CASE = '''
from parisph import Box, Case, Fluid, Numerics, Tank
def case() -> Case:
    return Case(title="tank", fluid=Fluid(Box(width=1.0, height=0.5), density=1000.0), gravity=(0.0, -9.81),
                walls=Tank(width=1.0, height=1.0), numerics=Numerics(spacing=0.1, time_step=0.01), end_time=0.02)
'''
BAD = "-log_view\n-pressure_ksp_type nonsense\n"    # who reads it shows its log at the end, and can solve nothing
VERBS = (["run", "tank.py", "-q"], ["check", "tank.py"], ["doctor", "--trial"])

COMPILING = 240.0    # [s] in a new clone these are the first runs, which compile all kernels


@pytest.fixture
def folder(tmp_path):
    """A folder with a case, and one to be the home of the user."""
    (tmp_path / "work").mkdir()
    (tmp_path / "work" / "tank.py").write_text(CASE)
    (tmp_path / "my home").mkdir()
    return tmp_path


@pytest.mark.parametrize(("words", "ranks", "name", "home"), [
    *((words, 1, name, "my home") for words in VERBS for name in (".petscrc", "petscrc")),
    (VERBS[0], 2, ".petscrc", "my home"), (VERBS[2], 2, ".petscrc", "my home"), (VERBS[0], 1, ".petscrc", "work")])
def test_file_in_the_current_folder_is_not_read(folder, words, ranks, name, home):
    """Also if it is the home."""
    (folder / "work" / name).write_text(BAD)
    done = succeeded(parisph(*words, ranks=ranks, cwd=folder / "work", timeout=COMPILING, HOME=str(folder / home)))
    assert "PETSc" not in done.stdout


@pytest.mark.parametrize("ranks", [1, 2])
def test_file_in_the_home_is_read(folder, ranks):
    (folder / "my home" / ".petscrc").write_text(BAD)
    done = parisph(*VERBS[0], ranks=ranks, cwd=folder / "work", timeout=COMPILING, HOME=str(folder / "my home"))
    assert done.returncode == 2 and "nonsense" in done.stderr


def options(folder, script, **settings):
    """Return PETSc's options after a script, which runs in the folder."""
    script += "\nfrom parisph.parallel.petsc import PETSc\nprint(PETSc.Options().getAll())\n"
    done = succeeded(run([sys.executable, "-c", script], cwd=folder / "work", HOME=str(folder / "my home"), **settings))
    return done.stdout


def test_environment_variable_wins_over_the_file_in_the_home(folder):
    (folder / "my home" / ".petscrc").write_text("-one home\n-two home\n")
    found = options(folder, "import os", PETSC_OPTIONS="-two env")
    assert "'one': 'home'" in found and "'two': 'env'" in found


def test_environment_is_left_as_it_was(folder):
    (folder / "my home" / ".petscrc").write_text("-one home\n")
    show = "import os, parisph.parallel.petsc\nprint('here', os.environ.get('PETSC_OPTIONS'))"
    assert "here None" in options(folder, show)
    assert "here -two env" in options(folder, show, PETSC_OPTIONS="-two env")


def test_program_that_has_started_petsc_keeps_what_it_has(folder):
    (folder / "work" / ".petscrc").write_text("-here 1\n")
    found = options(folder, "import petsc4py\npetsc4py.init(['-mine', '2'])")
    assert "'mine': '2'" in found and "'here': '1'" in found and "skip_petscrc" not in found


def test_matplotlib_executes_nothing_that_the_current_folder_names(folder):
    work = folder / "work"
    (work / "evil").write_text("#!/bin/sh\ntouch executed\n")
    (work / "evil").chmod(0o755)
    (work / "matplotlibrc").write_text("animation.ffmpeg_path: ./evil\n")
    assert parisph("run", "tank.py", "-o", "run", "-q", cwd=work, timeout=COMPILING).returncode == 0
    done = parisph("movie", "run", "-o", "flow.mp4", cwd=work)
    assert not (work / "executed").exists() and "Traceback" not in done.stderr
    assert parisph("plot", "run", cwd=work).returncode == 0


@pytest.mark.parametrize("name, width", [(None, 1.5), ("../mine", 7.0)])
def test_the_users_own_file_for_matplotlib_is_read(folder, name, width):
    """It may be named relative to the current folder; 1.5 is matplotlib's own value."""
    (folder / "work" / "matplotlibrc").write_text("lines.linewidth: 9\n")
    (folder / "mine").write_text("lines.linewidth: 7\n")
    script = ("from parisph.pictures import style; style.drawing(); import matplotlib, os; "
              "print(matplotlib.rcParams['lines.linewidth'], os.getcwd())")
    settings = {} if name is None else {"MATPLOTLIBRC": name}
    done = run([sys.executable, "-c", script], cwd=folder / "work", HOME=str(folder / "my home"), **settings)
    assert done.stdout.split() == [str(width), str(folder / "work")], done.stderr


@pytest.mark.parametrize("before, read", [("", 0), ("import numba", 1)])
def test_numba_does_not_read_the_current_folder(folder, before, read):
    """Neither when it is loaded nor when it compiles; but a program that has loaded numba itself keeps what it has."""
    pytest.importorskip("yaml")    # without it numba reads no file
    (folder / "work" / ".numba_config.yaml").write_text("developer_mode: 1\n")
    script = (f"{before}\nimport parisph.kernels.jit, numba\nnumba.njit(lambda x: x)(1)\n"
              "print(numba.config.DEVELOPER_MODE)")
    done = run([sys.executable, "-c", script], cwd=folder / "work", timeout=COMPILING)
    assert done.stdout.split() == [str(read)], done.stderr
