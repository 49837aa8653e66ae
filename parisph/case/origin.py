"""The origin of a case: its file, and the parameters of its function. It is not a part of the case."""

import hashlib
from collections.abc import Mapping
from math import isfinite
from pathlib import Path
from typing import Any

from parisph.base.json_digest import KEY, MADE
from parisph.base.paths import AnyPath
from parisph.base.text import named, shown

PLAIN = (bool, int, float, str, type(None))


class Origin(dict[str, Any]):
    """The origin of a case as JSON-ready values, by name. All are equal, so comparisons of cases ignore it."""

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Origin)

    def __ne__(self, other: object) -> bool:
        return not self == other


def of_file(file: Path, path: AnyPath, parameters: Mapping[str, Any], given: Mapping[str, Any]) -> Origin:
    """Return the Origin of a case that a Python file describes. Raises OSError.

    path : the file as the user named it; parameters : of its function; given : those that the user set
    """
    return Origin(case_file=named(path), case_digest=_digest(file),
                  parameters={name: _plain(value) for name, value in parameters.items()}, given=sorted(given))


def of_stored(file: Path, path: AnyPath, content: Mapping[str, Any]) -> Origin:
    """Return the Origin of the case of an earlier run. Raises OSError.

    content : of its case.json, which users may have edited
    """
    run, made = content.get("run"), content.get(MADE)
    made = made if isinstance(made, dict) else {}
    earlier = {name: value for name, value in made.items() if name != "restarts"}
    kept = {name: earlier[name] for name in ("parameters", "given", "changed") if name in earlier}
    return Origin(case_file=named(path), case_digest=_digest(file), edited=KEY not in content, **kept,
                  repeats={"run": shown(run) if not isinstance(run, str) else named(run),
                           **{name: value for name, value in earlier.items() if name not in kept}})


def _digest(file: Path) -> str:
    return hashlib.blake2b(file.read_bytes(), digest_size=16).hexdigest()


def _plain(value: Any) -> Any:
    """Return a value of a parameter that JSON can store: other objects, and nan and inf, as text."""
    if isinstance(value, (tuple, list)):
        return [_plain(item) for item in value]
    return value if type(value) in PLAIN and not (isinstance(value, float) and not isfinite(value)) else shown(value)
