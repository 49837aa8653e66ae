"""Water that passes a line: what is counted is the volume behind it, on any number of ranks, over a restart."""

import json

import numpy as np
import pytest
from mpi4py import MPI

from parisph import Box, Case, CaseError, Fluid, Flux, Numerics, Output, Plate, ProbeArray, Tank
from parisph.base.fields import FLUID
from parisph.driver import Simulation
from parisph.io import info, reader
from parisph.report import events as told
from parisph.truth.overtopping import events
from parisph.watch.passages import passed
from tests.scenes import restart_alone, run_alone
from tests.watched import Watch, scene

OVER = Flux("over", start=(0.5, 0.2), end=(0.5, 1.0), pause=0.2)


def over_a_plate(end_time=0.6, **output):
    """Return a dam break whose water falls over a plate into the other half of a tank."""
    return Case(title="over a plate", fluid=Fluid(Box(width=0.4, height=0.8), density=1000.0),
                walls=(Tank(width=1.0, height=1.0, lid=True), Plate(((0.5, 0.0), (0.5, 0.2)), name="plate")),
                gravity=(0.0, -9.81), numerics=Numerics(spacing=0.05, rtol=1e-13), output=Output(**output),
                probes=[OVER, ProbeArray("lines", [Flux("back", start=OVER.end, end=OVER.start)])], end_time=end_time)


def test_a_way_through_a_line_counts_and_one_beside_it_does_not():
    line = np.array([[0.0, 0.0], [0.0, 1.0]])    # upwards: positive towards +x
    before = np.array([[-0.1, 0.5], [0.1, 0.5], [-0.1, 1.2], [-0.1, 0.9], [0.0, 0.5], [-0.2, 0.5]])
    after = np.array([[0.1, 0.5], [-0.1, 0.5], [0.1, 1.2], [0.1, 1.3], [0.1, 0.6], [0.0, 0.5]])
    each = [passed(line, a[None], b[None], np.ones(1)) for a, b in zip(before, after)]
    assert each == [1.0, -1.0, 0.0, 0.0, 1.0, 0.0]
    assert passed(line[::-1], before[:2], after[:2], np.array([1.0, 3.0])) == 2.0


def test_uniform_flow_has_its_rate_wherever_the_line_lies():
    for x in (0.5, 0.512, 0.525, 0.549):
        watch = Watch(scene([Flux("up", start=(x, 0.0), end=(x, 1.0)), Flux("down", start=(x, 1.0), end=(x, 0.0)),
                             Flux("along", start=(0.2, 0.26), end=(0.8, 0.26))], velocity=(0.3, 0.0)), MPI.COMM_SELF)
        found = watch.sample()
        assert found["up"][0] == pytest.approx(0.3 * 0.5, rel=1e-12) and found["down"][0] == -found["up"][0]
        assert found["along"][0] == pytest.approx(0.0, abs=1e-15)
        watch.destroy()


def counted_and_behind(case, comm):
    """Run a case on some ranks; return what its lines have counted, and the volume right of x = .5."""
    s = Simulation(case, comm)
    while not s.finished():
        s.advance()
    p = s.particles
    behind = comm.allreduce(p.volume[(p.kind == FLUID) & (p.x[:, 0] > 0.5)].sum())
    found = list(s.passages.state().values())
    s.destroy()
    return found, behind


@pytest.mark.parametrize("method", ["ISPH_R", "SPH"])
def test_what_passed_a_line_is_what_lies_behind_it(method):
    """SPH knows no plates: there it is a dam break that passes the line."""
    case = over_a_plate(0.5)
    if method == "SPH":
        case = case.changed(walls=Tank(width=1.0, height=1.0, lid=True), end_time=0.18, numerics=Numerics(
            spacing=0.05, method="SPH"), probes=[Flux("over", start=(0.5, 0.0), end=(0.5, 1.0))])
    counted, behind = counted_and_behind(case, MPI.COMM_SELF)
    assert behind > 0.005
    assert counted == pytest.approx([behind, -behind][:len(counted)], rel=1e-12)


def test_it_goes_on_over_a_restart_and_is_told(tmp_path):
    whole = run_alone(over_a_plate(0.4), tmp_path / "whole")
    run_alone(over_a_plate(0.36), tmp_path / "parts")
    summary = restart_alone(tmp_path / "parts", until=0.4)
    found = summary["passed"]["over"]
    assert found["total"] > found["events"][0]["volume"] * 0.999 > 0.0
    assert found["total"] == pytest.approx(whole["passed"]["over"]["total"], rel=1e-12)
    assert summary["passed"]["lines.back"] == {"total": -found["total"], "events": None}
    assert any(line.startswith("passed over ") and " in 1 event, the largest " in line for line in info.table(summary))
    table = told.passed(json.loads((tmp_path / "parts" / "summary.json").read_text()))
    assert [row[1].text for row in table.rows] == ["all", "1", "all"]
    columns = reader.open_run(tmp_path / "parts").units("over")
    assert columns["rate"] == "m^2/s" and columns["total"] == "m^2"


def test_events_end_where_nothing_passes_for_a_pause_and_add_up_to_the_total():
    time = 0.1 * np.arange(11)
    total = np.array([0.0, 0.0, 1.0, 1.0, 3.0, 3.0, 3.0, 3.0, 3.0, 2.5, 2.5])
    found = events(time, total, 0.35)
    assert [[round(value, 3) for value in event.values()] for event in found] == [[0.1, 0.4, 3.0], [0.8, 0.9, -0.5]]
    assert len(events(time, total, 0.05)) == 3 and len(events(time, total, 0.5)) == 1
    assert events(time, 0.0 * total, 0.3) == []


@pytest.mark.parametrize("line, why", [({"start": (0.5, 0.2), "end": (0.5, 0.2)}, "must be two points"),
                                       ({"start": (3.0, 0.2), "end": (3.0, 1.0)}, "must lie within the walls")])
def test_a_line_that_nothing_can_pass_is_refused(line, why):
    with pytest.raises(CaseError, match=f"probe 'over'.*{why}"):
        over_a_plate().changed(probes=[Flux("over", **line)])
