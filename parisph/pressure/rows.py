"""The pressure matrix of this rank: the rows that parts fill, and the CSR matrix of all rows."""

from typing import Any

import numpy as np

from parisph.base.fields import INNER, SURFACE, WET
from parisph.kernels import rankine, surface_rows
from parisph.kernels.jit import kernel
from parisph.kernels.records import Cloud


class Rows:
    """Buffers of rows, which are kept from step to step; row I starts at indptr[I] of the neighbour lists.

    count : (n,) int32, entries of each row but its diagonal; columns, values : (nnz,); measure : (n,)
    """

    def __init__(self) -> None:
        self.columns, self.count = np.empty(0, np.int32), np.empty(0, np.int32)
        self.values, self.measure = np.empty(0), np.empty(0)

    def reserve(self, n: int, nnz: int) -> None:
        """Make room for n rows with nnz entries, all of them empty."""
        if nnz > len(self.columns):
            room = nnz + nnz // 8
            self.columns, self.values = np.empty(room, np.int32), np.empty(room)
        if n > len(self.count):
            room = n + n // 8
            self.count, self.measure = np.empty(room, np.int32), np.empty(room)
        self.count[:n] = 0
        self.measure[:n] = 0.0


class Flux:
    """Stencils of the divergence at inner particles: div u_I = sum_J flux_J . (u_J - u_I).

    count : (n,) int32; columns : (nnz,) int32; flux : (nnz, dim) [1/m]; div : (n,) [1/s], of the velocity they were
    filled with. Count and columns are those of the rows if the same kernel fills both.
    """

    def __init__(self, dim: int) -> None:
        self.columns, self.count = np.empty(0, np.int32), np.empty(0, np.int32)
        self.flux, self.div = np.empty((0, dim)), np.empty(0)

    def reserve(self, n: int, nnz: int, shared: Rows | None) -> None:
        """Make room for n stencils with nnz entries. shared : rows whose count and columns are used, or None."""
        if nnz > len(self.flux):
            self.flux = np.empty((nnz + nnz // 8, self.flux.shape[1]))
        if n > len(self.div):
            self.div = np.empty(n + n // 8)
        self.div[:n] = 0.0
        if shared is not None:
            self.columns, self.count = shared.columns, shared.count
            return
        if nnz > len(self.columns):
            self.columns = np.empty(nnz + nnz // 8, np.int32)
        if n > len(self.count):
            self.count = np.empty(n + n // 8, np.int32)
        self.count[:n] = 0


class PressureRows:
    """Rows row_I(p) = p_I - sum_J values_J p_J, with row_I(p) = -measure_I target_I.

    The target is the Laplacian at inner particles and the inward normal derivative at wet
    walls. Surface particles have p = 0, or a row of measure 0; every other particle has p = 0.

    Parameters
    ----------
    laplacian, divergence, walls : parts that fill rows and stencils (methods.parts)
    offset : distance from a full surface particle to the surface, in spacings; 0 for p = 0 at surface particles
    radius : of the neighbours that count in rows of the surface, in spacings
    """

    def __init__(self, dim: int, laplacian: Any, divergence: Any, walls: Any, offset: float, radius: float) -> None:
        self.laplacian, self.divergence_part, self.walls = laplacian, divergence, walls
        self.offset, self.radius = offset, radius
        self.own_flux = laplacian.gives != divergence.name
        self.rows, self.flux = Rows(), Flux(dim)
        self._invariants: tuple[np.ndarray, np.ndarray, np.ndarray] | None = None

    def fill(self, u: np.ndarray, cloud: Cloud, cells: np.ndarray) -> None:
        """Fill the rows of all owned particles, and the flux divergence of u (n_all, dim) [m/s]. Not collective.

        cells : (n_all,), the part of their cells that particles fill
        """
        n, rows, flux = len(cloud.indptr) - 1, self.rows, self.flux
        self.cloud, self._invariants = cloud, None
        rows.reserve(n, len(cloud.indices))
        flux.reserve(n, len(cloud.indices), None if self.own_flux else rows)
        self.laplacian.fill(rows, cloud, flux, u)
        if self.own_flux:
            self.divergence_part.fill(flux, cloud, u)
        self.walls.fill(rows, cloud)
        if self.offset > 0.0:
            s = cloud.spacing
            surface_rows.surface_rows(rows.count, rows.columns, rows.values, cloud, cells, self.offset * s,
                                      self.radius * s)

    @property
    def div(self) -> np.ndarray:
        """Flux divergence (n_owned,) [1/s] of the velocity that the rows were filled with, 0 without a stencil."""
        return self.flux.div[:len(self.cloud.indptr) - 1]

    def pin(self, which: np.ndarray) -> None:
        """Make p = 0 at some owned particles, given by a mask or their numbers, whose role becomes SURFACE."""
        self.rows.count[:len(self.cloud.indptr) - 1][which] = 0

    def csr(self, role: np.ndarray, global_rows: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Return (indptr, global columns, values, anchored) with the p = 0 columns dropped.

        anchored : (n_owned,) bool, rows with p = 0 or of the surface, or with such a neighbour.
        """
        rows, indptr = self.rows, self.cloud.indptr
        return compress(len(indptr) - 1, rows.count, rows.columns, rows.values, indptr, role, global_rows,
                        self.offset > 0.0)

    def right_hand_side(self, target: np.ndarray) -> np.ndarray:
        """Return -measure * target, (n_owned,)."""
        return -self.rows.measure[:len(target)] * target

    def add_surface_values(self, right: np.ndarray, p: np.ndarray, role: np.ndarray) -> None:
        """Add to the right-hand side (n_owned,) what makes p (n_all,) [Pa] the pressure on the surface, in place of 0.

        Where surface particles lie below the surface, p is that above them. role : (n_all,)
        """
        rows = self.rows
        add_surface_values(right, p, role, rows.count, rows.columns, rows.values, self.offset > 0.0, self.cloud.indptr)

    def divergence(self, out: np.ndarray, u: np.ndarray, role: np.ndarray) -> None:
        """Write the flux divergence of u (n_all, dim) at inner particles to out (n_owned,) [1/s]."""
        rankine.divergence(out, u, role, *self._stencils())

    def gradient_invariants(self, u: np.ndarray, role: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return tr(G^2) [1/s^2], sqrt(2 G:G) and tr(G) [1/s] of G = grad u at inner particles, (n_owned,) each.

        They are found once for the rows, and not again until they are filled anew.

        u : (n_all, dim) [m/s] of the flow; role : (n_all,)
        """
        if self._invariants is None:
            square, rate, div = np.empty((3, len(self.cloud.indptr) - 1))
            rankine.gradient_invariants(square, rate, div, u, role, *self._stencils())
            self._invariants = square, rate, div
        return self._invariants

    def _stencils(self):
        flux, cloud = self.flux, self.cloud
        return flux.count, flux.columns, flux.flux, cloud.indptr, cloud.axes


@kernel
def add_surface_values(right: np.ndarray, p: np.ndarray, role: np.ndarray, count: np.ndarray, columns: np.ndarray,
                       values: np.ndarray, solved: bool, indptr: np.ndarray) -> None:
    """Add the terms of `PressureRows.add_surface_values`.

    solved : whether surface particles have rows of their own, p_I - p_s = sum_J values_J (p_J - p_s)
    """
    for i in range(len(right)):
        if role[i] == SURFACE:
            share = 1.0
            if solved:
                for k in range(indptr[i], indptr[i] + count[i]):
                    share -= values[k]
            right[i] += share * p[i]
        elif not solved and (role[i] == INNER or role[i] == WET):
            for k in range(indptr[i], indptr[i] + count[i]):
                if role[columns[k]] == SURFACE:
                    right[i] += values[k] * p[columns[k]]


@kernel
def compress(n: int, count: np.ndarray, columns: np.ndarray, values: np.ndarray, start: np.ndarray, role: np.ndarray,
             global_rows: np.ndarray, solved: bool) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Join the rows to one CSR with global columns; Dirichlet rows become p = 0.

    solved : whether surface particles have rows of their own
    """
    indptr = np.empty(n + 1, np.int32)
    entries = n
    for i in range(n):
        entries += count[i]
    out_columns = np.empty(entries, np.int32)
    out_values = np.empty(entries)
    anchored = np.zeros(n, np.bool_)
    m = np.uint32(0)    # unsigned, as in kernels.near.gather
    indptr[0] = 0
    for i in range(n):
        own, placed = global_rows[i], False
        if role[i] == INNER or role[i] == WET or (role[i] == SURFACE and solved):
            anchored[i] = role[i] == SURFACE
            for k in range(np.uint32(start[i]), np.uint32(start[i] + count[i])):
                j = np.uint32(columns[k])
                if values[k] == 0.0:
                    continue
                if role[j] == SURFACE:
                    anchored[i] = True
                if role[j] == INNER or role[j] == WET or (role[j] == SURFACE and solved):
                    if not placed and global_rows[j] > own:    # so that a row in order stays so
                        out_columns[m], out_values[m] = own, 1.0
                        m, placed = np.uint32(m + 1), True
                    out_columns[m] = global_rows[j]
                    out_values[m] = -values[k]
                    m += np.uint32(1)
                else:
                    anchored[i] = True
        else:
            anchored[i] = True
        if not placed:
            out_columns[m], out_values[m] = own, 1.0
            m += np.uint32(1)
        indptr[i + 1] = m
    return indptr, out_columns[:m], out_values[:m], anchored
