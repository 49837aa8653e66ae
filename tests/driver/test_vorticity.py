"""Vorticity in snapshots: exact where velocity is linear, and of nobody's concern who does not ask for it."""

from math import pi

import numpy as np
import pytest

from parisph import Box, Case, Fluid, Numerics, Output, PressureTap, StandingWave
from parisph.base.fields import FLUID
from parisph.io import reader
from parisph.kernels import strain
from tests.scenes import at_end, ran, run_alone, scene, simulated, water

ASKED = ("u", "p", "role", "vorticity")


def shear():
    return Case(title="shear", fluid=Fluid(Box(1.0, 1.0), density=1000.0, velocity=("3*y", "-2*x")), gravity=(0.0, 0.0),
                numerics=Numerics(spacing=0.1, jitter=0.4), output=Output(fields=ASKED), end_time=0.1)


def test_it_is_exact_for_a_linear_velocity():
    simulation = simulated(shear())
    simulation.complete(ASKED)
    p = simulation.particles
    np.testing.assert_allclose(p.vorticity[p.kind == FLUID], -5.0, rtol=1e-11)


@pytest.mark.parametrize(("spacing", "step"), [(0.05, 0.02), (0.05, 0.01), (0.025, 0.01)])
def test_an_irrotational_wave_has_none_beside_walls(spacing, step):
    """With the velocity that walls had at the start of the step it was .029, .014 and .041 1/s, and grew on refinement.

    Measured .0005 to .0006, of a velocity gradient of .04. The velocities of the run stay as they are.
    """
    wave = StandingWave(amplitude=0.01, depth=0.5, length=2.0, phase=pi / 2)
    simulation = at_end(water((1.0, 0.5), (1.0, 0.8), dict(spacing=spacing, time_step=step), wave=wave,
                              output=Output(fields=ASKED), end_time=0.56))
    p = simulation.particles
    before = p.u.copy()
    simulation.complete(ASKED)
    below = (p.kind == FLUID) & (p.x[:, 1] < 0.5 - 3.0 * spacing)
    assert np.abs(p.vorticity[below]).max() < 0.002
    np.testing.assert_array_equal(p.u, before)


def test_a_run_writes_it_and_computes_it_for_that_alone(tmp_path, monkeypatch):
    calls, gradient = [], strain.velocity_gradient
    # the filter asks the same kernel for something else, and gives no room for a gradient
    monkeypatch.setattr(strain, "velocity_gradient", lambda *given: calls.extend([1] * (len(given[0]) > 0))
                        or gradient(*given))
    gentle = {"preset": "gentle", "time_step": 0.01, "regularisers": ("irrotational", "wall_guard")}
    case = scene("dam_break", gentle, spacing=0.25).changed(end_time=0.05, probes=[], output=Output(fields=ASKED))
    run_alone(case, tmp_path / "asked")
    assert len(calls) == 2    # at the start and at the end; these regularisers measure no strain
    found = reader.open_run(tmp_path / "asked").snapshot()
    assert np.abs(found["vorticity"][found["kind"] == FLUID]).max() > 0.0
    assert not found["vorticity"][found["kind"] != FLUID].any()
    assert "vorticity" not in ran(case.changed(output=Output()), tmp_path / "not").snapshot() and len(calls) == 2


def test_the_flow_at_a_peak_has_it_too(tmp_path):
    case = scene("dam_break", spacing=0.25).changed(
        end_time=0.3, probes=[PressureTap("tap", at=(0.0, 0.2), peak=True)], output=Output(fields=ASKED))
    peak = ran(case, tmp_path / "run").peak("tap")
    assert peak["step"] > 0 and np.abs(peak["vorticity"]).max() > 0.0


def test_who_has_no_such_field_computes_nothing():
    simulation = simulated(shear().changed(output=Output()))
    simulation.complete(ASKED)
    with pytest.raises(AttributeError):
        simulation.particles.vorticity    # noqa: B018
