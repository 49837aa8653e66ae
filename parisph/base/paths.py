"""Checks of file and folder names from outside, before they are used."""

import os
from contextvars import ContextVar
from pathlib import Path

from parisph.base.errors import CaseError
from parisph.base.text import is_plain, shown

AnyPath = str | os.PathLike[str]    # for annotations

# Bytes that Linux, macOS and most file systems allow for a name, and for all of a path.
LONGEST_NAME, LONGEST_PATH = 255, 4095
# The folder that the paths in a case file are relative to, while it is loaded.
FOLDER: ContextVar[Path] = ContextVar("folder of the case file", default=Path())


def checked(path: AnyPath, what: str) -> Path:
    """Return a pathlib.Path. Raises CaseError if no file can have this name, or if it has line breaks.

    path : str or os.PathLike; what : name of the argument, for the message
    """
    problem = fault(path)
    if problem:
        raise CaseError(f"{what} = {shown(path)}: {problem}")
    return Path(path)


def fault(path: object) -> str | None:
    """Return what is wrong with a path, or None."""
    if isinstance(path, os.PathLike):
        path = os.fspath(path)
    if not isinstance(path, str):
        return "must be a text or a pathlib.Path"
    if not path.strip():
        return "must not be empty"
    if not is_plain(path):
        return "must be text without line breaks or control characters"
    longest, total = max(len(os.fsencode(name)) for name in path.split("/")), len(os.fsencode(path))
    if longest > LONGEST_NAME or total > LONGEST_PATH:
        return (f"is too long: a name has at most {LONGEST_NAME} bytes, a path {LONGEST_PATH}; "
                f"here {longest} and {total}")
    return None
