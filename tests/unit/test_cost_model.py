"""The cost model: lattices cell by cell, real partitions in one process, and times that follow from counts."""

import json

import numpy as np
import pytest
from mpi4py import MPI

from run_scripts.studies.cost_model import model, multigrid
from run_scripts.studies.cost_model.partitions import WIDTH, Column, Points, cut, hops, line, shares
from tests.scenes import on_ranks
from tests.simulated import check_run

FOUR = """
from tests.simulated import check_cloud
for dim in (2, 3):
    check_cloud(comm, dim)
"""


@pytest.mark.parametrize("dim", [2, 3])
def test_a_column_made_cell_by_cell_is_that_of_all_its_particles(dim):
    column = Column(dim, 5000)
    x = column.particles(0, len(column.cells))
    assert len(np.unique(x, axis=0)) == column.n == len(x)
    whole = Points(x, np.zeros(dim), [2.0, 2.0] if dim == 2 else [2.0, 1.0, 2.0], WIDTH[dim] * column.spacing)
    for name in ("cells", "counts", "work"):
        np.testing.assert_array_equal(getattr(whole, name), getattr(column, name))
    partition = cut(column, 7)
    found, due = (shares(scene, partition, WIDTH[dim] * column.spacing) for scene in (column, whole))
    for name in ("owned", "sent", "received", "to", "by"):
        np.testing.assert_array_equal(getattr(found, name), getattr(due, name), err_msg=name)
    assert found.owned.sum() == column.n and found.sent.sum() == found.received.sum() > 0


def test_marks_come_to_every_rank():
    column = Column(2, 5000)
    for ranks in (1, 2, 40):
        partition = cut(column, ranks)
        found = hops(column, partition, shares(column, partition, 2.1 * column.spacing).receivers)
        assert (found == 0) if ranks == 1 else 0 <= found < ranks


def test_one_rank_has_the_counts_of_the_simulation():
    assert check_run(MPI.COMM_SELF) >= 10


def test_four_ranks_have_the_counts_of_the_simulation(tmp_path):
    on_ranks(4, FOUR, tmp_path)


def test_levels_are_read_from_what_hypre_prints():
    text = """
Operator Matrix Information:
lev    rows  entries sparse   min  max     avg      min         max
======================================================================
  0   10648   322292  0.003    14   33    30.3  0.0e+00  1.0e+00
  1     188     4076  0.115     9   30    21.7  0.0e+00  1.0e+00
Interpolation Matrix Information:
  0   10648 x 188     3    4  0.0  1.0
"""
    assert multigrid.levels_in(text) == [{"rows": 10648, "entries": 322292}, {"rows": 188, "entries": 4076}]


@pytest.mark.parametrize("dim", [2, 3])
def test_a_cycle_sends_on_four_ranks_what_the_model_makes_of_two(dim):
    measured = model.Measured.read(model.MEASURED)[dim]
    four = next(one for one in json.loads((model.MEASURED / f"messages_{dim}d.json").read_text()) if one["ranks"] == 4)
    mean = line(Column(dim, four["particles"]), 4)
    mean["matrix_to_max"] = mean["matrix_to_mean"]
    network = model.Network(1.0, np.inf)    # its time is the number of messages
    assert model._cycle(measured, network, mean) == pytest.approx(four["counts"]["cycle"][0], rel=0.1)
    updates = measured.counts("step/updates")[0]
    assert four["counts"]["step/updates"][0] == updates * four["neighbours"]


@pytest.mark.parametrize("dim", [2, 3])
def test_the_model_is_perfect_without_a_network_and_worse_with_a_slow_one(dim):
    measured = model.Measured.read(model.MEASURED)[dim]
    lines = [line(Column(dim, 20000), ranks) for ranks in (1, 4)]
    (alone, fast), (_, slow) = (model.table(measured, model.Network(latency, np.inf), lines) for latency in (0.0, 1e-2))
    assert alone["ms"] == pytest.approx(
        1e-3 * measured.phases["us_all"] * lines[0]["particles"] + measured.phases["overhead_ms"])
    parts = [fast[name] for name in model.PARTS]
    assert sum(parts) == pytest.approx(fast["ms"]) and max(parts[3:]) < 1e-3
    assert slow["efficiency"] < 0.1 * fast["efficiency"] < 0.1
