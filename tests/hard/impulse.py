"""Pressure-impulse theory of a rectangle of fluid that hits a wall with a whole side.

In the instant of the impact only the impulsive pressure P, the time integral of p, changes the velocity:
rho (u_after - u_before) = -grad P, and div u = 0 before and after gives lap P = 0. The free sides have
P = 0; on the side that hits the wall at the speed U, the normal velocity vanishes, so dP/dx = -rho U at
x = 0. Two equal rectangles that meet at the speed U each are mirror images: the plane between them acts as a wall.
"""

import numpy as np

TERMS = 2000    # of the series; the sum over 1/n^3 then is exact to 1e-8


def lost_energy(thickness: float, side: float, terms: int = TERMS) -> float:
    """Return the share of its kinetic energy that a rectangle loses in the impact.

    P = sum over odd n of 4 rho U h/(n pi)^2 sin(n pi y/h) sinh(n pi (b - x)/h)/cosh(n pi b/h). The loss is
    1/2 times the integral of |grad P|^2/rho, by Green's theorem U/2 times that of P over the side at the wall.

    thickness : b [m], normal to the wall; side : h [m], along the wall
    """
    n = np.arange(1, 2 * terms, 2)
    return float(8.0 * side / (np.pi**3 * thickness) * np.sum(np.tanh(n * np.pi * thickness / side) / n**3))
