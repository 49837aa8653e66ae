"""The page of the tuned numbers: what the sources say, and what the study has found."""

from pathlib import Path
from statistics import mean, stdev

from tests.constants.scenes import SCENES
from tests.constants.sources import FACTORS, Tuned, listed
from tests.constants.study import BASE, records
from tests.launch import ROOT

PAGE = ROOT / "parisph" / "methods" / "CONSTANTS.md"
TABLE = "| name | value | range | what it is | source | effect |\n|---|---|---|---|---|---|"
SCATTERS = 2.0       # standard errors of a mean of starts, from which on an effect is shown
CERTAIN = 5.0        # the same from which on it is hardly chance: each number is judged by some twenty comparisons
CHANGE = 0.05        # of a measure of a scene with one start, from which on an effect is shown
ROUNDING = 1e-6      # part of a measure: a smaller change is none
HEAD = """\
# Tuned numbers

The numbers of parisph that were chosen by measurement or by judgement, and what becomes of three scenes with half and \
with twice of them, within the range. `python -m tests.constants page` writes this page, from the comments `# tuned` \
in the sources and from what `python -m tests.constants study` has found.

The scenes are {scenes}. An effect is a failure, or a measure whose mean differs by more than {scatters:g} standard \
errors from that of twelve starts of the unchanged code (these are in brackets), or by more than {change:.0%} in the \
standing wave. By chance, a number without any effect shows one of less than {certain:g} in three cases of four: such \
are marked "perhaps". In one case of twenty it shows a greater one. \
The strongest two are given. "unused" means that nothing changes in any digit. {count} numbers.
"""


def text(root: Path = ROOT / "parisph") -> str:
    """Return the page."""
    numbers, found = listed(root), records()
    lines = [HEAD.format(scenes=", ".join(scene.what for scene in SCENES.values()), scatters=SCATTERS, change=CHANGE,
                         certain=CERTAIN, count=len(numbers))]
    for file in dict.fromkeys(one.file for one in numbers):
        lines += [f"## `{file}`\n", TABLE]
        lines += [f"| `{one.name}` | {one.value:g} | {one.low:g} to {one.high:g} | {one.what} | {one.source} | "
                  f"{effect(one, found)} |" for one in numbers if one.file == file]
        lines.append("")
    return "\n".join(lines)


def effect(one: Tuned, found: dict) -> str:
    """Return the words of the effect of a number by the records of the study."""
    base, said, unused = found.get((BASE, 1.0)), [], True
    for factor, word in FACTORS.items():
        record = found.get((one.key, factor))
        if base is None or record is None or record["value"] != one.value or record["tried"] != one.times(factor):
            return "not measured"
        shown = sorted(deviations(record["found"], base["found"]), reverse=True)[:2]
        unused &= _same(record["found"], base["found"])
        if shown:
            perhaps = "perhaps " if shown[0][0] < CERTAIN else ""
            said.append(f"{word} ({record['tried']:g}): {perhaps}{', '.join(words for _, words in shown)}")
    return "; ".join(said) or ("none, unused" if unused else "none")


def deviations(found: dict, base: dict) -> list[tuple[float, str]]:
    """Return how far each measure that shows an effect is off, infinite for a failure, and words for it.

    found, base : {scene: [{measure: value} or words of an error, of each start]}
    """
    shown = []
    for name, starts in found.items():
        failed = [start for start in starts if isinstance(start, str)]
        if failed:
            shown.append((float("inf"), f"{SCENES[name].what} fails ({len(failed)} of {len(starts)})"))
        sound = [start for start in starts if not isinstance(start, str)]
        for measure in sound[0] if sound else ():
            usual = [start[measure] for start in base[name]]
            was, now = mean(usual), mean(start[measure] for start in sound)
            if len(usual) == 1:
                least, error = CERTAIN, CHANGE / CERTAIN * abs(was)
            else:
                least, error = SCATTERS, stdev(usual) * (1.0 / len(sound) + 1.0 / len(usual))**0.5
            if abs(now - was) > max(least * error, ROUNDING * abs(was)):
                off = abs(now - was) / error if error else float("inf")
                shown.append((off, f"{SCENES[name].what}: {measure} {was:.3g} to {now:.3g} ({off:.1f})"))
    return shown


def _same(found, base):
    return all(starts == base[name][:len(starts)] for name, starts in found.items())
