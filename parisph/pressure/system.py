"""A linear system on all ranks: matrix, right-hand side, initial guess, residual, null space."""

import numpy as np
from mpi4py import MPI

from parisph.base.arrays import Array, Flags, Floats
from parisph.base.errors import SolverDiverged, agree
from parisph.parallel.petsc import PETSc
from parisph.pressure.matrices import matrix_of

# If |A v| is below this fraction of the largest entry, v is a null vector.
_NULL = 1e-9

# Factor of the tolerance of a solve that starts from an extrapolation within the goal. Water at rest then moves as
# little as from the last pressure alone; with 3 in place of 10 it moves two to four times as fast.
CLOSER = 10.0


class System:
    """The PETSc objects of A p = b, reused while the sizes stay the same.

    Parameters
    ----------
    comm : mpi4py communicator
    closed : bool, whether no Dirichlet row is expected. If A has the null vector v (1 in every row, 0 in identity
        rows), the solved system is Q A p = Q b with Q = I - v v^T / v.v: A p = b up to a constant in all rows of v, the
        incompatible part of b. The left null vector w of nonsymmetric rows is not constant, so b minus its mean still
        has w.b != 0 and no solution. Q A p = Q b has a solution for every b (w.v != 0, as w > 0 for such rows). The
        solution with zero mean is returned. A regular matrix is solved unchanged.

    Attributes
    ----------
    b, x : PETSc.Vec, right-hand side and unknown
    matrix : PETSc.Mat, A
    operator : PETSc.Mat, the operator of the solve: A, or Q A
    preconditioned : PETSc.Mat, matrix of the preconditioner: A, or A with a doubled diagonal entry in one row, which
        makes it regular for factorisations and coarse solves
    norm : |b|, or |Q b|
    """

    def __init__(self, comm: MPI.Comm, closed: bool) -> None:
        self.comm = comm
        self.matrix: PETSc.Mat = None
        self.operator: PETSc.Mat = None
        self.preconditioned: PETSc.Mat = None
        self._null: PETSc.NullSpace = None
        self.b: PETSc.Vec = None
        self.x: PETSc.Vec = None
        self._r: PETSc.Vec = None
        self.norm = 0.0
        self._closed = closed

    def resize(self, n: int, total: int) -> None:
        """Prepare vectors for n rows of `total` on this rank. Collective."""
        self.destroy()
        self._sizes = ((n, total), (n, total))
        self._arrays = [np.zeros(n) for _ in range(3)]
        self.x, self.b, self._r = (
            PETSc.Vec().createWithArray(array, size=(n, total), comm=self.comm) for array in self._arrays)

    def assemble(self, indptr: Array, indices: Array, values: Floats) -> None:
        """Make the matrix from this rank's rows (global columns, any order). Collective.

        Rearranges and keeps the arrays, or copies if their types are not PETSc's.
        """
        self.drop_matrix()
        csr = (np.ascontiguousarray(indptr, PETSc.IntType), np.ascontiguousarray(indices, PETSc.IntType),
               np.ascontiguousarray(values, float))
        alone, largest = (np.diff(indptr) == 1, np.abs(csr[2]).max(initial=0.0)) if self._closed else (None, 0.0)
        self.matrix = matrix_of(self.x, *csr)
        self.operator = self.preconditioned = self.matrix
        self.matrix.getDiagonal(self._r)
        self._zeros = float(np.count_nonzero(self._arrays[2] == 0.0))
        if alone is not None:
            self._find_null_vector(alone, largest)

    def load(self, rhs: Floats, guess: Floats | None, error: Exception | None = None, goal: float = 0.0) -> float:
        """Set b and the initial guess, compute |b|, and return the tolerance of the solve. Collective.

        A guess whose residual is not below |b| is replaced by zero.

        Parameters
        ----------
        rhs : (n,)
        guess : (n,), None for zero, or (k, n), the last pressure and extrapolations: the first is taken if its residual
            is within the goal, else the one with the least; the same k on all ranks
        goal : of |b - A x| / |b|. A pressure that still solves the equation stays. An extrapolation is only a start: at
            rest it amplifies errors within the tolerance, which would move the water.
        error : error of rhs or guess on this rank, or None; it is raised on all ranks

        Returns
        -------
        the tolerance of the solve: the goal, or the goal / CLOSER if it starts from an extrapolation within the goal

        Raises
        ------
        SolverDiverged on all ranks: a diagonal entry is missing or zero (PETSc's incomplete factors may then read
            beyond the end of the row instead of failing).
        """
        b = self._arrays[1]
        many = 1 if guess is None or np.ndim(guess) == 1 else len(guess)    # the same on all ranks
        guesses = np.zeros((many, len(b)))
        if error is not None:
            rhs = np.zeros_like(b)
        elif guess is not None:
            guesses[:] = guess
        b[:] = rhs
        self._touch(self.b)
        if self._null:
            self._null.remove(self.b)
        bb, given, zeros, failed, *left = self.sum(float(b @ b), float(rhs @ rhs), self._zeros, error is not None,
                                                   *(self._missing(one) for one in guesses))
        if failed:
            agree(self.comm, error)
        if zeros:
            raise SolverDiverged(f"{zeros:.0f} rows of the pressure equation have no diagonal entry")
        self.norm = np.sqrt(bb) if bb > 1e-28 * given else 0.0
        enough = goal * goal * bb
        best = 0 if left[0] <= enough else left.index(min(left))
        if not left[best] < bb:
            self.start_from(0.0)
        elif best < len(left) - 1:    # the last one is already in x
            self._begin(guesses[best])
        return goal / CLOSER if best > 0 and left[best] <= enough else goal

    def _begin(self, guess: Floats) -> None:
        self.start_from(guess)
        if self._null:
            self._null.remove(self.x)

    def _missing(self, guess: Floats) -> float:
        """Return this rank's part of |b - A x|^2 for a guess (n,), which stays in x. Collective."""
        self._begin(guess)
        return self._square()

    def _square(self) -> float:
        """Return this rank's part of |b - A x|^2 of the current x. Collective."""
        _, b, r = self._arrays
        self.operator.mult(self.x, self._r)
        np.subtract(b, r, out=r)
        return float(r @ r)

    def start_from(self, values: Floats | float) -> None:
        """Set the initial guess to an array of owned values, or to one value."""
        self._arrays[0][:] = values
        self._touch(self.x)

    def residual(self) -> float:
        """Return |b - A x| / |b| of the current x (with Q in a closed domain). Collective."""
        return float(np.sqrt(self.sum(self._square())[0])) / self.norm

    def solution(self) -> Floats:
        """Return a copy of the owned part of x, with zero mean in a closed domain. Collective."""
        if self._null:
            self._null.remove(self.x)
        return self._arrays[0].copy()

    def sum(self, *local: float) -> Floats:
        """Return the sums of numbers over the ranks. Collective."""
        numbers = np.array(local, float)
        if self.comm.size > 1:
            self.comm.Allreduce(MPI.IN_PLACE, numbers)
        return numbers

    def destroy(self) -> None:
        """Free the PETSc objects. Collective."""
        self.drop_matrix()
        for vector in (self.b, self.x, self._r):
            if vector:
                vector.destroy()
        self.b = self.x = self._r = None

    def drop_matrix(self) -> None:
        """Free the matrix, if there is one. Collective."""
        for thing in {id(t): t for t in (self.operator, self.preconditioned, self.matrix, self._null) if t}.values():
            thing.destroy()
        self.matrix = self.operator = self.preconditioned = self._null = None

    @staticmethod
    def _touch(*vectors: PETSc.Vec) -> None:
        # PETSc caches norms of vectors and does not notice changes of the arrays.
        for vector in vectors:
            vector.stateIncrease()

    def _find_null_vector(self, alone: Flags, largest: float) -> None:
        """Find the null vector of A. alone : (n,) bool, rows of one entry; largest : of all entries of this rank."""
        x, b, r = self._arrays
        count = self.sum(float(np.count_nonzero(~alone)))[0]
        x[:] = ~alone
        self._touch(self.x)
        self.matrix.mult(self.x, self._r)
        worst = np.array([np.abs(r).max(initial=0.0), largest])
        if self.comm.size > 1:
            self.comm.Allreduce(MPI.IN_PLACE, worst, MPI.MAX)
        if count == 0 or worst[0] > _NULL * worst[1]:
            return
        x[:] /= np.sqrt(count)
        self._touch(self.x)
        self._null = PETSc.NullSpace().create(constant=False, vectors=(self.x.copy(),), comm=self.comm)
        self.operator = PETSc.Mat().createPython(self._sizes, _Projected(self.matrix, self._null), comm=self.comm)
        self.operator.setUp()
        self.preconditioned = self._pinned(alone)

    def _pinned(self, alone: Flags) -> PETSc.Mat:
        """Return A with a doubled diagonal entry in the first row that is not an identity row."""
        pinned = self.matrix.duplicate(copy=True)
        first = self.matrix.getOwnershipRange()[0]
        mine = np.flatnonzero(~alone)
        candidate = first + int(mine[0]) if mine.size else self._sizes[0][1]
        row = self.comm.allreduce(candidate, MPI.MIN)
        if row == candidate:
            pinned.setValue(row, row, 2.0 * self.matrix.getValue(row, row))
        pinned.assemble()
        return pinned


class _Projected:
    """Python side of the operator Q A."""

    def __init__(self, matrix: PETSc.Mat, null: PETSc.NullSpace) -> None:
        self._matrix, self._null = matrix, null

    def mult(self, _: PETSc.Mat, x: PETSc.Vec, y: PETSc.Vec) -> None:
        self._matrix.mult(x, y)
        self._null.remove(y)
