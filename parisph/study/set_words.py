"""Values of parameters as text, for the words name=value of --set."""

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
    found: dict[str, str] = {}
    for word in words:
        name, equals, value = (part.strip() for part in word.partition("="))
        if not equals or not name:
            raise CaseError(f"--set {named(word)}: must be name=value, for example --set end_time=2")
        if name in found:
            raise CaseError(f"--set {named(name)} is given twice")
        found[name] = value
    return found


def value(name: str, given: Any) -> Any:
    """Return the value of a field of numerics from a text: None, bool, number, or the text; other values unchanged.

    "" is None. "none" is None too, unless it is a word of the field, as of surface_rule.
    """
    if not isinstance(given, str):
        return given
    word = given.lower()
    if name in WORDS and word in vocabulary.known(WORDS[name]):
        return word
    words = {"": None, "none": None, "true": True, "false": False}
    if word in words:
        return words[word]
    try:
        found = number(given)
    except ValueError:
        return given
    return int(found) if found == int(found) and name == "seed" else found


def text(value: Any) -> str:
    """Return the value of a parameter as text for --set."""
    if isinstance(value, (tuple, list)):
        return ",".join(map(text, value))
    return "none" if value is None else f"{value:.10g}" if isinstance(value, float) else str(value)
