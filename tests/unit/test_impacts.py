"""Peaks of pressure that are too short to be resolved are told from those that last."""

import json
from types import SimpleNamespace

import numpy as np
import pytest
from mpi4py import MPI

from parisph import Box, Case, Fluid, Force, Numerics, PeakBand, Peaks, PressureTap, ProbeArray, Tank
from parisph.io import info
from parisph.io.reader import open_run
from parisph.io.store import Store
from parisph.pictures import curves, style
from parisph.report import events
from parisph.truth import impacts, verdict
from parisph.truth.recorded import probe_records

T = 0.002 * np.arange(500)


def impact(start, greatest, decay=0.05):
    """Return an impact: a rise over six values, and a slow fall."""
    return greatest * np.interp(T, [start, start + 0.012], [0.0, 1.0]) * np.exp(-np.maximum(T - start, 0.0) / decay)


def spike(time, greatest, values=1):
    """Return a peak of one value, on lines that are so many samples long to either side."""
    return greatest * np.maximum(1.0 - np.abs(T - time) / (0.002 * values), 0.0)


RIPPLE = 7e3 + 300.0 * np.sin(1e3 * T)


@pytest.mark.parametrize("values", [1, 2, 5])
def test_a_peak_of_one_value_is_short_however_finely_it_is_sampled(values):
    others = np.interp(T, T[::values], (RIPPLE * (T > 0.3) + impact(0.3, 9e3))[::values])
    (first, lasting) = impacts.greatest(T, others + spike(0.8, 25e3, values))
    assert first.short and first.time == pytest.approx(0.8) and first.value == pytest.approx(32e3, rel=0.02)
    assert first.lasts == pytest.approx(0.002 * values, rel=0.1) and first.mean < 0.95 * first.value
    assert not lasting.short and lasting.time == pytest.approx(0.312, abs=0.01) and lasting.lasts > 0.005


def test_an_impact_a_crest_and_a_ripple_are_not_short():
    """Nor is the head of an impact, behind which the pressure stays high."""
    head = impact(0.3, 14e3, decay=0.5) + spike(0.314, 6e3)
    for values in (impact(0.3, 20e3), head, 5e3 + 2e3 * np.sin(6.0 * T), RIPPLE, np.zeros_like(T), -RIPPLE):
        (one,) = impacts.greatest(T, values)
        assert not one.short


