"""Text and file names from outside as parts of Markdown, and tables."""

import os
import re
from collections.abc import Iterable, Sequence
from urllib.parse import quote

from parisph.base.paths import AnyPath
from parisph.base.text import plain

# Markup inside a line. Underscores inside words are none, nor is an & unless a name and a semicolon follow.
_INSIDE = re.compile(r"[\\`*\[\]<|~$]|&(?=#?\w+;)|(?<![^\W_])_|_(?![^\W_])")
# Markup at the start of a line (lists, headings, quotations), and #s at the end of a heading, which would vanish.
_AT_ENDS = re.compile(r"^[-+=#>]|#(?=#*$)")
_NUMBERED = re.compile(r"^([0-9]+)([.)])(?=\s|$)")


def escaped(text: str) -> str:
    """Return a text that Markdown shows unchanged inside a line or a cell, without links, markup and HTML."""
    return _INSIDE.sub(r"\\\g<0>", plain(text))


def line(text: str) -> str:
    """Return a text for a whole line or a heading, escaped as `escaped` does."""
    return _NUMBERED.sub(r"\1\\\2", _AT_ENDS.sub(r"\\\g<0>", escaped(text.strip())))


def target(path: AnyPath) -> str:
    """Return a relative path as the target of a link in Markdown and HTML, percent-encoded."""
    return quote(os.fsencode(path), safe="/")


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a Markdown table whose columns are aligned."""
    rows = [[cell.replace("|", "/") for cell in row] for row in [head, *rows]]
    widths = [max(len(row[k]) for row in rows) for k in range(len(head))]
    lines = ["| " + " | ".join(cell.ljust(width) if k == 0 else cell.rjust(width)
                               for k, (cell, width) in enumerate(zip(row, widths))) + " |" for row in rows]
    rule = "|" + "|".join("-" * (width + 1) + "-:"[k > 0] for k, width in enumerate(widths)) + "|"
    return "\n".join([lines[0], rule, *lines[1:]])
