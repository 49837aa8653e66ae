"""Wave theories and exact solutions, for initial fields and as reference: pure functions of numbers and arrays.

Heights y are measured from the bed, elevations from the still surface. SI units.
"""

from typing import TypeVar

import numpy as np

from parisph.base.arrays import Floats

Number = TypeVar("Number", float, Floats)    # one number, or one for each of several waves
Values = float | Floats

MODES = 400   # of a series: the sloshing series then has an error below 1e-7 of the wave


def angular_frequency(k: Number, depth: float, g: float = 9.81) -> Number:
    """Angular frequency [rad/s] of linear waves of wave number k [1/m]: omega^2 = g k tanh(k depth)."""
    omega: Number = np.sqrt(g * k * np.tanh(k * depth))
    return omega


def wave_number(omega: Number, depth: float, g: float = 9.81) -> Number:
    """Wave number [1/m] of linear waves of angular frequency omega [rad/s], the inverse of angular_frequency."""
    target = omega**2 * depth / g
    kd: Number = target / np.sqrt(np.tanh(target))  # Eckart's approximation, within 5 %
    for _ in range(20):
        tanh = np.tanh(kd)
        kd = kd - (kd * tanh - target) / (tanh + kd * (1.0 - tanh**2))
    return kd / depth


def standing_wave_elevation(x: Values, t: Values, amplitude: float, k: float, depth: float, g: float = 9.81) -> Values:
    """Elevation [m] of a linear standing wave with an antinode at x = 0: a cos(kx) sin(omega t) (Z17 Eq 36)."""
    eta: Values = amplitude * np.cos(k * x) * np.sin(angular_frequency(k, depth, g) * t)
    return eta


def standing_wave_velocity(x: Values, y: Values, t: Values, amplitude: float, k: float, depth: float,
                           g: float = 9.81) -> tuple[Values, Values]:
    """Velocity components (u, v) [m/s] of a linear standing wave (Z17 Eqs 37, 38)."""
    omega = angular_frequency(k, depth, g)
    scale = amplitude * omega / np.sinh(k * depth) * np.cos(omega * t)
    return -scale * np.cosh(k * y) * np.sin(k * x), scale * np.sinh(k * y) * np.cos(k * x)


def standing_wave_start(amplitude: float, k: float, depth: float, g: float = 9.81) -> tuple[str, str]:
    """The velocity of a standing wave at t = 0, when its surface is flat, as expressions for Fluid(velocity=...)."""
    scale = float(amplitude * angular_frequency(k, depth, g) / np.sinh(k * depth))
    k = float(k)
    return f"-{scale!r}*cosh({k!r}*y)*sin({k!r}*x)", f"{scale!r}*sinh({k!r}*y)*cos({k!r}*x)"


def sway_sloshing_elevation(x: Values, t: Values, length: float, depth: float, amplitude: float, frequency: float,
                            g: float = 9.81, modes: int = MODES) -> Floats:
    """Linear elevation in a tank swaying with X = amplitude (1 - cos(frequency t)), in the tank's frame.

    Z14 Eqs 34 and 35 after Faltinsen, with a plus sign for this X (printed: minus), less the depth.

    Parameters
    ----------
    x : distance from the left wall [m]; t : [s]; they broadcast
    length, depth : of the water [m]
    amplitude [m], frequency [rad/s] : of the sway
    modes : the series runs over the odd mode numbers below this

    Returns
    -------
    array of the broadcast shape [m]
    """
    x, t = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(t, dtype=float))
    eta = np.zeros(x.shape)
    for n in range(1, modes, 2):
        k = n * np.pi / length
        omega = angular_frequency(k, depth, g)
        scale = 4.0 / (k * k * length) * omega**2 * amplitude * frequency**2 / g
        eta += scale * _beat(omega, frequency, t) * np.cos(k * x)
    return eta


def _beat(omega: float, frequency: float, t: Floats) -> Floats:
    """(cos(frequency t) - cos(omega t))/(omega^2 - frequency^2), also at resonance."""
    # A product of sines does not cancel where the two frequencies are close.
    mean, half = 0.5 * (omega + frequency), 0.5 * (omega - frequency)
    beat: Floats = np.sin(mean * t) * np.sinc(half * t / np.pi) * t / (2.0 * mean)
    return beat


def column_start_pressure(x: Values, y: Values, width: float, height: float, density: float = 1000.0, g: float = 9.81,
                          modes: int = 20 * MODES) -> Floats:
    """Pressure [Pa] in a column of water just after its right support is removed.

    Laplace's equation with p = 0 at y = height and x = width, dp/dx = 0 at x = 0 and dp/dy = -rho g at
    y = 0: p = rho g H (1 - y/H - sum_n 8/((2n-1) pi)^2 cos(a_n y) cosh(a_n x)/cosh(a_n L)), with
    a_n = (2n-1) pi/(2H).

    Parameters
    ----------
    x, y : [m], they broadcast
    width, height : of the column [m]
    """
    x, y = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(y, dtype=float))
    p = 1.0 - y / height
    for odd in range(1, 2 * modes, 2):
        a = odd * np.pi / (2.0 * height)
        # cosh(ax)/cosh(aL) without overflow
        ratio = np.exp(a * (x - width)) * (1.0 + np.exp(-2.0 * a * x)) / (1.0 + np.exp(-2.0 * a * width))
        p = p - 8.0 / (odd * np.pi) ** 2 * np.cos(a * y) * ratio
    return density * g * height * p


def drop_half_axes(times: Floats, radius: float, rate: float, stiffness: float = 0.0,
                   steps: int = 2000) -> tuple[Floats, Floats]:
    """Half axes (a, b) of an elliptical drop that starts round with velocity (rate x, -rate y).

    The only body force is a central force -stiffness^2 r. The velocity keeps the form (s x, -s y), and
    the pressure is a paraboloid that vanishes on the ellipse. Hence a' = s a, b' = -s b and
    s' = (s^2 + stiffness^2)(b^2 - a^2)/(a^2 + b^2).

    Parameters
    ----------
    times : (n,) increasing, from 0 on [s]
    radius [m], rate [1/s], stiffness [1/s]
    steps : of the Runge-Kutta integration to the last time

    Returns
    -------
    a, b : (n,) [m]
    """
    times = np.asarray(times, dtype=float)
    grid = np.linspace(0.0, max(times[-1], 1e-300), steps + 1)
    h = grid[1]

    def slope(state: Floats) -> Floats:
        a, b, s = state
        return np.array([s * a, -s * b, (s * s + stiffness**2) * (b * b - a * a) / (a * a + b * b)])

    states = [np.array([radius, radius, rate], dtype=float)]
    for _ in range(steps):
        y = states[-1]
        k1 = slope(y)
        k2 = slope(y + 0.5 * h * k1)
        k3 = slope(y + 0.5 * h * k2)
        k4 = slope(y + h * k3)
        states.append(y + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4))
    a, b = np.array(states)[:, 0], np.array(states)[:, 1]
    return np.interp(times, grid, a), np.interp(times, grid, b)
