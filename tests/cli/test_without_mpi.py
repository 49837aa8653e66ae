"""A laptop without MPI and PETSc: a case is checked, a run is looked at, and `run` says what is missing."""

import sys

import pytest

from parisph.base import libraries
from parisph.base.errors import MissingLibrary
from tests.launch import ROOT, clean_environment, parisph, run, succeeded

CASE = ROOT / "cases" / "small_sloshing.py"

# Python imports a module of this name when it starts.
HIDING = '''
import sys

class Hidden:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in {names}:
            raise ModuleNotFoundError(f"No module named {{name!r}}", name=name)

sys.meta_path.insert(0, Hidden())
'''


@pytest.fixture(scope="module")
def stored(tmp_path_factory):
    """The folder of a short run, made with everything installed."""
    folder = tmp_path_factory.mktemp("stored")
    succeeded(parisph("run", CASE, "--set", "spacing=0.1", "end_time=1", "-q", "-o", "run", cwd=folder))
    return folder / "run"


@pytest.fixture(scope="module")
def hide(tmp_path_factory):
    """Return a function that gives the settings under which libraries cannot be imported."""
    def settings(*names):
        folder = tmp_path_factory.mktemp("hiding")
        (folder / "sitecustomize.py").write_text(HIDING.format(names=names))
        return {"PYTHONPATH": f"{folder}:{clean_environment()['PYTHONPATH']}"}
    return settings


@pytest.fixture(scope="module")
def laptop(hide):
    return hide("mpi4py", "petsc4py")


@pytest.mark.parametrize(("words", "says"), [
    (["check", CASE, "--set", "spacing=0.1"], "particles   241"),
    (["check", "RUN/case.json"], "particles   241"),
    (["info", "RUN"], "completed"),
    (["plot", "RUN", "-o", "page.png"], "page.png"),
    (["plot", "RUN", "--time", "0.2", "--field", "speed", "-o", "flow.png"], "flow.png"),
    (["plot", "RUN", "--probe", "left", "-o", "left.png"], "left.png"),
    (["movie", "RUN", "-o", "flow.gif"], "flow.gif"),
    (["report", "RUN", "-o", "page"], "page/report.html"),
    (["compare", "RUN", ROOT / "cases/exact/small_sloshing.csv", "--probe", "left", "--time", "t_s",
      "--value", "eta_nonlinear_m"], "relative L2 error"),
], ids=lambda value: value[0] if isinstance(value, list) else "")
def test_checking_and_looking_need_no_mpi(stored, laptop, tmp_path, words, says):
    done = parisph(*(str(word).replace("RUN", str(stored)) for word in words), cwd=tmp_path, **laptop)
    assert done.returncode == 0 and says in done.stdout, done.stdout + done.stderr
    assert words[0] != "check" or not list(tmp_path.iterdir())


OFFERED = """
try:
    from parisph import {}
except ImportError as error:
    print(type(error).__name__, error)
"""


@pytest.mark.parametrize(("script", "says"), [
    ("import sys; from parisph import open_run; run = open_run(sys.argv[1]); print(run.snapshot(-1)['p'].size, "
     "run.probe('left')['y'].size > 1, 'mpi4py' in sys.modules)", "241 True False\n"),
    *((OFFERED.format(name), "MissingLibrary mpi4py and petsc4py are not installed: ")
      for name in ("run", "restart", "Simulation")),
])
def test_a_script_reads_a_run_and_is_told_what_is_missing(stored, laptop, script, says):
    done = run([sys.executable, "-c", script, stored], **laptop)
    assert done.stdout.startswith(says), done.stderr


@pytest.mark.parametrize("words", [
    ["run", CASE], ["restart", "RUN"], ["doctor", "--trial"],
], ids=lambda words: words[0])
def test_running_says_what_is_missing(stored, laptop, tmp_path, words):
    done = parisph(*(str(word).replace("RUN", str(stored)) for word in words), cwd=tmp_path, **laptop)
    assert done.returncode == 1 and done.stdout == ""
    assert (done.stderr.startswith("parisph: error: mpi4py and petsc4py are not installed: ")
            and done.stderr.count("\n") == 1)
    assert "run_scripts/setup" in done.stderr and "conda install" in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_doctor_says_what_works(laptop):
    done = parisph("doctor", **laptop)
    assert done.returncode == 0 and "PROBLEM" not in done.stdout, done.stdout + done.stderr
    assert "-       MPI        not installed (mpi4py)\n-       PETSc      not installed (petsc4py)\n" in done.stdout
    assert "plot, movie, report. What does not: run, restart, study.\nTo run cases: run_scripts/" in done.stdout


@pytest.mark.parametrize(("missing", "words", "says"), [
    ("h5py", ["info", "RUN"], "h5py is not installed: to look at runs, pip install 'parisph[look]'"),
    ("shtab", ["completion", "bash"], "shtab is not installed: to complete commands in a shell, pip install shtab"),
    ("matplotlib", ["plot", "RUN"], "matplotlib is not installed: to make pictures, pip install 'parisph[plot]'"),
])
def test_looking_says_what_is_missing(stored, hide, missing, words, says):
    done = parisph(*(word.replace("RUN", str(stored)) for word in words), **hide(missing))
    assert done.returncode == 1 and done.stderr.startswith(f"parisph: error: {says}") and done.stderr.count("\n") == 1


@pytest.mark.parametrize("error", ["ImportError('libmpi.so.40: cannot open shared object file')",
                                   "RuntimeError('libmpi.so.40: cannot open shared object file\\n(and more)')"])
def test_a_library_that_is_there_but_broken(tmp_path, monkeypatch, error):
    (tmp_path / "mpi4py_broken").mkdir()
    (tmp_path / "mpi4py_broken" / "__init__.py").write_text(f"raise {error}")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setitem(libraries._REMEDIES, ("mpi4py_broken.MPI",), "load its module")
    with pytest.raises(MissingLibrary) as found:
        libraries.require("mpi4py_broken.MPI")
    assert (str(found.value)
            == "mpi4py_broken cannot be loaded (libmpi.so.40: cannot open shared object file): load its module")
