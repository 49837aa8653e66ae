"""PETSc, started without the option files of the current folder.

By default PETSc reads `.petscrc` and `petscrc` in the current folder, and an option there may load any library
(`-dll_append`): a foreign folder would run code even when its cases are only checked. The user's `PETSC_OPTIONS` and
`~/.petscrc` stay valid. The import is collective over all ranks, like the start of PETSc. A running PETSc does not
change.
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
LARGE = 2**25    # bytes, the largest limit that malloc accepts
_M_MMAP_THRESHOLD, _M_MMAP_MAX = -3, -4    # of malloc.h

petsc4py_version = petsc4py.__version__


def _file_of_the_user() -> str | None:
    """Return the path of ~/.petscrc, or None if it is missing or home is the current folder."""
    try:
        home = Path.home()
        file = home / ".petscrc"
        return str(file) if file.is_file() and not home.samefile(Path.cwd()) else None
    except (OSError, RuntimeError):    # no home, or a removed folder
        return None


@contextmanager
def _read_first(file: str | None) -> Iterator[None]:
    """Let PETSc read an option file before the rest of PETSC_OPTIONS, which overrides it, as it does ~/.petscrc."""
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
    """Restore the handler of SIGPIPE: PETSc's would end the run when the reader of its output ends."""
    before = signal.getsignal(signal.SIGPIPE)
    yield
    if before is not None:
        with suppress(ValueError):    # not in the main thread
            signal.signal(signal.SIGPIPE, before)


def _give_large_arrays_back() -> None:
    """Let glibc's malloc return freed arrays above LARGE to the system, unless the user has configured it.

    Once PETSc is loaded, malloc keeps all freed memory, in pieces that often fit no other array: half a million
    particles on a rank then take a fifth more memory between solves. For small arrays keeping it saves time.
    """
    if any(name.startswith(("MALLOC_", "GLIBC_TUNABLES")) for name in os.environ):
        return
    with suppress(AttributeError, OSError):
        mallopt = ctypes.CDLL(None).mallopt
        mallopt(_M_MMAP_MAX, 65536)
        mallopt(_M_MMAP_THRESHOLD, LARGE)


if "petsc4py.PETSc" not in sys.modules:
    # the answer of one rank: all ranks must read the file, or none
    with _pipes_left_alone(), _read_first(MPI.COMM_WORLD.bcast(_file_of_the_user())):
        petsc4py.init(["-skip_petscrc"])
    _give_large_arrays_back()

Guard.watch(MPI.COMM_WORLD)    # on all ranks: one may end before its first call

from petsc4py import PETSc as PETSc  # noqa: E402
