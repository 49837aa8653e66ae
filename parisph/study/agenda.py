"""The agenda of a study: its runs, all checked, which of them are done, and what the others cost."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from parisph.base import paths
from parisph.base.errors import CaseError
from parisph.base.paths import AnyPath
from parisph.base.text import named
from parisph.driver import estimate
from parisph.study import conduct, prepared, report, study_file
from parisph.study.conduct import End
from parisph.study.definition import Study
from parisph.study.prepared import Prepared


@dataclass(frozen=True)
class Agenda:
    """A study whose runs have all been checked.

    Attributes
    ----------
    study : Study; place : folder of its file
    items : all its runs; chosen : those of --only
    folder : where it writes; limit : longest time of a run on the clock [s], None for any
    """

    study: Study
    place: Path
    items: tuple[Prepared, ...]
    chosen: tuple[Prepared, ...]
    folder: Path
    limit: float | None

    @property
    def title(self) -> str:
        """One line for people: that of the study, else of its case."""
        return self.study.title or self.items[0].case.title

    def ends(self) -> dict[str, End]:
        """Return {key: End} of the runs that need not be made again."""
        found = {item.key: conduct.end_of(item, self.folder, self.limit) for item in self.items}
        return {key: end for key, end in found.items() if end is not None}


def agenda(path: AnyPath, sets: Sequence[str] = (), only: Sequence[str] = (),
           out: AnyPath | None = None, limit: float | None = None) -> Agenda:
    """Return the Agenda of a study file, after all its runs have been checked. Writes nothing. Not collective.

    sets : texts "name=value" for all runs; only : names of methods or labels; out : folder, studies/NAME by default
    limit : longest time of a run on the clock [s], by default that of the study

    Raises
    ------
    CaseError : the file, a run, a measure or a limit is wrong.
    """
    study, file = study_file.read(path)
    if not isinstance(study, Study):
        raise CaseError(f"{named(path)}: a {type(study).__name__} has no runs of a case")
    return of_study(study, file, sets, only, out, limit)


def of_study(study: Study, file: Path, sets: Sequence[str] = (), only: Sequence[str] = (), out: AnyPath | None = None,
             limit: float | None = None, parts: Sequence[AnyPath] = ()) -> Agenda:
    """Return the Agenda of a Study, as `agenda`. file : absolute path of its file; parts : files that its runs need."""
    items = prepared.prepare(study, file, sets, parts)
    folder = folder_for(file, out)
    if limit is not None and not limit > 0.0:
        raise CaseError(f"--limit {limit:g}: must be greater than 0, the longest time of a run on the clock [s]")
    chosen = prepared.selected(items, only)
    return Agenda(study, file.parent, tuple(items), tuple(chosen), folder, limit or study.time_limit)


def folder_for(file: Path, out: AnyPath | None) -> Path:
    """Return the folder of the study in a file: `out`, or studies/NAME. Raises CaseError if it cannot be one."""
    folder = Path("studies") / file.stem if out is None else paths.checked(out, "out")
    if (folder / "case.json").exists():
        raise CaseError(f"{named(folder)} holds a run: give another folder for the study with -o DIR")
    if folder.exists() and not folder.is_dir():
        raise CaseError(f"{named(folder)} is a file: give a folder for the study with -o DIR")
    return folder


def listing(plan: Agenda) -> str:
    """Return the runs of a study with their estimated costs as text. Runs nothing."""
    ends, rows, left, basis = plan.ends(), [], 0.0, ""
    for number, item in enumerate(plan.chosen, 1):
        found, done = item.estimate(), ends.get(item.key)
        left, basis = left + (0.0 if done else found["seconds"]), found["basis"]
        rows.append([item.point.label, str(number), f"{item.spacing:.4g}", item.step_text,
                     str(item.case.numerics.seed), str(item.point.ranks), str(found["particles"]), str(found["steps"]),
                     estimate.duration(found["seconds"]), done.status if done else "to do"])
    head = ["run", "n", "spacing", "time step", "seed", "ranks", "particles", "steps", "CPU time", "state"]
    todo = sum(item.key not in ends for item in plan.chosen)
    return "\n\n".join([
        f"{plan.title}, into {plan.folder}", report.markdown(head, rows),
        f"{len(rows)} runs, {todo} to do: about {estimate.duration(left)} of CPU time (estimated from {basis})"])
