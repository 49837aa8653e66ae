"""Norms of an operator's error: those of the papers, and proper ones. Pure functions, nothing is collective."""

import numpy as np

from parisph.base.arrays import Floats
from parisph.truth.norms import relative_l2


def z14(error: Floats, size: float, volume: float) -> float:
    """Return Er of Z14, Sec. 2.2: sqrt(sum (error/size)^2 m/rho), (n,) errors.

    size : amplitude of the exact derivative; volume : m/rho of a particle [m^dim]. It is the rms times the root of the
    area that is looked at, 0.6 for the paper's window.
    """
    return float(np.sqrt(np.sum((error / size) ** 2) * volume))


def z14_largest(error: Floats, size: float) -> float:
    """Return Er_max of Z14, Sec. 2.2: the largest |error|/size."""
    return float(np.abs(error).max() / size)


def z17(error: Floats) -> float:
    """Return Er of Z17 Eq 33 as printed, of one component: sqrt(sum error^2)/N.

    It is the rms divided once more by sqrt(N): it decreases as 1/sqrt(N) for an error that does not.
    """
    return float(np.linalg.norm(error) / len(error))


def relative(found: Floats, exact: Floats) -> tuple[float, float]:
    """Return the error relative to the exact values in L2, and in L-infinity (largest error over largest value).

    found, exact : (n,), or (n, dim) for vectors, whose length counts
    """
    error, size = (np.abs(a) if a.ndim == 1 else np.linalg.norm(a, axis=1) for a in (found - exact, exact))
    return relative_l2(found.ravel(), exact.ravel()), float(error.max() / size.max())
