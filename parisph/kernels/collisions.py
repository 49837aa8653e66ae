"""What keeps particles apart and out of walls, and the velocity filter."""

import math

import numpy as np

from parisph.base.fields import DRY, FLUID, WALL
from parisph.kernels.jit import kernel
from parisph.kernels.rankine import _first_row_of_inverse
from parisph.kernels.smoothing import quartic_weight


@kernel
def pair_collisions(change, u, x, kind, distance, restitution, indptr, indices, axes):
    """Velocity change by collisions of fluid pairs nearer than the distance and approaching.

    Every particle sums the impulses of its pairs from the velocities before: the result does
    not depend on the order of the pairs, nor on which rank owns which, and momentum is kept.

    change : (n_owned, dim) output [m/s]. Returns the number of colliding pairs (each counted
    once a particle).
    """
    dim = len(axes)
    d2 = distance * distance
    pairs = 0
    for i in range(len(indptr) - 1):
        change[i, :] = 0.0
        if kind[i] != FLUID:
            continue
        for k in range(indptr[i], indptr[i + 1]):
            j = indices[k]
            if kind[j] != FLUID:
                continue
            r2, approach = 0.0, 0.0
            for a in range(dim):
                r2 += (x[j, a] - x[i, a]) ** 2
                approach += (x[j, a] - x[i, a]) * (u[i, a] - u[j, a])
            if not 0.0 < r2 < d2 or approach <= 0.0:
                continue
            pairs += 1
            for a in range(dim):
                change[i, a] -= 0.5 * (1.0 + restitution) * approach / r2 * (x[j, a] - x[i, a])
    return pairs


@kernel
def wall_guard(u, x, kind, corner, normal, wall_u, distance, indptr, indices, axes):
    """Stop fluid nearer to a wall than the distance from moving further into it.

    The normal velocity relative to the wall becomes zero if it points into the wall; the
    wall is the plane of each nearby wall particle. Returns the number of particles stopped.
    """
    dim = len(axes)
    stopped = 0
    for i in range(len(indptr) - 1):
        if kind[i] != FLUID:
            continue
        hit = False
        for k in range(indptr[i], indptr[i + 1]):
            j = indices[k]
            if kind[j] != WALL or corner[j]:
                continue
            away, inward, beside = 0.0, 0.0, 0.0
            for a in range(dim):
                away += (x[i, a] - x[j, a]) * normal[j, a]
                inward += (u[i, a] - wall_u[j, a]) * normal[j, a]
                beside += (x[i, a] - x[j, a]) ** 2
            if away < distance and inward < 0.0 and beside - away * away < 4.0 * distance * distance:
                hit = True
                for a in range(dim):
                    u[i, a] -= inward * normal[j, a]
        stopped += hit
    return stopped


@kernel
def smooth_velocity(change, u, x, kind, role, strength, radius, indptr, indices, axes):
    """Velocity change -strength (u - linear MLS of u) at fluid particles, the particle included.

    A harmonic velocity has no Laplacian, so the wave itself passes almost untouched.
    """
    dim = len(axes)
    radius2 = radius * radius
    c = np.empty(dim + 1)
    m = np.empty((dim + 1, dim + 1))
    for i in range(len(indptr) - 1):
        change[i, :] = 0.0
        if kind[i] != FLUID:
            continue
        m[:, :] = 0.0
        m[0, 0] = 1.0
        for k in range(indptr[i], indptr[i + 1]):
            j = indices[k]
            w = _weight(i, j, x, role, radius2, axes)
            if w == 0.0:
                continue
            m[0, 0] += w
            for a in range(dim):
                d = w * (x[j, a] - x[i, a]) / radius
                m[a + 1, 0] += d
                for b in range(a + 1):
                    m[a + 1, b + 1] += d * (x[j, b] - x[i, b]) / radius
        if m[0, 0] < 1.0 + 1.0e-12:
            continue
        _first_row_of_inverse(c, m, axes)
        for k in range(indptr[i], indptr[i + 1]):
            j = indices[k]
            w = _weight(i, j, x, role, radius2, axes)
            if w == 0.0:
                continue
            share = c[0]
            for a in range(dim):
                share += c[a + 1] * (x[j, a] - x[i, a]) / radius
            for a in range(dim):
                change[i, a] += strength * w * share * (u[j, a] - u[i, a])


@kernel
def _weight(i, j, x, role, radius2, axes):
    if role[j] == DRY:
        return 0.0
    r2 = 0.0
    for a in range(len(axes)):
        r2 += (x[j, a] - x[i, a]) ** 2
    return quartic_weight(r2, radius2)
