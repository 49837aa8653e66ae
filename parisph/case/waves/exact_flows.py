"""Exact reference solutions of flows other than waves: pure functions of numbers and arrays."""

from collections.abc import Callable, Sequence

import numpy as np

from parisph.base.arrays import Floats
from parisph.case.waves.linear import Values

MODES = 8000    # of the series


def column_start_pressure(x: Values, y: Values, width: float, height: float, density: float = 1000.0, g: float = 9.81,
                          modes: int = MODES) -> Floats:
    """Return the pressure [Pa] in a column of water just after its right support is removed.

    Laplace's equation with p = 0 at y = height and x = width, dp/dx = 0 at x = 0 and dp/dy = -rho g at
    y = 0: p = rho g H (1 - y/H - sum_n 8/((2n-1) pi)^2 cos(a_n y) cosh(a_n x)/cosh(a_n L)), with
    a_n = (2n-1) pi/(2H).

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
    """Return the half axes (a, b) of an elliptical drop that starts as a circle with velocity (rate x, -rate y).

    The only body force is a central force -stiffness^2 r. The velocity keeps the form (s x, -s y), and
    the pressure is a paraboloid that vanishes on the ellipse. Hence a' = s a, b' = -s b and
    s' = (s^2 + stiffness^2)(b^2 - a^2)/(a^2 + b^2).

    times : (n,) increasing, from 0 on [s]
    radius [m], rate [1/s], stiffness [1/s]
    steps : of the Runge-Kutta integration to the last time

    Returns:
    a, b : (n,) [m]
    """
    times = np.asarray(times, dtype=float)
    grid = np.linspace(0.0, max(times[-1], 1e-300), steps + 1)

    def slope(state: Floats) -> Floats:
        a, b, s = state
        return np.array([s * a, -s * b, (s * s + stiffness**2) * (b * b - a * a) / (a * a + b * b)])

    states = _integrated(slope, np.array([radius, radius, rate], dtype=float), grid)
    return np.interp(times, grid, states[:, 0]), np.interp(times, grid, states[:, 1])


def ellipsoid_half_axes(times: Floats, axes: Sequence[float], rates: Sequence[float], stiffness: float = 0.0,
                        steps: int = 2000) -> tuple[Floats, Floats, Floats]:
    """Return half axes, strain rates and central pressure over density of an ellipsoidal drop in 3D.

    It starts with the velocity (rates[i] x_i), and the only body force is a central force -stiffness^2 r. The velocity
    keeps the form a_i'/a_i x_i, and the pressure is a paraboloid P (1 - sum x_i^2/a_i^2). Hence
    a_i'' = 2 P/(rho a_i) - stiffness^2 a_i, P/rho = (sum (a_i'/a_i)^2 + 3 stiffness^2)/(2 sum 1/a_i^2).

    times : (n,) increasing, from 0 on [s]
    axes : (3,) [m]; rates : (3,) [1/s], with the sum 0; stiffness [1/s]
    steps : of the Runge-Kutta integration to the last time

    Returns: (n, 3) [m]; (n, 3) [1/s]; (n,) [m2/s2]
    """
    times, k = np.asarray(times, dtype=float), stiffness**2
    grid = np.linspace(0.0, max(times[-1], 1e-300), steps + 1)

    def pressure(a: Floats, speed: Floats) -> Floats:
        found: Floats = (np.sum((speed / a) ** 2, axis=-1) + 3.0 * k) / (2.0 * np.sum(a**-2.0, axis=-1))
        return found

    def slope(state: Floats) -> Floats:
        a, speed = state
        return np.array([speed, 2.0 * pressure(a, speed) / a - k * a])

    states = _integrated(slope, np.array([axes, np.multiply(rates, axes)], dtype=float), grid)
    a, speed = (np.stack([np.interp(times, grid, column) for column in states[:, part].T], axis=1) for part in (0, 1))
    return a, speed / a, pressure(a, speed)


def _integrated(slope: Callable[[Floats], Floats], start: Floats, grid: Floats) -> Floats:
    """Return the states at the times of an even grid (n,), by the Runge-Kutta method of fourth order."""
    h, states = grid[1], [start]
    for _ in range(len(grid) - 1):
        y = states[-1]
        k1 = slope(y)
        k2 = slope(y + 0.5 * h * k1)
        k3 = slope(y + 0.5 * h * k2)
        k4 = slope(y + h * k3)
        states.append(y + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4))
    return np.array(states)
