"""PETSc options of the pressure solve: the user's override the defaults, which leave no trace."""

import sys

import pytest
from mpi4py import MPI
from petsc4py import PETSc

from parisph.base.errors import CaseError, ParisphError
from parisph.pressure import options as opts
from parisph.pressure.solver import PressureSolver
from tests import systems
from tests.launch import run

SELF = MPI.COMM_SELF


def database():
    return PETSc.Options().getAll()


@pytest.fixture
def make():
    with systems.solvers(SELF) as new:
        yield new


def solved(solver, n=20):
    x, _, *rows = systems.square(n)
    return solver.solve(*rows, systems.product(rows, x[:, 0] * 0 + x[:, 1] ** 2), None)[1]


def test_tolerance_of_the_user_wins(make):
    ours = solved(make(rtol=1e-4))
    theirs = solved(make("-pressure_ksp_rtol", "1e-11", rtol=1e-4))
    assert 1e-6 < ours.residual <= 1e-4 and theirs.residual <= 1e-10


def test_method_of_the_user_wins_and_takes_part_in_the_defaults(make):
    solver = make("-pressure_ksp_type", "bcgs", "-pressure_pc_type", "jacobi", "-pressure_ksp_max_it", "400")
    record = solved(solver)
    ksp = solver._ksp
    assert (ksp.getType(), ksp.getPC().getType()) == ("bcgs", "jacobi")
    assert ksp.getPCSide() == PETSc.PC.Side.RIGHT and record.fallback == ""
    assert solver.options["pressure_ksp_type"] == "bcgs"


def test_side_of_the_user_wins(make):
    solver = make("-pressure_ksp_pc_side", "left")
    assert solved(solver).fallback == "" and solver._ksp.getPCSide() == PETSc.PC.Side.LEFT


def test_a_direct_solver_of_the_user_wins(make):
    record = solved(make("-pressure_ksp_type", "preonly", "-pressure_pc_type", "lu"))
    assert record.iterations == 1 and record.residual < 1e-12 and record.fallback == ""


def test_detail_of_the_default_preconditioner_may_be_changed(make):
    plain = solved(make()).iterations
    solver = make("-pressure_pc_factor_levels", "0")
    assert solved(solver).iterations > plain
    assert solver._ksp.getPC().getType() == "ilu"


@pytest.mark.parametrize("unknowns, entries, ranks, lasting, expected", [
    (1000, 21_000, 1, True, {"pc_type": "ilu", "pc_factor_levels": "2"}),
    (1000, 21_000, 1, False, {"pc_type": "ilu", "pc_factor_levels": "0"}),
    (1000, 38_000, 1, True, {"pc_type": "ilu", "pc_factor_levels": "1"}),
    (1000, 38_000, 1, False, {"pc_type": "ilu", "pc_factor_levels": "0"}),
    (1000, 21_000, 4, True, {"pc_type": "asm", "sub_pc_type": "ilu", "sub_pc_factor_levels": "2"}),
    (1000, 21_000, 4, False, {"pc_type": "asm", "sub_pc_type": "ilu", "sub_pc_factor_levels": "0"}),
    (1000, 21_000, 2, True, {"pc_type": "asm", "sub_pc_type": "ilu", "sub_pc_factor_levels": "2"}),
    (1000, 21_000, 2, False, {"pc_type": "bjacobi", "sub_pc_type": "ilu", "sub_pc_factor_levels": "0"}),
    (100_000, 2_100_000, 4, True, {"pc_type": "hypre", "pc_hypre_boomeramg_relax_type_down": "SOR/Jacobi"}),
    (50_000, 3_500_000, 1, True, {"pc_type": "ilu", "pc_factor_levels": "0"}),
    (100_000, 7_000_000, 2, False, {"pc_type": "bjacobi", "sub_pc_type": "ilu", "sub_pc_factor_levels": "0"}),
    (100_000, 7_000_000, 1, True, {"pc_type": "hypre", "pc_hypre_boomeramg_relax_type_down": "Jacobi"}),
])
def test_default_preconditioner_goes_by_size_and_row_length(unknowns, entries, ranks, lasting, expected):
    chosen = opts.primary(1e-6, False, ranks, unknowns, entries, lasting)
    assert {name: chosen[name] for name in expected} == expected
    # along the curve, but for the long rows of 2D on one rank
    spatial = entries > opts.ROW_3D * unknowns
    short = spatial or entries <= opts.LONG * unknowns
    in_order = (spatial or not lasting) and (ranks < opts.OVERLAPPING if ranks > 1 else short)
    orders = {value for name, value in chosen.items() if name.endswith("ordering_type")}
    assert orders == (set() if in_order or expected["pc_type"] == "hypre" else {"rcm"})


