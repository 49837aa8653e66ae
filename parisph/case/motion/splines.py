"""Smooth curves through points in time: values, rates and second derivatives.

Cubic splines join measured values; their second derivative is continuous. Quintic pieces join points at which the
first two derivatives are known.
"""

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from parisph.base.arrays import Floats

Law = tuple[float, float, float]    # value, rate and second derivative


class Cubic:
    """The cubic spline through (t, y) without knots at the second and the last but one time; n >= 4.

    Before the first and after the last time nothing changes any more.
    """

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

    def integral(self, t: float) -> float:
        """Return the integral from the first time to t."""
        k, h, a, b = self._place(min(max(t, self.t[0]), self.t[-1]))
        (y0, y1), (m0, m1) = self.y[k : k + 2], self.m[k : k + 2]
        cubes = m0 * ((1.0 - a**4) / 4.0 - (1.0 - a * a) / 2.0) + m1 * (b**4 / 4.0 - b * b / 2.0)
        return float(self.sums[k] + h * (0.5 * (1.0 - a * a) * y0 + 0.5 * b * b * y1) + h**3 / 6.0 * cubes)

    def _place(self, t: float) -> tuple[int, float, float, float]:
        k = min(int(np.searchsorted(self.t, t, side="right")) - 1, len(self.t) - 2)
        h = self.t[k + 1] - self.t[k]
        b = (t - self.t[k]) / h
        return k, h, 1.0 - b, b


@lru_cache(maxsize=8)
def cubic(times: tuple[float, ...], values: tuple[float, ...]) -> Cubic:
    """Return the Cubic of a series; one for each series."""
    return Cubic(times, values)


def second_derivatives(t: Floats, y: Floats) -> Floats:
    """Second derivatives (n,) at the knots of the not-a-knot cubic spline through (t, y), n >= 4."""
    h = np.diff(t)
    rhs = 6.0 * np.diff(np.diff(y) / h)
    diagonal = 2.0 * (h[:-1] + h[1:])
    lower, upper = h[:-1].copy(), h[1:].copy()
    # Not-a-knot: the third derivative is continuous at the second and the last but one knot. This
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
    diagonal, rhs = diagonal.copy(), rhs.copy()
    for k in range(1, len(rhs)):
        factor = lower[k] / diagonal[k - 1]
        diagonal[k] -= factor * upper[k - 1]
        rhs[k] -= factor * rhs[k - 1]
    for k in range(len(rhs) - 1, -1, -1):
        if k + 1 < len(rhs):
            rhs[k] -= upper[k] * rhs[k + 1]
        rhs[k] /= diagonal[k]
    return rhs


class Quintic:
    """Pieces of fifth degree between times at which value, rate and second derivative are given, (n,) each.

    Before the first and after the last time nothing changes any more.
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
        piece: Any = np.polynomial.Polynomial(
            [y0, v0, 0.5 * a0, 10.0 * d - 4.0 * e + 0.5 * f, -15.0 * d + 7.0 * e - f, 6.0 * d - 3.0 * e + 0.5 * f]
        )
        b = (t - self.t[k]) / h
        return piece(b), piece.deriv()(b) / h, piece.deriv(2)(b) / h**2


def rise(t: float, duration: float) -> tuple[float, float, float]:
    """Return a smooth step from 0 to 1 in `duration`, with its first two derivatives; 1 from the start if it is 0."""
    if t >= duration:
        return 1.0, 0.0, 0.0
    b = max(t, 0.0) / duration
    return (
        b**3 * (10.0 - 15.0 * b + 6.0 * b * b),
        30.0 * b * b * (1.0 - b) ** 2 / duration,
        60.0 * b * (1.0 - b) * (1.0 - 2.0 * b) / duration**2,
    )


def product(one: Law, other: Law) -> Law:
    """Return value, rate and second derivative of the product of two functions given by theirs."""
    (f, df, ddf), (g, dg, ddg) = one, other
    return f * g, df * g + f * dg, ddf * g + 2.0 * df * dg + f * ddg
