"""The gradient from a fit by harmonic polynomials, to the values of neighbours and to slopes across walls.

A stencil beside a wall is one-sided: nothing lies behind it. But the slope of pressure across a wall is known at each
of its particles (Z14 Eq 25), and so it is a datum of the fit like the value of a neighbour. Without it the pressure of
a wave ten spacings deep pushes the particles beside a wall too hard, by a tenth along the surface and along the bed.
"""

import numpy as np

from parisph.kernels import harmonic
from parisph.kernels.jit import inlined, kernel
from parisph.kernels.near import room_for
from parisph.kernels.roles import outside
from parisph.kernels.smoothing import quartic_weight

# The unit of length, in radii: 1.04 spacings for a radius of 2.6, so that all moments are of order one. A slope across
# a wall weighs as much as a difference between values over this length; a quarter or four times of it do as well.
UNIT = 0.4


@kernel
def harmonic_gradient(out: np.ndarray, f: np.ndarray, slope: np.ndarray, known: np.ndarray, laplacian: np.ndarray,
                      x: np.ndarray, role: np.ndarray, normal: np.ndarray, of: int, radius: float,
                      most: float, indptr: np.ndarray, indices: np.ndarray, axes: tuple[int, ...]) -> None:
    """Replace the gradient at particles of one role by that of the harmonic fit.

    The polynomials are of degree 3. Where the neighbours do not span them, or the terms above the first degree raise
    the variance of the slope to more than `most` times that of a linear fit, they are of degree 2. Where the neighbours
    do not suffice for these either, `out` keeps its value.

    out : (n_owned, dim), changed [unit of f per m]; f, x, role : (n_all, ...)
    slope : (n_all,) n . grad f at the walls that are `known` (n_all,) bool; normal : (n_all, dim)
    laplacian : (n_owned,) of f [unit of f per m^2], or without rows if f is harmonic. What it adds to values around a
        particle, lap r^2/(2 dim), and to slopes is not harmonic but known.
    of : the role; radius [m]
    """
    dim, size, less, room = len(axes), harmonic.terms(3, axes), harmonic.terms(2, axes), 2 * room_for(indptr)
    b, w, work = np.empty((size + 4, room)), np.empty((1, room)), np.empty((size, size + 3))
    right, scratch, moment, d = np.empty(size), np.empty(size), np.empty((dim, dim)), np.empty(dim)
    for i in range(len(indptr) - 1):
        if role[i] != of:
            continue
        lap = laplacian[i] / dim if len(laplacian) > 0 else 0.0
        m = _data(b, w, d, i, f, slope, known, lap, x, role, normal, radius, indptr, indices, axes)
        sound = m > size and harmonic.fit(right, work, moment, scratch, b, w, m, size, most, axes)
        if not sound:    # the columns of degree 2 are the first ones
            sound = m > less and harmonic.fit(right, work, moment, scratch, b, w, m, less, most, axes)
        if sound:
            for a in range(dim):
                out[i, a] = right[a] / (UNIT * radius)


@inlined
def _data(b, w, d, i, f, slope, known, lap, x, role, normal, radius, indptr, indices, axes):
    """Write the data of the fit around particle i to columns; return their number. lap : the Laplacian over dim."""
    dim, unit, last, m = len(axes), UNIT * radius, len(b) - 1, 0
    for k in range(indptr[i], indptr[i + 1]):
        j = indices[k]
        inside, across = not outside(role[j]), known[j]
        if not (inside or across):
            continue
        r2, away = 0.0, 0.0
        for a in range(dim):
            d[a] = x[j, a] - x[i, a]
            r2 += d[a] * d[a]
            away += normal[j, a] * d[a]
            d[a] /= unit
        weight = quartic_weight(r2, radius * radius)
        if weight == 0.0:
            continue
        if inside:
            harmonic.fill_values(b, m, d, 3, axes)
            w[0, m], b[last, m] = weight, f[j] - f[i] - 0.5 * lap * r2
            m += 1
        if across:
            harmonic.fill_slopes(b, m, d, normal[j], 3, axes)
            w[0, m], b[last, m] = weight, (slope[j] - lap * away) * unit
            m += 1
    return m
