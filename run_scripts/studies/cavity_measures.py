"""What the studies of the lid-driven cavity measure, over the speed of the lid: means over the last ten lid times."""

from pathlib import Path

import numpy as np

from parisph.base.table import read_reference
from parisph.study import Function

COMPUTED = Path(__file__).resolve().parents[2] / "cases" / "computed"
# component: probe, file, column
LINES = {"u": ("vertical", "cavity_u.csv", "y"), "v": ("horizontal", "cavity_v.csv", "x")}
MEAN = 10.0     # lid times


def mean_profile(run, line: str, quantity: str) -> np.ndarray:
    """Return the mean of u, v or p at the points of a line (points,)."""
    found = run.probe(line)
    late = found["time"] > found["time"][-1] - MEAN
    points = sum(name.startswith("u_") for name in found.dtype.names)
    return np.array([found[f"{quantity}_{k}"][late].mean() for k in range(points)])


def velocity(component: str, reynolds: int) -> Function:
    """Return the rms error of u or v on its line."""
    line, file, place = LINES[component]

    def error(run):
        x, truth = read_reference(COMPUTED / file, place, f"{component}_Re{reynolds}")
        inside = (x > 0.0) & (x < 1.0)
        return float(np.sqrt(np.mean((_at(x, mean_profile(run, line, component)) - truth)[inside] ** 2)))
    return Function(f"rms of {component}", of=error)


def pressure() -> Function:
    """Return the rms error of p - p(centre) on both lines at Re = 1000, over the largest of the reference."""
    def error(run):
        wrong, largest = [], 0.0
        for line, file, place in LINES.values():
            x, truth = read_reference(COMPUTED / file, place, "p_Re1000")
            p = mean_profile(run, line, "p")
            wrong.append(_at(x, p - p[len(p) // 2]) - truth)
            largest = max(largest, np.abs(truth).max())
        return float(np.sqrt(np.mean(np.concatenate(wrong) ** 2)) / largest)
    return Function("rms of p", of=error)


def _at(places, values):
    return np.interp(places, np.linspace(0.0, 1.0, len(values)), values)
