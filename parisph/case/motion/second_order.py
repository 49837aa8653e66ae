"""The second harmonic of a wavemaker for regular waves, by complete second-order theory.

A wall that moves with one frequency makes the wave of that frequency, its bound second harmonic, and free waves of
twice the frequency. These run at another speed, so the shape changes along the tank. The second harmonic of the motion
found here makes free waves that cancel them.

Schäffer (1996), Second-order wavemaker theory for irregular waves, Ocean Engng 23(1), here for one frequency. The
amplitude of the free wave is from Green's theorem with psi = cosh(Ky) cos(Kx), with the wave number K of free waves of
twice the frequency: no sum over products of modes can be resonant. For long waves it is the theory of Madsen (1971), On
the generation of long waves, J. Geophys. Res. 76(36).

With the motion of the wall X(t) f(y) and X = Re(X1 exp(i w t) + X2 exp(2 i w t)), the potential is a sum of the
travelling wave and of MODES evanescent ones, Re(sum C_j cosh(k_j y)/cosh(k_j d) exp(i(w t - k_j x))), all with
k tanh(kd) = nu = w^2/g; the evanescent ones have imaginary k.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from parisph.base.arrays import Floats
from parisph.case.waves.linear import wave_number

Complex = NDArray[np.complex128]

MODES = 200    # evanescent modes; the error is proportional to 1/MODES, here .2 % of the harmonic (kd = 1)
POINTS = 3 * MODES    # of the integrals over the moving part of the wall
ITERATIONS = 60    # each reduces the error of an imaginary wave number to at most a third


def second_harmonic(height: float, omega: float, depth: float, shape: Callable[[Floats], Floats], low: float,
                    g: float) -> complex:
    """Return X2 [m] of a wall that makes no free waves, for real and positive X1.

    height : of the waves [m]; omega : their angular frequency [rad/s]; depth : [m]
    shape : f over the height y (n,) above the bed [m], 1 at the still surface
    low : height above the bed of the lower end of the moving part of the wall [m]
    """
    nu, free = omega * omega / g, float(wave_number(2.0 * omega, depth, g))
    k = _wave_numbers(omega, depth, g)
    points, weights = np.polynomial.legendre.leggauss(POINTS)
    y, weights = low + 0.5 * (depth - low) * (points + 1.0), 0.5 * (depth - low) * weights
    f, (cosh, sinh) = shape(y), _over_top(k, y, depth)
    test, slope = (values[0].real for values in _over_top(np.array([free + 0j]), y, depth))
    norm = 0.5 * (depth * (1.0 - (nu / k) ** 2) + nu / k**2)    # integral of cosh^2/cosh^2(kd)
    C = -omega * (cosh * f) @ weights / (k * norm)
    stroke = 0.5 * height * g / (omega * abs(C[0]))
    C = C * stroke
    # second-order terms of the surface condition, products of modes
    both, kk = k[:, None] + k, k[:, None] * k
    asked = 1j * omega * np.outer(C, C) * (kk - 1.5 * nu**2 + 0.25 * (k[:, None] ** 2 + k**2))
    surface = (asked / g * 1j * both / (free**2 - both**2)).sum()
    # second-order terms of the wall, from its displacement: X (f phi_y)'
    rise = (C * k) @ sinh
    wall = 0.5 * stroke * (nu * C.sum() - free * (f * rise * slope) @ weights)
    return complex((surface - wall) / (2j * omega * (f * test) @ weights))


def _wave_numbers(omega: float, depth: float, g: float) -> Complex:
    """Return k (1 + MODES,) [1/m] of the travelling wave and, imaginary, of the evanescent ones."""
    target, turns = omega * omega * depth / g, np.pi * np.arange(1, 1 + MODES)
    decay = turns
    for _ in range(ITERATIONS):
        decay = turns - np.arctan(target / decay)
    return np.concatenate([[wave_number(omega, depth, g)], -1j * decay / depth])


def _over_top(k: Complex, y: Floats, depth: float) -> tuple[Complex, Complex]:
    """Return cosh(ky) and sinh(ky) over cosh(k depth) for complex k (m,) and y (n,), (m, n) each, without overflow."""
    up, down = np.exp(np.outer(k, y - depth)), np.exp(-np.outer(k, y + depth))
    scale = 1.0 / (1.0 + np.exp(-2.0 * k[:, None] * depth))
    return scale * (up + down), scale * (up - down)
