"""The scenes in a process of its own, with the parisph that PYTHONPATH names first.

    python -m tests.constants.one PLAN.json OUT.json

PLAN.json : {"scenes": {name: seeds}, "part": of the time, "kernels": a folder of compiled ones or null, "stale": files
of parisph/kernels that are not as they were there}. OUT.json, which grows with each start: {"parisph", "kernels": the
folders in use, "found": {name: [{measure: value}, or the words of an error]}}.
"""

import shutil
import sys
from pathlib import Path

from parisph.base import environment

environment.prepare()

import parisph  # noqa: E402
from parisph.io.files import read_json, write_json  # noqa: E402
from parisph.kernels import jit  # noqa: E402
from parisph.kernels.kept import ENDING  # noqa: E402
from tests.constants.scenes import SCENES  # noqa: E402


def main():
    """Compute what the plan says."""
    plan, out = read_json(Path(sys.argv[1])), Path(sys.argv[2])
    if plan["kernels"]:
        take(Path(plan["kernels"]), jit.FOLDERS.write, {Path(file).stem for file in plan["stale"]})
    found = {name: [] for name in plan["scenes"]}
    for name, seeds in plan["scenes"].items():
        for seed in seeds:
            found[name].append(_measured(name, seed, plan["part"]))
            write_json(out, {"parisph": str(Path(parisph.__file__).parent), "kernels": str(jit.FOLDERS.write),
                             "found": found})


def _measured(name, seed, part):
    try:
        return SCENES[name].measures(seed, part)
    except Exception as error:    # whatever it is, the number is not worth another look
        return f"{type(error).__name__}: {error}"[:200]


def take(kernels: Path, to: Path, stale: set[str]) -> None:
    """Copy compiled kernels to another folder but for those of stale modules; the name of a file begins with that."""
    for path in kernels.glob(f"*{ENDING}"):
        if path.name.partition(".")[0] not in stale and not (to / path.name).exists():
            shutil.copy2(path, to)


if __name__ == "__main__":
    main()
