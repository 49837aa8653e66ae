"""Reference series, measured or computed elsewhere: two columns of a CSV file. Not collective."""

from collections.abc import Mapping
from os.path import isdir, join

import numpy as np

from parisph.base import reading
from parisph.base.arrays import Floats
from parisph.base.errors import StoreError
from parisph.base.paths import AnyPath
from parisph.base.text import named, shown

LARGEST = 1e30    # in SI units, as for a case: squares stay finite


def names(path: AnyPath) -> list[str]:
    """Return the names of the columns of a CSV file with one header line. Raises StoreError."""
    return read(path)[0]


def read_reference(path: AnyPath, time: str, value: str, offset: float = 0.0, scale: float = 1.0,
                   time_scale: float = 1.0) -> tuple[Floats, Floats]:
    """Return (t (n,) [s], truth (n,)): two columns of a reference file, sorted by time.

    truth = offset + scale * column; t = time_scale * column. Lines with an empty cell or nan are skipped: measured
    series may have gaps, but not the truth of a case (case.truths.read_truth). Raises StoreError for a missing file or
    column, or a cell that is not a number.
    """
    found, lines = read(path)
    for name in (time, value):
        if name not in found:
            raise StoreError(f"{named(path)} has no column {shown(name)} (it has: {reading.listed(found)})")
    columns = [_numbers(path, name, {number: cells[found.index(name)] for number, cells in lines.items()})
               for name in (time, value)]
    with np.errstate(over="ignore", invalid="ignore"):
        t, truth = time_scale * columns[0], offset + scale * columns[1]
    good = ~(np.isnan(columns[0]) | np.isnan(columns[1]))
    if not np.all(np.abs([t[good], truth[good]]) <= LARGEST):
        raise StoreError(f"{named(path)}: {shown(time)} or {shown(value)} reaches more than {LARGEST:g} when scaled; "
                         "look at the scales and the offset")
    order = np.argsort(t[good], kind="stable")
    return t[good][order], truth[good][order]


def read(path: AnyPath) -> tuple[list[str], dict[int, list[str]]]:
    """Return what reading.read_columns does. Raises StoreError."""
    try:
        return reading.read_columns(path)
    except OSError as error:
        of_run = f"; give the file of a probe, as {path}/probes/NAME.csv" if isdir(join(path, "probes")) else ""
        raise StoreError(f"cannot read {named(path)}: {error.strerror}{of_run}") from None
    except ValueError as error:
        raise StoreError(f"cannot read {named(path)} as a CSV file: {error}") from None


def _numbers(path: AnyPath, name: str, cells: Mapping[int, str]) -> Floats:
    """Return the numbers (n,) of {line: cell}; nan for a gap. Raises StoreError."""
    found = np.full(len(cells), np.nan)
    for k, (line, cell) in enumerate(cells.items()):
        try:
            found[k] = float(cell) if cell else np.nan
        except ValueError:
            raise StoreError(f"{named(path)}: line {line} of column {shown(name)} holds a word, not a number") from None
        if np.abs(found[k]) > LARGEST:
            raise StoreError(f"{named(path)}: line {line} of column {shown(name)} holds a number of more "
                             f"than {LARGEST:g}")
    return found
