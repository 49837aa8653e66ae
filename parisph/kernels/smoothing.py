"""Kernel functions W(r) and W'(r)/r, and the weight of the moving least squares."""

import math

from parisph.kernels.jit import inlined


@inlined
def cubic_spline(r: float, h: float, dim: int) -> float:
    """Return W(r) of the cubic spline with support 2h (Zheng et al. 2014, Eq. 5) [m^-dim]."""
    q = min(r / h, 2.0)  # without branches, so that loops over neighbours are vectorised
    near, far = 2.0 / 3.0 - q * q * (1.0 - 0.5 * q), (2.0 - q) ** 3 / 6.0
    return _cubic_scale(h, dim) * (near if q < 1.0 else far)


@inlined
def cubic_spline_slope(r: float, h: float, dim: int) -> float:
    """Return W'(r)/r of the cubic spline, finite at r = 0 [m^-dim-2]."""
    q = min(r / h, 2.0)
    near, far = 1.5 * q - 2.0, -0.5 * (2.0 - q) ** 2 / max(q, 1.0)
    return _cubic_scale(h, dim) / (h * h) * (near if q < 1.0 else far)


@inlined
def _cubic_scale(h, dim):
    return 15.0 / (7.0 * math.pi * h * h) if dim == 2 else 3.0 / (2.0 * math.pi * h * h * h)


@inlined
def quartic_weight(r2: float, radius2: float) -> float:
    """Return the least-squares weight 1 - 6q^2 + 8q^3 - 3q^4 of q = r/radius, from squares.

    It is C2 at q = 1, where it is exactly zero, so it needs no branch. It is not normalised, as only ratios of weights
    matter.
    """
    q2 = min(r2 / radius2, 1.0)
    return 1.0 - q2 * (6.0 - 8.0 * math.sqrt(q2) + 3.0 * q2)
