"""Read text files from outside: regular files of limited size, with text in them. Not collective."""

import csv
import errno
import math
import os
import stat
from collections.abc import Sequence

from parisph.base.memory import amount
from parisph.base.paths import AnyPath
from parisph.base.text import clipped, named, shown

MOST = 16 * 10**6    # bytes of a file that is read


def read_text(path: AnyPath, most: float = MOST) -> str:
    """Return the text of a UTF-8 file, without a byte order mark.

    most : number of bytes that the file may have, math.inf for any (a file that parisph itself wrote)

    Raises
    ------
    OSError, whose strerror is one line: the file does not exist, is a folder, a pipe or a device (which is not
    opened), has more than `most` bytes, or is not text.
    """
    return read_exactly(path, most).removeprefix("\ufeff")


def read_exactly(path: AnyPath, most: float = MOST) -> str:
    """Return the text of a UTF-8 file as `read_text`, with its byte order mark if it has one: all that must be kept."""
    try:
        check_regular(os.stat(path), most)
        with open(os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0)), "rb") as file:
            check_regular(os.fstat(file.fileno()), most)    # it may be another one by now
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
    """Return (names, lines) of a CSV file with one header line: names of its columns, and {line number: cells}.

    Lines that begin with '#' and empty lines are left out.

    Raises
    ------
    OSError as read_text. ValueError, one line that shows little of the file: there is no header, a column has no name
    or that of another one, or a line has too few or too many cells.
    """
    names: list[str] = []
    lines: dict[int, list[str]] = {}
    for number, row in enumerate(read_text(path).splitlines(), 1):
        if not row.strip() or row.startswith("#"):
            continue
        cells = [cell.strip() for cell in _cells(row, number)]
        if not names:
            _check_names(cells)
            names = cells
        elif len(cells) != len(names):
            raise ValueError(f"line {number} has {len(cells)} values, and there are {len(names)} columns")
        else:
            lines[number] = cells
    if not names:
        raise ValueError("it has no line with the names of columns")
    return names, lines


def listed(names: Sequence[str]) -> str:
    """Return a few names of columns for a message; not all, because the file may contain anything."""
    return clipped(", ".join(named(name) for name in names[:9]) + ", ..." * (len(names) > 9)) or "none"


def check_regular(status: os.stat_result, most: float = math.inf) -> None:
    """Raise OSError unless the os.stat of a path is that of a regular file of at most `most` bytes.

    To open others may wait forever.
    """
    if stat.S_ISDIR(status.st_mode):
        raise OSError(errno.EISDIR, "it is a folder")
    if not stat.S_ISREG(status.st_mode):
        raise OSError(errno.EINVAL, "it is not a regular file")
    if status.st_size > most:
        raise OSError(errno.EFBIG, f"it has {amount(status.st_size)}, at most {amount(most)} are read")


def _cells(row: str, number: int) -> list[str]:
    try:
        return next(csv.reader([row], strict=True))
    except csv.Error as error:
        raise ValueError(f"line {number} is not one of a CSV file ({error})") from None


def _check_names(names: Sequence[str]) -> None:
    for number, name in enumerate(names, 1):
        if not name:
            raise ValueError(f"column {number} has no name")
        if name in names[number:]:
            raise ValueError(f"two columns are named {shown(name)}")
