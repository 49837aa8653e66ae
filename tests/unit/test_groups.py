"""Rows without contact with a known pressure are found, and only those."""

import numpy as np
import pytest
from mpi4py import MPI

from parisph.base.errors import ParisphError
from parisph.pressure.groups import isolated_rows
from tests import systems
from tests.digraphs import random_rows, to_csr

SELF = MPI.COMM_SELF


def flags(n, *marked):
    anchored = np.zeros(n, bool)
    anchored[list(marked)] = True
    return anchored


def find(columns, *marked):
    return isolated_rows(SELF, 0, *to_csr(columns), flags(len(columns), *marked))[0].tolist()


TWO = [[0, 1], [1, 0, 2], [2, 1], [3, 4], [4, 3]]
# The row of wall 0 contains fluid 1 and 2, but their rows do not contain it, so its anchor does not help them.
ONE_WAY = [[0, 1, 2], [1, 2], [2, 1]]


@pytest.mark.parametrize("columns, marked, isolated", [
    (TWO, (2,), [False, False, False, True, True]), (TWO, (2, 3), [False] * 5), (TWO, (), [True] * 5),
    (ONE_WAY, (0,), [False, True, True]), (ONE_WAY, (2,), [False] * 3)])
def test_groups_without_an_anchor_to_which_an_entry_leads(columns, marked, isolated):
    assert find(columns, *marked) == isolated


def test_the_matrix_is_regular_exactly_when_no_row_is_isolated():
    rng = np.random.default_rng(4)
    seen = set()
    for seed in range(60):
        n = 12
        indptr, indices = random_rows(n, 2.0, seed)
        anchored = rng.random(n) < 0.25
        matrix = np.zeros((n, n))
        for i in range(n):
            for j in indices[indptr[i]:indptr[i + 1]]:
                if j != i:
                    matrix[i, j] -= 1.0
            matrix[i, i] = -matrix[i].sum() + anchored[i]
        regular = np.linalg.matrix_rank(matrix) == n
        isolated = isolated_rows(SELF, 0, indptr, indices, anchored)[0].any()
        assert regular == (not isolated)
        seen.add(regular)
    assert seen == {True, False}


def test_a_long_chain_in_bad_order_is_followed_to_its_end():
    # Sweeps alone would need hundreds of passes here.
    n = 3000
    order = np.random.default_rng(2).permutation(n)
    columns = [None] * n
    for here, there in zip(order[:-1], order[1:]):
        columns[here] = [here, there]
    columns[order[-1]] = [order[-1]]
    assert not any(find(columns, order[-1]))
    middle = find(columns, order[1000])
    assert [i for i in range(n) if middle[i]] == sorted(order[1001:])


def test_pressure_rows_of_an_open_and_a_closed_tank():
    _, fixed, indptr, indices, _ = systems.square(20)
    assert not isolated_rows(SELF, 0, indptr, indices, fixed)[0].any()
    _, fixed, indptr, indices, _ = systems.square(20, closed=True)
    assert isolated_rows(SELF, 0, indptr, indices, fixed)[0].all()


def test_no_rows_at_all():
    nothing = np.zeros(0, np.int32)
    assert isolated_rows(SELF, 0, np.zeros(1, np.int32), nothing, np.zeros(0, bool))[0].shape == (0,)


def test_input_is_left_alone():
    anchored = flags(3, 0)
    indptr, indices = to_csr([[0], [1, 0], [2, 1]])
    isolated_rows(SELF, 0, indptr, indices, anchored)
    assert anchored.tolist() == [True, False, False]


def test_flags_that_do_not_fit_are_refused():
    indptr, indices = to_csr([[0], [1]])
    with pytest.raises(ParisphError, match="3 anchored flags"):
        isolated_rows(SELF, 0, indptr, indices, flags(3))
