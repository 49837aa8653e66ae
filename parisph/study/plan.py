"""The plan of a study: its runs, all checked before the first one begins."""

import difflib
import functools
import hashlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import parisph
from parisph.base import vocabulary
from parisph.base.errors import CaseError
from parisph.base.paths import AnyPath
from parisph.base.text import clipped, named, shown
from parisph.case import load as case_file
from parisph.case import scales, size
from parisph.case.faults import first_lines
from parisph.case.numerics import Numerics
from parisph.case.schema import Case
from parisph.case.stored import to_json
from parisph.driver import cost, estimate
from parisph.study import combinations, measuring, other_codes, set_words, study_folder
from parisph.study.combinations import SHORT, Combination
from parisph.study.definition import Study
from parisph.study.set_words import INSIDE

# The parts of parisph that decide what a run computes.
ENGINE = ("base", "case", "kernels", "parallel", "pressure", "methods", "truth", "watch", "io", "driver")
LINE = 300    # most characters of a line of a message


@dataclass(frozen=True, kw_only=True)
class PlannedRun(Combination):
    """A run of a study, with its case.

    stored : JSON text of its case, which the run reads
    key : digest of the case, the ranks and the code of parisph; a finished run with the same key is not repeated
    parts : Python files that register parts of methods for the run
    """

    case: Case
    stored: str
    key: str
    parts: tuple[str, ...] = ()

    @property
    def folder(self) -> str:
        """Name of its folder and files."""
        return f"{self.name}-{self.key[:8]}"

    @property
    def method(self) -> str:
        """Name of the method."""
        return self.case.numerics.method

    @property
    def seed(self) -> int:
        """Seed of the start."""
        return self.case.numerics.seed

    @property
    def spacing(self) -> float:
        """Particle spacing, in the unit of the study's spacings if it has some, else [m]."""
        given = self.sets.get("spacing")
        return float(self.case.numerics.spacing if given is None else set_words.value("spacing", given))

    @property
    def time_step(self) -> float | None:
        """Time step, in the unit of the study's time steps if it has some, else [s]; None if adaptive."""
        found = set_words.value("time_step", self.sets.get("time_step", self.case.numerics.time_step))
        return None if found is None else float(found)

    @property
    def step_text(self) -> str:
        """Time step as text, with its unit if that is the second."""
        if self.time_step is None:
            return "adaptive"
        return f"{self.time_step:.4g}{'' if 'time_step' in self.sets else ' s'}"

    def estimate(self) -> dict[str, Any]:
        """Return {"particles", "steps", "seconds", "basis"} for one rank, as of `parisph check`."""
        numerics = self.case.numerics.resolved()
        particles = size.counts(self.case)["all"]
        steps = estimate.estimated_steps(self.case, numerics, scales.expected(self.case))
        seconds, basis = cost.seconds_per_step(numerics, particles, self.case.dim)
        return {"particles": particles, "steps": steps, "seconds": steps * seconds, "basis": basis}


@dataclass(frozen=True)
class Plan:
    """A study whose runs have all been checked.

    study : Study; place : folder of its file; runs : all its runs; chosen : those of --only
    folder : of its results; limit : longest wall time of a run [s], None for any
    """

    study: Study
    place: Path
    runs: tuple[PlannedRun, ...]
    chosen: tuple[PlannedRun, ...]
    folder: Path
    limit: float | None

    @property
    def title(self) -> str:
        """Title of the study, else of its case."""
        return self.study.title or self.runs[0].case.title


