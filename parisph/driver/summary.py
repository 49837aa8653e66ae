"""The content of summary.json, also after a failure."""

import json
import resource
from collections.abc import Mapping
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

import numpy as np
from mpi4py import MPI

from parisph.base.errors import ParisphError
from parisph.base.fields import FLUID
from parisph.base.log import logger
from parisph.case import scales
from parisph.case.schema import Case
from parisph.driver import diagnostics, precheck, probe_gaps
from parisph.driver.load_balance import LoadBalance
from parisph.driver.simulation import Simulation
from parisph.geometry import build
from parisph.io import reader
from parisph.io.files import on_first
from parisph.io.store import Store
from parisph.methods import catalogue
from parisph.methods.reports import StepReport
from parisph.truth import arrivals, impacts, overtopping, reflected, verdict

FEW, SHARE = 4, 1e-3    # isolated particles at the start, and their share of all, without a note
DRAINED = 0.1           # share of the water that has left, above which the status names it
BODY = 0.05             # share of isolated particles in a step, above which they are more than spray


class Account:
    """Collects the cost and the diagnostics of a run, over restarts.

    state : of the checkpoint of a continued run, None for a new run
    """

    def __init__(self, state: Mapping[str, Any] | None = None) -> None:
        before: dict[str, Any] = state["account"] if state else {
            "wall": 0.0, "cpu": 0.0, "phases": {}, "cpu_phases": {}, "fallbacks": 0}
        self.before = before
        self.wall, self.cpu = perf_counter(), process_time()
        self.fallbacks = 0
        self.divergence: float | None = None
        self.diagnostics: diagnostics.Diagnostics | None = None    # from `start` on
        self._balance: LoadBalance | None = None                   # from `start` on
        self._uneven: list[str] = []              # lines about gauges, after the run
        self._gaps: dict[str, str] = {}           # of probes, after the run
        self._notes = list(before.get("notes", ()))
        self._isolated = before.get("isolated", [0, 0.0])    # the most in a step, and when [s]
        # {limit: time [s] at which it was passed}
        self.passed: dict[str, float] = dict(before.get("passed", {}))
        self._fluid = 0
        self._walls: int | None = None    # particles on walls, from `start` on

    def start(self, simulation: Simulation, isolated: int = 0) -> None:
        """Measure energy and volume at the start of the run, or of this part of it. Collective.

        isolated : particles without contact with a free surface in the first solve (Simulation.solve_start)
        """
        p = simulation.particles
        self._fluid = fluid = p.comm.allreduce(int(np.count_nonzero(p.kind == FLUID)))
        self._walls = int(p.n_global) - fluid
        if isolated > max(FEW, SHARE * fluid):
            self._notes.append(f"{isolated} particles had no contact with a free surface at the start (of {fluid} "
                               "fluid particles and the walls): p = 0 was set only at the highest of them")
            logger.warning(self._notes[-1])
        about = catalogue.warning(simulation.numerics)
        if about and not self.before.get("notes"):
            self._notes.append(f"method {simulation.numerics.method}: {about}")
            logger.warning(self._notes[-1])
        if "notes" not in self.before:
            self._notes += self._ahead(simulation)
        start = {name: self.before.get(name) for name in ("energy", "volume")}    # of a checkpoint by an older parisph
        self.diagnostics = diagnostics.Diagnostics(simulation, self.before, start)
        self.measure(simulation)
        self._balance = LoadBalance(simulation)

    def _ahead(self, simulation: Simulation) -> list[str]:
        """Return the warnings before the run, the same on all ranks, and log them. Collective."""
        comm, case = simulation.comm, simulation.case
        found = on_first(comm, "check the case for warnings",    # the estimate depends on the machine
                         lambda: [*precheck.early_warnings(case, build.counts(case), scales.expected(case), comm.size)])
        told: list[str] = comm.bcast(found)
        for text in told if comm.rank == 0 else ():
            logger.warning(text)
        return told

    def measure(self, simulation: Simulation) -> None:
        """Measure energy and volume now. Collective."""
        if self.diagnostics is not None:
            self.diagnostics.measure(simulation)

    def look_back(self, simulation: Simulation, store: Store) -> None:
        """Read the files of the whole run for warnings about gauges and probes. Collective."""
        folder = store.folder
        found = on_first(simulation.comm, f"read {folder}", lambda: _looked_back(simulation.case, store))
        self._uneven, self._gaps = simulation.comm.bcast(found) or ([], {})

    def step(self, simulation: Simulation, report: StepReport) -> None:
        """Count a step. Collective."""
        self.fallbacks += report.fallbacks
        self.divergence = getattr(report, "divergence", None)    # only of a projection
        isolated = getattr(report, "isolated", 0)
        if isolated > self._isolated[0]:
            self._isolated = [isolated, simulation.time]
        if self.diagnostics is not None:
            self.diagnostics.step(simulation)

    def news(self, time: float) -> list[str]:
        """Return one line for each limit exceeded for the first time, at `time` [s]. Not collective."""
        found = {} if self.diagnostics is None else self.diagnostics.passed()
        new = [name for name in found if name not in self.passed]
        self.passed.update(dict.fromkeys(new, time))
        return [found[name] for name in new]

    def status(self) -> str:
        """Return the status of a completed run. Not collective."""
        lost = 0.0 if self.diagnostics is None else self.diagnostics.lost
        if lost > DRAINED:
            return f"completed with warnings: {lost:.0%} of the water has left"
        return "completed with warnings" if self.warnings() else "completed"

    def warnings(self) -> list[str]:
        """Return one line for each warning of the whole run, the most serious first. Not collective."""
        checks, (most, time) = self.diagnostics, self._isolated
        found = [*([] if checks is None else checks.of_loss()), *self._notes]
        if most > BODY * self._fluid > 0.0:
            found.append(f"{most} particles had no contact with a free surface at t = {time:.4g} s (of {self._fluid} "
                         "fluid particles and the walls): the level of their pressure is not fixed")
        return [*found, *({} if checks is None else checks.passed()).values(), *self._uneven]

    def state(self, simulation: Simulation, comm: MPI.Comm | None = None) -> dict[str, Any]:
        """Return the data that a checkpoint needs to continue the account. Collective.

        comm : the ranks whose cost counts, by default all
        """
        comm = comm or simulation.comm
        found = simulation.timers.reduce(comm)
        return {"account": {
            **self.before, "wall": self.before["wall"] + perf_counter() - self.wall,
            "cpu": self.before["cpu"] + comm.allreduce(process_time() - self.cpu),
            "phases": _sums(self.before["phases"], {name: one["max"] for name, one in found.items()}),
            "cpu_phases": _sums(self.before["cpu_phases"], {name: one["cpu"] for name, one in found.items()}),
            "fallbacks": self.before["fallbacks"] + self.fallbacks, "notes": self._notes, "isolated": self._isolated,
            "passed": self.passed, **(self.diagnostics.state() if self.diagnostics else {}),
        }}

    def summary(self, simulation: Simulation, store: Store, status: str,
                comm: MPI.Comm | None = None) -> dict[str, Any]:
        """Return the content of summary.json, with the last measured volume and energy, the same on all ranks.

        Collective.

        comm : the ranks whose cost counts, by default all; with MPI.COMM_SELF it is not collective

        Raises StoreError on every rank if the files of the run cannot be read.
        """
        s, comm = simulation, comm or simulation.comm
        account = self.state(s, comm)["account"]
        peak = comm.allgather(_peak_memory())
        content = {
            "case": s.case.title, "method": s.numerics.method, "preset": s.numerics.preset, "ranks": s.comm.size,
            "particles": int(s.particles.n_global),
            "fluid_particles": None if self._walls is None else int(s.particles.n_global) - self._walls,
            "wall_particles": self._walls, "spacing": s.numerics.spacing, "steps": s.steps, "time": s.time,
            "status": status, "warnings": self.warnings(), "wall_seconds": account["wall"],
            "cpu_seconds": account["cpu"],
            "phases": account["phases"], "cpu_phases": account["cpu_phases"], "fallbacks": account["fallbacks"],
            "shares": self._balance.content(s, comm) if self._balance else None,
            **({"volume_drift": None, "energy_drift": None, "driven": s.case.driven} if self.diagnostics is None
               else self.diagnostics.conservation.content()),
            "left": vars(s.left) | ({"unit": "m3"} if s.case.dim == 3 else {}), "touched": self._gaps,
            "divergence": self.divergence,
            "peak_memory_mb": peak,
            "parisph_version": store.about["parisph_version"], "versions": json.loads(str(store.about["versions"])),
            "petsc_options": store.about["petsc_options"],
        }
        found = on_first(comm, f"read {store.folder}", lambda: _from_files(s.case, store))
        content |= found or {}
        everywhere: dict[str, Any] = comm.bcast(content)
        return everywhere


