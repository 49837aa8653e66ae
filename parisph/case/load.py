"""Find a case file and call its function `case` with the values of --set. Errors give file and line."""

import difflib
import functools
import inspect
import json
import types
import typing
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from parisph.base import paths, vocabulary
from parisph.base.errors import CaseError
from parisph.base.paths import AnyPath
from parisph.base.text import class_name, listed, named, of_error, shown
from parisph.case import origin, stored
from parisph.case.expressions import number
from parisph.case.numerics import WORDS
from parisph.case.profiles import Profiles, read_profiles
from parisph.case.schema import Case
from parisph.case.truths import Truth, read_truth
from parisph.case.users_file import LONGEST, beside, module_of, read, users_code, what

InFile = Truth | Profiles
MISSING = inspect.Parameter.empty
STARS: dict[Any, str] = {inspect.Parameter.VAR_POSITIONAL: "*", inspect.Parameter.VAR_KEYWORD: "**"}
MOST_STORED = 128 * 10**6    # bytes of a stored case: each of its fields may have 10**6 numbers, each up to 32 bytes


def load(path: AnyPath, sets: Mapping[str, Any] | Sequence[str] = ()) -> Case:
    """Return the Case that a case file describes. Not collective, needs no MPI.

    path : a Python file with a function `case(...) -> Case` whose parameters all have defaults, or the
        case.json of a run
    sets : dict of parameter values, or a list of texts "name=value"

    Raises CaseError: the file, a parameter or the case is wrong. Any exception in the
        code of the case file (also SystemExit, but not KeyboardInterrupt) becomes a CaseError.
    """
    file = _find(path)
    sets = _as_dict(sets)
    if file.suffix == ".json":
        if sets:
            raise CaseError(f"{named(path)}: a stored case takes no --set; give the case file that made it")
        return _stored(file, path)
    function = _function(file, path)
    given = {name: _value(function, name, value, path) for name, value in sets.items()}
    values = {**{name: item.default for name, item in inspect.signature(function).parameters.items()}, **given}
    try:
        came = origin.of_file(file, path, values, given)    # before the function runs: it may take long
    except OSError as error:
        raise CaseError(f"{named(path)}: cannot be read: {error.strerror}") from None
    with beside(file):
        case = users_code(lambda: function(**given), file, path)
    if not users_code(lambda: isinstance(case, Case), file, path):
        raise CaseError(f"{named(path)}: case(...) returned a {class_name(case)}; it must return a Case")
    return _with_truths(case, file.parent).of(came)


def arguments(path: AnyPath, sets: Mapping[str, Any] | Sequence[str] = ()) -> dict[str, Any]:
    """Return {name: value} of all parameters of a case file, as `load` passes them. Raises CaseError.

    path, sets : as of `load`; a stored case has no parameters
    """
    file = _find(path)
    if file.suffix == ".json":
        return {}
    function = _function(file, path)
    values = {name: item.default for name, item in inspect.signature(function).parameters.items()}
    return {**values, **{name: _value(function, name, value, path) for name, value in _as_dict(sets).items()}}


def parameters(path: AnyPath) -> dict[str, tuple[Any, str]]:
    """Return {name: (default, type in words)} of a case file's parameters. Raises CaseError."""
    function = _function(_find(path), path)
    hints = _hints(function)
    return {name: (item.default, _type_name(hints.get(name)))
            for name, item in inspect.signature(function).parameters.items()}


def _find(path: AnyPath) -> Path:
    file = paths.checked(path, "CASE")
    if file.is_file():
        return file.resolve()
    if file.name and file.suffix == "" and file.with_suffix(".py").is_file():
        return file.with_suffix(".py").resolve()
    folder = file if file.is_dir() else file.parent
    near = sorted(item.name for item in folder.glob("*.py")) if folder.is_dir() else []
    if file.is_dir():
        problem = "is a folder; give a case file"
    else:
        problem = "is not a regular file; give a case file" if file.exists() else "there is no such case file"
    hint = f"; {named(folder)} has {listed(map(named, near), 300)}" if near else ""
    raise CaseError(f"{named(path)}: {problem}{hint}")


