"""Incident and reflected waves from gauges, for waves that are known."""

from pathlib import Path

import numpy as np
import pytest

from parisph import Case, CaseError, Fluid, Numerics, Polygon, ProbeArray, Profile, Sponge, SurfaceGauge, Tank
from parisph.case.bodies import Obstacle, Piston, StillWater
from parisph.case.waves import Airy, Jonswap
from parisph.case.waves.jonswap import components_of
from parisph.io import info
from parisph.report import events
from parisph.truth import reflected
from parisph.truth.reflection import separated, spectra

K, PERIOD = 3.0, 1.3
TIMES = np.linspace(2.0, 2.0 + 3.0 * PERIOD, 200)


def elevations(places, incident, reflected, phase=0.7):
    """Return both waves with a second harmonic, a level and a trend."""
    omega, x, t = 2.0 * np.pi / PERIOD, np.asarray(places)[:, None], TIMES
    eta = incident * np.cos(K * x - omega * t) + reflected * np.cos(K * x + omega * t + phase)
    return eta + 0.1 * incident * np.cos(2.0 * (K * x - omega * t)) + 0.4 + 0.01 * t


@pytest.mark.parametrize("places", [(0.0, 0.5), (1.0, 1.3, 1.7), (0.2, 0.3, 0.9, 2.5)])
@pytest.mark.parametrize("share", [0.0, 0.05, 1.0, 3.0])
def test_both_waves_are_found_to_rounding(places, share):
    found = separated(TIMES, elevations(places, 0.02, share * 0.02), places, PERIOD, K)
    assert found.incident == pytest.approx(0.02, abs=1e-13)
    assert found.reflected == pytest.approx(share * 0.02, abs=1e-13)
    assert found.reflection == pytest.approx(share, abs=1e-11) and found.residual < 1e-11


def test_a_wave_of_another_length_is_a_residual():
    places = (0.0, 0.4, 0.9)
    assert separated(TIMES, elevations(places, 0.02, 0.0), places, PERIOD, 1.2 * K).residual > 0.05


@pytest.mark.parametrize("places", [(0.0, np.pi / K), (0.3, 0.3), (0.3,)])
def test_gauges_that_cannot_tell_them_apart(places):
    with pytest.raises(ValueError, match="cannot tell the waves apart"):
        separated(TIMES, elevations(places, 0.02, 0.01), places, PERIOD, K)


def test_too_short_a_time_or_another_shape():
    with pytest.raises(ValueError, match="less than a period"):
        separated(TIMES[:40], elevations((0.0, 0.5), 0.02, 0.0)[:, :40], (0.0, 0.5), PERIOD, K)
    with pytest.raises(ValueError, match="not one row for each"):
        separated(TIMES, elevations((0.0, 0.5), 0.02, 0.0).T, (0.0, 0.5), PERIOD, K)


# -- irregular waves, and the gauges of a run ---------------------------------------------------------

DEPTH = 0.5


def sea(places, share, noise=0.0, seed=1):
    """Return times and elevations of irregular waves that a wall reflects by a share, and their wave's case."""
    wave = Jonswap(height=0.05, period=1.5, depth=DEPTH, seed=seed)
    amplitude, omega, k, phase = components_of(wave)
    rng, t = np.random.default_rng(seed), np.arange(0.0, 120.0, 0.06)
    back, x = 2.0 * np.pi * rng.random(len(k)), np.asarray(places)[:, None, None]
    eta = amplitude * np.cos(k * x - omega * t[:, None] + phase)
    eta = eta + share * amplitude * np.cos(k * x + omega * t[:, None] + back)
    return t, eta.sum(axis=-1) + DEPTH + noise * rng.standard_normal((len(places), len(t)))