def plan_study(study: Study, file: Path, sets: Sequence[str] = (), only: Sequence[str] = (),
               out: AnyPath | None = None, limit: float | None = None, parts: Sequence[AnyPath] = ()) -> Plan:
    """Return the plan of a study. Writes nothing. Not collective, needs no MPI.

    file : absolute path of the study file; sets : texts "name=value" of --set, for all runs
    only : names of methods or labels, all if empty; out : folder, studies/NAME by default
    limit : longest wall time of a run [s], by default that of the study
    parts : Python files that have registered parts of methods

    Raises CaseError with one line for each fault of a case, a measure, a limit or an argument.
    """
    case = (file.parent / study.case).resolve()
    runs: list[PlannedRun] = []
    problems: dict[str, str] = {}
    for one in combinations.combine(study, set_words.read(sets)):
        try:
            made = _case(case, one)
        except CaseError as error:
            problems.setdefault(clipped(str(error).replace(str(case), study.case), 4 * LINE), one.described())
            continue
        stored = to_json(made)
        own = (str(case),) if vocabulary.outside() and case.suffix == ".py" else ()
        needed = (*(str(Path(part).resolve()) for part in parts), *own)
        key = hashlib.blake2b(f"{stored}\n{one.ranks}\n{code_version()}".encode(), digest_size=16).hexdigest()
        runs.append(PlannedRun(**vars(one), case=made, stored=stored, key=key, parts=needed))
        for line in _faults(study, made, file.parent):
            problems.setdefault(line, one.described())
    if problems:
        raise CaseError(first_lines([f"{named(run)}: {line}" for line, run in problems.items()]))
    for required in study.required:
        if not any(matches(required.where, run) for run in runs):
            raise CaseError(f"required, {named(required.of)}: no run of the study has {shown(required.where)}")
    _check_different(runs)
    folder = study_folder.choose(file, out)
    if limit is not None and not limit > 0.0:
        raise CaseError(f"--limit {limit:g}: must be greater than 0, the longest wall time of a run [s]")
    return Plan(study, file.parent, tuple(runs), _chosen(runs, only), folder, limit or study.time_limit)


def _chosen(runs: Sequence[PlannedRun], only: Sequence[str]) -> tuple[PlannedRun, ...]:
    """Return the runs of some methods or labels, of all if empty. Raises CaseError for an unknown one."""
    there = list(dict.fromkeys(name for run in runs for name in (run.method, run.label)))
    for name in only:
        if name not in there:
            raise CaseError(f"--only {named(name)}: the study has no such method (it has: "
                            f"{clipped('; '.join(map(named, there)), LINE)})")
    return tuple(run for run in runs if not only or {run.method, run.label} & set(only))


@functools.lru_cache(maxsize=1)
def code_version() -> str:
    """Return the version of parisph and a digest of the sources in ENGINE."""
    root = Path(parisph.__file__).resolve().parent
    found = hashlib.blake2b(digest_size=8)
    for path in sorted(path for part in ENGINE for path in (root / part).rglob("*.py")):
        found.update(f"{path.relative_to(root)}\n".encode())
        found.update(path.read_bytes())
    return f"{parisph.__version__}+{found.hexdigest()}"


def _case(path: Path, one: Combination) -> Case:
    """Return the case of a combination.

    A method, spacing, time step or seed for which the case has no parameter is set in its numerics.
    """
    known = case_file.arguments(path) if path.suffix != ".json" else {}
    own, fields = {}, {}
    for name, value in one.sets.items():
        field = name.removeprefix(INSIDE)
        if field != name or (name in SHORT and name not in known):
            fields[field] = set_words.value(field, value)
        else:
            own[name] = value
    case = case_file.load(path, own)
    for field in fields:
        if field not in Numerics.model_fields:
            near = difflib.get_close_matches(field, Numerics.model_fields, n=1)
            raise CaseError(f"Numerics has no field {shown(field)}{f'; did you mean {near[0]!r}?' if near else ''}")
    return case.changed(**{INSIDE + field: value for field, value in fields.items()}) if fields else case


def _faults(study: Study, case: Case, folder: Path) -> Iterator[str]:
    """Yield the faults of the measures, histories and other codes of a study, for one of its cases."""
    for measure in study.errors:
        yield from measuring.faults(measure, case, folder)
    names = [probe.name for probe in case.probes]
    for name in study.histories:
        if name not in names:
            yield f"histories: the case has no probe {shown(name)} (it has: {named(', '.join(names)) or 'none'})"
    for other in study.others:
        try:
            other_codes.read(other, folder)
        except CaseError as error:
            yield str(error)


def matches(where: dict[str, Any], run: PlannedRun) -> bool:
    """Return whether a run has the values of `where`, as of Required."""
    there = {**run.sets, "method": run.method, "spacing": run.spacing, "time_step": run.time_step, "ranks": run.ranks,
             "label": run.label}
    return all(name in there and _same(there[name], value) for name, value in where.items())


def _same(a: object, b: object) -> bool:
    number = (int, float)
    if isinstance(a, number) and isinstance(b, number) and not isinstance(a, bool) and not isinstance(b, bool):
        return abs(a - b) <= 1e-9 * max(abs(a), abs(b))
    return a == b


def _check_different(runs: Sequence[PlannedRun]) -> None:
    seen: dict[str, PlannedRun] = {}
    for run in runs:
        if run.key in seen:
            raise CaseError(f"two runs of the study are the same case: {named(seen[run.key].described())}, and "
                            f"{named(run.described())}: leave one of them out")
        seen[run.key] = run
