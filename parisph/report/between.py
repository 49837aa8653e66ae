"""Replace the lines between two marks in a text file of the user; all other bytes stay. Not collective."""

import errno
import os
import re
from collections.abc import Sequence
from pathlib import Path

from parisph.base.errors import CaseError, StoreError
from parisph.base.paths import AnyPath, checked
from parisph.base.reading import read_exactly
from parisph.base.text import named
from parisph.io.files import failing_as, rewrite


class Between:
    """The place between a line `start` and a line `end` of a UTF-8 text file, checked before any work.

    path : pathlib.Path of the file, without links
    """

    def __init__(self, file: AnyPath, start: str, end: str, what: str) -> None:
        """file : as named by the user; what : name of the new lines, for messages

        Raises StoreError if the file is not regular, not UTF-8, or cannot be read or written; CaseError unless it has
        one line `start` with one line `end` below it.
        """
        self._file, self._marks, self._what = file, (start, end), what
        self.path = Path(os.path.realpath(checked(file, "FILE")))
        self._found()
        if not os.access(self.path, os.W_OK) or not os.access(self.path.parent, os.W_OK):
            raise StoreError(f"cannot write {named(file)}: permission denied for it or for its folder")

    def put(self, lines: Sequence[str]) -> None:
        """Replace the lines between the marks. Raises as __init__, and then changes nothing.

        lines : each may contain line breaks
        """
        before, newline, after = self._found()
        text = before + "".join(f"{line}{newline}" for part in lines for line in part.split("\n")) + after
        with failing_as(f"write {named(self._file)}"):
            rewrite(self.path, text)

    def _found(self) -> tuple[str, str, str]:
        """Return (text before the place, line break, text after the place)."""
        try:
            text = read_exactly(self.path)
        except OSError as error:
            hint = ": convert it first, for example Latin-1 with iconv -f LATIN1 -t UTF-8" * (
                error.errno == errno.EILSEQ and "UTF-8" in str(error.strerror))
            raise StoreError(f"cannot read {named(self._file)}: {error.strerror}{hint}") from None
        start, end = (list(re.finditer(rf"(?<![^\r\n\ufeff]){re.escape(mark)}[ \t]*(\r\n|\n|\r|\Z)", text))
                      for mark in self._marks)
        if len(start) != 1 or len(end) != 1 or start[0].end() > end[0].start():
            there = "the second line is above the first" if len(start) == len(end) == 1 else \
                f"it has {len(start)} and {len(end)} of these lines"
            raise CaseError(f"{named(self._file)} must have one line {self._marks[0]} and, below it, one line "
                            f"{self._marks[1]}: {self._what} goes between them; {there}")
        return text[:start[0].end()], start[0][1], text[end[0].start():]
