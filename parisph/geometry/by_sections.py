"""Checks of the sections of a 3D scene, with messages about the whole scene."""

import re
from collections.abc import Callable, Iterable

from parisph.case.scene import Scene
from parisph.case.sections import fluids_across, sections

Check = Callable[[Scene], Iterable[str]]


def said(case: Scene, check: Check) -> list[str]:
    """Return what a check of 2D scenes says about each section of a 3D scene, each line once.

    A line that does not hold all across ends with the places y [m] where it does. Heights are called z.
    """
    parts, found = sections(case), dict[str, list[tuple[float, float]]]()
    for low, high, scene in parts:
        numbers = fluids_across(case, low, high)
        for line in dict.fromkeys(check(scene)):
            found.setdefault(_of_the_whole(case, line, numbers), []).append((low, high))
    return [line if len(where) == len(parts) else f"{line} (this is the section {_places(where)})"
            for line, where in found.items()]


def _of_the_whole(case: Scene, line: str, numbers: list[int]) -> str:
    """Return a line about a section with the numbers of the fluids in the whole scene, and z for heights."""
    line = re.sub(r"\bfluid\[(\d+)\]", lambda match: f"fluid[{numbers[int(match[1])]}]", line)
    low, high = case.breadth or (0.0, 0.0)
    line = line.replace("Tank(width=", f"Tank(breadth={high - low:g}, width=")
    return re.sub(r"\by(?= = | at )", "z", line)


def _places(where: list[tuple[float, float]]) -> str:
    """Return the intervals [m] across as text, joined where they meet."""
    joined = [where[0]]
    for low, high in where[1:]:
        if low == joined[-1][1]:
            joined[-1] = joined[-1][0], high
        else:
            joined.append((low, high))
    return " and ".join(f"from y = {low:g} to {high:g}" for low, high in joined)
