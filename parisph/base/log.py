"""Log messages of a run, and timers for its phases."""

import logging
import os
import sys
from contextlib import suppress
from time import perf_counter, process_time
from typing import TextIO

import numpy as np

from parisph.base.communicator import Communicator
from parisph.base.paths import AnyPath
from parisph.base.text import plain_lines

logger = logging.getLogger("parisph")


def start(comm: Communicator, path: AnyPath | None = None, level: int = logging.INFO,
          stream: TextIO | None = None) -> None:
    """Start logging on rank 0, to the screen and to a file; other ranks log nothing. Not collective.

    path : of a log file to append to, or None
    level : lowest level that is shown (the file takes everything)
    stream : for the screen, standard error by default

    Raises OSError on rank 0: the log file cannot be written.
    """
    stop()
    logger.propagate = False
    if comm.rank != 0:
        logger.addHandler(logging.NullHandler())
        return
    logger.setLevel(logging.DEBUG if path else level)
    if path:
        _add(_LogFile(path), logging.DEBUG, "%(asctime)s %(levelname)s %(message)s")
    _add(logging.StreamHandler(stream or sys.stderr), level, "%(message)s")


class _LogFile(logging.StreamHandler[TextIO]):
    """Appends to a file, but not through a symbolic link. If the disk refuses a line, only that line is lost.

    Raises OSError where the file cannot be opened.
    """

    def __init__(self, path: AnyPath) -> None:
        handle = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND | os.O_NOFOLLOW, 0o666)
        super().__init__(open(handle, "a", encoding="utf-8", errors="replace"))

    def handleError(self, record: logging.LogRecord) -> None:
        """Leave the line out. A full disk raises an error where results are written."""

    def close(self) -> None:
        with suppress(OSError):    # a last attempt to write the rest
            self.stream.close()
        super().close()


def stop() -> None:
    """Close the handlers of `start` and restore the logger's defaults."""
    for handler in list(logger.handlers):
        logger.removeHandler(handler)
        handler.close()
    logger.setLevel(logging.NOTSET)
    logger.propagate = True


def _add(handler: logging.Handler, level: int, form: str) -> None:
    handler.setLevel(level)
    handler.setFormatter(_Plain(form))
    logger.addHandler(handler)


class _Plain(logging.Formatter):
    """Indents further lines of a record and escapes control characters: one record never looks like two."""

    def format(self, record: logging.LogRecord) -> str:
        return plain_lines(super().format(record), indent="    ")


class Timers:
    """Wall and CPU time of named phases: `with timers("solve"): ...`.

    Phases may be nested: each counts all the time inside it. A phase inside itself counts once. A rank that waits uses
    wall time, and with some MPI libraries CPU time.

    seconds, cpu : dict of phase -> wall or CPU seconds so far on this rank, in the order of first use
    """

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self.cpu: dict[str, float] = {}
        self._open: set[str] = set()

    def __call__(self, phase: str) -> "_Phase":
        return _Phase(self, phase)

    def begin(self, phase: str) -> tuple[float, float] | None:
        """Return wall and CPU time [s] at the start of a phase, None inside itself."""
        if phase in self._open:
            return None
        self._open.add(phase)
        self.seconds.setdefault(phase, 0.0)
        self.cpu.setdefault(phase, 0.0)
        return perf_counter(), process_time()

    def end(self, phase: str, start: tuple[float, float] | None) -> None:
        """Count a phase that began at `start`; nothing if that is None."""
        if start is not None:
            self.seconds[phase] += perf_counter() - start[0]
            self.cpu[phase] += process_time() - start[1]
            self._open.discard(phase)

    def reduce(self, comm: Communicator) -> dict[str, dict[str, float]]:
        """Return {phase: {"max": s, "mean": s, "cpu": s}} over the ranks, the same on all. Collective.

        max, mean : of wall time, in which a phase that a rank never entered counts as 0 s; cpu : of all ranks together
        """
        known = dict.fromkeys(name for names in comm.allgather(list(self.seconds)) for name in names)
        everyone = comm.allgather([(self.seconds.get(name, 0.0), self.cpu.get(name, 0.0)) for name in known])
        return {name: {"max": float(wall.max()), "mean": float(wall.mean()), "cpu": float(cpu.sum())}
                for name, ranks in zip(known, zip(*everyone), strict=True) for wall, cpu in [np.transpose(ranks)]}


class _Phase:
    """Context of a phase. A class: a generator would take longer than some phases."""

    __slots__ = ("phase", "start", "timers")

    def __init__(self, timers: Timers, phase: str) -> None:
        self.timers, self.phase = timers, phase
        self.start: tuple[float, float] | None = None

    def __enter__(self) -> None:
        self.start = self.timers.begin(self.phase)

    def __exit__(self, *error: object) -> None:
        self.timers.end(self.phase, self.start)
