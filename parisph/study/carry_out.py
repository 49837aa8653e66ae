"""Carry out a study: make its runs, and write its table, its pictures and its verdict.

    DIR/results.md, .csv, .json        the table: starts that differ by their seed in one line; one line for each run
    DIR/required.json                  limits and what was measured
    DIR/error_NAME.png                 a measure against spacing or time step, and against CPU time
    DIR/history_NAME.png               a probe of all runs
    DIR/cases/RUN.json                 the case of a run
    DIR/runs/RUN/                      the folder of a run, see io.layout
    DIR/ends/RUN.json, RUN.txt         how it ended, if that is final; what it printed
    DIR/run.lock                       names the process that writes; removed at the end

RUN is made of method, spacing, time step, seed, ranks and a digest of the case and the code: another case or another
version of parisph never replaces a run. Nothing is removed.
"""

import re
import signal
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager
from pathlib import Path
from types import FrameType

from parisph.base import markdown
from parisph.base.errors import Interrupted, MissingLibrary, ParisphError, StoreError
from parisph.base.text import clipped
from parisph.io.files import write_json, write_text
from parisph.study import conduct, error_plots, history_plots, limits, measures, other_codes, processes, report, results
from parisph.study.agenda import Agenda
from parisph.study.prepared import Prepared
from parisph.study.results import Result

UNDONE = 1    # exit code if a run failed, or something required is not met


def carry_out(plan: Agenda, jobs: int = 1, progress: bool = True, force: bool = False,
              show: Callable[[str], None] = print) -> int:
    """Make the chosen runs that are not done, write and show all results, and return the exit code.

    jobs : runs at once; progress : whether a line for each run is written to standard error
    force : whether to use a folder that another host seems to use; show : what the table is given to

    Returns 0, or 1 if a run failed for a reason other than its method, or something required is not met.

    Raises
    ------
    Interrupted : Ctrl-C, SIGTERM or SIGHUP; the runs that were going are ended, the table of the others is there
    StoreError : the folder cannot be written, or another process writes there; MissingLibrary : no mpirun
    """
    processes.command([], max(item.point.ranks for item in plan.chosen))    # an error if there is no mpirun
    with conduct.Held(plan.folder, force) as held, terminated_as_interrupted():
        tell = _Progress(plan, progress)
        made, stopped = _run(plan, jobs, tell, held.beat)
        found = _ordered(plan, made)
        results.add_finest(found, plan.study, plan.place)
        code = _conclude(plan, found, show, tell)
    if stopped:
        left = sum(item.key not in {one.item.key for one in found} for item in plan.chosen)
        raise Interrupted(f"stopped with {left} of {len(plan.chosen)} runs to do; repeat the command to make them")
    return code


def _run(plan: Agenda, jobs: int, tell: "_Progress", beat: Callable[[], None]) -> tuple[dict[str, Result], bool]:
    """Return {key: Result} of all runs that have one, and whether the user has stopped the study."""
    ends, found = plan.ends(), {}
    for item in plan.items:
        if item.key in ends:
            found[item.key] = results.result(item, ends[item.key], plan.folder, plan.study, plan.place)
    for item in plan.chosen:
        if item.key in found:
            tell.run(found[item.key], "there already")
    todo = [item for item in plan.chosen if item.key not in found]
    try:
        if todo:
            tell.cores(todo, jobs)
        if todo and plan.study.warm_up:
            tell.say("taking a step of each method, so that its kernels are compiled")
            conduct.warm_up(todo)
        with closing(conduct.conduct(todo, plan.folder, jobs, plan.limit, beat)) as going:    # ends them in any case
            for item, end in going:
                found[item.key] = results.result(item, end, plan.folder, plan.study, plan.place)
                tell.run(found[item.key])
                results.save(_ordered(plan, found), plan.study, plan.folder, len(plan.items) - len(found))
    except KeyboardInterrupt:
        return found, True
    return found, False


def _ordered(plan: Agenda, found: dict[str, Result]) -> list[Result]:
    return [found[item.key] for item in plan.items if item.key in found]


