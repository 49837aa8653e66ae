"""The pressure solve on one rank: answers, kept preconditioner, fallback chain, closed domains."""


import numpy as np
import pytest
from mpi4py import MPI
from petsc4py import PETSc

from parisph.base.errors import ParisphError, SolverDiverged
from parisph.pressure import options as opts
from parisph.pressure.solver import LASTING, LOOSEST
from tests import systems

SELF = MPI.COMM_SELF


@pytest.fixture
def make():
    with systems.solvers(SELF) as new:
        yield new


def wave(x):
    return np.cos(np.pi * x[:, 0]) * np.cos(0.5 * np.pi * x[:, 1])


def problem(n=25, **kind):
    """Return (rows, p, b): CSR rows of the unit square, a pressure, and b = A p."""
    x, _, *rows = systems.square(n, **kind)
    p = wave(x)
    return rows, p, systems.product(rows, p)


def zero(p):
    return np.zeros_like(p)


# -- answers --------------------------------------------------------------------------------------


@pytest.mark.parametrize("rtol", [1e-4, 1e-6, 1e-10])
def test_solution_to_the_tolerance(make, rtol):
    rows, p, b = problem()
    found, record = make(rtol=rtol).solve(*rows, b, zero(p))
    true = np.linalg.norm(b - systems.product(rows, found)) / np.linalg.norm(b)
    assert true <= rtol
    assert record.residual == pytest.approx(true, rel=1e-3)
    assert record.residual > 1e-3 * rtol, "solved much further than asked: the tolerance is not in use"
    assert record.reason > 0 and record.fallback == "" and record.rebuilt
    assert 3 <= record.iterations <= 30
    assert record.setup_seconds > 0.0 and record.solve_seconds > 0.0


def test_multigrid_above_the_size_where_it_pays(make):
    rows, p, b = problem(90)
    assert len(p) > opts.SMALL
    solver = make(rtol=1e-8)
    found, record = solver.solve(*rows, b, zero(p))
    assert solver.options["pressure_pc_type"] == "hypre"
    assert record.iterations <= 30 and np.abs(found - p).max() < 1e-5
    small = make()
    small.solve(*problem(10)[0], *problem(10)[1:])
    assert small.options["pressure_pc_type"] == "ilu"


def test_columns_of_a_row_in_any_order(make):
    rows, p, b = problem()
    rng = np.random.default_rng(0)
    indptr, indices, values = rows[0], rows[1].copy(), rows[2].copy()
    for first, last in zip(indptr[:-1], indptr[1:]):
        order = first + rng.permutation(last - first)
        indices[first:last], values[first:last] = indices[order], values[order]
    found, record = make(rtol=1e-10).solve(indptr.astype(np.int64), indices.astype(np.int64), values, b, zero(p))
    assert np.abs(found - p).max() < 1e-8 and record.fallback == ""


def test_vectors_are_left_alone_rows_are_only_sorted_and_results_are_new(make):
    rows, p, b = problem()
    product = systems.product(rows, p)
    arguments = [*rows, b, 0.5 * p]
    before = [a.copy() for a in arguments[3:]]
    solver = make(rtol=1e-10)
    first, _ = solver.solve(*arguments)
    kept = first.copy()
    solver.solve_again(2.0 * b, None)
    for a, c in zip(arguments[3:], before):
        np.testing.assert_array_equal(a, c)
    np.testing.assert_allclose(systems.product(rows, p), product, atol=1e-13 * np.abs(product).max())
    np.testing.assert_array_equal(first, kept)


def test_exact_start_needs_no_iteration_and_a_good_one_fewer(make):
    rows, p, b = problem(40)
    solver = make()
    counts = [solver.solve(*rows, b, start)[1].iterations for start in (p, p * (1 + 1e-4), zero(p))]
    assert counts[0] == 0 and counts[0] < counts[1] < counts[2]


def test_a_start_worse_than_zero_is_dropped(make):
    rows, p, b = problem()
    solver = make(rtol=1e-8)
    cold = solver.solve(*rows, b, None)[1].iterations
    wild = 1e12 * np.random.default_rng(0).standard_normal(p.size)
    found, record = solver.solve(*rows, b, wild)
    assert record.iterations == cold and record.fallback == ""
    assert np.abs(found - p).max() < 1e-6


