"""Mirror images of fluid in nearby walls, without stored ghost particles.

A particle near a wall has too few neighbours. For i and j on the same side of a plane, the image of j
is never closer to i than j itself, so every image within a radius belongs to a neighbour within that
radius: the neighbour lists contain all that is needed.
"""

import numpy as np

from parisph.base.fields import ABSENT, FLUID, WALL
from parisph.kernels.jit import inlined, kernel, subkernel
from parisph.kernels.near import fill_up

SLACK = 0.1     # of the wall that a particle sees: how far past its end it still counts
PARALLEL = 0.9  # cosine above which two wall normals belong to the same plane


@kernel
def beside_walls(kind: np.ndarray, indptr: np.ndarray,
                 indices: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return which owned fluid has wall particles in its lists, and the lists of these alone.

    The numbers of the particles, int32, rising; and the CSR lists of all owned particles, empty for all others:
    indptr (n_owned + 1,) int32, indices int32. What only concerns walls looks at these few.
    """
    found, n = np.empty(len(indptr) - 1, np.int32), 0
    start, walls, m = np.zeros(len(indptr), np.int32), np.empty(len(indices), np.int32), 0
    for i in range(len(indptr) - 1):
        if kind[i] == FLUID:
            at = np.uint32(m)    # unsigned, as in `near.gather`
            for k in range(np.uint32(indptr[i]), np.uint32(indptr[i + 1])):
                j = np.uint32(indices[k])
                walls[at] = j    # overwritten by the next one if it is fluid
                at += np.uint32(kind[j] == WALL)
            m = np.int64(at)
        start[i + 1] = m
        found[n] = i
        n += m > start[i]
    return found[:n], start, walls[:m].copy()


@subkernel
def near_planes(member: np.ndarray, i: int, x: np.ndarray, kind: np.ndarray, corner: np.ndarray, normal: np.ndarray,
                indptr: np.ndarray, indices: np.ndarray, axes: tuple[int, ...]) -> int:
    """Find the walls next to particle i: one wall particle for each orientation.

    A wall ends with its last particles: there is no mirror plane above the rim of an open tank.

    member : (dim,) int64 output; the plane of member p goes through x[member[p]] with the
        normal of that particle. Of several parallel walls, the one closest to i is taken.
    Returns the number of planes, at most dim.
    """
    return _planes_among(member, i, x, kind, corner, normal, indptr[i], indptr[i + 1], indices, axes)


@inlined
def _planes_among(member, i, x, kind, corner, normal, first, stop, indices, axes):
    """Find the planes of `near_planes` among a part of a list, in which all walls near i must be."""
    dim = len(axes)
    found = 0
    for k in range(first, stop):
        j = indices[k]
        if kind[j] != WALL or corner[j]:
            continue
        same = -1
        for p in range(found):
            cosine = 0.0
            for a in range(dim):
                cosine += normal[member[p], a] * normal[j, a]
            if cosine > PARALLEL:
                same = p
        if same >= 0:
            if height(i, j, x, normal, axes) < height(i, member[same], x, normal, axes):
                member[same] = j
        elif found < dim:
            member[found] = j
            found += 1
    kept = 0
    for p in range(found):
        if _is_beside(i, member[p], x, kind, normal, first, stop, indices, axes):
            member[kept] = member[p]
            kept += 1
    return kept


@inlined
def _is_beside(i, wall, x, kind, normal, first, stop, indices, axes):
    """Return whether particle i is in front of a wall, not past its end.

    Along each tangent the wall particles of that plane, corners included, must lie on both sides of i.
    """
    dim = len(axes)
    for b in range(dim):  # the tangent along axis b is e_b - n_b n
        if 1.0 - normal[wall, b] ** 2 < 0.25:
            continue
        least, most = 0.0, 0.0
        seen = False
        for k in range(first, stop):
            j = indices[k]
            if kind[j] != WALL:
                continue
            off, apart = 0.0, 0.0
            for a in range(dim):
                off += (x[j, a] - x[wall, a]) * normal[wall, a]
                apart += (x[j, a] - x[wall, a]) ** 2
            if off * off > 0.01 * apart:
                continue  # on another wall
            along = x[j, b] - x[i, b] + height(i, wall, x, normal, axes) * normal[wall, b]
            least = min(least, along) if seen else along
            most = max(most, along) if seen else along
            seen = True
        slack = SLACK * (most - least)
        if least > slack or most < -slack:
            return False
    return True


@inlined
def height(i: int, wall: int, x: np.ndarray, normal: np.ndarray, axes: tuple[int, ...]) -> float:
    """Return the distance of particle i from the plane of a wall particle, positive inside."""
    h = 0.0
    for a in range(len(axes)):
        h += (x[i, a] - x[wall, a]) * normal[wall, a]
    return h


@inlined
def reflect(image: np.ndarray, j: int, subset: int, member: np.ndarray, x: np.ndarray, normal: np.ndarray,
            axes: tuple[int, ...]) -> None:
    """Write the image of particle j in the planes whose bits are set in subset."""
    dim = len(axes)
    for a in range(dim):
        image[a] = x[j, a]
    for p in range(dim):
        if (subset >> p) & 1:
            wall = member[p]
            h = 0.0
            for a in range(dim):
                h += (image[a] - x[wall, a]) * normal[wall, a]
            for a in range(dim):
                image[a] -= 2.0 * h * normal[wall, a]


@inlined
def casts_image(j: int, subset: int, member: np.ndarray, x: np.ndarray, kind: np.ndarray, normal: np.ndarray,
                thin: float, axes: tuple[int, ...]) -> bool:
    """Return whether particle j has an image, other than itself, in the planes whose bits are set in subset.

    All fluid has one. A wall particle on one of the planes (closer than `thin` [m]) is its own image;
    a particle on another wall has an image behind the plane, which is needed in the corners of a tank.
    """
    if kind[j] == FLUID:
        return True
    for p in range(len(axes)):
        if (subset >> p) & 1 and height(j, member[p], x, normal, axes) < thin:
            return False
    return True


@inlined
def gather_around(near: np.ndarray, walls: np.ndarray, member: np.ndarray, image: np.ndarray, i: int, x: np.ndarray,
                  kind: np.ndarray, corner: np.ndarray, normal: np.ndarray, h: float, indptr: np.ndarray,
                  indices: np.ndarray, axes: tuple[int, ...]) -> int:
    """Write all neighbours of fluid particle i, and the images of itself and its neighbours in nearby walls.

    Particles of the kind ABSENT are left out, as neighbours and as walls.

    near : (dim, 2^dim times the columns from `near.room_for`), relative to i, in units of h
    walls : int32, of the length from `near.room_for`, member : (dim,) int64, image : (dim,) scratch
    Returns the number of columns in use, including the padding with points without weight.
    """
    dim, scale, cx, cy = len(axes), 1.0 / h, x[i, 0], x[i, 1]
    cz = x[i, 2] if dim == 3 else 0.0
    to, wall = np.uint32(0), np.uint32(0)    # unsigned, as in `near.gather`
    for k in range(np.uint32(indptr[i]), np.uint32(indptr[i + 1])):
        j = np.uint32(indices[k])
        near[0, to], near[1, to] = (x[j, 0] - cx) * scale, (x[j, 1] - cy) * scale    # overwritten if j does not count
        if dim == 3:
            near[2, to] = (x[j, 2] - cz) * scale
        to += np.uint32(kind[j] != ABSENT)
        walls[wall] = j
        wall += np.uint32(kind[j] == WALL)
    n, w = np.int64(to), np.int64(wall)
    if w > 0:
        planes = _planes_among(member, i, x, kind, corner, normal, 0, w, walls, axes)
        if planes == 1:
            return fill_up(near, _reflect_all(near, n, i, member[0], x, kind, normal, h, indptr, indices, axes), axes)
        for subset in range(1, 1 << planes):
            for k in range(indptr[i] - 1, indptr[i + 1]):
                j = i if k < indptr[i] else indices[k]
                if kind[j] != ABSENT and casts_image(j, subset, member, x, kind, normal, 0.1 * h, axes):
                    reflect(image, j, subset, member, x, normal, axes)
                    for a in range(dim):
                        near[a, n] = (image[a] - x[i, a]) / h
                    n += 1
    return fill_up(near, n, axes)


@inlined
def _reflect_all(near, n, i, wall, x, kind, normal, h, indptr, indices, axes):
    """Write the images in one plane of particle i and of its first n neighbours behind these; return how many columns
    are in use then. No branches: which neighbours are a wall's particles, their own images, cannot be predicted."""
    dim, own = len(axes), height(i, wall, x, normal, axes) / h
    nx, ny = normal[wall, 0], normal[wall, 1]
    nz = normal[wall, 2] if dim == 3 else 0.0
    near[0, n], near[1, n] = -2.0 * own * nx, -2.0 * own * ny
    if dim == 3:
        near[2, n] = -2.0 * own * nz
    m, c = n + 1, 0
    for k in range(indptr[i], indptr[i + 1]):
        j = np.uint32(indices[k])
        up = own + near[0, c] * nx + near[1, c] * ny
        if dim == 3:
            up += near[2, c] * nz
            near[2, m] = near[2, c] - 2.0 * up * nz
        near[0, m], near[1, m] = near[0, c] - 2.0 * up * nx, near[1, c] - 2.0 * up * ny
        there = kind[j] != ABSENT
        m += there & ((kind[j] == FLUID) | (up >= 0.1))    # as `casts_image`
        c += there
    return m
