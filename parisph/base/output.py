"""Output to a reader that may close the pipe early, such as `head`."""

import os
import sys


def show(text):
    """Print a text; if the reader has closed the pipe, print nothing from now on. Not collective."""
    try:
        print(text, flush=True)
    except BrokenPipeError:
        silence(sys.stdout)


def silence(*streams):
    """Discard pending output to closed pipes, so that the exit is silent. Not collective."""
    for stream in streams:
        try:
            stream.flush()
        except OSError:    # the interpreter would try once more, and complain
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, stream.fileno())
            os.close(nowhere)