def test_zero_right_hand_side_gives_zero_without_a_solve(make):
    rows, p, b = problem()
    found, record = make().solve(*rows, zero(p), p)
    assert not found.any() and (record.reason, record.iterations, record.residual) == (0, 0, 0.0)
    assert not record.rebuilt


# -- the same matrix again --------------------------------------------------------------------------


def test_second_right_hand_side_uses_the_same_preconditioner(make):
    rows, p, b = problem()
    solver = make(rtol=1e-10)
    solver.solve(*rows, b, None)
    other = np.sin(7.0 * np.arange(p.size))
    # The scale differs much: a norm remembered from the first right-hand side would end this at once.
    found, record = solver.solve_again(1e-6 * systems.product(rows, other), None)
    assert np.abs(found - 1e-6 * other).max() < 1e-13
    assert solver.setups == 1 and not record.rebuilt


def test_second_right_hand_side_to_a_looser_tolerance(make):
    rows, p, b = problem()
    solver = make(rtol=1e-10)
    first = solver.solve(*rows, b, None)[1]
    loose = solver.solve_again(b, None, slack=1e6)[1]
    assert 1e-8 < loose.residual < 1e-3 and loose.iterations < 0.7 * first.iterations
    # and only that one
    assert solver.solve_again(b, None)[1].residual < 1e-9 and solver.solve(*rows, b, None)[1].residual < 1e-9


@pytest.mark.parametrize("rtol", [1e-5, 1e-2, 0.3])
def test_slack_never_asks_for_nothing(make, rtol):
    rows, p, b = problem()
    solver = make(rtol=rtol)
    solver.solve(*rows, b, None)
    assert solver.solve_again(b, None, slack=1e3)[1].residual <= max(rtol, LOOSEST)


def test_second_right_hand_side_belongs_to_the_new_matrix(make):
    solver = make(rtol=1e-10)
    solver.solve(*problem()[0], *problem()[1:])
    rows, p, _ = problem(scatter=0.3)
    solver.solve(*rows, zero(p), None)  # nothing to solve, but the matrix is the one to use
    found, _ = solver.solve_again(systems.product(rows, p), None)
    assert np.abs(found - p).max() < 1e-8


def test_solve_again_before_solve_is_refused(make):
    with pytest.raises(ParisphError, match="call solve first"):
        make().solve_again(np.ones(3), None)


# -- the kept preconditioner --------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["ilu", "hypre", "gamg", "asm", "lu"])
def test_preconditioner_is_kept_while_the_pattern_changes(make, kind):
    solver = make("-pressure_pc_type", kind)
    rows, p, b = problem()
    solver.solve(*rows, b, None)
    probe = PETSc.Vec().createWithArray(np.sin(np.arange(p.size) ** 2.0), comm=PETSc.COMM_SELF)
    answers = []
    for seed in range(4):
        x, _, *moved = systems.square(25, scatter=0.1 * seed)
        assert seed == 0 or moved[1].size != rows[1].size, "the pattern should differ"
        found, record = solver.solve(*moved, systems.product(moved, p), None)
        assert not record.rebuilt and np.abs(found - p).max() < 1e-3
        out = probe.duplicate()
        solver._ksp.getPC().apply(probe, out)
        answers.append(out.array.copy())
    assert solver.setups == 1
    for answer in answers[1:]:
        np.testing.assert_array_equal(answer, answers[0])


def test_preconditioner_is_rebuilt_when_rows_are_renumbered(make):
    rows, p, b = problem()
    solver = make()
    solver.solve(*rows, b, None)
    _, record = solver.solve(*rows, b, None, renumbered=True)
    assert record.rebuilt and solver.setups == 2 and record.fallback == ""


def test_preconditioner_is_made_cheaper_while_it_does_not_last(make):
    rows, p, b = problem()
    solver = make()
    levels = []
    for renumbered in [True, True, True, *[False] * (LASTING - 1), True, True]:
        solver.solve(*rows, b, None, renumbered=renumbered)
        levels.append(solver.options["pressure_pc_factor_levels"])
    assert levels == ["2", *["0"] * (LASTING + 1), "2", "0"]


