"""Read a study file: Python with a `study`, or JSON. Errors name file and line."""

import json
import sys
import traceback
import types
from contextlib import suppress
from pathlib import Path

from parisph.base import paths, reading
from parisph.base.errors import CaseError
from parisph.base.paths import AnyPath
from parisph.base.text import class_name, clipped, named, of_error, plain
from parisph.study.definition import Study
from parisph.study.patch_study import PatchStudy


def read(path: AnyPath) -> tuple[Study | PatchStudy, Path]:
    """Return the study that a file describes, and the absolute path of the file. Not collective, needs no MPI.

    path : a Python file with `study = Study(...)` or `study = PatchStudy(...)`, or a function `study()` that returns
        one; or a JSON file with the fields of a Study, or, with "kind": "patch", of a PatchStudy

    Raises
    ------
    CaseError : the file or the study is wrong; says where and what to do. Any exception in the code of the file
        (except KeyboardInterrupt) becomes a CaseError.
    """
    file = paths.checked(path, "FILE")
    if not file.is_file():
        problem = "is a folder; give a study file" if file.is_dir() else "there is no such study file"
        raise CaseError(f"{named(path)}: {problem}")
    file = file.resolve()
    try:
        text = reading.read_text(file)
    except OSError as error:
        raise CaseError(f"{named(path)}: cannot be read: {error.strerror}") from None
    if file.suffix == ".json":
        try:
            return _kind_of(text).model_validate_json(text), file
        except CaseError as error:
            raise CaseError(f"{named(path)}: {error}") from None
    return _of_python(text, file, path), file


def _kind_of(text: str) -> type[Study] | type[PatchStudy]:
    """Return the class of the study in a JSON text."""
    try:
        found = json.loads(text)
    except ValueError:    # the class says where
        return Study
    return PatchStudy if isinstance(found, dict) and found.get("kind") == "patch" else Study


def _of_python(text: str, file: Path, path: AnyPath) -> Study | PatchStudy:
    """Execute a study file, compiled here and not imported: no __pycache__ beside it."""
    module = types.ModuleType("parisph_study")
    module.__file__ = str(file)
    sys.path.insert(0, str(file.parent))
    try:
        exec(compile(text, str(file), "exec"), module.__dict__)  # noqa: S102
        found = vars(module).get("study")
        found = found() if isinstance(found, types.FunctionType) else found
    except KeyboardInterrupt:
        raise
    except BaseException as error:
        raise CaseError(f"{_where(error, file, path)}: {_what(error)}") from error
    finally:
        with suppress(ValueError):    # the file may have taken it out
            sys.path.remove(str(file.parent))
    if not isinstance(found, (Study, PatchStudy)):
        there = "has no `study`" if found is None else f"`study` is a {class_name(found)}"
        raise CaseError(f"{named(path)}: {there}; write: study = Study(case=..., ...)")
    return found


def _where(error: BaseException, file: Path, path: AnyPath) -> str:
    """Return 'path, line n' of the last line of the file that the error passed through."""
    if isinstance(error, SyntaxError) and error.filename == str(file):
        return f"{named(path)}, line {error.lineno}"
    lines = [frame.lineno for frame in traceback.extract_tb(error.__traceback__) if frame.filename == str(file)]
    return f"{named(path)}, line {lines[-1]}" if lines else named(path)


def _what(error: BaseException) -> str:
    if isinstance(error, CaseError):
        return "\n  ".join(clipped(plain(line), 400) for line in str(error).split("\n"))
    if isinstance(error, SyntaxError):
        return f"syntax error: {clipped(plain(str(error.msg)), 400)}"
    return f"{class_name(error)}: {of_error(error)}".removesuffix(": ")
