"""Incident and reflected waves from the elevations at two gauges or more, by least squares. Not collective.

Goda and Suzuki (1976) use two gauges, Mansard and Funke (1980) three.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from parisph.base.arrays import Array, Floats
from parisph.case.waves.linear import wave_number

SPREAD = 1e-3    # least ratio of the singular values of the equations; it is 0 for gauges whole half waves apart
SPREAD_OF_MANY = 0.15    # the same for each frequency of irregular waves; errors grow with its inverse
TAPER = 0.1      # share of a record that is tapered at each end
WITHIN = (0.5, 2.0)    # range over the frequency of the peak, with nearly all energy
BANDS = 12       # number of bands of equal width in it
HARMONICS = 2    # number of harmonics that are fitted to a regular wave


class Waves(NamedTuple):
    """Amplitudes of a regular wave towards +x and of one towards -x, in the unit of the elevation.

    residual : root mean square of the unexplained amplitudes at the gauges, relative to the amplitudes
    """

    incident: float
    reflected: float
    residual: float

    @property
    def reflection(self) -> float:
        """Reflected over incident amplitude."""
        return self.reflected / self.incident


def separated(times: Floats, elevations: Floats, places: Sequence[float], period: float, k: float) -> Waves:
    """Return the Waves of a period [s] and a wave number k [1/m].

    Least squares give the first harmonic at each gauge, together with the mean, a linear trend and further harmonics.
    With its complex amplitude b_j at x_j, the waves minimise sum |a exp(-i k x_j) + r exp(i k x_j) - b_j|^2.

    times : (n,) [s], best over whole periods; elevations : (gauges, n), of any level
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
    for n in range(1, HARMONICS + 1):
        parts += [np.cos(n * phase), np.sin(n * phase)]
    found, *_ = np.linalg.lstsq(np.stack(parts, axis=1), rows.T, rcond=None)
    b = found[2] - 1j * found[3]    # elevation = Re(b exp(i omega t))
    equations = _equations(x, k)
    if spread(x, k) < SPREAD:
        raise ValueError("the gauges are whole half waves apart, or at one place: they cannot tell the waves apart")
    waves, *_ = np.linalg.lstsq(equations, b, rcond=None)
    left = np.linalg.norm(equations @ waves - b) / max(np.linalg.norm(b), np.finfo(float).tiny)
    return Waves(float(abs(waves[0])), float(abs(waves[1])), float(left))


class Spectra(NamedTuple):
    """Irregular waves towards +x and towards -x, in bands of frequency.

    frequencies : (n,) middles of the bands [Hz]
    incident, reflected : (n,) densities [m2/Hz]; nan in a band in which the gauges cannot tell them apart
    residual : as of Waves
    """

    frequencies: Floats
    incident: Floats
    reflected: Floats
    residual: float

    @property
    def heights(self) -> tuple[float, float]:
        """Significant heights 4 sqrt(m0) of both [m]."""
        width = self.frequencies[1] - self.frequencies[0]
        incident, reflected = (float(4.0 * np.sqrt(np.nansum(one) * width)) for one in (self.incident, self.reflected))
        return incident, reflected


def spectra(times: Floats, elevations: Floats, places: Sequence[float], depth: float, g: float = 9.81) -> Spectra:
    """Return the Spectra of irregular waves whose components have the wave numbers of linear theory.

    Waves are separated for each frequency as in `separated`. Densities are means over bands, from half to twice the
    frequency of the peak. Records are tapered over a tenth of their length at each end, so that they are periodic.

    times : (n,) [s], any steps; elevations : (gauges, n), of any level; depth [m]; g [m/s2]

    Raises ValueError if the gauges cannot tell the waves apart at the peak, or the records are too short.
    """
    times, rows, x = np.asarray(times, float), np.asarray(elevations, float), np.asarray(places, float)
    even = np.linspace(times[0], times[-1], len(times))
    lasts = even[-1] - even[0]
    rows = np.array([np.interp(even, times, row) for row in rows])
    rows = rows - np.array([np.polyval(np.polyfit(even, row, 1), even) for row in rows])
    ends = np.clip(np.minimum(even - even[0], even[-1] - even) / (TAPER * lasts), 0.0, 1.0)
    taper = np.sin(0.5 * np.pi * ends) ** 2
    # eta = Re(b exp(i omega t)), scaled to the energy without the taper
    b = 2.0 / len(even) * np.fft.rfft(rows * taper, axis=1) / np.sqrt((taper**2).mean())
    frequencies = np.arange(b.shape[1]) / (lasts * len(even) / (len(even) - 1.0))
    power = np.convolve((np.abs(b) ** 2).mean(axis=0), np.ones(5) / 5.0, "same")
    peak = float(frequencies[1 + int(np.argmax(power[1:]))])
    inside = np.flatnonzero((frequencies >= WITHIN[0] * peak) & (frequencies <= WITHIN[1] * peak))
    if len(inside) < 2 * BANDS:
        raise ValueError(f"the records last {lasts:.4g} s, {lasts * peak:.3g} periods of the peak: "
                         f"{2 * BANDS / (WITHIN[1] - WITHIN[0]):.0f} are the least")
    if spread(x, float(wave_number(2.0 * np.pi * peak, depth, g))) < SPREAD_OF_MANY:
        raise ValueError(f"the gauges are about whole half waves apart for waves of the peak, {peak:.4g} Hz: "
                         "they cannot tell the waves apart")
    both, left, whole = np.full((2, len(inside)), np.nan), 0.0, 0.0
    for n, j in enumerate(inside):
        k = float(wave_number(2.0 * np.pi * frequencies[j], depth, g))
        if spread(x, k) >= SPREAD_OF_MANY:
            equations = _equations(x, k)
            found = np.linalg.lstsq(equations, b[:, j], rcond=None)[0]
            both[:, n] = 0.5 * np.abs(found) ** 2
            left += float((np.abs(equations @ found - b[:, j]) ** 2).sum())
            whole += float((np.abs(b[:, j]) ** 2).sum())
    edges = peak * np.linspace(WITHIN[0], WITHIN[1], BANDS + 1)
    number = np.clip(np.searchsorted(edges, frequencies[inside], side="right") - 1, 0, BANDS - 1)
    step = frequencies[1] - frequencies[0]
    incident, reflected = np.array([[_mean(one[number == band]) / step for band in range(BANDS)] for one in both])
    residual = np.sqrt(left / max(whole, float(np.finfo(float).tiny)))
    return Spectra(0.5 * (edges[:-1] + edges[1:]), incident, reflected, float(residual))


def spread(places: Sequence[float] | Floats, k: float) -> float:
    """Return how well gauges at `places` [m] separate two waves of wave number k [1/m], 0 (not at all) to 1."""
    x = np.asarray(places, float)
    if len(x) < 2:
        return 0.0
    # the singular values of the equations are the square roots of n +- |sum exp(2ikx)|
    alike = float(abs(np.exp(2j * k * x).sum())) / len(x)
    return float(np.sqrt(max(1.0 - alike, 0.0) / (1.0 + alike)))


def _equations(x: Floats, k: float) -> Array:
    return np.stack([np.exp(-1j * k * x), np.exp(1j * k * x)], axis=1)


def _mean(values: Floats) -> float:
    known = values[np.isfinite(values)]
    return float(known.mean()) if len(known) else np.nan
