"""The flow at a probe's greatest value is kept, whatever comes between."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from mpi4py import MPI

from parisph import CaseError, PeakBand, Peaks, PressureTap, SurfaceGauge, Truth, WaterFront
from parisph.__main__ import main
from parisph.base.fields import FIELDS
from parisph.case.schema import Output
from parisph.driver import run
from parisph.driver.peaks import PeakFlows
from parisph.io import reader
from parisph.io.store import Store
from parisph.parallel.particles import Particles
from tests import watched
from tests.scenes import assert_same, on_two_and_then, ran, restart_alone, scene

UNIT = (1.0 / 9.81) ** 0.5
TAP = PressureTap("tap", at=(0.0, 0.1), peak=True)


# ---- a made-up probe, to come to each of its turns

class Acting:
    """A run without a flow: particles whose x is the step, and a tap that takes given values."""

    def __init__(self, folder, values, state=None, store=None, tap=TAP):
        particles = Particles(MPI.COMM_SELF, 2)
        particles.assign({name: field.empty(3, 2) for name, field in FIELDS.items()} | {"id": np.arange(3)})
        self.simulation = SimpleNamespace(comm=MPI.COMM_SELF, particles=particles, time=0.0, pressure_time=0.0,
                                          steps=-1)
        self.values, self.folder = values, folder
        self.store = store or Store.create(MPI.COMM_SELF, folder, watched.scene([TAP]).model_dump_json())
        sampler = SimpleNamespace(name="tap", probe=tap, of_pressure=True)
        self.peaks = PeakFlows(self.simulation, [sampler], ("u", "p", "role"), state)

    def go(self, first, last):
        """Take the steps from first to last; return what is in the folder then: (step, value) or None."""
        for step in range(first, last + 1):
            s = self.simulation
            s.steps, s.time, s.pressure_time = step, 0.1 * step, 0.1 * step - 0.05
            s.particles.x[:] = step
            self.peaks.look({"tap": (self.values[step],)})
            self.peaks.write(self.store)
        return kept(self.folder)

    def save(self):
        self.peaks.write(self.store, all_of_them=True)
        return self.peaks.state()


def kept(folder, name="tap"):
    path = folder / "peaks" / f"{name}.vtkhdf"
    if not path.exists():
        return None
    (folder / "probes" / f"{name}.csv").touch()     # a run of which only the probe's name is read
    found = reader.open_run(folder).peak(name)
    assert np.all(found["x"] == found["step"]) and found["time"] == pytest.approx(0.1 * found["step"]) and "p" in found
    return found["step"], found["peak"]


def resumed(folder, values, state, step):
    case = watched.scene([TAP]).model_dump_json()
    run = reader.open_run(folder).identity
    store = Store.resume(MPI.COMM_SELF, folder, case, 0.1 * step, step, run=run)
    return Acting(folder, values, state, store)


def test_it_is_written_when_the_value_has_clearly_fallen_and_again_when_it_is_exceeded(tmp_path):
    acting = Acting(tmp_path / "run", [0.0, 2.0, 10.0, 9.5, 8.0, 9.0, 11.0, 10.8, 9.8, 1.0])
    assert acting.go(0, 3) is None          # 9.5 is no clear fall: less than a tenth of the range
    assert acting.go(4, 5) == (2, 10.0)
    assert acting.go(6, 7) == (2, 10.0)     # 11 is held in memory
    assert acting.go(8, 9) == (6, 11.0)


def test_a_checkpoint_writes_what_is_held(tmp_path):
    acting = Acting(tmp_path / "run", [0.0, 5.0, 6.0])
    acting.go(0, 2)
    assert acting.save()["tap"]["greatest"] == 6.0 and kept(tmp_path / "run") == (2, 6.0)


def test_no_number_and_an_equal_value_are_no_peak(tmp_path):
    acting = Acting(tmp_path / "run", [float("nan"), 5.0, float("nan"), 5.0, float("inf"), 0.0])
    assert acting.go(0, 5) == (1, 5.0)
    acting = Acting(tmp_path / "none", [float("nan")])
    acting.go(0, 0)
    assert acting.save() == {} and kept(tmp_path / "none") is None


@pytest.mark.parametrize("truth", [
    Peaks([PeakBand(start=0.15, end=0.35, when=0.2)]), Truth("a.csv", time="t", value="p", window=(0.15, 0.35)),
    Truth("a.csv", time="t", value="p", window=(0.0, 9.0), peaks=(PeakBand(start=0.15, end=0.35, low=1.0, high=2.0),)),
])
def test_only_values_within_the_truth_of_the_probe_count(tmp_path, truth):
    tap = TAP.model_copy(update={"truth": truth})
    values = [50.0, 40.0, 3.0, 5.0, 9.0, 60.0]
    acting = Acting(tmp_path / "run", values, tap=tap)
    acting.go(0, 5)
    assert acting.save()["tap"]["greatest"] == 5.0 and kept(tmp_path / "run") == (3, 5.0)
    early = Acting(tmp_path / "early", values, tap=tap)
    assert early.go(0, 1) is None and early.save() == {}, "nothing is kept before its window"


def test_negative_values_have_a_peak_too(tmp_path):
    assert Acting(tmp_path / "run", [-9.0, -1.0, -5.0]).go(0, 2) == (1, -1.0)


VALUES = [0.0, 10.0, 1.0, 5.0, 20.0, 2.0, 2.0]     # the lower peak before, the higher one after a checkpoint at step 3


def test_a_lower_value_after_a_restart_is_no_peak(tmp_path):
    acting = Acting(tmp_path / "run", [0.0, 10.0, 1.0])
    acting.go(0, 2)
    state = acting.save()
    assert resumed(tmp_path / "run", [None] * 3 + [8.0, 0.0], state, 2).go(3, 4) == (1, 10.0)


def test_a_run_killed_after_a_higher_peak_begins_from_what_its_checkpoint_knows(tmp_path):
    acting = Acting(tmp_path / "run", VALUES)
    acting.go(0, 3)
    state = acting.save()
    assert acting.go(4, 6) == (4, 20.0)
    again = resumed(tmp_path / "run", VALUES[:4] + [19.0, 2.0], state, 3)   # other ranks, say: not quite the same
    assert kept(tmp_path / "run") == (1, 10.0)
    assert again.go(4, 5) == (4, 19.0)
    never = resumed(tmp_path / "run", VALUES[:4] + [4.0, 2.0], state, 3)
    assert kept(tmp_path / "run") == (1, 10.0) and never.go(4, 5) == (1, 10.0)
    assert len(list((tmp_path / "run" / "replaced").rglob("tap.vtkhdf"))) == 2    # nothing is lost


def test_the_peak_that_the_checkpoint_knows_outlasts_several_higher_ones(tmp_path):
    acting = Acting(tmp_path / "run", [0.0, 10.0, 1.0, 20.0, 1.0, 30.0, 1.0])
    acting.go(0, 2)
    state = acting.save()
    assert acting.go(3, 6) == (5, 30.0)
    resumed(tmp_path / "run", [], state, 2)
    assert kept(tmp_path / "run") == (1, 10.0)


def test_in_another_folder_the_peak_so_far_is_there_too(tmp_path):
    acting = Acting(tmp_path / "run", VALUES)
    acting.go(0, 3)
    state = acting.save()
    acting.go(4, 6)                          # by now the peak of step 1 is in peaks/before
    other = Acting(tmp_path / "other", VALUES[:4] + [3.0, 15.0, 1.0], state)
    other.peaks.bring(Path(tmp_path / "run"))
    assert other.go(4, 4) == (1, 10.0)
    assert other.go(5, 6) == (5, 15.0)


def test_a_peak_that_cannot_be_brought_is_said(tmp_path, caplog):
    other = Acting(tmp_path / "other", [3.0, 4.0],
                   {"tap": {"least": 0.0, "greatest": 10.0, "time": 0.3, "step": 3, "now": 2.0}})
    other.peaks.bring(tmp_path / "run")
    assert "the flow at the peak of tap so far, t = 0.3 s, is no longer in" in caplog.text
    other.go(0, 1)
    other.save()
    assert kept(tmp_path / "other") is None


# ---- whole runs

def impact(end_time, **output):
    return scene("dam_break", {"rtol": 1e-13}, spacing=0.05, end_time=end_time, time_step=0.004).changed(
        output=Output(**output))


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    return ran(impact(2.0), tmp_path_factory.mktemp("whole") / "run")


def greatest(found, name="P2"):
    samples = found.probe(name)
    return samples[np.nanargmax(samples["pressure"])]


def test_the_flow_kept_is_that_of_the_maximum_in_the_series(whole):
    peak, line = whole.peak("P2"), greatest(whole)
    assert peak["step"] == line["step"] and peak["peak"] == pytest.approx(line["pressure"], rel=1e-9)
    # the flow is that of the end of the step, its pressure that of its middle
    after = whole.steps["time"] == peak["time"]
    assert whole.steps["step"][after] == peak["step"]
    assert peak["time"] - line["time"] == pytest.approx(0.5 * whole.steps["dt"][after][0])
    assert line["pressure"] > 1e4 and 1.5 < line["time"] / UNIT < 2.0
    near = np.abs(peak["x"] - (2.0, 0.05)).max(axis=1) < 0.01      # the wall particle at the tap
    assert peak["p"][near] == pytest.approx(line["pressure"], rel=0.05)  # that of the step alone
    assert whole.peak("P1") is None and len(whole.times) == 2       # it is none of the snapshots


def test_it_is_the_state_that_a_snapshot_of_that_time_holds(whole, tmp_path):
    peak = whole.peak("P2")
    snapshot = ran(impact(1.8, times=(peak["time"],)), tmp_path / "run").snapshot(peak["time"])
    for name in ("x", "u", "p", "role"):
        np.testing.assert_array_equal(peak[name], snapshot[name])


@pytest.mark.parametrize(("output", "probe"), [({"probe_every": 50}, {}), ({"probe_interval": 0.1}, {}),
                                               ({}, {"every": 50})])
def test_it_is_of_all_steps_however_seldom_samples_are_written(whole, tmp_path, output, probe):
    case = impact(2.0, **output)
    found = ran(case.changed(probes=[one.model_copy(update=probe) for one in case.probes]), tmp_path / "run")
    assert found.peak("P2")["step"] == whole.peak("P2")["step"] and len(found.probe("P2")) < 8


FIRST = """
for stop in (1.2, 1.9):
    driver.run(impact(stop), comm, f"run{stop}", progress=False)
