"""Linear waves: dispersion and the standing wave, as pure functions of numbers and arrays."""

from typing import TypeVar

import numpy as np

from parisph.base.arrays import Floats

Number = TypeVar("Number", float, Floats)    # one number, or one for each of several waves
Values = float | Floats


def angular_frequency(k: Number, depth: float, g: float = 9.81) -> Number:
    """Return the angular frequency [rad/s] of linear waves of wave number k [1/m]: omega^2 = g k tanh(k depth)."""
    omega: Number = np.sqrt(g * k * np.tanh(k * depth))
    return omega


def wave_number(omega: Number, depth: float, g: float = 9.81) -> Number:
    """Return the wave number [1/m] of linear waves of angular frequency omega [rad/s], inverse of angular_frequency."""
    target = omega**2 * depth / g
    kd: Number = target / np.sqrt(np.tanh(target))    # Eckart's approximation, within 5 %
    for _ in range(20):
        tanh = np.tanh(kd)
        kd = kd - (kd * tanh - target) / (tanh + kd * (1.0 - tanh**2))
    return kd / depth


def standing_wave_elevation(x: Values, t: Values, amplitude: float, k: float, depth: float, g: float = 9.81) -> Values:
    """Return the elevation [m] of a linear standing wave, a cos(kx) sin(omega t) (Z17 Eq 36)."""
    eta: Values = amplitude * np.cos(k * x) * np.sin(angular_frequency(k, depth, g) * t)
    return eta


def standing_wave_velocity(x: Values, y: Values, t: Values, amplitude: float, k: float, depth: float,
                           g: float = 9.81) -> tuple[Values, Values]:
    """Return the velocity (u, v) [m/s] of a linear standing wave (Z17 Eqs 37, 38)."""
    omega = angular_frequency(k, depth, g)
    scale = amplitude * omega / np.sinh(k * depth) * np.cos(omega * t)
    return -scale * np.cosh(k * y) * np.sin(k * x), scale * np.sinh(k * y) * np.cos(k * x)


def standing_wave_start(amplitude: float, k: float, depth: float, g: float = 9.81) -> tuple[str, str]:
    """Return the velocity of a standing wave at t = 0, with a flat surface, as expressions for Fluid(velocity=...)."""
    scale = float(amplitude * angular_frequency(k, depth, g) / np.sinh(k * depth))
    k = float(k)
    return f"-{scale!r}*cosh({k!r}*y)*sin({k!r}*x)", f"{scale!r}*sinh({k!r}*y)*cos({k!r}*x)"
