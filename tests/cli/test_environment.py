"""Faults of the environment and of the machine are told as such: no traceback, and no blame on a case file."""

import errno
import os
import resource
import subprocess
import sys
import tempfile

import pytest

from parisph.base import environment, surroundings
from parisph.base.errors import BadEnvironment, CaseError
from parisph.case.load import load
from tests.launch import HANGS, ROOT, clean_environment, parisph
from tests.others import UNKNOWN, as_user, open_folder

CASE = ROOT / "cases" / "hydrostatic.py"


@pytest.mark.parametrize(("variables", "says"), [
    ({"NUMBA_NUM_THREADS": "0"}, "NUMBA_NUM_THREADS = '0', which must be a whole number from 1: unset NUMBA"),
    ({"NUMBA_NUM_THREADS": "x"}, "NUMBA_NUM_THREADS = 'x'"),
    ({"OMP_NUM_THREADS": "-1"}, "OMP_NUM_THREADS = '-1'"),
    ({"OMP_NUM_THREADS": "4, 2"}, None),
    ({"OMPI_COMM_WORLD_RANK": "x"}, None),    # alone it means nothing
    ({"OMPI_COMM_WORLD_RANK": "x", "OMPI_COMM_WORLD_SIZE": "2"}, "unset OMPI_COMM_WORLD_RANK OMPI_COMM_WORLD_SIZE"),
    ({"PMI_RANK": "-1", "PMI_SIZE": "4"}, "PMI_RANK = '-1'"),
    ({"PMI_RANK": "4", "PMI_SIZE": "4"}, "PMI_RANK = '4'"),
    ({"SLURM_PROCID": "", "SLURM_STEP_NUM_TASKS": "2"}, None),
])
def test_variables(variables, says):
    prepared = dict(variables)
    environment.prepare(prepared)
    if says is None:
        surroundings.check(prepared)
        return
    with pytest.raises(BadEnvironment, match=says):
        surroundings.check(prepared)
    assert environment.is_first(prepared) or "RANK" not in says


def test_empty_variables_are_none():
    found = {"NUMBA_NUM_THREADS": "", "HOME": "", "TMPDIR": ""}
    environment.prepare(found)
    assert found["NUMBA_NUM_THREADS"] == "1" and found["HOME"]


