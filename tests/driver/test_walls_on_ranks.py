"""A piston, obstacles and a slope are the same flow on 1, 2 and 3 ranks, and after a restart on more of them."""

import numpy as np
import pytest

from parisph.base.fields import FLUID
from tests.running import last_checkpoint
from tests.scenes import assert_same, on_ranks

STEPS = 20
PRESETS = ("violent", "gentle", "solitary")

# one launch: first two ranks beside one alone, then all three
BODY = f"""
from parisph import driver
from tests.parallel.test_solid_walls import scene
some = comm.Split(0 if comm.rank < 2 else 1)
for preset in {PRESETS!r}:
    case = scene(preset)
    if preset == "solitary":
        case = case.changed(**{{"numerics.wall_rows": "curved"}})
    whole = case.changed(end_time={STEPS} * case.numerics.time_step)
    driver.run(whole, some, f"{{preset}}-{{some.size}}", progress=False)
    if some.size == 2:
        driver.run(whole.changed(end_time=0.5 * whole.end_time), some, f"{{preset}}-part", progress=False)
    comm.Barrier()
    driver.run(whole, comm, f"{{preset}}-3", progress=False)
    driver.restart(f"{{preset}}-part", comm, until=whole.end_time, progress=False)
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("walls")
    on_ranks(3, BODY, folder)
    return folder


@pytest.mark.parametrize("preset", PRESETS)
@pytest.mark.parametrize("other", ["2", "3", "part"])
def test_same_flow(folder, preset, other):
    """The piston goes a third of a spacing; water comes nearly as fast as it does."""
    (one, due), (more, found) = (last_checkpoint(folder / f"{preset}-{name}") for name in ("1", other))
    assert one["step"] == more["step"] == STEPS and (one["ranks"], more["ranks"]) == (1, 2 if other == "2" else 3)
    assert np.abs(due["u"][due["kind"] == FLUID]).max() > 0.05
    assert_same(due, found)
