"""A flow that is uneven by itself: ranks get equal shares of it, and the same ones each time."""

import numpy as np
import pytest

from tests.scenes import on_ranks

# A falling column: walls of which most touch no water, a front that runs from one rank's cells into
# another's. The processor time of their kernels is a part of the validation, "ranks".
FALLING = """
s = Simulation(scene("dam_break", spacing=0.025), comm)
{change}
steps = []
while s.steps < 110:
    s.advance()
    steps.append(s.domain.indices.size)    # neighbours in the lists of this rank's particles
everyone = np.array(comm.gather(steps) or 0)
found = s.gather("x", "u", "p", "role")
if comm.rank == 0:
    np.savez("{name}.npz", steps=everyone, **found)
"""
SPREAD_ONCE = "s.domain.tolerated = np.inf"


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    folder = tmp_path_factory.mktemp("uneven")
    for name, change in (("even", ""), ("again", ""), ("uneven", SPREAD_ONCE)):
        on_ranks(2, FALLING.format(name=name, change=change), folder)
    return {name: np.load(folder / f"{name}.npz") for name in ("even", "again", "uneven")}


def imbalance(run):
    """Return max/mean over the ranks of the neighbours of their particles, of the typical one of the last steps."""
    typical = np.median(run["steps"][:, 60:], axis=1)
    return typical.max() / typical.mean()


def test_ranks_of_an_uneven_flow_have_equal_work(runs):
    assert imbalance(runs["uneven"]) > 1.2, "the flow is uneven, if nothing is done"
    assert imbalance(runs["even"]) < 1.1


def test_run_on_two_ranks_can_be_repeated_bit_for_bit(runs):
    for name in ("x", "u", "p", "role"):
        np.testing.assert_array_equal(runs["even"][name], runs["again"][name])
