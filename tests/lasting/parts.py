"""The parts of the suite, and the names of their runs."""

from itertools import product
from typing import NamedTuple

from tests.lasting import breaking, calming, flumes, irregular, obstacles, sloshing, solitary, standing
from tests.lasting.long import Setting

PARTS = {"standing": standing, "sloshing": sloshing, "flumes": flumes, "irregular": irregular, "solitary": solitary,
         "obstacles": obstacles, "breaking": breaking, "calming": calming}
AXES = {    # what the words of the command line mean
    "kd": "wave number times depth", "amplitude": "over the depth", "depth": "of the water over the spacing",
    "jitter": "of the start", "height": "of the waves over the depth", "maker": "piston, flap, zone or body",
    "ratio": "of the forcing to the first frequency", "obstacle": "submerged or piercing",
}


class Plan(NamedTuple):
    """One run: its part, the values of its axes, and what is asked of all runs."""

    part: str
    values: dict[str, float | str]
    setting: Setting

    @property
    def name(self) -> str:
        """As in `standing-kd3.14-amplitude0.02-depth10-jitter0`."""
        values = (f"{axis if isinstance(value, float) else ''}{_shown(value)}" for axis, value in self.values.items())
        return "-".join([self.part, *values]) + self.setting.words()


def plans(words: list[str], axes: dict[str, list[float | str]], setting: Setting, quick: bool = False) -> list[Plan]:
    """Return the runs whose names, or beginnings of names up to a hyphen, are given; all for no words.

    axes : values in place of those of the parts, empty lists for none
    quick : the quick selection, of short runs

    Raises ValueError: a word names none
    """
    found = [plan for part in PARTS for plan in _of(part, axes, setting, quick)]
    for word in words:
        if not any(_fits(plan.name, word) for plan in found):
            raise ValueError(f"no run {word} (the parts are {', '.join(PARTS)}; --list shows the names)")
    return [plan for plan in found if not words or any(_fits(plan.name, word) for word in words)]


def _of(part, axes, setting, quick):
    module = PARTS[part]
    if quick and not hasattr(module, "QUICK"):
        return
    if quick and setting.periods is None:
        setting = Setting(setting.preset, setting.step, module.QUICK_PERIODS, setting.limit)
    usual = module.QUICK if quick else module.AXES
    chosen = {axis: axes.get(axis) or values for axis, values in usual.items()}
    for values in product(*chosen.values()):
        yield Plan(part, dict(zip(chosen, values)), setting)


def _shown(value):
    return f"{value:.3g}" if isinstance(value, float) else value


def _fits(name, word):
    return name == word or name.startswith(word + "-")