def test_samples_without_a_number_and_others_than_those_allowed_do_not_count():
    values = RIPPLE + spike(0.8, 25e3)
    assert not impacts.greatest(T, values, T < 0.7)[0].short
    values[values > 2e4] = np.nan
    assert not impacts.greatest(T, values)[0].short
    assert impacts.greatest(T, RIPPLE + spike(0.8, 25e3))[0].short
    assert not impacts.greatest(T, RIPPLE + spike(0.8, 25e3), seldom=True)[0].short
    assert impacts.greatest(T, np.full_like(T, np.nan)) == [] and impacts.greatest(T[:2], values[:2]) == []


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A run with a spike at two taps, and at a force that pulls."""
    band = Peaks([PeakBand(start=0.5, end=0.9, low=6e3, high=1e4)])
    probes = [PressureTap("P", at=(0.0, 0.1), truth=band, peak=True),
              ProbeArray("row", [PressureTap("Q", at=(1.0, 0.1))]), Force("load", peak=True), Force("dry"),
              ProbeArray("pair", [Force("side")])]
    case = Case(title="Basin", fluid=Fluid(Box(1.0, 0.5), density=1000.0), walls=Tank(1.0, 2.0), gravity=(0.0, -9.81),
                numerics=Numerics(spacing=0.1), end_time=1.0, probes=probes)
    folder = tmp_path_factory.mktemp("impacts") / "run"
    store = Store.create(MPI.COMM_SELF, folder, case.model_dump_json())
    parts = {"fx": "N/m", "fy": "N/m", "moment": "N m/m"}
    units = {"P": {"pressure": "Pa"}, "row": {"Q": "Pa"}, **dict.fromkeys(("load", "dry"), parts),
             "pair": {f"side_{name}": unit for name, unit in parts.items()}}
    for name, columns in units.items():
        store.add_series(f"probes/{name}", columns)
    for step, (t, value) in enumerate(zip(T, RIPPLE + spike(0.8, 25e3))):
        store.append(t, step, {"probes/P": [value], "probes/row": [value], "probes/load": [-value, 7e3, 0.0],
                               "probes/dry": [0.0, 0.0, 0.0], "probes/pair": [-value, 7e3, 0.0]})
    summary = {"peaks": impacts.peaks(case, open_run(folder)), "greatest": impacts.asked(case, open_run(folder)),
               "errors": verdict.errors(case, open_run(folder))}
    store.summary(summary)
    store.close()
    return case, open_run(folder)


def test_the_table_the_report_and_the_picture_say_so(run):
    case, found = run
    summary = json.loads(json.dumps(found.summary))
    assert {name: peak["short"] for name, peak in summary["peaks"].items()} == {
        "P": True, "row.Q": True, "load.fx": True, "load.fy": False, "pair.side.fx": True, "pair.side.fy": False}
    lines = [line for line in info.table(summary) if line.startswith("peak of")]
    assert len(lines) == 5 and "Pa at 0.8 s lasts only 2" in lines[0] and "the greatest that lasts: 7" in lines[0]
    assert lines[0].count(" Pa") == 3 and lines[2].count(" N/m") == 3
    assert " N/m at " in lines[2] and lines[4].startswith("peak of load") and lines[4].count(" at ") == 1
    assert [row[0].text for row in events.impacts(summary).rows][:2] == [f"{name} (short: not resolved)"
                                                                         for name in ("P", "row.Q")]
    assert "(short: not resolved; " in events.peaks(case.probes, summary).rows[0][4].text
    pytest.importorskip("matplotlib")
    axes = curves.plot_probe(found, ["P"]).axes[0]
    labels = [line.get_label() for line in axes.lines]
    for name in ("load", "pair"):    # alone, and in an array
        picture = curves.plot_probe(found, [name])
        line, cross, bar = picture.axes[0].lines[:3]
        assert [axes.get_ylabel() for axes in picture.axes if axes.lines][1].endswith("moment [N m/m]")
        assert cross.get_ydata()[0] == line.get_ydata().min() < bar.get_ydata()[0] < 0.0, "where the force pulls"
        assert cross.get_color() == bar.get_color() == line.get_color()
    assert labels[0] == "P" and "not resolved" in labels[1] and labels[2] == "its mean over 5 ms"


def test_samples_further_apart_than_a_few_steps_do_not_judge_how_long_a_peak_lasts():
    table = np.zeros(9, [("time", float), ("step", int)])
    for apart, each, coarse in ((0.001, 1, False), (0.001, 3, False), (0.001, 4, True), (0.006, 1, True)):
        table["time"], table["step"] = apart * np.arange(9), each * np.arange(9)
        assert impacts.coarse(table) is coarse
    probe = PressureTap("P", at=(0.0, 0.1), truth=Peaks([PeakBand(start=0.5, end=0.9, low=6e3, high=1e4)]))
    every = np.rec.fromarrays([T, np.arange(len(T)), RIPPLE + spike(0.8, 25e3)], names=["time", "step", "pressure"])
    for step, short in ((1, True), (4, False)):
        every["step"] = step * np.arange(len(T))
        found = verdict.errors(SimpleNamespace(probes=[probe]), SimpleNamespace(probe=lambda name: every))
        assert found["P"]["peaks"][0]["short"] is short


def test_probes_of_an_array_have_the_columns_of_their_names():
    """Also where the name of one begins with that of another."""
    inside = [PressureTap("P", at=(0.0, 0.1)), PressureTap("P_1", at=(0.0, 0.2)), Force("F")]
    names = ["time", "step", "P", "P_1", "F_fx", "F_fy", "F_moment"]
    run = SimpleNamespace(probe=lambda name: np.zeros(1, [(name, float) for name in names]))
    found = list(probe_records(SimpleNamespace(probes=[ProbeArray("row", inside)]), run, lambda probe: True))
    assert [(record.name, record.columns) for record in found] == [
        ("row.P", ["P"]), ("row.P_1", ["P_1"]), ("row.F", names[4:])]
    assert len(found[0].values("pressure")) == len(found[2].values("fy")) == 1


def test_figures_show_themselves_and_their_units_in_notebooks():
    pytest.importorskip("matplotlib")
    picture = style.new_figure(figsize=(1.0, 1.0))
    assert picture._repr_png_().startswith(b"\x89PNG") and type(picture) is type(style.new_figure())
    assert (style.written("m^2/s"), style.written("m^2"), style.written("Pa")) == ("m²/s", "m²", "Pa")
