"""Velocity gradient of the fluid, its rate of strain, and the velocity's deviation from a fit."""

import math

import numpy as np

from parisph.base.fields import FLUID
from parisph.kernels.gradient import fitted
from parisph.kernels.jit import inlined, kernel, subkernel
from parisph.kernels.mls import linear_fit, moment_count
from parisph.kernels.near import fill_up, gather_within, room_for, sum_changes
from parisph.kernels.records import Cloud

# The weight is 1 if the fit passes through the particle, and .6 to .8 beside a contact line, where surface particles
# would creep without the filter.
ALONE = 0.95    # tuned 0.475 to 1: weight of a particle in its own mean above which it has no fit; measured
TINY = float(np.finfo(float).tiny)  # avoids 0/0


@kernel
def velocity_gradient(g: np.ndarray, rate: np.ndarray, beyond: np.ndarray, cloud: Cloud, u: np.ndarray, radius: float,
                      floor: float) -> None:
    """Write the velocity gradient of owned fluid by linear least squares, and the velocity's deviation from the fit.

    The weight is quartic. The gradient is exact for a linear velocity. It is zero at walls, and where the neighbours do
    not span the plane: fewer than dim + 1 of them, or det/(trace/dim)^dim of their moment < floor.

    The filter removes the deviation: the velocity minus its moving least squares, which include the particle itself. It
    is almost zero in a wave, as a harmonic velocity has no Laplacian. It is set to zero where the neighbours do not
    span a plane (jets, drops), because an extrapolation from two neighbours is unbounded.

    g : (n_owned, dim, dim) output, g[i, a, b] = d u_a / d x_b [1/s]
    rate : (n_owned,) output, sqrt(2 S : S) with S the symmetric part of g [1/s]; g and rate may have no rows
    beyond : (n_owned, dim) output, the deviation [m/s], or without rows
    u : (n_all, dim) [m/s], of walls that of gradient.wall_velocity; radius : of the weight [m]
    """
    kind, indptr, axes = cloud.kind, cloud.indptr, cloud.axes
    dim, room = len(axes), room_for(indptr)
    near, weighted, difference = np.empty((dim, room)), np.empty((1, room)), np.empty((dim, room))
    member = np.empty(room, np.int32)
    m, inverse, sums = np.empty((dim, dim)), np.empty((dim, dim)), np.empty(1 + dim)
    moments, fit, here = np.empty((moment_count(axes), 1)), np.empty((dim + 1, 1)), np.zeros((dim, 1))
    for i in range(len(indptr) - 1):
        for c in range(dim if len(g) > 0 else 0):
            rate[i] = 0.0
            for a in range(dim):
                g[i, c, a] = 0.0
        for c in range(dim if len(beyond) > 0 else 0):
            beyond[i, c] = 0.0
        if kind[i] != FLUID:
            continue
        n = gather_within(near, member, 0, i, cloud, radius, radius)
        columns = fill_up(near, n, axes)
        spans = fitted(m, inverse, moments, weighted, near, 0, columns, axes) >= floor and len(g) > 0
        smooth = len(beyond) > 0 and _fit_here(fit, moments, here, axes)
        if not (spans or smooth):
            continue
        _differences(difference, u, member, i, n, columns, axes)
        for c in range(dim):
            sum_changes(sums, weighted, near, difference, c, columns, axes)
            if smooth:
                for r in range(1 + dim):
                    beyond[i, c] -= fit[r, 0] * sums[r]
            for b in range(dim if spans else 0):
                for a in range(dim):
                    g[i, c, a] += inverse[a, b] * sums[1 + b] / radius
        if spans:
            rate[i] = _strain_rate(g, i, axes)


@inlined
def _fit_here(fit, moments, here, axes):
    """Write the fit of neighbours and the particle, with weight 1; return whether it is linear and uses neighbours.

    moments : of the neighbours; the particle is added
    """
    moments[0, 0] += 1.0
    return linear_fit(fit, moments, here, 1, axes) == 1 and 0.0 < fit[0, 0] < ALONE


@inlined
def _differences(difference, u, member, i, n, columns, axes):
    """Write the velocities of n neighbours relative to that of particle i, (dim, columns)."""
    for k in range(n):
        j = np.uint32(member[k])
        for c in range(len(axes)):
            difference[c, k] = u[j, c] - u[i, c]
    for k in range(n, columns):
        for c in range(len(axes)):
            difference[c, k] = 0.0


@subkernel
def _strain_rate(g, i, axes):
    square = 0.0
    for a in range(len(axes)):
        for b in range(len(axes)):
            square += (0.5 * (g[i, a, b] + g[i, b, a])) ** 2
    return math.sqrt(2.0 * square)


@kernel
def mean_over_fluid(out: np.ndarray, cloud: Cloud, f: np.ndarray, radius: float) -> None:
    """Write the mean of f (n_all,) over fluid within the radius [m], itself included: (n_owned,), 0 at walls."""
    x, kind, indptr, indices, axes = cloud.x, cloud.kind, cloud.indptr, cloud.indices, cloud.axes
    radius2 = radius * radius
    for i in range(len(indptr) - 1):
        out[i] = 0.0
        if kind[i] != FLUID:
            continue
        total, n, cx, cy = f[i], 1.0, x[i, 0], x[i, 1]
        cz = x[i, 2] if len(axes) == 3 else 0.0
        for k in range(np.uint32(indptr[i]), np.uint32(indptr[i + 1])):
            j = np.uint32(indices[k])
            dx, dy = x[j, 0] - cx, x[j, 1] - cy
            r2 = dx * dx + dy * dy
            if len(axes) == 3:
                r2 += (x[j, 2] - cz) ** 2
            counts = 1.0 if (kind[j] == FLUID) & (r2 < radius2) else 0.0    # no branch, as half of them count
            total += counts * f[j]
            n += counts
        out[i] = total / n


@kernel
def judge(out: np.ndarray, rate: np.ndarray, by_pressure: np.ndarray, spacing: float, dt: float, rest: float,
          quick: float, disorder: float) -> None:
    """Write the strain of a step, its rapidity, and the density error that may be disorder: out (3, n).

    With the rate D and the acceleration a by pressure alone: the strain dt D, reduced where D is far below rest
    sqrt(a/s); rapid = D^2/(D^2 + quick^2 a/s), from 0 in calm fluid to 1; the error disorder (1 - rapid). Rapid strain
    packs particles faster than disorder does, and its whole error is compression.

    rate : (n,) [1/s]; by_pressure : (n,) [m/s^2]; spacing [m]; dt [s]
    """
    strained, rapid, doubt = out[0], out[1], out[2]
    for i in range(len(rate)):
        square = by_pressure[i] / spacing
        calm = quick * quick * square
        rapid[i] = 1.0 - calm / max(calm + rate[i] ** 2, TINY)
        doubt[i] = disorder * (1.0 - rapid[i])
        strained[i] = dt * rate[i] * rate[i] / max(rate[i] + rest * math.sqrt(square), TINY)
