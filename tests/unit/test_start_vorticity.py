"""Vorticity of the fluid at the start: that of its velocity, and none where this is irrotational."""

import numpy as np
import pytest

from parisph import Box, Fluid
from parisph.case.waves import standing_wave_start

PLACES = np.random.default_rng(1).random((400, 2)) * (2.0, 1.0)


def vorticity(velocity, spacing):
    return Fluid(Box(width=2.0, height=1.0), density=1000.0, velocity=velocity).start_vorticity(PLACES, spacing)


@pytest.mark.parametrize("spacing", [0.2, 0.05])
@pytest.mark.parametrize("k", [1.0, np.pi, 2.0 * np.pi])
def test_a_wave_has_none(k, spacing):
    """Differences of its velocity leave an error of second order, for which each step would pay."""
    assert not np.any(vorticity(standing_wave_start(0.05, k, 1.0, 9.81), spacing))


def test_rigid_rotation_has_twice_its_rate():
    assert vorticity(("-2*y", "2*x"), 0.1) == pytest.approx(4.0, rel=1e-12)


def test_a_shear_flow_is_right_to_second_order():
    due = -3.0 * np.cos(3.0 * PLACES[:, 1])
    coarse, fine = (np.abs(vorticity(("sin(3*y)", "0"), s) - due).max() for s in (0.1, 0.05))
    assert coarse < 0.02 and fine == pytest.approx(0.25 * coarse, rel=0.05)