def _conclude(plan: Agenda, found: Sequence[Result], show: Callable[[str], None], tell: "_Progress") -> int:
    """Write table and pictures, show the table, and return the exit code."""
    verdicts = limits.verdicts(plan.study, plan.chosen, found)
    parts = [report.table(found, plan.study)] + ([limits.table(verdicts)] if verdicts else [])
    missing = len(plan.items) - len(found)
    if missing:
        parts.append(f"{missing} of {len(plan.items)} runs have no result yet.")
    results.save(found, plan.study, plan.folder, missing)
    title = plan.title
    try:
        write_json(plan.folder / "required.json", {"required": limits.as_lines(verdicts)})
        write_text(plan.folder / "results.md", f"# {markdown.line(title)}\n\n" + "\n\n".join(parts) + "\n")
    except OSError as error:
        raise StoreError(f"cannot write the table in {plan.folder}: {error.strerror}") from None
    made = _pictures(plan, found, tell)
    show("\n\n".join([title, *parts]))
    for path in [plan.folder / "results.md", plan.folder / "results.csv", plan.folder / "results.json", *made]:
        show(str(path))
    unmet, failed = limits.unmet(verdicts), [one for one in found if one.end.status == "failed"]
    if unmet:
        print("parisph: required and not met:\n" + "\n".join(f"  {line}" for line in unmet), file=sys.stderr)
    if failed:
        print(f"parisph: {len(failed)} run{'s' * (len(failed) > 1)} failed; what they said is in "
              f"{plan.folder / conduct.ENDS}", file=sys.stderr)
    return UNDONE if unmet or failed else 0


def _pictures(plan: Agenda, found: Sequence[Result], tell: "_Progress") -> list[Path]:
    """Draw the pictures and return their paths; without matplotlib, say so and return nothing."""
    study, title = plan.study, plan.title
    names, made = [measures.name_of(measure) for measure in study.errors], []
    try:
        for name, measure in zip(names, study.errors):
            others = [point for other in study.others if (other.of or names[0]) == name
                      for point in other_codes.read(other, plan.place)]
            if not measures.is_error(measure):
                continue
            path = plan.folder / f"error_{file_name(name)}.png"
            made += [path] if error_plots.draw(found, name, measures.label_of(measure), title, path, others) else []
        for probe in study.histories:
            path = plan.folder / f"history_{file_name(probe)}.png"
            made += [path] if history_plots.draw(found, probe, study, plan.place, path) else []
    except MissingLibrary as error:
        tell.say(f"no pictures: {error}")
    except ParisphError as error:
        tell.say(f"a picture is missing: {error}")
    return made


def file_name(name: str) -> str:
    """Return a name as a part of names of files."""
    return clipped(re.sub(r"[^A-Za-z0-9.+-]+", "_", name).strip("_.") or "measure", 60)


class _Progress:
    """One line for each run, on standard error."""

    def __init__(self, plan: Agenda, wanted: bool) -> None:
        self._study, self._wanted = plan.study, wanted
        self._number = {item.key: number for number, item in enumerate(plan.chosen, 1)}

    def say(self, text: str) -> None:
        if self._wanted:
            print(text, file=sys.stderr, flush=True)

    def cores(self, items: Sequence[Prepared], jobs: int) -> None:
        ranks, cores = conduct.ranks_at_once(items, jobs)
        if ranks > cores:
            self.say(f"warning: {ranks} ranks at once on {cores} cores: times on the clock will be too long")

    def run(self, one: Result, note: str = "") -> None:
        errors = [f"{name} {value:.3g}" for name, value in one.errors.items() if value is not None]
        cpu = one.values.get("cpu_seconds")
        parts = [*errors, "" if cpu is None else f"{cpu:.3g} CPU s", "" if one.survived else one.end.status,
                 one.reason, note]
        place = f"[{self._number[one.item.key]}/{len(self._number)}]"
        self.say(f"{place} {report.name_of(one)}: {'; '.join(filter(None, parts)) or one.end.status}")


@contextmanager
def terminated_as_interrupted() -> Iterator[None]:
    """Let SIGTERM, or the loss of the terminal, end a study as Ctrl-C does, so that it ends its own runs."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def interrupt(number: int, frame: FrameType | None) -> None:
        raise KeyboardInterrupt

    before = {number: signal.signal(number, interrupt) for number in (signal.SIGTERM, signal.SIGHUP)}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