def _sums(before: Mapping[str, float], now: Mapping[str, float]) -> dict[str, float]:
    return {name: before.get(name, 0.0) + now.get(name, 0.0)
            for name in (*before, *(n for n in now if n not in before))}


def _from_files(case: Case, store: Store) -> dict[str, Any]:
    """Return the entries of the summary from the files of the whole run, with its earlier parts."""
    try:
        run = reader.open_run(store.folder)
        iterations, steps = None, run.steps
        counts = steps["iterations"] if "iterations" in (steps.dtype.names or ()) else np.empty(0)
        if len(counts):
            iterations = {"median": float(np.median(counts)), "p99": float(np.percentile(counts, 99)),
                          "max": int(counts.max())}
        return {"iterations": iterations, "errors": verdict.errors(case, run), "arrivals": arrivals.arrivals(case, run),
                "passed": overtopping.passed(case, run), "reflection": reflected.of_case(case, run),
                "peaks": impacts.peaks(case, run), "greatest": impacts.asked(case, run)}
    except ParisphError as error:
        return {"iterations": None, "errors": {"unavailable": str(error)}, "arrivals": {}, "passed": {},
                "reflection": None, "peaks": {}, "greatest": {}}


def _looked_back(case: Case, store: Store) -> tuple[list[str], dict[str, str]]:
    try:
        run = reader.open_run(store.folder)
        return diagnostics.of_gauges(case, run), probe_gaps.gaps(case, run)
    except ParisphError:    # reported by _from_files
        return [], {}


def _peak_memory() -> float:
    """Return the largest resident memory of this process so far [MB].

    VmHWM of Linux starts with the program; getrusage inherits the value of the parent process.
    """
    try:
        line = next(line for line in Path("/proc/self/status").read_text().splitlines() if line.startswith("VmHWM:"))
        return int(line.split()[1]) * 1024 / 1e6
    except (OSError, StopIteration, ValueError):
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / 1e6
