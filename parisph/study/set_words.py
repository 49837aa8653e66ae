"""The words name=value of --set for all runs of a study, and what they mean."""

from collections.abc import Sequence
from typing import Any

from parisph.base import vocabulary
from parisph.base.errors import CaseError
from parisph.base.text import named
from parisph.case.expressions import number
from parisph.case.numerics import WORDS

INSIDE = "numerics."    # before the name of a field of Numerics


def read(words: Sequence[str]) -> dict[str, str]:
    """Return {name: text} of words name=value. Raises CaseError."""
    found = {}
    for word in words:
        name, equals, value = word.partition("=")
        if not equals or not name.strip():
            raise CaseError(f"--set {named(word)}: must be name=value, for example --set end_time=2")
        if name.strip() in found:
            raise CaseError(f"--set {named(name.strip())} is given twice")
        found[name.strip()] = value.strip()
    return found


def value(name: str, text: str) -> Any:
    """Return what a text means for a field of numerics: None, True, False, a number, or the text itself.

    No text is None everywhere; "none" is, except where it is a word, as for surface_rule.
    """
    if name in WORDS and text.lower() in vocabulary.known(WORDS[name]):
        return text.lower()
    words = {"": None, "none": None, "true": True, "false": False}
    if text.lower() in words:
        return words[text.lower()]
    try:
        found = number(text)
    except ValueError:
        return text
    return int(found) if found == int(found) and name == "seed" else found


def number_of(value: float | str) -> float:
    """Return a number that may be given as text."""
    return number(value) if isinstance(value, str) else value
