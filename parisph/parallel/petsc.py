"""PETSc, started without the option files of the current folder.

By itself PETSc reads `.petscrc` and `petscrc` of the folder that a program is started in, and an
option there may load any library (`-dll_append`): a folder from elsewhere would run code even when
its cases are only checked. What the user has set stays: `PETSC_OPTIONS`, and `~/.petscrc`.

The import is collective over all ranks, as the start of PETSc is. A program that has started
PETSc itself keeps what it has.
"""

import ctypes
import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import petsc4py
from mpi4py import MPI

from parisph.parallel.guard import Guard

VARIABLE = "PETSC_OPTIONS"
LARGE = 2**25    # bytes, the largest limit that malloc takes
_M_MMAP_THRESHOLD, _M_MMAP_MAX = -3, -4    # of malloc.h

petsc4py_version = petsc4py.__version__


def _file_of_the_user() -> str | None:
    """Return the path of ~/.petscrc, None where there is none or the home folder is the current one."""
    try:
        home = Path.home()
        file = home / ".petscrc"
        return str(file) if file.is_file() and not home.samefile(Path.cwd()) else None
    except (OSError, RuntimeError):    # no home, or a folder that has been removed
        return None


@contextmanager
def _read_first(file: str | None) -> Iterator[None]:
    """Let PETSc read an option file before the rest of PETSC_OPTIONS, which wins, as it does over ~/.petscrc."""
    before = os.environ.get(VARIABLE)
    if file is not None:
        os.environ[VARIABLE] = f'-options_file "{file}" {before or ""}'
    try:
        yield
    finally:
        if before is not None:
            os.environ[VARIABLE] = before
        else:
            os.environ.pop(VARIABLE, None)


@contextmanager
def _pipes_left_alone() -> Iterator[None]:
    """Take SIGPIPE back from PETSc, which would end the run as soon as the reader of its output leaves."""
    before = signal.getsignal(signal.SIGPIPE)
    yield
    if before is not None:
        with suppress(ValueError):    # not in the main thread
            signal.signal(signal.SIGPIPE, before)


def _give_large_arrays_back() -> None:
    """Let malloc of glibc return arrays above LARGE to the system when they are freed, unless the user has set it.

    Once PETSc is loaded, malloc keeps all that it ever had, in pieces that often fit nothing else: half a million
    particles on a rank then take a fifth more memory between solves. For small arrays this saves time.
    """
    if any(name.startswith(("MALLOC_", "GLIBC_TUNABLES")) for name in os.environ):
        return
    with suppress(AttributeError, OSError):
        mallopt = ctypes.CDLL(None).mallopt
        mallopt(_M_MMAP_MAX, 65536)
        mallopt(_M_MMAP_THRESHOLD, LARGE)


if "petsc4py.PETSc" not in sys.modules:
    # one rank looks: PETSc reads the file on all of them together, or on none
    with _pipes_left_alone(), _read_first(MPI.COMM_WORLD.bcast(_file_of_the_user())):
        petsc4py.init(["-skip_petscrc"])
    _give_large_arrays_back()

Guard.watch(MPI.COMM_WORLD)    # all ranks are here, and one may end before its first call

from petsc4py import PETSc as PETSc  # noqa: E402
