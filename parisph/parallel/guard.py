"""A guard against ranks that wait forever for a failed or finished one.

Expected errors in collective calls are raised on all ranks (base.errors.agree). Other errors on one rank, such as
sys.exit or a MemoryError in a user's code, leave others waiting. A Guard then ends all ranks, with the failed one's
traceback.
"""

import atexit
import sys
import threading
import time
import traceback
import weakref
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext, suppress
from types import TracebackType
from typing import Any, cast

import numpy as np
from mpi4py import MPI

from parisph.base.errors import exit_code

PATIENCE = 5.0    # [s] that a rank with an error waits for errors of the others
LOOK, RARELY = 1.0, 4.0    # [s] between two checks of a waiting rank for ended ranks: at first, later
BRIEF = 1.0       # [s] for the message of an ending rank; MPI_Finalize sends the rest
_ENDED = 72       # the tag of that message


class Guard:
    """Watches the collective calls on a communicator, on all ranks. `Guard.of(comm)` makes or finds it.

    If a call raises an exception on only some ranks, all ranks end within PATIENCE: the others would wait forever. A
    rank that ends without an error sends others the number of its calls. A rank that waits for it in a later call ends
    all ranks; a rank that does not wait, for example because it makes pictures, is left alone. An uncaught exception
    also ends all ranks, unless they end too. The first call on the communicator of `watch` finds earlier ends too.

    Without an error no messages are sent. To detect ranks that have ended, the MPI library
    must support calls from several threads (MPI_THREAD_MULTIPLE, which mpi4py requests).
    """

    _key: int | None = None
    _all: "weakref.WeakSet[Guard]" = weakref.WeakSet()
    _failed = False    # this process ends with an uncaught exception
    _watched = False   # the hooks at the end of this process are set
    _world: MPI.Comm | None = None      # communicator of all ranks
    _used = False      # `of` has returned before, for any communicator
    _met = False       # all ranks of `_world` have been in `of`

    @classmethod
    def of(cls, comm: MPI.Comm) -> "Guard | None":
        """Return the Guard of a communicator, None for a single rank. Collective the first time."""
        guard = None if comm.size == 1 else cls._found(comm)
        cls._used = True
        return guard

    @classmethod
    def _found(cls, comm: MPI.Comm) -> "Guard":
        cls.watch()
        if cls._key is None:
            cls._key = MPI.Comm.Create_keyval(delete_fn=lambda comm, key, guard: guard.close())
        guard: Any = comm.Get_attr(cls._key)
        if guard is None:
            if comm == cls._world and not cls._met:
                cls._meet(comm)
            guard = cls(comm)
            comm.Set_attr(cls._key, guard)
        return cast(Guard, guard)

    @classmethod
    def _meet(cls, comm: MPI.Comm) -> None:
        """Wait until all ranks are here; end all ranks if one of them has ended instead. Collective."""
        meeting = _Meeting(comm, ends=False)
        meeting.wait(np.inf)
        if meeting.ended is not None:
            _abort(comm, f"rank {meeting.ended} has ended, and rank {comm.rank} waits for it in its first call", 1)
        cls._met = True

    def __init__(self, comm: MPI.Comm) -> None:
        self.comm = comm.Dup()
        self.calls = 0            # number so far, with the current one
        self.alone = False        # this rank has an error that others do not have
        self._call: str | None = None    # name of the current call
        self._left: dict[int, int] = {}  # {rank: calls} of ended ranks
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._look, name="guard", daemon=True)
        if MPI.Query_thread() == MPI.THREAD_MULTIPLE:
            self._thread.start()
        self._all.add(self)

    @contextmanager
    def call(self, name: str) -> Iterator[None]:
        """Return the context of a collective call, with inner ones: an error is on all ranks, or all ranks end."""
        if self._call is not None or self._ended.is_set():
            yield
            return
        self._call, self.calls = name, self.calls + 1
        try:
            yield
        except BaseException as error:
            if not self.on_all():
                with suppress(OSError):
                    traceback.print_exception(error)
                _abort(self.comm, f"an error on rank {self.comm.rank} alone, in {name}", exit_code(error))
            raise
        finally:
            self._call = None

    def on_all(self) -> bool:
        """Return whether all ranks have an error and arrive here within PATIENCE. Collective on these."""
        self.alone = self.alone or not all_come(self.comm)
        return not self.alone

    def close(self) -> None:
        """Free the communicator. Collective."""
        self._stop_looking()
        self._all.discard(self)
        self.comm.Free()

    # -- ending ranks ------------------------------------------------------------------------

    def _look(self) -> None:
        """During a long call, check whether a rank that this one waits for has ended. Runs in a thread."""
        before: int | None = None
        wait = LOOK
        while not self._ended.wait(wait):
            now = self.calls if self._call else None
            if now is None or now != before:
                before, wait = now, LOOK
                continue
            wait = min(2.0 * wait, RARELY)
            self._receive()
            for rank, calls in self._left.items():
                if calls < now:
                    _abort(self.comm, f"rank {rank} has ended, and rank {self.comm.rank} waits for it in {self._call}",
                           1)

    def _stop_looking(self) -> None:
        self._ended.set()
        if self._thread.is_alive():
            self._thread.join()

    def _receive(self) -> None:
        """Receive the messages of ended ranks."""
        status = MPI.Status()
        while self.comm.Iprobe(tag=_ENDED, status=status):
            self._left[status.source] = self.comm.recv(source=status.source, tag=_ENDED)

    def _leave(self) -> None:
        """Tell others that this rank ends. With an exception, all ranks end within PATIENCE."""
        self._stop_looking()
        sent = [self.comm.isend(self.calls, rank, _ENDED) for rank in self._partners(1)]
        due = len(self._partners(-1)) if self._failed else 0
        deadline = time.monotonic() + (PATIENCE if self._failed else BRIEF)
        while not MPI.Request.Testall(sent) or len(self._left) < due:
            if time.monotonic() > deadline:
                break
            self._receive()
            time.sleep(0.01)
        if len(self._left) < due:
            _abort(self.comm, f"rank {self.comm.rank} ends with an error, while others continue", 1)

    def _partners(self, sign: int) -> set[int]:
        """Return the ranks that get the message of this one (1) or send theirs (-1): few, but at least one."""
        size = self.comm.size
        return {(self.comm.rank + sign * 2**k) % size for k in range(size.bit_length())} - {self.comm.rank}

    @classmethod
    def watch(cls, world: MPI.Comm | None = None) -> None:
        """Call the guards when this process ends: atexit runs after an exception is shown and before MPI_Finalize.

        Not collective. world : communicator of all ranks, or None to keep it
        """
        cls._world = cls._world if world is None else world
        if cls._watched:
            return
        cls._watched = True

        def hook(kind: type[BaseException], error: BaseException, trace: TracebackType | None,
                 before: Callable[..., object] = sys.excepthook) -> None:
            before(kind, error, trace)
            cls._failed = True

        def leave() -> None:
            if MPI.Is_initialized() and not MPI.Is_finalized():
                for guard in list(cls._all):
                    guard._leave()
                if cls._world is not None:
                    cls._leave_world(cls._world)

        sys.excepthook = hook
        atexit.register(leave)

    @classmethod
    def _leave_world(cls, comm: MPI.Comm) -> None:
        """Tell ranks before their first call on `comm` that this rank has ended.

        If it ends with an exception before its own first call, on any communicator, all ranks end within PATIENCE.
        After that call it may work apart from other ranks, which are left alone.
        """
        if comm.size == 1 or cls._met:
            return
        alone = cls._failed and not cls._used
        if not _Meeting(comm, ends=True).wait(PATIENCE if alone else BRIEF) and alone:
            _abort(comm, f"rank {comm.rank} ends with an error, while others continue", 1)


