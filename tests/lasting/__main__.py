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

import argparse
import json
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict
from math import pi
from pathlib import Path

from parisph.base import environment

environment.prepare()

from tests.apart import outcome_of  # noqa: E402
from tests.hard import table  # noqa: E402
from tests.lasting import parts, wide  # noqa: E402
from tests.lasting.long import Setting  # noqa: E402

SLOWEST = 4.0    # wall time over CPU time of a run that others hold up


def number(word: str) -> float | str:
    """Return a value of an axis: a number, pi, or a word."""
    try:
        return pi if word == "pi" else float(word)
    except ValueError:
        return word


def main():
    """Compute the runs that are named, print the tables, and return the exit code."""
    parser = argparse.ArgumentParser(prog="python -m tests.lasting", description=__doc__.partition("\n")[0])
    parser.add_argument("runs", nargs="*", metavar="RUN",
                        help=f"any of {', '.join(parts.PARTS)}, or beginnings of names up to a hyphen (default: all)")
    for axis, meaning in parts.AXES.items():
        parser.add_argument(f"--{axis}", nargs="+", type=number, default=[], metavar="X", help=meaning)
    parser.add_argument("--periods", type=float, metavar="N", help="length of the runs")
    parser.add_argument("--preset", metavar="NAME", help="in place of that of the part")
    parser.add_argument("--step", type=float, metavar="DT", help="fixed time step over sqrt(d/g) (default: adaptive)")
    parser.add_argument("--limit", type=float, default=3600.0, metavar="SECONDS",
                        help="CPU time after which a run is ended (default: 3600)")
    parser.add_argument("--quick", action="store_true", help="the quick selection")
    parser.add_argument("--list", action="store_true", help="show the names and run nothing")
    parser.add_argument("-j", "--jobs", type=int, default=1, metavar="N",
                        help="runs at the same time (default: 1)")
    parser.add_argument("-o", "--out", metavar="DIR", help="folder for results.json (default: nothing is kept)")
    parser.add_argument("--against", metavar="FILE", help="results.json of an earlier time, shown in brackets")
    args = parser.parse_args()
    setting = Setting(args.preset, args.step, args.periods, args.limit)
    try:
        plans = parts.plans(args.runs, {axis: getattr(args, axis) for axis in parts.AXES}, setting, args.quick)
    except ValueError as error:
        parser.error(str(error))
    if args.list:
        print("\n".join(plan.name for plan in plans))
        return 0
    before = table.load(Path(args.against)) if args.against else None
    found = _all(plans, args)
    print(wide.text(found, before))
    return int(not all(outcome.met for outcome in found))


def _all(plans, args):
    """Return the outcomes of all runs in their order; results.json grows with each."""
    kept = Path(args.out) / "results.json" if args.out else None
    if kept:
        kept.parent.mkdir(parents=True, exist_ok=True)
    names, done = {plan.name for plan in plans}, []
    earlier = [found for found in (table.load(kept) if kept and kept.exists() else []) if found.scene not in names]
    with tempfile.TemporaryDirectory(prefix="parisph-lasting-") as folder, ThreadPoolExecutor(args.jobs) as pool:
        for outcome in pool.map(lambda plan: apart(plan, Path(folder)), plans):
            done.append(outcome)
            if kept:
                table.save(earlier + done, kept)
    return done


def apart(plan: parts.Plan, folder: Path) -> table.Outcome:
    """Compute a run in its own process, and return its Outcome. folder : for what the process reads and leaves"""
    asked, out = folder / f"{plan.name}.in.json", folder / f"{plan.name}.json"
    asked.write_text(json.dumps([plan.part, plan.values, asdict(plan.setting)]), encoding="utf-8")
    outcome = outcome_of("tests.lasting.one", [asked, out], out, 60.0 + SLOWEST * plan.setting.limit, plan.name)
    print(f"{plan.name}: {outcome.ended}, {outcome.steps} steps, {outcome.cpu_seconds:.1f} CPU s"
          f"{'' if outcome.met else ' - NO'}", flush=True)
    return outcome


if __name__ == "__main__":
    sys.exit(main())
