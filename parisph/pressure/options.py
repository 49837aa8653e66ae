"""PETSc options of the pressure solve: defaults, and the user's options, which override them."""

import ctypes
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager

from mpi4py import MPI

from parisph.base.errors import CaseError
from parisph.parallel.petsc import PETSc

PREFIX = "pressure_"

# Up to this many unknowns on all ranks, incomplete factors beat algebraic multigrid. CPU
# milliseconds on one rank of set-up + one solve to 1e-6 (iterations) from zero, nonsymmetric 2D
# rows of 21 entries with a new pattern each time (so no part of an old set-up can be reused):
#     unknowns          529            961             3025            10000           29929
#     BoomerAMG   0.7 + 0.7 (11)  1.6 + 2.1 (12)  4.8 + 6.3 (14)   12 + 20 (14)    39 + 75 (17)
#     ILU(0)      0.6 + 0.3 (15)  1.1 + 0.9 (20)  3.3 + 4.7 (33)   11 + 46 (60)   38 + 215 (121)
#     ILU(1)      1.3 + 0.4 (10)  2.4 + 0.9 (12)  7.2 + 3.1 (19)   24 + 22 (34)   94 + 136 (59)
#     ILU(2)      2.2 + 0.4 (8)   4.1 + 0.8 (9)   13 + 3.7 (14)    40 + 21 (24)   160 + 106 (40)
#     LU          1.8 + 0.1       4.6 + 0.2       29 + 1.1
# In the first steps of a dam break (3840 unknowns, warm start, two solves a step) the whole step
# took: with new factors in each step ILU(1) 14 (15), ILU(2) 24 (10), BoomerAMG 19 (9); with factors
# kept while they worked ILU(1) 12.2 (20), ILU(2) 12.5 (14), BoomerAMG 14.6 (12), ILU(0) 13.8 (35).
# In violent flow, factors last for fewer matrices. CPU milliseconds of a whole step of the dam break with H/s = 80, one
# rank, solves to 1e-5, on a slower machine (iterations; matrices per set of factors):
#     t sqrt(g/H)      ILU(0)            ILU(1) or ILU(2), by the earlier rule
#     0.5 to 0.65      28.6 (18; 7.7)    32.1 (9; 4.8)
#     1.6 to 2.2       31.9 (17; 3.1)    33.3 (10; 2.8)
# By these times, factors with fill pay if they last for a dozen matrices (solver.LASTING). Hence no fill if they are
# rebuilt more often, two levels if they are kept, and multigrid for large systems, where the iterations of incomplete
# factors grow with the domain.
# On one rank, without fill, rows stay in their order along the Hilbert curve. RCM and the pattern of factors in its
# order take three times as long as the factors, and more than its fewer iterations save. Milliseconds a step of set-ups
# and solves by PETSc's log, same dam break, steps 400 to 700, two runs each (factors applied; made):
#     RCM, growth 1.3                       5.56 5.29 (5362; 108)
#     the curve's order, growth 1.3         4.17 5.02 (6712; 103)
#     the same, 1.0                         4.30 4.44 (6423; 127)
#     the same, 0.8                         4.48 4.02 (6045; 160)
# On two ranks, with the same order, growths of 1.3, 1.0 and 0.8 take the same time.
# These rows have 18 entries. With 32 entries, as of ISPH, an iteration costs more: a step takes the same time with RCM
# and in the curve's order, 35.5 and 36.0 ms, and RCM needs fewer iterations (15; 18).
SMALL, LONG = 6_000, 25    # unknowns; entries of a row above which RCM pays
# Rows in 3D have 70 entries, in 2D 37 at most. Fill is too dear then, and iterations grow as N^(1/3) only, so factors
# without fill serve larger systems. Milliseconds of set-up + solve, from 0 to 1e-5, rows of violent flow (iterations):
#     unknowns                     18,897            68,626
#     ILU(0), the curve's order    117 + 75 (24)     151 + 394 (34)
#     ILU(0), RCM                  139 + 72 (20)
#     ILU(1), RCM                  1029 + 78 (12)
#     BoomerAMG, Gauss-Seidel      73 + 116 (11)     364 + 485 (11)
#     BoomerAMG, Jacobi            70 + 80 (12)      309 + 272 (12)
SMALL_3D, ROW_3D = 60_000, 50    # unknowns of a rank; entries of a row above which it is one of 3D

