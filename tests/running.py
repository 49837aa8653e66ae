"""A run in the background, to be killed, interrupted or watched from a test."""

import os
import shutil
import signal
import subprocess
import sys
import time
from contextlib import contextmanager, suppress
from pathlib import Path

import h5py
import numpy as np

from parisph.io import checkpoint
from tests.launch import clean_environment

# A case file that reaches any parameter of a scene of cases/.
FALLING = """
from tests.scenes import scene
def case(end_time: float = 0.5, checkpoint_every: float = 0.01):
    return scene("dam_break", {"rtol": 1e-13}, spacing=0.05, end_time=end_time, time_step=0.004).changed(
        **{"output.checkpoint_every": checkpoint_every})
"""
# What stands around a program that changes something before it does as `parisph`.
PROGRAM = """
import os, signal, sys, time
from mpi4py import MPI
{change}
from parisph.__main__ import main
sys.exit(main())
"""
LONG = 200.0    # [s] for a run to come as far as a test wants it, or to end: a bound on hangs


def last_checkpoint(run):
    """Return (attributes, fields in the order of ids) of the last checkpoint of a run."""
    with h5py.File(checkpoint.paths(run / "checkpoints")[-1], "r") as file:
        order = np.argsort(file["particles/id"][:])
        return dict(file.attrs), {name: data[:][order] for name, data in file["particles"].items()}


class Running:
    """`parisph run CASE.py -o run ...` on some ranks, in the folder of the case.

    change : text of Python that each rank carries out before, "" for none
    settings : environment variables to set besides

    process : subprocess.Popen of mpirun, or of the only rank
    checkpoints : pathlib.Path
    """

    def __init__(self, folder, ranks, *words, change="", **settings):
        program = ["-m", "parisph"]
        if change:
            (folder / "program.py").write_text(PROGRAM.format(change=change))
            program = ["program.py"]
        command = [sys.executable, *program, "run", "case.py", "-o", "run", *words]
        self._several = ranks > 1
        if self._several:
            command = [shutil.which("mpirun"), "-n", str(ranks), *command]
        self._out = open(folder / "output.txt", "w+")
        self.process = subprocess.Popen(command, cwd=folder, env=clean_environment(**settings),
                                        start_new_session=True, text=True,
                                        stdin=subprocess.DEVNULL, stdout=self._out, stderr=subprocess.STDOUT)
        self.checkpoints = Path(folder) / "run" / "checkpoints"

    def until_checkpoints(self, count):
        """Wait until a checkpoint with the number `count` or later is there."""
        self.until(lambda: any(int(path.stem) >= count for path in checkpoint.paths(self.checkpoints)))

    def until_it_steps(self):
        """Wait until a step has been made."""
        steps = self.checkpoints.parent / "steps.csv"
        self.until(lambda: steps.exists() and any(line[:1].isdigit() for line in steps.read_text().splitlines()))

    def until_it_can_be_stopped(self):
        """Wait until all ranks, which must have been started, have handlers of signals."""
        self.until(lambda: all(map(handles, self.ranks())))

    def until(self, is_so):
        """Wait until a function returns True."""
        deadline = time.monotonic() + LONG
        while not is_so():
            assert self.process.poll() is None and time.monotonic() < deadline, self.output()
            time.sleep(0.003)

    def ranks(self):
        """Return the process ids of the ranks, in the order in which they were started."""
        return sorted(_children(self.process.pid)) if self._several else [self.process.pid]

    def gone(self, pids, seconds):
        """Wait for the end of mpirun and of its ranks, which go on for a moment without it; return whether it came."""
        deadline = time.monotonic() + seconds
        while self.process.poll() is None or any(map(lives, pids)):
            if time.monotonic() > deadline:
                return False
            time.sleep(0.01)
        return True

    def wait(self):
        """Wait for the end and return the exit code."""
        return self.process.wait(LONG)

    def output(self):
        """Return what the run has said so far."""
        self._out.seek(0)
        return self._out.read()


@contextmanager
def running(folder, ranks, *words, case=FALLING, change="", **settings):
    """A Running of a case, whose processes are gone afterwards."""
    (folder / "case.py").write_text(case)
    run = Running(folder, ranks, *words, change=change, **settings)
    try:
        yield run
    finally:
        send((*_children(run.process.pid), run.process.pid), signal.SIGKILL)
        run.process.wait()
        run._out.close()


def send(pids, number):
    """Send a signal to those processes that have not ended by themselves."""
    for pid in pids:
        with suppress(ProcessLookupError):
            os.kill(pid, number)


def handles(pid):
    """Return whether a process has set its own handler of SIGTERM: parisph has begun to work."""
    try:
        status = Path(f"/proc/{pid}/status").read_text()
    except OSError:
        return False
    caught = next((line.split()[1] for line in status.splitlines() if line.startswith("SigCgt")), "0")
    return bool(int(caught, 16) >> (signal.SIGTERM - 1) & 1)


def lives(pid):
    """Return whether a process is there, and no dead child that its parent has not asked about."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] not in "ZX"
    except OSError:
        return False


def _children(parent):
    found = []
    for path in Path("/proc").glob("[0-9]*/stat"):
        try:
            if int(path.read_text().rpartition(")")[2].split()[1]) == parent:
                found.append(int(path.parent.name))
        except OSError:     # gone meanwhile
            continue
    return found
