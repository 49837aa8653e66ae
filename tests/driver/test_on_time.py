"""Snapshots are of the steps nearest to the asked times, of the start and of the end; none changes a step."""

from functools import cache

import numpy as np
import pytest
from mpi4py import MPI

from parisph.__main__ import main
from parisph.base.errors import Interrupted
from parisph.case.schema import Output
from parisph.driver import loop
from parisph.io import checkpoint, reader
from tests.scenes import ran, restart_alone, run_alone, scene

UNIT = (1.0 / 9.81) ** 0.5
STEP = 0.032 * UNIT     # of the dam break at H/s = 10
BOTH = pytest.mark.parametrize("time_step", [STEP, None])


def falling(end_time=0.38, time_step=STEP, numerics=None, **output):
    """Return the case of the first moments of a dam break, end_time in sqrt(H/g)."""
    return scene("dam_break", numerics, spacing=0.1, end_time=end_time).changed(
        **{"numerics.time_step": time_step, "output": Output(**output)})


def last(found):
    return checkpoint.read(MPI.COMM_SELF, checkpoint.paths(found.folder / "checkpoints")[-1])


def test_fixed_steps_that_divide_the_interval_are_not_touched(tmp_path):
    plain = ran(falling(), tmp_path / "a")
    watched = ran(falling(every=4 * STEP, times=(6 * STEP,)), tmp_path / "b")
    assert np.all(watched.steps["dt"] == STEP)
    assert watched.times == pytest.approx(STEP * np.array([0, 4, 6, 8, 12]), rel=1e-12)
    for name, values in last(plain).arrays.items():
        np.testing.assert_array_equal(last(watched).arrays[name], values, err_msg=name)


@BOTH
def test_snapshots_are_of_the_nearest_steps(tmp_path, time_step):
    every, further = 2.1 * STEP, (0.0101, 0.0333)
    case = falling(time_step=time_step, every=every, times=further)
    found = ran(case, tmp_path / "run")
    asked = sorted({*further, *(k * every for k in range(1, 99) if k * every < case.end_time)})
    ends = np.array(found.steps["time"])
    assert set(found.times[1:]) <= set(ends)
    assert [found.snapshot(n)["time"] for n in range(len(found))] == found.times.tolist()
    for time in asked:    # the step after is at most a tenth longer than the one that was thought of
        assert np.abs(found.times - time).min() <= 1.1 * np.abs(ends - time).min() + 1e-12
    assert len(found) <= len(asked) + 2
    if time_step is None:
        assert found.times[-1] == case.end_time


OUTPUTS = ({"every": 0.013, "fields": ("u", "p", "vorticity"), "checkpoint_every": 0.02, "probe_interval": 0.003,
            "budget": True},
           {"times": (0.011, 0.0111), "probe_every": 3, "fields": ("role",)})


@pytest.mark.parametrize("name", ["dam_break", "dam_break_sill"])
@pytest.mark.parametrize("output", OUTPUTS)
def test_what_is_written_does_not_change_what_is_computed(tmp_path, plain_runs, name, output):
    """Bit for bit, with probes or without, in a plain tank and among walls of any shape."""
    case, plain = plain_runs(name)
    found = ran(case.changed(output=Output(**output)), tmp_path / "run")
    assert len(found.steps) == len(plain.steps) > 20
    for column in ("time", "dt", "iterations"):
        np.testing.assert_array_equal(found.steps[column], plain.steps[column], err_msg=column)
    fields, due = last(found).arrays, last(plain).arrays
    for field in set(fields) & set(due):
        np.testing.assert_array_equal(fields[field], due[field], err_msg=field)


@pytest.fixture(scope="module")
def plain_runs(tmp_path_factory):
    """Return a function: name -> (case, its Run without probes and without any output asked for)."""
    @cache
    def plain(name):
        spacing, end_time = {"dam_break": (0.1, 1.5), "dam_break_sill": (0.04, 0.12)}[name]
        case = scene(name, spacing=spacing, end_time=end_time)
        return case, ran(case.changed(output=Output(), probes=()), tmp_path_factory.mktemp("plain") / "run")
    return plain


def test_a_restart_between_two_shortened_steps_takes_the_same(tmp_path, monkeypatch):
    case = falling(0.6, None, {"rtol": 1e-13})
    whole = ran(case, tmp_path / "whole")
    steps = whole.steps
    second = len(steps) - 4
    assert steps["dt"][second] == pytest.approx(steps["dt"][-1]) and steps["dt"][second] < 0.999 * steps["dt"][-12]
    with monkeypatch.context() as patch:
        patch.setattr(loop._Run, "_asked", lambda self: (loop.SAVE + 2) * (self.simulation.steps == second))
        with pytest.raises(Interrupted):
            run_alone(case, tmp_path / "part")
    assert last(reader.open_run(tmp_path / "part")).time == pytest.approx(steps["time"][second - 1], rel=1e-12)
    restart_alone(tmp_path / "part")
    part = reader.open_run(tmp_path / "part")
    np.testing.assert_allclose(part.steps["time"], steps["time"], rtol=1e-12)
    np.testing.assert_allclose(part.steps["dt"], steps["dt"], rtol=1e-9)
    assert part.times.tolist() == whole.times.tolist()


@BOTH
def test_start_and_end_are_there_to_be_looked_at_without_any_output_asked_for(tmp_path, time_step, capsys):
    found = ran(falling(0.1, time_step), tmp_path / "run")
    assert found.times.tolist() == [0.0, found.summary["time"]]
    np.testing.assert_array_equal(found.snapshot()["x"][np.argsort(found.snapshot()["id"])], _by_id(last(found)))
    assert main(["plot", str(found.folder)]) == 0
    assert capsys.readouterr().out.split() == [str(found.folder / "overview.png")]


def _by_id(saved):
    return saved.arrays["x"][np.argsort(saved.arrays["id"])]


def test_the_end_of_a_run_that_is_extended_stays(tmp_path):
    ran(falling(0.2, every=5 * STEP), tmp_path / "run")
    restart_alone(tmp_path / "run", until=0.38 * UNIT)
    found = reader.open_run(tmp_path / "run")
    np.testing.assert_allclose(found.times, STEP * np.array([0, 5, 6, 10, 12]), rtol=1e-12)
    assert [found.snapshot(n)["time"] for n in range(len(found))] == found.times.tolist()


def test_an_end_that_is_due_is_written_once(tmp_path):
    found = ran(falling(10 * 0.032, every=5 * STEP), tmp_path / "run")
    np.testing.assert_allclose(found.times, STEP * np.array([0, 5, 10]), rtol=1e-12)
