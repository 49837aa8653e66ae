"""The exact solitary wave: steady, irrotational, in units of depth and gravity.

The water is the conformal image of a strip of height 1, where the elevation solves Babenko's equation

    F^2 C eta - eta = eta C eta + C(eta^2)/2,    C with the symbol k coth k,

here on a long period (babenko_solver.py). Clamond & Dutykh (2013), Fast accurate computation of the fully
nonlinear solitary surface gravity waves, Computers & Fluids 84, 35-38.

With omega = alpha + i beta in the strip, beta = 0 on the bed, z = x + i y is a series of sines with real coefficients,
and the velocity in water at rest far away is u - i v = F (1 - 1/z').
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from parisph.base.arrays import Floats
from parisph.case.waves import babenko_solver

Complex = NDArray[np.complex128]
Values = TypeVar("Values", Floats, Complex)

HIGHEST = 0.75    # a/d, up to which the solution was checked; the highest wave has 0.8332
TAIL = 36.0    # decay exp(-TAIL) at the ends of the period
SMALL = 1e-14    # smaller harmonics are left out
STEP = 1e-8    # last step of Newton's method, whose error is its square
BLOCK = 2048    # points computed at once, which fit the cache


@dataclass(frozen=True)
class Solitary:
    """A solitary wave in units of depth and gravity, with its crest at x = 0.

    F : speed; half : half the period in alpha
    eta : (m,) harmonics of the elevation over alpha, cos(n pi alpha/half)
    mass, kinetic, potential : area of the wave and its energies
    """

    F: float
    half: float
    eta: Floats
    mass: float
    kinetic: float
    potential: float

    @property
    def decay(self) -> float:
        """Decay rate m far from the crest, exp(-m x)."""
        return _decay(self.F)

    @property
    def reach(self) -> float:
        """Half the length of the wave, which is zero beyond."""
        return 0.98 * self.half

    @cached_property
    def _series(self) -> tuple[Floats, Floats, float]:
        """Coefficients (m,) of z = (1 + eta_0) omega + sum b_n sin(n k omega), those of z', and k."""
        k = np.pi / self.half
        n = np.arange(1, len(self.eta))
        b = self.eta[1:] / np.sinh(n * k)
        return np.concatenate([[0.0], b]), np.concatenate([[1.0 + self.eta[0]], n * k * b]), k

    @cached_property
    def _fine(self) -> tuple[Floats, Floats, Floats]:
        """alpha, x and dx/dalpha (n,) at points on the surface, even in alpha, from the crest for half a period."""
        n, k = 4 * len(self.eta), np.arange(1, len(self.eta)) * np.pi / self.half
        sines = self.eta[1:] / np.tanh(k)
        room = np.zeros(n + 1 - len(self.eta))
        x = np.fft.irfft(np.concatenate([[0.0], -1j * sines, room]), 2 * n)[: n + 1] * n
        slope = np.fft.irfft(np.concatenate([[0.0], k * sines, room]), 2 * n)[: n + 1] * n
        alpha, mean = np.arange(n + 1) * self.half / n, 1.0 + self.eta[0]
        return alpha, mean * alpha + x, mean + slope

    @cached_property
    def _crossings(self) -> tuple[Floats, Floats]:
        """x and alpha (n,) of points on the surface, starts of Newton's method."""
        alpha, x, _ = self._fine
        return np.concatenate([-x[:0:-1], x]), np.concatenate([-alpha[:0:-1], alpha])

    @cached_property
    def _area(self) -> tuple[float, Floats]:
        """Coefficients of the area between the crest and alpha on the surface: of alpha, and of sin(n k alpha)."""
        slope = self._fine[2]
        n = len(slope) - 1
        room = np.zeros(n + 1 - len(self.eta))
        eta = self.eta[0] + np.fft.irfft(np.concatenate([[0.0], self.eta[1:], room]), 2 * n)[: n + 1] * n
        values = eta * slope
        a = np.fft.rfft(np.concatenate([values, values[-2:0:-1]])).real / n
        last = int(np.flatnonzero(np.abs(a) > SMALL)[-1]) + 1
        return 0.5 * a[0], np.concatenate([[0.0], a[1:last] / (np.arange(1, last) * np.pi / self.half)])

    def place(self, omega: Complex) -> tuple[Complex, Complex]:
        """Return z and z' at omega (complex arrays)."""
        b, c, k = self._series
        sines, cosines = _sums(b, c, k * omega)
        return (1.0 + self.eta[0]) * omega + sines, cosines

    def surface(self, x: Floats) -> tuple[Floats, Floats, Floats]:
        """Return elevation and slope at x (n,), and the area of the wave ahead of it."""
        x = np.clip(np.asarray(x, dtype=float), -self.reach, self.reach)
        omega = self._on_surface(x)
        z, slope = self.place(omega)
        linear, sines = self._area
        behind = linear * omega.real + _sums(sines, np.zeros(1), np.pi / self.half * omega.real)[0]
        return z.imag - 1.0, slope.imag / slope.real, 0.5 * self.mass - behind

    def velocity(self, x: Floats, y: Floats) -> tuple[Floats, Floats]:
        """Return u and v at points x, y (n,) in the water; 0 beyond the reach of the wave."""
        u, v = np.zeros(len(x)), np.zeros(len(x))
        near = np.flatnonzero(np.abs(x) < self.reach)
        for start in range(0, len(near), BLOCK):
            part = near[start : start + BLOCK]
            u[part], v[part] = self._velocity(x[part], y[part])
        return u, v

    def _velocity(self, x: Floats, y: Floats) -> tuple[Floats, Floats]:
        distinct, which = np.unique(x, return_inverse=True)
        above = self._on_surface(distinct)
        height = self.place(above)[0].imag
        # start at the same relative height in the strip
        share = y / height[which]
        omega = x + share * (above.real[which] - x) + 1j * share
        omega = _solve(self.place, omega, x + 1j * y)
        found = self.F * (1.0 - 1.0 / self.place(omega)[1])
        return found.real, -found.imag

    def _on_surface(self, x: Floats) -> Complex:
        """Return omega = alpha + i on the surface at x (n,)."""

        def along(alpha: Floats) -> tuple[Floats, Floats]:
            z, slope = self.place(alpha + 1j)
            return z.real, slope.real

        return _solve(along, np.interp(x, *self._crossings), x) + 1j


