"""Output whose reader may leave, as `head` does when it has enough."""

import os
import sys


def show(text):
    """Print a text, or nothing from now on if the reader of the output has left. Not collective."""
    try:
        print(text, flush=True)
    except BrokenPipeError:
        silence(sys.stdout)


def silence(*streams):
    """Discard what is still to be written to streams whose reader has left, so that the exit is silent. Not collective."""
    for stream in streams:
        try:
            stream.flush()
        except OSError:    # the interpreter would try once more, and complain
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, stream.fileno())
            os.close(nowhere)
