"""Probes on and above walls that move, or that do not stand on the bed."""

import numpy as np
import pytest
from mpi4py import MPI

from parisph import (
    Box,
    Case,
    ColumnHeight,
    Fluid,
    Numerics,
    Obstacle,
    Plate,
    StillWater,
    SurfaceGauge,
    Sway,
    Tank,
    WaterFront,
)
from tests.watched import DENSITY, G, Watch

S, LEVEL = 0.05, 0.6
SWAY = Sway(amplitude=0.2, frequency=np.pi)     # at .2 m after half a second


def scene(walls, probes, level=LEVEL):
    return Case(title="moving", fluid=Fluid(StillWater(level), density=DENSITY), walls=walls, gravity=(0.0, -G),
                numerics=Numerics(spacing=S), probes=probes, end_time=1.0)


def sampled(walls, probes, time=0.0, shift=0.0, level=LEVEL):
    """Return {probe: values} of still water that has moved by `shift` along x as one body."""
    def change(arrays):
        arrays["x"][:, 0] += shift
        arrays["p"][:] = DENSITY * G * np.maximum(level - arrays["x"][:, 1], 0.0)
    watch = Watch(scene(walls, probes, level), MPI.COMM_SELF, change)
    try:
        return watch.sample(time)
    finally:
        watch.destroy()


def test_gauges_stand_in_a_tank_that_moves():
    probes = [SurfaceGauge("gauge", at=0.9), ColumnHeight("column", at=1.0), WaterFront("front")]
    found = sampled(Tank(2.0, 1.0, motion=SWAY), probes, time=0.5, shift=0.2)
    assert found["gauge"] == found["column"] == pytest.approx((LEVEL,), abs=1e-9)
    assert found["front"] == pytest.approx((2.2 - S,), abs=1e-9)


@pytest.mark.parametrize("body", [Obstacle(Box(0.4, 0.2, at=(0.8, 0.1))), Plate([(0.8, 0.25), (1.2, 0.25)])])
@pytest.mark.parametrize("motion", [{}, {"motion": SWAY}])
def test_gauges_above_what_is_under_water_have_the_surface(body, motion):
    probes = [SurfaceGauge("gauge", at=1.0), ColumnHeight("column", at=1.0), SurfaceGauge("beside", at=0.4)]
    found = sampled((Tank(2.0, 1.0), body.model_copy(update=motion)), probes)
    assert {name: values[0] for name, values in found.items()} == pytest.approx(
        {"gauge": LEVEL, "column": LEVEL, "beside": LEVEL}, abs=1e-9)


def test_a_gauge_below_a_body_in_the_air_has_the_water_under_it():
    found = sampled((Tank(2.0, 1.2), Obstacle(Box(0.4, 0.2, at=(0.8, 0.8)))), [SurfaceGauge("gauge", at=1.0)])
    assert found["gauge"] == pytest.approx((LEVEL,), abs=1e-9)
