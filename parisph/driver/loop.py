"""The run: steps, probes, snapshots, checkpoints, and how it ends."""

import signal
from dataclasses import asdict, fields
from pathlib import Path
from time import perf_counter

import numpy as np
from mpi4py import MPI

from parisph.base import log
from parisph.base.errors import CaseError, Interrupted, ParisphError, StoreError, agree
from parisph.case.schema import Case
from parisph.driver.progress import Progress
from parisph.driver.simulation import Simulation
from parisph.driver.summary import Account
from parisph.io import checkpoint, probes
from parisph.io.store import Store, provenance
from parisph.methods.projection import StepReport
from parisph.pressure.trial import versions

WALL_CLOCK = 600.0  # seconds between checkpoints at the latest, whatever the case says
STOP, SAVE = 2, 1   # what ranks ask of each other at the end of a step
UNITS = {"dt": "s", "setup_seconds": "s", "solve_seconds": "s"}


def run(case, comm, out, petsc_options=None, progress=True):
    """Run a case from its start into the folder `out`, and return the summary. Collective.

    Parameters
    ----------
    case : Case; comm : mpi4py communicator; out : folder, without an earlier run
    petsc_options : list of str; progress : whether rank 0 tells how far it is

    Raises
    ------
    CaseError, SolverDiverged, ParticleLost, StoreError, Interrupted : on every rank; the folder
    then holds summary.json and everything up to there.
    """
    simulation = Simulation(case, comm, petsc_options)
    store = Store.create(comm, out, case.model_dump_json(), _about(simulation, petsc_options), case.output.fields)
    return _Run(simulation, store, Account.new(simulation), progress).go(first=True)


def restart(path, comm, until=None, out=None, petsc_options=None, progress=True):
    """Go on from the last checkpoint of a run, or from a given one, on any number of ranks. Collective.

    path : folder of a run or checkpoint file; until : new end time [s]; out : folder for what
    follows, by default the same. Otherwise as `run`.
    """
    path, folder = _find(path, comm)
    saved = checkpoint.read(comm, path)
    case = Case.model_validate_json(saved.case)
    if until is not None:
        case = case.model_copy(update={"end_time": float(until)})
    if case.end_time <= saved.time:
        raise CaseError(f"end_time = {case.end_time:g} s: the checkpoint {path} is of {saved.time:g} s already; "
                        "ask for more with --until")
    simulation = Simulation(case, comm, petsc_options, start=saved)
    store = Store.resume(comm, out or folder, case.model_dump_json(), saved.time, saved.step,
                         _about(simulation, petsc_options), case.output.fields)
    return _Run(simulation, store, Account.resumed(simulation, saved.state), progress).go(first=False)


