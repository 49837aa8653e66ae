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

import argparse
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from parisph.base import environment

environment.prepare()

from tests.apart import outcome_of  # noqa: E402
from tests.hard import scenes, table  # noqa: E402
from tests.hard.scene import Scene  # noqa: E402


def main():
    """Run the cases that are named, print the table, and return the exit code."""
    parser = argparse.ArgumentParser(prog="python -m tests.hard", description=__doc__.partition("\n")[0])
    parser.add_argument("cases", nargs="*", metavar="CASE",
                        help="names of cases, or beginnings of names up to a hyphen (default: all)")
    parser.add_argument("--quick", action="store_true", help="the quick selection")
    parser.add_argument("--list", action="store_true", help="show the names and run nothing")
    parser.add_argument("--seeds", type=int, default=1, metavar="N",
                        help="number of starts of each jittered case (default: 1)")
    parser.add_argument("-j", "--jobs", type=int, default=2, metavar="N",
                        help="cases that run at the same time (default: 2)")
    parser.add_argument("-o", "--out", metavar="DIR", help="folder for results.json (default: nothing is kept)")
    args = parser.parse_args()
    among = scenes.QUICK if args.quick else scenes.SCENES
    try:
        names = scenes.chosen(args.cases, among)
    except ValueError as error:
        parser.error(str(error))
    if args.list:
        print("\n".join(f"{name:24} {among[name].what}" for name in names))
        return 0
    runs = [(name, seed) for name in names for seed in range(1, 1 + (args.seeds if among[name].jittered else 1))]
    found = _all(runs, among, args)
    print(table.text(found))
    return int(not all(outcome.met for outcome in found))


def _all(runs, among, args):
    """Return the outcomes of all runs in their order; results.json grows with each."""
    kept = Path(args.out) / "results.json" if args.out else None
    if kept:
        kept.parent.mkdir(parents=True, exist_ok=True)
    order, done = {name: place for place, name in enumerate(scenes.SCENES)}, []
    earlier = table.load(kept) if kept and kept.exists() else []
    earlier = [found for found in earlier if (found.scene, found.seed) not in runs]
    with tempfile.TemporaryDirectory(prefix="parisph-hard-") as folder, ThreadPoolExecutor(max(1, args.jobs)) as pool:
        for outcome in pool.map(lambda run: apart(*run, among, args.quick, Path(folder)), runs):
            done.append(outcome)
            if kept:    # a case that there is no more comes last
                place = {found.scene: order.get(found.scene, len(order)) for found in earlier + done}
                table.save(sorted(earlier + done, key=lambda found: (place[found.scene], found.seed)), kept)
    return done


def apart(name: str, seed: int, among: dict[str, Scene], quick: bool, folder: Path) -> table.Outcome:
    """Run one case in its own process and return its Outcome, whatever becomes of the process.

    folder : for what the process leaves
    """
    out = folder / f"{name}-{seed}.json"
    words = [name, out, "--seed", seed, *(["--quick"] if quick else [])]
    outcome = outcome_of("tests.hard.one", words, out, among[name].limit, name, seed)
    print(f"{name}, start {seed}: {among[name].what}: {outcome.ended}, {outcome.steps} steps, "
          f"{outcome.cpu_seconds:.1f} CPU s{'' if outcome.met else ' - NO'}", flush=True)
    return outcome


if __name__ == "__main__":
    sys.exit(main())
