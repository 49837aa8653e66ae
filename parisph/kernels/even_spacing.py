"""Moves that keep the distances of neighbours even."""

import math

import numpy as np

from parisph.base.fields import FLUID, SURFACE
from parisph.kernels.jit import inlined, kernel, subkernel
from parisph.kernels.records import Cloud

# Radius of the neighbours that push, in spacings: those of the next layers, but not of the ones behind them, so that
# nothing is missing around the particles of the second layer.
REACH = 1.9    # tuned 1 to 2.6: radius of the neighbours that push, in spacings; judged
# The push of all neighbours over the displacement of a lone particle, in spacings: 1.60 of a line, 1.67 of the square
# lattice. Of the cubic one 1.96, so that a move there is 1.19 times as long.
STIFFNESS = 1.65
CLOSEST = 1e-3    # distance in spacings below which a push falls to 0: pairs in one place have no direction
TINY = float(np.finfo(float).tiny)  # keeps 0/0 away


@kernel
def even_out(move: np.ndarray, cloud: Cloud, across: np.ndarray, known: np.ndarray, strength: np.ndarray) -> None:
    """Write the moves of owned fluid away from neighbours that are too close (n_owned, dim) [m].

    Each neighbour within the reach pushes with (1 - q^2)^2, q = r/(1.9 s), wall particles across their wall only. On a
    lattice that is strained, the pushes from both sides are equal. Particles of the surface are pushed along it, by
    those of the surface and by walls where it meets them: wall particles that lie above each other count as one there.

    across : (n_owned, dim), any length, the direction across the surface; known : (n_all,) bool, walls with one normal
    strength : (n_owned,), part of a displacement of one particle on the lattice that is undone
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
    """Add the push of wall particle j at the square of a distance r2; size : of across^2 on the surface, else 0."""
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
    """Return the push over the distance r [1/m], by its square."""
    q2 = min(r2 / (REACH * spacing) ** 2, 1.0)
    return (1.0 - q2) ** 2 / max(math.sqrt(r2), CLOSEST * spacing)
