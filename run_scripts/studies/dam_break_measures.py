"""What the studies of the dam break measure. Times t* are in sqrt(H/g), pressures in rho g H, with H = 1 m."""

from math import sqrt

import numpy as np

from parisph.study import FinestError, Function, SeriesError
from parisph.truth import norms

UNIT = sqrt(1.0 / 9.81)     # sqrt(H/g) [s]
WEIGHT = 1000.0 * 9.81      # rho g H [Pa]
SMOOTH = 0.05               # width of the moving mean [s]
CODES = {"Basilisk": "P2_basilisk_256", "interFoam": "P2_interfoam_25600"}
COMPARED, IMPULSE, QUIET = (1.4, 3.4), (1.5, 2.6), (2.5, 3.9)    # t*


def against_code(code: str) -> SeriesError:
    """Return the error of P2 against a grid code in 1.4 < t* < 3.4."""
    return SeriesError(
        "P2", "../../cases/computed/dam_break_vof.csv", time="t_star", value=CODES[code], scale=WEIGHT, time_scale=UNIT,
        start=COMPARED[0] * UNIT, end=COMPARED[1] * UNIT, name=f"P2, {code}")


def against_finest(probe: str, start: float = 0.0, end: float = 10.0) -> FinestError:
    """Return the difference of a probe from that of the finest run; start, end : t*."""
    return FinestError(probe, start=start * UNIT, end=end * UNIT)


def impulse(run) -> float:
    """Return the impulse of P2 in 1.5 < t* < 2.6, in rho g H sqrt(H/g); the grid codes give 1.115 and 1.147."""
    tap = run.probe("P2")
    return _area(*norms.cut(tap["time"] / UNIT, tap["pressure"] / WEIGHT, IMPULSE))


def noise(run) -> float:
    """Return the noise of P2 in 2.5 < t* < 3.9: std(p - its moving mean over SMOOTH) / mean(p)."""
    tap = run.probe("P2")
    return noise_of(tap["time"], tap["pressure"], tuple(time * UNIT for time in QUIET))


def noise_of(time: np.ndarray, pressure: np.ndarray, window: tuple[float, float]) -> float:
    """Return the noise of a trace (n,) in a window (start, end) [s]; steps may be of any length."""
    t, p = norms.cut(time, pressure, window)
    rough, length = p - norms.moving_mean(t, p, SMOOTH), t[-1] - t[0]
    rough -= _area(t, rough) / length
    return float(np.sqrt(_area(t, rough**2) / length) / (_area(t, p) / length))


def _area(t, p):
    return float(np.sum(np.diff(t) * (p[1:] + p[:-1])) / 2)


def energy_at(time: float) -> Function:
    """Return the energy at a time t*, over that at the start."""
    def found(run):
        energy = run.probe("energy")
        return np.interp(time * UNIT, energy["time"], energy["total"]) / energy["total"][0]
    return Function(f"E({time:g})", of=found, error=False)


IMPACT = [
    against_code("Basilisk"), against_code("interFoam"), Function("impulse", of=impulse, error=False),
    Function("noise", of=noise), energy_at(2.0),
]
