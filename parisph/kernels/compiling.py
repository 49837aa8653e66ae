"""What happens when numba compiles: no search for garbage, and a count for those who wait."""

import gc
from collections.abc import Callable
from time import perf_counter

from parisph.kernels.processor import numba


class Compilation(numba.core.event.Listener):
    """Stops Python's garbage collection while numba compiles: it takes a sixth of that time and finds little.

    Attributes
    ----------
    count, seconds : kernels that were compiled in this process, and how long that took; what a kernel calls is part
        of it
    before : called when the next one is about to be compiled, once
    """

    def __init__(self) -> None:
        self.count, self.seconds = 0, 0.0
        self.before: Callable[[], object] | None = None
        self._depth, self._was, self._began = 0, False, 0.0

    def on_start(self, event: numba.core.event.Event) -> None:
        """Begin, perhaps within another one."""
        if self._depth == 0:
            self._was, self._began = gc.isenabled(), perf_counter()
            gc.disable()
            before, self.before = self.before, None
            if before is not None:
                before()
        self._depth += 1

    def on_end(self, event: numba.core.event.Event) -> None:
        """End what on_start has begun."""
        self._depth -= 1
        if self._depth == 0:
            self.count += 1
            self.seconds += perf_counter() - self._began
            if self._was:
                gc.enable()
