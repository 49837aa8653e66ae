"""The cavity driven by its lid, at Re = 100, 400 and 1000, against grid codes.

Velocities are over the speed of the lid.

Means over the last ten lid times of runs from rest. The reference is cases/computed/cavity_u.csv and cavity_v.csv.
"""

from dataclasses import dataclass

import numpy as np

from parisph.base.errors import StoreError
from parisph.base.table import read_reference
from parisph.io.reader import Run
from tests.launch import ROOT
from tests.validation.record import Bench, Row

COMPUTED = ROOT / "cases" / "computed"
# probe: file, column, component
LINES = {"vertical": ("cavity_u.csv", "y", "u"), "horizontal": ("cavity_v.csv", "x", "v")}
POINTS = 101
MEAN = 10.0       # lid times


@dataclass(frozen=True)
class Flow:
    """A run: Reynolds number, particles per side, lid times, time step in s/U, and what is required and aimed at."""

    reynolds: int
    side: int
    end: float
    step: float
    most: float
    aim: float


FLOWS = (Flow(100, 50, 22.0, 0.5, 0.01, 0.007), Flow(400, 60, 45.0, 0.5, 0.02, 0.01),
         Flow(1000, 100, 60.0, 0.25, 0.03, 0.02))
PRESSURE = 0.03    # rms at Re = 1000, over the largest


def rows(bench: Bench) -> list[Row]:
    """Return the errors of velocity and pressure, the drift of the energy and the cost, for each Reynolds number."""
    found = []
    for flow in FLOWS:
        name = f"cavity, Re = {flow.reynolds}, {flow.side} x {flow.side}"
        try:
            reference(flow.reynolds, "vertical"), reference(flow.reynolds, "horizontal")
        except StoreError as error:
            print(f"  {name}: left out, {error}", flush=True)
            continue
        run, summary = bench.run(f"cavity_{flow.reynolds}", "lid_driven_cavity", reynolds=flow.reynolds,
                                 spacing=1.0 / flow.side, end_time=flow.end, time_step=flow.step, points=POINTS)
        found += [Row(f"{name}: rms of {component}", errors(run, flow.reynolds, line), flow.most, aim=flow.aim,
                      cost=summary["cpu_seconds"]) for line, (_, _, component) in LINES.items()]
        if flow.reynolds == 1000:
            found.append(Row(f"{name}: rms of p over the largest", pressure_error(run), PRESSURE))
        found.append(Row(f"{name}: change of the energy in the last {MEAN:g} lid times", energy_drift(run), 0.02))
    return found


def reference(reynolds: int, line: str) -> tuple[np.ndarray, np.ndarray]:
    """Return places and velocities (n,) of the reference inside the cavity. Raises StoreError."""
    file, place, component = LINES[line]
    x, u = read_reference(COMPUTED / file, place, f"{component}_Re{reynolds}")
    inside = (x > 0.0) & (x < 1.0)
    return x[inside], u[inside]


def mean_profile(run: Run, line: str, quantity: str) -> np.ndarray:
    """Return the mean over the last lid times of u, v or p at the points of a line (points,)."""
    found = run.probe(line)
    late = found["time"] > found["time"][-1] - MEAN
    points = sum(name.startswith("u_") for name in found.dtype.names)
    return np.array([found[f"{quantity}_{k}"][late].mean() for k in range(points)])


def at(places: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return values (n,), given evenly from 0 to 1, at places (m,), by cubic polynomials."""
    step = 1.0 / (len(values) - 1)
    first = np.clip((places / step).astype(int) - 1, 0, len(values) - 4)
    t = places / step - first
    weights = (-(t - 1) * (t - 2) * (t - 3) / 6, t * (t - 2) * (t - 3) / 2, -t * (t - 1) * (t - 3) / 2,
               t * (t - 1) * (t - 2) / 6)
    return sum(weight * values[first + k] for k, weight in enumerate(weights))


def errors(run: Run, reynolds: int, line: str) -> float:
    """Return the rms error of the velocity across a line, over the speed of the lid (1 m/s)."""
    x, u = reference(reynolds, line)
    return float(np.sqrt(np.mean((at(x, mean_profile(run, line, LINES[line][2])) - u) ** 2)))


def pressure_error(run: Run) -> float:
    """Return the rms error of p - p(centre) on both lines at Re = 1000, walls included, over the largest of the
    reference."""
    wrong, largest = [], 0.0
    for line, (file, place, _) in LINES.items():
        x, truth = read_reference(COMPUTED / file, place, "p_Re1000")
        p = mean_profile(run, line, "p")
        wrong.append(at(x, p - p[len(p) // 2]) - truth)
        largest = max(largest, np.abs(truth).max())
    return float(np.sqrt(np.mean(np.concatenate(wrong) ** 2)) / largest)


def energy_drift(run: Run) -> float:
    """Return the change of the kinetic energy between the halves of the mean, over its mean."""
    found = run.probe("energy")
    late = found["time"] > found["time"][-1] - MEAN
    first, second = np.array_split(found["kinetic"][late], 2)
    return float(abs(second.mean() - first.mean()) / found["kinetic"][late].mean())
