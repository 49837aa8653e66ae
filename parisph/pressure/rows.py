"""The pressure matrix of this rank: the kernel that fills each row, and the CSR matrix of all rows."""

import numpy as np

from parisph.base.fields import INNER, SURFACE, WET
from parisph.kernels import laplacian, rankine, surface_rows, walls
from parisph.kernels.jit import axes_of, kernel


class PressureRows:
    """Rows row_I(p) = p_I - sum_J values_J p_J, with row_I(p) = -measure_I target_I.

    The target is the Laplacian at inner particles and the inward normal derivative at wet
    walls. Surface particles have p = 0, or a row of measure 0; every other particle has p = 0. The buffers are kept from step to step.

    Parameters
    ----------
    scheme : Scheme
        Needs `rows` ("rankine" or "sph") and `normalised`.
    wall_rows : "sfdi" or "harmonic"
    offset : distance from a full surface particle to the surface, in spacings; 0 for p = 0 at surface particles
    spacing : float [m]
    radii : mapping of "circle", "mls", "wall", "sph" to lengths in spacings
    """

    def __init__(self, dim, scheme, wall_rows, offset, spacing, radii):
        self.axes = axes_of(dim)
        self.scheme, self.wall_rows, self.offset, self.spacing = scheme, wall_rows, offset, spacing
        self.radii = {name: value * spacing for name, value in radii.items()}
        self.unit = rankine.directions(dim)
        self.columns, self.count = np.empty(0, np.int32), np.empty(0, np.int32)
        self.values, self.measure, self.div = np.empty(0), np.empty(0), np.empty(0)
        self.flux = np.empty((0, dim))

    def fill(self, u, x, kind, role, volume, normal, indptr, indices) -> None:
        """Fill the rows of all owned particles, and the flux divergence of u.

        u, x, normal : (n_all, dim); kind, role, volume : (n_all,); CSR of the owned particles. Not collective.
        Sets count, columns, values, measure, flux, div.
        """
        n, axes, r = len(indptr) - 1, self.axes, self.radii
        self._reserve(n, len(indices))
        self.indptr = indptr
        self.count[:n] = 0
        self.measure[:n] = 0.0
        self.div[:n] = 0.0
        rankine.rankine_rows(self.count, self.columns, self.values, self.measure, self.flux, self.div, u, x,
                             role, self.unit, r["circle"], r["mls"], self.scheme.normalised, indptr,
                             indices, axes)
        if self.scheme.rows == "sph":
            # same columns in the same order: the flux divergence stays valid
            laplacian.isph_rows(self.count, self.columns, self.values, self.measure, x, role, r["sph"],
                                self.spacing ** len(axes), indptr, indices, axes)
        walls.sfdi_rows(self.count, self.columns, self.values, self.measure, x, role, normal, r["wall"],
                        indptr, indices, axes)
        if self.wall_rows == "harmonic":
            walls.harmonic_rows(self.count, self.columns, self.values, self.measure, x, role, normal,
                                r["wall"], indptr, indices, axes)
        if self.offset > 0.0:
            surface_rows.surface_rows(self.count, self.columns, self.values, x, kind, role, volume, self.offset * self.spacing,
                                      self.spacing, r["mls"], indptr, indices, axes)

    def pin(self, which) -> None:
        """Make p = 0 at some owned particles, given by a mask or their numbers, whose role becomes SURFACE."""
        self.count[:len(self.indptr) - 1][which] = 0

    def csr(self, role, global_rows):
        """Return (indptr, global columns, values, anchored) with the p = 0 columns dropped.

        anchored : (n_owned,) bool, rows with p = 0 or of the surface, or with such a neighbour.
        """
        n = len(self.indptr) - 1
        return compress(n, self.count, self.columns, self.values, self.indptr, role, global_rows, self.offset > 0.0)

    def right_hand_side(self, target):
        """Return -measure * target, (n_owned,)."""
        return -self.measure[:len(target)] * target

    def divergence(self, out, u, role):
        """Write the flux divergence of u (n_all, dim) at inner particles to out (n_owned,) [1/s]."""
        rankine.divergence(out, u, role, self.count, self.columns, self.flux, self.indptr, self.axes)

    def second_invariant(self, out, u, role):
        """Write tr((grad u)^2) of u (n_all, dim) at inner particles to out (n_owned,) [1/s^2]."""
        rankine.second_invariant(out, u, role, self.count, self.columns, self.flux, self.indptr, self.axes)

    def turnover(self, out, u, role) -> None:
        """Write sqrt(2 G:G), G = grad u of u (n_all, dim), at inner particles to out (n_owned,) [1/s]."""
        rankine.turnover(out, u, role, self.count, self.columns, self.flux, self.indptr, self.axes)

    def _reserve(self, n, nnz):
        if nnz > len(self.columns):
            room = nnz + nnz // 8
            self.columns = np.empty(room, np.int32)
            self.values = np.empty(room)
            self.flux = np.empty((room, len(self.axes)))
        if n > len(self.count):
            room = n + n // 8
            self.count = np.empty(room, np.int32)
            self.measure, self.div = np.empty(room), np.empty(room)


@kernel
def compress(n, count, columns, values, start, role, global_rows, solved):
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
    m = 0
    indptr[0] = 0
    for i in range(n):
        out_columns[m] = global_rows[i]
        out_values[m] = 1.0
        m += 1
        if role[i] == INNER or role[i] == WET or (role[i] == SURFACE and solved):
            anchored[i] = role[i] == SURFACE
            for k in range(start[i], start[i] + count[i]):
                j = columns[k]
                if values[k] == 0.0:
                    continue
                if role[j] == SURFACE:
                    anchored[i] = True
                if role[j] == INNER or role[j] == WET or (role[j] == SURFACE and solved):
                    out_columns[m] = global_rows[j]
                    out_values[m] = -values[k]
                    m += 1
                else:
                    anchored[i] = True
        else:
            anchored[i] = True
        indptr[i + 1] = m
    return indptr, out_columns[:m], out_values[:m], anchored
