"""Start ranks from a test, as a user does from a shell."""

import os
import shutil
import sys
from pathlib import Path

from parisph.base import environment, launch

ROOT = Path(__file__).resolve().parent.parent
HANGS = 200.0    # [s]: to compile all kernels takes a minute of an idle machine


def clean_environment(**settings):
    """Return an environment free of any outer mpirun, in which `parisph` can be imported."""
    variables = environment.for_launching()
    variables["PYTHONPATH"] = os.pathsep.join(filter(None, [str(ROOT), variables.get("PYTHONPATH")]))
    variables.update(settings)
    return variables


def run(command, timeout=HANGS, cwd=None, **settings):
    """Run a command to its end; return CompletedProcess with text output.

    settings : environment variables to set besides
    Raises subprocess.TimeoutExpired, after the command and all its children are ended.
    """
    return launch.run([str(word) for word in command], timeout, clean_environment(**settings), cwd)


def mpirun(n, args, timeout=HANGS, cwd=None, **settings):
    """Run `python ARGS` on n ranks of this machine; return CompletedProcess (see `run`).

    args : list, for example ["-m", "parisph", "run", "cases/dam_break.py"]
    """
    launcher = shutil.which("mpirun") or shutil.which("mpiexec")
    if launcher is None:
        raise FileNotFoundError("no mpirun on PATH: see run_scripts/setup")
    return run([launcher, "-n", n, sys.executable, *args], timeout, cwd, **settings)


def parisph(*args, ranks=1, timeout=HANGS, cwd=None, **settings):
    """Run `parisph ARGS`, without mpirun on one rank; return CompletedProcess (see `run`)."""
    if ranks > 1:
        return mpirun(ranks, ["-m", "parisph", *args], timeout, cwd, **settings)
    return run([sys.executable, "-m", "parisph", *args], timeout, cwd, **settings)


def contents(folder, but=""):
    """Return {path: bytes} of all files of a folder, but those of one name."""
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file() and path.name != but}


def succeeded(done):
    """Return a CompletedProcess; raise AssertionError with what it has said if it failed."""
    assert done.returncode == 0, done.stderr
    return done
