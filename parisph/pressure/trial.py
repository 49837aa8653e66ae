"""A small pressure solve with a known solution, and the versions of its libraries."""

import ctypes
import os
from typing import Any

import numpy as np
from mpi4py import MPI

from parisph.base.arrays import Array, Floats, Ints
from parisph.parallel.petsc import PETSc, petsc4py_version
from parisph.pressure.solver import PressureSolver

SIDE = 48    # unknowns along one side of the square: enough for several multigrid levels


def versions() -> dict[str, str | None]:
    """Return {"PETSc", "petsc4py", "hypre": text or None, "scalar", "integer"}. Not collective.

    "hypre" is None if PETSc was built without it, and "" if its version cannot be read.
    """
    return {
        "PETSc": ".".join(map(str, PETSc.Sys.getVersion())),
        "petsc4py": petsc4py_version,
        "hypre": _hypre_version() if PETSc.Sys.hasExternalPackage("hypre") else None,
        "scalar": np.dtype(PETSc.ScalarType).name,
        "integer": np.dtype(PETSc.IntType).name,
    }


def solve(comm: MPI.Comm) -> dict[str, Any]:
    """Solve a five-point Poisson equation on the ranks of `comm` by the solver of a step. Collective.

    Returns {"ranks", "iterations", "error": max |p - exact| / max |exact|, the same on every rank}.
    Raises SolverDiverged on every rank.
    """
    first, last = (SIDE * SIDE * (comm.rank + k) // comm.size for k in (0, 1))
    indptr, indices, values = _rows(np.arange(first, last))
    rhs = np.add.reduceat(values * _exact(indices), indptr[:-1])
    solver = PressureSolver(comm, rtol=1e-10)
    p, record = solver.solve(indptr, indices, values, rhs, np.zeros(last - first), renumbered=True)
    solver.destroy()
    error = np.max(np.abs(p - _exact(np.arange(first, last))), initial=0.0)
    return {"ranks": comm.size, "iterations": record.iterations, "error": comm.allreduce(error, MPI.MAX)}


def _exact(row: Array) -> Floats:
    """Return a pressure of order one with structure on all scales."""
    found: Floats = np.sin(0.1 * row) + np.cos(1.7 * row + 0.3)
    return found


def _rows(rows: Ints) -> tuple[Array, Array, Floats]:
    """Return the CSR rows of the five-point Laplacian with p = 0 around the square."""
    i, j = np.divmod(rows, SIDE)
    offsets = ((0, 0), (-1, 0), (1, 0), (0, -1), (0, 1))
    inside = np.array([(i + a >= 0) & (i + a < SIDE) & (j + b >= 0) & (j + b < SIDE) for a, b in offsets]).T
    columns = np.array([rows + a * SIDE + b for a, b in offsets]).T
    entries = np.broadcast_to([4.0, -1.0, -1.0, -1.0, -1.0], columns.shape)
    indptr = np.concatenate([[0], np.cumsum(inside.sum(axis=1))])
    return indptr.astype(np.int32), columns[inside].astype(np.int32), entries[inside]


def _hypre_version() -> str:
    """Return the version of the hypre library that PETSc has loaded; needs no headers."""
    try:
        with open("/proc/self/maps") as maps:
            loaded = {line.split()[-1] for line in maps if "HYPRE" in os.path.basename(line.split()[-1])}
        text = ctypes.c_char_p()
        ctypes.CDLL(loaded.pop()).HYPRE_Version(ctypes.byref(text))
        return (text.value or b"").decode().replace("HYPRE Release Version", "").split("Date")[0].strip()
    except (OSError, KeyError, AttributeError, UnicodeDecodeError):
        return ""
