"""Kills at random moments, of one rank or of all, each followed by a restart that must finish the run."""

import signal
import time

import numpy as np

from parisph.base.errors import ParisphError
from parisph.io import reader
from tests.faults.table import each_in_its_folder, gone_on
from tests.launch import parisph
from tests.running import last_checkpoint, running, send
from tests.scenes import difference

# Checkpoints and snapshots in almost every step: many kills come in the middle of one.
CASE = """
from tests.faults.dam import dam
def case():
    return dam({"rtol": 1e-13}, spacing=0.05, end_time=0.5, snapshot_every=0.02).changed(
        **{"output.checkpoint_every": 0.01})
"""
GONE = 60.0        # [s] for all processes to end after a kill
SECONDS = 120.0    # [s] for a restart
COMPILE = 300.0    # [s] for the run that is never killed


def make(count, random, folder):
    """See table.Part."""
    due = folder / "due"
    due.mkdir()
    (due / "case.py").write_text(CASE)
    for out in ("compiled", "run"):    # the first run on a machine also compiles: its time does not count
        begun = time.monotonic()
        done = parisph("run", "case.py", "-o", out, "-q", cwd=due, timeout=COMPILE)
        whole = time.monotonic() - begun
        if done.returncode != 0:
            raise RuntimeError(done.stderr)
    yield from each_in_its_folder(count, folder, lambda place: _attempt(place, random, due / "run", whole))


def _attempt(folder, random, due, whole):
    ranks = int(random.integers(1, 3))
    victim = str(random.choice(["all", "mpirun", "first", "last"] if ranks > 1 else ["all"]))
    moment = float(random.uniform(0.0, 1.3 * whole))
    what = f"{ranks} ranks, {victim} killed after {moment:.2f} s"
    with running(folder, ranks, "-q", case=CASE) as run:
        time.sleep(moment)
        pids = run.ranks() if ranks > 1 else [run.process.pid]
        _kill(run, victim, pids)
        if not run.gone(pids, GONE):
            return f"{what}: processes are left after {GONE:g} s"
    return _finish(folder, int(random.integers(1, 4)), due, what)


def _kill(run, victim, pids):
    chosen = {"all": pids, "mpirun": [run.process.pid], "first": pids[:1], "last": pids[-1:]}[victim]
    send(chosen, signal.SIGKILL)


def _finish(folder, ranks, due, what):
    """Restart the run, or start it where it had not begun, and compare it with one that was never killed."""
    run = folder / "run"
    ended = (run / "summary.json").exists()    # before the kill
    wrong = None if ended else gone_on(folder, what, ranks, SECONDS)
    if wrong:
        return wrong
    try:
        return _compare(run, due, what)
    except ParisphError as error:
        return f"{what}: {error}"


def _compare(run, due, what):
    found, expected = reader.open_run(run), reader.open_run(due)
    if not found.summary["status"].startswith("completed"):
        return f"{what}: status {found.summary['status']}"
    if not np.array_equal(found.steps["step"], expected.steps["step"]):
        return f"{what}: steps {found.steps['step']}"
    if not np.allclose(found.times, expected.times, rtol=1e-12):
        return f"{what}: snapshots at {found.times}"
    for number in range(len(found)):
        found.snapshot(number)
    left = [path.name for path in run.rglob(".*")] + [path.name for path in run.glob("run.lock")]
    if left:
        return f"{what}: left behind {left}"
    (_, a), (_, b) = last_checkpoint(run), last_checkpoint(due)
    wrong = [name for name in ("x", "u", "p") if difference(a[name], b[name]) > 1e-8]
    return f"{what}: {wrong} differ from the run that was never killed" if wrong else None
