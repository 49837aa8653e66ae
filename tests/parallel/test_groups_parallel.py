"""Isolated rows are the same on any number of ranks, and errors reach all of them."""

import numpy as np
import pytest

from parisph.base.errors import ParisphError
from parisph.pressure.groups import highest, isolated_rows
from tests.digraphs import leads_nowhere, random_rows, to_csr


def cut(comm, indptr, indices, ends):
    """Return this rank's (first, last, indptr, indices); rank r owns rows up to ends[r]."""
    first, last = (0, *ends)[comm.rank], ends[comm.rank]
    return first, last, indptr[first:last + 1] - indptr[first], indices[indptr[first]:indptr[last]]


def even(comm, n):
    return [n * (rank + 1) // comm.size for rank in range(comm.size)]


def with_empty_first(comm, n):
    return [n * rank // max(comm.size - 1, 1) for rank in range(comm.size)] if comm.size > 1 else [n]


def with_empty_last(comm, n):
    return [n * min(rank + 1, comm.size - 1) // max(comm.size - 1, 1) for rank in range(comm.size)]\
        if comm.size > 1 else [n]


@pytest.mark.parametrize("ends", [even, with_empty_first, with_empty_last])
def test_random_graphs_as_by_brute_force(comm, ends):
    for seed in range(12):
        mean = (0.8, 1.5, 4.0)[seed % 3]
        indptr, indices = random_rows(120, mean, seed)
        anchored = np.random.default_rng(seed + 100).random(120) < 0.03
        first, last, *rows = cut(comm, indptr, indices, ends(comm, 120))
        found, count = isolated_rows(comm, first, *rows, anchored[first:last])
        np.testing.assert_array_equal(found, leads_nowhere(indptr, indices, anchored)[first:last])


def test_a_chain_that_goes_to_and_fro_between_ranks(comm):
    # One mark crosses a border in each round: as many rounds as rows.
    n = 60
    order = np.arange(n).reshape(2, -1).T.ravel()
    columns = [None] * n
    for here, there in zip(order[:-1], order[1:]):
        columns[here] = [here, there]
    columns[order[-1]] = [order[-1]]
    first, last, *rows = cut(comm, *to_csr(columns), even(comm, n))
    anchored = np.zeros(n, bool)
    anchored[order[40]] = True
    found, count = isolated_rows(comm, first, *rows, anchored[first:last])
    assert sorted(np.flatnonzero(found) + first) == [i for i in sorted(order[41:]) if first <= i < last]


def test_flags_that_do_not_fit_on_one_rank_raise_on_all(comm):
    first, last, *rows = cut(comm, *random_rows(30, 2.0, 1), even(comm, 30))
    anchored = np.zeros(last - first + (comm.rank == comm.size - 1), bool)
    with pytest.raises(ParisphError, match="anchored flags do not fit"):
        isolated_rows(comm, first, *rows, anchored)


def test_a_column_that_no_rank_owns_raises_on_all(comm):
    if comm.size == 1:
        pytest.skip("on one rank such a column leads nowhere, and the solver refuses it")
    indptr, indices = random_rows(30, 2.0, 1)
    indices[-1] = 30
    first, last, *rows = cut(comm, indptr, indices, even(comm, 30))
    with pytest.raises(ParisphError, match="column .* 30 of 30"):
        isolated_rows(comm, first, *rows, np.zeros(last - first, bool))


@pytest.mark.parametrize("ends", [even, with_empty_first, with_empty_last])
@pytest.mark.parametrize(("force", "expected"), [
    ([0.0, -9.81], 37),         # on top, and the lowest id of those as high to within the rounding
    ([0.0, 9.81], 5), ([2.0, 0.0], 11),
    ([0.0, 0.0], 5),            # nothing is higher than anything else: the lowest id of all
])
def test_highest_of_all_ranks(comm, ends, force, expected):
    x = np.array([[0.0, 1.0 - 1e-9], [1.0, 1.0], [-1.0, 0.3], [0.5, 0.0], [0.0, 2.0]])
    ids = np.array([37, 40, 11, 5, 1])
    candidate = np.array([True, True, True, True, False])
    own = slice(*[0, *ends(comm, len(x))][comm.rank:comm.rank + 2])
    chosen = highest(comm, candidate[own], x[own], np.tile(force, (len(x), 1))[own], ids[own], 1e-3)
    assert [number for part in comm.allgather(ids[own][chosen].tolist()) for number in part] == [expected]


def test_highest_of_none(comm):
    none = np.zeros((3, 2))
    assert not highest(comm, np.zeros(3, bool), none, none, np.arange(3), 1e-3).any()
