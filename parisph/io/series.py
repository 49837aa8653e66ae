"""Time series of a run as CSV files: one line per step or sample.

A file starts with comment lines "# ..." (title, units). The names of the columns follow, first time and step, then the
values. Each line is passed to the system when it is complete, so that a killed process loses none. An incomplete last
line is ignored.
"""

import math
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from parisph.base.arrays import Array
from parisph.base.errors import StoreError
from parisph.base.paths import AnyPath
from parisph.base.reading import check_regular
from parisph.io.files import write_text

OF_RUN = "run "
OF_RUN_LINE = f"# {OF_RUN}"


class SeriesFile:
    """A CSV file that grows line by line. One rank only; every method raises OSError.

    columns : {name: unit, "" for none}; `time` and `step` are added in front
    title : one line of description
    keep_to, until : None to start a new file, else last step and time [s] of the lines that are kept (restart)
    run : identity of the run that writes it, or ""

    If an older release wrote the file with other columns, those of the same name continue; new ones are empty.

    Raises StoreError: the old file is damaged, or of another run
    """

    def __init__(self, path: AnyPath, columns: Mapping[str, str], title: str = "", keep_to: int | None = None,
                 run: str = "", until: float = math.inf) -> None:
        self.path = Path(path)
        self.columns = {"time": "s", "step": "", **columns}
        kept = self._kept_lines(keep_to, run, until)
        units = ", ".join(f"{name} [{unit or '-'}]" for name, unit in self.columns.items())
        head = ([f"# {line}" for line in (title, units, f"{OF_RUN}{run}" if run else "") if line]
                + [",".join(self.columns)])
        write_text(self.path, "\n".join(head + kept) + "\n")
        # not buffered: a line that the disk refuses must not be written later, when the file is closed
        self._file = os.open(self.path, os.O_WRONLY | os.O_APPEND | os.O_NOFOLLOW)

    def append(self, time: float, step: int, values: Sequence[float | str | None]) -> None:
        """Add one line: time [s], step and one value (number, str, None for none) for each further column."""
        if len(values) != len(self.columns) - 2:
            raise ValueError(f"{self.path.name} has {len(self.columns) - 2} values a line, got {len(values)}")
        line = (",".join(_text(value) for value in (time, step, *values)) + "\n").encode()
        written = os.write(self._file, line)
        while written < len(line):    # the disk is nearly full: the next call raises
            written += os.write(self._file, line[written:])

    def close(self) -> None:
        """Close the file."""
        os.close(self._file)

    def _kept_lines(self, keep_to: int | None, run: str, until: float) -> list[str]:
        """Return the lines of the old file up to `keep_to` and `until`."""
        if keep_to is None or not self.path.exists():
            return []
        names, lines = read_own(self.path, run)
        if names != list(self.columns) and not set(names[2:]) & set(self.columns):
            raise StoreError(f"{self.path} has the columns {', '.join(names)[:200]}, not {', '.join(self.columns)}: "
                             "it is of another run")
        at = [names.index(name) if name in names else None for name in self.columns]
        return [",".join("" if k is None else line[k] for k in at)
                for line in lines if int(line[1]) <= keep_to and float(line[0]) <= until]


def read_own(path: Path, run: str = "", each_step: bool = False) -> tuple[list[str], list[list[str]]]:
    """Return the names of the columns of a SeriesFile and its complete lines, cell by cell. Not collective.

    run : identity of the expected run, "" for any; each_step : whether every step must have a line

    Raises StoreError: the file cannot be read, is damaged (it names the line), or is of another run.
    """
    try:
        check_regular(os.stat(path))
        text = path.read_bytes().decode("utf-8")
    except FileNotFoundError:
        raise StoreError(f"there is no {path}: it was removed or moved away") from None
    except OSError as error:
        raise StoreError(f"cannot read {path}: {error.strerror or error}") from None
    except UnicodeDecodeError:
        raise StoreError(f"{path} is damaged: it is not text") from None
    names: list[str] = []
    lines: list[list[str]] = []
    before: tuple[float, int] | None = None
    text = text[: text.rfind("\n") + 1]    # without an incomplete last line
    for number, row in enumerate(text.split("\n")[:-1], 1):
        if row.startswith(OF_RUN_LINE) and run and row[len(OF_RUN_LINE):].strip() != run:
            raise StoreError(f"{path} is of another run")
        if row.startswith("#"):
            continue
        cells = row.split(",")
        if not names:
            names = [name.strip() for name in cells]
            if names[:2] != ["time", "step"]:
                raise StoreError(f"{path} is damaged, or was not written by parisph: "
                                 "its columns do not begin with time, step")
            continue
        before = _checked(path, number, cells, len(names), before, each_step)
        lines.append(cells)
    if not names:
        raise StoreError(f"{path} is damaged: it has no columns")
    return names, lines


def _checked(path: Path, number: int, cells: list[str], count: int, before: tuple[float, int] | None,
             each_step: bool) -> tuple[float, int]:
    """Return (time, step) of a line of a SeriesFile. Raises StoreError for a damaged line."""
    try:
        if len(cells) != count or not all(cell.isprintable() and '"' not in cell for cell in cells):
            raise ValueError
        time, step = float(cells[0]), int(cells[1])
    except ValueError:
        raise StoreError(f"{path} is damaged: line {number} does not have {count} values. "
                         "Repair the file or move it away") from None
    if before and (not time > before[0] or step < before[1] or (each_step and step != before[1] + 1)):
        raise StoreError(f"{path} is damaged: in line {number} step {step} at {time:g} s follows step {before[1]} at "
                         f"{before[0]:g} s. Repair the file or move it away")
    return time, step


def table(names: list[str], lines: list[list[str]]) -> Array:
    """Return lines of cells as a structured array: numbers as float64, step as int64, columns with words as str."""
    columns = [_column(name, [line[k] for line in lines]) for k, name in enumerate(names)]
    found = np.empty(len(lines), dtype=[(name, column.dtype) for name, column in zip(names, columns)])
    for name, column in zip(names, columns):
        found[name] = column
    return found


def units(path: AnyPath) -> dict[str, str]:
    """Return the unit of each column of a SeriesFile as a dict, "" for none or unknown."""
    found: dict[str, str] = {}
    with open(path, encoding="utf-8") as file:
        for line in file:
            if not line.startswith("#"):
                return {name: found.get(name, "") for name in line.strip().split(",")}
            for part in line[1:].split(","):
                name, bracket, unit = part.strip().rstrip("]").partition(" [")
                if bracket:
                    found[name] = "" if unit == "-" else unit
    return {}


def _column(name: str, cells: list[str]) -> Array:
    try:
        numbers = np.array([float(cell) if cell.strip() else math.nan for cell in cells], dtype=np.float64)
    except ValueError:
        return np.array(cells, dtype=str) if cells else np.zeros(0, dtype="U1")
    return numbers.astype(np.int64) if name == "step" else numbers


def _text(value: Any) -> str:
    if value is None or isinstance(value, str):
        return value or ""
    value = value.item() if hasattr(value, "item") else value
    return repr(value)  # the shortest text that reads back as the same number