def _stored(file: Path, path: AnyPath) -> Case:
    text = read(file, path, MOST_STORED)
    try:
        case = stored.from_json(text)
    except CaseError as error:
        raise CaseError(f"{named(path)}: {what(error)}") from error
    content = json.loads(text)
    try:
        return case.of(origin.of_stored(file, path, content)) if "run" in content else case
    except OSError as error:
        raise CaseError(f"{named(path)}: cannot be read: {error.strerror}") from None


def register_parts(path: AnyPath) -> None:
    """Run a Python file that registers parts of methods, such as a case file. Call it on every rank.

    Raises CaseError: the file cannot be read, or raises an error.
    """
    module_of(_find(path), path, "parisph_case")


def _function(file: Path, path: AnyPath) -> Callable[..., Any]:
    """Run the case file and return its function `case`."""
    module = module_of(file, path, "parisph_case")
    function: Callable[..., Any] | None = vars(module).get("case")
    if not callable(function) or users_code(lambda: inspect.iscoroutinefunction(function), file, path):
        there = ("has no function case(...)" if function is None
                 else f"`case` is a {class_name(function)}, not a plain function")
        raise CaseError(f"{named(path)}: {there}; write: def case(...) -> Case")
    _check_parameters(function, path)
    return function


def _check_parameters(function: Callable[..., Any], path: AnyPath) -> None:
    try:
        known = inspect.signature(function).parameters.items()
    except KeyboardInterrupt:
        raise
    except BaseException:
        raise CaseError(f"{named(path)}: `case` is {shown(function)}, whose parameters cannot be found; write: "
                        "def case(...) -> Case") from None
    for name, parameter in known:
        if parameter.kind not in (parameter.POSITIONAL_OR_KEYWORD, parameter.KEYWORD_ONLY):
            stars = STARS.get(parameter.kind, "")
            raise CaseError(f"{named(path)}: the parameter {stars}{name} of case(...) cannot be set by name; "
                            f"write it as {name}: float = 1.0")
        if parameter.default is MISSING:
            raise CaseError(f"{named(path)}: the parameter {name!r} of case(...) needs a default, "
                            f"as in {name}: float = 1.0")


def _as_dict(sets: Mapping[str, Any] | Sequence[str]) -> dict[str, Any]:
    if isinstance(sets, Mapping):
        return dict(sets)
    values: dict[str, str] = {}
    for text in sets or ():
        name, equals, value = text.partition("=")
        if not equals or not name.strip():
            raise CaseError(f"--set {named(text)}: must be name=value, for example --set spacing=0.02")
        if name.strip() in values:
            raise CaseError(f"--set {named(name.strip())} is given twice: "
                            f"{named(values[name.strip()])} and {named(value.strip())}")
        values[name.strip()] = value.strip()
    return values


def _value(function: Callable[..., Any], name: str, value: Any, path: AnyPath) -> Any:
    """Return a --set value in the type of its parameter."""
    known = inspect.signature(function).parameters
    if name not in known:
        close = difflib.get_close_matches(name, known, n=1)
        meant = f"; did you mean {close[0]!r}?" if close else "."
        defaults = listed((f"{key}={shown(item.default, 40)}" for key, item in known.items()), LONGEST) or "none"
        raise CaseError(f"{named(path)} has no parameter {shown(name)}{meant} Its parameters and their defaults: "
                        f"{defaults}")
    if not isinstance(value, str):
        return value
    hint = _hints(function).get(name)
    default = known[name].default
    wanted = hint if hint is not None else type(default)
    if name in WORDS and value.lower() in vocabulary.known(WORDS[name]):    # such as "none"
        return value.lower()
    try:
        return _convert(value, wanted)
    except (ValueError, TypeError) as error:
        reason = "none is not allowed here" if value.lower() == "none" else of_error(error)
        raise CaseError(f"--set {named(name)}={named(value)}: must be {_type_name(wanted)}, "
                        f"as the default {shown(default, 40)} is ({reason})") from None


