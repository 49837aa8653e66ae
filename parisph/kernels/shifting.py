"""Regularisation of positions: Fick shift, and the density error for the position projection."""

import math

import numpy as np

from parisph.base.fields import FLUID, INNER, WALL
from parisph.kernels.halves import beside_node
from parisph.kernels.jit import inlined, kernel, subkernel
from parisph.kernels.records import Cloud

# The solid behind a wall does not move as fluid there would, so it holds a layer at its distance half as stiffly. Dam
# break (H/s = 40): P2 errs by .074 with 1 (nine starts), .069 with 1.5 and .072 with 2 (six starts each), and the
# energy rises by .17, .12 and .09 %.
STIFF = 1.5    # tuned 0.75 to 3: weight of the gradient of concentration across a wall; measured


@kernel
def compression(e: np.ndarray, cloud: Cloud, alpha: np.ndarray, doubt: np.ndarray, limit: float,
                reach: float) -> None:
    """Write the relative density error that the position projection removes.

    e = alpha - 1 at inner particles, clipped to +-limit. With a surface particle within the reach [m], only the excess
    of alpha - 1 over the doubt counts: there alpha < 1 because of the surface, not of a void. Without the doubt, only
    the positive errors of disorder would remain, and their mean would push the surface outwards: a wave would gain
    energy.

    e : (n_owned,) output; alpha, doubt : (n_owned,)
    """
    role, reach2, bare = cloud.role, reach * reach, _without_equation(cloud.kind, cloud.role)
    for i in range(len(cloud.indptr) - 1):
        e[i] = 0.0
        if role[i] != INNER:
            continue
        e[i] = min(max(alpha[i] - 1.0, -limit), limit)
        if e[i] != 0.0 and _any(bare, i, cloud) and _near_surface(i, bare, reach2, cloud):
            e[i] = max(e[i] - doubt[i], 0.0)


@kernel
def stiffen(gradient: np.ndarray, cloud: Cloud, covered: np.ndarray, weight: np.ndarray) -> None:
    """Multiply the gradient of concentration across walls by STIFF, beside the covered ones.

    gradient : (n_owned, dim), changed; covered : (n_all,) of wetness.covered_walls
    weight : (n_all,), of nodes the part of a cell inside the fluid
    """
    dim = len(cloud.axes)
    n = np.empty(dim)
    for j in range(len(gradient)):
        if cloud.role[j] != INNER:
            continue
        n[:] = 0.0
        for k in range(cloud.indptr[j], cloud.indptr[j + 1]):
            i = cloud.indices[k]
            if cloud.kind[i] == WALL:
                part = covered[i] * beside_node(i, j, cloud, weight[i])
                for a in range(dim):
                    n[a] += part * cloud.normal[i, a]
        size2, along = 0.0, 0.0
        for a in range(dim):
            size2 += n[a] * n[a]
            along += gradient[j, a] * n[a]
        if size2 > 0.0:
            for a in range(dim):
                gradient[j, a] += (STIFF - 1.0) * min(math.sqrt(size2), 1.0) * along * n[a] / size2


@subkernel
def _without_equation(kind, role):
    """Return which particles are fluid without a pressure equation, (n_all,) bool."""
    bare = np.empty(len(kind), np.bool_)
    for j in range(len(kind)):
        bare[j] = (kind[j] == FLUID) & (role[j] != INNER)
    return bare


@inlined
def _any(marked, i, cloud):
    """Return whether any listed neighbour of i is marked. As most have none, a loop without branches takes a third."""
    found = False
    for k in range(np.uint32(cloud.indptr[i]), np.uint32(cloud.indptr[i + 1])):
        found |= marked[np.uint32(cloud.indices[k])]
    return found


@inlined
def _near_surface(i, bare, reach2, cloud):
    """Return whether a marked neighbour lies within the reach of particle i."""
    for k in range(cloud.indptr[i], cloud.indptr[i + 1]):
        j = cloud.indices[k]
        if bare[j]:
            r2 = 0.0
            for a in range(len(cloud.axes)):
                r2 += (cloud.x[j, a] - cloud.x[i, a]) ** 2
            if r2 < reach2:
                return True
    return False


