"""`parisph` and `python -m parisph`: run a command line, and see that every rank ends."""

import sys
import time
import traceback
from contextlib import suppress

from parisph.base import environment, output
from parisph.base.errors import CaseError, Interrupted, ParisphError, ParticleLost, SolverDiverged, StoreError
from parisph.base.text import clipped, of_error, plain_lines

# The first class that fits gives the exit code.
CODES = ((CaseError, 2), (SolverDiverged, 3), (ParticleLost, 3), (Interrupted, 4), (KeyboardInterrupt, 4), (StoreError, 5))
OTHER = 1
WIDEST = 380       # characters of a line of a message
PATIENCE = 5.0    # [s] that a rank with an error waits for the others to come to theirs


def main(words=None):
    """Carry out a command line (default: that of this process) and return the exit code."""
    environment.prepare()
    from parisph import cli

    words = sys.argv[1:] if words is None else words
    try:
        code = cli.execute(words)
        sys.stdout.flush()
        return code
    except (Exception, KeyboardInterrupt) as error:
        if isinstance(error, BrokenPipeError) and environment.launched()[1] == 1:
            return 0
        return _fail(error, words)
    finally:
        output.silence(sys.stdout, sys.stderr)


def _fail(error, words):
    """Say what went wrong, leave together with the other ranks, return the exit code.

    An error that parisph raises on purpose is on all ranks, and the first one says it. Any other
    is a fault, perhaps of this rank alone, while the others wait for it in a collective: this
    rank says it, with the traceback, and ends them all.
    """
    meant = isinstance(error, (ParisphError, KeyboardInterrupt))
    first = environment.launched()[0] == 0
    if first or not meant:
        _say(error, trace=not meant or "--debug" in words)
    code = next((code for kind, code in CODES if isinstance(error, kind)), OTHER)
    comm = _running_world()
    if comm is not None and not _all_come(comm):
        if meant and not first:
            _say(error, trace=True)
        comm.Abort(code)
    return code


def _say(error, trace):
    """Say what went wrong, to whoever still reads it."""
    with suppress(BrokenPipeError):
        _print(error, trace)


def _print(error, trace):
    if trace:
        traceback.print_exception(error)
    if isinstance(error, (ParisphError, KeyboardInterrupt)):
        text = str(error) or "interrupted"
    else:
        text = f"{type(error).__name__}: {of_error(error)} (a fault in parisph or in a library)"
    # Names of files and texts of stored runs may hold anything, at any length; the terminal gets little of it.
    text = "\n".join(clipped(line, WIDEST) for line in plain_lines(text).split("\n"))
    print(f"parisph: error: {text}", file=sys.stderr, flush=True)


def _running_world():
    """Return the communicator of all ranks if there are several and MPI is up, else None."""
    if "mpi4py.MPI" not in sys.modules:
        return None
    from mpi4py import MPI

    up = MPI.Is_initialized() and not MPI.Is_finalized()
    return MPI.COMM_WORLD if up and MPI.COMM_WORLD.size > 1 else None


def _all_come(comm):
    """Return whether all ranks arrive here within a few seconds."""
    request = comm.Ibarrier()
    deadline = time.monotonic() + PATIENCE
    while not request.Test():
        if time.monotonic() > deadline:
            return False
        time.sleep(0.01)
    return True


if __name__ == "__main__":
    sys.exit(main())
