"""The long validation: whole runs, measured against what is asked of them. Not part of the tests.

    python -m tests.validation                      everything: some three hours on two cores
    python -m tests.validation rest waves           some parts
    python -m tests.validation -o runs/validation   keep the runs, and results.json; repeated, it makes only what is
    left

From the top folder of the clone. Exit code 1 if something asked for is not met.
"""

import argparse
import sys
from importlib import import_module

from parisph.base import environment

environment.prepare()

from tests.validation import record  # noqa: E402

PARTS = {name: import_module(f"tests.validation.{name}") for name in (
    "rest", "rest_of_methods", "rest_at_walls", "rest_in_3d", "waves", "waves_in_3d", "drops_in_3d", "motion",
    "dam_break", "measured", "ranks", "cold_start", "cavity")}


def main():
    """Run the parts that are named, print the table, and return the exit code."""
    parser = argparse.ArgumentParser(prog="python -m tests.validation", description=__doc__.partition("\n")[0])
    parser.add_argument("parts", nargs="*", metavar="PART", help=f"any of {', '.join(PARTS)} (default: all)")
    parser.add_argument("-o", "--out", metavar="DIR",
                        help="folder for the runs and results.json (default: nothing is kept)")
    args = parser.parse_args()
    unknown = set(args.parts) - set(PARTS)
    if unknown:
        parser.error(f"no part {', '.join(sorted(unknown))} (there are {', '.join(PARTS)})")
    bench, rows = record.Bench(args.out), []
    try:
        for name in args.parts or PARTS:
            print(f"{name}: {PARTS[name].__doc__.partition(chr(10))[0]}", flush=True)
            rows += PARTS[name].rows(bench)
            if args.out:
                record.save(rows, bench.folder / "results.json")
    finally:
        bench.close()
        print(record.table(rows))
    return int(any(row.met is False for row in rows))


if __name__ == "__main__":
    sys.exit(main())
