"""Points of other codes, from CSV files, for the pictures of a study."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from parisph.base import reading, table
from parisph.base.errors import CaseError, StoreError
from parisph.base.text import named, shown
from parisph.study.definition import OtherCodes


@dataclass(frozen=True)
class OtherPoint:
    """A run of another code: its name, spacing, error and CPU time [s]; None if unknown."""

    code: str
    spacing: float | None
    error: float | None
    cpu: float | None


def read(other: OtherCodes, folder: Path) -> list[OtherPoint]:
    """Return the points of a file. Not collective.

    folder : of the study file

    Raises CaseError: the file cannot be read, lacks a column, or has a word in place of a number
    """
    try:
        names, lines = table.read(folder / other.file)
    except StoreError as error:
        raise CaseError(f"others: {error}") from None
    for name in filter(None, (other.code, other.spacing, other.error, other.cpu)):
        if name not in names:
            raise CaseError(f"others: {named(other.file)} has no column {shown(name)} "
                            f'(it has: {reading.listed(names)}); write "" for a column that it lacks')

    def number(line: int, cells: Sequence[str], name: str) -> float | None:
        cell = cells[names.index(name)] if name else ""
        try:
            return float(cell) if cell else None
        except ValueError:
            raise CaseError(
                f"others: {named(other.file)}, line {line}: {shown(cell)} in {shown(name)} is not a number") from None

    return [OtherPoint(cells[names.index(other.code)] if other.code else Path(other.file).stem,
                       *(number(line, cells, name) for name in (other.spacing, other.error, other.cpu)))
            for line, cells in lines.items()]
