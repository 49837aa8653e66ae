"""The potential flow around each particle: a fit to the velocities of its neighbours and across walls.

Waves are irrotational. What a velocity has beyond the gradient of a harmonic function is an error of the method:
roughness, a residual divergence, or a vortex that the small errors of the pressure gradient drive for many periods.
"""

from typing import NamedTuple

import numpy as np

from parisph.base.fields import BALLISTIC, FLUID, WALL, WET
from parisph.kernels import harmonic
from parisph.kernels.harmonic_gradient import UNIT
from parisph.kernels.jit import inlined, kernel
from parisph.kernels.near import room_for
from parisph.kernels.smoothing import quartic_weight


class Potential(NamedTuple):
    """The potential flow that a velocity is close to.

    beyond : (n_owned, dim) [m/s], what the velocity of fluid has beyond it; square : (n_owned,) [1/s^2], tr(G^2) of its
        velocity gradient G, at fluid and wet walls
    """

    beyond: np.ndarray
    square: np.ndarray


@kernel
def fit_potential(beyond: np.ndarray, square: np.ndarray, u: np.ndarray, x: np.ndarray, kind: np.ndarray,
                  role: np.ndarray, known: np.ndarray, normal: np.ndarray, across: np.ndarray, radius: float,
                  indptr: np.ndarray, indices: np.ndarray, axes: tuple[int, ...]) -> None:
    """Fit u = grad f around fluid and wet walls, with f a harmonic polynomial of degree 3.

    Where that takes more data than there are, as at walls in the edges of a box, it is of degree 2. The data are the
    velocities of the fluid within the radius, the particle itself included, and those across walls.

    beyond : (n_owned, dim) output [m/s], u - grad f of fluid, 0 elsewhere
    square : (n_owned,) output [1/s^2], tr((grad grad f)^2); both are 0 where the data do not determine f
    u : (n_all, dim) [m/s]; known : (n_all,) bool, walls with one normal; across : (n_all,) n . u of walls [m/s]
    """
    dim, size, room = len(axes), harmonic.terms(3, axes), len(axes) * (room_for(indptr) + 1)
    b, w, work = np.empty((size + 4, room)), np.empty((1, room)), np.empty((size, size + 3))
    right, scratch, moment = np.empty(size), np.empty(size), np.empty((dim, dim))
    d, one = np.empty(dim), np.eye(dim)
    for i in range(len(indptr) - 1):
        beyond[i, :] = 0.0
        square[i] = 0.0
        if role[i] == BALLISTIC or (kind[i] == WALL and role[i] != WET):
            continue
        m = _data(b, w, d, one, i, u, x, kind, known, normal, across, radius, indptr, indices, axes)
        sound = False
        for less in range(2):
            n = harmonic.terms(3 - less, axes)
            sound = m > n and harmonic.fit(right, work, moment, scratch, b, w, m, n, np.inf, axes)
            if sound:
                break
        if not sound:
            continue
        square[i] = _square(right, axes) / (UNIT * radius) ** 2
        if kind[i] == FLUID:
            for a in range(dim):
                beyond[i, a] = u[i, a] - right[a]


@inlined
def _data(b, w, d, one, i, u, x, kind, known, normal, across, radius, indptr, indices, axes):
    """Write the data of the fit around particle i to columns; return their number."""
    dim, unit, last, m = len(axes), UNIT * radius, len(b) - 1, 0
    d[:] = 0.0
    if kind[i] == FLUID:
        for a in range(dim):
            harmonic.fill_slopes(b, m, d, one[a], 3, axes)
            w[0, m], b[last, m] = 1.0, u[i, a]
            m += 1
    elif known[i]:
        harmonic.fill_slopes(b, m, d, normal[i], 3, axes)
        w[0, m], b[last, m] = 1.0, across[i]
        m += 1
    for k in range(indptr[i], indptr[i + 1]):
        j = indices[k]
        if kind[j] != FLUID and not known[j]:
            continue
        r2 = 0.0
        for a in range(dim):
            d[a] = x[j, a] - x[i, a]
            r2 += d[a] * d[a]
            d[a] /= unit
        weight = quartic_weight(r2, radius * radius)
        if weight == 0.0:
            continue
        if kind[j] == FLUID:
            for a in range(dim):
                harmonic.fill_slopes(b, m, d, one[a], 3, axes)
                w[0, m], b[last, m] = weight, u[j, a]
                m += 1
        else:
            harmonic.fill_slopes(b, m, d, normal[j], 3, axes)
            w[0, m], b[last, m] = weight, across[j]
            m += 1
    return m


@inlined
def _square(c, axes):
    """Return the sum of the squares of the second derivatives, by the coefficients of degree 2."""
    if len(axes) == 2:
        return 2.0 * (4.0 * c[2] * c[2] + c[3] * c[3])
    xx, yy, zz = 2.0 * c[3], 2.0 * (c[4] - c[3]), -2.0 * c[4]
    return xx * xx + yy * yy + zz * zz + 2.0 * (c[5] * c[5] + c[6] * c[6] + c[7] * c[7])
