"""Scenes at their limits: how far fluid and walls reach, and what is refused before any work."""

import numpy as np
import pytest

from parisph import (
    Box,
    Case,
    Disc,
    Fluid,
    Numerics,
    Profile,
    Roll,
    Series,
    StillWater,
    Sway,
    Tank,
)
from parisph.base.errors import CaseError
from parisph.case.motion import Moved
from parisph.driver.preview import describe
from parisph.geometry import build

S = 0.05
TANK = Tank(2.0, 1.0)
COLUMN = Fluid(Box(0.5, 0.5, at=(0.5, 0.0)), 1000.0)
WATER = Fluid(StillWater(0.4), 1000.0)


def scene(walls, fluid=WATER, end_time=1.0, spacing=S, **more):
    return Case(title="scene", fluid=fluid, walls=walls, gravity=(0.0, -9.81), end_time=end_time,
                numerics=Numerics(spacing=spacing, **more.pop("numerics", {})), **more)


def sampled(case):
    return sum(volume.sum() for _, volume in build.samples(case, (-9.0, -9.0), (9.0, 9.0)))


@pytest.mark.parametrize("points", [[(0.0, 0.2), (0.0, 0.0), (2.0, 0.0), (2.0, 0.2)], [(0.0, 0.0), (2.0, 0.0)]])
def test_fluid_above_the_highest_wall_has_its_volume(points):
    case = scene(Profile(points), COLUMN)
    assert sampled(case) == pytest.approx(0.25, rel=1e-9)
    assert build.domain(case)[1][1] == 0.5
    assert "0.25 m2 exactly" in describe(case)


@pytest.mark.parametrize("motion, end_time, right", [
    (Sway(0.3, 2.0 * np.pi), 399.0, 2.6),
    (Roll(0.5 * np.pi, 2.0 * np.pi, centre=(2.0, 0.0)), 399.0, 3.0),
    (Moved(Series(times=(0.0, 100.0, 100.1, 100.2, 100.3, 400.0), values=(0.0, 0.0, 0.3, 0.3, 0.0, 0.0))), 400.0, 2.3),
])
def test_walls_are_looked_at_wherever_they_move(motion, end_time, right):
    assert build.domain(scene(Tank(2.0, 1.0, motion=motion), end_time=end_time))[1][0] >= right - 1e-3


def refused(case):
    """Return the one error with which the case is refused, before any work."""
    with pytest.raises(CaseError) as error:
        describe(case)
    return str(error.value)


def test_holes_that_leave_no_fluid_are_named():
    said = refused(scene(TANK, Fluid(Box(0.5, 0.5), 1000.0, holes=(Disc(2.0, at=(0.2, 0.2)),))))
    assert said == "fluid.holes: they leave none of its particles; make them smaller, or leave this fluid out"
