"""Pictures of series: what shares axes, who is who in a picture of several runs, a probe beside its reference."""

import itertools

import numpy as np
import pytest

from parisph import Case, ColumnHeight, Energy, Fluid, Numerics, PressureTap, SurfaceGauge, VelocityPoint, WaterFront
from parisph.base.errors import CaseError
from parisph.case.motion import Roll
from parisph.case.shapes import Box, Tank
from parisph.pictures import curves, style
from tests.stored import stored

pytest.importorskip("matplotlib")
PROBES = {"P1": ({"pressure": "Pa"}, PressureTap("P1", at=(0.0, 0.1))),
          "P2": ({"pressure": "Pa"}, PressureTap("P2", at=(1.0, 0.1))),
          "gauge": ({"y": "m"}, SurfaceGauge("gauge", at=0.5)), "column": ({"y": "m"}, ColumnHeight("column", at=0.0)),
          "front": ({"x": "m"}, WaterFront("front")),
          "energy": ({"kinetic": "J/m", "potential": "J/m"}, Energy("energy"))}
POINT = {"point": ({"u": "m/s", "v": "m/s", "p": "Pa"}, VelocityPoint("point", at=(0.5, 0.2)))}


def recorded(folder, names=tuple(PROBES), height=0.5, title="Basin"):
    """Return a Run with the series of some probes: .1 s apart, all values rise from 1000."""
    probes = [PROBES[name][1] for name in names]
    case = Case(title=title, fluid=Fluid(Box(1.0, height), density=1000.0), walls=Tank(1.0, 2.0), gravity=(0.0, -9.81),
                numerics=Numerics(spacing=0.1), end_time=1.0, probes=probes)
    series = {f"probes/{name}": PROBES[name][0] for name in names}
    return stored(folder, case, series, [
        (0.1 * step, step, {name: [1000.0 + step] * len(series[name]) for name in series}) for step in range(11)])


def panels(picture):
    """Return {label of the values: [labels of the lines]}."""
    return {axes.get_ylabel(): [line.get_label() for line in axes.lines] for axes in picture.axes}


def test_heights_positions_pressures_and_energies_have_axes_of_their_own(tmp_path):
    assert panels(curves.plot_probe(recorded(tmp_path / "run"))) == {
        "pressure $p$ [Pa]": ["P1", "P2"], "height $y$ [m]": ["column", "gauge"], "front position $x$ [m]": ["front"],
        "energy [J/m]": ["energy: kinetic", "energy: potential"]}


@pytest.mark.parametrize("changes, columns", [
    ({"gravity": ("-x", "-y")}, ["energy: kinetic"]), ({"frame": Roll(0.1, 1.0, (0.5, 0.0))}, ["energy: kinetic"]),
    ({"gravity": ("0", "-9.81")}, ["energy: kinetic", "energy: potential", "energy: total"]),
])
def test_potential_energy_is_drawn_only_where_the_force_has_a_potential(tmp_path, changes, columns):
    about = {"gravity": (0.0, -9.81), "probes": [Energy("energy")], **changes}
    case = Case(title="x", fluid=Fluid(Box(1.0, 0.5), density=1000.0), walls=Tank(1.0, 2.0), end_time=1.0,
                numerics=Numerics(spacing=0.1), **about)
    run = stored(tmp_path / "run", case, {"probes/energy": dict.fromkeys(("kinetic", "potential", "total"), "J/m")},
                 [(0.1 * step, step, {"probes/energy": (1.0, 0.0, 1.0)}) for step in range(3)])
    assert panels(curves.plot_probe(run)) == {"energy [J/m]": columns}


def test_velocity_and_pressure_of_a_point_are_named_each_on_its_own_axes(tmp_path, monkeypatch):
    monkeypatch.setattr(f"{__name__}.PROBES", POINT)
    assert panels(curves.plot_probe(recorded(tmp_path / "run", ("point",)))) == {
        "velocity [m/s]": ["point: u", "point: v"], "pressure $p$ [Pa]": ["point: p"]}


def test_several_runs_of_one_case_lie_over_each_other_by_the_names_of_their_folders(tmp_path):
    runs = [recorded(tmp_path / name) for name in ("coarse", "fine")] + [recorded(tmp_path / "other", ("P1", "front"))]
    found = panels(curves.plot_probe(runs, ["P1", "front"]))
    assert found == {"P1: pressure $p$ [Pa]": ["coarse", "fine", "other"],
                     "front position $x$ [m]": ["coarse", "fine", "other"]}
    found = panels(curves.plot_probe(runs[:2], ["energy", "P1", "P2"]))
    assert found["energy [J/m]"] == ["coarse, kinetic", "coarse, potential", "fine, kinetic", "fine, potential"]
    assert found["pressure $p$ [Pa]"] == ["coarse, P1", "coarse, P2", "fine, P1", "fine, P2"]
    everything = panels(curves.plot_probe(runs))      # what a run does not have is left out of its lines
    assert everything["height $y$ [m]"] == ["coarse, column", "coarse, gauge", "fine, column", "fine, gauge"]
    with pytest.raises(CaseError, match="other has no probe 'P2'"):
        curves.plot_probe(runs, "P2")


def test_folders_of_one_name_are_told_apart(tmp_path):
    names = curves.folder_names([tmp_path / "a" / "run", tmp_path / "b" / "run", tmp_path / "c"])
    assert names == ["a/run", "b/run", "c"]
    assert curves.folder_names([tmp_path / "x", tmp_path / "x"]) == ["x", "x"]      # one run twice: no endless search