def test_multigrid_of_the_user_gets_the_tuning(make):
    solver = make("-pressure_pc_type", "hypre")
    solved(solver)
    assert solver.options["pressure_pc_hypre_boomeramg_agg_nl"] == "1"
    assert "pressure_pc_factor_levels" not in solver.options


def test_the_user_may_forbid_to_keep_the_preconditioner(make):
    solver = make("-pressure_ksp_reuse_preconditioner", "false")
    assert [solved(solver).rebuilt for _ in range(3)] == [True] * 3


def test_a_later_attempt_can_be_steered_too(make):
    solver = make("-pressure_ksp_max_it", "1", "-pressure_gamg_pc_type", "lu", rtol=1e-8)
    record = solved(solver)
    assert record.fallback == "gamg" and record.residual < 1e-11


def warnings(caplog):
    return [record.getMessage() for record in caplog.records if record.levelname == "WARNING"]


def test_options_that_petsc_never_looks_for_are_named_once(make, caplog):
    solver = make("-pressure_ksp_typo", "3", "-pressure_ksp_rtol", "1e-5", "-pressure_pc_hypre_boomeramg_agg_nl", "2",
                  "-pressure_ksp_vieww")
    assert not warnings(caplog)
    for n in (10, 12):
        solved(solver, n)
    said, = warnings(caplog)
    assert "does not use -pressure_ksp_typo, -pressure_pc_hypre_boomeramg_agg_nl, -pressure_ksp_vieww:" in said


def test_options_that_take_effect_are_not_complained_of(make, caplog):
    solved(make("-pressure_ksp_rtol", "1e-5", "-pressure_ksp_type", "bcgs", "-pressure_pc_factor_levels", "0",
                "-pressure_ksp_reuse_preconditioner", "false", "-pressure_ksp_error_if_not_converged", "false",
                "-pressure_lu_pc_type", "svd"))
    assert not warnings(caplog)


def test_options_are_judged_only_after_a_solve_that_looked_for_them(make, caplog):
    solver, (x, _, *rows) = make("-pressure_pc_type", "asm", "-pressure_sub_pc_factor_levels", "2"), systems.square(20)
    solver.solve(*rows, 0.0 * x[:, 0], None)    # nothing to solve
    solved(solver)
    assert not warnings(caplog)


def test_options_leave_no_trace():
    before = database()
    solver = PressureSolver(SELF, ["-pressure_ksp_rtol", "1e-9", "-pressure_ksp_max_it", "1"])
    given = {"pressure_ksp_rtol": "1e-9", "pressure_ksp_max_it": "1"}
    assert database() == {**before, **given}
    for n in (12, 20):
        assert solved(solver, n).fallback == "gamg"
        assert database() == {**before, **given}
    solver.destroy()
    solver.destroy()
    assert database() == before


def test_options_given_before_are_put_back():
    PETSc.Options().setValue("pressure_ksp_rtol", "1e-3")
    try:
        PressureSolver(SELF, ["-pressure_ksp_rtol", "1e-9"]).destroy()
        assert database()["pressure_ksp_rtol"] == "1e-3"
    finally:
        PETSc.Options().delValue("pressure_ksp_rtol")