def test_mpi_gets_folders_that_it_can_use(monkeypatch, tmp_path):
    """It would end the process if there is no home, or if the folder for temporary files cannot be written."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.setattr(environment.Path, "home", lambda: (_ for _ in ()).throw(RuntimeError("no entry")))
    found = {"TMPDIR": "/nonexistent"}
    environment.prepare(found)
    assert (found["TMPDIR"], found["HOME"]) == (str(tmp_path), str(tmp_path))
    with pytest.raises(OSError, match="no home"):
        environment.cache_folder({})
    assert str(environment.cache_folder({"XDG_CACHE_HOME": "relative", "HOME": "/me"})) == "/me/.cache/parisph"
    monkeypatch.setattr(tempfile, "gettempdir", lambda: (_ for _ in ()).throw(FileNotFoundError("no usable folder")))
    with pytest.raises(BadEnvironment, match="set TMPDIR to a folder that you can write"):
        surroundings.check({})


@pytest.mark.parametrize(("name", "limits", "says"), [
    ("RLIMIT_NOFILE", (16, 16), "only 16 files open .ulimit -n., and a run needs 64"),
    ("RLIMIT_NOFILE", (16, 4096), None),    # it is raised
    ("RLIMIT_AS", (10**8, 10**8), "only 100 MB of memory .ulimit -v."),
])
def test_limits(monkeypatch, name, limits, says):
    free, raised, limited = resource.RLIM_INFINITY, [], getattr(resource, name)
    monkeypatch.setattr(resource, "getrlimit", lambda which: limits if which == limited else (free, free))
    monkeypatch.setattr(resource, "setrlimit", lambda which, new: raised.append(new))
    if says is None:
        surroundings.check({})
        assert raised == [(surroundings.FILES, 4096)]
        return
    with pytest.raises(BadEnvironment, match=says):
        surroundings.check({})


@pytest.mark.parametrize(("error", "says"), [
    (OSError(errno.EMFILE, os.strerror(errno.EMFILE), "file"), "as many open as it may (ulimit -n is 1024)"),
    (ImportError("libx.so: cannot open shared object file: Too many open files"), "no more files can be opened"),
    (OSError(errno.ENOMEM, "Cannot allocate memory"), "no memory left"),
    (RuntimeError("can't start new thread"), "ulimit -u is unlimited"),
    (RuntimeError("Could not determine home directory."), "set HOME"),
    (ValueError("numpy.dtype size changed, may indicate binary incompatibility. Expected 96, got 88"), "this numpy"),
    (ImportError("A module that was compiled using NumPy 1.x cannot be run in NumPy 2.4.6"), "this numpy"),
    (ValueError("a value of a case"), None), (MemoryError(), None), (FileNotFoundError(errno.ENOENT, "x"), None),
])
def test_what_an_exception_says_of_the_environment(monkeypatch, error, says):
    """A limit that is high enough, or none, is not what is wrong with this process alone."""
    monkeypatch.setattr(surroundings, "_limit", {"NOFILE": 1024}.get)
    for raised in (error, CaseError("dam.py, line 1: something")):
        raised.__cause__ = None if raised is error else error
        found = surroundings.explained(raised)
        assert (found is None) == (says is None) and (says or "") in str(found or "")


@pytest.mark.parametrize("beside", [False, True])
@pytest.mark.parametrize(("inside", "kind", "says"), [
    ("raise RuntimeError('of the library')", BadEnvironment, "The installation is at fault, and not this file"),
    ("raise ValueError('numpy.dtype size changed, may indicate')", BadEnvironment, "cannot be loaded with this numpy"),
    ("", CaseError, "line 1: ImportError: cannot import name 'thing'"),
])
def test_a_library_that_fails_is_not_the_fault_of_the_case_that_imports_it(
        tmp_path, monkeypatch, inside, kind, says, beside):
    (tmp_path / "site-packages").mkdir()
    (tmp_path / "site-packages" / "broken_library.py").write_text(inside)
    monkeypatch.syspath_prepend(tmp_path / "site-packages")
    monkeypatch.delitem(sys.modules, "broken_library", raising=False)
    imports = "from broken_library import thing"
    (tmp_path / "dam.py").write_text("import beside_the_dam" if beside else imports)
    (tmp_path / "beside_the_dam.py").write_text(imports)
    monkeypatch.delitem(sys.modules, "beside_the_dam", raising=False)
    with pytest.raises(kind, match=says):
        load(tmp_path / "dam.py")


def test_a_file_beside_the_case_is_the_users(tmp_path):
    (tmp_path / "own_helper_of_dam.py").write_text("raise RuntimeError('mine')")
    (tmp_path / "dam.py").write_text("import own_helper_of_dam")
    with pytest.raises(CaseError, match="line 1: RuntimeError: mine"):
        load(tmp_path / "dam.py")


def test_from_a_shell(tmp_path):
    """Before anything is loaded, and where numba reads a variable: one line."""
    for name, value in (("NUMBA_NUM_THREADS", "0"), ("NUMBA_OPT", "x")):
        done = parisph("check", CASE, cwd=tmp_path, **{name: value})
        assert done.returncode == 1 and done.stdout == "" and done.stderr.count("\n") == 1
        assert done.stderr.startswith(f"parisph: error: the environment has {name} = {value!r}")


def test_a_user_that_the_machine_does_not_know():
    """As in a container that is started with `-u 12345`: no entry, and no HOME."""
    user = as_user(UNKNOWN)
    program = ("from parisph.__main__ import main; code = main(['check', 'case.py']); from mpi4py import MPI\n"
               "print(code)")
    with open_folder() as work:
        work.chmod(0o777)
        (work / "case.py").write_text(f"from parisph import load\ndef case():\n    return load({str(CASE)!r})")
        variables = clean_environment(TMPDIR=str(work))
        variables.pop("HOME", None)
        done = subprocess.run([sys.executable, "-c", program], cwd=work, env=variables, capture_output=True, text=True,
                              timeout=HANGS, **user)
    assert done.stdout.endswith("\n0\n") and done.stderr == "", done.stderr
