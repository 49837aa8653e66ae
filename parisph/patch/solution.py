"""Solve the Poisson problem lap p = lap f on an arrangement of particles. Not collective."""

import numpy as np
from mpi4py import MPI

from parisph.base.arrays import Floats
from parisph.base.fields import INNER, SURFACE, WET
from parisph.patch.derivatives import Discrete
from parisph.pressure.solver import PressureSolver

RTOL = 1e-9    # relative tolerance of the solve, far below the errors of the operators


def solution(system: Discrete, f: Floats, laplacian: Floats, gradient: Floats | None = None) -> Floats:
    """Return p (n,) with lap p = laplacian inside, n . grad p = n . gradient at walls, and p = f at the surface.

    system : rows of inner particles and walls; f, laplacian : (n,); gradient : (n, dim), needed if there are wet walls.
    If no particle has a known value, p is unique up to a constant, and its mean is 0.

    Raises SolverDiverged: the equations could not be solved
    """
    a = system.arrangement
    n, known = len(a.x), a.role == SURFACE
    target = np.where(a.role == INNER, laplacian, 0.0)
    if gradient is not None:
        target = np.where(a.role == WET, (a.normal * gradient).sum(axis=1), target)
    # the solver takes p = 0 for known particles: their terms with f are on the right-hand side
    right = system.rows.right_hand_side(target) + system.weighted(np.where(known, f, 0.0))
    right[(a.role != INNER) & (a.role != WET)] = 0.0
    indptr, columns, values, _ = system.rows.csr(np.arange(n, dtype=np.int32))
    solver = PressureSolver(MPI.COMM_SELF, rtol=RTOL, closed=not known.any())
    try:
        p, _ = solver.solve(indptr, columns, values, right, None)
    finally:
        solver.destroy()
    return np.where(known, f, p)
