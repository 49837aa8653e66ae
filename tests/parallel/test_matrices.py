"""Matrices on ranks have the entries of their rows, whichever way PETSc gets them."""

import gc

import numpy as np
import pytest

from parisph.parallel.petsc import PETSc
from parisph.pressure import matrices
from parisph.pressure.solver import PressureSolver
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


@pytest.mark.parametrize("inside", ["sor", "ilu"])
def test_a_kept_preconditioner_may_outlive_the_matrix_whose_block_it_uses(comm, inside):
    solver = PressureSolver(comm, ["-pressure_pc_type", "bjacobi", "-pressure_sub_pc_type", inside], rtol=1e-5)
    try:
        for seed in range(8):
            x, _, *rows = systems.square(20, scatter=0.02 * seed)
            p = np.cos(np.pi * x[:, 0]) * np.cos(0.5 * np.pi * x[:, 1])
            first, last, *mine = systems.share(comm, rows)
            found, record = solver.solve(*mine, systems.product(rows, p)[first:last], None)
            gc.collect()
            assert np.abs(found - p[first:last]).max() < 1e-3 and record.fallback == ""
        assert solver.setups < 8    # some were kept
    finally:
        solver.destroy()
