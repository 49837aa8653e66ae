"""Hooks into numba's compilation: pause the garbage collector, count kernels, announce a wait."""

import gc
from collections.abc import Callable
from time import perf_counter

from parisph.kernels.processor import numba


class Compilation(numba.core.event.Listener):
    """Pauses Python's garbage collector while numba compiles, where it takes a sixth of the time and frees little.

    Attributes
    ----------
    count, seconds : kernels compiled in this process, including the functions they call, and the time taken
    before : called once, before the next compilation
    """

    def __init__(self) -> None:
        self.count, self.seconds = 0, 0.0
        self.before: Callable[[], object] | None = None
        self._depth, self._was, self._began = 0, False, 0.0

    def on_start(self, event: numba.core.event.Event) -> None:
        """Start a compilation, perhaps nested in another."""
        if self._depth == 0:
            self._was, self._began = gc.isenabled(), perf_counter()
            gc.disable()
            before, self.before = self.before, None
            if before is not None:
                before()
        self._depth += 1

    def on_end(self, event: numba.core.event.Event) -> None:
        """Finish a compilation."""
        self._depth -= 1
        if self._depth == 0:
            self.count += 1
            self.seconds += perf_counter() - self._began
            if self._was:
                gc.enable()
