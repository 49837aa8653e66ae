"""A run that was stopped and goes on, on more ranks, ends as one that never stopped."""

import json

import numpy as np
import pytest

from parisph.io import checkpoint, reader
from tests.running import last_checkpoint
from tests.scenes import assert_same, on_ranks

END = 1.0       # t sqrt(g/H)
BODY = """
from parisph import driver

def fall(end, **sets):
    # snapshots and checkpoints fall between steps, where what is due could be missed or repeated
    case = scene("dam_break", {"rtol": 1e-13, "gamma": 0.01}, spacing=0.05, end_time=end, snapshot_every=0.11,
                 **{"time_step": 0.004, **sets})
    return case.changed(**{"output.checkpoint_every": 0.0777, "output.probe_every": 3})
"""
FIRST = """
summary = driver.run(fall({end}), comm, "whole", progress=False)
everyone = comm.allgather(summary)
assert everyone[0] == everyone[1] and {{"iterations", "errors"}} <= set(summary), everyone
driver.run(fall({half}), comm, "part", progress=False)
driver.run(fall({end}, time_step="none"), comm, "adaptive", progress=False)
""".format(end=END, half=0.5 * END)
THEN = """
from parisph.io import checkpoint
unit = (1.0 / 9.81) ** 0.5
driver.restart("part", comm, until={end} * unit, progress=False)
driver.restart(checkpoint.paths("adaptive/checkpoints")[0], comm, out="later", progress=False)
""".format(end=END)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("restart")
    on_ranks(2, BODY + FIRST, folder)
    (folder / "part-summary.json").write_text((folder / "part" / "summary.json").read_text())
    on_ranks(3, BODY + THEN, folder)
    return folder


@pytest.mark.parametrize(("stopped", "straight"), [("part", "whole"), ("later", "adaptive")])
def test_same_result(folder, stopped, straight):
    (found, fields), (due, expected) = (last_checkpoint(folder / name) for name in (stopped, straight))
    assert (found["ranks"], due["ranks"]) == (3, 2)
    assert (found["step"], found["time"], found["dt"]) == pytest.approx((due["step"], due["time"], due["dt"]),
                                                                        rel=1e-12)
    assert np.abs(expected["u"]).max() > 1.0
    assert_same(expected, fields, 1e-8, ("x", "u", "p", "phi"))


def test_series_go_on_without_gap_or_repetition(folder):
    found, expected = reader.open_run(folder / "part"), reader.open_run(folder / "whole")
    steps = expected.steps["step"]
    np.testing.assert_array_equal(steps, np.arange(1, len(steps) + 1))
    np.testing.assert_array_equal(found.steps["step"], steps)
    np.testing.assert_allclose(found.steps["time"], expected.steps["time"], rtol=1e-12)
    assert found.probe_names == expected.probe_names
    for probe in expected.case["probes"]:    # the volume has one sample in ten
        name = probe["name"]
        a, b = found.probe(name), expected.probe(name)
        np.testing.assert_array_equal(a["step"], np.arange(0, len(steps) + 1, 3 * probe["every"]))
        for column in b.dtype.names:
            np.testing.assert_allclose(a[column], b[column], rtol=1e-6, atol=1e-6 * np.nanmax(np.abs(b[column])),
                                       err_msg=f"{name} {column}")


def test_series_in_another_folder_begin_at_the_checkpoint(folder):
    found, expected = reader.open_run(folder / "later").steps, reader.open_run(folder / "adaptive").steps
    begin = checkpoint.paths(folder / "adaptive" / "checkpoints")[0]
    np.testing.assert_array_equal(found["step"], np.arange(int(begin.stem) + 1, expected["step"][-1] + 1))
    np.testing.assert_allclose(found["dt"], expected["dt"][-len(found):], rtol=1e-9)


def test_snapshots_are_those_of_a_run_that_never_stopped(folder):
    found, expected = reader.open_run(folder / "part"), reader.open_run(folder / "whole")
    due, step = 0.11 * np.arange(10) * (1.0 / 9.81) ** 0.5, expected.steps["dt"][0]
    np.testing.assert_allclose(expected.times[:-1], due, atol=0.5001 * step)
    assert expected.times[-1] == expected.summary["time"]
    first_end = json.loads((folder / "part-summary.json").read_text())["time"]      # the end of the first part stays
    np.testing.assert_allclose(found.times, np.sort([*expected.times, first_end]), rtol=1e-12)


def test_summary_counts_the_whole_run(folder):
    whole, both, part = (json.loads((folder / name).read_text()) for name in
                         ("whole/summary.json", "part/summary.json", "part-summary.json"))
    assert both["status"].startswith("completed") and both["ranks"] == 3
    assert (both["status"], len(both["warnings"])) == (whole["status"], len(whole["warnings"]))
    assert (both["steps"], both["time"], both["fallbacks"]) == (whole["steps"], pytest.approx(whole["time"]),
                                                                whole["fallbacks"])
    times = reader.open_run(folder / "whole").steps["time"]
    assert (part["time"] == pytest.approx(times[part["steps"] - 1], rel=1e-12)
            and 0.45 < part["steps"] / whole["steps"] < 0.55)
    for key in ("energy_drift", "volume_drift"):    # against the start of the run, not of its second part
        assert both[key] == pytest.approx(whole[key], rel=1e-6)
    for key in ("phases", "cpu_phases"):
        assert set(both[key]) == set(whole[key])
        for name, seconds in part[key].items():
            assert both[key][name] >= seconds
    for key in ("wall_seconds", "cpu_seconds"):
        assert both[key] > part[key]
    assert both["iterations"]["max"] == reader.open_run(folder / "part").steps["iterations"].max()


def test_phases_add_up(folder):
    for name in ("whole", "part"):
        summary = json.loads((folder / name / "summary.json").read_text())
        least = 0.7 if name == "whole" else 0.0    # the other was begun twice, which is a part of no phase
        assert least < sum(summary["phases"].values()) / summary["wall_seconds"] < 1.3
        assert least < sum(summary["cpu_phases"].values()) / summary["cpu_seconds"] <= 1.0
