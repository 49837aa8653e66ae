"""Damaged snapshots: they are refused in one line, or read as they were written; never as anything else."""

import subprocess

import numpy as np

from parisph.io.reader import open_run
from tests.faults.answering import Answering
from tests.faults.damage import KINDS, damaged, two_runs
from tests.launch import parisph

LIMIT = 60.0     # [s] for a command
BY_SHELL = 25    # one attempt in so many goes through the command line


def make(count, random, folder):
    """Damage one snapshot of a run and read it; see table.Part."""
    run, other = two_runs(folder, 2 if count > BY_SHELL else 1)
    flow = open_run(run)
    sound = {path: path.read_bytes() for path in sorted((run / "snapshots").iterdir())}
    foreign = {path.name: path.read_bytes() for path in (other / "snapshots").iterdir()}
    for number in range(len(flow)):
        np.savez(folder / f"written{number}.npz", **flow.snapshot(number))
    kinds = list(KINDS)
    with Answering(__name__) as reader:
        for attempt in range(count):
            kind, number = kinds[attempt % len(kinds)], int(random.integers(len(flow)))
            path = list(sound)[number]
            others = [foreign[path.name], *(content for beside, content in sound.items() if beside != path)]
            path.write_bytes(damaged(kind, sound[path], others, random))
            if attempt % BY_SHELL == 3:
                found = _by_shell(run, number, flow.times[number], folder / "picture.png")
            else:
                found = reader.ask([str(run), number, str(folder / f"written{number}.npz")])
            wrong = _judge(found, path)
            yield wrong and f"{kind} in {path.name}: {wrong}"
            path.write_bytes(sound[path])


def answer(question):
    """Read a snapshot and compare it with what it was: [folder of the run, number, file of numpy] (see answering)."""
    run, number, file = question
    read, written = open_run(run).snapshot(number), dict(np.load(file))
    if read.keys() != written.keys():
        return f"read with the fields {', '.join(read)}"
    changed = [name for name in written if not np.array_equal(read[name], written[name], equal_nan=True)]
    return f"read with another {', '.join(changed)}" if changed else "read as it was written"


def _by_shell(run, number, time, picture):
    """Return (class of the error, its text) of `parisph info` or `plot`, which open the snapshot."""
    words = ["info", run] if number == 0 else ["plot", run, "--time", time, "-o", picture]
    try:
        done = parisph(*words, timeout=LIMIT)
    except subprocess.TimeoutExpired:
        return "hang", f"no end after {LIMIT:g} s"
    said = done.stderr.removesuffix("\n")
    if done.returncode != 5 or picture.exists() or not said.startswith("parisph: error: "):
        return "exit", f"code {done.returncode}: {done.stdout}{said}"
    return "StoreError", said


def _judge(found, path):
    """Return what is wrong with (class of the error or None, text), or None."""
    error, said = found
    if error is None:
        return None if said == "read as it was written" else said
    if error != "StoreError":
        return f"{error}: {said}"
    return None if "\n" not in said and str(path) in said else f"not one line with the name of the file: {said}"
