"""Run a command, with or without MPI ranks, within a time limit."""

import os
import signal
import subprocess
from collections.abc import Mapping, Sequence

from parisph.base.paths import AnyPath

GRACE = 5.0    # [s] that mpirun gets to end its ranks before it is killed


def run(command: Sequence[str], timeout: float, env: Mapping[str, str],
        cwd: AnyPath | None = None) -> subprocess.CompletedProcess[str]:
    """Run a command to its end; return subprocess.CompletedProcess with text output.

    timeout : [s]; env : variables (environment.for_launching)

    Raises subprocess.TimeoutExpired, with the output so far, after the command and its children have been stopped. A
    collective call that one rank does not reach never returns.
    """
    process = subprocess.Popen(
        command, cwd=cwd, env=env, text=True, errors="replace", stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True)
    try:
        out, err = process.communicate(timeout=timeout)
    except subprocess.TimeoutExpired:
        out, err = _end(process)
        raise subprocess.TimeoutExpired(command, timeout, out, err) from None
    except BaseException:
        _end(process)
        raise
    return subprocess.CompletedProcess(command, process.returncode, out, err)


def _end(process: subprocess.Popen[str]) -> tuple[str, str]:
    """Stop a process and its group: by SIGTERM, which mpirun passes on to its ranks, then by SIGKILL."""
    os.killpg(process.pid, signal.SIGTERM)
    try:
        return process.communicate(timeout=GRACE)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        return process.communicate()
