"""The pressure equation A p = b: Krylov solve, kept preconditioner, fallback chain, record."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from time import perf_counter

import numpy as np
from mpi4py import MPI

from parisph.base.arrays import Array, Floats
from parisph.base.errors import CaseError, ParisphError, SolverDiverged, agree
from parisph.base.log import logger
from parisph.parallel.petsc import PETSc
from parisph.parallel.sums import sums
from parisph.pressure import options as opts
from parisph.pressure.row_checks import guess_fault, row_fault, vector_fault
from parisph.pressure.system import System

# A kept preconditioner that needs more than GROWTH x fresh + 2 iterations is rebuilt for the next matrix, not for a
# short second solve with the same one. `fresh` is its first number of iterations, at least FRESH, as a nearly exact
# start needs few. It is expected to last if earlier ones have lasted for LASTING matrices in the mean. Factors without
# fill take the time of a few iterations, on one rank, if rows keep their order, of two (see options). There, 99 % of
# the solves of the dam break with H/s = 80 take at most 24 iterations, where 30 are allowed.
GROWTH, GROWTH_WITHOUT_FILL, GROWTH_IN_ORDER, FRESH, LASTING = 1.5, 1.3, 1.0, 4, 12

# An attempt has failed if its true residual exceeds this many times the tolerance.
SLACK = 10.0
# The loosest tolerance for a second right-hand side.
LOOSEST = 1e-3

_BACKUPS = ("gamg", "asm", "lu")

_NAMES = {
    "fresh": "first method", "kept": "first method with the kept preconditioner", "rebuilt": "first method, rebuilt",
    "gamg": "multigrid of PETSc", "asm": "incomplete factors", "lu": "direct factors",
}

_Tried = tuple[str, int, int, float]    # an attempt: name, reason, iterations, residual
_REFUSED = -100
_REASONS = {
    _REFUSED: "PETSc refused", 1: "converged", 2: "converged", 3: "converged", 4: "iteration limit reached",
    5: "converged", -2: "no progress", -3: "too many iterations", -4: "residual grew without bound", -5: "breakdown",
    -6: "breakdown", -7: "method needs a symmetric matrix", -8: "indefinite preconditioner", -9: "not a number",
    -10: "indefinite matrix", -11: "preconditioner could not be built",
}


@dataclass(frozen=True)
class SolveRecord:
    """The record of one solve; the same on every rank, except for the seconds.

    reason : PETSc's KSPConvergedReason of the last attempt (positive: converged); 0 if b = 0, which needs no solve
    iterations : Krylov iterations of all attempts
    residual : true relative residual |b - A p| / |b| after the solve, in a closed domain |Q (b - A p)| / |Q b| (System)
    setup_seconds, solve_seconds : of matrix and preconditioner, and of Krylov iterations [s]
    fallback : the attempt that succeeded after others had failed ("rebuilt", "gamg", "asm", "lu"), else ""
    rebuilt : whether a preconditioner was built
    """

    reason: int
    iterations: int
    residual: float
    setup_seconds: float
    solve_seconds: float
    fallback: str
    rebuilt: bool


class PressureSolver:
    """Solves A p = b on all ranks, for one nonsymmetric matrix per step.

    Attempts are made in this order until one succeeds: the preconditioner kept from an earlier matrix; the same
    rebuilt; flexible GMRES with PETSc's multigrid ("gamg"), with overlapping incomplete factors ("asm"), with a direct
    factorisation ("lu"). An attempt fails if PETSc reports a failure (unless the true residual is within rtol), or if
    the true residual is above 10 rtol, or above 10 atol if the user set an absolute tolerance.

    Parameters
    ----------
    comm : mpi4py communicator
    options : list of str or None
        The user's PETSc options, as on a command line, with the prefix `pressure_`. These, and those in PETSC_OPTIONS,
        override the defaults. Later attempts have the prefixes `pressure_gamg_`, `pressure_asm_` and `pressure_lu_`.
    rtol : relative tolerance of the true residual
    closed : whether there is no free surface. p then has zero mean; for a singular A see System

    Attributes
    ----------
    options : dict, name -> value or None: the defaults, overridden by the user's options, and other options of the user
    setups : int, number of preconditioners built for first attempts

    Raises
    ------
    CaseError on all ranks: an option is invalid, or a tolerance is out of range.
    """

    def __init__(self, comm: MPI.Comm, options: Sequence[str] | None = None, rtol: float = 1e-6,
                 closed: bool = False) -> None:
        if not rtol > 0.0:
            raise ParisphError(f"relative tolerance {rtol} of the pressure solve must be positive")
        self.setups = 0
        self.options: dict[str, str | None] = {}
        self._comm = comm
        self._closed = closed
        self._wanted = rtol
        self._system = System(comm, closed)
        self._rows = -1             # of this rank, of the preconditioner
        self._total = 0
        self._matrices = 0          # since rows were renumbered
        self._setups = 0            # before that
        self._ksp: PETSc.KSP = None
        self._user = opts.UserOptions(options)
        self._unchecked = True      # until unused options are looked for
        try:
            for stage in ("", *_BACKUPS):
                opts.check_tolerances(f"{opts.PREFIX}{stage}_" if stage else opts.PREFIX)
            self._configure(0, 0)   # finds bad options, before the size is known
        except CaseError:
            self._user.withdraw()
            raise

    def solve(self, indptr: Array, indices: Array, values: Floats, rhs: Floats, guess: Floats | None,
              renumbered: bool = False) -> tuple[Floats, SolveRecord]:
        """Solve A p = b with a new matrix. Collective.

        Parameters
        ----------
        indptr : (n_owned + 1,) int, indices : (nnz,) int, values : (nnz,) float
            This rank's rows as CSR with global columns in any order; n_owned may be 0. The solver keeps the arrays
            until the next matrix or `release`, some preconditioners longer, and rearranges them: do not use them again.
        rhs : (n_owned,) float, b
        guess : (n_owned,) float, (k, n_owned) float or None, the initial guess (the previous pressure), or several: the
            first is taken if it solves the equation, else the best. None for zero. The same k on all ranks.
        renumbered : bool, whether row numbers have changed, on any rank, since the previous matrix

        Returns
        -------
        p : (n_owned,) float, a new array, in the unit of b over A
        record : SolveRecord

        Raises
        ------
        SolverDiverged on all ranks: a value is not finite, a row has no diagonal entry, or no
            attempt reached the tolerance.
        ParisphError on all ranks: array sizes do not match.
        """
        start = perf_counter()
        self._accept(indptr, indices, values, rhs, guess, renumbered)
        self._system.assemble(indptr, indices, values)
        self._current = False
        found = self._run("new", rhs, guess, start, self._rtol)
        if self._unchecked and found[1].rebuilt:    # a preconditioner reads its options when it is built
            self._warn_of_unused_options()
        return found

    def solve_again(self, rhs: Floats, guess: Floats | None, slack: float = 1.0) -> tuple[Floats, SolveRecord]:
        """Solve for another right-hand side with the matrix of the last `solve`. Collective.

        slack : factor of the tolerance of `solve`; the result is at most LOOSEST
        Other parameters, results and errors as in `solve`. ParisphError on all ranks also without a matrix: before
        `solve`, and after `release`.
        """
        start = perf_counter()
        if self._system.matrix is None:    # nothing to solve with
            agree(self._comm, ParisphError("solve_again needs a matrix: call solve first"))
        error = vector_fault("right-hand side", rhs, self._rows) or guess_fault(guess, self._rows)
        return self._run("again", rhs, guess, start, max(self._rtol, min(slack * self._rtol, LOOSEST)), error)

    def release(self) -> None:
        """Free the last matrix, so two never exist at once. Collective.

        The preconditioner stays, and some keep their matrix. `solve_again` is refused until the next `solve`.
        """
        self._system.drop_matrix()
        self._ksp.setOperators(None, None)

    def destroy(self) -> None:
        """Free the PETSc objects and restore the options database. Collective."""
        if self._ksp is not None:
            self._ksp.destroy()
            self._system.destroy()
            self._user.withdraw()
            self._ksp = None

    # -- before the solve ---------------------------------------------------------------------

    def _accept(self, indptr: Array, indices: Array, values: Floats, rhs: Floats, guess: Floats | None,
                renumbered: bool) -> None:
        """Check the local arrays, agree on the sizes, and decide if the preconditioner stays."""
        def fault(total: int) -> ParisphError | None:
            return (row_fault(indptr, indices, values, n, total) or vector_fault("right-hand side", rhs, n)
                    or guess_fault(guess, n))

        n = np.size(rhs)
        mine = bool(renumbered) or n != self._rows
        error = None if mine else fault(self._total)
        changed, total, entries, failed = sums(self._comm, mine, n, len(indices), error is not None)
        if changed or failed:    # check again, with the known size
            agree(self._comm, fault(total))
        if changed:
            # Make a new solver: PETSc's reset loses viewers and keeps the subdomains of the old rows.
            self._configure(total, entries)
            self._system.resize(n, total)
            self._rows, self._total, self._matrices = n, total, 0
        self._matrices += 1
        if changed or self._worn or not self._may_keep:
            self._usable = False

    def _warn_of_unused_options(self) -> None:
        """Warn once of options that are probably misspelled. Those of later attempts are not used yet."""
        self._unchecked = False
        later = tuple(f"{opts.PREFIX}{stage}_" for stage in _BACKUPS)
        names = [f"-{name}" for name in self._user.unused() if not name.startswith(later)]
        if names and self._comm.rank == 0:
            logger.warning(f"PETSc does not use {', '.join(names)}: misspelled, "
                           "or for another solver than the one in use (-pressure_ksp_view shows it)")

    def _configure(self, unknowns: int, entries: int) -> None:
        """Make the Krylov solver of the first attempt; its preconditioner depends on the size."""
        lasting = self._matrices >= LASTING * (self.setups - self._setups)
        self._chosen = opts.primary(self._wanted, self._closed, self._comm.size, unknowns, entries, lasting)
        without_fill = "0" in (self._chosen.get("pc_factor_levels"), self._chosen.get("sub_pc_factor_levels"))
        in_order = self._comm.size == 1 and "pc_factor_mat_ordering_type" not in self._chosen
        without = GROWTH_IN_ORDER if in_order else GROWTH_WITHOUT_FILL
        self._growth = without if without_fill else GROWTH
        ksp = opts.configured(self._comm, opts.PREFIX, self._chosen)
        if self._ksp is not None:
            self._ksp.destroy()
        self._ksp = ksp
        self._rtol, self._atol = ksp.getTolerances()[:2]
        given = PETSc.Options(opts.PREFIX)
        self._may_keep = given.getBool("ksp_reuse_preconditioner", True)
        ours = {opts.PREFIX + name: value for name, value in {**self._chosen, **given.getAll()}.items()}
        self.options = {**ours, **self._user.given}
        self._usable = False        # whether there is a preconditioner
        self._current = False       # whether it is of this matrix
        self._worn: bool = False    # whether the next matrix gets a new one
        self._setups = self.setups
        self._fresh: dict[str, int] = {}    # its first iterations, for each kind of solve

    # -- the solve ----------------------------------------------------------------------------

    def _run(self, kind: str, rhs: Floats, guess: Floats | None, start: float, goal: float,
             error: ParisphError | None = None) -> tuple[Floats, SolveRecord]:
        """Load the vectors and make attempts until one succeeds; return (p, SolveRecord).

        error : of this rank's vectors, or None.
        """
        system, self._goal = self._system, goal
        self._ksp.setTolerances(rtol=system.load(rhs, guess, error, goal))
        self._seconds = [perf_counter() - start, 0.0]
        if system.norm == 0.0:
            return np.zeros(np.size(rhs)), SolveRecord(0, 0, 0.0, self._seconds[0], 0.0, "", False)
        tried: list[_Tried] = []
        best, least = system.x.array.copy(), 1.0
        for name in self._attempts():
            reason, iterations = self._backup(name) if name in _BACKUPS else self._attempt(name)
            residual = float(system.residual())
            tried.append((name, reason, iterations, residual))
            if self._succeeded(reason, residual):
                break
            if residual < least:
                best, least = system.x.array.copy(), residual
            system.start_from(best)
        else:
            raise SolverDiverged(self._failure(tried))
        self._judge(kind, name, iterations)
        record = SolveRecord(reason, sum(t[2] for t in tried), residual, self._seconds[0], self._seconds[1],
                             name if len(tried) > 1 else "", any(t[0] != "kept" for t in tried))
        return system.solution(), record

    def _attempts(self) -> Iterator[str]:
        """Yield the names of the attempts, in their order."""
        if self._usable:
            yield "kept"
            if not self._current:
                yield "rebuilt"
        else:
            yield "fresh"
        yield from _BACKUPS

    def _attempt(self, name: str) -> tuple[int, int]:
        """Solve with the first attempt's method; return (reason, iterations). Collective."""
        def prepare() -> None:
            # The matrix and its pattern are new in each step. With this flag PETSc keeps the
            # preconditioner for any new operator, and frees the old matrix.
            self._ksp.getPC().setReusePreconditioner(name == "kept")
            self._ksp.setOperators(self._system.operator, self._system.preconditioned)
            if name != "kept":
                self._build()
        return self._timed(self._ksp, prepare)

    def _timed(self, ksp: PETSc.KSP, prepare: Callable[[], None]) -> tuple[int, int]:
        """Call `prepare()` and solve; return (reason, iterations). Adds to the seconds of both. Collective."""
        start = perf_counter()
        try:
            prepare()
            middle = perf_counter()
            self._seconds[0] += middle - start
            ksp.solve(self._system.b, self._system.x)
            self._seconds[1] += perf_counter() - middle
            return ksp.getConvergedReason(), ksp.getIterationNumber()
        except PETSc.Error:
            return _REFUSED, 0

    def _build(self) -> None:
        """Build the first attempt's preconditioner from the current matrix. Collective."""
        self.setups += 1
        self._usable = self._current = False
        # Blocks and levels read their options during set-up.
        with opts.defaults(opts.PREFIX, self._chosen):
            self._ksp.setUp()
            self._ksp.setUpOnBlocks()
        self._usable = self._current = True
        self._worn = False
        self._fresh = {}

    def _backup(self, stage: str) -> tuple[int, int]:
        """Solve with a later attempt; return (reason, iterations). Collective."""
        prefix = f"{opts.PREFIX}{stage}_"
        chosen = opts.backup(stage, self._goal, self._comm.size)
        start = perf_counter()
        ksp = opts.configured(self._comm, prefix, chosen)
        self._seconds[0] += perf_counter() - start

        def prepare() -> None:
            with opts.defaults(prefix, chosen):
                ksp.setOperators(self._system.operator, self._system.preconditioned)
                ksp.setUp()
                ksp.setUpOnBlocks()
        try:
            return self._timed(ksp, prepare)
        finally:
            ksp.destroy()

    # -- after the solve ----------------------------------------------------------------------

    def _succeeded(self, reason: int, residual: float) -> bool:
        """Return whether an attempt succeeded, by its true residual. NaN fails every comparison."""
        floor: float = self._atol / self._system.norm
        if reason > 0:
            return residual <= SLACK * max(self._goal, floor)
        return residual <= max(self._goal, floor)

    def _judge(self, kind: str, name: str, iterations: int) -> None:
        """Decide whether the next solve may keep the preconditioner."""
        if name in _BACKUPS:
            self._usable = False
            return
        fresh = self._fresh.setdefault(kind, iterations)
        if iterations > self._growth * max(fresh, FRESH) + 2:
            self._worn = True

    def _failure(self, tried: Sequence[_Tried]) -> str:
        """Return the message of a solve in which all attempts failed."""
        attempts = "".join(
            f"\n  {_NAMES[name]}: {_REASONS.get(reason, f'reason {reason}')} after {iterations} iterations, "
            f"residual {residual:.1e}" for name, reason, iterations, residual in tried)
        return (f"the pressure equation ({self._total} unknowns) could not be solved to a relative residual of "
                f"{self._goal:g}. Attempts:{attempts}\n  A frequent cause is a group of particles without contact "
                "with the free surface, or several particles in one place")
