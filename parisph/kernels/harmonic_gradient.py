"""The gradient from a fit by harmonic polynomials to the values of neighbours and to slopes across walls.

A stencil beside a wall is one-sided. But the normal derivative of pressure is known at each wall particle (Z14 Eq 25),
and is a datum of the fit like the value of a neighbour. Without it, the pressure of a wave ten spacings deep pushes the
particles beside a wall too hard, by a tenth along the surface and along the bed.
"""

import numpy as np

from parisph.base.fields import INNER, SURFACE
from parisph.kernels import harmonic
from parisph.kernels.jit import inlined, kernel
from parisph.kernels.near import fill_up, gather_within, room_for
from parisph.kernels.records import Cloud


@kernel
def harmonic_gradient(out: np.ndarray, where: np.ndarray, cloud: Cloud, f: np.ndarray, slopes: harmonic.Slopes,
                      laplacian: np.ndarray, radius: float, most: float) -> np.ndarray:
    """Write the gradient at fluid with a pressure by the harmonic fit; return where it exists (n_owned,) bool.

    The polynomials are of degree 3, or of degree 2 if the neighbours do not span them or the terms above the first
    degree raise the variance of the slope to more than `most` times that of a linear fit. If neither fit is sound,
    `out` keeps its value.

    out : (n_owned, dim), changed [unit of f per m] at particles `where` (n_owned,) bool; f : (n_all,)
    laplacian : (n_owned,) of f [unit of f per m^2], or without rows if f is harmonic. Its contributions to values, lap
        r^2/(2 dim), and to slopes are subtracted before the fit.
    radius : of the weight [m]
    """
    role, indptr, axes = cloud.role, cloud.indptr, cloud.axes
    dim, room, size, less = len(axes), room_for(indptr), harmonic.terms(3, axes), harmonic.terms(2, axes)
    fit, member = harmonic.fit_of(2 * room, axes), np.empty(room, np.int32)
    unit, found = harmonic.UNIT * radius, np.zeros(len(indptr) - 1, np.bool_)
    for i in range(len(indptr) - 1):
        if not where[i] or (role[i] != INNER and role[i] != SURFACE):
            continue
        n = gather_within(fit.b, member, 0, i, cloud, unit, radius)
        if n <= dim:    # in free flight
            continue
        lap = laplacian[i] / dim if len(laplacian) > 0 else 0.0
        _values(fit, member, n, i, f, 0.5 * lap * unit * unit, axes)
        m = harmonic.add_slopes(fit, n, i, cloud, slopes, lap, unit, radius)
        if m > size:
            harmonic.assemble(fit, m, size, axes)
            found[i] = harmonic.solve(fit, size, dim, most, axes)
        if m > less and not found[i]:
            harmonic.assemble(fit, m, less, axes)
            found[i] = harmonic.solve(fit, less, dim, most, axes)
        for a in range(dim if found[i] else 0):
            out[i, a] = fit.right[a] / unit
    return found


@inlined
def _values(fit, member, n, i, f, bend, axes):
    """Complete the columns of n neighbours: polynomials, weights and data. bend : lap/(2 dim), lengths in units"""
    b, size = fit.b, harmonic.terms(3, axes)
    m = fill_up(b, n, axes)
    harmonic.fill_values(b, m, 3, axes)
    harmonic.weigh(fit.w, b, m, axes)
    for k in range(m):
        r2 = b[0, k] ** 2 + b[1, k] ** 2
        if len(axes) == 3:
            r2 += b[2, k] ** 2
        b[size, k] = -bend * r2
    for k in range(n):
        b[size, k] += f[np.uint32(member[k])] - f[i]
