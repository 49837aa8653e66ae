"""A run in 3D tells of its probes in units of 3D, and follows its volume."""

import numpy as np
import pytest

from parisph import Box, Case, Fluid, Flux, Force, Numerics, ProbeArray, SurfaceGauge, Tank, open_run
from parisph.io import info
from parisph.pictures.curves import plot_probe
from tests.scenes import run_alone


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("made") / "run"
    case = Case(title="column", fluid=Fluid(Box(0.5, 0.6), 1000.0), walls=Tank(1.0, 1.0, breadth=0.6),
                gravity=(0.0, -9.81), numerics=Numerics(spacing=0.1), end_time=0.15, probes=[
                    Force("load", side="bed"), ProbeArray("rows", [Force("back", side="back")]),
                    Flux("through", start=(0.57, 0.0), end=(0.57, 1.0), pause=0.1),
                    SurfaceGauge("gauge", at=(0.0, 0.3))])
    return run_alone(case, folder), open_run(folder)


def test_units_and_columns_are_those_of_3d(made):
    summary, run = made
    assert run.units("load") == {"time": "s", "step": "", "fx": "N", "fy": "N", "fz": "N", "mx": "N m", "my": "N m",
                                 "mz": "N m"}
    assert list(run.units("gauge"))[2:] == ["z"] and run.units("through")["total"] == "m^3"
    assert summary["peaks"]["load.fz"]["unit"] == "N" and "rows.back.fy" in summary["peaks"]
    assert summary["passed"]["through"]["unit"] == "m3"
    assert summary["passed"]["through"]["total"] == run.probe("through")["total"][-1] > 0.0
    assert "m3 of water in 1 event, the largest" in info.describe(run)


def test_the_volume_is_followed_without_a_probe_of_it(made):
    summary, run = made
    assert summary["volume_unknown"] is None and abs(summary["volume_drift"]) < 0.01
    assert np.isfinite(run.probe("load")["fz"]).all()


def test_axes_of_pictures_name_the_height_z(made, tmp_path):
    axes = plot_probe(made[1], ["gauge"], tmp_path / "gauge.png").axes[0]
    assert axes.get_ylabel() == "surface height $z$ [m]"
