"""The errors of summary.json: probes of a made-up run against truths whose distance is known."""

import json

import numpy as np
import pytest
from mpi4py import MPI

from parisph.case.schema import Energy, PressureTap, SurfaceGauge, Truth, WaterFront
from parisph.case.truths import PeakBand
from parisph.io.reader import open_run
from parisph.io.store import Store
from parisph.truth import verdict
from tests.watched import scene

T = np.linspace(0.0, 2.0, 201)


@pytest.fixture
def reference(tmp_path):
    path = tmp_path / "reference.csv"
    path.write_text("t_s,eta,one\n" + "".join(f"{t},{0.01 * np.sin(t)},1\n" for t in T[::10]))
    return str(path)


def case_and_run(folder, watched, series, end=2.0):
    """series : {probe: (columns, function of time)}"""
    case = scene(watched)
    store = Store.create(MPI.COMM_SELF, folder / "run", json.dumps(json.loads(case.model_dump_json())))
    for name, (columns, _) in series.items():
        store.add_series(f"probes/{name}", columns)
    for step, t in enumerate(T[T <= end]):
        store.append(t, step, {f"probes/{name}": of(t) for name, (_, of) in series.items()})
    store.close()
    return case, folder / "run"


def test_waves_are_judged_without_the_depth_and_pressures_with_all(tmp_path, reference):
    watched = [
        SurfaceGauge(name="gauge", at=0.0, truth=Truth(reference, time="t_s", value="eta", offset=0.5, wave=True)),
        PressureTap(name="tap", at=(0.0, 0.1), truth=Truth(reference, time="t_s", value="one", scale=4000.0)),
        Energy(name="energy", truth=Truth(reference, time="t_s", value="one", scale=3.0)),
        WaterFront(name="front"),
    ]
    case, run = case_and_run(tmp_path, watched, {
        "gauge": ({"y": "m"}, lambda t: (0.5 + 0.012 * np.sin(t),)),
        "tap": ({"pressure": "Pa"}, lambda t: (4040.0,)),
        "energy": ({"kinetic": "J/m", "potential": "J/m", "total": "J/m"}, lambda t: (9.0, 9.0, 3.3)),
        "front": ({"x": "m"}, lambda t: (t,)),
    })
    found = verdict.errors(case, open_run(run))
    assert set(found) == {"gauge", "tap", "energy"}
    wave = 0.01 * np.sin(T[::10])
    expected = {
        "relative_l2": pytest.approx(0.2), "start": 0.0, "end": 2.0,
        "paper": pytest.approx(0.2 * np.linalg.norm(wave) / np.linalg.norm(0.5 + wave)),
        "paper_2017": pytest.approx(0.2 * np.linalg.norm(wave) / wave.sum()), "points": 21,
    }
    assert {name: found["gauge"][name] for name in expected} == expected
    expected = {"relative_l2": pytest.approx(0.01), "paper": pytest.approx(0.01), "points": 21}
    assert {name: found["tap"][name] for name in expected} == expected
    assert found["energy"]["relative_l2"] == pytest.approx(0.1)


@pytest.mark.parametrize("end, file, reason", [(0.0, None, "two samples or more"), (2.0, "gone.csv", "cannot be read")])
def test_what_cannot_be_judged_says_why(tmp_path, reference, end, file, reason):
    about = Truth(file or reference, time="t_s", value="one")
    case, run = case_and_run(tmp_path, [WaterFront(name="front", truth=about)],
                             {"front": ({"x": "m"}, lambda t: (1.0,))}, end)
    found = verdict.errors(case, open_run(run))["front"]
    assert found["relative_l2"] is None and reason in found["reason"]


def test_series_are_smoothed_and_cut_shifts_are_separate_and_peaks_have_bands(tmp_path):
    file = tmp_path / "two.csv"
    lines = [f"{of},{t / 2.0},{(of == 'b') + np.sin(3.0 * t)}\n" for of in ("a", "b") for t in T]
    file.write_text("of,t,p\n" + "".join(lines))
    first, other = (Truth(str(file), time="t", value="p", time_scale=2.0, rows={"of": of}, window=(0.5, 1.5),
                          smooth=0.1, name=of) for of in ("a", "b"))
    bands = (PeakBand(start=0.2, end=1.0, low=0.9, high=1.1), PeakBand(start=1.5, end=2.5, low=0.1, high=1.0),
             PeakBand(start=0.2, end=1.0, low=0.9, high=1.1, smooth=0.1))
    watched = [WaterFront(name="late", truth=first.model_copy(update={"peaks": bands, "others": (other,)}))]
    # 0.02 s late, with a ripple as long as the mean is wide
    of = {"late": ({"x": "m"}, lambda t: (np.sin(3.0 * (t - 0.02)) + 0.3 * np.sin(20.0 * np.pi * t),))}
    case, run = case_and_run(tmp_path, watched, of)
    found = verdict.errors(case, open_run(run))["late"]
    assert (found["start"], found["end"]) == (0.5, 1.5)
    t = T[(T >= 0.5) & (T <= 1.5)]
    assert found["relative_l2"] == pytest.approx(
        np.linalg.norm(np.sin(3.0 * (t - 0.02)) - np.sin(3.0 * t)) / np.linalg.norm(np.sin(3.0 * t)), rel=0.05)
    assert found["best_shift"] == pytest.approx(-0.02, abs=1e-3)
    assert found["shifted_l2"] < 0.1 * found["relative_l2"]
    assert found["others"]["b"]["relative_l2"] > 0.5
    first, last, mean = found["peaks"]
    assert mean["found"] == pytest.approx(1.0, abs=0.02), "without the ripple"
    assert 1.0 < first["found"] < 1.31 and first["high"] == 1.1
    assert first["beyond"] == pytest.approx(max(0.0, first["found"] / 1.1 - 1.0))
    assert last["found"] is None, "the run ends within it"


def test_a_run_shorter_than_the_window_has_no_error(tmp_path, reference):
    about = Truth(reference, time="t_s", value="one", window=(1.0, 3.0), name="long")
    of = {"front": ({"x": "m"}, lambda t: (1.0,))}
    case, run = case_and_run(tmp_path, [WaterFront(name="front", truth=about)], of)
    found = verdict.errors(case, open_run(run))["front"]
    assert found["relative_l2"] is None and "window" in found["reason"]
