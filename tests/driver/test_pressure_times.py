"""Samples of pressures on walls have the times that their pressures are of.

In a tank whose gravity grows evenly, still water has p = rho g(t) depth at every instant. A step finds that of its
middle, to the last digits of the solve.
"""

import numpy as np
import pytest

from parisph import Box, Case, Fluid, Force, Numerics, Output, PressureTap, ProbeArray, SurfaceGauge, Tank
from parisph.io import reader
from tests.scenes import on_two_and_then, ran, restart_alone

SPACING, DEPTH, START, RATE = 0.1, 1.0, 5.0, 40.0     # m, m, m/s^2, m/s^3
TAP = PressureTap("tap", at=(0.0, 0.2))
LOAD = Force("load", side="bed")


def still(end=0.2, output=None, **numerics):
    return Case(title="still", walls=(Tank(1.0, 2.0),), fluid=Fluid(Box(1.0, DEPTH), density=1000.0), end_time=end,
                gravity=("0", f"-({START} + {RATE}*t)"), output=output or Output(),
                probes=[TAP, LOAD, ProbeArray("mixed", [SurfaceGauge("y", at=0.5), TAP])],
                numerics=Numerics(spacing=SPACING, **({"rtol": 1e-12} | numerics)))


def check(tap, load, tolerance=1e-6):
    expected = 1000.0 * (START + RATE * tap["time"])
    np.testing.assert_allclose(tap["pressure"], expected * (DEPTH - 0.2), rtol=tolerance)
    np.testing.assert_allclose(load["fy"], -expected * DEPTH, rtol=tolerance)


@pytest.mark.parametrize("numerics", [{"time_step": 0.01, "preset": "gentle"}, {"preset": "violent"}])
def test_a_pressure_that_grows_evenly_is_exact(tmp_path, numerics):
    found = ran(still(**numerics), tmp_path / "run")
    tap, steps = found.probe("tap"), found.steps
    check(tap[:-1], found.probe("load")[:-1])
    assert tap["time"][0] == 0.0 and len(tap) == len(steps) + 2
    assert tap[-1].tolist() == (steps["time"][-1], *tap[-2].tolist()[1:])     # up to the end there is no other
    behind = (steps["time"] - tap["time"][1:-1]) / steps["dt"]
    np.testing.assert_allclose(behind, 0.5)
    assert (found.probe("mixed")["time"][1:] == steps["time"]).all()    # places are of the end of the step
    assert "time is that of the pressure" in (found.folder / "probes" / "tap.csv").read_text().splitlines()[0]


def test_at_a_fixed_rate_too_up_to_the_last_pressure(tmp_path):
    found = ran(still(preset="violent", time_step=0.01, output=Output(probe_interval=0.0007)), tmp_path / "run")
    tap, load = found.probe("tap"), found.probe("load")
    np.testing.assert_array_equal(tap["time"], np.arange(len(tap)) * 0.0007)
    known = tap["time"] < found.steps["time"][-1] - 0.005
    check(tap[known], load[known])
    assert (np.diff(tap["pressure"]) >= 0.0).all() and np.count_nonzero(~known) >= 7
    assert tap["pressure"][-1] == tap["pressure"][-2]       # the last pressure that there is


def test_weakly_compressible_pressures_are_of_the_end_of_the_step(tmp_path):
    found = ran(still(end=0.02, method="SPH", rtol=None), tmp_path / "run")
    assert found.probe("tap")["time"][1:].tolist() == found.steps["time"].tolist()


RESTARTED = """
from parisph import driver
from tests.driver.test_pressure_times import still
from parisph import Output
def case(end):
    return still(end, preset="violent", time_step=0.01, output=Output({}))
"""


@pytest.mark.parametrize("output", ["", "probe_interval=0.0007"])
def test_a_restart_goes_on_from_the_times_before(tmp_path, output):
    """The first part ends with samples after its last pressure, which the second one knows better."""
    body = RESTARTED.format(output)
    on_two_and_then(1, body, 'driver.run(case(0.06), comm, "whole", progress=False)\n'
                             'driver.run(case(0.031), comm, "part", progress=False)\n',
                    'driver.restart("part", comm, until=0.06, progress=False)', tmp_path)
    part, whole = (reader.open_run(tmp_path / name) for name in ("part", "whole"))
    for probe in ("tap", "load", "mixed"):
        a, b = part.probe(probe), whole.probe(probe)
        np.testing.assert_allclose(a["time"], b["time"], rtol=1e-12)
        np.testing.assert_array_equal(a["step"], b["step"])
        for column in a.dtype.names[2:]:
            np.testing.assert_allclose(a[column], b[column], rtol=1e-7, atol=1e-6, err_msg=f"{probe} {column}")


def test_a_run_that_is_killed_at_its_end_keeps_its_last_samples(tmp_path):
    """Between the last checkpoint and the summary."""
    case = still(preset="violent", time_step=0.01)
    before = ran(case, tmp_path / "run").probe("tap")
    (tmp_path / "run" / "summary.json").unlink()
    restart_alone(tmp_path / "run")
    assert reader.open_run(tmp_path / "run").probe("tap").tolist() == before.tolist()