# Least number of ranks with overlapping blocks of factors without fill. On fewer, blocks are of each rank's own rows,
# in their order along the Hilbert curve: overlapping blocks cost more to make and apply than their fewer iterations
# save. Milliseconds a step of the same dam break, two ranks, means of two runs, growth 1.5 (iterations; steps that
# build):
#     overlapping, with RCM    solve 6.7, regularise 6.0, in all 24.5 (9.0; 42 %)
#     own rows, with RCM       solve 5.2, regularise 6.1, in all 23.2 (11.2; 36 %)
#     own rows                 solve 4.5, regularise 5.9, in all 21.5 (12.8; 36 %)
# With growth 1.3, own rows take 21.0 and overlapping blocks 23.6 (12.5; 38 %). On four and eight ranks both take the
# same time; overlapping blocks need 8 iterations, own rows 14 and 16.
OVERLAPPING = 4

# Krylov methods with right preconditioning, whose monitored residual is the true one.
_RIGHT = {"gmres", "fgmres", "lgmres", "dgmres", "pgmres", "gcr", "bcgs", "fbcgs", "bcgsl", "tfqmr"}

_KRYLOV = {"ksp_type": "gmres", "ksp_gmres_restart": "50", "ksp_max_it": "100"}

# Aggressive coarsening with extended+i interpolation: the cheapest BoomerAMG for these
# nonsymmetric M-like rows, iterations flat from 1e4 to 1e6 unknowns.
_BOOMERAMG = {
    "pc_type": "hypre",
    "pc_hypre_type": "boomeramg",
    "pc_hypre_boomeramg_coarsen_type": "HMIS",
    "pc_hypre_boomeramg_interp_type": "ext+i",
    "pc_hypre_boomeramg_P_max": "4",
    "pc_hypre_boomeramg_agg_nl": "1",
    "pc_hypre_boomeramg_no_CF": None,
    "pc_hypre_boomeramg_strong_threshold": "0.25",
    # One sweep of Gauss-Seidel in each direction. hypre's default, a symmetric sweep in each, is for CG: twice the work
    # for 2 iterations less (1e5 unknowns: 1.98 against 1.58 us per unknown).
    "pc_hypre_boomeramg_relax_type_down": "SOR/Jacobi",
    "pc_hypre_boomeramg_relax_type_up": "backward-SOR/Jacobi",
}

# Cheaper sweeps for the long rows of 3D (see SMALL_3D).
_JACOBI = {f"pc_hypre_boomeramg_relax_type_{way}": "Jacobi" for way in ("down", "up")}

# Gaussian elimination on a (nearly) singular coarsest level amplifies rounding errors.
_BOOMERAMG_CLOSED = {"pc_hypre_boomeramg_relax_type_coarse": "symmetric-SOR/Jacobi"}

# Chebyshev smoothers, GAMG's own default, expect a symmetric matrix.
_GAMG = {"pc_type": "gamg", "mg_levels_ksp_type": "richardson", "mg_levels_pc_type": "sor"}


# Options of the iteration that users may set: a test of the value, and the valid range in words.
_LIMITS: dict[str, tuple[Callable[[float], bool], str]] = {
    "ksp_rtol": (lambda value: 0.0 <= value < 1.0, "a number of at least 0 and below 1, such as 1e-6"),
    "ksp_atol": (lambda value: 0.0 <= value < float("inf"), "a number of at least 0"),
    "ksp_divtol": (lambda value: value > 0.0, "a number above 0"),
    "ksp_max_it": (lambda value: value >= 0.0 and value.is_integer(), "a whole number of at least 0"),
}


