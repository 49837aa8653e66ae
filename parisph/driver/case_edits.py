"""Edits of a case.json before a restart: those that change no result are taken, others refused."""

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from parisph.base.errors import CaseError
from parisph.base.reading import read_text
from parisph.base.text import listed, named, shown
from parisph.case.stored import from_json

# The length of a run, and the times of its output: the steps do not depend on them.
TAKEN = ("end_time", "title", "output.every", "output.times", "output.checkpoint_every")
FEW = 400    # characters of the edits in a message


def edits(folder: Path, saved: str) -> dict[str, Any]:
    """Return {name: new value} of the edits that a restart takes from the case.json of its run.

    saved : the case in the checkpoint, as JSON text

    Raises CaseError, with a remedy, if anything else was edited; OSError.
    """
    path = folder / "case.json"
    if not path.exists():
        return {}
    try:
        now = from_json(read_text(path, math.inf), read_only=True)
    except CaseError as error:
        raise CaseError(f"{named(path)}: {error}") from None
    before = from_json(saved, read_only=True)
    found = {name: (old, new) for name, old, new in _differences(before.model_dump(), now.model_dump())}
    others = [name for name in found if name not in TAKEN]
    if others:
        what = listed([f"{name} = {shown(found[name][1], 40)} (was {shown(found[name][0], 40)})"
                       for name in others], FEW)
        raise CaseError(
            f"{named(path)} was edited: {what}.\n"
            f"A restart takes edits of {', '.join(TAKEN)} alone, as all others would make another run of it.\n"
            f"To run the edited case from its start: parisph run {named(path)} -o DIR\n"
            f"To continue the original case: move {named(path)} out of its folder; the restart writes it again")
    return {name: new for name, (_, new) in found.items()}


def told(taken: dict[str, Any], folder: Path) -> list[str]:
    """Return the lines of the log about the edits that are taken."""
    return [f"{folder / 'case.json'} was edited, and the restart goes on with {name} = {shown(value)}"
            for name, value in taken.items()]


def _differences(old: Any, new: Any, name: str = "") -> Iterator[tuple[str, Any, Any]]:
    """Yield (dotted name, old, new) of the values in which two nested records differ.

    A value in both `asked` and `numerics` is named once, in `numerics`.
    """
    if isinstance(old, dict) and isinstance(new, dict):
        seen = set()
        for key in dict.fromkeys((*old, *new)):
            for inner, before, after in _differences(old.get(key), new.get(key), f"{name}.{key}".lstrip(".")):
                plain = inner.replace("asked.", "numerics.", 1) if inner.startswith("asked.") else inner
                if plain not in seen:
                    seen.add(plain)
                    yield plain, before, after
    elif isinstance(old, tuple) and isinstance(new, tuple) and len(old) == len(new) and any(
            isinstance(one, dict) for one in old):
        for number, (before, after) in enumerate(zip(old, new)):
            yield from _differences(before, after, f"{name}.{number}")
    elif old != new:
        yield name, old, new