def test_preconditioner_is_rebuilt_after_it_needed_many_iterations(make):
    rows, p, b = problem()
    solver = make()
    fresh = solver.solve(*rows, b, None)[1].iterations
    worse, _, _ = problem(scatter=1.5)
    rhs = systems.product(worse, p)
    slow = solver.solve(*worse, rhs, None)[1]
    assert slow.iterations > 1.5 * fresh + 2 and not slow.rebuilt and slow.fallback == ""
    again = solver.solve(*worse, rhs, None)[1]
    assert again.rebuilt and again.fallback == "" and again.iterations < slow.iterations
    assert not solver.solve(*worse, rhs, None)[1].rebuilt


def test_a_second_solve_keeps_what_the_next_matrix_will_rebuild(make):
    solver = make()
    rows, p, b = problem()
    solver.solve(*rows, b, None)
    worse, _, _ = problem(scatter=1.5)
    rhs = systems.product(worse, p)
    solver.solve(*worse, rhs, None)
    found, second = solver.solve_again(0.5 * rhs, None)
    assert not second.rebuilt and np.abs(found - 0.5 * p).max() < 1e-3
    assert solver.solve(*worse, rhs, None)[1].rebuilt and solver.setups == 2


def test_preconditioner_is_cheap_where_it_wears_out_though_rows_keep_their_numbers(make):
    solver = make()
    levels = []
    for scatter in (0.0, 1.5, 0.0, 1.5, 0.0, 1.5):
        rows, p, _ = problem(scatter=scatter)
        solver.solve(*rows, systems.product(rows, p), None)
    assert 1 < solver.setups
    rows, _, b = problem()
    for renumbered in (True, *[False] * (LASTING - 1), True):
        solver.solve(*rows, b, None, renumbered=renumbered)
        levels.append(solver.options["pressure_pc_factor_levels"])
    assert levels == [*["0"] * LASTING, "2"]


def test_number_of_rows_may_change(make):
    solver = make(rtol=1e-10)
    for n in (12, 20, 8):
        rows, p, b = problem(n)
        found, record = solver.solve(*rows, b, None)
        assert record.rebuilt and np.abs(found - p).max() < 1e-8


# -- the fallback chain -------------------------------------------------------------------------------

def test_kept_fails_and_rebuilt_succeeds(make):
    rows, p, b = problem()
    solver = make("-pressure_ksp_max_it", "12", rtol=1e-6)
    solver.solve(*rows, b, None)
    worse, _, _ = problem(scatter=1.5)
    found, record = solver.solve(*worse, systems.product(worse, p), None)
    assert record.fallback == "rebuilt" and record.rebuilt and solver.setups == 2
    assert record.iterations > 12, "iterations of the failed attempt count"
    assert np.abs(found - p).max() < 1e-3
    assert not solver.solve(*worse, b, None)[1].rebuilt, "the rebuilt one is kept in its turn"


@systems.chain
@pytest.mark.parametrize("closed", [False, True])
def test_each_stage_of_the_chain_is_reached(make, words, expected, closed):
    rows, p, b = problem(20, closed=closed)
    solver = make(*words, rtol=1e-8, closed=closed)
    found, record = solver.solve(*rows, b, None)
    assert record.fallback == expected and record.rebuilt and record.reason > 0 and record.residual <= 1e-7
    assert np.abs(found - (p - p.mean() if closed else p)).max() < 1e-4
    again = solver.solve(*rows, b, None)[1]
    assert again.iterations == record.iterations, "a preconditioner that failed is not tried again before it is rebuilt"


def hostile(n=300):
    """A regular matrix far from an M-matrix: random entries of both signs."""
    rng = np.random.default_rng(5)
    columns = [np.unique(np.append(rng.integers(0, n, 12), i)) for i in range(n)]
    indptr = np.concatenate([[0], np.cumsum([c.size for c in columns])]).astype(np.int32)
    indices = np.concatenate(columns).astype(np.int32)
    return indptr, indices, rng.standard_normal(indices.size)


def test_a_matrix_that_only_a_direct_solver_masters(make):
    rows = hostile()
    p = np.sin(np.arange(300.0))
    found, record = make().solve(*rows, systems.product(rows, p), None)
    assert record.fallback == "lu" and np.abs(found - p).max() < 1e-3