class _Meeting:
    """A collective operation on `comm` in which ranks state whether they end.

    It does not interfere with a user's messages.
    """

    def __init__(self, comm: MPI.Comm, ends: bool) -> None:
        self.size = comm.size
        self._mine, self._least = np.array([comm.rank if ends else comm.size]), np.array([comm.size])
        self._request = comm.Iallreduce(self._mine, self._least, MPI.MIN)

    @property
    def ended(self) -> int | None:
        """The lowest ending rank, or None. Known when all have arrived."""
        return None if self._least[0] == self.size else int(self._least[0])

    def wait(self, patience: float) -> bool:
        """Return whether all ranks arrive within `patience` [s]."""
        deadline, pause = time.monotonic() + patience, 1e-5
        while not self._request.Test():
            if time.monotonic() > deadline:
                return False
            time.sleep(pause)
            pause = min(2.0 * pause, 0.01)
        return True


def all_come(comm: MPI.Comm) -> bool:
    """Return whether all ranks of `comm` arrive here within PATIENCE. Collective on these."""
    return _Meeting(comm, ends=True).wait(PATIENCE)


def _abort(comm: MPI.Comm, text: str, code: int) -> None:
    with suppress(OSError):    # the output may be closed
        sys.stdout.flush()
        print(f"parisph: {text}: stopping all {comm.size} ranks", file=sys.stderr, flush=True)
    comm.Abort(code)


def guarded(comm: MPI.Comm, name: str) -> AbstractContextManager[None]:
    """Return the context of a collective call on `comm` (Guard.call). Collective the first time."""
    guard = Guard.of(comm)
    return nullcontext() if guard is None else guard.call(name)
