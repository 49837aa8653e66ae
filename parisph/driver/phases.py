"""Timers for the phases of a step: wall time, as in `log.Timers`, and CPU time."""

from time import process_time

from parisph.base.communicator import Communicator
from parisph.base.log import Timers


class PhaseTimers(Timers):
    """Timers that also count CPU time.

    A rank that waits for others uses wall time; it depends on the MPI library whether it also uses
    CPU time.

    cpu : dict of phase -> CPU seconds so far on this rank
    """

    def __init__(self) -> None:
        super().__init__()
        self.cpu: dict[str, float] = {}

    def now(self) -> tuple[float, ...]:
        """Return what the clocks show [s]: wall time and CPU time."""
        return *super().now(), process_time()

    def count(self, phase: str, start: tuple[float, ...]) -> None:
        """Add to a phase what has passed since the clocks showed `start`."""
        super().count(phase, start)
        self.cpu[phase] = self.cpu.get(phase, 0.0) + process_time() - start[1]

    def reduce_cpu(self, comm: Communicator) -> dict[str, float]:
        """Return {phase: CPU seconds of all ranks together}, the same on all. Collective."""
        total: dict[str, float] = {}
        for mine in comm.allgather(self.cpu):
            for name, seconds in mine.items():
                total[name] = total.get(name, 0.0) + seconds
        return total
