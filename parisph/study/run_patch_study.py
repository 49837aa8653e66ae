"""Run a patch study in this process, and write its tables and pictures.

    DIR/results.md, .csv, .json                the tables: seeds in one line; one line for each test, and the histograms
    DIR/KIND_PATCH_FIELD[_ROWS-walls]_kK.png   errors against spacing; with _sS: against disorder
    DIR/histogram_sS_kK.png                    particles by their error
    DIR/run.lock                               names the process that writes; removed at the end
"""

import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from parisph.base.errors import Interrupted, MissingLibrary, ParisphError
from parisph.study import patch_pictures, patch_report, patch_tasks, study_folder
from parisph.study.patch_study import PatchStudy
from parisph.study.patch_tasks import PatchResult, Task
from parisph.study.study_folder import file_name


def run_patch_study(study: PatchStudy, file: Path, folder: Path, only: Sequence[str] = (), progress: bool = True,
                    force: bool = False, show: Callable[[str], None] = print) -> int:
    """Make all tests, write and show the results, and return the exit code, 0. Not collective.

    file : of the study; folder : of the results; only : words of operators, all if empty
    progress : whether a line for each point is written to standard error
    force : whether to use a folder that another host seems to use; show : function that shows the tables

    Raises CaseError : as patch_tasks.tasks, or a field fails on the particles
    Interrupted : Ctrl-C, SIGTERM or SIGHUP, after the tables of the finished tests were written
    StoreError : the folder cannot be written, or another process writes there
    """
    todo = patch_tasks.tasks(study, only)
    with study_folder.hold(folder, force) as renew:
        found = _results(todo, study, renew, progress)
        title, missing = study.title or file.stem, len(todo) - len(found)
        patch_report.save(found, study, folder, missing)
        parts = [patch_report.table(found, study)] + [f"{missing} tests have no result yet."] * bool(missing)
        study_folder.publish(folder, title, parts, _pictures(found, study, title, folder, progress), show)
    if missing:
        raise Interrupted(f"stopped with {missing} of {len(todo)} tests to do; repeat the command to make all")
    return 0


def _results(todo: Sequence[Task], study: PatchStudy, renew: Callable[[], None], progress: bool) -> list[PatchResult]:
    """Return the results of the tests, or of those made before Ctrl-C."""
    found: list[PatchResult] = []
    try:
        for number, task in enumerate(todo, 1):
            renew()
            found.append(patch_tasks.apply(task, study))
            after = todo[number] if number < len(todo) else None
            if progress and (after is None or _point(after) != _point(task)):
                _tell(f"[{number}/{len(todo)}]", [one for one in found if _point(one.task) == _point(task)])
    except KeyboardInterrupt:
        pass
    return found


def _pictures(found: Sequence[PatchResult], study: PatchStudy, title: str, folder: Path, progress: bool) -> list[Path]:
    """Draw the pictures and return their paths; without matplotlib, print a note."""
    made: list[Path] = []
    try:
        for name, axis, results in patch_pictures.pictures(found, study):
            path = folder / f"{file_name(name, 'picture')}.png"
            patch_pictures.draw(results, axis, title, path)
            made.append(path)
        for one in study.histograms:
            path = folder / f"{file_name(f'histogram_s{one.spacing:.4g}_k{one.jitter:g}', 'picture')}.png"
            made += [path] if patch_pictures.draw_histogram(found, one, title, path) else []
    except MissingLibrary as error:
        if progress:
            print(f"no pictures: {error}", file=sys.stderr)
    except ParisphError as error:
        print(f"a picture is missing: {error}", file=sys.stderr)
    return made


def _point(task: Task) -> tuple[Any, ...]:
    return task.group, task.operator, task.spacing, task.jitter


def _tell(place: str, results: Sequence[PatchResult]) -> None:
    task = results[0].task
    norms = [f"{name} {sum(one.norms[name] for one in results if name in one.norms) / len(results):.3g}"
             for name in patch_report.names_in(results)]
    problems = dict.fromkeys(one.problem for one in results if one.problem)
    words = task.described().rpartition(", seed")[0]
    print(f"{place} {words}: {', '.join([*norms, *problems])}", file=sys.stderr, flush=True)
