"""Time series of a run as CSV files: one line a step, or a sample, that any program reads.

A file starts with lines "# ..." (what it is, the units), then the names of the columns, of
which the first two are always time and step, then the values. A line is handed to the system
as soon as it is complete, so a killed process loses none; a line cut in the middle is ignored.
"""

import csv
import math
from pathlib import Path

import numpy as np

from parisph.base.errors import StoreError
from parisph.io.files import write_text


class Series:
    """A CSV file that grows line by line. One rank only; every method raises OSError.

    Parameters
    ----------
    path : pathlib.Path
    columns : dict of column name -> unit ("" for none); `time` and `step` come first by themselves
    title : str, one line for people
    keep_to : None to start the file anew, or the last step of which lines are kept (restart)
    """

    def __init__(self, path, columns, title="", keep_to=None):
        self.path = Path(path)
        self.columns = {"time": "s", "step": "", **columns}
        kept = self._kept_lines(keep_to)
        units = ", ".join(f"{name} [{unit or '-'}]" for name, unit in self.columns.items())
        head = [f"# {line}" for line in (title, units) if line] + [",".join(self.columns)]
        write_text(self.path, "\n".join(head + kept) + "\n")
        self._file = open(self.path, "a", encoding="utf-8")

    def append(self, time, step, values):
        """Add one line: time [s], step and one value (number, str, None for none) for each further column."""
        if len(values) != len(self.columns) - 2:
            raise ValueError(f"{self.path.name} has {len(self.columns) - 2} values a line, got {len(values)}")
        self._file.write(",".join(_text(value) for value in (time, step, *values)) + "\n")
        self._file.flush()

    def close(self):
        """Close the file."""
        self._file.close()

    def _kept_lines(self, keep_to):
        if keep_to is None or not self.path.exists():
            return []
        names, lines = _lines(self.path)
        if names != list(self.columns):
            raise StoreError(f"{self.path} has the columns {names}, not {list(self.columns)}: it is of another run")
        return [",".join(line) for line in lines if int(line[1]) <= keep_to]


def read(path, cut=True):
    """Return a CSV file with one header line as a structured array: numbers as float64, step as int64,
    columns that hold words as str. Lines "#" are comments.

    With `cut`, a last line without a line end is taken to be cut off and is left out.
    Raises StoreError.
    """
    try:
        names, lines = _lines(path, cut)
    except OSError as error:
        raise StoreError(f"cannot read {path}: {error}") from None
    columns = [_column(name, [line[k] for line in lines]) for k, name in enumerate(names)]
    table = np.empty(len(lines), dtype=[(name, column.dtype) for name, column in zip(names, columns)])
    for name, column in zip(names, columns):
        table[name] = column
    return table


def units(path):
    """Return the unit of each column of a Series file as a dict, "" for none or unknown."""
    found = {}
    with open(path, encoding="utf-8") as file:
        for line in file:
            if not line.startswith("#"):
                return {name: found.get(name, "") for name in line.strip().split(",")}
            for part in line[1:].split(","):
                name, bracket, unit = part.strip().rstrip("]").partition(" [")
                if bracket:
                    found[name] = "" if unit == "-" else unit
    return {}


def read_reference(path, time, value, offset=0.0, scale=1.0, time_scale=1.0):
    """Return (t (n,) [s], truth (n,)): two columns of a reference file, lines in order of time.

    truth = offset + scale * column; t = time_scale * column. Lines with an empty cell are left
    out: a measured series has gaps, where the truth of a case (case.probes.read_truth) must be
    sound from end to end. Raises StoreError for a missing file or column, or a cell that is not a number.
    """
    table = read(path, cut=False)
    for name in (time, value):
        if name not in (table.dtype.names or ()):
            raise StoreError(f"{path} has no column {name!r} (it has: {', '.join(table.dtype.names or ())})")
        if table[name].dtype.kind not in "fi":
            raise StoreError(f"column {name!r} of {path} holds words, not numbers")
    t, truth = time_scale * table[time], offset + scale * table[value]
    good = np.isfinite(t) & np.isfinite(truth)
    order = np.argsort(t[good], kind="stable")
    return t[good][order], truth[good][order]


def _lines(path, cut=True):
    """Names of the columns and the complete lines below them."""
    text = Path(path).read_text(encoding="utf-8")
    if cut:
        text = text[: text.rfind("\n") + 1]
    lines = list(csv.reader(row for row in text.splitlines() if row.strip() and not row.startswith("#")))
    if not lines:
        raise StoreError(f"{path} has no columns")
    names = [name.strip() for name in lines[0]]
    return names, [line for line in lines[1:] if len(line) == len(names)]


def _column(name, cells):
    try:
        numbers = np.array([float(cell) if cell.strip() else math.nan for cell in cells], dtype=np.float64)
    except ValueError:
        return np.array(cells, dtype=str) if cells else np.zeros(0, dtype="U1")
    return numbers.astype(np.int64) if name == "step" else numbers


def _text(value):
    if value is None or isinstance(value, str):
        return value or ""
    value = value.item() if hasattr(value, "item") else value
    return repr(value)  # the shortest text that reads back as the same number