@pytest.mark.parametrize(("words", "iterations"), [
    ("-pressure_ksp_max_it 2", 2),
    ("-pressure_ksp_type richardson -pressure_ksp_richardson_scale 1e9 -pressure_pc_type none "
     "-pressure_ksp_divtol 1e300 -pressure_ksp_max_it 60", 60),
])
def test_claimed_convergence_is_not_believed_and_an_attempt_that_ends_in_nan_leaves_no_trace(make, words, iterations):
    rows, p, b = problem()
    found, record = make("-pressure_ksp_norm_type", "none", *words.split()).solve(*rows, b, None)
    assert record.fallback == "gamg" and record.residual <= 1e-5 and record.iterations > iterations
    assert np.abs(found - p).max() < 1e-3


def test_a_singular_system_without_solution_is_told_in_words(make):
    rows, p, _ = problem(12, closed=True)
    with pytest.raises(SolverDiverged) as caught:
        make().solve(*rows, np.ones(p.size), None)
    text = str(caught.value)
    for word in (f"{p.size} unknowns", "1e-06", "multigrid of PETSc", "incomplete factors", "direct factors",
                 "iterations, residual", "free surface"):
        assert word in text


@pytest.mark.parametrize("columns", [[0, 1, 1, 2, 0], [0, 1, 1, 2, 2]])
def test_rows_without_diagonal_entry_are_refused(make, columns):
    values = np.array([1.0, 1.0, 1.0, 1.0, 0.0])
    with pytest.raises(SolverDiverged, match="1 rows of the pressure equation have no diagonal entry"):
        make().solve(np.array([0, 2, 4, 5]), np.array(columns), values, np.ones(3), None)


def test_the_solver_lives_on_after_a_failure(make):
    rows, p, b = problem()
    singular, q, _ = problem(closed=True)
    solver = make(rtol=1e-8)
    for _ in range(2):
        with pytest.raises(SolverDiverged):
            solver.solve(*singular, np.ones(q.size), None)
        found, record = solver.solve(*rows, b, None)
        assert np.abs(found - p).max() < 1e-5 and record.fallback == ""


# -- bad input ----------------------------------------------------------------------------------------


def bad(what):
    rows, p, b = problem(10)
    arrays = {"indptr": rows[0], "indices": rows[1], "values": rows[2], "rhs": b, "guess": zero(p)}
    what(arrays)
    return arrays


def put(name, place, value):
    def change(arrays):
        arrays[name] = arrays[name].copy()
        arrays[name][place] = value
    return change


def shorten(name):
    def change(arrays):
        arrays[name] = arrays[name][:-1]
    return change


@pytest.mark.parametrize("change, kind, message", [
    (put("values", 30, np.nan), SolverDiverged, "matrix holds nan in owned row 2"),
    (put("rhs", 7, np.nan), SolverDiverged, "right-hand side of the pressure equation holds nan in owned row 7"),
    (put("rhs", 7, np.inf), SolverDiverged, "holds inf in owned row 7"),
    (put("guess", 5, np.nan), SolverDiverged, "guess of the pressure equation holds nan in owned row 5"),
    (put("indices", 3, 10_000), ParisphError, "column .* 10000 of 121"),
    (put("indices", 3, -1), ParisphError, "column -1"),
    (shorten("rhs"), ParisphError, "do not fit together"),
    (shorten("guess"), ParisphError, "guess .* shape"),
    (shorten("values"), ParisphError, "do not fit together"),
    (shorten("indptr"), ParisphError, "do not fit together"),
    (put("indptr", 5, 10_000), ParisphError, "not a CSR matrix"),
])
def test_bad_arrays_are_refused_with_their_place(make, change, kind, message):
    assert systems.square(10)[2][2] <= 30 < systems.square(10)[2][3]
    with pytest.raises(kind, match=message):
        make().solve(**bad(change))


def test_large_finite_values_are_not_taken_for_infinite(make):
    rows, p, b = problem(10)
    found, _ = make(rtol=1e-8).solve(rows[0], rows[1], 1e200 * rows[2], 1e100 * b, None)
    np.testing.assert_allclose(1e100 * found, p, atol=1e-6)


