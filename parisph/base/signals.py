"""Signals that ask a run to stop. They never interrupt a collective call.

Python runs a signal handler only while its main thread executes Python code. A rank that waits for another one does
not. A thread therefore reads the signal numbers from a socket, to which the interpreter writes them immediately
(signal.set_wakeup_fd).
"""

import faulthandler
import os
import select
import signal
import socket
import sys
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from types import FrameType
from typing import ClassVar

from parisph.base.communicator import Communicator

NUMBERS = (signal.SIGINT, signal.SIGTERM, signal.SIGUSR1)
CODE = 4          # exit code of a run that was stopped
COPY = 0.25       # [s] after a signal; another one within it may be a copy
PATIENCE = 4.0    # [s] for a run to stop properly then
_HINT = 0.3       # [s] that other ranks wait, so that rank 0 prints first


class Signals:
    """The first Ctrl-C, SIGTERM or SIGUSR1 sets a flag; a second signal ends all ranks at once.

    A second signal within COPY of the first may be a copy: a batch system signals mpirun and its ranks,
    and mpirun then signals its ranks too. The run then gets PATIENCE to stop properly.

    SIGUSR1 is supported because mpirun only forwards it. After SIGINT or SIGTERM, mpirun kills its ranks within about a
    second. That also ends a rank that waits inside PETSc or HDF5 for one that hangs: they hold Python's lock, so that
    the thread cannot run.

    seen : number of the first signal to this process, else None
    left : text about the files on disk and how to resume; rank 0 prints it at the end
    rank : rank of this process
    abort : function (exit code) that ends all ranks; None in a single process, where a second signal raises
        KeyboardInterrupt in the main thread
    socket : from which the thread reads signals; None if none are watched
    """

    # The handlers belong to the process, so only one instance can be active.
    _active: ClassVar["Signals | None"] = None

    def __init__(self) -> None:
        self.seen: int | None = None
        self.left = "nothing has been written"
        self.rank = 0
        self.abort: Callable[[int], object] | None = None
        self.socket: socket.socket | None = None
        self._depth, self._raise, self._own = 0, False, False

    @classmethod
    def active(cls) -> "Signals":
        """Return the active Signals, else new ones; use them in a `with` statement."""
        return cls._active or cls()

    def over(self, comm: Communicator) -> None:
        """Let a second signal end all ranks of `comm`, if there are several. Not collective."""
        if comm.size > 1:
            self.rank, self.abort = comm.rank, comm.Abort

    def __enter__(self) -> "Signals":
        self._depth += 1
        if self._depth > 1 or threading.current_thread() is not threading.main_thread():
            return self    # only the main thread can set handlers
        self.socket, self._source = socket.socketpair()
        self._source.setblocking(False)
        self._main = threading.get_ident()
        self._wakeup = signal.set_wakeup_fd(self._source.fileno(), warn_on_full_buffer=False)
        self._old = {number: signal.signal(number, self._handle) for number in NUMBERS}
        self._thread = threading.Thread(target=self._listen, args=(self.socket,), name="signals", daemon=True)
        self._thread.start()
        Signals._active = self
        return self

    def __exit__(self, *_: object) -> None:
        self._depth -= 1
        if self._depth or self.socket is None:
            return
        Signals._active = None
        for number, handler in self._old.items():
            signal.signal(number, signal.SIG_DFL if handler is None else handler)
        signal.set_wakeup_fd(self._wakeup)
        self.socket.shutdown(socket.SHUT_RDWR)
        self._thread.join()
        self.socket.close()
        self._source.close()
        self.socket = None

    def ignore(self) -> None:
        """Ignore signals from now on, because the process is about to end."""
        for number in NUMBERS:
            signal.signal(number, signal.SIG_IGN)

    def _handle(self, number: int, frame: FrameType | None) -> None:
        if self._raise:
            self._raise = False
            raise KeyboardInterrupt
        self.seen = self.seen or number

    def _listen(self, source: socket.socket) -> None:
        """Read signals until the socket is closed, and end all ranks when necessary."""
        first: float | None = None
        deadline: float | None = None
        while True:
            left = None if deadline is None else max(deadline - time.monotonic(), 0.0)
            if not select.select([source], [], [], left)[0]:
                self._end()
                deadline = None
                continue
            numbers = source.recv(64)
            if not numbers:
                return
            for number in numbers:
                if number not in NUMBERS or self._is_own():
                    continue
                now = time.monotonic()
                if first is None:
                    first, self.seen = now, self.seen or number
                else:
                    deadline = min(deadline or now + PATIENCE, now + (PATIENCE if now - first < COPY else 0.0))

    def _is_own(self) -> bool:
        """Return whether a signal is the one that this thread sent to the main thread."""
        own, self._own = self._own, False
        return own

    def _end(self) -> None:
        if self.abort is None:
            self._raise = self._own = True
            signal.pthread_kill(self._main, signal.SIGINT)
            return
        # Ends this process if the rest hangs.
        faulthandler.dump_traceback_later(PATIENCE, exit=True, file=open(os.devnull, "w"))
        if self.rank:
            time.sleep(_HINT)
        with suppress(OSError):    # standard error is closed
            print(f"parisph: stopped at once by a second signal; {self.left}", file=sys.stderr, flush=True)
        self.abort(CODE)
