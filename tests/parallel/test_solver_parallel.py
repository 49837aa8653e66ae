"""The pressure solve on several ranks: same answer, empty ranks, errors and fallbacks on all."""

import gc
import os
import weakref

import numpy as np
import pytest
from mpi4py import MPI

from parisph.base.errors import ParisphError, SolverDiverged
from parisph.pressure import options as opts
from parisph.pressure.solver import PressureSolver
from tests import systems

BUSY = {"all": None, "one": 1}  # how many ranks have rows; the last ones


@pytest.fixture
def make(comm):
    with systems.solvers(comm) as new:
        yield new


class Problem:
    """A manufactured Poisson problem, and this rank's part of it."""

    def __init__(self, comm, n=30, busy=None, **kind):
        x, _, *self.rows = systems.square(n, **kind)
        self.p = np.cos(np.pi * x[:, 0]) * np.cos(0.5 * np.pi * x[:, 1])
        self.b = systems.product(self.rows, self.p)
        first, last, *self._mine = systems.share(comm, self.rows, busy)
        self.part = slice(first, last)
        self.comm = comm

    @property
    def mine(self):
        """This rank's rows, for a solver to keep and rearrange."""
        return [array.copy() for array in self._mine]

    def solve(self, solver, rhs=None, guess=None, **more):
        rhs = self.b if rhs is None else rhs
        guess = None if guess is None else guess[self.part]
        return solver.solve(*self.mine, rhs[self.part], guess, **more)

    def whole(self, found):
        """Return the solution of all ranks in global order."""
        return np.concatenate(self.comm.allgather(found))


def same_everywhere(comm, record):
    """Return whether all ranks have the same record, seconds apart."""
    told = (record.reason, record.iterations, record.residual, record.fallback, record.rebuilt)
    return len(set(comm.allgather(told))) == 1


@pytest.mark.parametrize("busy", BUSY)
@pytest.mark.parametrize("kind", ["", "hypre", "gamg", "lu"])
def test_same_answer_on_any_number_of_ranks(comm, make, busy, kind):
    problem = Problem(comm, busy=BUSY[busy])
    solver = make(*(["-pressure_pc_type", kind] if kind else []), rtol=1e-12)
    found, record = problem.solve(solver)
    assert found.shape == problem.p[problem.part].shape
    assert np.abs(problem.whole(found) - problem.p).max() < 1e-9
    true = np.linalg.norm(problem.b - systems.product(problem.rows, problem.whole(found))) / np.linalg.norm(problem.b)
    assert record.residual == pytest.approx(true, rel=0.1, abs=1e-15) and record.residual <= 1e-11
    assert record.fallback == "" and same_everywhere(comm, record)


def test_default_preconditioner_goes_by_the_rows_of_all_ranks(comm, make):
    solver = make()
    Problem(comm, 10).solve(solver)
    assert solver.options["pressure_pc_type"] == ("ilu" if comm.size == 1 else "asm")
    large = Problem(comm, 90)
    assert large.p.size > opts.SMALL
    found, record = large.solve(solver, renumbered=True)
    assert solver.options["pressure_pc_type"] == "hypre" and record.iterations <= 27
    assert np.abs(large.whole(found) - large.p).max() < 1e-3


def test_preconditioner_is_kept_and_second_right_hand_side_solved(comm, make):
    solver = make(rtol=1e-10)
    for seed in range(3):
        problem = Problem(comm, scatter=0.1 * seed)
        found, record = problem.solve(solver)
        assert record.rebuilt == (seed == 0) and same_everywhere(comm, record)
        assert np.abs(problem.whole(found) - problem.p).max() < 1e-7
        again, record = solver.solve_again(1e-6 * problem.b[problem.part], None)
        assert np.abs(problem.whole(again) - 1e-6 * problem.p).max() < 1e-13 and not record.rebuilt
    assert solver.setups == 1