def _hints(function: Callable[..., Any]) -> dict[str, Any]:
    while isinstance(function, functools.partial):
        function = function.func
    try:
        return typing.get_type_hints(function)
    except KeyboardInterrupt:
        raise
    except BaseException:    # annotations in quotes are the user's code
        return {}


def _convert(text: str, wanted: Any) -> Any:
    """Convert text to a type: float, int, bool, str, tuple[...] or a union of them with None."""
    origin, arguments = typing.get_origin(wanted), typing.get_args(wanted)
    if origin in (typing.Union, types.UnionType):
        if type(None) in arguments and text.lower() in ("none", ""):
            return None
        return _first(text, [item for item in arguments if item is not type(None)])
    if wanted is tuple or origin is tuple:
        parts = [part.strip() for part in text.strip().strip("()").split(",") if part.strip()]
        kinds = [item for item in arguments if item is not Ellipsis] or [float]
        if Ellipsis not in arguments and arguments and len(parts) != len(kinds):
            raise ValueError(f"{len(parts)} values where {len(kinds)} are needed")
        return tuple(_convert(part, kinds[min(k, len(kinds) - 1)]) for k, part in enumerate(parts))
    if wanted is bool:
        values = {"true": True, "yes": True, "on": True, "1": True, "false": False, "no": False,
                  "off": False, "0": False}
        if text.lower() not in values:
            raise ValueError("give true or false")
        return values[text.lower()]
    if wanted is int:
        return int(text)
    if wanted is float:
        return number(text)
    if wanted is str:
        return text
    raise TypeError(f"a parameter of type {_type_name(wanted)} cannot be set from text")


def _first(text: str, kinds: Sequence[Any]) -> Any:
    """Convert to the first type that accepts the text; str comes last, as it accepts any text."""
    problem: Exception | None = None
    for kind in sorted(kinds, key=lambda item: item is str):
        try:
            return _convert(text, kind)
        except (ValueError, TypeError) as error:
            problem = problem or error
    raise problem or TypeError("a union of no types")


def _type_name(wanted: Any) -> str:
    known = {float: "a number", int: "a whole number", bool: "true or false", str: "a text", type(None): "none"}
    for kind, words in known.items():
        if wanted is kind:
            return words
    if typing.get_origin(wanted) in (typing.Union, types.UnionType):
        return " or ".join(_type_name(item) for item in typing.get_args(wanted))
    if wanted is tuple or typing.get_origin(wanted) is tuple:
        return "values with commas between them"
    return named(getattr(wanted, "__name__", None) or shown(wanted))


def _with_truths(case: Case, folder: Path) -> Case:
    """Return the case with absolute paths of the probes' reference files, each read once as a check."""
    probes = []
    for probe in case.probes:
        if isinstance(probe.truth, (Truth, Profiles)):
            try:
                truth = _read(probe.truth, folder)
            except CaseError as error:
                raise CaseError(f"probe {probe.name!r}: {error}") from None
            probe = probe.model_copy(update={"truth": truth})
        probes.append(probe)
    return case.model_copy(update={"probes": tuple(probes)})


def _read(truth: InFile, folder: Path) -> InFile:
    """Return a truth with absolute paths, its `others` too, after reading the files as a check."""
    truth = truth.model_copy(update={"file": _absolute(truth.file, folder)})
    if isinstance(truth, Truth):
        read_truth(truth)
    else:
        read_profiles(truth)
    return truth.model_copy(update={"others": tuple(_read(other, folder) for other in truth.others)})


def _absolute(file: str, folder: Path) -> str:
    try:
        return str(paths.checked(folder / file, "truth.file").resolve())
    except (OSError, RuntimeError) as error:    # circular links
        raise CaseError(f"truth.file = {shown(file)}: {of_error(error)}") from None
