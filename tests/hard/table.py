"""The lines of the table of hard cases, and how they are kept."""

import math
from dataclasses import asdict, dataclass, field
from pathlib import Path

from parisph.io.files import read_json, write_json

ENDED = "came to its end"


@dataclass(frozen=True)
class Line:
    """One measured quantity of a scene.

    what : the quantity
    value : number
    must, aim : what is required and what is aimed at, None for a report only
    least : whether these limits are lower ones
    """

    what: str
    value: float
    must: float | None = None
    aim: float | None = None
    least: bool = False

    @property
    def met(self) -> bool | None:
        """Whether the requirement is met, None where there is none. A number that is not one meets nothing."""
        return self._within(self.must)

    @property
    def reached(self) -> bool | None:
        """Whether the aim is reached, None where there is none."""
        return self._within(self.aim)

    def _within(self, limit):
        return None if limit is None else bool(self.value >= limit if self.least else self.value <= limit)

    def limits(self) -> tuple[str, str]:
        """Return what is required and what is aimed at, as text."""
        return tuple("" if limit is None else f"{'>=' if self.least else '<='} {limit:g}"
                     for limit in (self.must, self.aim))


@dataclass
class Outcome:
    """What became of a scene.

    scene, seed : its name, and which start
    ended : ENDED, "stopped: MESSAGE" for an error of parisph, "failed: ..." for anything else
    may_stop : whether it may stop with an error of parisph, which names cause and remedy
    lines : list of Line
    steps, cpu_seconds : of all its runs; their ranks' CPU seconds are added
    """

    scene: str
    ended: str = ENDED
    may_stop: bool = False
    lines: list[Line] = field(default_factory=list)
    seed: int = 1
    steps: int = 0
    cpu_seconds: float = 0.0

    @property
    def met(self) -> bool:
        """Whether the scene ended as it may, and all that is required is met."""
        return self.ended_well and all(line.met is not False for line in self.lines)

    @property
    def ended_well(self) -> bool:
        """Whether it came to its end, or stopped where that is allowed."""
        return self.ended == ENDED or (self.may_stop and self.ended.startswith("stopped: "))


def text(outcomes: list[Outcome]) -> str:
    """Return the outcomes as a Markdown table.

    The seeds of one scene are one entry: its values are given from the least to the greatest, the worst decides,
    and steps and CPU seconds, in the first line of a scene, are added.
    """
    rows = ["| case | measured | value | must | aim | | steps | CPU s |", "|---|---|---|---|---|---|---|---|"]
    for name in dict.fromkeys(found.scene for found in outcomes):
        rows += _entry(name, [found for found in outcomes if found.scene == name])
    return "\n".join(rows)


def _entry(name, starts):
    label = name if len(starts) == 1 else f"{name}, {len(starts)} starts"
    ends = "; ".join(dict.fromkeys(_cell(found.ended) for found in starts))
    yield (f"| {label} | {ends} | | | | {verdict(all(found.ended_well for found in starts), None)} "
           f"| {sum(found.steps for found in starts)} | {sum(found.cpu_seconds for found in starts):.1f} |")
    for what in dict.fromkeys(line.what for found in starts for line in found.lines):
        same = [line for found in starts for line in found.lines if line.what == what]
        met, reached = _all(line.met for line in same), _all(line.reached for line in same)
        yield (f"| {label} | {what} | {spread([line.value for line in same])} | {' | '.join(same[0].limits())} "
               f"| {verdict(met, reached)} | | |")


def _all(verdicts):
    verdicts = list(verdicts)
    return None if None in verdicts else all(verdicts)


def save(outcomes: list[Outcome], path: Path) -> None:
    """Write outcomes as JSON, whole or not at all."""
    write_json(path, {"outcomes": [asdict(found) | {"met": found.met} for found in outcomes]})


def load(path: Path) -> list[Outcome]:
    """Read what `save` wrote. Raises StoreError."""
    return [_outcome(entry) for entry in read_json(path)["outcomes"]]


def _outcome(entry):
    values = {name: value for name, value in entry.items() if name not in ("met", "lines")}
    return Outcome(**values, lines=[_line(line) for line in entry["lines"]])


def _line(entry):    # what is not a number is null in JSON
    return Line(**{**entry, "value": math.nan if entry["value"] is None else entry["value"]})


def _cell(words):
    return " ".join(words.replace("|", "/").split())


def spread(values) -> str:
    """Return the least and the greatest of some values as text, nan if one is."""
    ends = dict.fromkeys(f"{value:.4g}" for value in (min(values), max(values)))
    return " to ".join(ends) if all(value == value for value in values) else "nan"


def verdict(met: bool | None, reached: bool | None) -> str:
    """Return whether a requirement is met and an aim is reached, as text."""
    return {None: "", True: "ok", False: "NO"}[met] + {None: "", True: " (aim)", False: ""}[reached]
