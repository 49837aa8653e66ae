"""Probes at a fixed rate: samples at exactly k intervals, on the straight line between the steps around."""

import numpy as np
import pytest
from mpi4py import MPI

from parisph import CaseError, Force, Output, ProbeArray, RunUp, VelocityPoint
from parisph.driver import run
from parisph.driver.probing import Watch, _between
from parisph.io import reader, series
from tests.driver.test_restart import BODY
from tests.scenes import on_two_and_then, ran, scene

UNIT = (1.0 / 9.81) ** 0.5
SEVERAL = ProbeArray("several", [RunUp("up", side="left"), Force("load"), VelocityPoint("u", at=(0.2, 0.2))])


def fall(folder, **output):
    """Run the first moments of a dam break in adaptive steps."""
    case = scene("dam_break", {"rtol": 1e-13}, spacing=0.1, end_time=0.6,
                 time_step="none", cfl=0.8)
    case = case.changed(probes=[*case.probes, SEVERAL], output=Output(**output))
    return ran(case, folder)


@pytest.fixture(scope="module")
def every_step(tmp_path_factory):
    return fall(tmp_path_factory.mktemp("rate") / "run")


@pytest.mark.parametrize("interval", [0.0007, 0.0031, 0.04])
def test_samples_lie_on_the_line_between_steps(tmp_path, every_step, interval):
    """Intervals shorter than a step, near it and longer."""
    found = fall(tmp_path / "run", probe_interval=interval)
    end = found.case["end_time"]
    due = np.arange(int(end / interval) + 1) * interval
    np.testing.assert_array_equal(found.steps["time"], every_step.steps["time"])    # no step is shortened
    for name in (probe["name"] for probe in found.case["probes"] if probe["every"] == 1):
        samples, steps = found.probe(name), every_step.probe(name)
        assert samples["time"].tolist() == due.tolist()     # to the last bit, and none after the end
        for column in samples.dtype.names[2:]:
            line = np.interp(due, steps["time"], steps[column])
            scale = np.nanmax(np.abs(steps[column]))
            np.testing.assert_allclose(samples[column], line, rtol=0, atol=1e-11 * scale, err_msg=f"{name} {column}")
        after = np.searchsorted(steps["time"], due * (1 - 1e-12))
        np.testing.assert_array_equal(samples["step"], steps["step"][after])
        head = (found.folder / "probes" / f"{name}.csv").read_text().splitlines()[0]
        assert f"every {interval:g} s by linear interpolation in time" in head
        assert series.units(found.folder / "probes" / f"{name}.csv")["time"] == "s"


def test_a_sample_at_the_very_end_is_there(tmp_path):
    end = 0.6 * UNIT
    samples = fall(tmp_path / "run", probe_interval=end / 7).probe("P1")
    np.testing.assert_allclose(samples["time"], np.arange(8) * end / 7, rtol=1e-15)


def test_particles_are_looked_at_in_the_steps_around_a_sample_only(tmp_path, monkeypatch):
    sampled, sample = [], Watch._sample

    def counted(self, samplers):
        if not all(sampler.of_pressure for sampler in samplers):     # P2 is looked at in every step, for its peak
            sampled.append(self.simulation.steps)
        return sample(self, samplers)

    monkeypatch.setattr(Watch, "_sample", counted)
    found = fall(tmp_path / "run", probe_interval=0.05)
    around = ([0] + [step for k in (1, 2, 3)
                     for step in (np.searchsorted(found.steps["time"], 0.05 * k) + np.array([0, 1])).tolist()])
    assert sampled == around and len(sampled) < len(found.steps)


def test_a_gauge_that_loses_the_water_spoils_no_other_value():
    nan = float("nan")
    before, after = (1.0, {"g": (nan, 2.0)}), (2.0, {"g": (4.0, 3.0)})
    np.testing.assert_array_equal(_between(before, after, 1.25)["g"], (nan, 2.25))
    np.testing.assert_array_equal(_between(before, after, 1.75)["g"], (4.0, 2.75))
    np.testing.assert_array_equal(_between(before, after, 2.0)["g"], (4.0, 3.0))
    np.testing.assert_array_equal(_between(None, after, 2.0)["g"], (4.0, 3.0))


RATE = BODY.replace('"output.probe_every": 3', '"output.probe_interval": 0.0007')


def test_nothing_is_missed_or_repeated_over_a_restart_on_other_ranks(tmp_path):
    """Fixed steps of 5 ms, of which none ends where a sample is due: the run stops between two of these."""
    on_two_and_then(3, RATE, 'driver.run(fall(0.6), comm, "whole", progress=False)\n'
                             'driver.run(fall(0.31), comm, "part", progress=False)\n',
                    'driver.restart("part", comm, until=0.6 * (1.0 / 9.81) ** 0.5, progress=False)', tmp_path)
    part, whole = (reader.open_run(tmp_path / name) for name in ("part", "whole"))
    for probe in whole.case["probes"]:
        name, every = probe["name"], probe["every"]
        a, b = part.probe(name), whole.probe(name)
        assert a["time"].tolist() == b["time"].tolist() == (np.arange(0, every * len(b), every) * 0.0007).tolist()
        assert len(b) > 250 / every
        np.testing.assert_array_equal(a["step"], b["step"])
        for column in b.dtype.names[2:]:
            np.testing.assert_allclose(a[column], b[column], rtol=1e-6, atol=1e-6 * np.nanmax(np.abs(b[column])),
                                       err_msg=f"{name} {column}")


def test_a_rate_is_in_steps_or_in_time():
    with pytest.raises(CaseError, match="probe_every = 3 and probe_interval = 0.01 s: give only one of them"):
        Output(probe_every=3, probe_interval=0.01)
    with pytest.raises(CaseError, match="probe_interval = 1e-12 s: takes .* samples"):
        scene("dam_break", spacing=0.1).changed(**{"output.probe_interval": 1e-12})


@pytest.mark.parametrize("output", [{}, {"probe_every": 2}, {"probe_interval": 0.0031}])
def test_a_probe_may_have_fewer_samples(tmp_path, output):
    """Those that it has are samples of the run, from the first on; a restart continues to count."""
    found = {}
    for name, every in (("all", 1), ("few", 3)):
        case = scene("dam_break", spacing=0.1, end_time=0.5)
        probes = [probe.model_copy(update={"every": every}) if probe.kind in ("volume", "energy") else probe
                  for probe in case.probes]
        run(case.changed(probes=probes, output=Output(checkpoint_every=0.05, **output)), MPI.COMM_SELF,
            tmp_path / name, progress=False)
        found[name] = reader.open_run(tmp_path / name)
    for name in ("volume", "energy"):
        few, all_of_them = found["few"].probe(name), found["all"].probe(name)
        assert len(few) > 5 and few.tolist() == all_of_them[::3].tolist()
    assert found["few"].probe("P1").tolist() == found["all"].probe("P1").tolist()
    head = (found["few"].folder / "probes" / "energy.csv").read_text().splitlines()[0]
    assert ("every 0.0093 s" in head) == ("probe_interval" in output)


def test_members_of_an_array_have_its_samples():
    with pytest.raises(CaseError, match="every=N is for a probe with a file of its own"):
        ProbeArray("several", [Force("load", every=2)])