def _incomplete(ranks: int, levels: int, long: bool = False) -> dict[str, str | None]:
    """Return options of ILU(levels) on one rank, of ILU blocks on more (see SMALL, LONG and OVERLAPPING).

    If a user sets another number of levels, the order of rows does not change.
    """
    factor = {"pc_factor_levels": str(levels), "pc_factor_mat_ordering_type": "rcm"}
    if ranks == 1:
        return {"pc_type": "ilu", **(factor if levels or long else {"pc_factor_levels": "0"})}
    if levels == 0 and ranks < OVERLAPPING:
        return {"pc_type": "bjacobi", "sub_pc_type": "ilu", "sub_pc_factor_levels": "0"}
    return {"pc_type": "asm", "pc_asm_overlap": "2", "sub_pc_type": "ilu",
            **{f"sub_{name}": value for name, value in factor.items()}}


def primary(rtol: float, closed: bool, ranks: int, unknowns: int, entries: int,
            lasting: bool = True) -> dict[str, str | None]:
    """Return the default options of the first attempt, name without prefix -> value or None.

    They depend on the user's `-pressure_pc_type` if it is set, else on the size of the system.

    Parameters
    ----------
    rtol, closed, ranks : as of PressureSolver
    unknowns, entries : int, rows and matrix entries on all ranks
    lasting : whether the preconditioner is expected to be kept for several matrices
    """
    kind, spatial = PETSc.Options(PREFIX).getString("pc_type", ""), entries > ROW_3D * unknowns
    if not kind:
        small = SMALL_3D * ranks if spatial else SMALL
        kind = "incomplete" if unknowns <= small else "hypre" if PETSc.Sys.hasExternalPackage("hypre") else "gamg"
    if kind == "incomplete":
        # Long rows produce more fill: with 37 entries per row, each level doubles the set-up time.
        levels = 0 if spatial else (1 + int(entries < 32 * unknowns)) * int(lasting)
        long = entries > LONG * unknowns and not spatial
        preconditioner: Mapping[str, str | None] = _incomplete(ranks, levels, long)
    elif kind == "hypre":
        preconditioner = dict(_BOOMERAMG, **(_JACOBI if spatial else {}), **(_BOOMERAMG_CLOSED if closed else {}))
    else:
        preconditioner = _GAMG if kind == "gamg" else {}  # the user's own
    return dict(_KRYLOV, ksp_rtol=repr(float(rtol)), **preconditioner)


def backup(stage: str, rtol: float, ranks: int) -> dict[str, str | None]:
    """Return the default options of a later attempt: "gamg", "asm" or "lu".

    Attempts differ in Krylov method and preconditioner, with growing cost and robustness.
    """
    krylov = {"ksp_type": "fgmres", "ksp_gmres_restart": "100", "ksp_rtol": repr(float(rtol))}
    if stage == "gamg":
        return dict(krylov, ksp_max_it="200", **_GAMG)
    if stage == "asm":
        return dict(krylov, ksp_max_it="500", **_incomplete(ranks, 3))
    return dict(krylov, ksp_max_it="20", pc_type="lu", **_direct(ranks))


def _direct(ranks: int) -> dict[str, str | None]:
    """Return options of the best direct solver of this PETSc."""
    if PETSc.Sys.hasExternalPackage("mumps"):
        # MUMPS then replaces null pivots, and solves a singular but consistent system.
        return {"pc_factor_mat_solver_type": "mumps", "mat_mumps_icntl_24": "1"}
    if ranks > 1 and PETSc.Sys.hasExternalPackage("superlu_dist"):
        return {"pc_factor_mat_solver_type": "superlu_dist"}
    return {"pc_factor_shift_type": "nonzero"}


@contextmanager
def defaults(prefix: str, options: Mapping[str, str | None]) -> Iterator[None]:
    """Add options that the user has not set to PETSc's database, and remove them afterwards.

    The database is global, with at most 512 entries, so defaults are in it only during configuration. Users' options
    never change.
    """
    database = PETSc.Options(prefix)
    ours = [name for name in options if not database.hasName(name)]
    for name in ours:
        database.setValue(name, options[name])
    try:
        yield
    finally:
        for name in ours:
            database.delValue(name)


