"""Make the runs of a study, a few at once; those that are finished already are not made again."""

import json
import os
import tempfile
import time
from collections.abc import Callable, Generator, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path

from parisph.base.errors import ParisphError, StoreError
from parisph.base.json_digest import MADE
from parisph.base.text import plain
from parisph.case.schema import Case
from parisph.io import reader
from parisph.io.files import read_json, write_json, write_text
from parisph.io.folder import make_inside
from parisph.io.lock import Lock
from parisph.study import processes
from parisph.study.prepared import Prepared, code_version

CASES, RUNS, ENDS = "cases", "runs", "ends"    # folders inside that of a study
DIVERGED = 3      # exit code of a run that blew up: a result
LONGEST = 120     # characters of a reason
FIRST_STEP = 1e-3    # of the end time: a run to there takes a step, which compiles the kernels


@dataclass(frozen=True)
class End:
    """How a run ended.

    Attributes
    ----------
    key : of the Prepared; code : exit code; wall : [s] on the clock
    status : completed, diverged, out of time, failed
    reason : one line, "" for a completed run; limit : [s], the longest time it was given, None for any
    """

    key: str
    code: int
    wall: float
    status: str
    reason: str = ""
    limit: float | None = None

    @property
    def final(self) -> bool:
        """Whether this is a result, which another attempt would only repeat."""
        return self.status in ("completed", "diverged", "out of time")


