"""The particles on the free surface in 3D, by the widest cone without neighbours.

The axis of a cone is one of 162 directions: the corners of an icosahedron whose edges are divided by four. A neighbour
covers the directions within the half angle of its own. Most are looked up: for each bin of neighbours' directions, on
the faces of a cube, a mask has the directions that any neighbour in the bin covers. What the masks of all neighbours
leave, none for most inner particles, is compared with each neighbour.
"""

import math
from functools import lru_cache
from itertools import combinations
from typing import NamedTuple

import numpy as np

from parisph.base.arrays import Floats
from parisph.base.fields import ABSENT, BALLISTIC, FLUID, INNER, SURFACE
from parisph.kernels.elements import nearest_point
from parisph.kernels.jit import inlined, kernel
from parisph.kernels.near import room_for
from parisph.kernels.records import Cloud, Walls

BINS = 16     # across a face of the cube
SPLITS = 4    # of an icosahedron's edge; with 2, particles of a jittered surface have no free cone
WORD = 64     # bits
EVERY, LAST = np.uint64(2**WORD - 1), np.uint64(2 ** (10 * SPLITS**2 + 2 - 2 * WORD) - 1)    # masks of all axes
FARTHER = 1.0 + 1e-6    # for rounding
# of cosines: 24 axes are 60 degrees from the normal of a wall along a coordinate plane, where rounding would decide
TIE = 1e-9
FEW = 6       # tuned 4 to 9: number of neighbours below which a particle is on the surface in 3D; judged


class Cone(NamedTuple):
    """The cone rule: a particle joins the surface if a cone of half angle `enter` [rad] is free of neighbours, and
    stays on it as long as one of `leave` is. Below the density ratio `thin` it is always on the surface.

    axis : (162, 3), unit vectors along the cones
    joining, staying : (6 BINS^2, 3) uint64, the axes that each bin of neighbours covers, with `enter` and with `leave`
    """

    enter: float
    leave: float
    thin: float
    axis: np.ndarray
    joining: np.ndarray
    staying: np.ndarray


def cone(enter: float, leave: float, thin: float) -> Cone:
    """Return the Cone with its tables, from angles [rad] below a right angle. Takes some milliseconds."""
    return Cone(enter, leave, thin, directions(), masks(enter), masks(leave))


@lru_cache(maxsize=1)
def directions() -> Floats:
    """Return the corners of a divided icosahedron (10 SPLITS^2 + 2, 3), on the unit sphere. Cached."""
    golden = 0.5 * (1.0 + math.sqrt(5.0))
    corner = np.array([np.roll((0.0, a, b * golden), turn) for turn in range(3) for a in (-1, 1) for b in (-1, 1)])
    found = []
    for face in combinations(range(12), 3):
        if all(np.linalg.norm(corner[a] - corner[b]) < 2.1 for a, b in combinations(face, 2)):    # edges are 2 long
            for i in range(SPLITS + 1):
                for j in range(SPLITS + 1 - i):
                    found.append(np.array([i, j, SPLITS - i - j]) @ corner[list(face)])
    unit = np.array(found) / np.linalg.norm(found, axis=1)[:, None]
    first: Floats = unit[np.sort(np.unique(np.round(unit, 9) + 0.0, axis=0, return_index=True)[1])]
    return first


