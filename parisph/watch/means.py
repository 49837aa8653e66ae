"""Means of pressures in time that keep their integral."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from parisph.base.arrays import Floats

ROUNDED = 1.0 - 1e-9    # factor of the least distance of knots, against rounding

Point = tuple[float, Floats]                # time [s], values (n,)
Step = tuple[float, float, Floats]          # start and end [s], values (n,)


class Means:
    """A piecewise linear function of time with the same integral as the pressures of the steps. Not collective.

    A pressure p acts from the start of its step to the end. The knots of the line are middles of steps, about a window
    apart. At a knot the line is the mean of p weighted by the hat function f of the knot, which is 1 there and 0 at the
    knots beside it: integral f p dt / integral f dt. The hat functions add up to 1. So the line has the integral of p
    for any distance of knots, and equals p where p is constant. The trapezoidal rule over middles of steps is exact.

    A mean is known when the next knot is. The line begins at the pressure of the start. At the first and the last knot
    it is the pressure of the step. Values are pressures at n places, or linear functions of these.

    time, values : of the start [s], (n,)
    end : None for the start of a run; if the values are those of a step, its end [s], with its middle as `time`
    """

    def __init__(self, time: float, values: Floats | Sequence[float], end: float | None = None) -> None:
        own = np.array(values, float)
        self._line: list[Point] = [(time, own)]         # the last two points of the line that are known
        self._acted: list[Point] = [(time, own)]        # middles and values of steps from these on
        self._knots = [] if end is None else [time]     # the last that is known, and the next if there is one
        self._steps: list[Step] = [] if end is None else [(time, end, own)]    # that act after that knot

    def add(self, start: float, end: float, middle: float, values: Floats | Sequence[float], window: float) -> None:
        """Add the step from `start` to `end` [s], with its middle [s] and values (n,).

        window : distance of knots [s], to half a step
        """
        own = np.array(values, float)
        self._steps.append((start, end, own))
        self._acted.append((middle, own))
        if not self._knots:
            self._line.append((middle, own))
        elif middle - self._knots[-1] < ROUNDED * (window - 0.5 * (end - start)):
            return
        self._knots.append(middle)
        if len(self._knots) == 3:
            self._line = [self._line[-1], (self._knots[1], self._mean(*self._knots))]
            self._knots.pop(0)
            self._forget()

    @property
    def known(self) -> float:
        """Time [s] up to which the line is known."""
        return self._line[-1][0]

    @property
    def knots(self) -> list[float]:
        """Times [s] of the last known knot and of the one after it, if there is one."""
        return self._knots

    def at(self, time: float, ended: bool = False) -> tuple[Floats, Floats]:
        """Return the line (n,) at a known time [s], and the values (n,) that acted, interpolated between middles.

        ended : whether there is no further step, so that all of the line is known
        """
        return between([*self._line, *(self._last() if ended else ())], time), between(self._acted, time)

    def state(self) -> dict[str, Any]:
        """Return the content for a checkpoint, see `resumed`."""
        return {"line": self._line, "knots": self._knots, "acted": self._acted, "steps": self._steps}

    @classmethod
    def resumed(cls, state: Mapping[str, Any]) -> "Means":
        """Return the Means with this state."""
        found = cls.__new__(cls)
        found._line, found._acted = ([(time, np.array(values, float)) for time, values in state[name]]
                                     for name in ("line", "acted"))
        found._steps = [(start, end, np.array(values, float)) for start, end, values in state["steps"]]
        found._knots = list(state["knots"])
        return found

    def _mean(self, before: float, knot: float, behind: float) -> Floats:
        """Return the mean (n,) at a knot between two others."""
        found = np.zeros_like(self._line[-1][1])
        for start, end, values in self._steps:
            weight = _hat(end, before, knot, behind) - _hat(start, before, knot, behind)
            if weight > 0.0:    # other values may be nan
                found += weight * values
        return found / (0.5 * (behind - before))

    def _last(self) -> list[Point]:
        """Return the points of the line after the known ones, without a further step."""
        last, found = self._acted[-1], list[Point]()
        if len(self._knots) == 2 and last[0] > self._knots[1]:
            found = [(self._knots[1], self._mean(self._knots[0], self._knots[1], last[0]))]
        return [*found, last] if last[0] > self._line[-1][0] else found

    def _forget(self) -> None:
        """Forget steps before the last known knot, and values before the known part of the line."""
        self._steps = [step for step in self._steps if step[1] > self._knots[0]]
        while len(self._acted) > 1 and self._acted[1][0] <= self._line[0][0]:
            self._acted.pop(0)


def _hat(time: float, before: float, knot: float, behind: float) -> float:
    """Return the integral up to a time of the hat function of a knot between two others [s]."""
    if time <= knot:
        return 0.5 * max(time - before, 0.0) ** 2 / (knot - before)
    return 0.5 * (behind - before) - 0.5 * max(behind - time, 0.0) ** 2 / (behind - knot)


def between(points: Sequence[Point], time: float) -> Floats:
    """Return the values at a time by linear interpolation, outside the points those of the ends.

    If one of two values is nan, the nearer one counts.
    """
    for (before, a), (behind, b) in zip(points, points[1:]):
        if time < behind:
            share = max((time - before) / (behind - before), 0.0)
            return np.where(np.isfinite(a + b), a + share * (b - a), a if share < 0.5 else b)
    return points[-1][1]
