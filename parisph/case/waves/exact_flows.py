"""Exact reference solutions of flows other than waves: pure functions of numbers and arrays."""

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
