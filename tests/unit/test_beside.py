"""A probe beside its references: what the axes hold, and how references and bands are drawn."""

import numpy as np
import pytest
from matplotlib.collections import PolyCollection

from parisph import PeakBand, Peaks, RunUp, SurfaceGauge, Truth
from parisph.pictures.beside import plot_beside
from tests.stored import stored
from tests.watched import scene

pytest.importorskip("matplotlib")


def axes_of(folder, probe, of=lambda t: 0.25 + 0.01 * t):
    """Return the axes of a picture of a probe with given heights at 0, 0.1, ... 1 s."""
    name = f"probes/{probe.name}"
    samples = [(0.1 * step, step, {name: (of(0.1 * step),)}) for step in range(11)]
    return plot_beside(stored(folder, scene([probe]), {name: {"y": "m"}}, samples), probe).axes[0]


def test_the_axes_hold_the_bands_which_are_drawn_once(tmp_path):
    bands = tuple(PeakBand(start=0.0, end=0.9, low=0.4, high=0.5, smooth=smooth) for smooth in (None, 0.1))
    later = PeakBand(start=5.0, end=6.0, low=2.0, high=3.0)
    axes = axes_of(tmp_path / "run", RunUp("up", side="right", truth=Peaks((*bands, later), name="others")))
    low, high = axes.get_ylim()
    assert low < 0.25 and 0.5 < high < 0.6, "a band after the end of the run counts no more"
    boxes = [box.get_paths()[0].vertices for box in axes.collections if isinstance(box, PolyCollection)]
    assert sum(np.ptp(box[:, 1]) == pytest.approx(0.1) for box in boxes) == 1


def test_a_constant_of_two_distant_points_is_a_line_over_the_run(tmp_path):
    (tmp_path / "one.csv").write_text("t,one\n0,1\n1e9,1\n")
    truth = Truth(str(tmp_path / "one.csv"), time="t", value="one", scale=0.3)
    axes = axes_of(tmp_path / "run", SurfaceGauge("gauge", at=0.5, truth=truth))
    line = next(line for line in axes.lines if line.get_label() == "reference")
    assert line.get_xdata().tolist() == [0.0, 1.0] and line.get_ydata().tolist() == [0.3, 0.3]
    assert line.get_linestyle() == "--" and line.get_marker() in ("", "None")


def test_names_stand_below_the_axes_and_the_time_has_its_height(tmp_path):
    (tmp_path / "one.csv").write_text("t,one\n0,1\n1e9,1\n")
    truth = Truth(str(tmp_path / "one.csv"), time="t", value="one", scale=0.3, name="a rather long name of a reference")
    axes = axes_of(tmp_path / "run", SurfaceGauge("gauge", at=0.5, truth=truth))
    picture = axes.figure
    picture.draw_without_rendering()
    legend, = picture.legends
    assert axes.get_legend() is None and legend.get_window_extent().y1 <= axes.get_tightbbox().y0
    assert [text.get_text() for text in legend.get_texts()] == ["run", "a rather long name of a reference"]
    height = scene([]).fluids[0].shape.height
    assert any(f"$H$ = {height:.4g} m, the height of the fluid at the start" in child.get_xlabel()
               for child in axes.child_axes)
