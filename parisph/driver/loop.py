"""A run: steps, probes, snapshots, checkpoints, and its end."""

import gc
import logging
import signal
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
from mpi4py import MPI

from parisph.base import log
from parisph.base.errors import Interrupted, ParisphError, StoreError
from parisph.base.paths import AnyPath, checked
from parisph.base.signals import Signals
from parisph.case.schema import Case
from parisph.case.stored import to_json
from parisph.driver import diagnostics, run_folder
from parisph.driver.cost import Clock
from parisph.driver.failure import explained
from parisph.driver.peaks import PeakFlows
from parisph.driver.probing import Line, Watch
from parisph.driver.progress import Progress
from parisph.driver.schedule import Times
from parisph.driver.simulation import Simulation, finished
from parisph.driver.summary import Account
from parisph.io import checkpoint, room_file
from parisph.io import made as how
from parisph.io.checkpoint import Checkpoint, Share
from parisph.io.files import on_first, together, write_json
from parisph.io.layout import run_of
from parisph.io.store import Store, provenance
from parisph.parallel.guard import guarded
from parisph.pressure.options import as_text
from parisph.pressure.trial import versions
from parisph.watch import instruments
from parisph.watch.sampling import Sampler

WALL_CLOCK = 600.0  # [s]: longest wall time between checkpoints
SAVE = 1            # request of a rank at the end of a step; plus the number of a signal to stop


def run(case: Case, comm: MPI.Comm, out: AnyPath, petsc_options: list[str] | None = None, progress: bool = True,
        overwrite: bool = False, force: bool = False) -> dict[str, Any]:
    """Run a case from its start into the folder `out`, and return the summary, the same dict on every rank. Collective.

    case : Case; comm : mpi4py communicator; out : folder, without an earlier run
    petsc_options : list of str; progress : whether rank 0 shows progress
    overwrite : whether to move an earlier run in `out` to `out`.old, `out`.old-2, ...; nothing is ever removed
    force : whether to use a folder locked by a process that may still run

    Raises CaseError, SolverDiverged, ParticleLost, StoreError or Interrupted on every rank; the folder then contains
    summary.json and all results so far, unless it already contained a run (CaseError).
    """
    with guarded(comm, "run"), _signals(comm) as signals:
        made, old = (on_first(comm, f"start a run in {out}",
                              lambda: run_folder.new_folder(checked(out, "out"), overwrite, force)) or (None, None))
        with (run_folder.left_only_if_used(made, old), run_folder.locked(comm, Path(out), force) as lock,
              Progress(case.end_time, progress, comm.rank == 0) as shown,
              _built(case, comm, petsc_options) as simulation):
            samplers = instruments.build(case, simulation.comm)
            store = Store.create(simulation.comm, out, to_json(simulation.case, how.of_run(comm, case)),
                                 _about(simulation), case.output.fields, lock)
            room_file.keep(simulation.comm, store.folder, case, store.run)
            store.walls = simulation.wall_cells
            store.notes += [(logging.INFO, line) for line in how.repeated(case)]
            if old is not None:
                store.notes.append((logging.INFO, f"the earlier {'run' if (old / 'case.json').exists() else 'content'} "
                                                  f"was moved to {old}"))
            return _Run(simulation, samplers, store, Account(), shown).go(signals, first=True)


def restart(path: AnyPath, comm: MPI.Comm, until: float | None = None, out: AnyPath | None = None,
            petsc_options: list[str] | None = None, progress: bool = True, force: bool = False) -> dict[str, Any]:
    """Continue a run from its last checkpoint, or from a given one, on any number of ranks. Collective.

    A run killed before its first checkpoint begins again. One killed after its last checkpoint is completed.

    path : folder of a run or checkpoint file; until : new end time [s]; out : folder to continue in,
    without an earlier run; the same folder by default. Other parameters as for `run`.

    Raises as `run`, and on every rank before anything is changed: CaseError if `out` contains another run, if results
    of the same folder after the checkpoint would be lost, or if nothing is left to do; StoreError for a folder in use
    or a damaged file.
    """
    with guarded(comm, "restart"), _signals(comm) as signals:
        return _restarted(signals, path, comm, until, out, petsc_options, progress, force)


