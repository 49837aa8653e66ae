"""Run Python files of the user, such as case and study files. Errors in them give file and line."""

import sys
import sysconfig
import traceback
import types
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TypeVar

from parisph.base import paths, reading, surroundings
from parisph.base.errors import BadEnvironment, CaseError
from parisph.base.paths import AnyPath
from parisph.base.text import class_name, clipped, named, of_error, plain
from parisph.case.faults import first_lines

Result = TypeVar("Result")

_PACKAGE = Path(__file__).resolve().parent.parent
LONGEST = 400    # characters of a line of a message


@contextmanager
def beside(file: Path) -> Iterator[None]:
    """Read files that a case names, such as the measured motion of a Series, from the folder of the case file."""
    token = paths.FOLDER.set(file.parent)
    try:
        yield
    finally:
        paths.FOLDER.reset(token)


def read(file: Path, path: AnyPath, most: float = reading.MOST) -> str:
    """Return the text of a file of at most `most` bytes; path : as the user named it. Raises CaseError."""
    try:
        return reading.read_text(file, most)
    except OSError as error:
        raise CaseError(f"{named(path)}: cannot be read: {error.strerror}") from None


def module_of(file: Path, path: AnyPath, name: str) -> types.ModuleType:
    """Run a Python file of the user and return its module, called `name`. Raises CaseError.

    The text is compiled, not imported: ranks could race for a __pycache__ beside the file.
    """
    text = read(file, path)
    module = types.ModuleType(name)
    module.__file__ = str(file)
    sys.path.insert(0, str(file.parent))
    try:
        with beside(file):
            users_code(lambda: exec(compile(text, str(file), "exec"), module.__dict__), file, path)  # noqa: S102
    finally:
        with suppress(ValueError):    # the file may have removed it
            sys.path.remove(str(file.parent))
    return module


def users_code(action: Callable[[], Result], file: Path, path: AnyPath) -> Result:
    """Return action(), which runs code of a file of the user.

    Raises CaseError with the place of any exception except Ctrl-C, or BadEnvironment if machine or libraries are at
    fault.
    """
    try:
        return action()
    except KeyboardInterrupt:
        raise
    except BaseException as error:
        fault = surroundings.explained(error) or _of_a_library(error, file, path)
        if fault is not None:
            raise fault from error
        raise CaseError(f"{_where(error, file, path)}: {what(error)}") from error


def _where(error: BaseException, file: Path, path: AnyPath) -> str:
    """Return 'path, line n' of the last line of the file that the error passed through."""
    if isinstance(error, SyntaxError) and error.filename == str(file):
        return f"{named(path)}, line {error.lineno}"
    lines = [frame.lineno for frame in traceback.extract_tb(error.__traceback__) if frame.filename == str(file)]
    return f"{named(path)}, line {lines[-1]}" if lines else named(path)


def _of_a_library(error: BaseException, file: Path, path: AnyPath) -> BadEnvironment | None:
    """Return the error for a failed import of an installed library, or None for any other error."""
    frames = traceback.extract_tb(error.__traceback__)
    # the user's file, and other files that it imports
    own = [place for place, frame in enumerate(frames) if frame.filename == str(file) or not _installed(frame.filename)]
    beyond = frames[own[-1] + 1:] if own else []
    inside = [frame for frame in beyond if not frame.filename.startswith("<")]
    importing = any(frame.name == "<module>" or frame.filename.startswith("<frozen importlib") for frame in beyond)
    if not importing or not inside:
        return None
    where = f"{named(inside[-1].filename)}, line {inside[-1].lineno}"
    return BadEnvironment(f"{named(path)} imports what cannot be loaded here: {what(error)} ({where}). The "
                          "installation is at fault, and not this file: parisph doctor says what is wrong")


def _installed(file: str) -> bool:
    """Return whether a file is one of parisph, of another installed library, or of Python."""
    path = Path(file)
    return (file.startswith("<") or bool({"site-packages", "dist-packages"} & set(path.parts))
            or path.is_relative_to(_PACKAGE) or path.is_relative_to(sysconfig.get_path("stdlib")))


def what(error: BaseException) -> str:
    """Return the text of an error for the end of a message; of a CaseError the first lines."""
    if isinstance(error, CaseError):
        lines = [clipped(plain(line), LONGEST) for line in str(error).split("\n")]
        return lines[0] if len(lines) == 1 else "\n  " + first_lines(lines).replace("\n", "\n  ")
    if isinstance(error, SyntaxError):
        return f"syntax error: {clipped(plain(str(error.msg)), LONGEST)}"
    return f"{class_name(error)}: {of_error(error)}".removesuffix(": ")
