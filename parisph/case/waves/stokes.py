"""Stokes waves up to the fifth order.

Fenton (1985), A fifth-order Stokes theory for steady waves, J. Waterway Port Coast. Ocean Eng. 111(2), 216-234. A test
of the coefficients: residuals of the surface conditions fall with the sixth power of the steepness.
"""

from collections.abc import Callable
from functools import lru_cache
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, model_validator

from parisph.base.arrays import Floats
from parisph.case.waves.linear import wave_number
from parisph.case.waves.wavefield import (
    Depth,
    Gravity,
    Height,
    Leftward,
    Period,
    Place,
    Travelling,
    no_higher,
    steepest,
)

Terms = dict[tuple[int, int], float]    # coefficients of order and harmonic


def _coefficients(kd: float) -> tuple[Terms, Terms, dict[int, float]]:
    """Return A and B {(order, harmonic): value} and C {order: value} at a relative depth kd (Fenton 1985, Table 1)."""
    S = 1.0 / np.cosh(2.0 * kd)
    sinh, coth = np.sinh(kd), 1.0 / np.tanh(kd)
    P: Callable[..., Any] = np.polynomial.polynomial.polyval
    a, b, c = 1.0 - S, 3.0 + 2.0 * S, 4.0 + S
    A = {
        (1, 1): 1.0 / sinh,
        (2, 2): 3.0 * S**2 / (2.0 * a**2),
        (3, 1): P(S, (-4, -20, 10, -13)) / (8.0 * sinh * a**3),
        (3, 3): P(S, (0, 0, -2, 11)) / (8.0 * sinh * a**3),
        (4, 2): P(S, (0, 12, -14, -264, -45, -13)) / (24.0 * a**5),
        (4, 4): P(S, (0, 0, 0, 10, -174, 291, 278)) / (48.0 * b * a**5),
        (5, 1): P(S, (-1184, 32, 13232, 21712, 20940, 12554, -500, -3341, -670)) / (64.0 * sinh * b * c * a**6),
        (5, 3): P(S, (0, 4, 105, 198, -1376, -1302, -117, 58)) / (32.0 * sinh * b * a**6),
        (5, 5): P(S, (0, 0, 0, -6, 272, -1552, 852, 2029, 430)) / (64.0 * sinh * b * c * a**6),
    }
    B31 = -3.0 * P(S, (1, 3, 3, 2)) / (8.0 * a**3)
    B53 = 9.0 * P(S, (132, 17, -2216, -5897, -6292, -2687, 194, 467, 82)) / (128.0 * b * c * a**6)
    B55 = 5.0 * P(S, (300, 1579, 3176, 2949, 1188, 675, 1326, 827, 130)) / (384.0 * b * c * a**6)
    B = {
        (1, 1): 1.0,
        (2, 2): coth * P(S, (1, 2)) / (2.0 * a),
        (3, 1): B31,
        (3, 3): -B31,
        (4, 2): coth * P(S, (6, -26, -182, -204, -25, 26)) / (6.0 * b * a**4),
        (4, 4): coth * P(S, (24, 92, 122, 66, 67, 34)) / (24.0 * b * a**4),
        (5, 1): -(B53 + B55),
        (5, 3): B53,
        (5, 5): B55,
    }
    C0 = np.sqrt(np.tanh(kd))
    C = {0: C0, 2: C0 * P(S, (2, 0, 7)) / (4.0 * a**2), 4: C0 * P(S, (4, 32, -116, -400, -71, 146)) / (32.0 * a**5)}
    return A, B, C


def _speed(k: float, height: float, depth: float, g: float, order: int) -> float:
    """Return the celerity [m/s] without a mean Eulerian current, to the given order."""
    terms = _coefficients(k * depth)[2]
    return float(np.sqrt(g / k) * sum(value * (0.5 * k * height) ** n for n, value in terms.items() if n < order))


