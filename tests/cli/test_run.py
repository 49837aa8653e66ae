"""run and restart, whole, as a user does them from a shell."""

import json

import pytest

from tests.launch import mpirun, parisph, succeeded

CASE = '''
from parisph import Box, Case, Fluid, Numerics, Output, PressureTap, Tank
def case(end_time: float = 0.1) -> Case:
    return Case(title="small dam", fluid=Fluid(Box(width=0.5, height=1.0), density=1000.0), gravity=(0.0, -9.81),
                walls=Tank(width=1.0, height=1.5), numerics=Numerics(spacing=0.05, time_step=0.005), end_time=end_time,
                output=Output(every=0.025, checkpoint_every=0.05), probes=[PressureTap("corner", at=(0.0, 0.1))])
'''


@pytest.fixture
def place(tmp_path):
    (tmp_path / "dam.py").write_text(CASE)
    return tmp_path


def summary(folder):
    return json.loads((folder / "summary.json").read_text())


def test_run_on_two_ranks_and_go_on_with_three(place):
    done = succeeded(mpirun(2, ["-m", "parisph", "run", "dam.py"], timeout=200, cwd=place))
    assert "status          completed" in done.stdout and done.stdout.count("folder ") == 1
    folder = place / "runs" / "dam"
    first = summary(folder)
    assert (first["status"], first["ranks"], first["steps"]) == ("completed", 2, 20)
    assert first["time"] == pytest.approx(0.1)
    for name in ("case.json", "steps.csv", "probes/corner.csv", "flow.hdf.series", "snapshots/000004.vtkhdf",
                 "run.log"):
        assert (folder / name).stat().st_size > 0, name

    succeeded(mpirun(3, ["-m", "parisph", "restart", "runs/dam", "--until", "0.15", "-q"], timeout=200, cwd=place))
    second = summary(folder)
    assert (second["ranks"], second["steps"], second["particles"]) == (3, 30, first["particles"])

    done = parisph("info", "runs/dam", cwd=place)
    assert done.returncode == 0 and "small dam" in done.stdout and "t = 0 to 0.15 s" in done.stdout


def test_petsc_options_reach_the_solver(place):
    done = succeeded(parisph("run", "dam.py", "-q", "--", "-pressure_ksp_view", timeout=200, cwd=place))
    assert "KSP Object: (pressure_)" in done.stdout


FAULT = '''
import sys
from parisph.__main__ import main
from parisph.driver.simulation import Simulation
advance = Simulation.advance
def faulty(self):
    if self.steps == 2 and self.comm.rank == 1:
        raise ZeroDivisionError("in one rank's step")
    return advance(self)
Simulation.advance = faulty
sys.exit(main(["run", "dam.py", "-q"]))
'''


def test_a_fault_in_the_step_of_one_rank_ends_the_run(place):
    """The other rank waits in the step's collectives; nothing on the way out may wait for it."""
    (place / "fault.py").write_text(FAULT)
    done = mpirun(2, ["fault.py"], timeout=120, cwd=place)
    assert done.returncode == 1
    assert "ZeroDivisionError: in one rank's step" in done.stderr and "Traceback" in done.stderr
    left = summary(place / "runs/dam")
    assert left["status"] == "failed: rank 1: ZeroDivisionError: in one rank's step"
    assert (left["ranks"], left["steps"]) == (2, 2) and left["wall_seconds"] > 0.0
    # of the last sample, and of the last step
    assert left["volume_drift"] == 0.0 and 0.0 < abs(left["energy_drift"]) < 1e-3
    assert left["iterations"]["max"] > 0 and len(left["peak_memory_mb"]) == 1


WARM_UP = """
import pathlib, sys
from parisph.__main__ import main
from parisph.driver import warmup
def fails(*_):
    raise KeyError("no such compiler")
warmup._step, warmup.mark_of = fails, lambda scene: pathlib.Path("no mark")
sys.exit(main(["run", "dam.py", "-q"]))
"""


def test_a_fault_of_the_warm_up_is_told_by_all_with_its_traceback(place):
    """The other ranks wait for the first one to compile the kernels."""
    (place / "fault.py").write_text(WARM_UP)
    done = mpirun(2, ["fault.py"], timeout=120, cwd=place)
    assert done.returncode == 1 and "parisph: error: rank 0: KeyError: 'no such compiler'" in done.stderr
    assert "Traceback" in done.stderr and "in fails" in done.stderr
    assert not (place / "runs").exists()
