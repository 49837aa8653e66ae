"""Progress of a run, shown by rank 0."""

import sys
from time import perf_counter
from typing import TextIO

from parisph.base.log import logger
from parisph.driver.simulation import Simulation
from parisph.methods.reports import StepReport

TERMINAL, BATCH = 0.5, 15.0  # seconds between lines


class Progress:
    """One live line on a terminal; in a batch log plain lines, at growing intervals.

    Parameters
    ----------
    end_time : float [s]
    wanted : bool, False to be quiet
    first : bool, whether this is rank 0; other ranks show nothing
    """

    def __init__(self, end_time: float, wanted: bool, first: bool = True, stream: TextIO | None = None) -> None:
        self.end_time, self.stream, self.wanted = end_time, stream or sys.stderr, wanted
        self.shown = wanted and first
        self.live = self.shown and self.stream.isatty()
        self._began = self._last = perf_counter()
        self._first: float | None = None    # time [s] after the first step that is seen here
        self._steps = 0

    def step(self, simulation: Simulation, report: StepReport) -> None:
        """Show the progress after a step, if it is time for a new line. Not collective."""
        if not self.shown:
            return
        now = perf_counter()
        if self._first is None:
            self._first, self._steps = simulation.time, simulation.steps
        if now - self._last < (TERMINAL if self.live else min(BATCH, 2.0 + 0.1 * (now - self._began))):
            return
        self._last = now
        text = self._text(simulation, report, now - self._began)
        if self.live:
            self.stream.write(f"\r\x1b[2K{text}")
            self.stream.flush()
        else:
            logger.info(text)

    def close(self) -> None:
        """End the live line."""
        if self.live:
            self.stream.write("\r\x1b[2K")
            self.stream.flush()

    def _text(self, simulation: Simulation, report: StepReport, elapsed: float) -> str:
        done = simulation.time - (self._first or 0.0)
        left = _clock(max(self.end_time - simulation.time, 0.0) * elapsed / done) if done > 0.0 else "?"
        rate = (simulation.steps - self._steps) / elapsed
        return (f"t {simulation.time:.4g} of {self.end_time:.4g} s  dt {report.dt:.2e}  {rate:.1f} steps/s  "
                f"{report.words()}  {left} left")


def _clock(seconds: float) -> str:
    minutes, seconds = divmod(int(seconds + 0.5), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02d}:{seconds:02d}" if hours else f"{minutes}:{seconds:02d}"