class _Run:
    """What happens around the steps of one run."""

    def __init__(self, simulation, store, account, progress):
        self.simulation, self.store, self.account = simulation, store, account
        self.comm, self.case = simulation.comm, simulation.case
        self.samplers = probes.build(self.case, self.comm)
        self.progress = Progress(self.case.end_time, progress and self.comm.rank == 0)
        self.last_checkpoint = None
        self.saved_at = perf_counter()
        self.snapshots = _Times(self.case.output.every, self.case.output.times)
        self.checkpoints = _Times(self.case.output.checkpoint_every, ())

    def go(self, first):
        log.start(self.comm, self.store.folder / "run.log")
        status = "failed"
        try:
            with _Signals() as signals:
                self._open(first)
                while not self.simulation.finished():
                    self._step(signals)
            self._save()
            status = "completed"
        except ParisphError as error:
            status = "interrupted" if isinstance(error, Interrupted) else f"failed: {error}"
            raise self._explained(error) from error
        finally:
            self.progress.close()
            summary = self._close(status)
        return summary

    def _open(self, first):
        s = self.simulation
        self.store.add_series("steps", {f.name: UNITS.get(f.name, "") for f in fields(StepReport)},
                              "one line a step")
        for sampler in self.samplers:
            self.store.add_series(f"probes/{sampler.name}", sampler.columns, sampler.title)
        s.domain.refresh()
        self.account.start(s, self.samplers)
        if first:
            log.logger.info(f"{self.case.title}: {s.particles.n_global} particles on {self.comm.size} "
                            f"rank{'s' * (self.comm.size > 1)}, into {self.store.folder}")
            if self.case.output.every or 0.0 in self.case.output.times:
                self.store.snapshot(s.particles, s.time, s.steps)
            self._save()
        self.snapshots.skip(s.time)
        self.checkpoints.skip(s.time)

    def _step(self, signals):
        s = self.simulation
        report = s.advance()
        values = {"steps": tuple(asdict(report).values())}
        if s.steps % self.case.output.probe_every == 0:
            with s.timers("probes"):
                sampled = probes.sample_all(self.samplers, s.particles, s.domain, s.time)
            values.update({f"probes/{name}": line for name, line in sampled.items()})
        with s.timers("store"):
            self.store.append(s.time, s.steps, values)
            if self.snapshots.due(s.time + 0.5 * report.dt):
                self.store.snapshot(s.particles, s.time, s.steps)
        self.account.step(report)
        self.progress.step(s, report)
        asked = self._asked(signals)
        if asked or self.checkpoints.due(s.time + 0.5 * report.dt):
            self._save()
        if asked >= STOP:
            raise Interrupted(f"stopped at t = {s.time:g} s by signal {signals.seen or 'on another rank'}; "
                              f"go on with: parisph restart {self.store.folder}")

    def _asked(self, signals):
        late = self.comm.rank == 0 and perf_counter() - self.saved_at > WALL_CLOCK
        return self.comm.allreduce(STOP if signals.seen else SAVE if late else 0, op=MPI.MAX)

    def _save(self):
        s = self.simulation
        with s.timers("store"):
            self.last_checkpoint = self.store.checkpoint(s.particles, s.time, s.steps, s.dt or 0.0,
                                                         self.account.state(s))
        self.saved_at = perf_counter()

    def _explained(self, error):
        """Return the error with what a user needs to go on: where, who, and from which checkpoint."""
        if isinstance(error, (Interrupted, StoreError)):
            return error
        s = self.simulation
        where = f"step {s.steps + 1}, t = {s.time:g} s"
        suspects = suspicious(s)
        text = f"{error}\n  at {where}\n  particles to look at:\n" + "\n".join(f"    {line}" for line in suspects)
        text += f"\n  last good checkpoint: {self.last_checkpoint}" if self.last_checkpoint else ""
        return type(error)(text)

    def _close(self, status):
        """Write the summary whatever has happened, free everything, and return the summary."""
        summary = self.account.summary(self.simulation, self.samplers, self.store, status)
        self.store.summary(summary)
        self.store.close()
        log.stop()
        self.simulation.destroy()
        return summary


class _Times:
    """When something is due: every so often, and at given times."""

    def __init__(self, every, times):
        self.every, self.times, self.count = every, sorted(times), 0

    def due(self, time):
        """Return whether a time has been reached since it was asked last."""
        before = self.count
        self.skip(time)
        return self.count > before

    def skip(self, time):
        self.count = sum(t <= time for t in self.times)
        if self.every:
            self.count += int(np.floor(time / self.every * (1.0 + 1e-12)))


class _Signals:
    """Ctrl-C and SIGTERM ask the run to finish its step; a second one ends it at once."""

    def __enter__(self):
        self.seen = None
        self._old = {}
        for number in (signal.SIGINT, signal.SIGTERM):
            try:
                self._old[number] = signal.signal(number, self._handle)
            except ValueError:  # not in the main thread (a notebook's worker): leave signals alone
                break
        return self

    def _handle(self, number, frame):
        if self.seen:
            raise KeyboardInterrupt
        self.seen = signal.Signals(number).name

    def __exit__(self, *_):
        for number, handler in self._old.items():
            signal.signal(number, handler)


def suspicious(simulation, count=5):
    """Describe the particles that look worst: not finite first, then the fastest. Collective."""
    p = simulation.particles
    speed = np.linalg.norm(p.u, axis=1)
    bad = ~(np.isfinite(p.x).all(axis=1) & np.isfinite(speed) & np.isfinite(p.p))
    key = np.where(bad, np.inf, np.nan_to_num(speed))
    worst = np.argsort(-key)[:count]
    mine = [(float(key[i]), f"id {p.id[i]} role {p.role[i]} at {np.round(p.x[i], 5).tolist()} m, "
                            f"u {np.round(p.u[i], 3).tolist()} m/s, p {p.p[i]:.4g} Pa") for i in worst]
    found = sorted((item for part in p.comm.allgather(mine) for item in part), key=lambda item: -item[0])
    return [text for _, text in found[:count]]


def _find(path, comm):
    """Return (checkpoint file, folder of its run), the same on every rank."""
    path, error, found = Path(path), None, None
    if comm.rank == 0:
        if path.is_dir():
            there = checkpoint.paths(path / "checkpoints")
            found = (there[-1], path) if there else None
            error = None if there else StoreError(f"{path} holds no checkpoint to go on from")
        elif path.is_file():
            found = (path, path.resolve().parent.parent)
        else:
            error = StoreError(f"{path}: no such folder or file")
    agree(comm, error)
    return comm.bcast(found)


def _about(simulation, petsc_options):
    return provenance(simulation.numerics.method, " ".join(petsc_options or ()), **versions())
