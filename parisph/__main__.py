"""`parisph` and `python -m parisph`: execute a command line, and make sure that every rank ends."""

import atexit
import gc
import os
import sys
import time
import traceback
from collections.abc import Sequence
from contextlib import ExitStack, suppress
from typing import TYPE_CHECKING

from parisph.base import environment, output, surroundings
from parisph.base.errors import BadEnvironment, ParisphError, StoreError, exit_code, unforeseen
from parisph.base.signals import Signals
from parisph.base.text import clipped, of_error, plain_lines

if TYPE_CHECKING:
    from mpi4py import MPI

STOPPABLE = ("run", "restart")    # verbs that a signal stops properly
LATER = 0.3        # [s] in which the launcher ends a rank if rank 0 has reported the same fault
WIDEST = 380       # most characters of a line of a message


def main(words: Sequence[str] | None = None) -> int:
    """Execute a command line (default: that of this process) and return the exit code."""
    environment.prepare()
    output.open_closed()
    own, words = words is None, sys.argv[1:] if words is None else words
    if own:
        atexit.register(gc.freeze)    # saves .3 s: no garbage collection at exit
    with ExitStack() as stack:
        try:
            surroundings.check()
            if words and words[0] in STOPPABLE:
                signals = stack.enter_context(_signals())
                if own:
                    stack.pop_all()    # handlers stay until the interpreter ends,
                    atexit.register(signals.ignore)    # as a signal would then change the exit code
                    # Nearly all objects of a start stay: no garbage collection until the end of the first step, which
                    # enables it if objects are frozen.
                    gc.freeze()
                    gc.disable()
            from parisph import cli

            code = cli.execute(words)
            sys.stdout.flush()
            return code
        except BaseException as error:
            if isinstance(error, SystemExit) and _running_world() is None:
                raise
            if isinstance(error, BrokenPipeError) and environment.launched()[1] == 1:
                return 0
            if not isinstance(error, ParisphError) or unforeseen(error):
                error = surroundings.explained(error) or error
            if output.is_unwritable(error):
                error = StoreError(f"cannot write the output: {error.strerror}; "
                                   "send it elsewhere (files of a run are not affected)")
            return _fail(error, words)
        finally:
            output.silence(sys.stdout, sys.stderr)


def _signals() -> Signals:
    """Return the Signals of this process before MPI is initialised."""
    signals = Signals()
    signals.rank, size = environment.launched()
    if size > 1:
        signals.abort = os._exit    # the launcher ends the other ranks
    return signals


def _fail(error: BaseException, words: Sequence[str]) -> int:
    """Print an error, wait for the other ranks, return the exit code.

    Errors of parisph are on all ranks, and rank 0 prints them. Any other error is a fault, possibly on this rank only,
    while the others wait in a collective call: this rank prints it with the traceback and ends all ranks.
    """
    meant = isinstance(error, (ParisphError, KeyboardInterrupt)) and not unforeseen(error)
    first, comm = environment.is_first(), _running_world()
    if first or not meant:
        _say(error, trace=not meant or "--debug" in words)
    elif isinstance(error, BadEnvironment) and comm is None:
        time.sleep(LATER)
        _say(error, trace=False)
    if comm is not None:
        from parisph.parallel.guard import all_come

        if not all_come(comm):
            if meant and not first:
                _say(error, trace=True)
            comm.Abort(exit_code(error))
    return exit_code(error)


def _say(error: BaseException, trace: bool) -> None:
    """Print an error, if standard error can be written."""
    meant = isinstance(error, (ParisphError, KeyboardInterrupt))
    text = str(error) or "interrupted" if meant else (
        f"{type(error).__name__}: {of_error(error)} (a fault in parisph or in a library)")
    # names of files and texts of stored runs may be of any length
    text = "\n".join(clipped(line, WIDEST) for line in plain_lines(text).split("\n"))
    with suppress(OSError):
        if trace:
            traceback.print_exception(error)
        print(f"parisph: error: {text}", file=sys.stderr, flush=True)


def _running_world() -> "MPI.Comm | None":
    """Return the communicator of all ranks if there are several and MPI is initialised, else None."""
    if "mpi4py.MPI" not in sys.modules:
        return None
    from mpi4py import MPI

    up = MPI.Is_initialized() and not MPI.Is_finalized()
    return MPI.COMM_WORLD if up and MPI.COMM_WORLD.size > 1 else None


if __name__ == "__main__":
    sys.exit(main())
