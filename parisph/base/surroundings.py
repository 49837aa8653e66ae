"""Faults of the machine or of the environment of this process, with a remedy for each.

`check` finds those that can be known before any work. `explained` recognises the others in an exception, so that no
case file and no code of parisph is blamed for them.
"""

import errno
import os
import re
import sys
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path

from parisph.base import environment
from parisph.base.errors import BadEnvironment
from parisph.base.memory import amount
from parisph.base.text import of_error, shown

FILES = 64             # open files that a run needs on one rank: it has 22
MEMORY = 640 * 10**6   # bytes of address space that Python and the libraries take before a run has particles
_COUNT = re.compile(r"0*[1-9]\d*(,0*[1-9]\d*)*")    # OMP_NUM_THREADS may have a number for each level
_UNREAD = re.compile(r"Environment variable '(\w+)' is defined but its associated value '(.*)' could not", re.DOTALL)
# Messages of libraries that were compiled for another numpy.
_ANOTHER_NUMPY = ("numpy.dtype size changed", "numpy.ufunc size changed", "compiled using NumPy",
                  "_ARRAY_API not found", "numpy.core.multiarray failed to import",
                  "numpy._core.multiarray failed to import", "module compiled against A")
_NO_MEMORY = ("failed to map segment", "annot allocate memory", "libllvmlite.so")
_NO_FILES = "Too many open files"


def check(environ: Mapping[str, str] = os.environ) -> None:
    """Check the variables that parisph reads, and the limits of this process. Not collective.

    Raises BadEnvironment, which names the variable or limit, its value and what to do.
    """
    environment.launched(environ)
    for name in environment.THREADS:
        if not _COUNT.fullmatch(environ.get(name, "1").replace(" ", "")):
            raise BadEnvironment(f"the environment has {name} = {shown(environ[name])}, which must be a whole number "
                                 f"from 1: unset {name}, and parisph takes 1 thread on each rank")
    _check_limits()
    try:
        tempfile.gettempdir()
    except OSError:
        raise BadEnvironment("no folder for temporary files can be written: set TMPDIR to a folder that you can write "
                             f"(now TMPDIR = {shown(environ.get('TMPDIR', ''))}), or free some space in /tmp") from None


def _check_limits() -> None:
    try:
        import resource
    except ImportError:    # not on this system
        return
    files, most = resource.getrlimit(resource.RLIMIT_NOFILE)
    if _less(files, FILES):
        if _less(most, FILES):
            raise _files()
        resource.setrlimit(resource.RLIMIT_NOFILE, (FILES, most))
    if _less(resource.getrlimit(resource.RLIMIT_AS)[0], MEMORY):
        raise _memory()


def _less(limit: int, needed: int) -> bool:
    return 0 <= limit < needed    # without a limit it is negative


def _limit(name: str) -> int | None:
    """Return the limit RLIMIT_name of this process, None if there is none."""
    try:
        import resource
    except ImportError:
        return None
    found = resource.getrlimit(getattr(resource, f"RLIMIT_{name}"))[0]
    return None if found == resource.RLIM_INFINITY else found


def _files() -> BadEnvironment:
    limit = _limit("NOFILE")
    if limit is None or limit >= FILES:
        return BadEnvironment("no more files can be opened: this process, or the whole machine, has as many open as it "
                              f"may (ulimit -n is {_words(limit)}). End other programs, or raise the limit")
    return BadEnvironment(f"this process may have only {limit} files open (ulimit -n), and a run needs "
                          f"{FILES}: ulimit -n 1024, in a new shell if this one refuses it")


def _words(limit: int | None) -> str:
    return "unlimited" if limit is None else str(limit)


def _memory() -> BadEnvironment:
    limit = _limit("AS")
    if limit is None:
        return BadEnvironment("the machine has no memory left: end other programs, or use more ranks on more machines "
                              "or fewer particles")
    return BadEnvironment(f"this process may use only {amount(limit)} of memory (ulimit -v). The libraries alone need "
                          f"{amount(MEMORY)}, and particles come on top: ulimit -v unlimited, in a new shell if this "
                          "one refuses it")


