"""Timers for the phases of a step: wall time, as in `log.Timers`, and CPU time."""

from collections.abc import Iterator
from contextlib import contextmanager
from time import process_time

from parisph.base.communicator import Communicator
from parisph.base.log import Timers


class PhaseTimers(Timers):
    """Timers that also count CPU time.

    A rank that waits for others uses wall time; it depends on the MPI library whether it also uses
    CPU time.

    Attributes
    ----------
    cpu : dict of phase -> CPU seconds so far on this rank
    """

    def __init__(self) -> None:
        super().__init__()
        self.cpu: dict[str, float] = {}

    @contextmanager
    def __call__(self, phase: str) -> Iterator[None]:
        nested, start = phase in self._open, process_time()
        try:
            with super().__call__(phase):
                yield
        finally:
            if not nested:
                self.cpu[phase] = self.cpu.get(phase, 0.0) + process_time() - start

    def reduce_cpu(self, comm: Communicator) -> dict[str, float]:
        """Return {phase: CPU seconds of all ranks together}, the same on all. Collective."""
        total: dict[str, float] = {}
        for mine in comm.allgather(self.cpu):
            for name, seconds in mine.items():
                total[name] = total.get(name, 0.0) + seconds
        return total
