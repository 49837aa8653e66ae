"""What a study requires, against what its runs gave."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from parisph.study import report
from parisph.study.definition import Required, Study
from parisph.study.plan import text
from parisph.study.prepared import Prepared, matches
from parisph.study.results import Result


@dataclass(frozen=True)
class Verdict:
    """One limit on runs that differ by their seed only.

    Attributes
    ----------
    of, where : the measure and the run, for people
    required : the Required; values : of the starts, None for a run without a value
    """

    of: str
    where: str
    required: Required
    values: tuple[float | None, ...]

    @property
    def met(self) -> bool | None:
        """Whether every start meets `must`, None where there is none. A run without a value meets nothing."""
        return self._within(self.required.must)

    @property
    def reached(self) -> bool | None:
        """Whether every start reaches `aim`, None where there is none."""
        return self._within(self.required.aim)

    def _within(self, limit: float | None) -> bool | None:
        if limit is None:
            return None
        return bool(self.values) and all(
            value is not None and (value >= limit if self.required.least else value <= limit) for value in self.values)


def verdicts(study: Study, items: Sequence[Prepared], results: Sequence[Result]) -> list[Verdict]:
    """Return a Verdict for each limit and each of the runs that it applies to; one without a result meets nothing."""
    found = []
    for required in study.required:
        chosen = [item for item in items if matches(required.where, item)]
        there = {one.item.key: one for one in results}
        for group in report.families([there[item.key] for item in chosen if item.key in there]):
            values = tuple(one.number(required.of) for one in group)
            found.append(Verdict(required.of, _place(group[0].item), required, values))
        found += [Verdict(required.of, _place(item), required, (None,)) for item in chosen if item.key not in there]
    return found


def table(found: Sequence[Verdict]) -> str:
    """Return verdicts as a Markdown table; of several starts their range is given."""
    head = ["required", "run", "measured", "must", "aim", "met"]
    return report.markdown(head, [[one.of, one.where, _range(one.values), _limit(one.required, one.required.must),
                                   _limit(one.required, one.required.aim), _word(one)] for one in found])


def as_lines(found: Sequence[Verdict]) -> list[dict[str, Any]]:
    """Return verdicts as a list of dicts for JSON."""
    return [{"of": one.of, "run": one.where, "values": one.values, "must": one.required.must, "aim": one.required.aim,
             "least": one.required.least, "met": one.met, "reached": one.reached} for one in found]


def unmet(found: Sequence[Verdict]) -> list[str]:
    """Return one line for each requirement that is not met."""
    return [f"{one.of} of {one.where} is {_range(one.values)}, must be {_limit(one.required, one.required.must)}"
            for one in found if one.met is False]


def _place(item: Prepared) -> str:
    parts = [item.point.label, f"spacing {text(item.spacing)}"]
    if "time_step" in item.point.sets and "dt = " not in item.point.label:
        parts.append(f"time step {text(item.time_step)}")
    return ", ".join(parts)


def _range(values: Sequence[float | None]) -> str:
    numbers = [value for value in values if value is not None]
    ends = list(dict.fromkeys(f"{value:.4g}" for value in (min(numbers), max(numbers)))) if numbers else []
    return " to ".join(ends) + f"{' and ' * bool(ends)}none" * (len(numbers) < len(values))


def _limit(required: Required, limit: float | None) -> str:
    return "" if limit is None else f"{'>=' if required.least else '<='} {limit:.4g}"


def _word(one: Verdict) -> str:
    met = {None: "", True: "yes", False: "NO"}[one.met]
    return (met + {None: "", True: " (aim)", False: ""}[one.reached]).strip()
