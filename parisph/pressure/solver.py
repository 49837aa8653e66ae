"""The pressure equation A p = b: Krylov solve, kept preconditioner, fallback chain, record."""

from dataclasses import dataclass
from time import perf_counter

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

from parisph.base.errors import ParisphError, SolverDiverged, agree
from parisph.pressure import options as opts


@dataclass(frozen=True)
class SolveRecord:
    """What happened in one solve; the same on every rank but for the seconds.

    reason : PETSc's KSPConvergedReason of the last attempt (positive: converged)
    iterations : Krylov iterations, of all attempts together
    residual : true |b - A p| / |b|, computed after the solve
    setup_seconds, solve_seconds : matrix and preconditioner; Krylov iterations [s]
    fallback : "" or the attempt that succeeded after another failed
    rebuilt : the preconditioner was built anew for this solve
    """

    reason: int
    iterations: int
    residual: float
    setup_seconds: float
    solve_seconds: float
    fallback: str
    rebuilt: bool


class PressureSolver:
    """Solves one nonsymmetric system a step.

    Parameters
    ----------
    comm : mpi4py communicator
    options : list of str or None
        PETSc options of the user, prefix `pressure_`; they win over the defaults.
    rtol : float
        Relative tolerance on the true residual.
    closed : bool
        No free surface: A has the constant as its null vector.
    """

    def __init__(self, comm, options=None, rtol=1e-6, closed=False):
        self._comm = comm
        self._closed = closed
        self._user = opts.UserOptions(options)
        self._ksp = PETSc.KSP().create(comm)
        self._ksp.setOptionsPrefix(opts.PREFIX)
        with opts.defaults(opts.PREFIX, opts.primary(rtol, closed)):
            self._ksp.setFromOptions()
        opts.right_side(self._ksp)
        self._ksp.setInitialGuessNonzero(True)
        self._rtol = self._ksp.getTolerances()[0]
        self._matrix = None
        self._vectors = None

    def solve(self, indptr, indices, values, rhs, guess, renumbered=True, drift=0.0):
        """Return (p (n_owned,), SolveRecord). Collective."""
        start = perf_counter()
        n = len(rhs)
        if self._matrix is not None:
            self._matrix.destroy()
        if renumbered:
            self._ksp.reset()
        csr = [np.asarray(a, PETSc.IntType) for a in (indptr, indices)]
        self._matrix = PETSc.Mat().createAIJ(((n, None), (n, None)), csr=(*csr, values), comm=self._comm)
        self._ksp.setOperators(self._matrix)
        self._ksp.setUp()
        return self._run(rhs, guess, perf_counter() - start)

    def solve_again(self, rhs, guess):
        """Solve for another right-hand side with the same matrix. Collective."""
        return self._run(rhs, guess, 0.0)

    def _run(self, rhs, guess, setup):
        start = perf_counter()
        b = PETSc.Vec().createWithArray(np.array(rhs, float), comm=self._comm)
        x = PETSc.Vec().createWithArray(np.array(guess, float), comm=self._comm)
        self._ksp.solve(b, x)
        r = b.duplicate()
        self._matrix.mult(x, r)
        r.aypx(-1.0, b)
        residual = r.norm() / max(b.norm(), 1e-300)
        if not residual <= 10 * self._rtol:
            raise SolverDiverged(f"pressure solve failed: reason {self._ksp.reason}, residual {residual:.1e}")
        record = SolveRecord(self._ksp.reason, self._ksp.its, residual, setup, perf_counter() - start, "", True)
        return x.array.copy(), record

    def destroy(self):
        """Free the PETSc objects. Collective."""
        self._ksp.destroy()
        if self._matrix is not None:
            self._matrix.destroy()
        self._user.withdraw()
