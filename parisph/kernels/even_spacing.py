"""Displacements that keep the distances of neighbours even."""

import math

import numpy as np

from parisph.base.fields import FLUID, SURFACE
from parisph.kernels.jit import inlined, kernel, subkernel
from parisph.kernels.records import Cloud

# The reach includes the next layer but not the one behind it, so that the second layer has all its neighbours.
REACH = 1.9    # tuned 1 to 2.6: radius of the neighbours that push, in spacings; judged
# Total push over the displacement of a single particle, in spacings: 1.60 on a line, 1.67 on the square lattice, and
# 1.96 on the cubic one, where moves are thus 1.19 times as long.
STIFFNESS = 1.65
CLOSEST = 1e-3    # distance in spacings below which a push falls to 0, as coincident pairs have no direction
TINY = float(np.finfo(float).tiny)  # avoids 0/0


@kernel
def even_out(move: np.ndarray, cloud: Cloud, across: np.ndarray, known: np.ndarray, strength: np.ndarray) -> None:
    """Write the moves of owned fluid away from neighbours that are too close (n_owned, dim) [m].

    Each neighbour within the reach pushes with (1 - q^2)^2, q = r/(1.9 s); wall particles push along their normal only.
    On a uniformly strained lattice, the pushes from both sides cancel. Surface particles are pushed along the surface,
    by other surface particles and by walls: there, wall particles above each other count as one.

    across : (n_owned, dim), the direction across the surface, of any length; known : (n_all,) bool, walls with one
        normal
    strength : (n_owned,), the part of a single particle's displacement on the lattice that is undone
    """
    x, role, indptr, dim, spacing = cloud.x, cloud.role, cloud.indptr, len(cloud.axes), cloud.spacing
    push, reach2 = np.empty(dim), (REACH * spacing) ** 2
    for i in range(len(indptr) - 1):
        move[i, :] = 0.0
        if cloud.kind[i] != FLUID:
            continue
        on, size = role[i] == SURFACE, TINY
        push[:] = 0.0
        for a in range(dim):
            size += across[i, a] ** 2
        for k in range(np.uint32(indptr[i]), np.uint32(indptr[i + 1])):
            j = np.uint32(cloud.indices[k])
            r2 = 0.0
            for a in range(dim):
                r2 += (x[i, a] - x[j, a]) ** 2
            if cloud.kind[j] == FLUID:
                if r2 < reach2 and (not on or role[j] == SURFACE):
                    f = _push(r2, spacing)
                    for a in range(dim):
                        push[a] += f * (x[i, a] - x[j, a])
            elif known[j]:
                _add_push_of_wall(push, i, j, r2, cloud, across, size if on else 0.0)
        if on:
            along = 0.0
            for a in range(dim):
                along += across[i, a] * push[a]
            for a in range(dim):
                push[a] -= along / size * across[i, a]
        for a in range(dim):
            move[i, a] = strength[i] / STIFFNESS * spacing * push[a]


@inlined
def _add_push_of_wall(push, i, j, r2, cloud, across, size):
    """Add the push of wall particle j at the squared distance r2. size : across^2 on the surface, else 0"""
    share, away, above = 1.0, 0.0, 0.0
    for a in range(len(cloud.axes)):
        away += cloud.normal[j, a] * (cloud.x[i, a] - cloud.x[j, a])
        above += across[i, a] * (cloud.x[i, a] - cloud.x[j, a])
    if size > 0.0:
        above2 = above * above / size
        r2 -= above2
        share = max(1.0 - math.sqrt(above2) / cloud.spacing, 0.0)
    f = share * _push(max(r2, 0.0), cloud.spacing) * away
    for a in range(len(cloud.axes)):
        push[a] += f * cloud.normal[j, a]


@subkernel
def _push(r2, spacing):
    """Return the push over the distance r [1/m]."""
    q2 = min(r2 / (REACH * spacing) ** 2, 1.0)
    return (1.0 - q2) ** 2 / max(math.sqrt(r2), CLOSEST * spacing)
