"""Matrices on ranks have the entries of their rows, whichever way PETSc gets them."""

import gc

import numpy as np
import pytest

from parisph.parallel.petsc import PETSc
from parisph.pressure import matrices
from parisph.pressure.system import System
from tests import systems


def rows_of(comm, busy=None, seed=0):
    """Return (first, last, indptr, columns, values) of this rank, the entries of each row in any order."""
    _, _, *rows = systems.square(12)
    first, last, indptr, columns, values = systems.share(comm, rows, busy)
    columns, values = columns.astype(PETSc.IntType), values.copy()
    random = np.random.default_rng(seed)
    for start, end in zip(indptr[:-1], indptr[1:]):
        order = start + random.permutation(end - start)
        columns[start:end], values[start:end] = columns[order], values[order]
    return first, last, indptr.astype(PETSc.IntType), columns, values


@pytest.mark.parametrize("blocks", [True, False])
@pytest.mark.parametrize("busy", [None, 1])
def test_a_matrix_has_the_entries_of_its_rows(comm, monkeypatch, blocks, busy):
    if not blocks:
        monkeypatch.setattr(matrices, "_create", None)    # as with a PETSc whose functions cannot be called
    elif matrices._create is None:
        pytest.skip("this PETSc does not give away its functions")
    first, last, *csr = rows_of(comm, busy)
    given = [array.copy() for array in csr]
    total = comm.allreduce(last - first)
    system = System(comm, False)
    system.resize(last - first, total)
    found = matrices.matrix_of(system.x, *csr)
    gc.collect()    # nobody but the matrix holds its arrays
    due = PETSc.Mat().createAIJ(found.getSizes(), csr=tuple(given), comm=comm)
    assert found.getOwnershipRange() == (first, last) and found.refcount == 1
    assert due.norm() > 1.0
    due.axpy(-1.0, found)
    assert due.norm() == 0.0
    for thing in (found, due):
        thing.destroy()
    system.destroy()


def test_products_with_a_matrix_from_blocks(comm):
    first, last, *csr = rows_of(comm)
    _, _, *rows = systems.square(12)
    p = np.random.default_rng(3).normal(size=comm.allreduce(last - first))
    system = System(comm, False)
    system.resize(last - first, len(p))
    for seed in range(3):    # of which each drops the matrix before
        system.assemble(*rows_of(comm, seed=seed)[2:])
    system.start_from(p[first:last])
    system.matrix.mult(system.x, system.b)
    np.testing.assert_allclose(system.b.array, systems.product(rows, p)[first:last], rtol=1e-12, atol=1e-12)
    system.destroy()
