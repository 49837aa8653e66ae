"""The neighbours of a particle with the differences of their velocities, and their images in moving walls."""

from typing import NamedTuple

import numpy as np

from parisph.base.fields import ABSENT, FLUID, WALL
from parisph.kernels.jit import inlined, subkernel
from parisph.kernels.mirrors import PARALLEL, height, near_planes
from parisph.kernels.solids import nearest_walls

ON_PLANE = 0.1      # of the radius: what is closer to the plane of a wall lies on it
GONE, SLIPS, STICKS = 0, 1, 2    # what an element is: behind air, without friction, or one that fluid sticks to


class Solids(NamedTuple):
    """Walls as elements for `gather_moving`, none in a tank alone, whose wall particles know their planes.

    corners : (M, dim, dim) [m]; u : (M, dim) [m/s]; state : (M,) int8, GONE, SLIPS or STICKS
    indptr, indices : the elements near each owned particle (kernels.solids)
    """

    corners: np.ndarray
    u: np.ndarray
    state: np.ndarray
    indptr: np.ndarray
    indices: np.ndarray


def no_solids(dim: int) -> Solids:
    """Return the Solids of a scene without elements."""
    none = np.zeros(0, np.int32)
    return Solids(np.empty((0, dim, dim)), np.empty((0, dim)), np.zeros(0, np.int8), none, none)


@subkernel
def gather_moving(near: np.ndarray, du: np.ndarray, speed: float, member: np.ndarray, image: np.ndarray,
                  mirror: np.ndarray, slips: np.ndarray, i: int, u: np.ndarray, nu: np.ndarray, x: np.ndarray,
                  kind: np.ndarray, corner: np.ndarray, normal: np.ndarray, no_slip: np.ndarray, h: float,
                  everywhere: bool, solids: Solids, indptr: np.ndarray, indices: np.ndarray,
                  axes: tuple[int, ...]) -> int:
    """Write the neighbours of i and their images relative to i, in units of h, and nu_ij (u_j - u_i).

    With `everywhere` all walls are neighbours and make images. Without, free-slip walls only make images, and no-slip
    walls are only neighbours.

    near, du : (dim, 2^dim times the columns from `room_for`); the others scratch. Returns the number of columns.
    """
    dim, n, walls = len(axes), 0, False
    for k in range(indptr[i], indptr[i + 1]):
        j = indices[k]
        walls |= kind[j] == WALL
        if kind[j] != ABSENT and (kind[j] == FLUID or no_slip[j] or everywhere):
            mean = 0.5 * (nu[i] + nu[j])
            for a in range(dim):
                near[a, n] = (x[j, a] - x[i, a]) / h
                du[a, n] = mean * (u[j, a] - u[i, a])
            n += 1
    foot, away, planes = np.empty((dim, dim)), np.empty((dim, dim)), 0
    if len(solids.corners):
        planes = _solid_planes(foot, away, speed, slips, member, i, x, solids, axes)
    elif walls:
        planes = near_planes(member, i, x, kind, corner, normal, indptr, indices, axes)
        for p in range(planes):
            slips[p] = _plane_velocity(speed, p, member[p], i, u, x, kind, corner, normal, no_slip, ON_PLANE * h,
                                       indptr, indices, axes)
            for a in range(dim):
                foot[p, a], away[p, a] = x[member[p], a], normal[member[p], a]
    for subset in range(1, 1 << planes):
        wanted = True
        for p in range(planes):
            wanted &= ((subset >> p) & 1 == 0) | slips[p] | everywhere
        if not wanted:
            continue
        for k in range(indptr[i] - 1, indptr[i + 1]):
            j = i if k < indptr[i] else indices[k]
            if kind[j] == ABSENT or (kind[j] == WALL and not no_slip[j] and not everywhere):
                continue
            if not _casts(j, subset, foot, away, x, kind, ON_PLANE * h, axes):
                continue
            for a in range(dim):
                image[a] = x[j, a]
            _reflect(image, subset, foot, away, axes)
            for a in range(dim):
                near[a, n] = (image[a] - x[i, a]) / h
                image[a] = u[j, a]
            _mirror_velocity(image, mirror, subset, speed, slips, away, axes)
            mean = 0.5 * (nu[i] + nu[j])
            for a in range(dim):
                du[a, n] = mean * (image[a] - u[i, a])
            n += 1
    return n