@pytest.mark.parametrize("closed", [False, True])
@pytest.mark.parametrize("words", [(), ("-pressure_pc_type", "hypre"), ("-pressure_pc_type", "bjacobi")])
def test_a_matrix_that_is_released_leaves_the_preconditioner(comm, make, words, closed):
    solver = make(*words, rtol=1e-8, closed=closed)
    for again in range(2):
        problem = Problem(comm, closed=closed, scatter=0.01 * again)
        mine = problem.mine
        values = weakref.ref(mine[2])
        found, record = solver.solve(*mine, problem.b[problem.part], None)
        del mine
        exact = problem.p - (problem.p.mean() if closed else 0.0)
        assert record.rebuilt == (again == 0) and record.fallback == ""
        assert np.abs(problem.whole(found) - exact).max() < 1e-5
        solver.release()
        solver.release()    # of nothing
        gc.collect()
        assert values() is None or (comm.size > 1 and "bjacobi" in words)    # which keeps a block of the first matrix
        with pytest.raises(ParisphError, match="needs a matrix: call solve first"):
            solver.solve_again(problem.b[problem.part], None)


def test_one_rank_that_renumbers_makes_all_rebuild(comm, make):
    problem, solver = Problem(comm), make()
    problem.solve(solver)
    _, record = problem.solve(solver, renumbered=comm.rank == comm.size - 1)
    assert record.rebuilt and solver.setups == 2


@pytest.mark.parametrize("told", [True, False])
def test_rows_may_move_between_ranks(comm, make, told):
    """A size that changes on some ranks needs no flag."""
    solver = make(rtol=1e-10)
    for busy in (None, 1, None):
        problem = Problem(comm, 20, busy=busy)
        found, record = problem.solve(solver, renumbered=told)
        assert np.abs(problem.whole(found) - problem.p).max() < 1e-8
        assert record.rebuilt or not told and comm.size == 1


@systems.chain
@pytest.mark.parametrize("busy", BUSY)
@pytest.mark.parametrize("closed", [False, True])
def test_each_stage_of_the_chain_is_reached(comm, make, words, expected, closed, busy):
    problem = Problem(comm, 20, closed=closed, busy=BUSY[busy])
    found, record = problem.solve(make(*words, rtol=1e-8, closed=closed))
    assert record.fallback == expected and same_everywhere(comm, record)
    exact = problem.p - (problem.p.mean() if closed else 0.0)
    assert np.abs(problem.whole(found) - exact).max() < 1e-4


def test_kept_fails_and_rebuilt_succeeds(comm, make):
    solver = make("-pressure_ksp_max_it", "17")
    Problem(comm).solve(solver)
    worse = Problem(comm, scatter=1.5)
    found, record = worse.solve(solver)
    assert record.fallback == "rebuilt" and same_everywhere(comm, record)
    assert np.abs(worse.whole(found) - worse.p).max() < 1e-3


@pytest.mark.parametrize("busy", BUSY)
@pytest.mark.parametrize("closed", [False, True])
def test_a_pressure_that_still_holds_stays_and_an_extrapolation_is_solved_closer(comm, make, closed, busy):
    problem = Problem(comm, 20, closed=closed, busy=BUSY[busy])
    exact = problem.p - (problem.p.mean() if closed else 0.0)
    wrong = np.sin(40.0 * np.arange(exact.size))
    wrong -= wrong.mean() if closed else 0.0
    unit = np.linalg.norm(problem.b) / np.linalg.norm(systems.product(problem.rows, wrong))
    far, near = (exact + residual * unit * wrong for residual in (1e-3, 0.9e-6))
    solver = make(rtol=1e-6, closed=closed)

    def solved(*guesses):
        return solver.solve(*problem.mine, problem.b[problem.part], np.stack(guesses)[:, problem.part])
    found, record = solved(near, exact)
    assert record.iterations == 0 and same_everywhere(comm, record)
    np.testing.assert_allclose(problem.whole(found), near, atol=1e-12)
    _, record = solved(far, near)
    assert record.iterations > 0 and record.residual < 1e-7 and same_everywhere(comm, record)


