"""Close pairs of fluid: their lists, rotation in strained fluid, and separation without pressure."""

import math

import numpy as np

from parisph.base.fields import FLUID, INNER
from parisph.kernels.jit import inlined, kernel, subkernel
from parisph.kernels.records import Cloud

TILT = math.pi / 6.0    # tuned 3 to 12: pi over the angle between a pair and the direction in which it parts; judged


@inlined
def _hash(first, second):
    """Return 32 bits that depend on the unordered pair of ids only."""
    low, high = np.uint64(min(first, second)), np.uint64(max(first, second))
    h = (low * np.uint64(2654435761) + high * np.uint64(40503)) & np.uint64(0xFFFFFFFF)
    h = (((h >> np.uint64(13)) ^ h) * np.uint64(1274126177)) & np.uint64(0xFFFFFFFF)
    return h ^ (h >> np.uint64(16))


@subkernel
def across(side: np.ndarray, d: np.ndarray, first: int, second: int, axes: tuple[int, ...]) -> None:
    """Write a vector normal to d, of its length (3D: at most), on a side that depends on the ids of the pair.

    Its sign changes with that of d, so that the sum over a pair is zero.
    """
    h = _hash(first, second)
    sign = 1.0 if h & np.uint64(1) else -1.0
    if len(axes) == 2:
        side[0], side[1] = -sign * d[1], sign * d[0]
        return
    # an axis uniformly distributed on the sphere, from the other bits
    z = 2.0 * ((h >> np.uint64(1)) & np.uint64(0x7FFF)) / 0x7FFF - 1.0
    angle = 2.0 * math.pi * ((h >> np.uint64(16)) & np.uint64(0xFFFF)) / 0x10000
    rest = math.sqrt(max(0.0, 1.0 - z * z))
    ax, ay = rest * math.cos(angle), rest * math.sin(angle)
    side[0], side[1], side[2] = ay * d[2] - z * d[1], z * d[0] - ax * d[2], ax * d[1] - ay * d[0]


def close_pairs(cloud: Cloud, distance: float) -> Cloud:
    """Return a cloud with lists of fluid pairs closer than the distance [m] but not coincident.

    The functions below take such clouds.
    """
    indptr, indices = _close_lists(cloud, distance)
    return cloud._replace(indptr=indptr, indices=indices)


@kernel
def _close_lists(cloud, distance):
    x, kind, indptr, indices, axes = cloud.x, cloud.kind, cloud.indptr, cloud.indices, cloud.axes
    n, close, distance2 = np.uint32(0), np.empty(len(indices), np.int32), distance * distance
    start = np.zeros(len(indptr), np.int32)
    for i in range(len(indptr) - 1):
        if kind[i] == FLUID:
            cx, cy = x[i, 0], x[i, 1]
            cz = x[i, 2] if len(axes) == 3 else 0.0
            for k in range(np.uint32(indptr[i]), np.uint32(indptr[i + 1])):
                j = np.uint32(indices[k])
                dx, dy = x[j, 0] - cx, x[j, 1] - cy
                r2 = dx * dx + dy * dy
                if len(axes) == 3:
                    r2 += (x[j, 2] - cz) ** 2
                if (r2 < distance2) & (0.0 < r2) & (kind[j] == FLUID):    # rare, so well predicted
                    close[n] = j
                    n += np.uint32(1)
        start[i + 1] = n
    return start, close[:n].copy()


@kernel
def turn_pairs(shift: np.ndarray, cloud: Cloud, ident: np.ndarray, strength: np.ndarray, distance: float) -> None:
    """Rotate close pairs of inner particles, as a compressed lattice has no gradient of concentration.

    Each particle of a pair moves normal to its line, by (1 - r/distance) times half the mean of their strengths.

    shift : (n_owned, dim) [m], to which the moves are added; ident : (n_all,); strength : (n_all,) [m]; distance [m]
    """
    role, indptr, indices, dim = cloud.role, cloud.indptr, cloud.indices, len(cloud.axes)
    d, side = np.empty(dim), np.empty(dim)
    for i in range(len(indptr) - 1):
        if role[i] != INNER:
            continue
        for k in range(indptr[i], indptr[i + 1]):
            j = indices[k]
            r = _distance(d, i, j, cloud)
            if role[j] != INNER or not r < distance:
                continue
            across(side, d, ident[i], ident[j], cloud.axes)
            move = 0.5 * (strength[i] + strength[j]) * (1.0 - r / distance) / r
            for a in range(dim):
                shift[i, a] -= move * side[a]


