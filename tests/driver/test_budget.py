"""The energy budget of a step: what the fluid gains by each part adds up to what it gains."""

import json

import numpy as np
import pytest

from parisph import Box, Case, Fluid, Numerics, Output
from parisph.case.schema import Sway
from parisph.case.stored import from_json, to_json
from parisph.io import reader, series
from tests.scenes import budget, on_ranks, ran, restart_alone, run_alone, scene, simulated

CAUSES = ("pressure", "film", "filter", "collisions", "guard", "projection", "parting", "shift")
COLUMNS = [f"work_{cause}" for cause in CAUSES]
SELDOM = ("work_parting", "work_film")    # in a flow without jets of single particles or slow films


def test_works_add_up_to_the_change_of_energy():
    """Before, in and after the impact; also in a tank that moves, whose own acceleration has no potential."""
    start = 2455.0
    most = dict.fromkeys(COLUMNS, 0.0)
    for works, gain in budget(scene("dam_break", spacing=0.05, jitter=0.4, end_time=1.9, budget=True)):
        assert sum(works.values()) == pytest.approx(gain, abs=1e-12 * start)
        most = {name: max(value, abs(works[name])) for name, value in most.items()}
    assert list(works) == COLUMNS
    assert min(value for name, value in most.items() if name not in SELDOM) > 1e-6 * start
    shaken = scene("dam_break", spacing=0.1, end_time=0.3, budget=True)
    shaken = shaken.changed(frame=Sway(amplitude=0.05, frequency=10.0))
    gained = [(sum(works.values()), gain) for works, gain in budget(shaken)]
    np.testing.assert_allclose(*zip(*gained), rtol=0, atol=1e-12 * start)


def test_free_fall_does_no_work():
    """The step keeps the energy of a parabola: kinetic and potential energy only change places."""
    case = Case(title="fall", fluid=Fluid(Box(1.0, 1.0), density=1000.0, velocity=(1.0, 2.0)), gravity=(0.0, -9.81),
                numerics=Numerics(spacing=0.1, time_step=0.01, jitter=0.4), output=Output(budget=True), end_time=0.2)
    for works, gain in budget(case):
        np.testing.assert_allclose(list(works.values()), 0.0, atol=1e-7)     # of 2,500 J/m; the solver's tolerance
        assert abs(gain) < 1e-7


def test_without_a_budget_there_is_none(tmp_path):
    case = scene("dam_break", spacing=0.1, end_time=0.05)
    simulation = simulated(case)
    assert simulation.advance().works is None
    names = ran(case, tmp_path / "run").steps.dtype.names
    assert not any("work" in name for name in names) and names[-1] == "left"


def test_a_restart_continues_the_columns(tmp_path):
    case = scene("dam_break", spacing=0.1, end_time=0.1, budget=True)
    run_alone(case, tmp_path / "run")
    restart_alone(tmp_path / "run", until=0.06)
    found = reader.open_run(tmp_path / "run")
    assert found.steps["time"][-1] > 0.055 and series.units(found.folder / "steps.csv")[COLUMNS[0]] == "J/m"
    works = sum(found.steps[name] for name in COLUMNS)
    np.testing.assert_allclose(works, np.diff(found.probe("energy")["total"]), rtol=0, atol=1e-9)


def test_cases_from_before_have_no_budget():
    content = json.loads(to_json(scene("dam_break")))
    del content["output"]["budget"]
    for probe in content["probes"]:
        probe.pop("current", None)
    assert from_json(json.dumps(content)) == scene("dam_break")


BODY = """
def works(comm):
    s = Simulation(scene("dam_break", {"rtol": 1e-13}, spacing=0.05, jitter=0.4, budget=True), comm)
    found = np.array([list(s.advance().works.values()) for _ in range(20)])
    s.destroy()
    return found

together, alone = works(comm), works(MPI.COMM_SELF)
assert np.array_equal(together, comm.bcast(together))
assert (np.abs(alone).max(axis=0)[[0, 2, 5, 7]] > 1e-3).all()
assert difference(together, alone) < 1e-9, difference(together, alone)
"""


def test_ranks_agree(tmp_path):
    on_ranks(2, "from tests.scenes import difference" + BODY, tmp_path)
