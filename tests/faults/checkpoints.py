"""Damaged checkpoints: restart says in one line which file is damaged, and which older one is sound."""

import subprocess

from mpi4py import MPI

from parisph.io import checkpoint
from tests.faults.answering import Answering
from tests.faults.damage import KINDS, damaged, two_runs
from tests.launch import contents, parisph

LIMIT = 60.0     # [s] for a command
BY_SHELL = 25    # one attempt in so many goes through the command line, on one and on two ranks by turns


def make(count, random, folder):
    """Damage the last checkpoint of a run, or the one before, or both, and try to go on; see table.Part."""
    run, other = two_runs(folder, 2 if count > BY_SHELL else 1)
    sound = {path: path.read_bytes() for path in checkpoint.paths(run / "checkpoints")}
    foreign = {path.name: path.read_bytes() for path in checkpoint.paths(other / "checkpoints")}
    older, last = sound
    kinds = list(KINDS)
    with Answering(__name__) as reader:
        for number in range(count):
            kind = kinds[number % len(kinds)]
            targets = [[last], [last], [last], [last, older], [older]][random.integers(5)]
            for path in targets:
                others = [foreign[path.name], *(content for beside, content in sound.items() if beside != path)]
                path.write_bytes(damaged(kind, sound[path], others, random))
            good = {last, older} - set(targets)
            if number % BY_SHELL == 3:
                found = _by_shell(run, run if targets[0] == last else older, 1 + number // BY_SHELL % 2)
            else:
                found = reader.ask(str(targets[0]))
            wrong = _judge(found, targets[0], good.pop() if good else None)
            yield wrong and f"{kind} in {' and '.join(path.name for path in targets)}: {wrong}"
            for path in targets:
                path.write_bytes(sound[path])


def answer(path):
    """Read a checkpoint as restart does, in another process (see answering)."""
    return f"read as a checkpoint of step {checkpoint.read(MPI.COMM_SELF, path).step}"


def _by_shell(run, place, ranks):
    """Return (class of the error, its text) of `parisph restart PLACE`; what else happens is given as another class."""
    before = contents(run)
    words = ["restart", place, "--until", "0.04"]
    try:
        done = parisph(*words, ranks=ranks, timeout=LIMIT)
    except subprocess.TimeoutExpired:
        return "hang", f"no end after {LIMIT:g} s"
    said = [line for line in done.stderr.splitlines() if line.startswith("parisph: ")]    # mpirun says more
    if contents(run) != before:
        return "change", "restart has changed files of the run"
    if (done.returncode != 5 or done.stdout or not said or "Traceback" in done.stderr
        or (ranks == 1 and done.stderr.count("\n") != 1)):
        return "exit", f"code {done.returncode}: {done.stdout}{done.stderr}"
    return "StoreError", "\n".join(said)


def _judge(found, path, sound):
    """Return what is wrong with (class of the error, text), or None."""
    error, said = found
    if error != "StoreError":
        return f"{error or 'no error'}: {said}"
    if "\n" in said or str(path) not in said:
        return f"not one line with the name of the file: {said}"
    if ("sound" in said) != (sound is not None) or str(sound or "") not in said:
        return f"{sound or 'nothing'} is sound, but it says: {said}"
    return None
