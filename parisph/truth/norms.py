"""Errors of a time series against a reference, and of operators.

Z14: Zheng, Ma & Duan (2014). Z17: Zheng et al. (2017). Series are (n,) arrays; times [s] increase. Nothing here is
collective. A series that cannot be evaluated raises ValueError.
"""

import numpy as np

from parisph.base.arrays import Flags, Floats

MOST_SAMPLES = 10_000    # of a series that is sampled evenly


def relative_l2(value: Floats, truth: Floats, rest: float = 0.0) -> float:
    """Return |value - truth| / |truth - rest| in the discrete L2 norm; both (n,), any unit.

    Z14 uses it for pressures (Er_p, Sec. 3.1.2) and for elevations above the bed (Er_eta, Sec. 3.2.1).
    rest : level of the water at rest, in the unit of the series, for an error relative to the wave alone
    """
    value, truth = _pair(value, truth)
    size = np.linalg.norm(truth - rest)
    if size == 0.0:
        raise ValueError("the truth equals the level at rest: there is no relative error")
    return float(np.linalg.norm(value - truth) / size)


def z17_elevation(elevation: Floats, truth: Floats) -> float:
    """Return Z17's Err as printed (Eq 35): sqrt(sum (truth - elevation)^2) / sum(truth); (n,) each [m].

    It decreases as 1/sqrt(n) with the number of samples. Its denominator vanishes if the truth oscillates about zero
    (ValueError if it is exactly zero).
    """
    value, truth = _pair(elevation, truth)
    total = np.sum(truth)
    if total == 0.0:
        raise ValueError("the truth adds up to zero: Eq 35 of Z17 divides by that sum")
    return float(np.linalg.norm(value - truth) / abs(total))


def z14_er(error: Floats, size: float, volume: float) -> float:
    """Return Er of Z14, Sec. 2.2: sqrt(sum (error/size)^2 m/rho), (n,) errors.

    size : amplitude of the exact derivative; volume : m/rho of a particle [m^dim]. Er is the rms times the root of the
    area of the particles, 0.6 for the paper's window.
    """
    return float(np.sqrt(np.sum((error / size) ** 2) * volume))


def z14_er_max(error: Floats, size: float) -> float:
    """Return Er_max of Z14, Sec. 2.2: the largest |error|/size."""
    return float(np.abs(error).max() / size)


def z17_er(error: Floats) -> float:
    """Return Er of Z17 Eq 33 as printed, of one component: sqrt(sum error^2)/N.

    It is the rms over sqrt(N): for a constant error it decreases as 1/sqrt(N).
    """
    return float(np.linalg.norm(error) / len(error))


def relative_l2_linf(found: Floats, exact: Floats) -> tuple[float, float]:
    """Return the error relative to the exact values in L2, and in L-infinity (largest error over largest value).

    found, exact : (n,), or (n, dim) for vectors, whose length counts
    """
    error, size = (np.abs(a) if a.ndim == 1 else np.linalg.norm(a, axis=1) for a in (found - exact, exact))
    return relative_l2(found.ravel(), exact.ravel()), float(error.max() / size.max())


def on_reference(time: Floats, value: Floats, reference_time: Floats, reference: Floats,
                 shift: float = 0.0) -> tuple[Floats, Floats, Floats]:
    """Return (t, value at t, reference at t), (k,) each, where the two series overlap.

    t are the times of the reference, or those of the run if fewer than two of the reference are inside the run (such as
    a constant given by two distant points). The other series is interpolated linearly.

    time, value : (n,) of the run; reference_time, reference : (m,)
    shift : [s], added to the run's time, as for a gate that opens late

    Raises ValueError: the two overlap in fewer than two samples of either
    """
    time, value = _series(time, value)
    reference_time, reference = _series(reference_time, reference)
    time = time + shift
    inside = _within(reference_time, time)
    if np.count_nonzero(inside) >= 2:
        t = reference_time[inside]
        return t, np.interp(t, time, value), reference[inside]
    inside = _within(time, reference_time)
    if np.count_nonzero(inside) < 2:
        raise ValueError(
            f"the series from {time[0]:g} to {time[-1]:g} s and the reference from "
            f"{reference_time[0]:g} to {reference_time[-1]:g} s share fewer than two samples"
        )
    t = time[inside]
    return t, value[inside], np.interp(t, reference_time, reference)


