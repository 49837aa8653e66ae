"""Divergence stencils of the velocity without a pressure row.

They have the form that `rankine.divergence` and `gradient_invariants` read: div u_I = sum_J flux_J . (u_J - u_I).
"""

import numpy as np

from parisph.base.fields import INNER
from parisph.kernels.circle import Circle, fill_basis, fit_around, sum_over_points
from parisph.kernels.gradient import support
from parisph.kernels.harmonic import basis_size
from parisph.kernels.jit import inlined, kernel
from parisph.kernels.mls import moment_count
from parisph.kernels.near import Form, fill_up, gather_within, room_for
from parisph.kernels.rankine import UNSOUND
from parisph.kernels.records import Cloud, DivergenceRows


@kernel
def flux_rows(flux: DivergenceRows, cloud: Cloud, u: np.ndarray, circle: Circle) -> None:
    """Fill the flux stencils of inner particles, as in `rankine.rankine_rows`, and the flux divergence of u.

    The flux of u through the circle of radius R, interpolated by linear moving least squares (Zheng, Ma & Duan 2014,
    Eq. 23), gives div u_I = (dim/R) mean u . n. It is exact for linear u on any particles. A stencil is zero where the
    neighbours do not span the plane (3D: space), or where they lie on one side of the circle. It holds the
    neighbours within R + radius, even if the lists reach farther.

    u : (n_all, dim) [m/s]
    """
    unit, radius, role, indptr, axes = circle.unit, circle.radius, cloud.role, cloud.indptr, cloud.axes
    dim, points, size, room = len(axes), len(unit), basis_size(axes), room_for(indptr)
    at = np.ascontiguousarray(unit.T) * (circle.size / radius)
    centre = np.zeros_like(at)
    basis, w = np.empty((size + 1, room)), np.empty((points, room))
    moments, fit = np.empty((moment_count(axes), points)), np.empty((dim + 1, points))
    mean = np.empty((dim + 1, room))
    for i in range(len(indptr) - 1):
        if role[i] != INNER:
            continue
        n = gather_within(basis, flux.columns, indptr[i], i, cloud, radius, circle.size + radius)
        m = fill_up(basis, n, axes)
        fill_basis(basis, m, axes)
        spanned = fit_around(fit, moments, w, basis, at, centre, m, axes)
        sum_over_points(mean, fit, w, basis, unit, m, axes)
        sound = spanned and _surrounded(mean, basis, m)
        _finish(flux, i, n, dim / (circle.size * points) if sound else 0.0, mean, cloud, u)


@inlined
def _surrounded(mean, basis, m):
    """Return whether the mean over the circle is sound as a pressure row, by the limits of `rankine`."""
    total, spread, lowest = 0.0, 0.0, 0.0
    for k in range(m):
        total += mean[0, k]
        lowest = min(lowest, mean[0, k])
        spread += mean[0, k] * basis[len(basis) - 1, k]
    return total > 0.0 and spread > 0.0 and lowest > -UNSOUND * total


@kernel
def least_squares_flux(flux: DivergenceRows, cloud: Cloud, u: np.ndarray, form: Form) -> None:
    """Fill the divergence stencils of inner particles from the first-order least-squares gradient.

    This is the nodal divergence of SFDI (Zheng et al. 2017, Eqs. 29-32, with power 2), exact for linear u (n_all, dim)
    [m/s] on any particles. A stencil below the floor is zero. As a pressure source it is unstable where the flux
    through a circle is stable.
    """
    indptr, axes = cloud.indptr, cloud.axes
    dim, room = len(axes), room_for(indptr)
    near, weighted = np.empty((dim, room)), np.empty((dim + 1, room))
    stencil = np.empty((dim + 1, room))
    moment, inverse = np.empty((dim, dim)), np.empty((dim, dim))
    for i in range(len(indptr) - 1):
        if cloud.role[i] != INNER:
            continue
        n = gather_within(near, flux.columns, indptr[i], i, cloud, form.radius, form.radius)
        m = fill_up(near, n, axes)
        sound = support(moment, inverse, weighted, near, form.power, n, m, axes) >= form.floor
        for a in range(dim):
            for k in range(m):
                total = 0.0
                for b in range(dim):
                    total += inverse[a, b] * weighted[1 + b, k]
                stencil[1 + a, k] = total if sound else 0.0
        _finish(flux, i, n, 1.0 / form.radius, stencil, cloud, u)


@inlined
def _finish(flux, i, n, scale, stencil, cloud, u):
    """Store a stencil of n neighbours, rows 1 to dim, and sum the divergence of u."""
    change, first = 0.0, cloud.indptr[i]
    flux.count[i] = n
    for k in range(n):
        j = flux.columns[first + k]
        for a in range(len(cloud.axes)):
            f = scale * stencil[1 + a, k]
            flux.flux[first + k, a] = f
            change += f * (u[j, a] - u[i, a])
    flux.div[i] = change
