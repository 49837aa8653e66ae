"""The schedule of a run: simulated times at which something is due, and the steps that meet its end."""

import math
from collections.abc import Iterable

ROUNDED = 1.0 + 1e-12   # a time that is reached but for rounding is reached
ROUNDING = 1e-6         # of a step: what the sum of many steps may be off by
SHARING = 10            # steps before the end of a run


def step_towards(target: float, time: float, limit: float) -> tuple[float, float]:
    """Return a step of at most `limit` (or a thousandth more) on the way to `target`, and the time after it, all in s.

    The target is the end of the run. The last SHARING steps before it share the remaining time, and it is met exactly.
    So steps do not shorten by more than a tenth at once, unless fewer are left: what a step leaves of the divergence is
    proportional to its length, the next one takes that out, and its pressure jumps by a tenth where it is half as long.
    The result does not depend on earlier steps: a run that is restarted between these takes the same steps.
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
        """Return whether something has become due since the last call."""
        before = self.count
        self.skip(time)
        return self.count > before

    def skip(self, time: float) -> None:
        """Count everything up to `time` as done."""
        self.count = sum(t <= time * ROUNDED for t in self.times) + self._multiple(time)

    def after(self, time: float) -> float:
        """Return the first time [s] that is due after `time`, infinity if there is none."""
        found = [t for t in self.times if t > time * ROUNDED][:1]
        if self.every:
            found.append((self._multiple(time) + 1) * self.every)
        return min(found, default=math.inf)

    def between(self, start: float, end: float) -> list[float]:
        """Return the times [s] that are due after `start` and up to `end`, in order."""
        found, time = [], self.after(start)
        while time <= end * ROUNDED:
            found.append(time)
            time = self.after(time)
        return found

    def _multiple(self, time: float) -> int:
        return math.floor(time / self.every * ROUNDED) if self.every else 0
