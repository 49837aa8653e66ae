"""The pressure matrix of this rank: rows filled by parts, and the CSR matrix of all rows."""

from typing import Any

import numpy as np

from parisph.base.arrays import Array, Flags, Floats, Ints
from parisph.base.fields import INNER, SURFACE, WET
from parisph.kernels import rankine, surface_rows
from parisph.kernels.jit import kernel
from parisph.kernels.rankine import Invariants
from parisph.kernels.records import Cloud, DivergenceRows, Rows


def _with_room(array: Array, n: int) -> Array:
    """Return an array with room for n items: this one if it is long enough."""
    return array if n <= len(array) else np.empty((n + n // 8, *array.shape[1:]), array.dtype)


class PressureRows:
    """Rows row_I(p) = p_I - sum_J values_J p_J, with row_I(p) = -measure_I target_I.

    The target is the Laplacian at inner particles and the inward normal derivative at wet
    walls. Surface particles have p = 0, or a row of measure 0; every other particle has p = 0.

    Parameters
    ----------
    laplacian, divergence, walls : parts that fill rows and stencils (methods.parts)
    offset : distance from a full surface particle to the surface, in spacings; 0 for p = 0 at surface particles
    radius : of the neighbours in rows of the surface, in spacings
    """

    def __init__(self, dim: int, laplacian: Any, divergence: Any, walls: Any, offset: float, radius: float) -> None:
        self.laplacian, self.divergence_part, self.walls = laplacian, divergence, walls
        self.offset, self.radius = offset, radius
        self.own_flux = laplacian.gives != divergence.name
        none, nothing = np.empty(0, np.int32), np.empty(0)
        self.rows = Rows(none, none, nothing, nothing)
        self.flux = DivergenceRows(none, none, np.empty((0, dim)), nothing)
        self._invariants: Invariants | None = None

    def fill(self, u: Floats, cloud: Cloud, cells: Floats) -> None:
        """Fill the rows of all owned particles, and the flux divergence of u (n_all, dim) [m/s]. Not collective.

        The rows refer to the cloud, and are valid until its particles are sorted again, with their current roles.
        cells : (n_all,), the fraction of their cells that particles fill
        """
        self.cloud, self._invariants = cloud, None
        self._reserve(len(cloud.indptr) - 1, len(cloud.indices))
        rows, flux = self.rows, self.flux
        self.laplacian.fill(rows, cloud, flux, u)
        if self.own_flux:
            self.divergence_part.fill(flux, cloud, u)
        self.walls.fill(rows, cloud)
        if self.offset > 0.0:
            s = cloud.spacing
            surface_rows.surface_rows(rows, cloud, cells, self.offset * s, self.radius * s)

    def _reserve(self, n: int, nnz: int) -> None:
        """Make room for n empty rows and stencils with nnz entries."""
        rows, flux = self.rows, self.flux
        self.rows = rows = Rows(_with_room(rows.count, n), _with_room(rows.columns, nnz), _with_room(rows.values, nnz),
                                _with_room(rows.measure, n))
        shared = flux if self.own_flux else rows
        self.flux = flux = DivergenceRows(_with_room(shared.count, n), _with_room(shared.columns, nnz),
                                          _with_room(flux.flux, nnz), _with_room(flux.div, n))
        for array in (rows.count, rows.measure, flux.count, flux.div):
            array[:n] = 0

    @property
    def div(self) -> Floats:
        """Flux divergence (n_owned,) [1/s] of the velocity given to `fill`, 0 without a stencil."""
        return self.flux.div[:len(self.cloud.indptr) - 1]

    def pin(self, which: Flags | Ints) -> None:
        """Set p = 0 at some owned particles, by mask or numbers; the caller sets their role to SURFACE."""
        self.rows.count[:len(self.cloud.indptr) - 1][which] = 0

    def csr(self, global_rows: Array) -> tuple[Array, Array, Floats, Flags]:
        """Return (indptr, global columns, values, anchored) with the p = 0 columns dropped.

        anchored : (n_owned,) bool, rows with p = 0 or of the surface, or with such a neighbour.
        """
        return compress(self.rows, self.cloud, global_rows, self.offset > 0.0)

    def right_hand_side(self, target: Floats) -> Floats:
        """Return -measure * target, (n_owned,)."""
        return -self.rows.measure[:len(target)] * target

    def add_surface_values(self, right: Floats, p: Floats) -> None:
        """Add the terms of a pressure p (n_all,) [Pa] on the surface, in place of 0, to the right-hand side (n_owned,).

        For surface particles below the surface, p is the pressure on the surface above them.
        """
        add_surface_values(right, self.rows, self.cloud, p, self.offset > 0.0)

    def divergence(self, out: Floats, u: Floats) -> None:
        """Write the flux divergence of u (n_all, dim) at inner particles to out (n_owned,) [1/s]."""
        rankine.divergence(out, self.flux, self.cloud, u)

    def gradient_invariants(self, u: Floats) -> Invariants:
        """Return the invariants of grad u at inner particles, computed once until rows are filled again.

        u : (n_all, dim) [m/s] of the flow
        """
        if self._invariants is None:
            self._invariants = Invariants(*np.empty((3, len(self.cloud.indptr) - 1)))
            rankine.gradient_invariants(self._invariants, self.flux, self.cloud, u)
        return self._invariants


@kernel
def add_surface_values(right: Floats, rows: Rows, cloud: Cloud, p: Floats, solved: bool) -> None:
    """Add the terms of `PressureRows.add_surface_values`.

    solved : whether surface particles have rows of their own, p_I - p_s = sum_J values_J (p_J - p_s)
    """
    count, columns, values, _ = rows
    role, indptr = cloud.role, cloud.indptr
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
def compress(rows: Rows, cloud: Cloud, global_rows: Array, solved: bool) -> tuple[Array, Array, Floats, Flags]:
    """Join the rows to one CSR with global columns; Dirichlet rows become p = 0.

    solved : whether surface particles have rows of their own
    """
    count, columns, values, _ = rows
    role, start, n = cloud.role, cloud.indptr, len(cloud.indptr) - 1
    indptr, entries = np.empty(n + 1, np.int32), n
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
                    if not placed and global_rows[j] > own:    # keeps the order of a sorted row
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