@lru_cache(maxsize=2)
def masks(angle: float) -> np.ndarray:
    """Return which directions are within the angle [rad] of all points of each bin: (6 BINS^2, 3) uint64. Cached.

    Bins have great circles as sides, and below a right angle a cap that contains the four corners contains the bin.
    """
    axis, step = directions(), np.arange(BINS + 1) * (2.0 / BINS) - 1.0
    found = np.zeros((6, BINS, BINS, -(-len(axis) // WORD)), np.uint64)
    for face in range(6):
        corner = np.empty((BINS + 1, BINS + 1, 3))
        first = face // 2
        corner[..., first] = 1.0 - 2.0 * (face % 2)
        corner[..., (first + 1) % 3], corner[..., (first + 2) % 3] = np.meshgrid(step, step, indexing="ij")
        cosine = corner @ axis.T / np.linalg.norm(corner, axis=-1)[..., None]
        near = cosine >= math.cos(angle)
        sure = near[:-1, :-1] & near[1:, :-1] & near[:-1, 1:] & near[1:, 1:]
        for k in range(len(axis)):
            found[face, :, :, k // WORD] |= sure[..., k].astype(np.uint64) << np.uint64(k % WORD)
    return found.reshape(6 * BINS * BINS, -1)


@kernel
def surface_by_cone(role: np.ndarray, was: np.ndarray, cloud: Cloud, walls: Walls, alpha: np.ndarray, radius: float,
                    rule: Cone) -> None:
    """Mark fluid particles on the surface by the widest cone without neighbours within the radius [m] (3D).

    The counterpart of `surface.surface_by_gap`, with the same arguments: a particle with fewer than FEW neighbours is
    on the surface, and a present element counts as the reflection in it.
    """
    toward = np.empty((3, room_for(cloud.indptr) + room_for(walls.indptr)))
    places = np.empty(3), np.empty(3)
    for i in range(len(alpha)):
        if cloud.kind[i] != FLUID:
            continue
        role[i] = SURFACE
        if alpha[i] < rule.thin:
            continue
        n = _neighbours(toward, i, cloud, radius * radius)
        if walls.indptr[i] < walls.indptr[i + 1]:
            n = _reflections(toward, n, places, i, cloud, walls, radius * radius)
        if n < FEW:
            continue
        stays = was[i] == SURFACE or was[i] == BALLISTIC
        if not _is_free(toward, n, rule.axis, rule.staying if stays else rule.joining,
                        math.cos(rule.leave if stays else rule.enter)):
            role[i] = INNER


@inlined
def _neighbours(toward, i, cloud, radius2):
    """Write the unit vectors towards the neighbours; return their number."""
    x, n = cloud.x, 0
    for k in range(cloud.indptr[i], cloud.indptr[i + 1]):
        j = cloud.indices[k]
        dx, dy, dz = x[j, 0] - x[i, 0], x[j, 1] - x[i, 1], x[j, 2] - x[i, 2]
        r2 = dx * dx + dy * dy + dz * dz
        if 0.0 < r2 < radius2 and cloud.kind[j] != ABSENT:    # a coincident one has no direction
            _note(toward, n, dx, dy, dz, r2)
            n += 1
    return n


@inlined
def _reflections(toward, n, places, i, cloud, walls, radius2):
    """Add the unit vectors towards the reflections in present elements; return the number of all."""
    px, py, pz = cloud.x[i, 0], cloud.x[i, 1], cloud.x[i, 2]
    place, foot = places
    place[0], place[1], place[2] = px, py, pz
    for k in range(walls.indptr[i], walls.indptr[i + 1]):
        e = walls.indices[k]
        height = walls.shapes.plane[e, 0] * px + walls.shapes.plane[e, 1] * py + walls.shapes.plane[e, 2] * pz
        height -= walls.shapes.plane[e, 3]
        if walls.present[e] > 0.0 and 4.0 * height * height < radius2 * FARTHER:
            nearest_point(foot, place, e, walls.corners, cloud.axes)
            dx, dy, dz = foot[0] - px, foot[1] - py, foot[2] - pz
            r2 = dx * dx + dy * dy + dz * dz
            if 0.0 < 4.0 * r2 < radius2:
                _note(toward, n, dx, dy, dz, r2)
                n += 1
    return n


@inlined
def _note(toward, n, dx, dy, dz, r2):
    scale = 1.0 / math.sqrt(r2)
    toward[0, n], toward[1, n], toward[2, n] = dx * scale, dy * scale, dz * scale


@inlined
def _is_free(toward, n, axis, masks, limit):
    """Return whether any axis has no neighbour within its cone, whose half angle has the cosine `limit`.

    A neighbour on the side of the cone, but for rounding, is within it. The masks do not count on it.
    """
    first, second, third = np.uint64(0), np.uint64(0), np.uint64(0)
    for k in range(n):
        b = _bin(toward[0, k], toward[1, k], toward[2, k])
        first |= masks[b, 0]
        second |= masks[b, 1]
        third |= masks[b, 2]
    if first == EVERY and second == EVERY and third == LAST:
        return False
    for q in range(len(axis)):
        word = first if q < WORD else (second if q < 2 * WORD else third)
        if (word >> np.uint64(q % WORD)) & np.uint64(1):
            continue
        nearest = -1.0
        for k in range(n):
            cosine = toward[0, k] * axis[q, 0] + toward[1, k] * axis[q, 1] + toward[2, k] * axis[q, 2]
            nearest = max(nearest, cosine)
        if nearest < limit - TIE:
            return True
    return False


@inlined
def _bin(dx, dy, dz):
    """Return the bin of a direction: the face of the cube that it meets, and the place on the face."""
    ax, ay, az = abs(dx), abs(dy), abs(dz)
    if ax >= ay and ax >= az:
        face, most, p, q = 0 if dx > 0.0 else 1, ax, dy, dz
    elif ay >= az:
        face, most, p, q = 2 if dy > 0.0 else 3, ay, dz, dx
    else:
        face, most, p, q = 4 if dz > 0.0 else 5, az, dx, dy
    row = min(int((p / most + 1.0) * (0.5 * BINS)), BINS - 1)
    column = min(int((q / most + 1.0) * (0.5 * BINS)), BINS - 1)
    return (face * BINS + row) * BINS + column
