"""A piston, obstacles and a slope are the same flow on 1, 2 and 3 ranks, and after a restart on more of them."""

import numpy as np
import pytest

from parisph import Box, Case, Fluid, Numerics, Obstacle, Piston, Polygon, Profile, StillWater, Sway
from parisph.base.fields import FLUID
from tests.running import last_checkpoint
from tests.scenes import assert_same, on_ranks

STEPS = 20
# the last one: violent flow in which all wall rows are means of their neighbours
KINDS = ("violent", "gentle", "solitary", "means")
BED = ((0.0, 0.9), (0.0, 0.0), (1.6, 0.0), (2.4, 0.8))


def scene(kind):
    more = {"wall_rows": "curved"} if kind == "solitary" else {}
    return Case(title="piston, sill and slope", fluid=Fluid(StillWater(0.5), density=1000.0), walls=(
        Profile(BED), Obstacle(Polygon([(0.9, -0.1), (0.9, 0.1), (1.0, 0.2), (1.1, 0.2), (1.1, -0.1)])),
        Obstacle(Box(width=0.1, height=0.1, at=(0.6, 0.25))),
        Piston(at=0.12, motion=Sway(amplitude=0.05, frequency=3.0), side="right")), gravity=(0.0, -9.81),
        numerics=Numerics(spacing=0.05, preset="violent" if kind == "means" else kind, jitter=0.4, rtol=1e-13,
                          time_step=0.006, **more), end_time=0.006 * STEPS)


# one launch: first two ranks beside one alone, then all three
BODY = f"""
import pytest
from parisph import driver
from tests import mean_rows
from tests.driver.test_walls_on_ranks import scene
some = comm.Split(0 if comm.rank < 2 else 1)
for kind in {KINDS!r}:
    if kind == "means":
        mean_rows.install(pytest.MonkeyPatch())
    whole = scene(kind)
    driver.run(whole, some, f"{{kind}}-{{some.size}}", progress=False)
    if some.size == 2:
        driver.run(whole.changed(end_time=0.5 * whole.end_time), some, f"{{kind}}-part", progress=False)
    comm.Barrier()
    driver.run(whole, comm, f"{{kind}}-3", progress=False)
    driver.restart(f"{{kind}}-part", comm, until=whole.end_time, progress=False)
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("walls")
    on_ranks(3, BODY, folder)
    return folder


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("other", ["2", "3", "part"])
def test_same_flow(folder, kind, other):
    """The piston goes a third of a spacing; water comes nearly as fast as it does."""
    (one, due), (more, found) = (last_checkpoint(folder / f"{kind}-{name}") for name in ("1", other))
    assert one["step"] == more["step"] == STEPS and (one["ranks"], more["ranks"]) == (1, 2 if other == "2" else 3)
    assert np.abs(due["u"][due["kind"] == FLUID]).max() > 0.05
    np.testing.assert_array_equal(found["volume"], due["volume"])
    np.testing.assert_allclose(found["weight"], due["weight"], rtol=1e-12, atol=1e-12)
    assert_same(due, found)
