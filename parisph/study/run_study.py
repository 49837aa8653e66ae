"""Run a study: make its runs, and write its table, its pictures and what it requires.

    DIR/results.md, .csv, .json        the table: starts that differ by their seed in one line; one line for each run
    DIR/required.json                  limits and what was measured
    DIR/error_NAME.png                 a measure against spacing or time step, and against CPU time
    DIR/history_NAME.png               a probe of all runs
    DIR/cases/RUN.json                 the case of a run
    DIR/runs/RUN/                      the folder of a run, see io.layout
    DIR/ends/RUN.json, RUN.txt         how it ended, if that is final; its output
    DIR/run.lock                       names the process that writes; removed at the end

RUN consists of method, spacing, time step, seed, ranks and a digest of the case and the code: another case or version
of parisph never replaces a run. Nothing is removed.
"""

import os
import sys
from collections.abc import Callable, Sequence
from contextlib import closing
from pathlib import Path

from parisph.base.errors import Interrupted, MissingLibrary, ParisphError
from parisph.io.files import failing_as, write_json
from parisph.study import error_plots, history_plots, limits, measures, other_codes, report, results, runs, study_folder
from parisph.study.plan import Plan, PlannedRun
from parisph.study.processes import command
from parisph.study.results import Result

UNDONE = 1    # exit code if a run failed, or a requirement is not met


def run_study(plan: Plan, jobs: int = 1, progress: bool = True, force: bool = False,
              show: Callable[[str], None] = print) -> int:
    """Make the chosen runs that are not done, write and show all results, and return the exit code.

    jobs : number of runs at once; progress : whether a line for each run is written to standard error
    force : whether to use a folder that another host seems to use; show : function that shows the table

    Returns 0, or UNDONE if a run failed without having diverged, or a requirement is not met.

    Raises Interrupted : Ctrl-C, SIGTERM or SIGHUP; running runs are ended, and the table of the others is written
    StoreError : the folder cannot be written, or another process writes there; MissingLibrary : no mpirun
    """
    command([], max(run.ranks for run in plan.chosen))    # raises without mpirun
    with study_folder.hold(plan.folder, force) as renew:
        tell = _Progress(plan, progress)
        made, stopped = _results(plan, jobs, tell, renew)
        found = _ordered(plan, made)
        results.add_finest(found, plan)
        code = _conclude(plan, found, show, tell)
    if stopped:
        left = sum(run.key not in made for run in plan.chosen)
        raise Interrupted(f"stopped with {left} of {len(plan.chosen)} runs to do; repeat the command to make them")
    return code


def _results(plan: Plan, jobs: int, tell: "_Progress", renew: Callable[[], None]) -> tuple[dict[str, Result], bool]:
    """Return {key: Result} of all finished runs, and whether the user has stopped the study."""
    ends = runs.ends(plan)
    found = {run.key: results.result(run, ends[run.key], plan) for run in plan.runs if run.key in ends}
    for run in plan.chosen:
        if run.key in found:
            tell.run(found[run.key], "there already")
    todo = [run for run in plan.chosen if run.key not in found]
    try:
        if todo:
            tell.cores(todo, jobs)
        if todo and plan.study.warm_up:
            tell.say("compiling kernels by a step of each method")
            runs.compile_kernels(todo)
        with closing(runs.make(todo, plan, jobs, renew)) as going:    # ends runs after an error too
            for run, end in going:
                found[run.key] = results.result(run, end, plan)
                tell.run(found[run.key])
                results.save(_ordered(plan, found), plan)
    except KeyboardInterrupt:
        return found, True
    return found, False


def _ordered(plan: Plan, found: dict[str, Result]) -> list[Result]:
    return [found[run.key] for run in plan.runs if run.key in found]


def _conclude(plan: Plan, found: Sequence[Result], show: Callable[[str], None], tell: "_Progress") -> int:
    """Write table and pictures, show the table, and return the exit code."""
    verdicts = limits.verdicts(plan.study, plan.chosen, found)
    missing = len(plan.runs) - len(found)
    parts = [report.table(found, plan.study), *([limits.table(verdicts)] if verdicts else []),
             *([f"{missing} of {len(plan.runs)} runs have no result yet."] if missing else [])]
    results.save(found, plan)
    with failing_as(f"write to {plan.folder}"):
        write_json(plan.folder / "required.json", {"required": limits.as_lines(verdicts)})
    study_folder.publish(plan.folder, plan.title, parts, _pictures(plan, found, tell), show)
    unmet, failed = limits.unmet(verdicts), [one for one in found if one.end.status == "failed"]
    if unmet:
        print("parisph: required and not met:\n" + "\n".join(f"  {line}" for line in unmet), file=sys.stderr)
    if failed:
        print(f"parisph: {len(failed)} run{'s' * (len(failed) > 1)} failed; their output is in "
              f"{plan.folder / runs.ENDS}", file=sys.stderr)
    return UNDONE if unmet or failed else 0


def _pictures(plan: Plan, found: Sequence[Result], tell: "_Progress") -> list[Path]:
    """Draw the pictures and return their paths; without matplotlib, print a note."""
    study, made = plan.study, []
    names = [measures.name_of(measure) for measure in study.errors]
    try:
        for name, measure in zip(names, study.errors):
            others = [point for other in study.others if (other.of or names[0]) == name
                      for point in other_codes.read(other, plan.place)]
            path = plan.folder / f"error_{study_folder.file_name(name, 'measure')}.png"
            if measures.is_error(measure) and error_plots.draw(found, name, measures.label_of(measure), plan.title,
                                                               path, others):
                made.append(path)
        for probe in study.histories:
            path = plan.folder / f"history_{study_folder.file_name(probe, 'measure')}.png"
            made += [path] if history_plots.draw(found, probe, plan, path) else []
    except MissingLibrary as error:
        tell.say(f"no pictures: {error}")
    except ParisphError as error:
        tell.say(f"a picture is missing: {error}")
    return made


class _Progress:
    """One line for each run, on standard error."""

    def __init__(self, plan: Plan, wanted: bool) -> None:
        self._wanted = wanted
        self._number = {run.key: number for number, run in enumerate(plan.chosen, 1)}

    def say(self, text: str) -> None:
        if self._wanted:
            print(text, file=sys.stderr, flush=True)

    def cores(self, todo: Sequence[PlannedRun], jobs: int) -> None:
        ranks, cores = sum(sorted((run.ranks for run in todo), reverse=True)[:jobs]), os.cpu_count() or 1
        if ranks > cores:
            self.say(f"warning: {ranks} ranks at once on {cores} cores: wall times will be too long")

    def run(self, one: Result, note: str = "") -> None:
        errors = [f"{name} {value:.3g}" for name, value in one.errors.items() if value is not None]
        cpu = one.values.get("cpu_seconds")
        parts = [*errors, "" if cpu is None else f"{cpu:.3g} CPU s", "" if one.survived else one.end.status,
                 one.reason, note]
        place = f"[{self._number[one.run.key]}/{len(self._number)}]"
        self.say(f"{place} {report.name_of(one)}: {'; '.join(filter(None, parts)) or one.end.status}")
