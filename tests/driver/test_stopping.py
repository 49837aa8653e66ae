"""Runs that are killed or asked to stop, and go on."""

import json
import os
import signal
import time

import numpy as np
import pytest

from parisph.io import checkpoint, reader
from tests.launch import parisph, succeeded
from tests.running import FALLING, last_checkpoint, running
from tests.scenes import assert_same

ENDLESS = ("--set", "end_time=1000")


def restarted(folder, ranks, *words):
    """Restart the run and return its summary."""
    succeeded(parisph("restart", "run", "-q", *words, ranks=ranks, cwd=folder))
    return json.loads((folder / "run" / "summary.json").read_text())


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    folder = tmp_path_factory.mktemp("undisturbed")
    (folder / "case.py").write_text(FALLING)
    succeeded(parisph("run", "case.py", "-o", "run", "-q", cwd=folder))
    return folder / "run"


HELD = """
from parisph.driver import Simulation
advance = Simulation.advance
def held(self):
    if self.steps == 30:    # of 32, so that no kill comes after the end
        time.sleep(300)
    return advance(self)
Simulation.advance = held
"""


@pytest.mark.parametrize("trial", [0, 2])    # on one rank and on three
def test_kill_9_and_restart(tmp_path, undisturbed, trial):
    """A checkpoint is written in every step, so some of these kills come in the middle of one."""
    random = np.random.default_rng(trial)
    with running(tmp_path, ranks=2, change=HELD) as run:
        run.until_checkpoints(random.integers(1, 25))
        time.sleep(random.uniform(0.0, 0.03))
        os.kill(run.ranks()[trial // 2], signal.SIGKILL)
        assert run.wait() != 0
    assert not (tmp_path / "run" / "summary.json").exists()
    summary = restarted(tmp_path, ranks=1 + trial % 3)
    (last, found), (expected, due) = last_checkpoint(tmp_path / "run"), last_checkpoint(undisturbed)
    assert summary["status"] == "completed" and summary["steps"] == last["step"] == expected["step"]
    assert_same(due, found)
    np.testing.assert_array_equal(reader.open_run(tmp_path / "run").steps["step"], np.arange(1, last["step"] + 1))
    assert not list((tmp_path / "run").rglob(".*"))


@pytest.mark.parametrize(("ranks", "number"), [(1, "SIGINT"), (1, "SIGUSR1"), (2, "SIGTERM")])
def test_signal_ends_the_run_after_its_step(tmp_path, ranks, number):
    with running(tmp_path, ranks, *ENDLESS, "--set", "checkpoint_every=100") as run:
        run.until_it_steps()
        os.kill(run.ranks()[-1], getattr(signal, number))   # of several ranks it reaches one only
        assert run.wait() == 4
        said = run.output()
    assert said.count("parisph: error: ") == 1 and f"by {number}" in said and "parisph restart run" in said
    assert "Traceback" not in said
    summary = json.loads((tmp_path / "run" / "summary.json").read_text())
    steps = int(checkpoint.paths(tmp_path / "run" / "checkpoints")[-1].stem)
    assert summary["status"] == "interrupted" and summary["steps"] == steps > 0
    assert summary["energy_drift"] is not None
    unit = (1.0 / 9.81) ** 0.5
    later = restarted(tmp_path, ranks, "--until", repr(summary["time"] + 0.1 * unit))
    assert later["status"] == "completed" and later["steps"] == pytest.approx(steps + 12, abs=1)
    np.testing.assert_array_equal(reader.open_run(tmp_path / "run").steps["step"], np.arange(1, later["steps"] + 1))


def test_signal_to_mpirun_leaves_a_checkpoint(tmp_path):
    """mpirun has an exit code of its own then, and gives its ranks a second."""
    with running(tmp_path, 2, *ENDLESS, "--set", "checkpoint_every=100") as run:
        run.until_it_steps()
        os.kill(run.process.pid, signal.SIGTERM)
        assert run.wait() != 0
    steps = int(checkpoint.paths(tmp_path / "run" / "checkpoints")[-1].stem)
    summary = restarted(tmp_path, 2, "--until", repr(0.05 + steps * 0.006))
    # how far it came before the signal is up to the machine, and after the fall the coarse scene gains energy
    assert summary["status"].startswith("completed") and summary["steps"] > steps


EARLY = """
from parisph.pressure.solver import PressureSolver

def stopped(work):
    def also(self, comm, *args, **options):
        if MPI.COMM_WORLD.rank == MPI.COMM_WORLD.size - 1:
            os.kill(os.getpid(), signal.SIGTERM)
        work(self, comm, *args, **options)
    return also

PressureSolver.__init__ = stopped(PressureSolver.__init__)
"""


@pytest.mark.parametrize("ranks", [1, 2])
def test_signal_during_the_set_up_leaves_a_checkpoint_of_the_start(tmp_path, ranks):
    with running(tmp_path, ranks, *ENDLESS, change=EARLY) as run:
        assert run.wait() == 4
        said = run.output()
    assert "stopped at t = 0 s by SIGTERM" in said and "Traceback" not in said
    assert [path.stem for path in checkpoint.paths(tmp_path / "run" / "checkpoints")] == ["00000000"]
    summary = json.loads((tmp_path / "run" / "summary.json").read_text())
    assert (summary["status"], summary["steps"], summary["energy_drift"]) == ("interrupted", 0, 0.0)
    assert restarted(tmp_path, ranks, "--until", "0.02")["status"] == "completed"


HANGING = FALLING + """
import pathlib, time
from parisph.methods.projection import Projection

def hang(*_):
    pathlib.Path("hanging").touch()
    while True:
        time.sleep(0.1)

Projection.step = hang
"""


def test_second_signal_ends_at_once(tmp_path):
    """A step that hangs, in a file system say, cannot be finished."""
    with running(tmp_path, 1, case=HANGING) as run:
        run.until((tmp_path / "hanging").exists)
        run.process.send_signal(signal.SIGTERM)
        time.sleep(0.3)
        assert run.process.poll() is None
        run.process.send_signal(signal.SIGTERM)
        assert run.wait() == 4
        assert "Traceback" not in run.output()
    summary = json.loads((tmp_path / "run" / "summary.json").read_text())
    assert summary["status"] == "interrupted" and summary["steps"] == 0
    assert summary["energy_drift"] == 0.0    # as at the start, which is in the checkpoint
    assert not list((tmp_path / "run").glob("summary-*"))