@kernel
def count_close(number: np.ndarray, cloud: Cloud, distance: float) -> None:
    """Write the number of pairs of each particle within the distance [m] that are not both inner: number (n_owned,)."""
    role, d = cloud.role, np.empty(len(cloud.axes))
    for i in range(len(number)):
        number[i] = 0
        for k in range(cloud.indptr[i], cloud.indptr[i + 1]):
            j = cloud.indices[k]
            if role[i] != INNER or role[j] != INNER:
                number[i] += _distance(d, i, j, cloud) < distance


@kernel
def part_pairs(shift: np.ndarray, cloud: Cloud, number: np.ndarray, ident: np.ndarray, distance: float,
               strength: float) -> None:
    """Separate close pairs of which at least one particle has no pressure equation (jets, drops, films).

    A pair separates by strength (distance - r), divided by the larger number of such pairs of the two, which limits the
    sum. The direction is the pair's line turned by TILT to either side: particles on one line then form a column again
    instead of a point.

    shift : (n_owned, dim) output [m]; number : (n_all,) of `count_close`; ident : (n_all,); distance [m]
    """
    role, indptr, indices, dim = cloud.role, cloud.indptr, cloud.indices, len(cloud.axes)
    d, side = np.empty(dim), np.empty(dim)
    cosine, sine = math.cos(TILT), math.sin(TILT)
    for i in range(len(indptr) - 1):
        shift[i, :] = 0.0
        if number[i] == 0:
            continue
        for k in range(indptr[i], indptr[i + 1]):
            j = indices[k]
            if role[i] == INNER and role[j] == INNER:
                continue
            r = _distance(d, i, j, cloud)
            if not r < distance:
                continue
            across(side, d, ident[i], ident[j], cloud.axes)
            move = 0.5 * strength * (distance - r) / (r * max(number[i], number[j]))
            for a in range(dim):
                shift[i, a] -= move * (cosine * d[a] + sine * side[a])


@kernel
def keep_apart(move: np.ndarray, near: np.ndarray, cloud: Cloud, ident: np.ndarray, distance: float,
               longest: float) -> tuple[int, int]:
    """Sum the moves that bring each pair to the distance [m], half each, along its line turned by TILT.

    For repeated sweeps: the sum is exact for an isolated pair, and limited in a crowd.

    move : (n_owned, dim), at most `longest` [m]; written at the particles examined, 0 before the first sweep
    near : int32, the owned particles to examine, all in the first sweep; those that the next sweep may bring too close
        to a neighbour are moved to the front
    ident : (n_all,)
    Returns the number of particles with a neighbour within the distance, and how many remain in `near`.
    """
    indptr, indices, dim = cloud.indptr, cloud.indices, len(cloud.axes)
    d, side = np.empty(dim), np.empty(dim)
    cosine, sine = math.cos(TILT), math.sin(TILT)
    crowded, left, reach = 0, 0, distance + longest
    for i in near:
        for a in range(dim):
            move[i, a] = 0.0
        if not _any_within(reach, i, cloud):
            continue
        near[left] = i
        left += 1
        close = False
        for k in range(indptr[i], indptr[i + 1]):
            j = indices[k]
            r = _distance(d, i, j, cloud)
            if not 0.0 < r < distance:
                continue
            close = True
            across(side, d, ident[i], ident[j], cloud.axes)
            for a in range(dim):
                move[i, a] -= 0.5 * (distance - r) / r * (cosine * d[a] + sine * side[a])
        crowded += close
        length = 0.0
        for a in range(dim):
            length += move[i, a] ** 2
        if length > longest**2:
            for a in range(dim):
                move[i, a] *= longest / math.sqrt(length)
    return crowded, left


@inlined
def _any_within(reach, i, cloud):
    """Return whether a neighbour of i is within the reach; without branches, as most have none."""
    x, found = cloud.x, False
    for k in range(cloud.indptr[i], cloud.indptr[i + 1]):
        j = np.uint32(cloud.indices[k])
        r2 = 0.0
        for a in range(len(cloud.axes)):
            r2 += (x[j, a] - x[i, a]) ** 2
        found |= r2 < reach * reach
    return found


@inlined
def _distance(d, i, j, cloud):
    """Write x_j - x_i, and return its length."""
    r2 = 0.0
    for a in range(len(cloud.axes)):
        d[a] = cloud.x[j, a] - cloud.x[i, a]
        r2 += d[a] ** 2
    return math.sqrt(r2)
