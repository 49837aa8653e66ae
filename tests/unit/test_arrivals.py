"""When a probe first passes a value."""

import numpy as np
import pytest

from parisph import Case, ProbeArray, SurfaceGauge, WaterFront
from parisph.io import info, reader
from parisph.truth.arrivals import first_passing
from tests.scenes import run_alone, scene

TIME = np.array([0.0, 1.0, 2.0, 4.0])


@pytest.mark.parametrize("values, level, time", [
    ((0.0, 1.0, 2.0, 3.0), 1.5, 1.5), ((0.0, 1.0, 2.0, 3.0), 2.5, 3.0), ((3.0, 2.0, 0.0, 5.0), 1.0, 1.5),
    ((0.0, 1.0, 2.0, 3.0), 2.0, 2.0), ((0.0, 1.0, 2.0, 3.0), 0.0, 0.0), ((0.0, 1.0, 2.0, 3.0), 3.1, None),
    ((0.0, np.nan, 2.0, 0.0), 1.0, 1.0), ((np.nan,) * 4, 1.0, None), ((0.0, 2.0, -1.0, 2.0), 1.0, 0.5),
])
def test_it_lies_on_the_line_between_samples(values, level, time):
    found = first_passing(TIME, np.array(values), level)
    assert found == (None if time is None else pytest.approx(time, abs=1e-14))


def test_the_summary_tells_when_the_front_comes(tmp_path):
    case: Case = scene("dam_break", spacing=0.1).changed(end_time=0.35, probes=[
        WaterFront("front", arrival=1.3), WaterFront("far", arrival=1.99),
        ProbeArray("gauges", [SurfaceGauge("a", at=0.2, arrival=0.9), SurfaceGauge("b", at=1.5)])])
    summary = run_alone(case, tmp_path / "run")
    front = reader.open_run(tmp_path / "run").probe("front")
    found = summary["arrivals"]
    assert list(found) == ["front", "far", "gauges.a"] and found["far"] is None
    assert np.interp(found["front"], front["time"], front["x"]) == pytest.approx(1.3, abs=1e-9)
    assert 0.0 < found["gauges.a"] < 0.35
    text = "\n".join(info.table(summary))
    assert f"arrival at front {found['front']:.6g} s" in text and "arrival at far  not in this run" in text
