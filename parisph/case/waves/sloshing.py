"""Linear sloshing in a tank that sways."""

from collections.abc import Iterator
from typing import Annotated, Literal

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field

from parisph.base.arrays import Floats
from parisph.case.waves.airy import transfer
from parisph.case.waves.linear import angular_frequency
from parisph.case.waves.wavefield import Depth, Gravity, WaveField

MODES = 400    # of the series, for an error below 1e-7 of the wave


def sway_sloshing_elevation(x: ArrayLike, t: ArrayLike, length: float, depth: float, amplitude: float, frequency: float,
                            g: float = 9.81, modes: int = MODES) -> Floats:
    """Return the linear elevation in a tank that sways by X = amplitude (1 - cos(frequency t)), in the tank's frame.

    Z14 Eqs 34 and 35 after Faltinsen, minus the depth, with a plus sign for this X (printed: minus).

    x : distance from the left wall [m]; t : [s]; they broadcast
    length, depth : of the water [m]
    amplitude [m], frequency [rad/s] : of the sway
    modes : the series has the odd modes below this number

    Returns: array of the broadcast shape [m]
    """
    x, t = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(t, dtype=float))
    eta = np.zeros(x.shape)
    for k, omega, scale in _modes(length, depth, amplitude, frequency, g, modes):
        eta += scale * _beat(omega, frequency, t) * np.cos(k * x)
    return eta


def _modes(length: float, depth: float, amplitude: float, frequency: float, g: float,
           modes: int) -> Iterator[tuple[float, float, float]]:
    """Yield wave number [1/m], frequency [rad/s] and scale [m/s2] of each mode."""
    for n in range(1, modes, 2):
        k = n * np.pi / length
        omega = angular_frequency(k, depth, g)
        yield k, omega, 4.0 / (k * k * length) * omega**2 * amplitude * frequency**2 / g


def _beat(omega: float, frequency: float, t: Floats) -> Floats:
    """Return (cos(frequency t) - cos(omega t))/(omega^2 - frequency^2), also at resonance."""
    # A product of sines does not cancel for close frequencies.
    mean, half = 0.5 * (omega + frequency), 0.5 * (omega - frequency)
    beat: Floats = np.sin(mean * t) * np.sinc(half * t / np.pi) * t / (2.0 * mean)
    return beat


def _beat_rate(omega: float, frequency: float, t: Floats) -> Floats:
    """Return the time derivative of _beat."""
    mean, half = 0.5 * (omega + frequency), 0.5 * (omega - frequency)
    rate: Floats = (0.5 * np.cos(mean * t) * np.sinc(half * t / np.pi) * t
                    + 0.5 * np.sin(mean * t) * np.cos(half * t) / mean)
    return rate


class Sloshing(WaveField):
    """Linear sloshing in a tank that sways by X = amplitude (1 - cos(frequency t)) from rest, in the tank's frame.

    length, depth : of the water [m]; amplitude [m] and frequency [rad/s] : of the sway; at : x of the left wall [m]

    >>> wave = Sloshing(length=2.0, depth=0.5, amplitude=0.002, frequency=2.7)
    >>> print(f"{abs(wave.elevation(0.0, 0.0)):.3f} m")    # flat at the start
    0.000 m
    """

    kind: Literal["sloshing"] = Field(default="sloshing", init=False)
    length: Annotated[float, Field(gt=0, description="length of the tank [m]")]
    depth: Depth
    amplitude: Annotated[float, Field(description="amplitude of the sway [m]")]
    frequency: Annotated[float, Field(gt=0, description="angular frequency of the sway [rad/s]")]
    at: Annotated[float, Field(description="position x of the left wall [m]")] = 0.0
    g: Gravity = 9.81

    def elevation(self, x: ArrayLike, t: ArrayLike) -> Floats:
        x = np.asarray(x, dtype=float) - self.at
        return sway_sloshing_elevation(x, t, self.length, self.depth, self.amplitude, self.frequency, self.g)

    def velocity(self, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> tuple[Floats, Floats]:
        """See WaveField: of the potential whose normal derivative at y = depth is the rate of the elevation."""
        x, y, t = np.broadcast_arrays(
            np.asarray(x, dtype=float) - self.at, np.asarray(y, dtype=float), np.asarray(t, dtype=float)
        )
        u, v = np.zeros(x.shape), np.zeros(x.shape)
        for k, omega, scale in _modes(self.length, self.depth, self.amplitude, self.frequency, self.g, MODES):
            rate = scale * _beat_rate(omega, self.frequency, t)
            cosh, sinh = transfer(k, y, self.depth)
            u -= rate * cosh * np.sin(k * x)
            v += rate * sinh * np.cos(k * x)
        return u, v