def explained(error: BaseException) -> BadEnvironment | None:
    """Return the fault of the environment that has caused an exception, with a remedy; None if there is none.

    error : raised by a library, parisph or a file of the user
    """
    for cause in _causes(error):
        if isinstance(cause, BadEnvironment):
            return cause
        text = of_error(cause)
        number = cause.errno if isinstance(cause, OSError) else None
        if number in (errno.EMFILE, errno.ENFILE) or (isinstance(cause, ImportError) and _NO_FILES in text):
            return _files()
        unloaded = isinstance(cause, (ImportError, OSError)) and any(word in text for word in _NO_MEMORY)
        if number == errno.ENOMEM or ((unloaded or isinstance(cause, MemoryError)) and _limit("AS") is not None):
            return _memory()
        if isinstance(cause, RuntimeError) and "can't start new thread" in text:
            return BadEnvironment(
                "no thread can be started: your programs, or those of this machine or container, have as many as they "
                f"may (ulimit -u is {_words(_limit('NPROC'))}). End other programs, or raise the limit")
        if isinstance(cause, RuntimeError) and "determine home directory" in text:
            return BadEnvironment("your user has no home folder here: set HOME to a folder that you can write")
        if isinstance(cause, ValueError) and "is not a valid value for backend" in text and "MPLBACKEND" in os.environ:
            return BadEnvironment(f"the environment has MPLBACKEND = {shown(os.environ['MPLBACKEND'])}, which is no "
                                  "backend of this matplotlib: unset MPLBACKEND, or set it to agg")
        if is_another_numpy(text):
            return BadEnvironment(another_numpy(text))
    return None


def _causes(error: BaseException) -> Iterator[BaseException]:
    """Yield the causes of an exception, the first one first, and the exception."""
    found: list[BaseException] = []
    cause: BaseException | None = error
    while cause is not None and len(found) < 20:
        found.insert(0, cause)
        cause = cause.__cause__ or (None if cause.__suppress_context__ else cause.__context__)
    yield from found


def unread_number(message: str) -> BadEnvironment | None:
    """Return the error for a warning of numba about a variable that it cannot read; None for another warning."""
    found = _UNREAD.search(message)
    if found is None:
        return None
    return BadEnvironment(f"the environment has {found[1]} = {shown(found[2])}, which numba cannot read: "
                          f"unset {found[1]}, or give it a value of numba's documentation")


# ---- numpy

def is_another_numpy(message: str) -> bool:
    """Return whether a message says that a library was compiled for another numpy."""
    return any(word in message for word in _ANOTHER_NUMPY)


def another_numpy(message: str) -> str:
    """Return what is wrong with the numpy of this Python, and the remedy. message : that of the library"""
    version = getattr(sys.modules.get("numpy"), "__version__", "unknown")
    return (f"a library cannot be loaded with this numpy ({version}), as it was compiled for another one"
            f"{numpy_due(' ({})')}: {numpy_remedy()} (the library says: {' '.join(message.split())[:80]}...)")


def numpy_remedy() -> str:
    """Return the command that installs the right numpy."""
    clone = Path(__file__).resolve().parents[2]
    if Path(sys.prefix).resolve() == clone / ".venv" and (clone / "run_scripts" / "setup").exists():
        return "run_scripts/setup puts the right numpy back"
    due = numpy_due("=={}") or "<2"
    return f"pip install 'numpy{due}'"


def numpy_due(form: str) -> str:
    """Return the version of numpy that the libraries were compiled for, "" if unknown.

    run_scripts/setup has noted it. form : format of the text, with {} for the version
    """
    try:
        lines = (Path(sys.prefix) / "constraints.txt").read_text(encoding="utf-8").splitlines()
    except (OSError, ValueError):
        return ""
    return next((form.format(line[len("numpy=="):]) for line in lines if line.startswith("numpy==")), "")
