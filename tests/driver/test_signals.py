"""Two signals to one of two ranks end both, in whatever they are; one rank alone never deadlocks the other."""

import os
import signal
import time

import pytest

from parisph.base import signals
from tests.running import FALLING, running

ENDLESS = ("--set", "end_time=1000", "--set", "checkpoint_every=100")
PATIENT = """
from parisph.base import signals
signals.COPY, signals.PATIENCE = 100.0, 100.0
"""    # so that a busy machine takes no copy for a second signal, and has the time to stop properly


def twice(pid, numbers, gap):
    for number, pause in zip(numbers, (gap, 0.0)):
        os.kill(pid, number)
        time.sleep(pause)


def ended(run):
    """Wait for the end; return the exit code and what was said."""
    return run.wait(), run.output()


SLOW_CASE = FALLING + """
import pathlib, time
pathlib.Path("waits").touch()
while not pathlib.Path("go").exists():
    time.sleep(0.01)
"""


def test_one_signal_while_the_case_is_loaded_stops_before_anything_is_made(tmp_path):
    with running(tmp_path, 2, case=SLOW_CASE) as run:
        run.until((tmp_path / "waits").exists)
        run.until_it_can_be_stopped()
        os.kill(run.ranks()[-1], signal.SIGTERM)
        (tmp_path / "go").touch()
        code, said = ended(run)
    assert code == 4 and said.count("parisph: error: ") == 1 and "stopped by SIGTERM before the run has begun" in said
    assert "Traceback" not in said and not (tmp_path / "run").exists()


SLOW_WARM_UP = """
import pathlib
from parisph.driver import warmup
def wait(*_):
    open("waits", "w").close()
    time.sleep(300)
warmup._step, warmup.mark_of = wait, lambda scene: pathlib.Path("no mark")
"""
SLOW_STEP = """
from parisph.methods.projection import Projection
step = Projection.step
def wait(self, *args):
    if self.flow.particles.comm.size == 1:
        return step(self, *args)    # of the warm-up
    if self.flow.particles.comm.rank == 0:
        open("waits", "w").close()
        time.sleep(300)
    self.flow.particles.comm.Barrier()
Projection.step = wait
"""


QUICK = """
from parisph.base import signals
signals.PATIENCE = 2.0
"""


@pytest.mark.parametrize(("where", "gap"), [("loading", 0.02), ("loading", 0.5), ("warm-up", 0.5), ("step", 0.02)])
def test_rank_that_waits_for_another_is_ended(tmp_path, where, gap):
    """The first one waits for the case file, the compiler or something else, and the last one for the first."""
    case = SLOW_CASE if where == "loading" else FALLING
    change = {"warm-up": QUICK + SLOW_WARM_UP, "step": QUICK + SLOW_STEP}.get(where, "")    # "": not even MPI is up
    with running(tmp_path, 2, case=case, change=change) as run:
        run.until((tmp_path / "waits").exists)
        run.until_it_can_be_stopped()
        twice(run.ranks()[-1], (signal.SIGTERM, signal.SIGINT), gap)
        code, said = ended(run)
    assert code == 4 and said.count("stopped at once by a second signal; ") == 1 and "Traceback" not in said
    tells = ("the last checkpoint is run/checkpoints/00000000.h5; continue with: parisph restart run" if where == "step"
             else "nothing has been written")
    assert tells in said
    assert (tmp_path / "run" / "case.json").exists() == (where == "step")


IN_A_CHECKPOINT = """
from parisph.io import checkpoint
write = checkpoint.write
def signalled(comm, folder, particles, time_, step, *more):
    if comm.rank == 1 and 0 < step < 5:
        for number in (signal.SIGINT, signal.SIGINT):
            os.kill(os.getpid(), number)
            time.sleep(0.005)
    return write(comm, folder, particles, time_, step, *more)
checkpoint.write = signalled
"""


def test_two_copies_of_a_signal_in_a_collective_write_are_one(tmp_path):
    with running(tmp_path, 2, change=PATIENT + IN_A_CHECKPOINT) as run:
        code, said = ended(run)
    assert code == 4 and "stopped at t = " in said and "by SIGINT" in said and "parisph restart run" in said
    assert "Traceback" not in said and "at once" not in said


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGUSR1])
def test_every_rank_may_get_it(tmp_path, number):
    """As from srun and scancel, twice."""
    with running(tmp_path, 2, *ENDLESS, change=PATIENT) as run:
        run.until_it_steps()
        for _ in range(2):
            for pid in run.ranks():
                os.kill(pid, number)
        code, said = ended(run)
    assert code == 4 and said.count(f"by {number.name}") == 1 and "Traceback" not in said


def test_handlers_are_put_back():
    before = [signal.getsignal(number) for number in signals.NUMBERS]
    with signals.Signals() as outer:
        with signals.Signals.active() as inner:
            assert inner is outer
        os.kill(os.getpid(), signal.SIGUSR1)
        for _ in range(10_000):
            time.sleep(0.01)
            if outer.seen:
                break
        assert outer.seen == signal.SIGUSR1 and signals.Signals.active() is outer
    assert [signal.getsignal(number) for number in signals.NUMBERS] == before
    assert signal.set_wakeup_fd(-1) == -1 and signals.Signals.active() is not outer


def test_in_a_process_alone_a_second_one_raises():
    with pytest.raises(KeyboardInterrupt), signals.Signals():
        for _ in range(2):
            os.kill(os.getpid(), signal.SIGINT)
            time.sleep(2.0 * signals.COPY)
        time.sleep(100.0)
