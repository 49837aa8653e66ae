"""One hard case in a process of its own.

    python -m tests.hard.one NAME OUT.json [--seed N] [--quick]

Its outcome is in OUT.json unless the process dies.
"""

import argparse
import sys
import traceback
from pathlib import Path

from parisph.base import environment

environment.prepare()

from parisph.base.errors import ParisphError, unforeseen  # noqa: E402
from tests.hard import scenes, table  # noqa: E402
from tests.hard.flow import Bench  # noqa: E402
from tests.hard.scene import Scene  # noqa: E402


def outcome(name: str, scene: Scene, seed: int = 1) -> table.Outcome:
    """Compute a scene and return its Outcome, also of one that fails."""
    bench = Bench(seed)
    found = table.Outcome(name, may_stop=scene.may_stop, seed=seed)
    try:
        found.lines = scene.measure(bench)
    except ParisphError as error:
        traceback.print_exc()
        found.ended = f"{'failed' if unforeseen(error) else 'stopped'}: {type(error).__name__}: {error}"
    except Exception as error:
        traceback.print_exc()
        found.ended = f"failed: {type(error).__name__}: {error}"
    found.steps, found.cpu_seconds = bench.steps, bench.cpu_seconds
    return found


def main():
    """Compute the scene that is named and write its outcome."""
    parser = argparse.ArgumentParser(prog="python -m tests.hard.one", description=__doc__.partition("\n")[0])
    parser.add_argument("name", metavar="NAME")
    parser.add_argument("out", metavar="OUT.json")
    parser.add_argument("--seed", type=int, default=1, metavar="N")
    parser.add_argument("--quick", action="store_true")
    args = parser.parse_args()
    among = scenes.QUICK if args.quick else scenes.SCENES
    table.save([outcome(args.name, among[args.name], args.seed)], Path(args.out))


if __name__ == "__main__":
    sys.exit(main())
