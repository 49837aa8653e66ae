"""The fault campaign: damage, kills, signals, full disks and bad input. Not part of the tests.

    python -m tests.faults                      everything, seeded: about an hour on two cores
    python -m tests.faults inputs kills         some parts
    python -m tests.faults --share 0.1          a tenth of the attempts of each part
    python -m tests.faults --seed 7             other random choices
    python -m tests.faults --3d kills signals   with a run in 3D, where a part disturbs a run

From the top folder of the clone. Exit code 1 if anything misbehaved. The default tests run a few
attempts of each part (tests/driver/test_faults.py).
"""

import argparse
import os
import sys
import tempfile
from pathlib import Path

from parisph.base import environment

environment.prepare()

from tests.faults import table  # noqa: E402
from tests.faults.dam import IN_3D  # noqa: E402
from tests.faults.parts import PARTS  # noqa: E402


def main():
    """Run the parts that are named, print the table, and return the exit code."""
    parser = argparse.ArgumentParser(prog="python -m tests.faults", description=__doc__.partition("\n")[0])
    parser.add_argument("parts", nargs="*", metavar="PART", help=f"any of {', '.join(PARTS)} (default: all)")
    parser.add_argument("--share", type=float, default=1.0, metavar="X",
                        help="share of the attempts, 0 to 1 (default: 1)")
    parser.add_argument("--seed", type=int, default=0, metavar="N", help="seed of the random choices (default: 0)")
    parser.add_argument("--3d", dest="in_3d", action="store_true", help="disturb runs in 3D")
    args = parser.parse_args()
    if args.in_3d:
        os.environ[IN_3D] = "1"
    unknown = set(args.parts) - set(PARTS)
    if unknown:
        parser.error(f"no part {', '.join(sorted(unknown))} (there are {', '.join(PARTS)})")
    rows = []
    try:
        for name in args.parts or PARTS:
            with tempfile.TemporaryDirectory(prefix=f"parisph-faults-{name}-") as folder:
                rows.append(table.carry_out(name, PARTS[name], max(1, round(args.share * PARTS[name].attempts)),
                                            args.seed, Path(folder)))
    finally:
        print(table.text(rows))
    return int(any(row.misbehaved for row in rows))


if __name__ == "__main__":
    sys.exit(main())
