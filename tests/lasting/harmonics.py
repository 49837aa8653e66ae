"""Amplitudes of a signal in each of its periods."""

from typing import NamedTuple

import numpy as np

FEWEST = 8    # samples of a period that tell its harmonics


class Harmonics(NamedTuple):
    """Of each period, (n,): its middle [s], the mean, and the amplitudes of the first and of the second harmonic."""

    time: np.ndarray
    mean: np.ndarray
    first: np.ndarray
    second: np.ndarray


def by_period(time: np.ndarray, values: np.ndarray, period: float, start: float = 0.0) -> Harmonics:
    """Return the Harmonics of a signal (n,) at times (n,) [s], by least squares in each whole period."""
    rows = []
    count = int((time[-1] - start) / period + 1e-6) if len(time) else 0
    for number in range(count):
        begin = start + number * period
        chosen = (time >= begin) & (time <= begin + period * (1.0 + 1e-9))
        if chosen.sum() < FEWEST:
            continue
        phase = 2.0 * np.pi / period * time[chosen]
        parts = np.stack([np.ones_like(phase), *(f(n * phase) for n in (1, 2) for f in (np.cos, np.sin))], axis=1)
        c = np.linalg.lstsq(parts, values[chosen], rcond=None)[0]
        rows.append((begin + 0.5 * period, c[0], np.hypot(c[1], c[2]), np.hypot(c[3], c[4])))
    return Harmonics(*np.array(rows).reshape(-1, 4).T)


def loss(amplitudes: np.ndarray, over: float, ends: int = 3) -> float:
    """Return the part of an amplitude that is lost in so many periods, from its first and last few ones; else nan.

    amplitudes : (n,), one for each period; the means of `ends` of them are compared
    """
    n = len(amplitudes)
    if n < ends + 1:
        return np.nan
    ends = min(ends, n // 2)
    first, last = amplitudes[:ends].mean(), amplitudes[-ends:].mean()
    return float(1.0 - (last / first) ** (over / (n - ends)))
