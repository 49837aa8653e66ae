"""Progress of a run, shown by rank 0."""

from collections import deque
from time import perf_counter
from typing import TextIO

from parisph.base.live_line import LiveLine, clock
from parisph.base.log import logger
from parisph.driver.simulation import Simulation
from parisph.kernels import jit, kept
from parisph.methods.reports import StepReport

FEW = 20         # compiled kernels: with fewer, nearly all of the hundred need compilation
STEPS, SECONDS, LONG = 10, 1.0, 30.0    # a rate needs this many steps and [s], or this many [s] alone


class Progress:
    """One live line on a terminal; in a batch log plain lines, at growing intervals.

    Inside `with`, a line announces a compilation of kernels. After the first step, another one gives its duration.

    end_time : float [s]
    wanted : bool, False to be quiet
    first : bool, whether this is rank 0; other ranks show nothing
    """

    def __init__(self, end_time: float, wanted: bool, first: bool = True, stream: TextIO | None = None) -> None:
        self.end_time, self.wanted = end_time, wanted
        self._line = LiveLine(wanted and first, logger.info, stream, _now)    # begins after the first step
        self._compiled: tuple[int, float] | None = None    # kernels, and their seconds, before this run
        # [s] since the first step, time of the flow [s], steps; at intervals
        self._marks: deque[tuple[float, float, int]] = deque()

    def __enter__(self) -> "Progress":
        if self._line.shown:
            jit.COMPILATION.before = self._compiling
        return self

    def __exit__(self, *error: object) -> None:
        jit.COMPILATION.before = None

    def step(self, simulation: Simulation, report: StepReport) -> None:
        """Show the progress after a step, if a new line is due. Not collective."""
        if not self._line.shown:
            return
        if not self._marks:
            self._after_compiling()
            self._line.begin()
            self._marks.append((0.0, simulation.time, simulation.steps))
        if self._line.due():
            self._line.show(self._text(simulation, report, self._line.elapsed))

    def close(self) -> None:
        """End the live line."""
        self._line.close()

    def _compiling(self) -> None:
        compilation = jit.COMPILATION
        self._compiled = compilation.count, compilation.seconds
        where = f" (kept in {jit.FOLDERS.write})" if jit.FOLDERS.write else ""
        if kept.state(jit.FOLDERS)["kernels"] < FEW:
            text = f"compiling kernels, about a minute, once for each machine and version of parisph{where}"
        else:
            text = f"compiling further kernels{where}"
        if logger.handlers:
            logger.info(text)
        else:
            print(text, file=self._line.stream, flush=True)

    def _after_compiling(self) -> None:
        if self._compiled is not None:
            count, seconds = jit.COMPILATION.count - self._compiled[0], jit.COMPILATION.seconds - self._compiled[1]
            logger.info(f"compiled {count} kernel{'s' * (count != 1)} in {seconds:.1f} s")

    def _text(self, simulation: Simulation, report: StepReport, elapsed: float) -> str:
        """Return the line, with rate and remaining time once they are known.

        They follow from the second half of the steps so far: the first ones may be shorter, or cost more.
        """
        while len(self._marks) > 1 and self._marks[1][0] <= 0.5 * elapsed:
            self._marks.popleft()
        then, time, steps = self._marks[0]
        if elapsed - self._marks[-1][0] > 0.02 * elapsed:
            self._marks.append((elapsed, simulation.time, simulation.steps))
        rate = left = ""
        count, seconds = simulation.steps - steps, elapsed - then
        if ((count >= STEPS and seconds >= SECONDS) or seconds >= LONG) and simulation.time > time:
            rate = f"{count / seconds:.{1 if count >= seconds else 2}f} steps/s  "
            speed = (simulation.time - time) / seconds
            left = f"  {clock(max(self.end_time - simulation.time, 0.0) / speed)} left"
        return f"t {simulation.time:.4g} of {self.end_time:.4g} s  dt {report.dt:.2e}  {rate}{report.words()}{left}"


def _now() -> float:
    """Return a time [s] without the compilation of kernels."""
    return perf_counter() - jit.COMPILATION.seconds
