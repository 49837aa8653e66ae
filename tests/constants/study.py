"""The study: each tuned number halved and doubled in a copy of the package, and what becomes of the scenes."""

import json
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from parisph.io.files import read_json, write_json
from tests.constants.scenes import SCENES
from tests.constants.sources import FACTORS, Tuned, dependents, listed, replaced
from tests.launch import ROOT, run

RESULTS = Path(__file__).parent / "results.jsonl"
LIMIT = 1200.0    # [s] for all scenes of one number, some thirty times what they take
BASE = "base"


def records(path: Path = RESULTS) -> dict[tuple[str, float], dict[str, Any]]:
    """Return the records of a study by key and factor: of what was tried twice, the last."""
    lines = path.read_text(encoding="utf-8").splitlines() if path.exists() else []
    return {(one["key"], one["factor"]): one for one in map(json.loads, lines)}


def study(part: int, parts: int, names: list[str], kept: Path, out: Path = RESULTS) -> None:
    """Try all numbers of one part, or those whose key contains one of the names, and append a record of each.

    What has a record with the present value is not tried again. The base line is of the first part.
    kept : folder for the compiled kernels of the unchanged package
    """
    kernels = _run(ROOT / "parisph", _plan(SCENES, 0.02), kept)["kernels"]
    todo: list[tuple[Tuned | None, float]] = [(None, 1.0)] if part == 1 else []
    chosen = [one for one in listed() if not names or any(name in one.key for name in names)]
    todo += [(one, factor) for one in chosen[part - 1::parts] for factor in FACTORS]
    for tuned, factor in todo:
        key, value = (tuned.key, tuned.value) if tuned else (BASE, 1.0)
        there = records(out).get((key, factor))
        if there and there["value"] == value:
            continue
        begun = _spent()
        tried = tuned.times(factor) if tuned else value
        found = _tried(tuned, tried, kernels) if tuned else _run(ROOT / "parisph", _plan(SCENES, base=True), kept)
        record = {"key": key, "factor": factor, "value": value, "tried": tried, "found": found["found"],
                  "cpu_seconds": round(_spent() - begun, 1)}
        with out.open("a", encoding="utf-8") as file:
            file.write(json.dumps(record) + "\n")
        print(f"{key} {value:g} -> {tried:g}: {record['cpu_seconds']} CPU s", flush=True)


def _spent():
    """Return the CPU seconds of the processes that have ended."""
    return sum(os.times()[2:4])


def _tried(tuned, value, kernels):
    """Return what is found with another value of a number: kernels that it is compiled into are compiled first, as the
    last digits differ where a process has compiled them itself."""
    scenes = [name for name, scene in SCENES.items() if not tuned.name.startswith(f"{scene.absent}.")]
    with tempfile.TemporaryDirectory(prefix="parisph-constants-") as folder:
        copy = Path(folder) / "parisph"
        shutil.copytree(ROOT / "parisph", copy, ignore=shutil.ignore_patterns("__pycache__"))
        file = copy / tuned.file
        file.write_text(replaced(file.read_text(encoding="utf-8"), tuned, value), encoding="utf-8")
        stale = sorted(dependents(tuned.file))
        for part in (0.02, 1.0):
            found = _run(copy, {**_plan(scenes, part), "kernels": kernels, "stale": stale}, Path(folder) / "kernels")
        if found.get("parisph", str(copy)) != str(copy):
            raise RuntimeError(f"{tuned.key} was tried with the parisph in {found['parisph']}, not with that in {copy}")
        return found


def _plan(scenes, part=1.0, base=False):
    seeds = {name: SCENES[name].base if base else SCENES[name].tried for name in scenes}
    return {"scenes": seeds if part == 1.0 else {name: some[:1] for name, some in seeds.items()}, "part": part,
            "kernels": None, "stale": []}


def _run(package, plan, cache):
    """Return what a process with a package leaves, whatever becomes of it. cache : folder for compiled kernels"""
    with tempfile.TemporaryDirectory(prefix="parisph-constants-") as folder:
        asked, out = Path(folder) / "plan.json", Path(folder) / "out.json"
        write_json(asked, plan)
        path = os.pathsep.join([str(package.parent), str(ROOT)])
        try:
            done = run([sys.executable, "-m", "tests.constants.one", asked, out], LIMIT, package.parent,
                       PYTHONPATH=path, NUMBA_CACHE_DIR=str(cache.absolute()))
            ended = f"exit code {done.returncode}: {done.stderr.strip()[-200:]}"
        except subprocess.TimeoutExpired:
            ended = f"not finished after {LIMIT:g} s"
        found = read_json(out) if out.exists() else {"found": {}}
        for name, seeds in plan["scenes"].items():
            there = found["found"].setdefault(name, [])
            there += [ended] * (len(seeds) - len(there))
        return found