@pytest.mark.parametrize("share, places", [(0.0, (2.0, 2.3, 2.75)), (0.3, (2.0, 2.3, 2.75)), (0.3, (2.0, 2.4))])
def test_irregular_waves_are_told_apart_by_frequency(share, places):
    t, eta = sea(places, share, noise=5e-4)
    found = spectra(t, eta, places, DEPTH)
    assert found.heights[1] / found.heights[0] == pytest.approx(share, abs=0.03) and found.residual < 0.05
    assert found.heights[0] == pytest.approx(0.05, rel=0.15)
    peak = found.frequencies[np.argmax(found.incident)]
    assert peak == pytest.approx(1.0 / 1.5, rel=0.15)


def test_a_record_of_a_few_waves_has_no_spectrum():
    t, eta = sea((2.0, 2.3), 0.1)
    with pytest.raises(ValueError, match="the records last 12 s, .* periods of the peak: 16 are the least"):
        spectra(t[:201], eta[:, :201], (2.0, 2.3), DEPTH)


class Flume:
    """A run whose gauges have recorded waves: towards +x of height .06 m, and a fifth of that towards -x."""

    folder = Path("flume")

    def __init__(self, wave, **more):
        gauges = [SurfaceGauge(f"g{x}", at=x) for x in (1.0, 3.0, 3.4, 3.9, 7.9)]
        inner = ProbeArray("row", [SurfaceGauge("a", at=3.0), SurfaceGauge("b", at=3.4)])
        self.case = Case(title="flume", fluid=Fluid(StillWater(level=DEPTH), density=1000.0),
                         walls=(Tank(width=12.0, height=0.8, at=(-0.5, 0.0)), Piston(at=0.0, wave=wave)),
                         gravity=(0.0, -9.81), absorb=Sponge(start=8.0, length=3.5), probes=[*gauges, inner],
                         numerics=Numerics(spacing=0.05, preset="gentle"), end_time=60.0).changed(**more)
        self.wave, self.at = wave, {f"g{gauge.at}": gauge.at for gauge in gauges} | {"a": 3.0, "b": 3.4}
        self.probe_names = [*list(self.at)[:5], "row"]

    def probe(self, name):
        if isinstance(self.wave, Jonswap):
            t, eta = sea([self.at[name]], 0.2)
            return np.rec.fromarrays([t, eta[0]], names="time,y")
        t, k, omega = np.arange(0.0, 40.0, 0.05), self.wave.k, 2.0 * np.pi / self.wave.period

        def waves(x):
            return DEPTH + 0.03 * np.cos(k * x - omega * t) + 0.006 * np.cos(k * x + omega * t + 1.0)
        columns = {"a": waves(3.0), "b": waves(3.4)} if name == "row" else {"y": waves(self.at[name])}
        return np.rec.fromarrays([t, *columns.values()], names=["time", *columns])


def test_a_flume_chooses_gauges_and_a_time():
    wave = Airy(height=0.06, period=1.6, depth=DEPTH)
    flume = Flume(wave)
    found = reflected.of_case(flume.case, flume)
    assert found["probes"] == ["g3.0", "g3.4", "g3.9"] and found["regular"] and found["bands"] is None
    assert found["incident"] == pytest.approx(0.06, rel=1e-3) and found["coefficient"] == pytest.approx(0.2, abs=1e-3)
    assert found["end"] - found["start"] == pytest.approx(16.0, abs=0.06) and found["residual"] < 1e-3
    assert "reflection coefficient        0.2\n" in reflected.text(found)
    flat = {**found, "incident": 0.0, "coefficient": None}    # the waves have not come so far
    assert "no incident waves" in reflected.text(flat) and "no waves at" in "".join(info.table({"reflection": flat}))
    assert reflected.analysed(flume.case, flume, ["row.a", "row.b"])["coefficient"] == pytest.approx(0.2, abs=1e-3)
    head, row = next(events.reflection({"reflection": found}))[0].head, info.table({"reflection": found})
    assert "reflection coefficient" in head and row == ["reflection      0.2 of the incident height, 0.06 m, at g3.0, "
                                                        f"g3.4, g3.9 (residual {found['residual']:.2g})"]


