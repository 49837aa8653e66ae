"""Two signals within milliseconds, to one of two ranks or to both, at a random moment of a run."""

import signal
import time

import numpy as np

from parisph.io import reader
from tests.faults.table import each_in_its_folder, gone_on
from tests.launch import mpirun
from tests.running import handles, running, send

# Checkpoints and snapshots in almost every step: many signals come in the middle of one.
CASE = """
from tests.faults.dam import dam
def case():
    return dam(spacing=0.05, end_time=0.4, snapshot_every=0.02).changed(
        **{"output.checkpoint_every": 0.01})
"""
NUMBERS = (signal.SIGINT, signal.SIGTERM, signal.SIGUSR1)
GONE = 60.0        # [s] for all processes to end after the second signal
SECONDS = 300.0    # [s] for a run, which may have to compile
COLD = 0.15        # share of the attempts in which the kernels have to be compiled, for which one rank waits
COMPILES = 15.0    # [s] at least for that
FEW, USUAL = 5, 5.0    # so few attempts do without measuring how long a run takes, about so many [s]


def make(count, random, folder):
    """See table.Part."""
    whole = USUAL if count <= FEW else _seconds(folder)
    yield from each_in_its_folder(count, folder, lambda place: _attempt(place, random, whole))


def _seconds(folder):
    """Return how long a run takes that nobody stops."""
    (folder / "case.py").write_text(CASE)
    for name in ("first", "second"):    # the first one may compile the kernels
        begun = time.monotonic()
        done = mpirun(2, ["-m", "parisph", "run", "case.py", "-o", name, "-q"], cwd=folder, timeout=SECONDS)
        if done.returncode != 0:
            raise RuntimeError(done.stderr)
    return time.monotonic() - begun


def _attempt(folder, random, whole):
    cold = random.random() < COLD
    numbers = [NUMBERS[k] for k in random.integers(0, len(NUMBERS), 2)]
    moment = float(random.uniform(0.0, COMPILES if cold else 1.1 * whole))
    gap = float(random.uniform(0.001, 0.05))
    whom = str(random.choice(["first", "last", "all"]))
    what = (f"{numbers[0].name} and {numbers[1].name} {1e3 * gap:.0f} ms apart to {whom} of 2 ranks "
            f"after {moment:.2f} s"
            + cold * ", while kernels are compiled")
    settings = {"NUMBA_CACHE_DIR": str(folder / "kernels")} if cold else {}
    with running(folder, 2, "-q", case=CASE, **settings) as run:
        time.sleep(moment)
        ranks = run.ranks()
        chosen = {"first": ranks[:1], "last": ranks[-1:], "all": ranks}[whom]
        begun = all(map(handles, ranks))
        for number, pause in zip(numbers, (gap, 0.0)):
            send(chosen, number)
            time.sleep(pause)
        if not run.gone(ranks, GONE):
            return f"{what}: processes are left after {GONE:g} s"
        code, said = run.process.returncode, run.output()
    # Before Python has started, nothing of parisph can say how it ends.
    if begun and "Traceback" in said:
        return f"{what}: {said[-1000:]}"
    if begun and code not in (0, 4):
        return f"{what}: exit code {code}: {said[-1000:]}"
    return _finish(folder, what)


def _finish(folder, what):
    """Go on with the run, or start it where it had not begun; see that all of it is there."""
    run = folder / "run"
    begun = (run / "case.json").exists()
    if not begun and run.exists() and {path.name for path in run.iterdir()} - {"run.lock"}:
        return f"{what}: the run has not begun, but left {sorted(path.name for path in run.iterdir())}"
    wrong = None if begun and _status(run) == "completed" else gone_on(folder, what)
    if wrong:
        return wrong
    steps = reader.open_run(run).steps["step"]
    if _status(run) != "completed" or not np.array_equal(steps, np.arange(1, len(steps) + 1)):
        return f"{what}: status {_status(run)}, steps {steps}"
    return None


def _status(run):
    return reader.open_run(run).summary.get("status") if (run / "summary.json").exists() else None