def test_many_solvers_do_not_fill_the_database():
    for _ in range(100):  # the database holds 512 options
        PressureSolver(SELF).destroy()
    solver = PressureSolver(SELF, ["-pressure_ksp_max_it", "7"])
    assert solver.options["pressure_ksp_max_it"] == "7"
    solver.destroy()


@pytest.mark.parametrize("words, message", [
    (["-ksp_rtol", "1e-8"], "write -pressure_ksp_rtol"), (["-pc_type", "lu"], "write -pressure_pc_type"),
    (["1e-8"], "'1e-8' among the PETSc options"),
    (["-pressure_ksp_rtol", "1e-8", "1e-9"], "'1e-9' among the PETSc options"),
    (["-pressure_ksp_type", "nonsense"], "PETSc rejects .*nonsense"),
    (["-pressure_pc_type", "nonsense"], "PETSc rejects .*nonsense"),
    (["-pressure_ksp_gmres_restart", "many"], "PETSc rejects"),
    (["-pressure_ksp_rtol"], "-pressure_ksp_rtol = nothing: must be"),
    *(([f"-pressure_{name}", value], f"-pressure_{name} = {value}: must be") for name, value in (
        ("ksp_rtol", "1"), ("ksp_rtol", "-2"), ("ksp_rtol", "nan"), ("ksp_rtol", "tight"), ("ksp_atol", "-1e-9"),
        ("ksp_divtol", "0"), ("ksp_max_it", "-1"), ("ksp_max_it", "inf"), ("lu_ksp_rtol", "2"))),
])
def test_options_that_cannot_be_meant_are_refused_before_any_work(words, message):
    before = database()
    with pytest.raises(CaseError, match=message):
        PressureSolver(SELF, words)
    assert database() == before


def test_negative_numbers_are_values(make):
    assert opts.UserOptions(["-pressure_x", "-1.5"]).given == {"pressure_x": "-1.5"}
    PETSc.Options().delValue("pressure_x")


@pytest.mark.parametrize("rtol", [0.0, -1.0, float("nan")])
def test_tolerance_must_be_positive(rtol):
    with pytest.raises(ParisphError, match="must be positive"):
        PressureSolver(SELF, rtol=rtol)


SCRIPT = """
from mpi4py import MPI
import numpy as np
from parisph.pressure.solver import PressureSolver
solver = PressureSolver(MPI.COMM_SELF, {words!r})
n = 50
indptr = np.arange(n + 1) * 2
indices = np.column_stack([np.arange(n), (np.arange(n) + 1) % n]).ravel()
values = np.tile([1.0, -0.5], n)
record = solver.solve(indptr, indices, values, np.ones(n), None)[1]
print("iterations", record.iterations, "restart", solver.options["pressure_ksp_gmres_restart"])
"""


def test_environment_variable_wins_over_us_and_the_command_line_over_it():
    settings = "-pressure_ksp_gmres_restart 7 -pressure_ksp_type fgmres"
    done = run([sys.executable, "-c", SCRIPT.format(words=[])], PETSC_OPTIONS=settings)
    assert "restart 7" in done.stdout, done.stderr
    done = run([sys.executable, "-c", SCRIPT.format(words=["-pressure_ksp_gmres_restart", "9"])],
               PETSC_OPTIONS=settings)
    assert "restart 9" in done.stdout, done.stderr


def test_ksp_view_prints_as_petsc_users_expect():
    done = run([sys.executable, "-c", SCRIPT.format(words=["-pressure_ksp_view"])])
    assert "KSP Object: (pressure_) 1 MPI process" in done.stdout, done.stderr
    assert "right preconditioning" in done.stdout and "restart=50" in done.stdout


def test_tolerances_at_their_limits_are_taken(make):
    assert solved(make("-pressure_ksp_rtol", "0", "-pressure_ksp_atol", "1e-6", "-pressure_ksp_divtol",
                       "1e9")).residual < 1e-3
