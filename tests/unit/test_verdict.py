"""The errors of summary.json: probes of a made-up run against truths whose distance is known."""

import numpy as np
import pytest

from parisph import Energy, Peaks, PressureTap, ProbeArray, Profiles, RunUp, SurfaceGauge, Truth, WaterFront
from parisph.base.errors import CaseError
from parisph.case.profiles import height
from parisph.case.truths import PeakBand, WaveTruth
from parisph.case.waves import Airy
from parisph.truth import verdict
from tests.stored import stored
from tests.watched import scene

T = np.linspace(0.0, 2.0, 201)


@pytest.fixture
def reference(tmp_path):
    path = tmp_path / "reference.csv"
    path.write_text("t_s,eta,one\n" + "".join(f"{t},{0.01 * np.sin(t)},1\n" for t in T[::10]))
    return str(path)


def judged(folder, watched, series, end=2.0):
    """Return the errors of probes in a run with these series, {probe: (columns, function of time)}."""
    case = scene(watched)
    run = stored(folder / "run", case, {f"probes/{name}": columns for name, (columns, _) in series.items()}, [
        (t, step, {f"probes/{name}": of(t) for name, (_, of) in series.items()}) for step, t in enumerate(T[T <= end])])
    return verdict.errors(case, run)


def risen(folder, bands, height):
    """Return the errors of a run-up, a function of time, against bands."""
    watched = [RunUp(name="up", side="right", truth=Peaks(bands, name="others"))]
    return judged(folder, watched, {"up": ({"y": "m", "x": "m"}, lambda t: (height(t), 0.0))})["up"]


def gauged(folder, gauges, truth, heights):
    """Return the errors of an array of gauges, with constant heights, against profiles."""
    watched = [ProbeArray(name="array", probes=gauges, truth=truth)]
    return judged(folder, watched, {"array": ({gauge.name: "m" for gauge in gauges}, lambda t: heights)})["array"]


def test_waves_are_judged_without_the_depth_and_pressures_with_all(tmp_path, reference):
    watched = [
        SurfaceGauge(name="gauge", at=0.0, truth=Truth(reference, time="t_s", value="eta", offset=0.5, wave=True)),
        PressureTap(name="tap", at=(0.0, 0.1), truth=Truth(reference, time="t_s", value="one", scale=4000.0)),
        Energy(name="energy", truth=Truth(reference, time="t_s", value="one", scale=3.0)),
        WaterFront(name="front"),
    ]
    found = judged(tmp_path, watched, {
        "gauge": ({"y": "m"}, lambda t: (0.5 + 0.012 * np.sin(t),)),
        "tap": ({"pressure": "Pa"}, lambda t: (4040.0,)),
        "energy": ({"kinetic": "J/m", "potential": "J/m", "total": "J/m"}, lambda t: (9.0, 9.0, 3.3)),
        "front": ({"x": "m"}, lambda t: (t,)),
    })
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


@pytest.mark.parametrize("end, file, window, reason", [
    (0.0, None, None, "two samples or more"), (2.0, "gone.csv", None, "cannot be read"),
    (2.0, None, (1.0, 3.0), "window")])
def test_what_cannot_be_judged_says_why(tmp_path, reference, end, file, window, reason):
    about = Truth(file or reference, time="t_s", value="one", window=window)
    found = judged(tmp_path, [WaterFront(name="front", truth=about)], {"front": ({"x": "m"}, lambda t: (1.0,))},
                   end)["front"]
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
    found = judged(tmp_path, watched, of)["late"]
    assert (found["start"], found["end"]) == (0.5, 1.5)
    t = T[(T >= 0.5) & (T <= 1.5)]
    assert found["relative_l2"] == pytest.approx(
        np.linalg.norm(np.sin(3.0 * (t - 0.02)) - np.sin(3.0 * t)) / np.linalg.norm(np.sin(3.0 * t)), rel=0.05)
    assert found["best_shift"] == pytest.approx(-0.02, abs=1e-3)
    assert found["shifted_l2"] < 0.1 * found["relative_l2"]
    assert found["shift_sought"] == pytest.approx(0.05), "5 % of the window"
    assert found["others"]["b"]["relative_l2"] > 0.5
    first, last, mean = found["peaks"]
    assert mean["found"] == pytest.approx(1.0, abs=0.02), "without the ripple"
    assert 1.0 < first["found"] < 1.31 and first["high"] == 1.1
    assert first["beyond"] == pytest.approx(max(0.0, first["found"] / 1.1 - 1.0))
    assert last["found"] is None, "the run ends within it"


def test_a_wave_is_compared_within_its_window_only(tmp_path):
    """The gauge is the wave from 1 s on; before, as while a wavemaker starts, it is flat."""
    wave = Airy(height=0.02, period=0.8, depth=0.5)
    of = {"gauge": ({"y": "m"}, lambda t: (0.5 + (1.1 * wave.elevation(0.3, t) if t >= 1.0 else 0.0),))}
    found = {}
    for window in ((1.0, 1.8), None, (1.0, 30.0)):
        about = WaveTruth(wave, level=0.5, window=window)
        folder = tmp_path / str(len(found))
        folder.mkdir()
        found[window] = judged(folder, [SurfaceGauge(name="gauge", at=0.3, truth=about)], of)["gauge"]
    assert found[1.0, 1.8]["relative_l2"] == pytest.approx(0.1, rel=1e-3)
    assert (found[1.0, 1.8]["start"], found[1.0, 1.8]["end"]) == (1.0, 1.8)
    assert found[None]["relative_l2"] > 0.4
    assert found[1.0, 30.0]["relative_l2"] is None and "window" in found[1.0, 30.0]["reason"]


