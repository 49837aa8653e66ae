"""Make the runs of a study, several at once. Finished runs are not repeated."""

import json
import tempfile
import time
from collections.abc import Callable, Generator, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path

from parisph.base.errors import ParisphError, StoreError
from parisph.base.json_digest import MADE
from parisph.base.text import clipped, plain
from parisph.io import reader
from parisph.io.files import failing_as, read_json, write_json, write_text
from parisph.io.folder import make_inside
from parisph.study import processes
from parisph.study.plan import Plan, PlannedRun, code_version

CASES, RUNS, ENDS = "cases", "runs", "ends"    # folders inside that of a study
DIVERGED = 3         # exit code of a run that has diverged, which is a result
FIRST_STEP = 1e-3    # share of the end time for a run of about one step


@dataclass(frozen=True)
class End:
    """How a run ended.

    key : of the PlannedRun; code : exit code; wall : wall time [s]
    status : completed, diverged, out of time, failed
    reason : one line, "" for a completed run; limit : longest wall time that was allowed [s], None for any
    """

    key: str
    code: int
    wall: float
    status: str
    reason: str = ""
    limit: float | None = None

    @property
    def final(self) -> bool:
        """Whether another attempt would only repeat this result."""
        return self.status in ("completed", "diverged", "out of time")


def ends(plan: Plan) -> dict[str, End]:
    """Return {key: End} of the runs that need not be repeated."""
    found = {run.key: _end(run, plan) for run in plan.runs}
    return {key: end for key, end in found.items() if end is not None}


def _end(run: PlannedRun, plan: Plan) -> End | None:
    """Return how a run ended, None if it must be repeated, as with more time than before."""
    try:
        content = read_json(_path(run, plan, ".json"), needs_digest=True)
        end = End(**{name: content[name] for name in End.__dataclass_fields__})
    except (StoreError, KeyError, TypeError):
        return None
    if end.key != run.key or not end.final:
        return None
    if end.status == "out of time":
        return None if plan.limit is None or plan.limit > (end.limit or 0.0) else end
    return end if (plan.folder / RUNS / run.folder / "summary.json").exists() else None


def _path(run: PlannedRun, plan: Plan, ending: str) -> Path:
    return plan.folder / ENDS / f"{run.folder}{ending}"


def compile_kernels(runs: Sequence[PlannedRun]) -> None:
    """Compile kernels by a step of the coarsest case of each method, preset and number of ranks.

    Failures are ignored: the run itself will report them.
    """
    coarsest: dict[tuple[str, str, int], PlannedRun] = {}
    for run in sorted(runs, key=lambda run: -run.spacing):
        coarsest.setdefault((run.method, run.case.numerics.preset, run.ranks), run)
    with tempfile.TemporaryDirectory(prefix="parisph-study-") as place:
        for number, run in enumerate(coarsest.values()):
            case, numerics, end = Path(place) / f"{number}.json", run.case.numerics, run.case.end_time
            step = min(numerics.time_step or numerics.max_time_step or FIRST_STEP * end, end)
            case.write_text(run.case.changed(end_time=step).model_dump_json(), encoding="utf-8")
            words = ["run", str(case), "-q", "-o", f"{place}/{number}"]
            process = processes.Process(processes.command(words, run.ranks), Path(place) / "output.txt")
            try:
                while process.code is None:
                    time.sleep(processes.PAUSE)
            finally:
                processes.stop([process])


def make(runs: Sequence[PlannedRun], plan: Plan, jobs: int = 1,
         renew: Callable[[], None] = lambda: None) -> Generator[tuple[PlannedRun, End], None, None]:
    """Make runs of a plan, at most `jobs` at once, and yield each with its End as soon as it has ended.

    renew : called repeatedly meanwhile

    If the generator is closed, or an exception is raised in it (Ctrl-C), its running runs are ended. Raises StoreError
    if the folder cannot be written.
    """
    with failing_as(f"write to {plan.folder}"):
        for name in (CASES, RUNS, ENDS):
            make_inside(plan.folder / name)
    waiting = list(runs)
    running: dict[str, tuple[PlannedRun, processes.Process]] = {}
    try:
        while waiting or running:
            while waiting and len(running) < jobs:
                run = waiting.pop(0)
                running[run.key] = run, _start(run, plan)
            for key, (run, process) in list(running.items()):
                late = plan.limit is not None and process.code is None and process.seconds > plan.limit
                if late:
                    processes.stop([process])
                if process.code is not None:
                    del running[key]
                    yield run, _ended(run, plan, process, late)
            renew()
            time.sleep(processes.PAUSE)
    finally:
        processes.stop(process for _, process in running.values())


def _start(run: PlannedRun, plan: Plan) -> processes.Process:
    case, out = plan.folder / CASES / f"{run.folder}.json", plan.folder / RUNS / run.folder
    # the digest of the case does not include the parameters that made it
    write_text(case, json.dumps({**json.loads(run.stored), MADE: dict(run.case.origin)}))
    _path(run, plan, ".json").unlink(missing_ok=True)
    # --overwrite moves the files of an interrupted attempt aside
    words = ["run", str(case), "-o", str(out), "-q", "--overwrite", *(f"--parts={path}" for path in run.parts)]
    return processes.Process(processes.command(words, run.ranks), _path(run, plan, ".txt"))


def _ended(run: PlannedRun, plan: Plan, process: processes.Process, late: bool) -> End:
    """Return the End of a run whose process has ended, and write it if it is final."""
    code = process.code or 0
    if code == 0:
        status, reason = "completed", ""
    elif late:
        status, reason = "out of time", f"out of time after {plan.limit:g} s"
    else:
        status, reason = "diverged" if code == DIVERGED else "failed", _reason(run, plan, code)
    end = End(run.key, code, process.seconds, status, reason, plan.limit)
    if end.final:
        write_json(_path(run, plan, ".json"), {**asdict(end), "code_version": code_version(), "run": run.described()})
    return end


def _reason(run: PlannedRun, plan: Plan, code: int) -> str:
    """Return why a run failed: from its summary, else the error or the last line of its output."""
    with suppress(ParisphError):
        status = str((reader.Run(plan.folder / RUNS / run.folder).summary or {}).get("status", ""))
        if status.startswith("failed: "):
            return _one_line(status.removeprefix("failed: "))
    said: list[str] = []
    with suppress(OSError):
        said = _path(run, plan, ".txt").read_text(encoding="utf-8", errors="replace").split("\n")
    lines = [line for line in said if "error: " in line] or [line for line in said if line.strip()][-1:]
    word = f"ended by signal {-code}" if code < 0 else f"exit code {code}"
    return _one_line(": ".join([word, *(line.removeprefix("parisph: error: ") for line in lines[:1])]))


def _one_line(words: str) -> str:
    return clipped(plain(" ".join(words.split())), 120)
