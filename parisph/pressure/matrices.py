"""PETSc matrices that use arrays of rows without copies."""

import ctypes
from collections.abc import Callable
from typing import Any

import numpy as np
from mpi4py import MPI

from parisph.base.arrays import Array, Floats
from parisph.kernels.row import sort_rows, split_rows
from parisph.parallel.petsc import PETSc

_INT = ctypes.c_int64 if np.dtype(PETSc.IntType).itemsize == 8 else ctypes.c_int32
# a handle is a pointer in some MPI libraries and an integer in others
_HANDLE = ctypes.c_void_p if MPI._sizeof(MPI.Comm) == ctypes.sizeof(ctypes.c_void_p) else ctypes.c_int
_Create = Callable[[MPI.Comm, int, int, tuple[Array, ...]], PETSc.Mat]


def matrix_of(rows: PETSc.Vec, indptr: Array, columns: Array, values: Floats) -> PETSc.Mat:
    """Return the matrix of these rows. Collective.

    On one rank the entries of rows are sorted in place. On several, the arrays become the block of own columns.

    Parameters
    ----------
    rows : PETSc.Vec with the same rows on each rank
    indptr : (n + 1,) PETSc.IntType, columns : (nnz,) PETSc.IntType, values : (nnz,) float
        This rank's rows as CSR with global columns; the matrix keeps the arrays.
    """
    sort_rows(indptr, columns, values)    # PETSc takes many times as long for unsorted rows
    if rows.comm.size > 1 and _create is not None:
        return _from_blocks(_create, rows, indptr, columns, values)
    return PETSc.Mat().createAIJWithArrays((rows.sizes, rows.sizes), (indptr, columns, values), comm=rows.comm)


def compile_for_ranks() -> None:
    """Compile or load the kernels that only several ranks need. Not collective."""
    split_rows(np.zeros(1, PETSc.IntType), np.zeros(0, PETSc.IntType), np.zeros(0), 0, 0)


def _from_blocks(create: _Create, rows: PETSc.Vec, indptr: Array, columns: Array, values: Floats) -> PETSc.Mat:
    """Return the matrix of sorted rows from its blocks of own and of other columns, PETSc's storage on several ranks.

    PETSc would split rows entry by entry, 13 ms for 41,600 rows on each of two ranks: three Krylov iterations.
    """
    (first, last), (n, total) = rows.owner_range, rows.sizes
    arrays = split_rows(indptr, columns, values, first, last)
    matrix = create(rows.comm.tompi4py(), n, total, arrays)
    # The arrays must live as long as PETSc uses them: a kept preconditioner may use the block without the matrix.
    for holder in (matrix, matrix.getDiagonalBlock()):
        holder.setAttr("__rows__", arrays)
    return matrix


def _creator() -> _Create | None:
    """Return a function that makes a matrix from its blocks by PETSc's function, which petsc4py lacks; None if it
    cannot be called."""
    try:
        library = ctypes.CDLL(PETSc.__file__)
        function, capsule = library.MatCreateMPIAIJWithSplitArrays, PETSc.__pyx_capi__["PyPetscMat_New"]
    except (OSError, AttributeError, KeyError):
        return None
    if PETSc.ScalarType is not np.float64:
        return None
    function.restype = ctypes.c_int
    function.argtypes = [_HANDLE, *[_INT] * 4, *[ctypes.c_void_p] * 7]
    wrapped = ctypes.PYFUNCTYPE(ctypes.py_object, ctypes.c_void_p)(_address(capsule))

    def create(comm: MPI.Comm, n: int, total: int, arrays: tuple[Array, ...]) -> PETSc.Mat:
        handle, made = _HANDLE.from_address(MPI._addressof(comm)), ctypes.c_void_p()
        error = function(handle, n, n, total, total, *(array.ctypes.data for array in arrays), ctypes.byref(made))
        if error:
            raise PETSc.Error(error)
        matrix = wrapped(made)
        matrix.decRef()    # the wrapper counts a second reference
        return matrix
    return create


def _address(capsule: Any) -> Any:
    """Return the address in a Python capsule."""
    name = ctypes.pythonapi.PyCapsule_GetName
    name.restype, name.argtypes = ctypes.c_char_p, [ctypes.py_object]
    pointer = ctypes.pythonapi.PyCapsule_GetPointer
    pointer.restype, pointer.argtypes = ctypes.c_void_p, [ctypes.py_object, ctypes.c_char_p]
    return pointer(capsule, name(capsule))


_create = _creator()
