"""Smooth curves through points in time: values, rates and second derivatives.

Cubic splines join measured values, with continuous second derivatives. Quintic pieces join points with known ones.
"""

from collections import deque
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from parisph.base.arrays import Floats

Law = tuple[float, float, float]    # value, rate and second derivative
Values = Sequence[float]


class CubicSpline:
    """The not-a-knot cubic spline through (t, y), n >= 4; constant before the first and after the last time."""

    def __init__(self, t: ArrayLike, y: ArrayLike) -> None:
        self.t, self.y = np.asarray(t, dtype=float), np.asarray(y, dtype=float)
        self.m = second_derivatives(self.t, self.y)
        h = np.diff(self.t)
        # the integral up to each knot
        self.sums = np.concatenate(
            [[0.0], np.cumsum(0.5 * h * (self.y[1:] + self.y[:-1]) - h**3 / 24.0 * (self.m[1:] + self.m[:-1]))]
        )

    def at(self, t: float) -> tuple[float, float, float]:
        """Return value, rate and second derivative at t."""
        if t < self.t[0] or t > self.t[-1]:
            return (self.y[0] if t < self.t[0] else self.y[-1]), 0.0, 0.0
        k, h, a, b = self._place(t)
        y, m = self.y[k : k + 2], self.m[k : k + 2]
        value = a * y[0] + b * y[1] + ((a**3 - a) * m[0] + (b**3 - b) * m[1]) * h * h / 6.0
        slope = (y[1] - y[0]) / h + ((3 * b * b - 1) * m[1] - (3 * a * a - 1) * m[0]) * h / 6.0
        return value, slope, a * m[0] + b * m[1]

    def values(self, t: Floats) -> Floats:
        """Return the values (n,) at times (n,)."""
        t = np.clip(t, self.t[0], self.t[-1])
        k, h, a, b = self._places(t)
        bend = (a**3 - a) * self.m[k] + (b**3 - b) * self.m[k + 1]
        found: Floats = a * self.y[k] + b * self.y[k + 1] + bend * h * h / 6.0
        return found

    def integrals(self, t: Floats) -> Floats:
        """Return the integrals (n,) from the first time to times (n,)."""
        k, h, a, b = self._places(np.clip(t, self.t[0], self.t[-1]))
        cubes = self.m[k] * ((1.0 - a**4) / 4.0 - (1.0 - a * a) / 2.0) + self.m[k + 1] * (b**4 / 4.0 - b * b / 2.0)
        lines = 0.5 * (1.0 - a * a) * self.y[k] + 0.5 * b * b * self.y[k + 1]
        found: Floats = self.sums[k] + h * lines + h**3 / 6.0 * cubes
        return found

    def _place(self, t: float) -> tuple[int, float, float, float]:
        k = min(int(np.searchsorted(self.t, t, side="right")) - 1, len(self.t) - 2)
        h = self.t[k + 1] - self.t[k]
        b = (t - self.t[k]) / h
        return k, h, 1.0 - b, b

    def _places(self, t: Floats) -> tuple[NDArray[np.intp], Floats, Floats, Floats]:
        k = np.minimum(np.searchsorted(self.t, t, side="right") - 1, len(self.t) - 2)
        h = self.t[k + 1] - self.t[k]
        b = (t - self.t[k]) / h
        return k, h, 1.0 - b, b


class Curves:
    """The CubicSplines of the last series, by identity of the tuples.

    Hashing or comparing long tuples would take longer than the evaluation of the spline.
    """

    def __init__(self, most: int) -> None:
        self._kept: deque[tuple[Values, Values, CubicSpline]] = deque(maxlen=most)

    def of(self, times: Values, values: Values) -> CubicSpline:
        """Return the CubicSpline of a series."""
        for own_times, own_values, curve in self._kept:
            if own_times is times and own_values is values:
                return curve
        curve = CubicSpline(times, values)
        self._kept.append((times, values, curve))
        return curve


cubic = Curves(most=8).of