def test_irregular_waves_of_a_flume_have_bands():
    flume = Flume(Jonswap(height=0.05, period=1.5, depth=DEPTH, seed=1))
    found = reflected.of_case(flume.case, flume)
    assert not found["regular"] and found["coefficient"] == pytest.approx(0.2, abs=0.03)
    assert len(found["bands"]) == 12 and any(band["coefficient"] is not None for band in found["bands"])
    assert "frequency [Hz]" in reflected.text(found)
    assert len(list(events.reflection({"reflection": found}))) == 2


def test_gauges_and_times_that_do_not_do_are_refused_with_a_remedy():
    flume = Flume(Airy(height=0.06, period=1.6, depth=DEPTH))
    for words, why in ((["g1.0", "no"], "there is no SurfaceGauge 'no'"), (["g3.0"], "give others with --probes"),):
        with pytest.raises(CaseError, match=why):
            reflected.analysed(flume.case, flume, words)
    for more, why in (({"period": 0.0}, "--period 0: must be greater"), ({"end": 4.0}, "run longer, or give --from"),
                      ({"depth": -1.0}, "--depth -1: must be greater"), ({"start": 50.0}, "end must be after")):
        with pytest.raises(CaseError, match=why):
            reflected.analysed(flume.case, flume, **more)
    far = Flume(flume.wave, probes=[SurfaceGauge("g1.0", at=1.0), SurfaceGauge("g7.9", at=7.9)])
    assert "no two gauges are within 0.75 of the wave length" in reflected.of_case(far.case, far)["reason"]
    assert reflected.of_case(Flume(flume.wave, probes=[]).case, flume) is None
    still = flume.case.changed(walls=Tank(width=12.0, height=0.8), absorb=())
    with pytest.raises(CaseError, match="no wavemaker with a period: give the period .* with --period, or"):
        reflected.analysed(still, flume)
    assert reflected.analysed(still, flume, period=1.6)["coefficient"] == pytest.approx(0.2, abs=1e-3)
    dry, whole = flume.probe("g3.4"), flume.probe
    dry["y"][5] = np.nan
    flume.probe = lambda name: dry if name == "g3.4" else whole(name)
    with pytest.raises(CaseError, match="the gauge g3.4 has no value at some times"):
        reflected.analysed(flume.case, flume, ["g3.0", "g3.4"])


def test_gauges_over_a_bar_are_not_chosen():
    """There the waves are others than the wavemaker's."""
    wave = Airy(height=0.06, period=1.6, depth=DEPTH)
    case = Flume(wave).case
    bar = Obstacle(Polygon([(2.8, 0.0), (3.2, 0.2), (3.6, 0.2), (3.7, 0.0)]), name="bar")    # behind it are others
    flume = Flume(wave, walls=(*case.walls, bar), probes=[*case.probes[:4], SurfaceGauge("g1.4", at=1.4)])
    flume.at["g1.4"] = 1.4
    flume.probe_names.append("g1.4")
    assert reflected.of_case(flume.case, flume)["probes"] == ["g1.0", "g1.4"]
    step = Profile([(-0.5, 0.8), (-0.5, 0.0), (2.8, 0.0), (3.2, 0.2), (11.5, 0.2), (11.5, 0.8)], breadth=0.4)
    gauges = [gauge.model_copy(update={"y": 0.2}) for gauge in (*case.probes[:4], SurfaceGauge("g1.4", at=1.4))]
    solid = Flume(wave, gravity=(0.0, 0.0, -9.81), walls=(step, case.walls[1]), probes=gauges)
    solid.at["g1.4"] = 1.4
    solid.probe_names.append("g1.4")
    assert reflected.of_case(solid.case, solid)["probes"] == ["g1.0", "g1.4"]    # in 3D the same
    bare = Flume(wave, walls=(*case.walls, bar))
    assert reflected.of_case(bare.case, bare) is None
