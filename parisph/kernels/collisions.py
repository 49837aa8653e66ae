"""Pair collisions and wall guard."""

import numpy as np

from parisph.base.fields import FLUID
from parisph.kernels.jit import inlined, kernel, subkernel
from parisph.kernels.mirrors import height, near_planes

ROUNDING = 1e-9    # of the approach by a linear velocity: what differs from it by less is linear


@kernel
def count_collisions(number: np.ndarray, u: np.ndarray, x: np.ndarray, kind: np.ndarray, distance: float,
                     indptr: np.ndarray, indices: np.ndarray, axes: tuple[int, ...]) -> None:
    """Number of fluid neighbours closer than the distance that each owned particle approaches: (n_owned,).

    These are at least as many as it collides with (pair_collisions).
    """
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
def pair_collisions(change: np.ndarray, number: np.ndarray, u: np.ndarray, x: np.ndarray, g: np.ndarray,
                    kind: np.ndarray, volume: np.ndarray, distance: float, restitution: float, indptr: np.ndarray,
                    indices: np.ndarray, axes: tuple[int, ...]) -> int:
    """Velocity change by collisions of fluid pairs that are closer than the distance and approach.

    What counts is the approach beyond that of a linear velocity, d . (u_i - u_j) + d . (g_i + g_j) d/2
    with d = x_j - x_i, or all of it if that is less: smooth strain never collides. Each impulse is
    divided by the larger `number` of the two. Momentum is then conserved (with masses in
    proportion to the volumes), and energy does not rise as long as no mass is more than 1/(1 +
    restitution) of the two. Impulses are computed from the velocities before the collisions: the
    result depends neither on the order of the pairs nor on the rank that owns a particle.

    change : (n_owned, dim) output [m/s]; number : (n_all,) of count_collisions
    g : (n_all, dim, dim), velocity gradient [1/s]; volume : (n_all,) [m^dim], > 0 for fluid
    Returns the number of colliding pairs (each counted once per particle).
    """
    dim = len(axes)
    pairs = 0
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


@kernel
def wall_guard(u: np.ndarray, beside: np.ndarray, x: np.ndarray, kind: np.ndarray, corner: np.ndarray,
               normal: np.ndarray, distance: float, dt: float, indptr: np.ndarray, indices: np.ndarray,
               axes: tuple[int, ...]) -> int:
    """Keep fluid from coming closer to a wall than the distance within the next dt [s].

    The velocity into the wall is limited to the room in front of the wall, and to zero if there is
    none. A particle behind the wall would see its neighbours on the wrong side, which gives an
    unbounded pressure. u of the wall particles is the wall's normal velocity. Returns the number of
    particles that were slowed down.

    beside : fluid with walls in its lists, and indptr, indices : of these walls, of `mirrors.beside_walls`
    """
    dim = len(axes)
    member = np.empty(dim, np.int64)
    slowed = 0
    for i in beside:
        hit = False
        for p in range(near_planes(member, i, x, kind, corner, normal, indptr, indices, axes)):
            wall = member[p]
            outward = 0.0
            for a in range(dim):
                outward += (u[i, a] - u[wall, a]) * normal[wall, a]
            allowed = min(distance - height(i, wall, x, normal, axes), 0.0) / dt
            if outward < allowed:
                hit = True
                for a in range(dim):
                    u[i, a] += (allowed - outward) * normal[wall, a]
        slowed += hit
    return slowed


@kernel
def keep_off_walls(move: np.ndarray, beside: np.ndarray, x: np.ndarray, kind: np.ndarray, corner: np.ndarray,
                   normal: np.ndarray, distance: float, indptr: np.ndarray, indices: np.ndarray,
                   axes: tuple[int, ...]) -> None:
    """Remove the part of a displacement that would bring fluid closer to a wall than the distance.

    move : (n_owned, dim) [m], changed in place
    beside : fluid with walls in its lists, and indptr, indices : of these walls, of `mirrors.beside_walls`
    """
    dim = len(axes)
    member = np.empty(dim, np.int64)
    for i in beside:
        if not _any(move, i, axes):
            continue
        for p in range(near_planes(member, i, x, kind, corner, normal, indptr, indices, axes)):
            wall = member[p]
            outward = 0.0
            for a in range(dim):
                outward += move[i, a] * normal[wall, a]
            allowed = min(distance - height(i, wall, x, normal, axes), 0.0)
            if outward < allowed:
                for a in range(dim):
                    move[i, a] += (allowed - outward) * normal[wall, a]


@inlined
def _any(move, i, axes):
    """Return whether particle i moves at all."""
    for a in range(len(axes)):
        if move[i, a] != 0.0:
            return True
    return False
