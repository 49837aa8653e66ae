"""The velocity gradient of the fluid, and its rate of strain."""

import math

import numpy as np

from parisph.base.fields import FLUID
from parisph.kernels.gradient import support
from parisph.kernels.jit import kernel
from parisph.kernels.near import dot, fill_up, gather, room_for


@kernel
def velocity_gradient(g: np.ndarray, rate: np.ndarray, u: np.ndarray, x: np.ndarray, kind: np.ndarray, role: np.ndarray,
                      radius: float, floor: float, indptr: np.ndarray, indices: np.ndarray,
                      axes: tuple[int, ...]) -> None:
    """Gradient of the velocity at owned fluid particles, by linear least squares with the quartic weight.

    It is exact for a linear velocity. It is zero at walls, and where the neighbours do not span the
    plane: fewer than dim + 1 of them, or det/(trace/dim)^dim of their moment < floor.

    g : (n_owned, dim, dim) output, g[i, a, b] = d u_a / d x_b [1/s]
    rate : (n_owned,) output, sqrt(2 S : S) with S the symmetric part of g [1/s]
    u, x, kind, role : of owned and ghost particles, walls with the velocity of `wall_velocity`
    """
    dim, room = len(axes), room_for(indptr)
    near, weighted, difference = np.empty((dim, room)), np.empty((dim + 1, room)), np.empty((1, room))
    member = np.empty(room, np.int32)
    m, inverse = np.empty((dim, dim)), np.empty((dim, dim))
    for i in range(len(indptr) - 1):
        g[i] = 0.0
        rate[i] = 0.0
        if kind[i] != FLUID:
            continue
        n = gather(near, member, 0, i, x, role, radius, indptr, indices, axes)
        columns = fill_up(near, n, axes)
        if support(m, inverse, weighted, near, 0, n, columns, axes) < floor:
            continue
        for c in range(dim):
            for k in range(columns):
                difference[0, k] = (u[member[k], c] - u[i, c]) / radius if k < n else 0.0
            for b in range(dim):
                right = dot(weighted, 1 + b, difference, 0, columns)
                for a in range(dim):
                    g[i, c, a] += inverse[a, b] * right
        rate[i] = _strain_rate(g, i, axes)


@kernel
def _strain_rate(g, i, axes):
    square = 0.0
    for a in range(len(axes)):
        for b in range(len(axes)):
            square += (0.5 * (g[i, a, b] + g[i, b, a])) ** 2
    return math.sqrt(2.0 * square)


@kernel
def mean_over_fluid(out: np.ndarray, f: np.ndarray, x: np.ndarray, kind: np.ndarray, radius: float, indptr: np.ndarray,
                    indices: np.ndarray, axes: tuple[int, ...]) -> None:
    """Mean of a scalar over the fluid within the radius, the particle itself included.

    out : (n_owned,) output, zero at walls; f, x, kind : of owned and ghost particles
    """
    radius2 = radius * radius
    for i in range(len(indptr) - 1):
        out[i] = 0.0
        if kind[i] != FLUID:
            continue
        total, n = f[i], 1
        for k in range(indptr[i], indptr[i + 1]):
            j = indices[k]
            if kind[j] != FLUID:
                continue
            r2 = 0.0
            for a in range(len(axes)):
                r2 += (x[j, a] - x[i, a]) ** 2
            if r2 < radius2:
                total += f[j]
                n += 1
        out[i] = total / n