@pytest.mark.parametrize("busy", BUSY)
@pytest.mark.parametrize("kind", ["", "hypre"])
def test_closed_domain_has_one_answer(comm, make, kind, busy):
    # Sources that do not add up, columns of a nonsymmetric matrix: the answer must not depend on
    # the ranks, though the preconditioner does. One rank alone gives the reference.
    problem = Problem(comm, 25, closed=True, busy=BUSY[busy])
    rhs = problem.b + 0.1 * np.sin(5.0 * np.arange(problem.p.size))
    words = ["-pressure_pc_type", kind] if kind else []
    found, record = problem.solve(make(*words, rtol=1e-12, closed=True), rhs)
    whole = problem.whole(found)
    assert record.fallback == "" and abs(whole.mean()) < 1e-12 and same_everywhere(comm, record)
    alone = PressureSolver(MPI.COMM_SELF, ["-pressure_pc_type", "lu"], rtol=1e-12, closed=True)
    reference, _ = alone.solve(*problem.rows, rhs, None)
    alone.destroy()
    np.testing.assert_allclose(whole, reference, atol=1e-8)
    defect = rhs - systems.product(problem.rows, whole)
    assert np.ptp(defect) < 1e-8 and abs(defect.mean()) > 1e-5


def test_zero_right_hand_side(comm, make):
    problem = Problem(comm)
    found, record = problem.solve(make(), 0.0 * problem.b, problem.p)
    assert not found.any() and record.iterations == 0 and same_everywhere(comm, record)


# -- errors -----------------------------------------------------------------------------------------


def spoil(name):
    """Return a function that spoils one argument of solve."""
    def change(arguments):
        arguments[name] = arguments[name].copy()
        arguments[name][-1] = np.nan if arguments[name].dtype.kind == "f" else 10_000
    return change


def cut_short(arguments):
    arguments["rhs"] = arguments["rhs"][:-1]


@pytest.mark.parametrize("change, kind, message", [
    (spoil("values"), SolverDiverged, "matrix holds nan"),
    (spoil("rhs"), SolverDiverged, "right-hand side .* holds nan"),
    (spoil("guess"), SolverDiverged, "guess .* holds nan"),
    (spoil("indices"), ParisphError, "column .* 10000 of"),
    (cut_short, ParisphError, "do not fit together"),
])
@pytest.mark.parametrize("guilty", [0, -1])
def test_bad_input_on_one_rank_raises_on_all(comm, make, guilty, change, kind, message):
    problem = Problem(comm, 20)
    solver = make(rtol=1e-8)
    names = ("indptr", "indices", "values", "rhs", "guess")
    arguments = dict(zip(names, (*problem.mine, problem.b[problem.part], problem.p[problem.part])))
    if comm.rank == guilty % comm.size:
        change(arguments)
    with pytest.raises(kind, match=message) as caught:
        solver.solve(**arguments)
    if comm.size > 1:
        assert f"rank {guilty % comm.size}: " in str(caught.value)
    found, record = problem.solve(solver)
    assert np.abs(problem.whole(found) - problem.p).max() < 1e-5 and record.fallback == ""


def test_bad_second_right_hand_side_on_one_rank_raises_on_all(comm, make):
    problem = Problem(comm, 20)
    solver = make()
    problem.solve(solver)
    rhs = problem.b[problem.part].copy()
    if comm.rank == comm.size - 1:
        rhs[0] = np.inf
    with pytest.raises(SolverDiverged, match="holds inf in owned row 0"):
        solver.solve_again(rhs, None)


def test_a_system_without_solution_raises_on_all(comm, make):
    problem = Problem(comm, 12, closed=True)
    with pytest.raises(SolverDiverged, match="direct factors"):
        problem.solve(make(), np.ones(problem.p.size))


def test_a_missing_diagonal_on_one_rank_raises_on_all(comm, make):
    problem = Problem(comm, 12)
    indptr, indices, values = (a.copy() for a in problem.mine)
    if comm.rank == comm.size - 1:
        first = problem.part.start
        row = slice(indptr[4], indptr[5])
        indices[row][indices[row] == first + 4] = first + 5 if first + 5 not in indices[row] else first
    with pytest.raises(SolverDiverged, match="1 rows of the pressure equation have no diagonal"):
        make().solve(indptr, indices, values, problem.b[problem.part], None)


# -- memory -----------------------------------------------------------------------------------------


@systems.needs_proc
def test_memory_is_flat(comm, make):
    problems = [Problem(comm, 22, scatter=0.1 * k) for k in range(3)]
    solver = make()

    def steps(count):
        for k in range(count):
            problem = problems[k % 3]
            problem.solve(solver, renumbered=k % 10 == 0)
            solver.solve_again(problem.b[problem.part], None)

    steps(100)
    before = systems.resident()
    steps(250)
    assert systems.resident() - before < 2000, "kB; one matrix kept a step would be 40 kB each"
