"""Carry out a patch study, and write its tables and pictures. In this process alone.

    DIR/results.md, .csv, .json                the tables: seeds in one line; one line for each test, and the histograms
    DIR/KIND_PATCH_FIELD[_ROWS-walls]_kK.png   errors against spacing; with _sS: against disorder
    DIR/histogram_sS_kK.png                    particles by their error
    DIR/run.lock                               names the process that writes; removed at the end
"""

import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from parisph.base import markdown
from parisph.base.errors import Interrupted, MissingLibrary, ParisphError, StoreError
from parisph.io.files import write_text
from parisph.io.lock import Lock
from parisph.study import patch_pictures, patch_report, patch_results
from parisph.study.carry_out import file_name, terminated_as_interrupted
from parisph.study.patch_results import PatchResult, Task
from parisph.study.patch_study import PatchStudy


def carry_out(study: PatchStudy, file: Path, folder: Path, only: Sequence[str] = (), progress: bool = True,
              force: bool = False, show: Callable[[str], None] = print) -> int:
    """Make all tests, write and show the results, and return the exit code, 0. Not collective.

    file : of the study; folder : where it writes; only : words of operators, all if empty
    progress : whether a line for each point is written to standard error
    force : whether to use a folder that another host seems to use; show : what the tables are given to

    Raises
    ------
    CaseError : as patch_results.tasks, or a field fails on the particles
    Interrupted : Ctrl-C, SIGTERM or SIGHUP; the tables of what was done are there
    StoreError : the folder cannot be written, or another process writes there
    """
    todo = patch_results.tasks(study, only)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        lock = Lock(folder, force)
    except OSError as error:
        raise StoreError(f"cannot write to {folder}: {error.strerror}") from None
    try:
        with terminated_as_interrupted():
            found = _results(todo, study, lock, progress)
            _conclude(found, study, file, folder, len(todo) - len(found), progress, show)
    finally:
        lock.release()
    if len(found) < len(todo):
        raise Interrupted(f"stopped with {len(todo) - len(found)} of {len(todo)} tests to do; "
                          "repeat the command to make all")
    return 0


def _results(todo: Sequence[Task], study: PatchStudy, lock: Lock, progress: bool) -> list[PatchResult]:
    """Return the results of the tests that were made before the user stopped them."""
    found: list[PatchResult] = []
    try:
        for number, task in enumerate(todo, 1):
            lock.check()
            found.append(patch_results.carry_out(task, study))
            after = todo[number] if number < len(todo) else None
            if progress and (after is None or _point(after) != _point(task)):
                _tell(f"[{number}/{len(todo)}]", [one for one in found if _point(one.task) == _point(task)])
    except KeyboardInterrupt:
        pass
    return found


def _conclude(found: Sequence[PatchResult], study: PatchStudy, file: Path, folder: Path, missing: int, progress: bool,
              show: Callable[[str], None]) -> None:
    """Write tables and pictures, and show the tables."""
    title = study.title or file.stem
    parts = [patch_report.table(found, study)] + ([f"{missing} tests have no result yet."] if missing else [])
    patch_report.save(found, study, folder, missing)
    try:
        write_text(folder / "results.md", f"# {markdown.line(title)}\n\n" + "\n\n".join(parts) + "\n")
    except OSError as error:
        raise StoreError(f"cannot write the table in {folder}: {error.strerror}") from None
    made = _pictures(found, study, title, folder, progress)
    show("\n\n".join([title, *parts]))
    for path in [folder / "results.md", folder / "results.csv", folder / "results.json", *made]:
        show(str(path))


def _pictures(found: Sequence[PatchResult], study: PatchStudy, title: str, folder: Path, progress: bool) -> list[Path]:
    """Draw the pictures and return their paths; without matplotlib, say so and return nothing."""
    made: list[Path] = []
    try:
        for name, axis, results in patch_pictures.pictures(found, study):
            made.append(folder / f"{file_name(name)}.png")
            patch_pictures.draw(results, axis, title, made[-1])
        for one in study.histograms:
            path = folder / f"{file_name(f'histogram_s{one.spacing:.4g}_k{one.jitter:g}')}.png"
            made += [path] if patch_pictures.draw_histogram(found, one, title, path) else []
    except MissingLibrary as error:
        if progress:
            print(f"no pictures: {error}", file=sys.stderr)
        return []
    except ParisphError as error:
        print(f"a picture is missing: {error}", file=sys.stderr)
    return [path for path in made if path.exists()]


def _point(task: Task) -> tuple[Any, ...]:
    return task.group, task.operator, task.spacing, task.jitter


def _tell(place: str, results: Sequence[PatchResult]) -> None:
    task = results[0].task
    norms = [f"{name} {sum(one.norms[name] for one in results if name in one.norms) / len(results):.3g}"
             for name in patch_report.names_in(results)]
    problems = dict.fromkeys(one.problem for one in results if one.problem)
    words = task.described().rpartition(", seed")[0]
    print(f"{place} {words}: {', '.join([*norms, *problems])}", file=sys.stderr, flush=True)
