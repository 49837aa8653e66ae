"""Long runs: waves that must last, against what is required. Not part of the tests.

    python -m tests.lasting                                     all: many hours
    python -m tests.lasting standing --depth 10 --periods 20    a part, with other values of its axes
    python -m tests.lasting standing --kd pi --preset violent   with another preset
    python -m tests.lasting standing-kd3.14 --step 0.1          by the beginning of a name, with a fixed step
    python -m tests.lasting --quick                             the quick selection, which the default tests run too
    python -m tests.lasting -o runs/lasting                     keep results.json; what was computed earlier stays in it
    python -m tests.lasting --against runs/before/results.json  with the values of an earlier time in brackets
    python -m tests.lasting --list                              the names

From the top folder of the clone. Each run is a process of its own, and is measured however it ends. Exit code 1 if
something required is not met.
"""

import sys
from math import pi
from pathlib import Path

from tests import apart
from tests.hard import table
from tests.lasting import parts, wide
from tests.lasting.long import Setting


def number(word: str) -> float | str:
    """Return a value of an axis: a number, pi, or a word."""
    try:
        return pi if word == "pi" else float(word)
    except ValueError:
        return word


def main():
    """Compute the runs that are named, print the tables, and return the exit code."""
    parser = apart.parser_of("python -m tests.lasting", __doc__,
                             f"any of {', '.join(parts.PARTS)}, or beginnings of names up to a hyphen", 1)
    for axis, meaning in parts.AXES.items():
        parser.add_argument(f"--{axis}", nargs="+", type=number, default=[], metavar="X", help=meaning)
    parser.add_argument("--periods", type=float, metavar="N", help="length of the runs")
    parser.add_argument("--preset", metavar="NAME", help="in place of that of the part")
    parser.add_argument("--step", type=float, metavar="DT", help="fixed time step over sqrt(d/g) (default: adaptive)")
    parser.add_argument("--limit", type=float, default=3600.0, metavar="SECONDS",
                        help="CPU time after which a run is ended (default: 3600)")
    parser.add_argument("--against", metavar="FILE", help="results.json of an earlier time, shown in brackets")
    args = parser.parse_args()
    setting = Setting(args.preset, args.step, args.periods, args.limit)
    try:
        plans = parts.plans(args.names, {axis: getattr(args, axis) for axis in parts.AXES}, setting, args.quick)
    except ValueError as error:
        parser.error(str(error))
    if args.list:
        print("\n".join(plan.name for plan in plans))
        return 0
    before = table.load(Path(args.against)) if args.against else None
    found = apart.outcomes_of(plans, args)
    print(wide.text(found, before))
    return int(not all(outcome.met for outcome in found))


if __name__ == "__main__":
    sys.exit(main())
