"""The account of a run: what summary.json says, also of a run that failed."""

import json
import resource
from pathlib import Path
from time import perf_counter, process_time

import numpy as np

from parisph.base.errors import ParisphError
from parisph.case.schema import Energy, Volume
from parisph.io import probes, reader
from parisph.io.files import on_first
from parisph.study import truth


class Account:
    """Collects what a run costs and conserves, over restarts.

    Made by `Account.new` or `Account.resumed`.
    """

    def __init__(self, before):
        self.before = before
        self.wall, self.cpu = perf_counter(), process_time()
        self.fallbacks = 0
        self.divergence = None
        self.last = {"energy": None, "volume": None}

    @classmethod
    def new(cls):
        """Return the account of a run that begins."""
        return cls({"wall": 0.0, "cpu": 0.0, "phases": {}, "cpu_phases": {}, "fallbacks": 0, "energy": None, "volume": None})

    @classmethod
    def resumed(cls, state):
        """Return the account of a run that goes on from a checkpoint's state."""
        return cls(state["account"])

    def start(self, simulation):
        """Take energy and volume at the start of the run. Collective."""
        watched = (Energy(name="energy"), *((Volume(name="volume"),) if simulation.case.dim == 2 else ()))
        self._watch = probes.build(simulation.case.model_copy(update={"probes": watched}), simulation.comm)
        self.measure(simulation)
        if self.before["energy"] is None:
            self.before.update(self.last)

    def measure(self, simulation):
        """Take energy and volume as they are now. Collective."""
        found = probes.sample_all(self._watch, simulation.particles, simulation.domain, simulation.time)
        named = {w.name: dict(zip(w.columns, found[w.name])) for w in self._watch}
        self.last = {"energy": named["energy"]["total"], "volume": named.get("volume", {}).get("cell")}

    def step(self, report):
        """Count a step. Not collective."""
        self.fallbacks += (report.fallback != "") + (report.position_fallback != "")
        self.divergence = report.divergence

    def state(self, simulation, comm=None):
        """Return what a checkpoint must hold to go on counting. Collective.

        comm : the ranks whose cost counts, by default all of the simulation
        """
        comm, timers = comm or simulation.comm, simulation.timers
        wall = {name: seconds["max"] for name, seconds in timers.reduce(comm).items()}
        return {"account": {
            **self.before, "wall": self.before["wall"] + perf_counter() - self.wall,
            "cpu": self.before["cpu"] + comm.allreduce(process_time() - self.cpu),
            "phases": _sums(self.before["phases"], wall),
            "cpu_phases": _sums(self.before["cpu_phases"], timers.reduce_cpu(comm)),
            "fallbacks": self.before["fallbacks"] + self.fallbacks,
        }}

    def summary(self, simulation, store, status, comm=None):
        """Return the content of summary.json, with volume and energy as measured last, the same on all ranks. Collective.

        comm : the ranks whose cost counts, by default all; MPI.COMM_SELF makes it not collective
        Raises StoreError on every rank if the files of the run cannot be read.
        """
        s, comm = simulation, comm or simulation.comm
        account = self.state(s, comm)["account"]
        peak = comm.allgather(_peak_memory())
        content = {
            "case": s.case.title, "method": s.numerics.method, "preset": s.numerics.preset, "ranks": s.comm.size,
            "particles": int(s.particles.n_global), "spacing": s.numerics.spacing, "steps": s.steps, "time": s.time,
            "status": status, "wall_seconds": account["wall"], "cpu_seconds": account["cpu"],
            "phases": account["phases"], "cpu_phases": account["cpu_phases"], "fallbacks": account["fallbacks"],
            "volume_drift": _drift(self.last["volume"], account["volume"]),
            "energy_drift": _drift(_with(self.last["energy"], s.left.energy), account["energy"]), "driven": s.case.driven,
            "left": vars(s.left),
            "divergence": self.divergence, "peak_memory_mb": peak,
            "parisph_version": store.about["parisph_version"], "versions": json.loads(store.about["versions"]),
            "petsc_options": store.about["petsc_options"],
        }
        found = on_first(comm, f"read {store.folder}", lambda: _from_files(s.case, store))
        if comm.rank == 0:
            content["iterations"], content["errors"] = found
        return comm.bcast(content)


def _with(energy, left):
    """Return the energy of the fluid in the tank and of that which has left it, None if it is not known."""
    return None if energy is None else energy + left


def _sums(before, now):
    return {name: before.get(name, 0.0) + now.get(name, 0.0) for name in (*before, *(n for n in now if n not in before))}


def _drift(end, start):
    if end is None or not start or not np.isfinite(end):
        return None
    return end / start - 1.0


def _from_files(case, store):
    """Return (iterations, errors) of the whole run, as its files hold them, earlier parts included."""
    try:
        run = reader.open_run(store.folder)
        counts = run.steps["iterations"]
        iterations = None
        if len(counts):
            iterations = {"median": float(np.median(counts)), "p99": float(np.percentile(counts, 99)),
                          "max": int(counts.max())}
        return iterations, truth.errors(case, run)
    except ParisphError as error:
        return None, {"unavailable": str(error)}


def _peak_memory():
    """Return the largest resident memory that this process has had [MB].

    Linux's own mark begins with the program; that of getrusage is inherited from whatever started it.
    """
    try:
        line = next(line for line in Path("/proc/self/status").read_text().splitlines() if line.startswith("VmHWM:"))
        return int(line.split()[1]) * 1024 / 1e6
    except (OSError, StopIteration, ValueError):
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / 1e6
