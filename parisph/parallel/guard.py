"""No rank waits for ever for one that has failed, or has ended.

What fails in a collective call is agreed on wherever it can be foreseen (base.errors.agree). The rest,
such as sys.exit or a MemoryError in a user's own code on one rank, leaves the other ranks waiting. A
Guard ends all of them then, with the traceback of the rank that failed.
"""

import atexit
import sys
import threading
import time
import traceback
import weakref
from contextlib import contextmanager, nullcontext, suppress

from mpi4py import MPI

from parisph.base.errors import exit_code

PATIENCE = 5.0    # [s] that a rank with an error waits for the others to come to theirs
LOOK, RARELY = 1.0, 4.0    # [s] between two looks of a rank that waits, for ranks that have ended: at first, later
BRIEF = 1.0       # [s] for the message of a rank that ends; MPI_Finalize sends what is left
_ENDED = 72       # the tag of that message


class Guard:
    """Watches the collective calls on one communicator, from all ranks. `Guard.of(comm)` makes or finds it.

    An exception that leaves a call on some ranks only ends all ranks within PATIENCE, as they wait in
    the call for ever otherwise, or in the next one. A rank that ends without an error tells others
    how many calls it has made. Whoever waits for it in a later one ends all ranks; whoever does not is
    left alone, such as a rank that still makes pictures. An uncaught exception also ends all ranks,
    unless they end with it.

    None of this sends a message while all is well. To look for ranks that have ended takes an MPI library
    that several threads may call at once (MPI_THREAD_MULTIPLE, which mpi4py asks for).
    """

    _key = None
    _all = weakref.WeakSet()
    _failed = False    # this process ends by an uncaught exception

    @classmethod
    def of(cls, comm):
        """Return the Guard of a communicator, None if it has one rank only. Collective the first time."""
        if comm.size == 1:
            return None
        if cls._key is None:
            cls._key = MPI.Comm.Create_keyval(delete_fn=lambda comm, key, guard: guard.close())
            cls._watch_the_end()
        guard = comm.Get_attr(cls._key)
        if guard is None:
            guard = cls(comm)
            comm.Set_attr(cls._key, guard)
        return guard

    def __init__(self, comm):
        self.comm = comm.Dup()
        self.calls = 0            # made so far, with the present one
        self.alone = False        # an error of this rank is not on the others
        self._call = None         # name of the present call
        self._left = {}           # calls that ranks had made when they ended
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._look, name="guard", daemon=True)
        if MPI.Query_thread() == MPI.THREAD_MULTIPLE:
            self._thread.start()
        self._all.add(self)

    @contextmanager
    def call(self, name):
        """A collective call: what it raises is on all ranks, or all are ended. Calls inside it are part of it."""
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
                self._abort(f"an error on rank {self.comm.rank} alone, in {name}", exit_code(error))
            raise
        finally:
            self._call = None

    def on_all(self):
        """Return whether an error is on all ranks: whether they come here within PATIENCE. Collective, for those that do."""
        self.alone = self.alone or not all_come(self.comm)
        return not self.alone

    def close(self):
        """Free the communicator. Collective."""
        self._stop_looking()
        self._all.discard(self)
        self.comm.Free()

    def _abort(self, text, code):
        with suppress(OSError):    # nobody reads it any more
            sys.stdout.flush()
            print(f"parisph: {text}: all {self.comm.size} ranks are ended", file=sys.stderr, flush=True)
        self.comm.Abort(code)

    # -- ranks that end ----------------------------------------------------------------------

    def _look(self):
        """Where this rank is in one call for long, see whether one that it needs there has ended. In a thread."""
        before, wait = None, LOOK
        while not self._ended.wait(wait):
            now = self.calls if self._call else None
            if now is None or now != before:
                before, wait = now, LOOK
                continue
            wait = min(2.0 * wait, RARELY)
            self._receive()
            for rank, calls in self._left.items():
                if calls < now:
                    self._abort(f"rank {rank} has ended, and rank {self.comm.rank} waits for it in {self._call}", 1)

    def _stop_looking(self):
        self._ended.set()
        if self._thread.is_alive():
            self._thread.join()

    def _receive(self):
        """Note the messages of ranks that end, as far as they have come."""
        status = MPI.Status()
        while self.comm.Iprobe(tag=_ENDED, status=status):
            self._left[status.source] = self.comm.recv(source=status.source, tag=_ENDED)

    def _leave(self):
        """Tell others that this rank ends. If an exception ends it, all ranks end within PATIENCE."""
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
            self._abort(f"rank {self.comm.rank} ends with an error, and others go on", 1)

    def _partners(self, sign):
        """Return the ranks that hear from this one (1), or that it hears from (-1): few, and where all but one wait, one of them."""
        size = self.comm.size
        return {(self.comm.rank + sign * 2**k) % size for k in range(size.bit_length())} - {self.comm.rank}

    @classmethod
    def _watch_the_end(cls):
        """Have guards called when this process ends: atexit comes before MPI is finalised, and after an exception is shown."""
        def hook(kind, error, trace, before=sys.excepthook):
            before(kind, error, trace)
            cls._failed = True

        def leave():
            if not MPI.Is_finalized():
                for guard in list(cls._all):
                    guard._leave()

        sys.excepthook = hook
        atexit.register(leave)


def all_come(comm):
    """Return whether all ranks of `comm` come here within PATIENCE. Collective, for those that do."""
    request, wait = comm.Ibarrier(), 1e-5
    deadline = time.monotonic() + PATIENCE
    while not request.Test():
        if time.monotonic() > deadline:
            return False
        time.sleep(wait)
        wait = min(2.0 * wait, 0.01)
    return True


def guarded(comm, name):
    """Return the context of a collective call on `comm` (Guard.call). Collective the first time."""
    guard = Guard.of(comm)
    return nullcontext() if guard is None else guard.call(name)
