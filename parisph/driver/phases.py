"""Timers for the phases of a step: wall time, as in `log.Timers`, and CPU time."""

from contextlib import contextmanager
from time import process_time

from parisph.base.log import Timers


class PhaseTimers(Timers):
    """Timers that also count CPU time.

    A rank that waits for others uses wall time; it depends on the MPI library whether it also uses
    CPU time.

    Attributes
    ----------
    cpu : dict of phase -> CPU seconds so far on this rank
    """

    def __init__(self):
        super().__init__()
        self.cpu = {}

    @contextmanager
    def __call__(self, phase):
        nested, start = phase in self._open, process_time()
        try:
            with super().__call__(phase):
                yield
        finally:
            if not nested:
                self.cpu[phase] = self.cpu.get(phase, 0.0) + process_time() - start

    def reduce_cpu(self, comm):
        """Return {phase: CPU seconds of all ranks together}, the same on all. Collective."""
        total = {}
        for mine in comm.allgather(self.cpu):
            for name, seconds in mine.items():
                total[name] = total.get(name, 0.0) + seconds
        return total