@subkernel
def _solid_planes(foot, away, speed, slips, member, i, x, solids, axes):
    """Write the planes that touch the walls nearest to i, at most dim of them; return their number.

    foot, away : (dim, dim) output, of each plane a point and the normal; the velocity goes to speed, as in
        _plane_velocity
    """
    dim, planes = len(axes), 0
    if solids.indptr[i] == solids.indptr[i + 1]:
        return 0
    found = np.empty((dim, dim + 1))
    p, q, r = np.empty(dim), np.empty(dim), np.empty(dim)
    for w in range(nearest_walls(found, member, p, q, r, i, x, solids.corners, solids.indptr, solids.indices, axes)):
        e = member[w]
        if solids.state[e] == GONE:
            continue
        slips[planes] = solids.state[e] == SLIPS
        for a in range(dim):
            away[planes, a] = found[w, a]
            foot[planes, a] = x[i, a] - found[w, dim] * found[w, a]
            speed[planes, a] = solids.u[e, a]
        planes += 1
    return planes


@inlined
def _casts(j, subset, foot, away, x, kind, thin, axes):
    """Return whether particle j has an image, other than itself, in the planes of the subset (mirrors.casts_image)."""
    if kind[j] == FLUID:
        return True
    for p in range(len(axes)):
        if (subset >> p) & 1:
            h = 0.0
            for a in range(len(axes)):
                h += (x[j, a] - foot[p, a]) * away[p, a]
            if h < thin:
                return False
    return True


@inlined
def _reflect(image, subset, foot, away, axes):
    """Turn a place into that of its image in the planes of the subset."""
    dim = len(axes)
    for p in range(dim):
        if (subset >> p) & 1:
            h = 0.0
            for a in range(dim):
                h += (image[a] - foot[p, a]) * away[p, a]
            for a in range(dim):
                image[a] -= 2.0 * h * away[p, a]


@inlined
def _mirror_velocity(v, mean, subset, speed, slips, away, axes):
    """Turn the velocity of a particle into that of its image in the planes whose bits are set in subset.

    Relative to the mean velocity of these planes, each free-slip one turns its normal part round, each no-slip one all
    of it. In the corner of two walls that move apart, the order of the planes thus has no effect.

    mean : (dim,) scratch
    """
    dim, planes = len(axes), 0
    for a in range(dim):
        mean[a] = 0.0
    for p in range(dim):
        if (subset >> p) & 1:
            planes += 1
            for a in range(dim):
                mean[a] += speed[p, a]
    for a in range(dim):
        mean[a] /= planes
        v[a] -= mean[a]
    for p in range(dim):
        if (subset >> p) & 1:
            through = 0.0
            for a in range(dim):
                through += v[a] * away[p, a]
            for a in range(dim):
                v[a] = v[a] - 2.0 * through * away[p, a] if slips[p] else -v[a]
    for a in range(dim):
        v[a] += mean[a]


@subkernel
def _plane_velocity(speed, p, wall, i, u, x, kind, corner, normal, no_slip, thin, indptr, indices, axes):
    """Write the velocity of plane p beside i to speed[p]; return whether it is free-slip.

    It is the mean over the wall particles of the plane weighted by 1/r^4, which does not depend on their numbering.
    """
    dim, total, bound = len(axes), 0.0, 0.0
    for a in range(dim):
        speed[p, a] = 0.0
    for k in range(indptr[i], indptr[i + 1]):
        j = indices[k]
        if kind[j] != WALL or corner[j]:
            continue
        cosine, r2 = 0.0, 0.0
        for a in range(dim):
            cosine += normal[wall, a] * normal[j, a]
            r2 += (x[j, a] - x[i, a]) ** 2
        if cosine > PARALLEL and abs(height(j, wall, x, normal, axes)) < thin:
            w = 1.0 / max(r2, thin * thin) ** 2
            total += w
            bound += w * (no_slip[j] != 0)
            for a in range(dim):
                speed[p, a] += w * u[j, a]
    for a in range(dim):
        speed[p, a] /= total
    return bound < 0.5 * total