def _solve(function: Callable[[Values], tuple[Values, Values]], start: Values, target: Values) -> Values:
    """Solve function(found) = target by Newton's method; function returns values and derivatives.

    Each point stops separately, so its result does not depend on the others.
    """
    found, active = start, np.ones(len(start), dtype=bool)
    for _ in range(60):
        value, slope = function(found)
        step = np.where(active, (value - target) / slope, 0.0)
        found = found - step
        active &= np.abs(step) >= STEP
        if not active.any():
            break
    return found


def _sums(b: Floats, c: Floats, theta: Values) -> tuple[Values, Values]:
    """Return the sums of b_n sin(n theta) and c_n cos(n theta), n from 0, by Clenshaw's recurrence."""
    cosine = np.cos(theta)
    two = 2.0 * cosine
    one, before, other, earlier = (np.zeros_like(two) for _ in range(4))
    for n in range(max(len(b), len(c)) - 1, 0, -1):
        one, before = two * one - before + (b[n] if n < len(b) else 0.0), one
        other, earlier = two * other - earlier + (c[n] if n < len(c) else 0.0), other
    return one * np.sin(theta), c[0] + cosine * other - earlier


@lru_cache(maxsize=16)
def solitary(height: float) -> Solitary:
    """Return the solitary wave of a relative height up to HIGHEST. Raises ValueError if it is not found."""
    F = float(np.sqrt(1.0 + height - height**2 / 20.0 - 3.0 * height**3 / 70.0))
    half = TAIL / _decay(F)
    found = babenko_solver.solve(height, F, half, _decay(F))
    if found is None:
        raise ValueError(f"no solitary wave of a height of {height:g} depths was found")
    return _record(*found, half)


def _decay(F: float) -> float:
    """Return the decay rate m: exp(-m x) far away, with tan(m)/m = F^2."""
    low, high = 1e-9, np.pi / 2.0 - 1e-9
    for _ in range(100):
        m = 0.5 * (low + high)
        low, high = (m, high) if np.tan(m) < F * F * m else (low, m)
    return m


def _record(F: float, eta: Floats, half: float) -> Solitary:
    """Return the Solitary, with mass and energies by the trapezoidal rule, which is exact for periodic functions."""
    n = len(eta)
    harmonics = np.fft.rfft(eta).real / n
    harmonics[1:] *= 2.0
    last = int(np.flatnonzero(np.abs(harmonics) > SMALL)[-1]) + 1
    k = np.arange(len(harmonics)) * np.pi / half
    symbol = np.concatenate([[1.0], k[1:] / np.tanh(k[1:])])
    stretch = 1.0 + np.fft.irfft(symbol * np.fft.rfft(eta), n)
    step = 2.0 * half / n
    mass = step * float(eta @ stretch)
    # T = F^2 (M - integral of eta over alpha)/2: flow of the wave minus the uniform flow of the strip
    kinetic = 0.5 * F * F * (mass - step * float(eta.sum()))
    return Solitary(F, half, harmonics[:last], mass, kinetic, 0.5 * step * float((eta**2) @ stretch))
