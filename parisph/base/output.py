"""Output to a reader that may close the pipe early, such as `head`, to a full disk, or to nowhere."""

import errno
import os
import sys
from typing import TextIO, TypeGuard

# Errors of a write to a file, a terminal or a socket. A pipe without a reader gives BrokenPipeError.
_UNWRITABLE = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO, errno.EBADF)


def open_closed() -> None:
    """Send output to nowhere if the shell has closed the stream, as in `parisph run CASE >&-`. Not collective."""
    for number, name in ((1, "stdout"), (2, "stderr")):
        if getattr(sys, name) is None:
            nowhere = os.open(os.devnull, os.O_WRONLY)    # usually gets `number`, so that no other file does
            setattr(sys, name, open(nowhere, "w"))


def is_unwritable(error: BaseException | None) -> TypeGuard[OSError]:
    """Return whether an exception says that standard output cannot be written. Files of a run have their own errors."""
    return isinstance(error, OSError) and error.filename is None and error.errno in _UNWRITABLE


def show(text: object) -> None:
    """Print a text; if the reader has closed the pipe, print nothing from now on. Not collective."""
    try:
        print(text, flush=True)
    except BrokenPipeError:
        silence(sys.stdout)


def silence(*streams: TextIO) -> None:
    """Discard pending output to closed pipes, so that the exit is silent. Not collective."""
    for stream in streams:
        try:
            stream.flush()
        except OSError:    # the interpreter would try once more, and complain
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, stream.fileno())
            os.close(nowhere)
