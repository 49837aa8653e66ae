"""Cells of the tables of a report: a text, and where in the files of the run its number is."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Cell:
    """A cell. source : "FILE: name.name", the entry of a JSON file of the run that the text shows; "" for words."""

    text: str
    source: str = ""


@dataclass(frozen=True)
class CellTable:
    """A table. head : names of the columns, empty if the first column has names; rows : of Cells"""

    head: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]


def number(content: Mapping[str, Any], file: str, path: Sequence[str | int], form: str = ".4g", unit: str = "") -> Cell:
    """Return the Cell of a number in the content of a JSON file; "-" if it is not there, or None.

    path : names and indices on the way to it; form : as of format(); unit : written behind it
    """
    value: Any = content
    for name in path:
        try:
            value = value[name]
        except (KeyError, IndexError, TypeError):
            value = None
    if value is None:
        return Cell("-")
    text = format(value, form) if isinstance(value, (int, float)) and not isinstance(value, bool) else str(value)
    return Cell(text + (f" {unit}" if unit else ""), f"{file}: {'/'.join(str(name) for name in path)}")