def best_shift(time: Floats, value: Floats, reference_time: Floats, reference: Floats,
               limit: float) -> float:
    """Return the shift [s] of the run's time, at most `limit` in either direction, with the least error.

    All shifts are compared at the same samples of the reference: those that overlap the run under every shift. The
    minimum is found on a grid of limit/100 and then on two finer grids.
    """
    time, value = _series(time, value)
    reference_time, reference = _series(reference_time, reference)
    common = (reference_time >= time[0] + limit) & (reference_time <= time[-1] - limit)
    if np.count_nonzero(common) < 2:
        raise ValueError("fewer than two samples of the reference stay inside the series under every shift up "
                         f"to {limit:g} s")
    t, truth = reference_time[common], reference[common]

    def error(shift: float) -> float:
        return float(np.linalg.norm(np.interp(t, time + shift, value) - truth))

    centre, width = 0.0, limit
    for _ in range(3):
        grid = np.clip(np.linspace(centre - width, centre + width, 201), -limit, limit)
        centre, width = grid[np.argmin([error(shift) for shift in grid])], width / 50
    return float(centre)


def judge(time: Floats, value: Floats, reference_time: Floats, reference: Floats,
          rest: float | None = None, shift: float = 0.0) -> dict[str, float]:
    """Return the errors of a probe against its truth, for summary.json.

    shift : [s], added to the run's time
    rest : None, or the level at rest of a wave, in the probe's unit

    Returns a dict: relative_l2 (relative to the wave if `rest` is given), z14 (relative to the whole truth), samples,
    start and end [s] of the compared window.
    """
    t, found, truth = on_reference(time, value, reference_time, reference, shift)
    return {
        "relative_l2": relative_l2(found, truth, 0.0 if rest is None else rest),
        "z14": relative_l2(found, truth), "samples": len(t), "start": float(t[0]), "end": float(t[-1]),
    }


def cut(time: Floats, value: Floats, window: tuple[float, float]) -> tuple[Floats, Floats]:
    """Return the series (k,) inside a window (start, end) [s], with interpolated samples at its ends.

    Raises ValueError if the window is not inside the series.
    """
    time, value = _series(time, value)
    start, end = window
    if not time[0] <= start < end <= time[-1]:
        raise ValueError(f"the window from {start:g} to {end:g} s is not inside the series from {time[0]:g} to "
                         f"{time[-1]:g} s")
    t = np.concatenate(([start], time[(time > start) & (time < end)], [end]))
    return t, np.interp(t, time, value)


def evenly(time: Floats, value: Floats) -> tuple[Floats, Floats]:
    """Return a series (n,) at equal steps from its first to its last time (m,), with about its median step [s]."""
    time, value = _series(time, value)
    count = min(round((time[-1] - time[0]) / float(np.median(np.diff(time)))), MOST_SAMPLES)
    t = np.linspace(time[0], time[-1], max(count, 1) + 1)
    return t, np.interp(t, time, value)


def moving_mean(time: Floats, value: Floats, width: float) -> Floats:
    """Return the mean (n,) of a series over a width [s] about each of its times, or over its part inside the series."""
    t, p = _series(time, value)
    low, high = np.maximum(t - width / 2, t[0]), np.minimum(t + width / 2, t[-1])
    mean: Floats = (_integral(t, p, high) - _integral(t, p, low)) / (high - low)
    return mean


def _within(time: Floats, other: Floats) -> Flags:
    """Return whether times (n,) are inside the span of others (m,), (n,) bool."""
    inside: Flags = (time >= other[0]) & (time <= other[-1])
    return inside


def _integral(t: Floats, p: Floats, upto: Floats) -> Floats:
    """Return the integral of the piecewise linear function (t, p) from t[0] to each of `upto`."""
    whole = np.concatenate(([0.0], np.cumsum(np.diff(t) * (p[1:] + p[:-1]) / 2)))
    k = np.clip(np.searchsorted(t, upto, side="right") - 1, 0, len(t) - 2)
    part = upto - t[k]
    slope = (p[k + 1] - p[k]) / (t[k + 1] - t[k])
    found: Floats = whole[k] + part * (p[k] + slope * part / 2)
    return found


def _pair(value: Floats, truth: Floats) -> tuple[Floats, Floats]:
    value, truth = np.asarray(value, dtype=float), np.asarray(truth, dtype=float)
    if value.shape != truth.shape or value.ndim != 1:
        raise ValueError(f"value and truth must be series of one length, got shapes {value.shape} and {truth.shape}")
    if len(value) == 0 or not (np.all(np.isfinite(value)) and np.all(np.isfinite(truth))):
        raise ValueError("a series is empty or has values that are not numbers")
    return value, truth


def _series(time: Floats, value: Floats) -> tuple[Floats, Floats]:
    time, value = _pair(time, value)
    if len(time) < 2 or np.any(np.diff(time) <= 0.0):
        raise ValueError("a series needs two samples or more, with times that increase")
    return time, value
