"""Wall rows that are means of their neighbours, as some are where water leaves a wall: here all of them."""

import numpy as np
import pytest

from parisph import Roll, Sway
from parisph.base.fields import FLUID, WET
from tests import mean_rows
from tests.physics.test_moving_walls import apart
from tests.scenes import scene, simulated


@pytest.fixture
def means(monkeypatch):
    mean_rows.install(monkeypatch)


def test_water_rests(means):
    case = scene("hydrostatic", spacing=0.1, preset="violent", jitter=0.4).changed(**{"numerics.rtol": 1e-13})
    s = simulated(case, 20)
    found = s.gather("u", "kind", "role")
    assert np.count_nonzero(found["role"] == WET) > 20
    assert np.abs(found["u"][found["kind"] == FLUID]).max() < 1e-9


@pytest.mark.parametrize("motion", [Sway(amplitude=0.02, frequency=5.5),
                                    Roll(angle=0.05, frequency=5.5, centre=(0.5, 0.0))], ids=["sway", "roll"])
def test_moving_walls_are_a_moving_frame(motion, means):
    assert apart(motion, "violent") < 5e-4
