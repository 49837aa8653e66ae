"""The runs of a study: all combinations of its choices, each with its name and the curve that it belongs to."""

import itertools
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from parisph.base.errors import CaseError
from parisph.base.text import clipped, named
from parisph.study.definition import Choices, Study

SHORT = {"method": "", "spacing": "s", "time_step": "dt", "seed": "seed"}    # of names of folders
LONGEST = 80    # characters of the name of a run


@dataclass(frozen=True)
class Point:
    """One run of a study.

    Attributes
    ----------
    sets : {name: value} of the parameters that the study sets: method, spacing, time_step, seed, and further ones
    ranks : number of MPI ranks
    label : name of the curve that it belongs to
    """

    sets: dict[str, Any]
    ranks: int
    label: str = ""
    given: str = field(default="", repr=False)    # the label of its variant

    @property
    def name(self) -> str:
        """Its name in files and messages, from method, spacing, time step, seed and ranks."""
        parts = [f"{short}{text(self.sets[name])}" for name, short in SHORT.items() if name in self.sets]
        parts = [*([self.given] if self.given else []), *parts, *([f"np{self.ranks}"] if self.ranks > 1 else [])]
        return clipped(re.sub(r"[^A-Za-z0-9.+-]+", "_", "-".join(parts)).strip("_-.") or "run", LONGEST)

    @property
    def further(self) -> dict[str, Any]:
        """The parameters that have no field of their own."""
        return {name: value for name, value in self.sets.items() if name not in SHORT}

    def described(self) -> str:
        """Return what distinguishes the run, for people."""
        parts = [f"{name}={text(value)}" for name, value in self.sets.items()]
        return ", ".join([*parts, *([f"{self.ranks} ranks"] if self.ranks > 1 else [])]) or "the case as it is"


def points(study: Study, sets: dict[str, Any] | None = None) -> list[Point]:
    """Return the runs of a study, in the order of its choices. Not collective.

    sets : further parameters of all runs, as of --set

    Raises
    ------
    CaseError : a parameter of `sets` is one that the study varies, or two runs are the same.
    """
    found: list[Point] = []
    for choices in study.variants or (study,):
        found += _product(study, choices, sets or {})
    seen: set[str] = set()
    for point in found:
        key = repr((sorted(point.sets.items(), key=lambda item: item[0]), point.ranks, point.given))
        if key in seen:
            raise CaseError(f"two runs of the study are the same ({named(point.described())}): leave one out, or give "
                            "their variants other labels")
        seen.add(key)
    return _labelled(found)


def text(value: Any) -> str:
    """Return a value of a parameter as --set takes it."""
    if isinstance(value, (tuple, list)):
        return ",".join(map(text, value))
    return "none" if value is None else f"{value:.10g}" if isinstance(value, float) else str(value)


def _product(study: Study, choices: Choices, sets: Mapping[str, Any]) -> Iterator[Point]:
    axes = [(name, _chosen(study, choices, several)) for name, several in
            (("method", "methods"), ("spacing", "spacings"), ("time_step", "time_steps"))]
    axes += [(name, value if isinstance(value, list) else [value])
             for name, value in {**study.parameters, **choices.parameters}.items()]
    axes.append(("seed", _chosen(study, choices, "seeds")))
    axes = [(name, values) for name, values in axes if values]
    for name in sets:
        if any(name == own and len(values) > 1 for own, values in axes):
            raise CaseError(f"--set {named(name)}: the study varies it; change it in the study file")
    for ranks in _chosen(study, choices, "ranks") or (1,):
        for values in itertools.product(*(values for _, values in axes)):
            given = dict(zip((name for name, _ in axes), values))
            yield Point({**given, **sets}, ranks, given=getattr(choices, "label", ""))


def _chosen(study: Study, choices: Choices, name: str) -> Sequence[Any]:
    values: Sequence[Any] = getattr(choices, name) or getattr(study, name)
    return values


def _labelled(found: list[Point]) -> list[Point]:
    """Return the points with their labels: method, and what else differs between curves but spacing and seed.

    The time step is part of a label only where there are several spacings, and several time steps for one of them;
    runs that differ by their time step alone are one curve. A label that the study gives is kept.
    """
    unnamed = [point for point in found if not point.given]
    names = dict.fromkeys(name for point in unnamed for name in point.sets)
    varied = [name for name in names if name not in ("method", "spacing", "time_step", "seed")
              and len({repr(point.sets.get(name, "-")) for point in unnamed}) > 1]
    if len({point.ranks for point in unnamed}) > 1:
        varied.append("ranks")
    groups: dict[tuple[Any, ...], set[Any]] = {}
    for point in found:
        like = (_label(point, varied), point.sets.get("spacing"), point.sets.get("seed"))
        groups.setdefault(like, set()).add(point.sets.get("time_step"))
    several = len({point.sets.get("spacing") for point in found}) > 1
    if several and any(len(steps) > 1 for steps in groups.values()):
        varied.append("time_step")
    return [Point(point.sets, point.ranks, _label(point, varied), point.given) for point in found]


def _label(point: Point, varied: Sequence[str]) -> str:
    parts = [point.given or str(point.sets.get("method", ""))]
    for name in varied:
        if name == "time_step" and name in point.sets:
            parts.append("adaptive" if point.sets[name] is None else f"dt = {text(point.sets[name])}")
        elif name == "ranks" and not point.given:
            parts.append(f"{point.ranks} rank{'s' * (point.ranks > 1)}")
        elif name in point.sets and not point.given:
            parts.append(f"{name.removeprefix('numerics.')} = {text(point.sets[name])}")
    return ", ".join(part for part in parts if part) or "case"