def _restarted(signals: Signals, path: AnyPath, comm: MPI.Comm, until: float | None, out: AnyPath | None,
               petsc_options: list[str] | None, progress: bool, force: bool) -> dict[str, Any]:
    folder = together(comm, f"find the run {path}", lambda: run_of(checked(path, "path")))
    other = together(comm, f"continue in {out}", lambda: None if out is None else checked(out, "out"))
    elsewhere = together(comm, f"continue in {out}", lambda: other is not None and other.resolve() != folder.resolve())
    target = other if other is not None and elsewhere else folder
    made, _ = on_first(comm, f"continue the run in {target}",
                       lambda: run_folder.new_folder(target) if elsewhere
                       else run_folder.check_run(folder, path)) or (None, None)
    with run_folder.left_only_if_used(made), run_folder.locked(comm, target, force) as lock:
        found = run_folder.find(Path(path), folder, comm)
        saved = checkpoint.read(comm, found) if found else None
        case, name, edits = together(comm, f"read the case of {folder}",
                                     lambda: run_folder.case_of(saved, found, folder, until))
        together(comm, f"read the walls of {folder}", lambda: room_file.remember(folder, case))
        done = saved is not None and finished(case, saved.time)
        on_first(comm, f"continue the run in {target}",
                 lambda: run_folder.check_useful(saved, case, found, folder, elsewhere, done, until))
        with (Progress(case.end_time, progress, comm.rank == 0) as shown,
              _built(case, comm, petsc_options, saved) as simulation):
            samplers = instruments.build(case, simulation.comm)
            time, step = (saved.time, saved.step) if saved else (-np.inf, -1)
            series = ("steps", *(f"probes/{sampler.name}" for sampler in samplers))
            store = Store.resume(simulation.comm, target, to_json(simulation.case, how.of_restart(comm, case)), time,
                                 step, _about(simulation),
                                 case.output.fields, lock, name, series,
                                 saved.state.get("checkpoints", [found.name]) if saved and found else ())
            room_file.keep(simulation.comm, store.folder, case, store.run)
            store.walls = simulation.wall_cells
            if saved:
                store.notes += [(logging.INFO, line) for line in edits]
                store.notes.insert(0, (logging.INFO,
                                       f"the checkpoint {found}, t = {saved.time:.6g} s, is continued in {target}"
                                                     f"{f'; earlier results are in {folder}' * elsewhere}"))
            state = saved.state if saved else None
            run = _Run(simulation, samplers, store, Account(state), shown, state,
                       folder if saved and elsewhere else None, saved.flows if saved else ())
            if saved and done:
                run.saved_step, run.last_checkpoint = saved.step, found
            return run.go(signals, first=saved is None)


@contextmanager
def _signals(comm: MPI.Comm) -> Iterator[Signals]:
    """Activate Signals; a second signal ends all ranks at once."""
    with Signals.active() as signals:
        signals.over(comm)
        yield signals


@contextmanager
def _built(case: Case, comm: MPI.Comm, petsc_options: list[str] | None,
           start: Checkpoint | None = None) -> Iterator[Simulation]:
    """Make a Simulation and free it at the end, except after an error on only one rank."""
    simulation = Simulation(case, comm, petsc_options, start)
    try:
        yield simulation
    except BaseException as error:
        if simulation.agreed(error):
            simulation.destroy()
        raise
    simulation.destroy()


