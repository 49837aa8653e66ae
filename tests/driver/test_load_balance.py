"""Ranks get equal shares of an uneven flow, and the same ones each time. The summary says how a run was shared, and one
table gathers runs on several numbers of ranks."""

import json
import sys

import numpy as np
import pytest

from tests.launch import ROOT, mpirun, run, succeeded
from tests.scenes import on_ranks

SETS = ("--set", "spacing=0.1", "jitter=0.2", "end_time=0.2")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("scaling")
    for ranks in (1, 2):
        succeeded(mpirun(ranks, ["-m", "parisph", "run", ROOT / "cases" / "dam_break.py", "-q", *SETS,
                                 "-o", place / f"ranks_{ranks}"], timeout=200))
    return place


def test_shares_are_those_of_the_ranks(folder):
    one, two = (json.loads((folder / f"ranks_{ranks}" / "summary.json").read_text()) for ranks in (1, 2))
    assert one["shares"]["imbalance"] == 1.0 and one["shares"]["ghosts"]["max"] == 0.0
    assert one["shares"]["owned"] == {"max": one["particles"], "mean": one["particles"]}
    shares = two["shares"]
    assert shares["owned"]["mean"] == two["particles"] / 2 and shares["neighbours"] == {"max": 1.0, "mean": 1.0}
    assert shares["ghosts"]["max"] > 0.0 and shares["work"]["mean"] == one["shares"]["work"]["mean"] / 2
    assert shares["imbalance"] == shares["work"]["max"] / shares["work"]["mean"]
    assert 9.0 < one["shares"]["updates"] < 20.0 and shares["updates"] == pytest.approx(one["shares"]["updates"], 0.1)
    assert 0.0 <= shares["plans"] <= 1.0 and 0.0 < shares["lists"] <= 1.0


def test_the_table_has_a_line_for_each_number_of_ranks(folder):
    (folder / "begun").mkdir()
    (folder / "begun" / "case.json").write_text("{}")
    done = succeeded(run([sys.executable, ROOT / "run_scripts" / "studies" / "scaling_table.py", folder]))
    lines = done.stdout.splitlines()
    assert lines[0].startswith("Strong scaling") and lines[-1] == "Not completed: begun"
    head, *rows = ([cell.strip() for cell in line.strip("|").split("|")] for line in lines if line.startswith("| "))
    first, second = (dict(zip(head, row, strict=True)) for row in rows)
    assert (first["ranks"], second["ranks"]) == ("1", "2") and first["efficiency"] == "1"
    assert len((folder / "table.csv").read_text().splitlines()) == 3


# -- a flow that is uneven by itself ----------------------------------------------------------------

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
    even, again, uneven = (FALLING.format(name=name, change=change)
                           for name, change in (("even", ""), ("again", ""), ("uneven", SPREAD_ONCE)))
    on_ranks(2, even + uneven, folder)
    on_ranks(2, again, folder)
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
