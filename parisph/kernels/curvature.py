"""What a pressure that is not harmonic adds to derivatives from a fit by harmonic polynomials.

With lap p = f known, p - f r^2/(2 dim) is harmonic around a particle, up to terms of third order in r. The fit of it,
and so that of p, is of second order. In an inviscid flow that keeps its volume, f = rho (div F - tr((grad u)^2)) with
the force F per unit mass, the divergence of Euler's equation; the gradients of u and F are those of the same fit. div F
is 0 for uniform gravity, but not for the forces in a frame that turns.
"""

import numpy as np

from parisph.base.fields import WET
from parisph.kernels import harmonic
from parisph.kernels.jit import inlined, kernel


@kernel
def laplacian_of_pressure(out: np.ndarray, wanted: np.ndarray, density: float, u: np.ndarray, force: np.ndarray,
                          x: np.ndarray, role: np.ndarray, radius: float, most: float, indptr: np.ndarray,
                          indices: np.ndarray, axes: tuple[int, ...]) -> None:
    """Write the Laplacian of the pressure at the particles `wanted` (n_owned,) bool to out (n_owned,) [Pa/m^2].

    It is 0 elsewhere, and where neighbours do not suffice for the harmonic fit. most : as of harmonic.coefficients

    density [kg/m^3]; u : (n_all, dim) [m/s], walls with the velocity of `gradient.wall_velocity`
    force : (n_all, dim) [m/s^2]
    """
    c, work, b = harmonic.scratch(indptr, axes)
    g = np.empty((len(axes), len(axes)))
    for i in range(len(indptr) - 1):
        out[i] = 0.0
        if wanted[i] and harmonic.coefficients(c, i, x, role, radius, most, work, b, indptr, indices, axes):
            out[i] = density * _divergence(g, c, i, u, force, indptr, indices, axes)


@kernel
def add_at_walls(right: np.ndarray, laplacian: np.ndarray, count: np.ndarray, columns: np.ndarray, values: np.ndarray,
                 x: np.ndarray, role: np.ndarray, indptr: np.ndarray, axes: tuple[int, ...]) -> None:
    """Add what wall rows find for the part of the pressure that is not harmonic to the right-hand side (n_owned,) [Pa].

    Harmonic rows are then exact for every quadratic pressure.

    laplacian : (n_owned,) of the pressure [Pa/m^2], used at wet wall particles; others as of pressure.rows.Rows
    """
    dim = len(axes)
    for i in range(len(indptr) - 1):
        if role[i] != WET or laplacian[i] == 0.0:
            continue
        total = 0.0
        for k in range(indptr[i], indptr[i] + count[i]):
            total += values[k] * _square_distance(i, columns[k], x, axes)
        right[i] -= laplacian[i] * total / (2.0 * dim)


@inlined
def _divergence(g, c, i, u, force, indptr, indices, axes):
    """Return div F - tr(g^2) by the coefficients c of a fit, which also writes the velocity gradient g (dim, dim)."""
    dim, found = len(axes), 0.0
    for a in range(dim):
        for d in range(dim):
            g[a, d] = 0.0
            for k in range(indptr[i], indptr[i + 1]):
                g[a, d] += c[k - indptr[i], d] * (u[indices[k], a] - u[i, a])
        for k in range(indptr[i], indptr[i + 1]):
            found += c[k - indptr[i], a] * (force[indices[k], a] - force[i, a])
    for a in range(dim):
        for d in range(dim):
            found -= g[a, d] * g[d, a]
    return found


@inlined
def _square_distance(i, j, x, axes):
    r2 = 0.0
    for a in range(len(axes)):
        r2 += (x[j, a] - x[i, a]) ** 2
    return r2
