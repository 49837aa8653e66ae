"""Read a study file: Python with a `study`, or JSON. Errors name file and line."""

import json
import types
from pathlib import Path

from parisph.base import paths
from parisph.base.errors import CaseError
from parisph.base.paths import AnyPath
from parisph.base.text import class_name, named
from parisph.case import users_file
from parisph.study.definition import Study
from parisph.study.patch_study import PatchStudy


def read(path: AnyPath) -> tuple[Study | PatchStudy, Path]:
    """Return the study that a file describes, and the absolute path of the file. Not collective, needs no MPI.

    path : a Python file with `study = Study(...)` or `study = PatchStudy(...)`, or a function `study()` that returns
        one; or a JSON file with the fields of a Study, or, with "kind": "patch", of a PatchStudy

    Raises CaseError, with place and remedy, for a fault of the file or the study. Any exception in the code of the file
    except KeyboardInterrupt becomes a CaseError.
    """
    file = paths.checked(path, "FILE")
    if not file.is_file():
        problem = "is a folder; give a study file" if file.is_dir() else "there is no such study file"
        raise CaseError(f"{named(path)}: {problem}")
    file = file.resolve()
    if file.suffix == ".json":
        text = users_file.read(file, path)
        try:
            return _kind_of(text).model_validate_json(text), file
        except CaseError as error:
            raise CaseError(f"{named(path)}: {error}") from None
    return _of_python(file, path), file


def _kind_of(text: str) -> type[Study] | type[PatchStudy]:
    """Return the class of the study in a JSON text."""
    try:
        found = json.loads(text)
    except ValueError:    # Study reports the place
        return Study
    return PatchStudy if isinstance(found, dict) and found.get("kind") == "patch" else Study


def _of_python(file: Path, path: AnyPath) -> Study | PatchStudy:
    found = vars(users_file.module_of(file, path, "parisph_study")).get("study")
    if isinstance(found, types.FunctionType):
        found = users_file.users_code(found, file, path)
    if not isinstance(found, (Study, PatchStudy)):
        there = "has no `study`" if found is None else f"`study` is a {class_name(found)}"
        raise CaseError(f"{named(path)}: {there}; write: study = Study(case=..., ...)")
    return found