class _Run:
    """The steps of one run, its output and its end."""

    def __init__(self, simulation: Simulation, samplers: list[Sampler], store: Store, account: Account,
                 progress: Progress, state: Mapping[str, Any] | None = None, source: Path | None = None,
                 flows: Sequence[Share] = ()) -> None:
        """state, flows : of the checkpoint; source : folder of the earlier run, if different."""
        self.simulation, self.store, self.account = simulation, store, account
        self.comm, self.case = simulation.comm, simulation.case
        self.progress = progress
        self.last_checkpoint: Path | None = None
        self.saved_step: int | None = None
        self.saved_at = perf_counter()
        self.clock = Clock()
        state, self.source = state or {}, source
        self.peaks = PeakFlows(simulation, samplers, self.case.output.fields, state.get("peaks"),
                           state.get("waiting"), flows)
        self.watch = Watch(simulation, samplers, self.case.output, self.peaks, state.get("watch"))
        self.snapshots = Times(self.case.output.every, self.case.output.times)
        self.checkpoints = Times(self.case.output.checkpoint_every)

    def go(self, signals: Signals, first: bool) -> dict[str, Any]:
        """Take all steps and return the summary. Collective.

        signals : requests to stop the run; first : whether this is a new run, not a restart
        """
        error, self.signals = None, signals
        signals.left = f"{self.store.folder} has no checkpoint yet: parisph restart {self.store.folder} begins it again"
        try:
            # the checks of each step report more than numpy
            with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
                self._open(first)
                self._pause()
                while not self.simulation.finished():
                    self._step()
                    # disabled by the command line; if a script disabled it, it stays so
                    if not gc.isenabled() and gc.get_freeze_count():
                        gc.freeze()
                        gc.enable()
                self._save()
        except BaseException as problem:
            if not isinstance(problem, ParisphError) or not self.simulation.agreed(problem):
                self._abandon(problem)
                raise
            error = explained(problem, self.simulation, self.last_checkpoint,
                              diagnostics.first_rise(self.account.passed))
        return self._close(error)

    def _open(self, first: bool) -> None:
        s, path = self.simulation, self.store.folder / "run.log"
        level = logging.INFO if self.progress.wanted else logging.WARNING
        together(self.comm, f"write {path}", lambda: log.start(self.comm, path, level))
        self.store.add_series("steps", s.columns, "one line per step")
        for sampler in self.watch.samplers:
            self.store.add_series(f"probes/{sampler.name}", sampler.columns, self.watch.title(sampler),
                                  self.watch.reached(sampler))
        log.logger.info(f"{self.case.title}: {s.particles.n_global} particles on {self.comm.size} "
                        f"rank{'s' * (self.comm.size > 1)}, {'into' if first else 'continuing in'} {self.store.folder}")
        for kind, line in self.store.notes:
            log.logger.log(kind, line)
        isolated = 0
        if first:
            isolated = s.solve_start()
        else:
            s.domain.refresh()
        if self.source is not None:
            self.peaks.bring(self.source)
        elif self.peaks.replaced:
            self.peaks.bring(self.store.folder, self.peaks.replaced)
        self.watch.look_at_last()
        self.account.start(s, isolated)
        if first:
            self._write(self.watch.at_start())
            self._snapshot()
            self._save()
        # as in _step: or what was due at the checkpoint would be due again
        self.snapshots.skip(s.nearest)
        self.checkpoints.skip(s.nearest)

    def _step(self) -> None:
        s = self.simulation
        self.watch.before_step(s.choose_step())
        report = s.advance()
        lines = self.watch.after_step()
        with s.timers("store"):
            self._write(lines, {"steps": tuple(report.line().values())})
            if self.snapshots.due(s.nearest) or s.finished():    # before the checkpoint
                self._snapshot()
            self.peaks.write(self.store)
        with s.timers("probes"):
            self.account.step(s, report)
        self._judge()
        self.clock.step()
        self.progress.step(s, report)
        self._pause(self.checkpoints.due(s.nearest))

    def _judge(self) -> None:
        """Warn once of each exceeded limit. Raises SolverDiverged on all ranks if the flow has exploded."""
        for line in self.account.news(self.simulation.time):
            self.progress.close()
            log.logger.warning(line)
        if self.account.diagnostics is not None:
            self.account.diagnostics.check()

    def _write(self, lines: Sequence[Line], of_step: Mapping[str, Any] | None = None) -> None:
        """Write the lines of the step, then those of probes. Collective."""
        s = self.simulation
        named = [(time, step, {f"probes/{name}": line for name, line in values.items()})
                 for time, step, values in lines]
        self.store.append_all([(s.time, s.steps, of_step or {}), *named])

    def _pause(self, due: bool = False) -> None:
        """Save a checkpoint if it is due or requested, and stop if requested. Collective."""
        s, asked = self.simulation, self._asked()
        if due or asked:
            self._save()
        if asked > SAVE and not s.finished():
            raise Interrupted(f"stopped at t = {s.time:.6g} s by {signal.Signals(asked - SAVE).name}; "
                              f"continue with: parisph restart {self.store.folder}")

    def _asked(self) -> int:
        """Return the request of any rank: 0, SAVE, or SAVE + the number of a signal to stop. Collective."""
        late = self.comm.rank == 0 and perf_counter() - self.saved_at > WALL_CLOCK
        seen = self.signals.seen
        asked = np.array([SAVE + seen if seen else SAVE * late])
        if self.comm.size > 1:
            self.comm.Allreduce(MPI.IN_PLACE, asked, op=MPI.MAX)
        return int(asked[0])

    def _snapshot(self) -> None:
        s = self.simulation
        self._note_options()
        s.complete(self.case.output.fields)
        with s.method.shown():
            self.store.snapshot(s.particles, s.time, s.steps)

    def _save(self) -> None:
        s = self.simulation
        if s.steps == self.saved_step:
            return
        self._note_options()
        with s.timers("probes"):
            self.account.measure(s)
        with s.timers("store"):
            self.peaks.write(self.store, all_of_them=True)
            waiting, flows = self.peaks.waiting()
            state = {**self.account.state(s), "peaks": self.peaks.state(), "waiting": waiting,
                     "watch": self.watch.state(), "left": vars(s.left), "passed": s.passages.state(),
                     **s.method.state()}
            self.last_checkpoint = self.store.checkpoint(s.particles, s.time, s.steps, s.dt or 0.0, state, flows)
        self.saved_at, self.saved_step = perf_counter(), s.steps
        self.signals.left = (f"the last checkpoint is {self.last_checkpoint}; "
                             f"continue with: parisph restart {self.store.folder}")

    def _abandon(self, fault: BaseException) -> None:
        """Write a summary after an error that may be on this rank only. Not collective.

        Other ranks may wait elsewhere, so the summary contains only the data of this rank.
        """
        self.progress.close()
        status = f"failed: rank {self.comm.rank}: {type(fault).__name__}: {fault}".removesuffix(": ")
        if isinstance(fault, KeyboardInterrupt):
            status = "interrupted"
        log.logger.debug(status)
        own = self.store.folder / f"summary-{self.comm.rank}.json"    # all ranks may write at once
        try:
            write_json(own, self.account.summary(self.simulation, self.store, status, MPI.COMM_SELF))
            own.replace(self.store.folder / "summary.json")
        except Exception as problem:    # must not hide the fault
            log.logger.debug(f"no summary: {problem}")
        finally:
            log.stop()

    def _note_options(self) -> None:
        """Store the current PETSc options for later files: they change with the size of the system."""
        self.store.about["petsc_options"] = as_text(self.simulation.method.about())

    def _close(self, error: ParisphError | None) -> dict[str, Any]:
        """Write the summary, and return it or raise the error. Collective."""
        self.progress.close()
        if error is None:
            self.account.look_back(self.simulation, self.store)
        status = self.account.status()
        for line in self.account.warnings():
            log.logger.warning(line)
        if error is not None:
            status = "interrupted" if isinstance(error, Interrupted) else f"failed: {error}"
        log.logger.debug(status)    # only into the log file
        summary: dict[str, Any] = {}
        self._note_options()
        try:
            if not isinstance(error, StoreError):
                self.peaks.write(self.store, all_of_them=True)
                self.peaks.write_last(self.store)
            summary = self.account.summary(self.simulation, self.store, status)
            self.store.summary(summary)
            self.store.close()
        except StoreError as problem:
            error = error or problem
        finally:
            log.stop()
        if error is not None:
            raise error
        if self.comm.rank == 0:
            self.clock.remember(self.simulation.numerics, self.simulation.particles.n_global, self.comm.size,
                                self.simulation.case.dim)
        return summary


def _about(simulation: Simulation) -> dict[str, str]:
    return provenance(simulation.numerics.method, as_text(simulation.method.about()), **versions())