# -- closed domains -----------------------------------------------------------------------------------


@pytest.mark.parametrize("words", [(), ("-pressure_pc_type", "hypre"), ("-pressure_pc_type", "lu"),
                                   ("-pressure_pc_type", "gamg")])
def test_closed_domain_with_sources_that_add_up(make, words):
    rows, p, b = problem(30, closed=True)
    found, record = make(*words, rtol=1e-9, closed=True).solve(*rows, b, None)
    assert record.fallback == "" and record.residual <= 1e-9
    assert np.abs(found - (p - p.mean())).max() < 1e-5
    assert abs(found.mean()) < 1e-12


def test_closed_domain_with_sources_that_do_not_add_up(make):
    rows, p, b = problem(30, closed=True)
    matrix = np.zeros((p.size, p.size))
    for i in range(p.size):
        np.add.at(matrix[i], rows[1][rows[0][i]:rows[0][i + 1]], rows[2][rows[0][i]:rows[0][i + 1]])
    left = np.linalg.svd(matrix)[0][:, -1]
    assert np.abs(left / left.mean() - 1.0).max() > 0.5, "the left null vector is not the constant"
    rhs = b + 0.1 * np.sin(5.0 * np.arange(p.size))
    found, record = make(rtol=1e-10, closed=True).solve(*rows, rhs, None)
    defect = rhs - systems.product(rows, found)
    assert record.fallback == "" and abs(found.mean()) < 1e-12
    # What remains is one constant, and it is the one that the left null vector demands.
    np.testing.assert_allclose(defect, left @ rhs / left.sum(), atol=1e-7)
    assert np.abs(defect).min() > 1e-5


def test_closed_domain_that_is_not_singular_is_solved_as_it_is(make):
    rows, p, b = problem()
    found, _ = make(rtol=1e-10, closed=True).solve(*rows, b, None)
    assert np.abs(found - p).max() < 1e-8


def test_closed_domain_with_particles_that_take_no_part(make):
    # Two identity rows, in no other row, before and after: the null vector is zero there.
    rows, p, b = problem(20, closed=True)
    n = p.size
    indptr = np.concatenate([[0], rows[0] + 1, [rows[0][-1] + 2]])
    indices = np.concatenate([[0], rows[1] + 1, [n + 1]])
    values = np.concatenate([[1.0], rows[2], [1.0]])
    found, record = make(rtol=1e-10, closed=True).solve(indptr, indices, values, np.concatenate([[3.0], b, [0.0]]),
                                                        None)
    assert record.fallback == "" and found[0] == pytest.approx(3.0) and found[-1] == pytest.approx(0.0, abs=1e-9)
    assert np.abs(found[1:-1] - (p - p.mean())).max() < 1e-5


def test_closed_domain_with_a_constant_right_hand_side_is_at_rest(make):
    rows, p, _ = problem(20, closed=True)
    found, record = make(closed=True).solve(*rows, np.full(p.size, 0.3), None)
    assert not found.any() and record.iterations == 0


# -- memory -------------------------------------------------------------------------------------------


@systems.needs_proc
@pytest.mark.parametrize("closed, count", [(False, 2000), (True, 600)])
def test_memory_is_flat(make, closed, count):
    systems_in_turn = [problem(22, scatter=0.1 * k, closed=closed) for k in range(3)]
    solver = make(closed=closed)

    def steps(count):
        for k in range(count):
            rows, p, b = systems_in_turn[k % 3]
            solver.solve(*rows, b, p, renumbered=k % 10 == 0)
            solver.solve_again(b, None)

    steps(200)
    before = systems.resident()
    steps(count)
    assert systems.resident() - before < 2000, "kB; one vector kept a step would be 4 kB each, a matrix 130 kB"


@systems.needs_proc
def test_memory_is_flat_through_the_chain(make):
    rows, p, b = problem(22)
    solver = make(*systems.failing("", "gamg_"))

    def steps(count):
        for _ in range(count):
            assert solver.solve(*rows, b, None)[1].fallback == "asm"

    steps(40)
    before = systems.resident()
    steps(200)
    assert systems.resident() - before < 2000, "kB; one Krylov solver kept a step would be hundreds each"
