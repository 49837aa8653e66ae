"""Progress of long work: a line that is rewritten on a terminal, else plain lines at growing intervals."""

import sys
from collections.abc import Callable
from time import perf_counter
from typing import TextIO

TERMINAL, BATCH = 0.5, 15.0  # seconds between lines


class LiveLine:
    """One live line on a terminal; in a batch log plain lines, the first after two seconds.

    shown : whether to show anything
    say : function that shows a plain line; by default it is printed to the stream
    stream : standard error by default; now : function that returns a time [s], a clock by default
    """

    def __init__(self, shown: bool, say: Callable[[str], None] | None = None, stream: TextIO | None = None,
                 now: Callable[[], float] | None = None) -> None:
        self.stream, self._say, self._now = stream or sys.stderr, say, now or perf_counter
        self.shown, self._live = shown, shown and self.stream.isatty()
        self.begin()

    def begin(self) -> None:
        """Start the clock."""
        self._began = self._last = self._now()

    def due(self) -> bool:
        """Return whether it is time for a new line, which the caller then shows."""
        now = self._now()
        if not self.shown or now - self._last < (TERMINAL if self._live else min(BATCH, 2.0 + 0.1 * self.elapsed)):
            return False
        self._last = now
        return True

    @property
    def elapsed(self) -> float:
        """Seconds since the start."""
        return self._now() - self._began

    def show(self, text: str) -> None:
        """Show a line."""
        if self._live:
            self.stream.write(f"\r\x1b[2K{text}")
            self.stream.flush()
        elif self._say is not None:
            self._say(text)
        else:
            print(text, file=self.stream, flush=True)

    def close(self) -> None:
        """End the live line."""
        if self._live:
            self.stream.write("\r\x1b[2K")
            self.stream.flush()


def clock(seconds: float) -> str:
    """Return a duration [s] as 0:05 or 1:02:03."""
    minutes, seconds = divmod(int(seconds + 0.5), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02d}:{seconds:02d}" if hours else f"{minutes}:{seconds:02d}"
