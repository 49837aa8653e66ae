"""A tank with an obstacle and a piston in 3D is the same flow on one and two ranks, and after a restart on the other
number of them."""

import numpy as np
import pytest

from parisph import Box, Case, Fluid, Numerics, Obstacle, Piston, StillWater, Sway, Tank
from parisph.base.fields import FLUID
from tests.running import last_checkpoint
from tests.scenes import assert_same, on_ranks

STEPS, STEP = 12, 0.01    # and of time [s]


def scene():
    """Return the Case of some hundred particles."""
    return Case(title="piston and box in 3D", fluid=Fluid(StillWater(0.4), density=1000.0),
                walls=(Tank(1.4, 0.7, at=(-0.3, 0.0), breadth=0.7),
                       Obstacle(Box(0.2, 0.2, breadth=0.3, at=(0.6, 0.2, 0.0))),
                       Piston(0.0, motion=Sway(amplitude=0.05, frequency=6.0))),
                gravity=(0.0, -9.81), end_time=STEPS * STEP,
                numerics=Numerics(spacing=0.1, jitter=0.2, seed=1, rtol=1e-13, time_step=STEP))


# one launch: each rank has one run to itself, so that no rank waits for the other
BODY = """
from mpi4py import MPI
from parisph import driver
from tests.driver.test_restart_in_3d import scene
whole = scene()
half = whole.changed(end_time=0.5 * whole.end_time)
name, case = ("1", whole) if comm.rank == 0 else ("1-then-2", half)
driver.run(case, MPI.COMM_SELF, name, progress=False)
driver.run(half, comm, "2-then-1", progress=False)
driver.restart("1-then-2", comm, until=whole.end_time, progress=False)
if comm.rank == 0:
    driver.restart("2-then-1", MPI.COMM_SELF, until=whole.end_time, progress=False)
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("restart")
    on_ranks(2, BODY, folder, timeout=300)
    return folder


@pytest.mark.parametrize(("name", "ranks"), [("1-then-2", 2), ("2-then-1", 1)])
def test_same_flow(folder, name, ranks):
    (one, due), (more, found) = (last_checkpoint(folder / run) for run in ("1", name))
    assert one["step"] == more["step"] == STEPS and (one["ranks"], more["ranks"]) == (1, ranks)
    assert np.abs(due["u"][due["kind"] == FLUID]).max() > 0.05
    assert_same(due, found)
