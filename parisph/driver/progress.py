"""Progress of a run, shown by rank 0."""

from typing import TextIO

from parisph.base.live_line import LiveLine, clock
from parisph.base.log import logger
from parisph.driver.simulation import Simulation
from parisph.methods.reports import StepReport


class Progress:
    """One live line on a terminal; in a batch log plain lines, at growing intervals.

    Parameters
    ----------
    end_time : float [s]
    wanted : bool, False to be quiet
    first : bool, whether this is rank 0; other ranks show nothing
    """

    def __init__(self, end_time: float, wanted: bool, first: bool = True, stream: TextIO | None = None) -> None:
        self.end_time, self.wanted = end_time, wanted
        self._line = LiveLine(wanted and first, logger.info, stream)
        self.shown, self.live = self._line.shown, self._line.live
        self._first: float | None = None    # time [s] after the first step that is seen here
        self._steps = 0

    def step(self, simulation: Simulation, report: StepReport) -> None:
        """Show the progress after a step, if it is time for a new line. Not collective."""
        if not self.shown:
            return
        if self._first is None:
            self._first, self._steps = simulation.time, simulation.steps
        if self._line.due():
            self._line.show(self._text(simulation, report, self._line.elapsed))

    def close(self) -> None:
        """End the live line."""
        self._line.close()

    def _text(self, simulation: Simulation, report: StepReport, elapsed: float) -> str:
        done = simulation.time - (self._first or 0.0)
        left = clock(max(self.end_time - simulation.time, 0.0) * elapsed / done) if done > 0.0 else "?"
        rate = (simulation.steps - self._steps) / elapsed
        return (f"t {simulation.time:.4g} of {self.end_time:.4g} s  dt {report.dt:.2e}  {rate:.1f} steps/s  "
                f"{report.words()}  {left} left")