def test_each_run_is_normalised_by_its_own_scales(tmp_path):
    runs = [recorded(tmp_path / "low", height=0.5), recorded(tmp_path / "high", height=2.0)]
    axes = curves.plot_probe(runs, "P1", normalise=True).axes[0]
    assert [line.get_label() for line in axes.lines] == ["shape.height 0.5", "shape.height 2"]
    assert curves.run_labels([*runs, runs[0]]) == ["shape.height 0.5 (low)", "shape.height 2", "shape.height 0.5 (low)"]
    for line, height in zip(axes.lines, (0.5, 2.0)):
        time, pressure = line.get_data()
        assert (pressure[0] == pytest.approx(1000.0 / (9810.0 * height))
                and time[-1] == pytest.approx(np.sqrt(9.81 / height)))
    assert axes.get_ylabel() == r"P1: pressure $p$$\,/\,(\rho g H)$"


@pytest.mark.parametrize("count", [2, 6, 7, 9, 12, 36])
def test_lines_are_told_apart(count):
    looks = style.line_looks(count)
    assert len({(look["color"], look["linestyle"]) for look in looks}) == count
    assert len({look["color"] for look in looks}) == min(count, len(style.LINES))
    if count <= style.FEW:
        assert {look["linestyle"] for look in looks} == {"-"}
    else:    # each differs from those before and after it in both
        assert all(a["color"] != b["color"] and a["linestyle"] != b["linestyle"] for a, b in itertools.pairwise(looks))


def test_of_several_runs_the_colour_says_which_and_the_kind_of_line_what(tmp_path):
    looks = style.line_looks(4, 3)
    assert [look["color"] for look in looks] == [style.LINES[run] for run in range(4) for _ in range(3)]
    assert ([look["linestyle"] for look in looks[:3]] == [look["linestyle"] for look in looks[9:]]
            == list(style.STYLES[:3]))
    runs = [recorded(tmp_path / name) for name in "abcdefgh"]
    lines = curves.plot_probe(runs, "P1").axes[0].lines
    assert len({(line.get_color(), line.get_linestyle()) for line in lines}) == 8


def test_a_short_legend_is_above_the_curves(tmp_path):
    picture = curves.plot_probe(recorded(tmp_path / "run", ("gauge", "column")))
    picture.draw_without_rendering()
    axes, = picture.axes[:1]
    top = max(axes.transData.transform(np.transpose(line.get_data()))[:, 1].max() for line in axes.lines)
    assert axes.get_legend().get_window_extent().y0 > top


def test_a_long_legend_is_as_high_as_its_panel(tmp_path):
    runs = [recorded(tmp_path / f"spacing_{number}", ("energy", "P1")) for number in range(14)]
    picture = curves.plot_probe(runs)
    picture.draw_without_rendering()
    boxes, legends = ([part.get_window_extent().transformed(picture.dpi_scale_trans.inverted()) for part in parts]
                      for parts in (picture.axes, [axes.get_legend() for axes in picture.axes]))
    assert [len(axes.lines) for axes in picture.axes] == [14, 28]
    for box, legend in zip(boxes, legends):
        assert legend.height < 1.1 * box.height
        assert 5.0 < box.width < 7.5 and legend.x1 < picture.get_figwidth() + 0.05
    assert 0.0 < boxes[0].y0 - boxes[1].y1 < 0.5    # no blank between the panels


def test_of_very_many_lines_the_first_and_the_last_are_named(tmp_path):
    picture = curves.plot_probe(tuple(recorded(tmp_path / f"run_{number}", ("energy",)) for number in range(25)))
    axes, = picture.axes
    assert axes.get_legend() is None and picture.get_figwidth() == 8.0
    assert axes.get_title(loc="right") == "50 lines, from run_0, kinetic to run_24, potential"


# Linear RGB as those see it who lack one kind of cone (Machado, Oliveira & Fernandes 2009, severity 1).
SIGHT = {
    "all": np.eye(3),
    "protan": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
    "deutan": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]],
    "tritan": [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]],
}


@pytest.mark.parametrize("sight", SIGHT)
def test_colours_differ_for_those_who_do_not_tell_all_hues(sight):
    lab = [_lab(np.clip(np.array(SIGHT[sight]) @ _linear(colour), 0.0, 1.0)) for colour in style.LINES]
    assert min(np.linalg.norm(a - b) for a, b in itertools.combinations(lab, 2)) > 14.0    # 2.3 is just seen


def _linear(colour):
    part = np.array([int(colour[k:k + 2], 16) for k in (1, 3, 5)]) / 255
    return np.where(part <= 0.04045, part / 12.92, ((part + 0.055) / 1.055) ** 2.4)


def _lab(linear):
    """CIE L*a*b* of linear sRGB."""
    xyz = (np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]) @ linear
           / [0.9505, 1.0, 1.089])
    f = np.where(xyz > 0.008856, np.cbrt(xyz), 7.787 * xyz + 16 / 116)
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


def test_a_comparison_shows_both_and_their_difference():
    t, s = np.linspace(0.0, 1.0, 101), np.linspace(0.2, 1.4, 13)
    both = s[s <= 1.0]
    upper, lower = curves.plot_comparison((t, 5e3 * t), (s, 4e3 * s), (both, 1e3 * both), "title",
                                          "pressure", "Pa").axes
    assert [line.get_label() for line in upper.lines] == ["run", "reference"] and upper.get_ylabel() == "pressure [kPa]"
    assert upper.lines[1].get_marker() == "o"     # few samples
    np.testing.assert_allclose(lower.lines[1].get_ydata(), both)
    assert lower.get_ylabel() == "run - reference [kPa]" and upper.get_xlim() == (0.2, 1.0)
