"""The process of a run: started, timed, and ended by its process id."""

import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterable, Sequence
from contextlib import suppress
from pathlib import Path

from parisph.base import environment
from parisph.base.errors import MissingLibrary

PATIENCE = 10.0    # [s] for a run to write its summary after it is asked to stop
GRACE = 3.0        # [s] between SIGTERM and SIGKILL
PAUSE = 0.05       # [s] between polls


def command(words: Sequence[str], ranks: int) -> list[str]:
    """Return the command that runs `parisph WORDS` on some ranks. Raises MissingLibrary if there is no mpirun."""
    own = [sys.executable, "-m", "parisph", *words]
    if ranks == 1:
        return own
    launcher = shutil.which("mpirun") or shutil.which("mpiexec")
    if launcher is None:
        raise MissingLibrary("there is no mpirun on PATH, which runs on several ranks need: see parisph doctor")
    return [launcher, "-n", str(ranks), *own]


class Process:
    """A run in the background. It has its own session: Ctrl-C reaches only the study.

    output : file for its output; stopped : whether `ask` or `kill` was used
    """

    def __init__(self, command: Sequence[str], output: Path) -> None:
        self._began, self.stopped = time.monotonic(), False
        self._seconds: float | None = None
        with open(output, "w", encoding="utf-8") as file:
            self._process = subprocess.Popen(    # one thread a rank
                command, env={**environment.for_own(), "OMP_NUM_THREADS": "1"}, stdin=subprocess.DEVNULL, stdout=file,
                stderr=subprocess.STDOUT, start_new_session=True)

    @property
    def code(self) -> int | None:
        """Exit code, None while it runs; negative for the signal that ended it."""
        found = self._process.poll()
        if found is not None and self._seconds is None:
            self._seconds = time.monotonic() - self._began
        return found

    @property
    def seconds(self) -> float:
        """Wall time since its start, or from start to end."""
        return time.monotonic() - self._began if self._seconds is None else self._seconds

    def ask(self) -> None:
        """Ask it to stop after the current step, with checkpoint and summary. mpirun passes the signal on."""
        if self.code is None:
            self.stopped = True
            with suppress(ProcessLookupError):
                os.kill(self._process.pid, signal.SIGUSR1)

    def kill(self, number: int = signal.SIGKILL) -> None:
        """Send a signal to it and its ranks."""
        if self.code is None:
            self.stopped = True
            with suppress(ProcessLookupError):
                os.killpg(self._process.pid, number)


def stop(running: Iterable[Process]) -> None:
    """End processes of this study, and wait for them: first ask, then SIGTERM, then SIGKILL."""
    running = list(running)
    try:
        for process in running:
            process.ask()
        _wait(running, PATIENCE)
        for process in running:
            process.kill(signal.SIGTERM)
        _wait(running, GRACE)
    finally:    # also after a second Ctrl-C
        for process in running:
            process.kill()
        _wait(running, GRACE)


def _wait(running: Sequence[Process], seconds: float) -> None:
    until = time.monotonic() + seconds
    while any(process.code is None for process in running) and time.monotonic() < until:
        time.sleep(PAUSE)
