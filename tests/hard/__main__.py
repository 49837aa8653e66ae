"""The hard cases: flows at the edge of what a particle method can do, against what is required. Not part of the tests.

    python -m tests.hard                       all: a quarter of an hour on two cores
    python -m tests.hard columns vortex        some, by name or by the beginning of their names
    python -m tests.hard --quick               the quick selection, which the default tests run too
    python -m tests.hard dam --seeds 3         jittered starts with the seeds 1, 2 and 3
    python -m tests.hard -o runs/hard          keep results.json; what was computed earlier and not now stays in it
    python -m tests.hard --list                the names

From the top folder of the clone. Each case runs in a process of its own with a time limit. Exit code 1 if
something required is not met.
"""

import sys

from tests import apart
from tests.hard import scenes, table


def main():
    """Run the cases that are named, print the table, and return the exit code."""
    parser = apart.parser_of("python -m tests.hard", __doc__, "names, or beginnings of names up to a hyphen", 2)
    parser.add_argument("--seeds", type=int, default=1, metavar="N",
                        help="number of starts of each jittered case (default: 1)")
    args = parser.parse_args()
    try:
        starts = [scenes.Start(name, quick=args.quick)
                  for name in apart.chosen(args.names, [*(scenes.QUICK if args.quick else scenes.SCENES)])]
    except ValueError as error:
        parser.error(str(error))
    if args.list:
        print("\n".join(f"{start.name:24} {start.what}" for start in starts))
        return 0
    jobs = [start._replace(seed=seed) for start in starts
            for seed in range(1, 1 + (args.seeds if start.scene.jittered else 1))]
    found = apart.outcomes_of(jobs, args, order=[*scenes.SCENES])
    print(table.text(found))
    return int(not all(outcome.met for outcome in found))


if __name__ == "__main__":
    sys.exit(main())
