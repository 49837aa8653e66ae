"""The parts of the suite, and the names of their runs."""

from itertools import product
from typing import NamedTuple

from tests.apart import chosen
from tests.hard.flow import Bench
from tests.hard.table import Outcome
from tests.lasting import breaking, calming, flumes, irregular, obstacles, sloshing, solitary, standing
from tests.lasting.long import Setting, follow

PARTS = {"standing": standing, "sloshing": sloshing, "flumes": flumes, "irregular": irregular, "solitary": solitary,
         "obstacles": obstacles, "breaking": breaking, "calming": calming}
SLOWEST = 4.0    # wall time over CPU time of a run that others hold up
AXES = {    # what the words of the command line mean
    "kd": "wave number times depth", "amplitude": "over the depth", "depth": "of the water over the spacing",
    "jitter": "of the start", "height": "of the waves over the depth", "maker": "piston, flap, zone or body",
    "ratio": "of the forcing to the first frequency", "obstacle": "submerged or piercing",
}


class Plan(NamedTuple):
    """One run, a job (tests.apart): its part, the values of its axes, and what is asked of all runs."""

    part: str
    values: dict[str, float | str]
    setting: Setting

    @property
    def name(self) -> str:
        """As in `standing-kd3.14-amplitude0.02-depth10-jitter0`."""
        values = (f"{axis if isinstance(value, float) else ''}{_shown(value)}" for axis, value in self.values.items())
        return "-".join([self.part, *values]) + self.setting.words()

    seed = 1

    @property
    def what(self) -> str:
        """Its part, in words."""
        return PARTS[self.part].__doc__.partition(".")[0]

    @property
    def limit(self) -> float:
        """Wall time [s]."""
        return 60.0 + SLOWEST * self.setting.limit

    def outcome(self) -> Outcome:
        """Compute it."""
        bench = Bench()
        long = PARTS[self.part].long(self.values, self.setting)
        record = follow(bench, long, self.setting.limit)
        return Outcome(self.name, record.end, lines=long.measure(record), steps=bench.steps,
                       cpu_seconds=bench.cpu_seconds)


def plans(words: list[str], axes: dict[str, list[float | str]], setting: Setting, quick: bool = False) -> list[Plan]:
    """Return the runs whose names, or beginnings of names up to a hyphen, are given; all for no words.

    axes : values in place of those of the parts, empty lists for none
    quick : the quick selection, of short runs

    Raises ValueError: a word names none
    """
    found = {plan.name: plan for part in PARTS for plan in _of(part, axes, setting, quick)}
    return [found[name] for name in chosen(words, [*found])]


def _of(part, axes, setting, quick):
    module = PARTS[part]
    if quick and not hasattr(module, "QUICK"):
        return
    if quick and setting.periods is None:
        setting = Setting(setting.preset, setting.step, module.QUICK_PERIODS, setting.limit)
    usual = module.QUICK if quick else module.AXES
    for values in product(*(axes.get(axis) or values for axis, values in usual.items())):
        yield Plan(part, dict(zip(usual, values)), setting)


def _shown(value):
    return f"{value:.3g}" if isinstance(value, float) else value
