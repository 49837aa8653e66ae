"""Text from outside, prepared for messages: on one line, without control characters, not too long."""

import math
import reprlib
import unicodedata
from collections.abc import Iterable
from typing import cast

LIMIT = 80          # characters of a value in a message
LONGEST = 200       # characters of a name or path
# Control characters, half of a surrogate pair (a byte that is not UTF-8), line and paragraph separators.
_UNFIT = ("Cc", "Cs", "Zl", "Zp")

_short = reprlib.Repr()
_short.maxstring = _short.maxother = _short.maxlong = LIMIT
_short.maxlevel = 3


def is_plain(text: str) -> bool:
    """Return whether a text is one line without control characters."""
    return not any(unicodedata.category(character) in _UNFIT for character in text)


def plain(text: str) -> str:
    """Return a text on one line: control characters and line breaks become escapes such as \\n or \\x1b."""
    if is_plain(text):
        return text
    return "".join(character.encode("unicode_escape").decode()
                   if unicodedata.category(character) in _UNFIT else character for character in text)


def plain_lines(text: str, indent: str = "") -> str:
    """Return a text with an indent after each line break, and with escapes for other control characters."""
    return f"\n{indent}".join(plain(line) for line in text.split("\n"))


def clipped(text: str, limit: int = LIMIT) -> str:
    """Return a text of at most `limit` characters; '...' replaces the middle of a longer one."""
    if len(text) <= limit:
        return text
    end = (limit - 3) // 3
    return f"{text[:limit - 3 - end]}...{text[len(text) - end:]}"


def listed(texts: Iterable[str], limit: int = LONGEST) -> str:
    """Return texts with commas between them; those beyond `limit` characters are only counted."""
    texts = list(texts)
    for kept in range(min(len(texts), limit), 0, -1):
        more = f" and {len(texts) - kept} more" if kept < len(texts) else ""
        if len(found := ", ".join(texts[:kept]) + more) <= limit:
            return found
    return clipped(", ".join(texts), limit)


def shown(value: object, limit: int = LIMIT) -> str:
    """Return any value for a message: its repr on one line, of at most `limit` characters.

    Raises only KeyboardInterrupt, even if the repr of a user's object fails.
    """
    is_text = issubclass(type(value), str)    # isinstance may execute code of the value
    try:
        text = repr(value) if is_text and len(cast(str, value)) <= limit else _short.repr(value)
    except KeyboardInterrupt:
        raise
    except BaseException:
        text = f"<{class_name(value)}>"
    return clipped(plain(" ".join(text.split())) if not is_text else plain(text), limit)


def class_name(value: object) -> str:
    """Return the name of a value's class for a message. Executes no code of that class or its metaclass."""
    return named(type.__dict__["__name__"].__get__(type(value)))


def named(text: object, limit: int = LONGEST) -> str:
    """Return a name or path for a message: without quotes, on one line, of at most `limit` characters."""
    return clipped(plain(str(text)), limit)


def rounded_down(value: float) -> str:
    """Return a positive number as text, rounded down to three digits."""
    unit = 10.0 ** (math.floor(math.log10(value)) - 2)
    return f"{math.floor(value / unit + 1e-9) * unit:.3g}"


def of_error(error: BaseException, limit: int = 300) -> str:
    """Return the message of an exception on one line, of at most `limit` characters. Raises only KeyboardInterrupt."""
    try:
        text = str(error)
    except KeyboardInterrupt:
        raise
    except BaseException:
        text = "its message cannot be shown"
    return clipped(plain(" ".join(text.split("\n"))), limit)


def point(x: Iterable[float]) -> str:
    """Return a place as text, as in (0.5, 1)."""
    return f"({', '.join(f'{a:g}' for a in x)})"
