"""The schedule of a run: simulated times of output, and the steps that meet its end."""

import math
from collections.abc import Iterable

ROUNDED = 1.0 + 1e-12   # tolerance of times
ROUNDING = 1e-6         # of a step: error of the sum of many steps
SHARING = 10            # steps before the end of a run


def step_towards(target: float, time: float, limit: float) -> tuple[float, float]:
    """Return a step [s] towards `target` of at most `limit` (or a thousandth more), and the time [s] after it.

    The last SHARING steps before the target, the end of the run, share the remaining time and meet it exactly. So steps
    shorten by at most a tenth at once, unless fewer are left. The divergence that a step leaves is proportional to its
    length, and the next step removes it: after a step of half the length, the pressure would jump by a tenth.
    The result does not depend on earlier steps: a restart between these takes the same steps.
    """
    left = target - time
    if not 0.0 < left <= SHARING * limit:
        return limit, time + limit
    steps = max(1, math.ceil(left / limit - 1e-3))
    dt = left / steps
    if abs(dt - limit) < ROUNDING * limit:
        dt = limit
    return dt, target if steps == 1 else time + dt


class Times:
    """Times at which something is due: at a fixed interval, and at given times [s]."""

    def __init__(self, every: float | None, times: Iterable[float] = ()) -> None:
        self.every, self.times, self.count = every, sorted(times), 0

    def due(self, time: float) -> bool:
        """Return whether a time has become due since the last call."""
        before = self.count
        self.skip(time)
        return self.count > before

    def skip(self, time: float) -> None:
        """Count all times up to `time` [s] as done."""
        self.count = sum(t <= time * ROUNDED for t in self.times) + self._multiple(time)

    def after(self, time: float) -> float:
        """Return the first due time [s] after `time` [s], or infinity."""
        found = [t for t in self.times if t > time * ROUNDED][:1]
        if self.every:
            found.append((self._multiple(time) + 1) * self.every)
        return min(found, default=math.inf)

    def between(self, start: float, end: float) -> list[float]:
        """Return the due times [s] after `start` up to `end` [s], in order."""
        found, time = [], self.after(start)
        while time <= end * ROUNDED:
            found.append(time)
            time = self.after(time)
        return found

    def _multiple(self, time: float) -> int:
        return math.floor(time / self.every * ROUNDED) if self.every else 0
