"""Collisions of pairs of fluid particles."""

import numpy as np

from parisph.base.fields import FLUID
from parisph.kernels.jit import kernel, subkernel
from parisph.kernels.records import Cloud

ROUNDING = 1e-9    # smallest deviation from the approach by a linear velocity, relative to it


@kernel
def count_collisions(number: np.ndarray, cloud: Cloud, u: np.ndarray, distance: float) -> None:
    """Write the number of approaching fluid neighbours within the distance of each owned particle: (n_owned,).

    It is at least the number of its collisions (`pair_collisions`).
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
    """Write the velocity change by collisions of approaching fluid pairs closer than the distance; return their number.

    The approach is the smaller of d . (u_i - u_j) and its excess over a linear velocity, d . (u_i - u_j) + d . (g_i +
    g_j) d/2, with d = x_j - x_i. Smooth strain thus causes no collisions. Each impulse is divided by the larger
    `number` of the pair. Momentum is conserved for masses in proportion to the volumes. Energy does not rise, whatever
    the masses: a pair alone loses it, and the change of a particle is a mean over its pairs. All impulses use the
    velocities before the collisions, so that the result is independent of the order of pairs and of ranks.

    change : (n_owned, dim) output [m/s]; number : (n_all,) of count_collisions
    g : (n_all, dim, dim), velocity gradient [1/s]; the volumes of fluid must be > 0
    Returns the number of colliding pairs, counted once per particle.
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
    """Return r^2 and the smaller of d . (u_i - u_j) and its excess over a linear velocity."""
    r2, full, smooth = 0.0, 0.0, 0.0
    for a in range(len(axes)):
        d = x[j, a] - x[i, a]
        r2 += d * d
        full += d * (u[i, a] - u[j, a])
        for b in range(len(axes)):
            smooth -= 0.5 * d * (g[i, a, b] + g[j, a, b]) * (x[j, b] - x[i, b])
    beyond = full - smooth
    return r2, min(full, beyond) if beyond > ROUNDING * abs(smooth) else 0.0
