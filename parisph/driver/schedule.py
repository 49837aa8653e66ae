"""When a run has something to do: at simulated times, and when it is told to stop."""

import signal

import numpy as np


class Times:
    """When something is due: every so often, and at given times [s]."""

    def __init__(self, every, times=()):
        self.every, self.times, self.count = every, sorted(times), 0

    def due(self, time):
        """Return whether a time has been reached since it was asked last."""
        before = self.count
        self.skip(time)
        return self.count > before

    def skip(self, time):
        """Count everything up to `time` as done."""
        self.count = sum(t <= time for t in self.times)
        if self.every:
            self.count += int(np.floor(time / self.every * (1.0 + 1e-12)))


class Signals:
    """Ctrl-C, SIGTERM and SIGUSR1 ask the run to finish its step; a second one ends it at once.

    SIGUSR1, because mpirun hands it on and leaves the run alone, whereas after a SIGINT or
    SIGTERM it kills the ranks within a second or so, finished or not.

    Attributes
    ----------
    seen : number of the signal that has come to this rank, or None
    """

    NUMBERS = (signal.SIGINT, signal.SIGTERM, signal.SIGUSR1)

    def __enter__(self):
        self.seen = None
        self._old = {}
        for number in self.NUMBERS:
            try:
                self._old[number] = signal.signal(number, self._handle)
            except ValueError:  # not in the main thread (a notebook's worker): leave signals alone
                break
        return self

    def _handle(self, number, frame):
        if self.seen:
            raise KeyboardInterrupt
        self.seen = number

    def __exit__(self, *_):
        for number, handler in self._old.items():
            signal.signal(number, handler)
