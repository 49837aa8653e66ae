"""The cases of a study's runs, all checked before the first one begins, with their estimated costs."""

import difflib
import functools
import hashlib
from collections.abc import Iterable, Iterator, Sequence
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
from parisph.study import measuring, other_codes, plan, set_words
from parisph.study.definition import Study
from parisph.study.plan import SHORT, Point
from parisph.study.set_words import INSIDE

# The parts of parisph that decide what a run computes.
ENGINE = ("base", "case", "kernels", "parallel", "pressure", "methods", "truth", "watch", "io", "driver")
LINE = 300    # characters of a line of a message


@dataclass(frozen=True)
class Prepared:
    """A run that can be made.

    Attributes
    ----------
    point : Point
    case : Case; stored : its JSON text, which is what runs
    parts : Python files that register parts of methods, which the run needs
    key : digest of the case, the ranks and parisph's own code: a finished run with the same key is not made again
    """

    point: Point
    case: Case
    stored: str
    key: str
    parts: tuple[str, ...] = ()

    @property
    def folder(self) -> str:
        """The name of its folder and files."""
        return f"{self.point.name}-{self.key[:8]}"

    @property
    def spacing(self) -> float:
        """Particle spacing as the study gives it, else [m]."""
        given = self.point.sets.get("spacing")
        return float(self.case.numerics.spacing if given is None else set_words.number_of(given))

    @property
    def time_step(self) -> float | None:
        """Time step as the study gives it, else [s]; None if it adapts."""
        given = self.point.sets.get("time_step", ...)
        if given is ...:
            return self.case.numerics.time_step
        found = set_words.value("time_step", given) if isinstance(given, str) else given
        return None if found is None else float(found)

    @property
    def step_text(self) -> str:
        """The time step for people: in the unit of the case if the study gives it, else in seconds."""
        if self.time_step is None:
            return "adaptive"
        return f"{self.time_step:.4g}{'' if 'time_step' in self.point.sets else ' s'}"

    @property
    def method(self) -> str:
        """Name of the method."""
        return self.case.numerics.method

    def estimate(self) -> dict[str, Any]:
        """Return {"particles", "steps", "seconds", "basis"} as `parisph check` estimates them, of one rank."""
        numerics = self.case.numerics.resolved()
        particles = size.counts(self.case)["all"]
        steps = estimate.estimated_steps(self.case, numerics, scales.expected(self.case))
        seconds, basis = cost.seconds_per_step(numerics, particles)
        return {"particles": particles, "steps": steps, "seconds": steps * seconds, "basis": basis}


def prepare(study: Study, file: Path, sets: Sequence[str] = (), parts: Sequence[AnyPath] = ()) -> list[Prepared]:
    """Return all runs of a study, each with its case. Not collective, needs no MPI.

    file : absolute path of the study file; sets : texts "name=value" of --set, for all runs
    parts : Python files that register parts of methods, which have been read

    Raises
    ------
    CaseError : a case, a measure or a limit of the study is wrong; one line for each problem
    """
    case = (file.parent / study.case).resolve()
    found: list[Prepared] = []
    problems: dict[str, Point] = {}
    for point in plan.points(study, set_words.read(sets)):
        try:
            made = _case(case, point)
        except CaseError as error:
            problems.setdefault(clipped(str(error).replace(str(case), study.case), 4 * LINE), point)
            continue
        text = to_json(made)
        own = (str(case),) if vocabulary.outside() and case.suffix == ".py" else ()
        needed = (*(str(Path(part).resolve()) for part in parts), *own)
        found.append(Prepared(point, made, text, _key(text, point.ranks), needed))
        for line in _faults(study, made, file.parent):
            problems.setdefault(line, point)
    if problems:
        raise CaseError(first_lines([f"{named(point.described())}: {line}" for line, point in problems.items()]))
    _check_places(study, found)
    _check_different(found)
    return found


def selected(found: Iterable[Prepared], methods: Sequence[str]) -> list[Prepared]:
    """Return the runs of some methods (or labels); all if none is named. Raises CaseError for one that is not there."""
    found = list(found)
    there = list(dict.fromkeys(name for item in found for name in (item.method, item.point.label)))
    for name in methods:
        if name not in there:
            raise CaseError(f"--only {named(name)}: the study has no such method (it has: "
                            f"{clipped('; '.join(map(named, there)), LINE)})")
    return [item for item in found if not methods or {item.method, item.point.label} & set(methods)]


@functools.lru_cache(maxsize=1)
def code_version() -> str:
    """Return parisph's version and a digest of those of its sources that decide what a run computes."""
    root = Path(parisph.__file__).resolve().parent
    found = hashlib.blake2b(digest_size=8)
    for path in sorted(path for part in ENGINE for path in (root / part).rglob("*.py")):
        found.update(f"{path.relative_to(root)}\n".encode())
        found.update(path.read_bytes())
    return f"{parisph.__version__}+{found.hexdigest()}"


def _key(text: str, ranks: int) -> str:
    return hashlib.blake2b(f"{text}\n{ranks}\n{code_version()}".encode(), digest_size=16).hexdigest()


def _case(path: Path, point: Point) -> Case:
    """Return the case of a point.

    Those of method, spacing, time step and seed that the case file has no parameter for are set in its numerics.
    """
    known = case_file.arguments(path) if path.suffix != ".json" else {}
    own, inside = {}, {}
    for name, value in point.sets.items():
        if name.startswith(INSIDE) or (name in SHORT and name not in known):
            field = name.removeprefix(INSIDE)
            inside[INSIDE + field] = set_words.value(field, value) if isinstance(value, str) else value
        else:
            own[name] = value
    case = case_file.load(path, own)
    for name in inside:
        field = name.removeprefix(INSIDE)
        if field not in Numerics.model_fields:
            near = difflib.get_close_matches(field, Numerics.model_fields, n=1)
            raise CaseError(f"Numerics has no field {shown(field)}{f'; did you mean {near[0]!r}?' if near else ''}")
    return case.changed(**inside) if inside else case


def _faults(study: Study, case: Case, folder: Path) -> Iterator[str]:
    """Yield what is wrong with the measures, histories and other codes of a study, for one of its cases."""
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


def matches(where: dict[str, Any], item: Prepared) -> bool:
    """Return whether a run is one that a Required names by its `where`."""
    there = {**item.point.sets, "method": item.method, "spacing": item.spacing, "time_step": item.time_step,
             "ranks": item.point.ranks, "label": item.point.label}
    return all(name in there and _same(there[name], value) for name, value in where.items())


def _same(a: object, b: object) -> bool:
    number = (int, float)
    if isinstance(a, number) and isinstance(b, number) and not isinstance(a, bool) and not isinstance(b, bool):
        return abs(a - b) <= 1e-9 * max(abs(a), abs(b))
    return a == b


def _check_places(study: Study, found: Sequence[Prepared]) -> None:
    for item in study.required:
        if not any(matches(item.where, one) for one in found):
            raise CaseError(f"required, {named(item.of)}: no run of the study has {shown(item.where)}")


def _check_different(found: Sequence[Prepared]) -> None:
    seen: dict[str, Prepared] = {}
    for item in found:
        if item.key in seen:
            raise CaseError(f"two runs of the study are the same case: {named(seen[item.key].point.described())}, and "
                            f"{named(item.point.described())}: leave one of them out")
        seen[item.key] = item
