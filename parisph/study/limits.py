"""The requirements of a study, compared with its results."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from parisph.base import markdown
from parisph.study import report
from parisph.study.definition import Required, Study
from parisph.study.plan import PlannedRun, matches
from parisph.study.results import Result
from parisph.study.set_words import text


@dataclass(frozen=True)
class Verdict:
    """A Required, applied to runs that differ only by their seed.

    where : the run, for people; values : of the starts, None for a run without a value
    """

    required: Required
    where: str
    values: tuple[float | None, ...]

    @property
    def met(self) -> bool | None:
        """Whether every start meets `must`, None without that limit. A run without a value meets no limit."""
        return self._within(self.required.must)

    @property
    def reached(self) -> bool | None:
        """Whether every start reaches `aim`, None without that limit."""
        return self._within(self.required.aim)

    def _within(self, limit: float | None) -> bool | None:
        if limit is None:
            return None
        return bool(self.values) and all(
            value is not None and (value >= limit if self.required.least else value <= limit) for value in self.values)


def verdicts(study: Study, runs: Sequence[PlannedRun], results: Sequence[Result]) -> list[Verdict]:
    """Return a Verdict for each Required and each of its runs; a run without a result meets no limit."""
    found, there = [], {one.run.key: one for one in results}
    for required in study.required:
        chosen = [run for run in runs if matches(required.where, run)]
        for group in report.families([there[run.key] for run in chosen if run.key in there]):
            values = tuple(one.number(required.of) for one in group)
            found.append(Verdict(required, _place(group[0].run), values))
        found += [Verdict(required, _place(run), (None,)) for run in chosen if run.key not in there]
    return found


def table(found: Sequence[Verdict]) -> str:
    """Return verdicts as a Markdown table, with the range of several starts."""
    return markdown.table(["required", "run", "measured", "must", "aim", "met"], [
        [one.required.of, one.where, _range(one.values), _limit(one.required, one.required.must),
         _limit(one.required, one.required.aim),
         ({None: "", True: "yes", False: "NO"}[one.met] + " (aim)" * bool(one.reached)).strip()] for one in found])


def as_lines(found: Sequence[Verdict]) -> list[dict[str, Any]]:
    """Return verdicts as a list of dicts for JSON."""
    return [{**one.required.model_dump(exclude={"where"}), "run": one.where, "values": one.values, "met": one.met,
             "reached": one.reached} for one in found]


def unmet(found: Sequence[Verdict]) -> list[str]:
    """Return one line for each requirement that is not met."""
    return [f"{one.required.of} of {one.where} is {_range(one.values)}, must be "
            f"{_limit(one.required, one.required.must)}" for one in found if one.met is False]


def _place(run: PlannedRun) -> str:
    step = f", time step {text(run.time_step)}" * ("time_step" in run.sets and "dt = " not in run.label)
    return f"{run.label}, spacing {text(run.spacing)}{step}"


def _range(values: Sequence[float | None]) -> str:
    numbers = [value for value in values if value is not None]
    ends = list(dict.fromkeys(f"{value:.4g}" for value in (min(numbers), max(numbers)))) if numbers else []
    return " to ".join(ends) + f"{' and ' * bool(ends)}none" * (len(numbers) < len(values))


def _limit(required: Required, limit: float | None) -> str:
    return "" if limit is None else f"{'>=' if required.least else '<='} {limit:.4g}"
