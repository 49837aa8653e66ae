"""`every` means every: snapshots at the asked times exactly, and the start and the end in any case."""

import numpy as np
import pytest
from mpi4py import MPI

from parisph.__main__ import main
from parisph.base.errors import Interrupted
from parisph.case.schema import Output
from parisph.driver import loop, restart, run
from parisph.io import checkpoint, reader
from tests.scenes import scene

UNIT = (1.0 / 9.81) ** 0.5
STEP = 0.032 * UNIT     # of the dam break at H/s = 10
BOTH = pytest.mark.parametrize("time_step", [STEP, None])


def falling(end_time=0.38, time_step=STEP, numerics=None, **output):
    """Return the case of the first moments of a dam break, end_time in sqrt(H/g)."""
    return scene("dam_break", numerics, spacing=0.1, end_time=end_time).changed(
        **{"numerics.time_step": time_step, "output": Output(**output)})


def done(case, folder):
    """Run a case in this process and return its Run."""
    run(case, MPI.COMM_SELF, folder, progress=False)
    return reader.open_run(folder)


def last(found):
    return checkpoint.read(MPI.COMM_SELF, checkpoint.paths(found.folder / "checkpoints")[-1])


def test_fixed_steps_that_divide_the_interval_are_not_touched(tmp_path):
    plain = done(falling(), tmp_path / "a")
    watched = done(falling(every=4 * STEP, times=(6 * STEP,)), tmp_path / "b")
    assert np.all(watched.steps["dt"] == STEP)
    assert watched.times.tolist() == [0.0, 4 * STEP, 6 * STEP, 8 * STEP, 12 * STEP]
    for name, values in last(plain).arrays.items():
        np.testing.assert_array_equal(last(watched).arrays[name], values, err_msg=name)


@BOTH
def test_snapshots_are_of_the_asked_times(tmp_path, time_step):
    every, further = 2.1 * STEP, (0.0101, 0.0333)
    case = falling(time_step=time_step, every=every, times=further)
    found = done(case, tmp_path / "run")
    asked = sorted({0.0, *further, *(k * every for k in range(1, 99) if k * every < case.end_time)})
    assert found.times.tolist() == [*asked, found.summary["time"]]
    assert [found.snapshot(n)["time"] for n in range(len(found))] == found.times.tolist()
    assert set(found.times[1:]) <= set(found.steps["time"])
    if time_step is None:
        assert found.times[-1] == case.end_time


@BOTH
def test_a_restart_between_two_shortened_steps_takes_the_same(tmp_path, time_step, monkeypatch):
    case = falling(0.6, time_step, {"rtol": 1e-13}, times=(0.3 * UNIT,))
    whole = done(case, tmp_path / "whole")
    steps = whole.steps
    second = np.flatnonzero(steps["time"] == 0.3 * UNIT)[0]
    assert (steps["dt"][second - 1] == pytest.approx(steps["dt"][second])
            and steps["dt"][second] < 0.999 * steps["dt"][second + 1])
    with monkeypatch.context() as patch:
        patch.setattr(loop._Run, "_asked", lambda self: (loop.SAVE + 2) * (self.simulation.steps == second))
        with pytest.raises(Interrupted):
            run(case, MPI.COMM_SELF, tmp_path / "part", progress=False)
    assert last(reader.open_run(tmp_path / "part")).time == pytest.approx(steps["time"][second - 1], rel=1e-12)
    restart(tmp_path / "part", MPI.COMM_SELF, progress=False)
    part = reader.open_run(tmp_path / "part")
    np.testing.assert_allclose(part.steps["time"], steps["time"], rtol=1e-12)
    np.testing.assert_allclose(part.steps["dt"], steps["dt"], rtol=1e-9)
    assert part.times.tolist() == whole.times.tolist()


@BOTH
def test_start_and_end_are_there_to_be_looked_at_without_any_output_asked_for(tmp_path, time_step, capsys):
    found = done(falling(0.1, time_step), tmp_path / "run")
    assert found.times.tolist() == [0.0, found.summary["time"]]
    np.testing.assert_array_equal(found.snapshot()["x"][np.argsort(found.snapshot()["id"])], _by_id(last(found)))
    assert main(["plot", str(found.folder)]) == 0
    assert capsys.readouterr().out.split() == [str(found.folder / "overview.png")]


def _by_id(saved):
    return saved.arrays["x"][np.argsort(saved.arrays["id"])]


def test_the_end_of_a_run_that_is_extended_stays(tmp_path):
    done(falling(0.2, every=5 * STEP), tmp_path / "run")
    restart(tmp_path / "run", MPI.COMM_SELF, until=0.38 * UNIT, progress=False)
    found = reader.open_run(tmp_path / "run")
    np.testing.assert_allclose(found.times, STEP * np.array([0, 5, 6, 10, 12]), rtol=1e-12)
    assert [found.snapshot(n)["time"] for n in range(len(found))] == found.times.tolist()


def test_an_end_that_is_due_is_written_once(tmp_path):
    found = done(falling(10 * 0.032, every=5 * STEP), tmp_path / "run")
    np.testing.assert_allclose(found.times, STEP * np.array([0, 5, 10]), rtol=1e-12)