def configured(comm: MPI.Comm, prefix: str, options: Mapping[str, str | None]) -> PETSc.KSP:
    """Return a new KSP with these options, overridden by the user's. Collective.

    Raises
    ------
    CaseError : PETSc rejects an option.
    """
    ksp = PETSc.KSP().create(comm)
    ksp.setOptionsPrefix(prefix)
    ksp.setInitialGuessNonzero(True)
    try:
        with defaults(prefix, options):
            ksp.setFromOptions()
    except PETSc.Error as error:
        ksp.destroy()
        raise CaseError(f"PETSc rejects an option of the pressure solve: {reason_of(error)}") from error
    given = PETSc.Options(prefix)
    if ksp.getType() in _RIGHT and not given.hasName("ksp_pc_side"):
        ksp.setPCSide(PETSc.PC.Side.RIGHT)
    if ksp.getType() in ("preonly", "none"):
        ksp.setInitialGuessNonzero(False)  # PETSc refuses the combination
    return ksp


def check_tolerances(prefix: str) -> None:
    """Check the tolerances and limits that the user gave under a prefix. Not collective.

    PETSc itself accepts any number, and fails later, in the middle of a run.

    Raises
    ------
    CaseError : a value is not a number or out of range; names the option, the value and the range.
    """
    given = PETSc.Options(prefix)
    for name, (fits, limits) in _LIMITS.items():
        if not given.hasName(name):
            continue
        text = given.getString(name, "")
        try:
            good = fits(float(text))
        except ValueError:
            good = text.lower() in ("default", "petsc_default")
        if not good:
            raise CaseError(f"option -{prefix}{name} = {text or 'nothing'}: must be {limits}; "
                            "give such a value, or leave the option out")


def reason_of(error: BaseException) -> str:
    """Return the last line of a PETSc error's message: the cause, without PETSc's call stack."""
    lines = [line for line in str(error).splitlines() if line.strip()]
    return lines[-1].strip() if lines else "no message"


class UserOptions:
    """The options that the user gave after `--`; they stay in PETSc's database until `withdraw`.

    Parameters
    ----------
    options : list of str or None, as on a command line: ["-pressure_ksp_rtol", "1e-8", "-pressure_ksp_view"].

    Raises
    ------
    CaseError : a word is neither an option nor a value, or a solver option has no prefix.
    """

    def __init__(self, options: Sequence[str] | None = None) -> None:
        self.given = _parse(options or [])
        database = PETSc.Options()
        before = database.getAll()
        self._before = {name: before.get(name) for name in self.given}
        for name, value in self.given.items():
            database.setValue(name, value)

    def unused(self) -> list[str]:
        """Return the options that PETSc has not used yet; none if that is unknown. Not collective.

        These are misspelled options, and those of unused solvers or preconditioners.
        """
        try:
            ask = ctypes.CDLL(PETSc.__file__).PetscOptionsUsed    # petsc4py lacks it
        except (OSError, AttributeError):
            return []
        found = ctypes.c_int()
        names = []
        for name in self.given:
            found.value = 1
            ask(None, name.encode(), ctypes.byref(found))
            if not found.value & 1:    # PETSc's bool may be a single byte
                names.append(name)
        return names

    def withdraw(self) -> None:
        """Restore PETSc's database."""
        database = PETSc.Options()
        for name, value in self._before.items():
            if value is None:
                database.delValue(name)
            else:
                database.setValue(name, value)
        self._before = {}


def as_text(options: Mapping[str, str | None]) -> str:
    """Return options, name -> value or None, as text for the command line after `--`."""
    words = (f"-{name}" if value is None else f"-{name} {value}" for name, value in options.items())
    return " ".join(words)


def _parse(words: Sequence[str]) -> dict[str, str | None]:
    given: dict[str, str | None] = {}
    name = None
    for word in words:
        if _is_name(word):
            name = word[1:]
            if name.startswith(("ksp_", "pc_")):
                raise CaseError(f"option {word} has no effect: options of the pressure solve "
                                f"have a prefix, write -{PREFIX}{name}")
            given[name] = None
        elif name is None or given[name] is not None:
            raise CaseError(f"'{word}' among the PETSc options is neither an option (-name) nor the value of an option")
        else:
            given[name] = word
    return given


def _is_name(word: str) -> bool:
    return len(word) > 1 and word[0] == "-" and not word[1].isdigit() and word[1] != "."
