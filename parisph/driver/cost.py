"""The cost of a step on this machine, for the estimate of `parisph check`.

The cost as a function of the number of particles was measured on one machine (COSTS). The speed of another machine is
taken from its earlier runs, whose costs are in a file in the user's cache folder, else from a short timing of numpy.
"""

import json
import os
import platform
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

import numpy as np

from parisph.base import environment
from parisph.case.numerics import ResolvedNumerics

# Measured with `python tests/benchmarks/step_cost.py` and with cases/small_sloshing.py on one core of
# an AMD EPYC (Zen 4): [s] per step, and per particle and step, with and without a position projection.
COSTS = {True: (1.4e-3, 3.6e-6), False: (0.7e-3, 2.7e-6)}
EACH_3D = 20e-6          # [s] per particle and step in 3D
ROWS = {"ISPH": 1.7}     # factor of methods whose rows reach farther
YARDSTICK = 2.4e-4       # [s] of `yardstick` on that machine
LEAST = 10.0             # [s]: shorter runs are not recorded
KEPT = 20                # recorded runs


def seconds_per_step(numerics: ResolvedNumerics, particles: int, dim: int = 2) -> tuple[float, str]:
    """Return the cost of a step in `dim` dimensions on one rank [s], and its basis in words. Not collective."""
    shape = _on_reference(numerics.method, _projects(numerics), particles, dim)
    runs = [run for run in _runs() if run["processor"] == _processor()]
    if not runs:
        return shape * yardstick() / YARDSTICK, "a short timing of this processor"
    like = (numerics.method, _projects(numerics), dim)
    run = min(reversed(runs), key=lambda run: ((run["method"], run["projection"], _dim(run)) != like,
                                               _dim(run) != dim, abs(np.log(run["particles"] / particles))))
    factor = run["seconds"] / _on_reference(run["method"], run["projection"], run["particles"], _dim(run))
    other = f" in {_dim(run)}D" if _dim(run) != dim else ""
    return shape * factor, f"an earlier run of {run['particles']} particles{other} on this processor"


def yardstick() -> float:
    """Return the shortest time [s] of an operation like those of a step: gather values of neighbours, combine them.

    Its arrays are made once and stay in the cache, so other jobs on the machine hardly affect it.
    """
    n, neighbours = 5000, 20
    random = np.random.default_rng(0)
    columns = (np.arange(n)[:, None] + random.integers(-300, 300, (n, neighbours))) % n
    values, x = random.random((n, neighbours)), random.random(n)
    out, total, best = np.empty((n, neighbours)), np.empty(n), np.inf
    for _ in range(60):
        start = perf_counter()
        np.take(x, columns, out=out, mode="clip")
        np.sqrt(np.multiply(out, values, out=out), out=out)
        np.einsum("ij,ij->i", out, values, out=total)
        best = min(best, perf_counter() - start)
    return best


class Clock:
    """Times the steps of a run after the first one, which may compile kernels.

    It takes CPU time, which other jobs on the machine affect less than wall time.
    """

    def __init__(self) -> None:
        self._start: float | None = None
        self._last: float | None = None
        self._steps = 0

    def step(self) -> None:
        """Count a step that has just ended. Not collective."""
        self._last = process_time()
        if self._start is None:
            self._start = self._last
        else:
            self._steps += 1

    def remember(self, numerics: ResolvedNumerics, particles: int, ranks: int, dim: int = 2) -> None:
        """Record the cost of a step of this run in `dim` dimensions for later estimates. One rank.

        Short runs, and runs with more ranks than cores or on several nodes, are not recorded. A cache folder that
        cannot be written is not an error.
        """
        seconds = (self._last or 0.0) - (self._start or 0.0)
        if seconds < LEAST or ranks > (os.cpu_count() or 1):
            return
        run = {"processor": _processor(), "method": numerics.method, "projection": _projects(numerics),
               "particles": particles, "seconds": seconds / self._steps * ranks, "dim": dim}
        try:
            path = _file()
            path.parent.mkdir(parents=True, exist_ok=True)
            own = path.with_name(f"{path.name}.{os.getpid()}")    # two runs may end at once
            own.write_text(json.dumps([*_runs(), run][-KEPT:]), encoding="utf-8")
            own.replace(path)
        except OSError:    # also if there is no home folder
            pass


def _projects(numerics: ResolvedNumerics) -> bool:
    """Return whether positions are projected, which takes a second solve."""
    return numerics.kappa > 0.0


def _dim(run: dict[str, Any]) -> int:
    """Return the number of dimensions of a recorded run; those of earlier releases were in 2D."""
    return int(run.get("dim", 2))


def _on_reference(method: str, projection: bool, particles: float, dim: int) -> float:
    """Cost of a step [s] on the machine of COSTS."""
    fixed, each = COSTS[projection]
    if dim == 3:
        each = EACH_3D
    return fixed + each * ROWS.get(method, 1.0) * particles


def _file() -> Path:
    return environment.cache_folder() / "costs.json"


def _runs() -> list[dict[str, Any]]:
    """Return the recorded runs, oldest first; none if the file is missing or invalid."""
    try:
        runs = json.loads(_file().read_text(encoding="utf-8"))
        return [run for run in runs if run["seconds"] > 0.0 and run["particles"] > 0
                and {"processor", "method", "projection"} <= run.keys()]
    except (OSError, ValueError, TypeError, KeyError, AttributeError):
        return []


def _processor() -> str:
    """Return the name of the processor: cluster nodes that share a home may differ."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
        return next(line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.processor() or platform.machine()
