"""The combinations of a study's choices, one for each run, each with its name and its curve."""

import itertools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from parisph.base.errors import CaseError
from parisph.base.text import named
from parisph.study.definition import Choices, Study
from parisph.study.set_words import text
from parisph.study.study_folder import file_name

SHORT = {"method": "", "spacing": "s", "time_step": "dt", "seed": "seed"}    # in names of folders


@dataclass(frozen=True)
class Combination:
    """The parameters of one run of a study.

    sets : {name: value} of the parameters: method, spacing, time_step, seed, and further ones
    ranks : number of MPI ranks; label : name of its curve
    """

    sets: dict[str, Any]
    ranks: int
    label: str = ""
    given: str = field(default="", repr=False)    # the label of its variant

    @property
    def name(self) -> str:
        """Name in files, from method, spacing, time step, seed and ranks."""
        parts = [f"{short}{text(self.sets[name])}" for name, short in SHORT.items() if name in self.sets]
        return file_name("-".join([self.given] * bool(self.given) + parts + [f"np{self.ranks}"] * (self.ranks > 1)),
                         "run", 80)

    @property
    def further(self) -> dict[str, Any]:
        """Parameters without a field of Choices."""
        return {name: value for name, value in self.sets.items() if name not in SHORT}

    def described(self) -> str:
        """Return the parameters as text, for people."""
        parts = [f"{name}={text(value)}" for name, value in self.sets.items()]
        return ", ".join(parts + [f"{self.ranks} ranks"] * (self.ranks > 1)) or "the case as it is"


def combine(study: Study, sets: Mapping[str, Any] | None = None) -> list[Combination]:
    """Return the combinations of a study, in the order of its choices. Not collective.

    sets : further parameters of all runs, as of --set

    Raises CaseError: the study varies a parameter of `sets`, or two runs are the same.
    """
    found: list[Combination] = []
    for choices in study.variants or (study,):
        found += _product(study, choices, sets or {})
    seen: set[str] = set()
    for one in found:
        key = repr((sorted(one.sets.items(), key=lambda item: item[0]), one.ranks, one.given))
        if key in seen:
            raise CaseError(f"two runs of the study are the same ({named(one.described())}): leave one out, or give "
                            "their variants other labels")
        seen.add(key)
    return _labelled(found)


def _product(study: Study, choices: Choices, sets: Mapping[str, Any]) -> Iterator[Combination]:
    def chosen(name: str) -> Any:
        return getattr(choices, name) or getattr(study, name)

    axes = {"method": chosen("methods"), "spacing": chosen("spacings"), "time_step": chosen("time_steps"),
            **{name: value if isinstance(value, list) else [value]
               for name, value in {**study.parameters, **choices.parameters}.items()},
            "seed": chosen("seeds")}
    axes = {name: values for name, values in axes.items() if values}
    for name in sets:
        if len(axes.get(name, ())) > 1:
            raise CaseError(f"--set {named(name)}: the study varies it; change it in the study file")
    for ranks in chosen("ranks") or (1,):
        for values in itertools.product(*axes.values()):
            yield Combination({**dict(zip(axes, values)), **sets}, ranks, given=getattr(choices, "label", ""))


def _labelled(found: list[Combination]) -> list[Combination]:
    """Return the combinations with their labels: method, and other parameters that differ, without spacing and seed.

    The time step is part of a label if there are several spacings, and several time steps for one of them. Otherwise
    runs that differ only by their time step are one curve. A label of the study is kept.
    """
    unnamed = [one for one in found if not one.given]
    names = dict.fromkeys(name for one in unnamed for name in one.further)
    varied = [name for name in names if len({repr(one.sets.get(name, "-")) for one in unnamed}) > 1]
    if len({one.ranks for one in unnamed}) > 1:
        varied.append("ranks")
    steps: dict[tuple[Any, ...], set[Any]] = {}
    for one in found:
        like = (_label(one, varied), one.sets.get("spacing"), one.sets.get("seed"))
        steps.setdefault(like, set()).add(one.sets.get("time_step"))
    several = len({one.sets.get("spacing") for one in found}) > 1
    if several and any(len(values) > 1 for values in steps.values()):
        varied.append("time_step")
    return [replace(one, label=_label(one, varied)) for one in found]


def _label(one: Combination, varied: list[str]) -> str:
    parts = [one.given or str(one.sets.get("method", ""))]
    for name in varied:
        if name == "time_step" and name in one.sets:
            parts.append("adaptive" if one.sets[name] is None else f"dt = {text(one.sets[name])}")
        elif name == "ranks" and not one.given:
            parts.append(f"{one.ranks} rank{'s' * (one.ranks > 1)}")
        elif name in one.sets and not one.given:
            parts.append(f"{name.removeprefix('numerics.')} = {text(one.sets[name])}")
    return ", ".join(filter(None, parts)) or "case"
