"""What the surface and the walls are taken for does not depend on the number of ranks."""

import numpy as np
import pytest

from tests.scenes import assert_same, on_one_and_more

BODY = """
from parisph import Box, Case, Fluid, Numerics, Polygon, Sway, Tank

def tank(shape, height, **numerics):
    return Case(title="tank", fluid=Fluid(shape, density=1000.0), walls=Tank(width=1.0, height=height, lid=True),
                gravity=(0.0, -9.81), frame=Sway(amplitude=0.05, frequency=5.0), end_time=10.0,
                numerics=Numerics(spacing=0.05, rtol=1e-13, time_step=0.004, **numerics))

cases = {
    "below the lid": (tank(Box(width=1.0, height=0.5), 0.55), 60),
    "without a surface": (tank(Polygon(((0.0, 0.0), (1.0, 0.0), (1.0, 0.5), (0.0, 0.5))), 0.5), 5),
    "kept surface": (tank(Box(width=1.0, height=0.5), 1.0, preset="gentle"), 100),
    **{rule: (tank(Box(width=0.5, height=0.5), 1.0, surface_rule=rule, jitter=0.2), 60)
       for rule in ("auxiliary", "density", "divergence")},
}
for name, (case, steps) in cases.items():
    if comm.size == 3 and "surface_rule" in case.numerics.model_fields_set:    # two ranks show it, in half the time
        continue
    s = Simulation(case, comm)
    isolated = s.solve_start()
    if name == "kept surface":      # one is thrown into the air, and comes down again
        s.particles.u[s.particles.id == 90] = [0.0, 2.0]
        s.particles.x[s.particles.id == 90] = [0.5, 0.6]
    roles = []
    for _ in range(steps):
        s.advance()
        roles.append(s.gather("role"))
    found = s.gather("x", "u", "p")
    if comm.rank == 0:
        np.savez(f"{name}-{comm.size}.npz", isolated=isolated, roles=[role["role"] for role in roles], **found)
    s.destroy()
"""
RULES = ("auxiliary", "density", "divergence")
NAMES = ("below the lid", "without a surface", "kept surface")
RUNS = [(name, ranks) for name in NAMES for ranks in (1, 2, 3)] + [(name, ranks) for name in RULES for ranks in (1, 2)]


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    folder = tmp_path_factory.mktemp("surface")
    on_one_and_more(BODY, folder)
    return {(name, n): np.load(folder / f"{name}-{n}.npz") for name, n in RUNS}


@pytest.mark.parametrize(("name", "ranks"), [run for run in RUNS if run[1] > 1])
def test_ranks_agree(results, name, ranks):
    one, more = results[name, 1], results[name, ranks]
    np.testing.assert_array_equal(more["roles"], one["roles"])
    assert more["isolated"] == one["isolated"] and (one["isolated"] > 0) == (name == "without a surface")
    assert_same(one, more, 1e-8, ("x", "p") if name == "without a surface" else ("x", "u", "p"))


def test_something_happened(results):
    for name in RULES:
        roles = results[name, 1]["roles"]
        assert (roles[0] != roles[-1]).sum() > 10
    lid = results["below the lid", 1]["roles"]
    assert (lid[0] != lid[-1]).sum() > 5
    flight = (results["kept surface", 1]["roles"] == 5).any(axis=0)
    assert flight.sum() == 1 and not (results["kept surface", 1]["roles"][-1] == 5).any()