def second_derivatives(t: Floats, y: Floats) -> Floats:
    """Return the second derivatives (n,) at the knots of the not-a-knot cubic spline through (t, y), n >= 4."""
    h = np.diff(t)
    rhs = 6.0 * np.diff(np.diff(y) / h)
    diagonal = 2.0 * (h[:-1] + h[1:])
    lower, upper = h[:-1].copy(), h[1:].copy()
    # Not-a-knot: the third derivative is continuous at the second and the second to last knot. This
    # gives the outer unknowns as combinations of their two neighbours, put into the outer rows.
    diagonal[0] += h[0] * (h[0] + h[1]) / h[1]
    upper[0] -= h[0] ** 2 / h[1]
    diagonal[-1] += h[-1] * (h[-1] + h[-2]) / h[-2]
    lower[-1] -= h[-1] ** 2 / h[-2]
    inner = _solve_tridiagonal(lower, diagonal, upper, rhs)
    first = ((h[0] + h[1]) * inner[0] - h[0] * inner[1]) / h[1]
    last = ((h[-1] + h[-2]) * inner[-1] - h[-1] * inner[-2]) / h[-2]
    return np.concatenate([[first], inner, [last]])


def _solve_tridiagonal(lower: Floats, diagonal: Floats, upper: Floats, rhs: Floats) -> Floats:
    """Solve by elimination; lower[0] and upper[-1] are not used."""
    a, d, b, x = lower.tolist(), diagonal.tolist(), upper.tolist(), rhs.tolist()    # faster as Python numbers
    for k in range(1, len(x)):
        factor = a[k] / d[k - 1]
        d[k] -= factor * b[k - 1]
        x[k] -= factor * x[k - 1]
    x[-1] /= d[-1]
    for k in range(len(x) - 2, -1, -1):
        x[k] = (x[k] - b[k] * x[k + 1]) / d[k]
    return np.array(x)


class Quintic:
    """Quintic pieces between times with given value, rate and second derivative, (n,) each.

    Constant before the first and after the last time.
    """

    def __init__(self, t: Floats, y: Floats, rate: Floats, second: Floats) -> None:
        self.t, self.points = t, np.stack([y, rate, second], axis=1)

    def at(self, t: float) -> tuple[float, float, float]:
        """Return value, rate and second derivative at t."""
        if t < self.t[0] or t > self.t[-1]:
            return self.points[0 if t < self.t[0] else -1, 0], 0.0, 0.0
        k = min(int(np.searchsorted(self.t, t, side="right")) - 1, len(self.t) - 2)
        h = self.t[k + 1] - self.t[k]
        (y0, v0, a0), (y1, v1, a1) = self.points[k] * (1.0, h, h * h), self.points[k + 1] * (1.0, h, h * h)
        d, e, f = y1 - y0 - v0 - 0.5 * a0, v1 - v0 - a0, a1 - a0
        g, i, j = 10.0 * d - 4.0 * e + 0.5 * f, -15.0 * d + 7.0 * e - f, 6.0 * d - 3.0 * e + 0.5 * f
        b = (t - self.t[k]) / h
        return (
            float(y0 + b * (v0 + b * (0.5 * a0 + b * (g + b * (i + b * j))))),
            float(v0 + b * (a0 + b * (3.0 * g + b * (4.0 * i + b * 5.0 * j)))) / h,
            float(a0 + b * (6.0 * g + b * (12.0 * i + b * 20.0 * j))) / h**2,
        )


def rise(t: float, duration: float) -> tuple[float, float, float]:
    """Return a smooth step from 0 to 1 in `duration`, with its first two derivatives; 1 if the duration is 0."""
    if t >= duration:
        return 1.0, 0.0, 0.0
    b = max(t, 0.0) / duration
    return (
        b**3 * (10.0 - 15.0 * b + 6.0 * b * b),
        30.0 * b * b * (1.0 - b) ** 2 / duration,
        60.0 * b * (1.0 - b) * (1.0 - 2.0 * b) / duration**2,
    )


def product(one: Law, other: Law) -> Law:
    """Return value, rate and second derivative of the product of two functions."""
    (f, df, ddf), (g, dg, ddg) = one, other
    return f * g, df * g + f * dg, ddf * g + 2.0 * df * dg + f * ddg