def test_numbers_without_a_series_are_beside_the_greatest_values(tmp_path):
    bands = (PeakBand(start=0.5, end=1.0, when=0.8), PeakBand(start=0.0, end=2.0, low=1.0, high=1.6))
    found = risen(tmp_path, bands, lambda t: t)
    first, second = found["peaks"]
    assert (first["found"], first["time"], first["when"], first["beyond"]) == (1.0, 1.0, 0.8, None)
    assert second["found"] == 2.0 and second["beyond"] == pytest.approx(0.25)
    assert found["relative_l2"] is None and "greatest" in found["reason"]


@pytest.mark.parametrize(("value", "first", "rises"), [
    (lambda t: min(t, 1.99), 1.99, True), (lambda t: 1.95, 0.0, False), (lambda t: min(t, 1.5), 1.5, False)])
def test_a_last_value_may_still_rise_also_if_written_twice_but_not_a_level_one(tmp_path, value, first, rises):
    bands = (PeakBand(start=0.0, end=2.0, low=1.0, high=2.5),)
    peak, = risen(tmp_path, bands, value)["peaks"]
    assert peak["time"] == pytest.approx(first) and peak["last"] is rises


def test_heights_are_beyond_a_band_by_a_share_of_the_height_above_still_water(tmp_path):
    whole = PeakBand(start=0.0, end=2.0, low=0.24, high=0.3, level=0.2)
    bands = whole.model_copy(update={"end": 1.0}), PeakBand(start=0.0, end=2.0, low=0.21, high=0.22), whole
    first, second, third = risen(tmp_path, bands, lambda t: 0.2 + 0.02 * min(t, 2.0 - t))["peaks"]
    assert first["beyond"] == pytest.approx(0.02 / 0.04 - 1.0) and second["beyond"] == 0.0
    assert third["beyond"] == pytest.approx(-0.5) and third["level"] == 0.2
    assert (first["last"], second["last"]) == (True, False), "it rises until 1 s, and falls then"
    with pytest.raises(CaseError, match="level"):
        PeakBand(start=0.0, end=1.0, low=0.24, high=0.3, level=0.24)


def test_profiles_are_compared_at_their_times_where_both_have_a_surface(tmp_path):
    file = tmp_path / "profiles.csv"
    file.write_text("# made\nof,t,x_cm,y_cm\n" + "".join(
        f"{of},{t},{x},{y}\n" for of, t, shape in (("a", 0.5, [(60, 9), (20, 11)]), ("a", 1.5, [(20, 5), (60, 7)]),
                                                   ("a", 9.0, [(20, 5), (60, 7)]), ("b", 0.5, [(20, 50), (60, 70)]))
        for x, y in shape))
    truth = Profiles(str(file), time="t", x="x_cm", value="y_cm", scale=0.01, x_scale=0.01, rows={"of": "a"})
    gauges = [SurfaceGauge(name=f"x{k}", at=0.1 * k) for k in (5, 1, 3, 4)]    # x1 is beyond all profiles
    found = gauged(tmp_path, gauges, truth, (0.1, 9.9, 0.1, np.nan))
    theirs = np.array([0.105, 0.095, 0.055, 0.065])    # at x3 and x5, at 0.5 and at 1.5 s
    assert found["points"] == 4 and (found["start"], found["end"]) == (0.5, 1.5)
    assert found["relative_l2"] == pytest.approx(np.linalg.norm(0.1 - theirs) / np.linalg.norm(theirs))
    assert found["mean"] == pytest.approx(np.mean(0.1 - theirs))
    assert [one["rms"] for one in found["profiles"]] == pytest.approx([0.005, np.sqrt((0.045**2 + 0.035**2) / 2.0)])
    assert "others" not in found


def test_further_profiles_are_judged_even_if_the_run_has_come_to_none_of_the_first(tmp_path):
    for name, time in (("late", 9.0), ("early", 0.5)):
        (tmp_path / f"{name}.csv").write_text(f"t,x,y\n{time},0,0.2\n{time},1,0.2\n")
    late, early, lost = (Profiles(str(tmp_path / f"{name}.csv"), time="t", x="x", value="y", name=name)
                         for name in ("late", "early", "lost"))
    truth = late.model_copy(update={"others": (early, lost)})
    gauges = [SurfaceGauge(name=f"x{k}", at=0.1 * k) for k in (3, 5)]
    found = gauged(tmp_path, gauges, truth, (0.1, 0.1))
    assert found["relative_l2"] is None and "none of the profiles" in found["reason"]
    assert found["others"]["early"]["relative_l2"] == pytest.approx(0.5) and found["others"]["early"]["points"] == 2
    assert "lost.csv" in found["others"]["lost"]["reason"]


def test_of_a_profile_that_overturns_the_upper_surface_counts():
    x, y = np.array([0.0, 2.0, 1.0, 3.0]), np.array([4.0, 3.0, 1.0, 0.0])
    assert [height(x, y, at) for at in (0.5, 1.5, 2.5, 3.5)] == [3.75, 3.25, 0.25, None]
    assert height(np.array([0.0, 1.0, 1.0]), np.array([5.0, 4.0, 1.0]), 1.0) == 4.0
