"""The half cells beside walls: does any fluid stand for them?

A wall particle takes the place of a neighbour one spacing away, thus fluid beside a wall is at rest in the
kernel sums one spacing in front of it. Fluid that starts there represents the half cell at the wall as well,
3/2 cells in all. Fluid that comes to the wall later represents one cell, and has its place at half a spacing:
its images are its neighbours then, and a wall particle would be one too many.
"""

import math

import numpy as np

from parisph.base.fields import ABSENT, FLUID, WALL
from parisph.kernels.jit import inlined, kernel, subkernel
from parisph.kernels.mirrors import casts_image, height, near_planes, reflect
from parisph.kernels.near import dot, room_for
from parisph.kernels.smoothing import cubic_spline, cubic_spline_slope

BEFORE = 1.5    # spacings from a wall within which fluid stands for its half cell there
# The same where fluid is pressed together along the wall, and how many half cells there are then.
FAR_BEFORE, PRESSED = 2.0, 2.0


@kernel
def wall_share(share: np.ndarray, x: np.ndarray, kind: np.ndarray, cells: np.ndarray, normal: np.ndarray,
               spacing: float, most: float, before: float, indptr: np.ndarray, indices: np.ndarray,
               axes: tuple[int, ...]) -> None:
    """Write the part of the half cells at owned wall particles that fluid in front of them stands for, 1 for fluid.

    share_i = min(most, sum_j (1 - t_ij/s) b_j), b_j = min(1, max(0, 2 (cells_j - 1))), over the fluid closer than
    `before` [spacings] to the wall, with the distance t_ij < s along the wall.

    share : (n_owned,) output; cells : (n_all,), for how many of its own a particle stands
    """
    dim = len(axes)
    for i in range(len(indptr) - 1):
        share[i] = 1.0
        if kind[i] != WALL:
            continue
        total = 0.0
        for k in range(indptr[i], indptr[i + 1]):
            j = indices[k]
            if kind[j] != FLUID:
                continue
            away, r2 = height(j, i, x, normal, axes), 0.0
            for a in range(dim):
                r2 += (x[j, a] - x[i, a]) ** 2
            along = math.sqrt(max(r2 - away * away, 0.0)) / spacing
            if 0.0 < away < before * spacing and along < 1.0:
                total += (1.0 - along) * min(max(2.0 * (cells[j] - 1.0), 0.0), 1.0)
        share[i] = min(total, most)


@kernel
def add_parts(ratio: np.ndarray, gradient: np.ndarray, further: np.ndarray, own: np.ndarray, x: np.ndarray,
              kind: np.ndarray, part: np.ndarray, other: np.ndarray, corner: np.ndarray, normal: np.ndarray, h: float,
              full: float, indptr: np.ndarray, indices: np.ndarray, axes: tuple[int, ...]) -> None:
    """Add to the density ratio, and to its gradient, what comes from a part of each particle.

    ratio_i = sum_j part_j W_ij / sum W over i itself, its neighbours, and the mirror images of these
    (`surface.density_ratio`). The part 1 - share of walls is what half cells add for which no fluid stands; the part
    weight - 1 of fluid is what its cells have more than those of the lattice.

    ratio : (n_owned,), gradient : (n_owned, dim) [1/m]; own : of these, the fluid to look at
    kind : (n_all,), ABSENT for particles that are no neighbours; part : (n_all,), negative where something is missing
    further : (n_owned,), the ratio of `other` (n_all,) parts; both without rows if there are none
    indptr, indices : the lists of all neighbours; for parts of walls alone, also those of `mirrors.beside_walls`
    """
    dim = len(axes)
    member, image = np.empty(dim, np.int64), np.empty(dim)
    for i in own:
        if not (_any_part(i, kind, part, indptr, indices)
                or (len(other) > 0 and _any_part(i, kind, other, indptr, indices))):
            continue
        planes = near_planes(member, i, x, kind, corner, normal, indptr, indices, axes)
        for subset in range(1 << planes):
            for k in range(indptr[i] - 1, indptr[i + 1]):
                j = i if k < indptr[i] else indices[k]
                one, two = part[j], other[j] if len(other) > 0 else 0.0
                if (one == 0.0 and two == 0.0) or kind[j] == ABSENT:
                    continue
                if subset:
                    if not casts_image(j, subset, member, x, kind, normal, 0.1 * h, axes):
                        continue
                    reflect(image, j, subset, member, x, normal, axes)
                else:
                    for a in range(dim):
                        image[a] = x[j, a]
                _add(ratio, gradient, further, i, image, x, one / full, two / full, h, axes)


@kernel
def add_parts_inside(ratio: np.ndarray, gradient: np.ndarray, x: np.ndarray, kind: np.ndarray, part: np.ndarray,
                     h: float, full: float, walls: np.ndarray, indptr: np.ndarray, indices: np.ndarray,
                     axes: tuple[int, ...]) -> None:
    """The same as `add_parts` for owned fluid without walls in its lists, in a fraction of the time.

    walls : indptr (n_owned + 1,) of the walls in the lists, of `mirrors.beside_walls`; other arguments as there
    """
    dim = len(axes)
    near, weight = np.empty((dim, room_for(indptr))), np.empty((1, room_for(indptr)))
    for i in range(len(indptr) - 1):
        if kind[i] != FLUID or walls[i + 1] > walls[i]:
            continue
        first, count = indptr[i], indptr[i + 1] - indptr[i]
        for k in range(count):
            j = np.uint32(indices[first + k])
            for a in range(dim):
                near[a, k] = x[i, a] - x[j, a]
            weight[0, k] = part[j]
        total = part[i] * cubic_spline(0.0, h, dim)
        for k in range(count):
            r2 = 0.0
            for a in range(dim):
                r2 += near[a, k] ** 2
            r = math.sqrt(r2)
            total += weight[0, k] * cubic_spline(r, h, dim)
            weight[0, k] *= cubic_spline_slope(r, h, dim)
        ratio[i] += total / full
        for a in range(dim):
            gradient[i, a] += dot(weight, 0, near, a, count) / full


@subkernel
def _any_part(i, kind, part, indptr, indices):
    """Return whether particle i, or any in its list, has a part that is not 0."""
    if part[i] != 0.0:
        return True
    for k in range(indptr[i], indptr[i + 1]):
        if kind[indices[k]] != ABSENT and part[indices[k]] != 0.0:
            return True
    return False


@inlined
def _add(ratio, gradient, further, i, place, x, weight, other, h, axes):
    """Add a neighbour at a place to the sums of particle i."""
    dim, r2 = len(axes), 0.0
    for a in range(dim):
        r2 += (place[a] - x[i, a]) ** 2
    here = cubic_spline(math.sqrt(r2), h, dim)
    ratio[i] += weight * here
    if len(further) > 0:
        further[i] += other * here
    slope = weight * cubic_spline_slope(math.sqrt(r2), h, dim)
    for a in range(dim):
        gradient[i, a] -= slope * (place[a] - x[i, a])