@kernel
def fick_shift(shift: np.ndarray, cloud: Cloud, gradient: np.ndarray, strength: np.ndarray, cap: float,
               reach: float) -> None:
    """Write the shift down the gradient of concentration; near the surface, only along it.

    dr = -strength grad alpha (Lind et al. 2012), |dr| <= cap; zero on the surface. Within the reach of a surface
    particle the part along the surface normal is removed; the normal is the mean of the surface particles' grad alpha
    weighted by 1/r^2.

    shift : (n_owned, dim) output [m]; gradient : (n_all, dim); strength : (n_owned,), C h^2 [m^2]
    """
    role, axes, dim = cloud.role, cloud.axes, len(cloud.axes)
    bare, direction = _without_equation(cloud.kind, role), np.empty(dim)
    for i in range(len(cloud.indptr) - 1):
        for a in range(dim):
            shift[i, a] = -strength[i] * gradient[i, a] if role[i] == INNER else 0.0
        if role[i] != INNER:
            continue
        if _any(bare, i, cloud):
            _surface_normal(direction, i, gradient, bare, reach * reach, cloud)
            _remove_along(shift, i, direction, axes)
        limit_length(shift, i, cap, axes)


@inlined
def _surface_normal(direction, i, gradient, bare, reach2, cloud):
    """Write the sum of grad alpha/r^2 of the marked neighbours within the reach of particle i."""
    x, dim = cloud.x, len(cloud.axes)
    for a in range(dim):
        direction[a] = 0.0
    for k in range(cloud.indptr[i], cloud.indptr[i + 1]):
        j = cloud.indices[k]
        if not bare[j]:
            continue
        r2 = 0.0
        for a in range(dim):
            r2 += (x[j, a] - x[i, a]) ** 2
        if 0.0 < r2 < reach2:
            for a in range(dim):
                direction[a] += gradient[j, a] / r2


@subkernel
def _remove_along(shift, i, direction, axes):
    norm2, along = 0.0, 0.0
    for a in range(len(axes)):
        norm2 += direction[a] ** 2
        along += direction[a] * shift[i, a]
    if norm2 > 0.0:
        for a in range(len(axes)):
            shift[i, a] -= along / norm2 * direction[a]


@subkernel
def limit_length(vector: np.ndarray, i: int, cap: float, axes: tuple[int, ...]) -> None:
    """Shorten row i of a vector field to the cap."""
    length2 = 0.0
    for a in range(len(axes)):
        length2 += vector[i, a] ** 2
    if length2 > cap * cap:
        for a in range(len(axes)):
            vector[i, a] *= cap / math.sqrt(length2)


@kernel
def limit_lengths(vector: np.ndarray, n: int, cap: float, axes: tuple[int, ...]) -> None:
    """Shorten the first n rows of a vector field to the cap."""
    for i in range(n):
        limit_length(vector, i, cap, axes)


@kernel
def cap_together(moves: tuple[np.ndarray, ...], free: np.ndarray, cap: float) -> None:
    """Shorten the moves of each particle if their sum exceeds both the cap and the longest free move.

    moves : each (n, dim) [m], changed in place; free : (number of moves,) bool; cap : [m]
    """
    n, dim = moves[0].shape
    for i in range(n):
        longest, whole = cap * cap, 0.0
        for a in range(dim):
            total = 0.0
            for move in moves:
                total += move[i, a]
            whole += total * total
        if whole <= longest:
            continue
        for m in range(len(moves)):
            length = 0.0
            for a in range(dim):
                length += moves[m][i, a] ** 2
            if free[m]:
                longest = max(longest, length)
        if whole > longest:
            share = math.sqrt(longest / whole)
            for move in moves:
                for a in range(dim):
                    move[i, a] *= share