@lru_cache(maxsize=64)
def _wave_number(height: float, period: float, depth: float, g: float, order: int) -> float:
    """Return k [1/m] of a wave of a given period [s], by the secant method from linear theory."""

    def excess(k: float) -> float:
        return k * _speed(k, height, depth, g, order) * period / (2.0 * np.pi) - 1.0

    k = float(wave_number(2.0 * np.pi / period, depth, g))
    last, k = k, 0.98 * k
    for _ in range(60):
        here, before = excess(k), excess(last)
        if here == before or abs(k - last) <= 1e-14 * k:
            break
        last, k = k, float(np.clip(k - here * (k - last) / (here - before), 0.5 * k, 2.0 * k))
    return k


@lru_cache(maxsize=64)
def _harmonics(k: float, height: float, depth: float, g: float, order: int) -> tuple[Floats, Floats]:
    """Return amplitudes of harmonics 1 to 5: of elevation [m], and of velocity over cosh and sinh of n k y [m/s]."""
    A, B, C = _coefficients(k * depth)
    steepness, n = 0.5 * k * height, np.arange(1, 6)
    eta, speed = np.zeros(5), np.zeros(5)
    for target, terms in ((eta, B), (speed, A)):
        for (power, harmonic), value in terms.items():
            if power <= order:
                target[harmonic - 1] += value * steepness**power
    return eta / k, C[0] * np.sqrt(g / k) * n * speed


class Stokes(Travelling):
    """A regular wave by Stokes's expansion to the order 2, 3, 4 or 5, of given height [m], period [s] and depth [m].

    The mean Eulerian current is zero. Valid for height length^2/depth^3 <= 40; use StreamFunction for longer waves.

    >>> wave = Stokes(height=0.1, period=1.2, depth=0.5)
    >>> print(f"crest {wave.elevation(0.0, 0.0):.3f} m, trough {wave.elevation(0.0, 0.6):.3f} m")
    crest 0.056 m, trough -0.044 m
    """

    kind: Literal["stokes"] = Field(default="stokes", init=False)
    height: Height
    period: Period
    depth: Depth
    order: Annotated[int, Field(ge=2, le=5, description="order of the expansion")] = 5
    at: Place = 0.0
    leftward: Leftward = False
    g: Gravity = 9.81

    @model_validator(mode="after")
    def _is_a_stokes_wave(self) -> "Stokes":
        linear = 2.0 * np.pi / float(wave_number(2.0 * np.pi / self.period, self.depth, self.g))
        no_higher(
            self.height, steepest(self.depth, linear), "that of the highest steady wave", "use a lower or a longer one"
        )
        no_higher(
            self.height,
            40.0 * self.depth**3 / linear**2,
            "where Stokes's expansion ends for waves of this length and depth",
            "use StreamFunction",
        )
        return self

    @property
    def k(self) -> float:
        """Wave number [1/m]."""
        return _wave_number(self.height, self.period, self.depth, self.g, self.order)

    @property
    def length(self) -> float:
        """Length of the wave [m]."""
        return 2.0 * np.pi / self.k

    @property
    def celerity(self) -> float:
        """Speed of the crests [m/s]."""
        return self.length / self.period

    @property
    def _harmonics(self) -> tuple[Floats, Floats]:
        return _harmonics(self.k, self.height, self.depth, self.g, self.order)

    def _profile(self, ahead: Floats) -> Floats:
        eta: Floats = sum(value * np.cos(n * self.k * ahead) for n, value in enumerate(self._harmonics[0], start=1))
        return eta

    def _flow(self, ahead: Floats, y: Floats) -> tuple[Floats, Floats]:
        u, v = np.zeros(np.shape(ahead)), np.zeros(np.shape(ahead))
        for n, value in enumerate(self._harmonics[1], start=1):
            u += value * np.cosh(n * self.k * y) * np.cos(n * self.k * ahead)
            v += value * np.sinh(n * self.k * y) * np.sin(n * self.k * ahead)
        return u, v
