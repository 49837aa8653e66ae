"""Read text files from outside: regular files of limited size that contain text. Not collective."""

import csv
import errno
import math
import os
import re
import stat
from collections.abc import Sequence

from parisph.base.memory import amount
from parisph.base.paths import AnyPath
from parisph.base.text import clipped, named, shown

MOST = 16 * 10**6    # bytes of a file that is read
SEPARATORS = {";": "semicolons", "\t": "tabs", ",": "commas", " ": "blanks"}    # of columns, the least ambiguous first
COMMA = re.compile(r"[+-]?(\d+,\d*|,\d+)([eE][+-]?\d+)?")    # a number with a decimal comma
POINT = re.compile(r"[+-]?(\d+\.\d*|\.\d+)([eE][+-]?\d+)?")
THOUSANDS = re.compile(r"[+-]?\d{1,3}(([.,' ])\d{3})+[.,]\d*")


def read_text(path: AnyPath, most: float = MOST) -> str:
    """Return the text of a UTF-8 file, without a byte order mark.

    most : number of bytes that the file may have, math.inf for any (a file that parisph itself wrote)

    Raises OSError, whose strerror is one line: the file does not exist, is a folder, a pipe or a device (which is not
    opened), has more than `most` bytes, or is not text.
    """
    return read_exactly(path, most).removeprefix("\ufeff")


def read_exactly(path: AnyPath, most: float = MOST) -> str:
    """Return the text of a UTF-8 file as `read_text`, with its byte order mark if it has one."""
    try:
        check_regular(os.stat(path), most)
        with open(os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0)), "rb") as file:
            check_regular(os.fstat(file.fileno()), most)    # it may have been replaced
            data = file.read() if most == math.inf else file.read(int(most) + 1)
        if len(data) > most:
            raise OSError(errno.EFBIG, f"it has more than {amount(most)}")
        text = data.decode("utf-8")
    except UnicodeDecodeError as error:
        raise OSError(errno.EILSEQ, f"it is not text in UTF-8: see byte {error.start}") from None
    except ValueError:    # a null character in the name
        raise OSError(errno.EINVAL, "no file can have this name") from None
    if "\0" in text:
        raise OSError(errno.EILSEQ, f"it is not text: see character {text.index(chr(0))}")
    return text


def read_columns(path: AnyPath) -> tuple[list[str], dict[int, list[str]]]:
    """Return (names, lines) of a text file with one header line: names of its columns, and {line number: cells}.

    Columns are separated by commas, semicolons, tabs or blanks, whichever splits all lines alike. Numbers with decimal
    commas are returned with points. Lines that begin with '#' and empty lines are left out.

    Raises OSError as read_text, and ValueError with one line that shows little of the file: there is no header, a
    column has no name or that of another one, a line has too few or too many cells, or the file is ambiguous.
    """
    rows = {number: row.strip(" ") for number, row in enumerate(read_text(path).splitlines(), 1)
            if row.strip() and not row.startswith("#")}
    if not rows:
        raise ValueError("it has no line with the names of columns")
    separator = _separator(list(rows.values()))
    first, *others = rows
    names = _cells(rows[first], separator, first)
    _check_names(names)
    lines = {number: _cells(rows[number], separator, number) for number in others}
    for number, cells in lines.items():
        if len(cells) != len(names):
            raise ValueError(f"line {number} has {len(cells)} value{'s' * (len(cells) != 1)}, and there are "
                             f"{len(names)} columns{_hint(separator, rows[first], len(cells) > len(names))}")
    return names, _with_points(lines)


def listed(names: Sequence[str]) -> str:
    """Return at most nine names of columns for a message."""
    return clipped(", ".join(named(name) for name in names[:9]) + ", ..." * (len(names) > 9)) or "none"


