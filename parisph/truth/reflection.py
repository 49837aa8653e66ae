"""Incident and reflected waves from the elevations at two gauges or more, by least squares.

Goda and Suzuki (1976) take two gauges, Mansard and Funke (1980) three. Nothing here is collective.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from parisph.base.arrays import Floats

SPREAD = 1e-3    # least singular value of the equations, over the greatest: gauges whole half waves apart tell nothing


class Waves(NamedTuple):
    """Amplitudes of a regular wave towards +x and of one towards -x, in the unit of the elevation.

    residual : what is left of the amplitudes at the gauges, relative to them (root mean square)
    """

    incident: float
    reflected: float
    residual: float

    @property
    def reflection(self) -> float:
        """Reflected over incident amplitude."""
        return self.reflected / self.incident


def separated(times: Floats, elevations: Floats, places: Sequence[float], period: float, wave_number: float,
              harmonics: int = 2) -> Waves:
    """Return the Waves of a period [s] and a wave number [1/m].

    The first harmonic at each gauge is found by least squares, beside the mean, a linear trend and the further
    harmonics; with b_j its complex amplitude at x_j, sum |a exp(-i k x_j) + r exp(i k x_j) - b_j|^2 is least.

    times : (n,) [s], over whole periods at best
    elevations : (gauges, n), of any level
    places : x of the gauges [m]; not all whole half waves apart from each other

    Raises ValueError if the gauges, or less than a period of time, cannot tell the two waves apart.
    """
    times, rows, x = np.asarray(times, float), np.asarray(elevations, float), np.asarray(places, float)
    if rows.shape != (len(x), len(times)):
        raise ValueError(f"elevations have the shape {rows.shape}, not one row for each of {len(x)} gauges and one "
                         f"column for each of {len(times)} times")
    if len(times) < 2 or times[-1] - times[0] < 0.9 * period:
        raise ValueError(f"the elevations last less than a period of {period:.4g} s")
    phase = 2.0 * np.pi / period * times
    parts = [np.ones_like(times), (times - times[0]) / period]
    for n in range(1, harmonics + 1):
        parts += [np.cos(n * phase), np.sin(n * phase)]
    found, *_ = np.linalg.lstsq(np.stack(parts, axis=1), rows.T, rcond=None)
    b = found[2] - 1j * found[3]    # elevation = Re(b exp(i omega t))
    equations = np.stack([np.exp(-1j * wave_number * x), np.exp(1j * wave_number * x)], axis=1)
    sizes = np.linalg.svd(equations, compute_uv=False)
    if len(x) < 2 or sizes[-1] < SPREAD * sizes[0]:
        raise ValueError("the gauges are whole half waves apart, or at one place: they cannot tell the waves apart")
    waves, *_ = np.linalg.lstsq(equations, b, rcond=None)
    left = np.linalg.norm(equations @ waves - b) / max(np.linalg.norm(b), np.finfo(float).tiny)
    return Waves(float(abs(waves[0])), float(abs(waves[1])), float(left))