"""
THEN = f"""
for stop in (1.2, 1.9):
    if comm.rank == 2:
        driver.restart(f"run{{stop}}", MPI.COMM_SELF, until={2.0 * UNIT!r}, out=f"elsewhere{{stop}}", progress=False)
    comm.Barrier()
    driver.restart(f"run{{stop}}", comm, until={2.0 * UNIT!r}, progress=False)
"""


def test_a_restart_on_other_ranks_before_or_after_it_ends_with_the_same(whole, tmp_path):
    due = whole.peak("P2")
    assert 1.2 < due["time"] / UNIT < 1.9
    on_two_and_then(3, "from parisph import driver\nfrom tests.driver.test_peaks import impact", FIRST, THEN, tmp_path)
    for folder in ("run1.2", "run1.9", "elsewhere1.2", "elsewhere1.9"):
        found = reader.open_run(tmp_path / folder).peak("P2")
        assert found["step"] == due["step"] and found["peak"] == pytest.approx(due["peak"], rel=1e-5)
        assert_same(due, found, 1e-5)


def test_ends_before_within_and_behind_it_leave_no_trace(whole, tmp_path):
    """At each end the flow kept is that of the series up to there, and of the whole series after the last one."""
    ends = whole.steps["time"][whole.peak("P2")["step"] + np.arange(-3, 5)]
    ran(impact(ends[0] / UNIT), tmp_path / "run")
    for until in (*ends[1:], 2.0 * UNIT):
        agrees(reader.open_run(tmp_path / "run"))
        restart_alone(tmp_path / "run", until=until)
    agrees(reader.open_run(tmp_path / "run"))


def agrees(found):
    peak, line = found.peak("P2"), greatest(found)
    assert peak["step"] == line["step"] and peak["peak"] == pytest.approx(line["pressure"], rel=1e-9)


def test_within_a_window_it_is_the_greatest_there(whole, tmp_path, capsys):
    """Windows that end before the peak, and begin behind it, both within the hat of a knot."""
    series, probes = whole.probe("P2"), [probe for probe in impact(2.0).probes if probe.name == "P2"]
    k = int(np.nanargmax(series["pressure"]))
    windows = {"before": series["time"][[k - 60, k - 3]], "behind": series["time"][[k + 3, k + 45]]}
    case = impact(2.0).changed(probes=[probes[0].model_copy(update={"name": name, "truth": Peaks(
        [PeakBand(start=start - 1e-9, end=end + 1e-9, when=start)])}) for name, (start, end) in windows.items()])
    found = ran(case, tmp_path / "run")
    for name, (start, end) in windows.items():
        inside = (series["time"] >= start) & (series["time"] <= end)
        due = series[inside][np.nanargmax(series["pressure"][inside])]
        assert found.peak(name)["step"] == due["step"]
        assert found.peak(name)["peak"] == pytest.approx(due["pressure"], rel=1e-9)
    assert main(["plot", str(found.folder), "--peak", "before"]) == 0
    said = capsys.readouterr().err
    assert f"the run keeps the flow at t = {found.peak('before')['time']:.6g} s" in said and "peak=True" not in said


def test_a_run_that_fails_leaves_the_peak_up_to_there(tmp_path, monkeypatch):
    from parisph.base.errors import SolverDiverged
    from parisph.driver.simulation import Simulation

    advance = Simulation.advance

    def failing(self, *args):
        if self.steps == 5:
            raise SolverDiverged("on purpose")
        return advance(self, *args)

    monkeypatch.setattr(Simulation, "advance", failing)
    with pytest.raises(SolverDiverged):
        run(impact(1.0).changed(probes=[WaterFront("front", peak=True).model_dump()]), MPI.COMM_SELF,
            tmp_path / "run", progress=False)
    found = reader.open_run(tmp_path / "run")
    assert (found.summary["steps"], found.peak("front")["step"]) == (5, 5)


def test_plot_takes_it_and_says_nothing(whole, capsys):
    assert main(["plot", str(whole.folder), "--peak", "P2"]) == 0
    said = capsys.readouterr()
    assert (said.out.strip() == str(whole.folder / f"flow_pressure_{whole.peak('P2')['time']:.4f}s.png")
            and said.err == "")
    assert main(["plot", str(whole.folder), "--peak", "P1"]) == 0
    assert "no snapshot at the peak of P1" in capsys.readouterr().err
    assert main(["info", str(whole.folder)]) == 0
    kept = [line.split()[1] for line in capsys.readouterr().out.splitlines() if "the flow at its peak is kept" in line]
    assert kept == ["P2:"]


def test_only_true_or_false_asks_for_it():
    with pytest.raises(CaseError, match="SurfaceGauge.peak = 'yes': must be True or False"):
        SurfaceGauge("gauge", at=0.0, peak="yes")
