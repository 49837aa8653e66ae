"""The errors of summary.json: probes of a made-up run against truths whose distance is known."""

import json

import numpy as np
import pytest
from mpi4py import MPI

from parisph.case.schema import Energy, PressureTap, SurfaceGauge, Truth, WaterFront
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
    assert found["gauge"] == {
        "relative_l2": pytest.approx(0.2),
        "paper": pytest.approx(0.2 * np.linalg.norm(wave) / np.linalg.norm(0.5 + wave)),
        "paper_2017": pytest.approx(0.2 * np.linalg.norm(wave) / wave.sum()), "points": 21,
    }
    assert found["tap"] == {"relative_l2": pytest.approx(0.01), "paper": pytest.approx(0.01), "points": 21}
    assert found["energy"]["relative_l2"] == pytest.approx(0.1)


@pytest.mark.parametrize("end, file, reason", [(0.0, None, "two samples or more"), (2.0, "gone.csv", "cannot be read")])
def test_what_cannot_be_judged_says_why(tmp_path, reference, end, file, reason):
    about = Truth(file or reference, time="t_s", value="one")
    case, run = case_and_run(tmp_path, [WaterFront(name="front", truth=about)],
                             {"front": ({"x": "m"}, lambda t: (1.0,))}, end)
    found = verdict.errors(case, open_run(run))["front"]
    assert found["relative_l2"] is None and reason in found["reason"]

