"""Neighbours of a particle, and their reflections in the nearest walls.

A reflection continues the fluid behind the plane of a wall. If i and j are on the same side of a plane, the reflection
of j is at least as far from i as j itself, so the neighbour lists contain every particle needed.
"""

import math
from typing import NamedTuple

import numpy as np

from parisph.base.fields import ABSENT, FLUID, WALL
from parisph.kernels.jit import inlined, subkernel
from parisph.kernels.near import room_for
from parisph.kernels.nearest_walls import nearest_walls, three_places
from parisph.kernels.records import Cloud, Walls

ON_PLANE = 0.1      # tuned 0.05 to 0.2: distance from the plane of a wall on which particles lie, in radii; judged


class Across(NamedTuple):
    """The columns that `gather_across` writes, and its scratch.

    near, du : (dim, columns), position of a column relative to the particle over the radius; its relative velocity,
        which `differences` writes
    member, planes : (columns,), index of the neighbour; bits of the planes that reflect it, 0 for the neighbour itself
    foot, away, speed : (dim, dim), a point, the normal and the velocity of each plane
    slips : (dim,), whether fluid slips along each plane
    """

    near: np.ndarray
    du: np.ndarray
    member: np.ndarray
    planes: np.ndarray
    foot: np.ndarray
    away: np.ndarray
    speed: np.ndarray
    slips: np.ndarray


@subkernel
def room_across(cloud: Cloud) -> Across:
    """Return an Across with room for all columns of any particle."""
    dim, room = len(cloud.axes), room_for(cloud.indptr) * 2 ** len(cloud.axes)
    return Across(np.empty((dim, room)), np.empty((dim, room)), np.empty(room, np.int32), np.empty(room, np.int8),
                  np.empty((dim, dim)), np.empty((dim, dim)), np.empty((dim, dim)), np.empty(dim, np.bool_))


@subkernel
def gather_across(across: Across, i: int, cloud: Cloud, walls: Walls, no_slip: np.ndarray, everywhere: bool,
                  radius: float) -> int:
    """Write the neighbours of particle i and their reflections, relative to it; return the number of columns.

    With `everywhere`, all wall particles are neighbours and all walls reflect. Otherwise free-slip walls reflect but
    add no particles, and no-slip walls, `no_slip` (n_all,), add particles but do not reflect. ABSENT particles and
    elements that are not present do not count.
    """
    kind, axes, n = cloud.kind, cloud.axes, 0
    for k in range(cloud.indptr[i], cloud.indptr[i + 1]):
        j = cloud.indices[k]
        if kind[j] != ABSENT and (kind[j] == FLUID or no_slip[j] or everywhere):
            across.member[n], across.planes[n] = j, 0
            for a in range(len(axes)):
                across.near[a, n] = (cloud.x[j, a] - cloud.x[i, a]) / radius
            n += 1
    planes = _find_planes(across, i, cloud, walls)
    for subset in range(1, 1 << planes):
        wanted = True
        for p in range(planes):
            wanted &= ((subset >> p) & 1 == 0) | across.slips[p] | everywhere
        if not wanted:
            continue
        for k in range(cloud.indptr[i] - 1, cloud.indptr[i + 1]):
            j = i if k < cloud.indptr[i] else cloud.indices[k]
            if kind[j] == ABSENT or (kind[j] == WALL and not no_slip[j] and not everywhere):
                continue
            if _is_reflected(across, j, subset, cloud, ON_PLANE * radius):
                across.member[n], across.planes[n] = j, subset
                _reflect(across, n, cloud, radius, i)
                n += 1
    return n


@subkernel
def _find_planes(across, i, cloud, walls):
    """Write the planes of the walls nearest to i, at most dim; return their number."""
    axes, planes = cloud.axes, 0
    if walls.indptr[i] == walls.indptr[i + 1]:
        return 0
    found, member = np.empty((len(axes), len(axes) + 1)), np.empty(len(axes), np.int64)
    for w in range(nearest_walls(found, member, three_places(axes), i, cloud, walls, math.inf)):
        e = member[w]
        if walls.present[e] > 0.0:
            across.slips[planes] = not walls.sticks[e]
            for a in range(len(axes)):
                across.away[planes, a] = found[w, a]
                across.foot[planes, a] = cloud.x[i, a] - found[w, len(axes)] * found[w, a]
                across.speed[planes, a] = walls.velocity[e, a]
            planes += 1
    return planes


@inlined
def _is_reflected(across, j, subset, cloud, thin):
    """Return whether particle j has a reflection in the planes of the subset that differs from itself.

    Fluid always has one. A wall particle within `thin` [m] of one of the planes has none. A particle on another wall
    has one, which the corners of a tank need.
    """
    if cloud.kind[j] == FLUID:
        return True
    for p in range(len(cloud.axes)):
        if (subset >> p) & 1:
            h = 0.0
            for a in range(len(cloud.axes)):
                h += (cloud.x[j, a] - across.foot[p, a]) * across.away[p, a]
            if h < thin:
                return False
    return True


@inlined
def _reflect(across, n, cloud, radius, i):
    """Write the position of column n relative to particle i."""
    j = across.member[n]
    for a in range(len(cloud.axes)):
        across.near[a, n] = cloud.x[j, a]
    for p in range(len(cloud.axes)):
        if (across.planes[n] >> p) & 1:
            h = 0.0
            for a in range(len(cloud.axes)):
                h += (across.near[a, n] - across.foot[p, a]) * across.away[p, a]
            for a in range(len(cloud.axes)):
                across.near[a, n] -= 2.0 * h * across.away[p, a]
    for a in range(len(cloud.axes)):
        across.near[a, n] = (across.near[a, n] - cloud.x[i, a]) / radius


@subkernel
def differences(across: Across, n: int, i: int, u: np.ndarray) -> None:
    """Write the velocities u (n_all, dim) of n columns relative to that of particle i."""
    dim = len(across.near)
    v, mean = np.empty(dim), np.empty(dim)
    for k in range(n):
        for a in range(dim):
            v[a] = u[across.member[k], a]
        if across.planes[k]:
            _reflect_velocity(v, mean, across, across.planes[k], dim)
        for a in range(dim):
            across.du[a, k] = v[a] - u[i, a]


@inlined
def _reflect_velocity(v, mean, across, subset, dim):
    """Reflect the velocity of a particle in the planes whose bits are set in subset.

    A free-slip plane reverses the normal part of the velocity, a no-slip plane all of it, both relative to the mean
    velocity of the planes. The result is thus independent of the order of the planes where two walls move apart.

    mean : (dim,) scratch
    """
    planes = 0
    for a in range(dim):
        mean[a] = 0.0
    for p in range(dim):
        if (subset >> p) & 1:
            planes += 1
            for a in range(dim):
                mean[a] += across.speed[p, a]
    for a in range(dim):
        mean[a] /= planes
        v[a] -= mean[a]
    for p in range(dim):
        if (subset >> p) & 1:
            through = 0.0
            for a in range(dim):
                through += v[a] * across.away[p, a]
            for a in range(dim):
                v[a] = v[a] - 2.0 * through * across.away[p, a] if across.slips[p] else -v[a]
    for a in range(dim):
        v[a] += mean[a]