def check_regular(status: os.stat_result, most: float = math.inf) -> None:
    """Raise OSError unless an os.stat is that of a regular file of at most `most` bytes; others may block if opened."""
    if stat.S_ISDIR(status.st_mode):
        raise OSError(errno.EISDIR, "it is a folder")
    if not stat.S_ISREG(status.st_mode):
        raise OSError(errno.EINVAL, "it is not a regular file")
    if status.st_size > most:
        raise OSError(errno.EFBIG, f"it has {amount(status.st_size)}, at most {amount(most)} are read")


def _separator(rows: Sequence[str]) -> str:
    """Return the character between the columns of lines; the first line has their names.

    Raises ValueError if two characters split all lines alike, and numbers do not decide between them.
    """
    there = [mark for mark in SEPARATORS if mark in rows[0]]
    if set(there) - {" "}:    # names may have blanks in them
        there = [mark for mark in there if mark != " "]
    fits = [mark for mark in there if len(there) > 1 and _splits_alike(rows, mark)]
    for which in (all, any):
        if len(fits) > 1:
            fits = [mark for mark in fits if which(_are_numbers(rows, mark))] or fits
    if len(fits) > 1:
        raise ValueError(f"its columns may be separated by {' or by '.join(SEPARATORS[mark] for mark in fits)}: "
                         "put names with such characters in double quotes")
    return (fits or there or [","])[0]


def _splits_alike(rows: Sequence[str], separator: str) -> bool:
    try:
        counts = {len(_cells(row, separator, 0)) for row in rows}
    except ValueError:
        return False
    return len(counts) == 1 and counts != {1}


def _are_numbers(rows: Sequence[str], separator: str) -> list[bool]:
    """Return for each column whether all lines after the first have a number."""
    return [all(map(_is_number, column)) for column in zip(*(_cells(row, separator, 0) for row in rows[1:]))]


def _is_number(cell: str) -> bool:
    try:
        float(cell.replace(",", ".") or "nan")
    except ValueError:
        return False
    return True


def _cells(row: str, separator: str, number: int) -> list[str]:
    if separator == " ":
        row = row.replace("\t", " ")
    try:
        found = next(csv.reader([row], delimiter=separator, skipinitialspace=True, strict=True))
    except csv.Error as error:
        raise ValueError(f"line {number} is not one of a CSV file ({error})") from None
    return [cell.strip() for cell in found]


def _hint(separator: str, header: str, more: bool) -> str:
    """Return a likely cause for a line with too many or too few values, as the end of a message."""
    if separator == "," and more:
        return "; where numbers have decimal commas, separate columns by semicolons"
    if separator == " ":
        return "; columns are separated by blanks: put names with blanks in double quotes"
    return "" if len(header) < 2 else f"; columns are separated by {SEPARATORS[separator]}, as in its first line"


def _with_points(lines: dict[int, list[str]]) -> dict[int, list[str]]:
    """Return lines whose numbers have decimal points. Raises ValueError if some have points and others commas."""
    with_commas = {number: cells for number, cells in lines.items() if any("," in cell for cell in cells)}
    marked = next((number for number, cells in with_commas.items() if any(map(THOUSANDS.fullmatch, cells))), None)
    if marked is not None:
        raise ValueError(f"line {marked} has a number with marks between thousands: leave them out")
    commas = next((number for number, cells in with_commas.items() if any(map(COMMA.fullmatch, cells))), None)
    if commas is None:
        return lines
    points = next((number for number, cells in lines.items() if any(map(POINT.fullmatch, cells))), None)
    if points is not None:
        raise ValueError(f"line {commas} has a number with a comma, and line {points} one with a point: "
                         "write all of them in one way")
    return {number: [cell.replace(",", ".") if COMMA.fullmatch(cell) else cell for cell in cells]
            for number, cells in lines.items()}


def _check_names(names: Sequence[str]) -> None:
    if all(_is_number(name) for name in names if name) and any(names):
        raise ValueError("its first line has numbers: write a line with the names of the columns above it")
    for number, name in enumerate(names, 1):
        if not name:
            raise ValueError(f"column {number} has no name")
        if name in names[number:]:
            raise ValueError(f"two columns are named {shown(name)}")