def make_folders(folder: Path) -> None:
    """Make the folders of a study. Raises StoreError."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name in (CASES, RUNS, ENDS):
            make_inside(folder / name)
    except OSError as error:
        raise StoreError(f"cannot write to {folder}: {error.strerror}") from None


def end_of(item: Prepared, folder: Path, limit: float | None = None) -> End | None:
    """Return how a run ended if it need not be made again, else None.

    limit : [s], the time it would get now: a run that was given less and was out of time is made again
    """
    try:
        content = read_json(folder / ENDS / f"{item.folder}.json", needs_digest=True)
        end = End(**{name: content[name] for name in End.__dataclass_fields__})
        whole = (folder / RUNS / item.folder / "summary.json").exists()
    except (StoreError, KeyError, TypeError):
        return None
    if end.key != item.key or not end.final:
        return None
    if end.status == "out of time":
        return None if limit is None or limit > (end.limit or 0.0) else end
    return end if whole else None


def warm_up(items: Sequence[Prepared]) -> None:
    """Take a step of the smallest case of each method and number of ranks, so that their kernels are compiled.

    That such a run fails is no error here: the real one will say why.
    """
    smallest: dict[tuple[str, str, int], Prepared] = {}
    for item in items:
        like = (item.method, item.case.numerics.preset, item.point.ranks)
        if like not in smallest or item.spacing > smallest[like].spacing:
            smallest[like] = item
    with tempfile.TemporaryDirectory(prefix="parisph-study-") as place:
        for number, item in enumerate(smallest.values()):
            text = item.case.changed(end_time=_first_step(item.case)).model_dump_json()
            case = Path(place) / f"{number}.json"
            case.write_text(text, encoding="utf-8")
            words = ["run", str(case), "-q", "-o", f"{place}/{number}"]
            one = processes.Process(processes.command(words, item.point.ranks), Path(place) / "output.txt")
            try:
                while one.code is None:
                    time.sleep(processes.PAUSE)
            finally:
                processes.stop([one])


def _first_step(case: Case) -> float:
    step = case.numerics.time_step or case.numerics.max_time_step
    return min(step or FIRST_STEP * case.end_time, case.end_time)


def conduct(items: Sequence[Prepared], folder: Path, jobs: int, limit: float | None,
            beat: Callable[[], None] = lambda: None) -> Generator[tuple[Prepared, End], None, None]:
    """Make runs, at most `jobs` at once, and yield each with its End as soon as it has ended.

    folder : of the study; limit : longest time of a run [s], None for any; beat : called again and again
    If the generator is closed, or an exception is raised in it (Ctrl-C), the runs that it has started are ended.
    """
    waiting = list(items)
    running: dict[str, tuple[Prepared, processes.Process]] = {}
    try:
        while waiting or running:
            while waiting and len(running) < jobs:
                item = waiting.pop(0)
                running[item.key] = item, _start(item, folder)
            for key, (item, process) in list(running.items()):
                late = limit is not None and process.code is None and process.seconds > limit
                if late:
                    processes.stop([process])
                code = process.code
                if code is not None:
                    del running[key]
                    yield item, _ended(item, code, process.seconds, folder, limit, late)
            beat()
            time.sleep(processes.PAUSE)
    finally:
        processes.stop(process for _, process in running.values())


def _start(item: Prepared, folder: Path) -> processes.Process:
    case, out = folder / CASES / f"{item.folder}.json", folder / RUNS / item.folder
    # with the parameters that made the case, which are no part of it and of its digest
    write_text(case, json.dumps({**json.loads(item.stored), MADE: dict(item.case.origin)}))
    with suppress(FileNotFoundError):
        (folder / ENDS / f"{item.folder}.json").unlink()
    # what an interrupted attempt has left is moved aside
    words = ["run", str(case), "-o", str(out), "-q", "--overwrite", *(f"--parts={path}" for path in item.parts)]
    return processes.Process(processes.command(words, item.point.ranks), folder / ENDS / f"{item.folder}.txt")


def _ended(item: Prepared, code: int, seconds: float, folder: Path, limit: float | None, late: bool) -> End:
    """Return the End of a run that took some seconds, and keep it beside the runs if it is final."""
    status = "completed" if code == 0 else "out of time" if late else "diverged" if code == DIVERGED else "failed"
    reason = ""
    if status == "out of time":
        reason = f"out of time after {limit:g} s"
    elif status != "completed":
        reason = _reason(item, folder, code)
    end = End(item.key, code, seconds, status, reason, limit)
    if end.final:
        content = {**asdict(end), "code_version": code_version(), "run": item.point.described()}
        write_json(folder / ENDS / f"{item.folder}.json", content)
    return end


def _reason(item: Prepared, folder: Path, code: int) -> str:
    """Return why a run failed, from its summary, else from the last line that it printed."""
    with suppress(ParisphError):
        status = str((reader.Run(folder / RUNS / item.folder).summary or {}).get("status", ""))
        if status.startswith("failed: "):
            return _one_line(status.removeprefix("failed: "))
    try:
        said = (folder / ENDS / f"{item.folder}.txt").read_text(encoding="utf-8", errors="replace").split("\n")
    except OSError:
        said = []
    lines = [line for line in said if "error: " in line] or [line for line in said if line.strip()][-1:]
    word = f"ended by signal {-code}" if code < 0 else f"exit code {code}"
    return _one_line(f"{word}: {lines[0].removeprefix('parisph: error: ')}" if lines else word)


def _one_line(words: str) -> str:
    """Return the first sentence of a message, of at most LONGEST characters."""
    words = plain(" ".join(words.split()))
    return words if len(words) <= LONGEST else f"{words[:LONGEST].rpartition(' ')[0].rstrip(',;:')} ..."


class Held:
    """The lock of the folder of a study, renewed by `beat`. Raises StoreError if another study writes there."""

    def __init__(self, folder: Path, force: bool = False) -> None:
        make_folders(folder)
        self._lock = Lock(folder, force)

    def beat(self) -> None:
        """Renew it. Raises StoreError if it was taken over."""
        self._lock.check()

    def __enter__(self) -> "Held":
        return self

    def __exit__(self, *_: object) -> None:
        self._lock.release()


def ranks_at_once(items: Sequence[Prepared], jobs: int) -> tuple[int, int]:
    """Return the largest number of ranks that run at once, and the number of cores of this machine."""
    most = sum(sorted((item.point.ranks for item in items), reverse=True)[:jobs])
    return most, os.cpu_count() or 1
