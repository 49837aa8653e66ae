"""Tables of a report, whose cells name the entry of the file that they show."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Cell:
    """A cell. source : "FILE: name/name", the entry of a JSON file of the run; "" for words."""

    text: str
    source: str = ""


@dataclass(frozen=True)
class CellTable:
    """A table. head : names of the columns, empty if the first column has names."""

    head: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]


def entry(content: Mapping[str, Any], path: Sequence[str | int]) -> Any:
    """Return an entry of a JSON file, None if it is missing. path : names and indices"""
    value: Any = content
    for name in path:
        try:
            value = value[name]
        except (KeyError, IndexError, TypeError):
            return None
    return value


def number(content: Mapping[str, Any], file: str, path: Sequence[str | int], form: str = ".4g", unit: str = "") -> Cell:
    """Return the Cell of an entry of a JSON file; "-" if it is missing or None.

    path : names and indices; form : as of format(); unit : written after the number
    """
    value = entry(content, path)
    if value is None:
        return Cell("-")
    text = format(value, form) if isinstance(value, (int, float)) and not isinstance(value, bool) else str(value)
    return Cell(text + (f" {unit}" if unit else ""), f"{file}: {'/'.join(str(name) for name in path)}")
