"""Collisions of pairs of fluid particles."""

import numpy as np

from parisph.base.fields import FLUID
from parisph.kernels.jit import kernel, subkernel
from parisph.kernels.records import Cloud

ROUNDING = 1e-9    # of the approach by a linear velocity: what differs from it by less is linear


@kernel
def count_collisions(number: np.ndarray, cloud: Cloud, u: np.ndarray, distance: float) -> None:
    """Number of fluid neighbours closer than the distance that each owned particle approaches: (n_owned,).

    These are at least as many as it collides with (pair_collisions).
    """
    x, kind, indptr, indices, axes = cloud.x, cloud.kind, cloud.indptr, cloud.indices, cloud.axes
    for i in range(len(indptr) - 1):
        number[i] = 0
        if kind[i] != FLUID:
            continue
        for k in range(indptr[i], indptr[i + 1]):
            j = indices[k]
            if kind[j] == FLUID:
                r2, approach = 0.0, 0.0
                for a in range(len(axes)):
                    r2 += (x[j, a] - x[i, a]) ** 2
                    approach += (x[j, a] - x[i, a]) * (u[i, a] - u[j, a])
                number[i] += 0.0 < r2 < distance * distance and approach > 0.0


@kernel
def pair_collisions(change: np.ndarray, cloud: Cloud, number: np.ndarray, u: np.ndarray, g: np.ndarray, distance: float,
                    restitution: float) -> int:
    """Velocity change by collisions of fluid pairs that are closer than the distance and approach.

    What counts is the approach beyond that of a linear velocity, d . (u_i - u_j) + d . (g_i + g_j) d/2
    with d = x_j - x_i, or all of it if that is less: smooth strain never collides. Each impulse is
    divided by the larger `number` of the two. Momentum is then conserved (with masses in
    proportion to the volumes), and energy does not rise as long as no mass is more than 1/(1 +
    restitution) of the two. Impulses are computed from the velocities before the collisions: the
    result depends neither on the order of the pairs nor on the rank that owns a particle.

    change : (n_owned, dim) output [m/s]; number : (n_all,) of count_collisions
    g : (n_all, dim, dim), velocity gradient [1/s]; the volumes of fluid must be > 0
    Returns the number of colliding pairs (each counted once per particle).
    """
    x, kind, volume, indptr, indices = cloud.x, cloud.kind, cloud.volume, cloud.indptr, cloud.indices
    axes, dim, pairs = cloud.axes, len(cloud.axes), 0
    for i in range(len(indptr) - 1):
        change[i, :] = 0.0
        if kind[i] != FLUID or number[i] == 0:
            continue
        for k in range(indptr[i], indptr[i + 1]):
            j = indices[k]
            if kind[j] != FLUID:
                continue
            r2, approach = _approach(i, j, x, u, g, axes)
            if not 0.0 < r2 < distance * distance or approach <= 0.0:
                continue
            pairs += 1
            share = volume[j] / (volume[i] + volume[j]) / max(number[i], number[j])
            for a in range(dim):
                change[i, a] -= share * (1.0 + restitution) * approach / r2 * (x[j, a] - x[i, a])
    return pairs


@subkernel
def _approach(i, j, x, u, g, axes):
    """Return r^2, and d . (u_i - u_j) or that beyond a linear velocity, whichever is less."""
    r2, full, smooth = 0.0, 0.0, 0.0
    for a in range(len(axes)):
        d = x[j, a] - x[i, a]
        r2 += d * d
        full += d * (u[i, a] - u[j, a])
        for b in range(len(axes)):
            smooth -= 0.5 * d * (g[i, a, b] + g[j, a, b]) * (x[j, b] - x[i, b])
    beyond = full - smooth
    return r2, min(full, beyond) if beyond > ROUNDING * abs(smooth) else 0.0
