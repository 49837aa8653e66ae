"""Moves that keep the distances of neighbours even."""

import math

import numpy as np

from parisph.base.fields import FLUID, SURFACE, WALL
from parisph.kernels.jit import kernel, subkernel

# Radius of the neighbours that push, in spacings: those of the next layers, but not of the ones behind them, so that
# nothing is missing around the particles of the second layer.
REACH = 1.9
# The push of all neighbours over the displacement of a lone particle, in spacings: 1.60 of a line, 1.67 of the square
# lattice, 1.62 of the cubic one.
STIFFNESS = 1.65


@kernel
def even_out(move: np.ndarray, across: np.ndarray, x: np.ndarray, kind: np.ndarray, role: np.ndarray,
             normal: np.ndarray, strength: np.ndarray, spacing: float, indptr: np.ndarray, indices: np.ndarray,
             axes: tuple[int, ...]) -> None:
    """Write the moves of owned fluid away from neighbours that are too close (n_owned, dim) [m].

    Each neighbour within the reach pushes with (1 - q^2)^2, q = r/(1.9 s). On a lattice that is strained, the pushes
    from both sides are equal. Particles of the surface are pushed along it, by those of the surface and by the nearest
    wall.

    across : (n_owned, dim), any length, the direction across the surface; strength : (n_owned,), part of a displacement
        of one particle on the lattice that is undone
    """
    dim = len(axes)
    push = np.empty(dim)
    for i in range(len(indptr) - 1):
        move[i, :] = 0.0
        if kind[i] != FLUID:
            continue
        on = role[i] == SURFACE
        push[:] = 0.0
        wall, least = -1, REACH * spacing
        for k in range(indptr[i], indptr[i + 1]):
            j = indices[k]
            if on and kind[j] == WALL:
                away = 0.0
                for a in range(dim):
                    away += normal[j, a] * (x[i, a] - x[j, a])
                if away < least:
                    wall, least = j, away
            elif not on or role[j] == SURFACE:
                r2 = 0.0
                for a in range(dim):
                    r2 += (x[j, a] - x[i, a]) ** 2
                f = _push(math.sqrt(r2), spacing)
                for a in range(dim):
                    push[a] -= f * (x[j, a] - x[i, a])
        if wall >= 0:
            f = _push(max(least, 0.0), spacing) * least
            for a in range(dim):
                push[a] += f * normal[wall, a]
        if on:
            size, along = 0.0, 0.0
            for a in range(dim):
                size += across[i, a] ** 2
                along += across[i, a] * push[a]
            for a in range(dim):
                push[a] -= along / max(size, 1e-300) * across[i, a]
        for a in range(dim):
            move[i, a] = strength[i] / STIFFNESS * spacing * push[a]


@subkernel
def _push(r, spacing):
    """Return the push over the distance r [1/m]."""
    q2 = min((r / (REACH * spacing)) ** 2, 1.0)
    return (1.0 - q2) ** 2 / max(r, 1e-3 * spacing)
