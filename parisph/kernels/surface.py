"""Density ratio, divergence of position, and which particles lie on the free surface.

The gap rule and the auxiliary functions divide the plane into angles and work in 2D only; the density
ratio and the divergence of position work in any dimension. Walls that do not touch the fluid (see
wetness.py) must not count as neighbours: the caller gives them the kind ABSENT.
"""

import math

import numpy as np

from parisph.base.fields import ABSENT, BALLISTIC, FLUID, INNER, SURFACE, WALL
from parisph.kernels.jit import inlined, kernel, subkernel
from parisph.kernels.mirrors import gather_around, near_planes, reflect
from parisph.kernels.near import room_for
from parisph.kernels.smoothing import cubic_spline, cubic_spline_slope
from parisph.kernels.solids import nearest_point

SECTORS = 16  # of the circle, in the quick test for a gap


@kernel
def lattice_sum(spacing: float, h: float, axes: tuple[int, ...]) -> float:
    """Return sum_j W(r_ij) over the full square or cubic lattice, i included [m^-dim]."""
    dim = len(axes)
    reach = int(2.0 * h / spacing) + 1
    side = 2 * reach + 1
    total = 0.0
    for cell in range(side**dim):
        rest, r2 = cell, 0.0
        for a in range(dim):
            r2 += (rest % side - reach) ** 2
            rest //= side
        total += cubic_spline(spacing * math.sqrt(r2), h, dim)
    return total


@kernel
def density_ratio(alpha: np.ndarray, x: np.ndarray, kind: np.ndarray, corner: np.ndarray, normal: np.ndarray, h: float,
                  full: float, indptr: np.ndarray, indices: np.ndarray, axes: tuple[int, ...]) -> None:
    """Kernel-sum density of fluid particles over its lattice value: 1 on a full lattice.

    rho_i = sum_j m W_ij over fluid, wall particles and the mirror images of both
    (Zheng, Ma & Duan 2014, Sec. 2.4.2, completed at walls); `full` from `lattice_sum`.

    alpha : (n_owned,) output; walls get 1
    """
    dim = len(axes)
    member, image, walls = np.empty(dim, np.int64), np.empty(dim), np.empty(room_for(indptr), np.int32)
    near = np.empty((dim, room_for(indptr) * 2**dim))
    for i in range(len(indptr) - 1):
        alpha[i] = 1.0
        if kind[i] != FLUID:
            continue
        total = cubic_spline(0.0, h, dim)
        for k in range(gather_around(near, walls, member, image, i, x, kind, corner, normal, h, indptr, indices, axes)):
            q2 = 0.0
            for a in range(dim):
                q2 += near[a, k] ** 2
            total += cubic_spline(h * math.sqrt(q2), h, dim)
        alpha[i] = total / full


@kernel
def position_divergence(div: np.ndarray, x: np.ndarray, kind: np.ndarray, corner: np.ndarray, normal: np.ndarray,
                        h: float, volume: float, indptr: np.ndarray, indices: np.ndarray,
                        axes: tuple[int, ...]) -> None:
    """Kernel estimate of div r of fluid particles: the number of dimensions where neighbours are all around.

    div r_i = sum_j V (x_j - x_i) . grad_i W_ij over fluid, wall particles and the mirror images of both
    (Lee et al. 2008, J. Comput. Phys. 227, 8417-8436, completed at walls). It is about half of that on a plane
    surface. Like the density ratio, but a particle itself does not count, and near ones count less than those at h.

    div : (n_owned,) output; walls get dim
    kind : (n_all,), ABSENT for particles that are no neighbours
    h : smoothing length of the cubic spline [m]; volume : of a particle [m^dim]
    """
    dim = len(axes)
    member, image, walls = np.empty(dim, np.int64), np.empty(dim), np.empty(room_for(indptr), np.int32)
    near = np.empty((dim, room_for(indptr) * 2**dim))
    for i in range(len(indptr) - 1):
        div[i] = dim
        if kind[i] != FLUID:
            continue
        total = 0.0
        for k in range(gather_around(near, walls, member, image, i, x, kind, corner, normal, h, indptr, indices, axes)):
            q2 = 0.0
            for a in range(dim):
                q2 += near[a, k] ** 2
            total -= cubic_spline_slope(h * math.sqrt(q2), h, dim) * q2
        div[i] = volume * h * h * total


@kernel
def surface_by_gap(role: np.ndarray, was: np.ndarray, x: np.ndarray, kind: np.ndarray, corner: np.ndarray,
                   normal: np.ndarray, alpha: np.ndarray, radius: float, enter: float, leave: float, thin: float,
                   mirrors: bool, corners: np.ndarray, present: np.ndarray, element_indptr: np.ndarray,
                   element_indices: np.ndarray, indptr: np.ndarray, indices: np.ndarray,
                   axes: tuple[int, ...]) -> None:
    """Mark fluid particles on the surface by the largest angle free of neighbours (2D).

    A particle joins the surface if the gap exceeds `enter` [rad], and stays on it while the gap exceeds
    `leave`. A particle with fewer than four neighbours within the radius, or a density ratio below
    `thin`, is always on it. The two thresholds keep a particle from alternating between p = 0 and an
    equation, which would cause pressure pulses.

    role : output for owned fluid; was : role at the previous step (owned and ghost)
    kind : (n_all,), ABSENT for particles that are no neighbours
    mirrors : whether images of fluid in walls count, too
    corners, present : of elements, as of density.completed_density; that point of an element counts which is nearest
    """
    member, image = np.empty(2, np.int64), np.empty(2)
    place, foot = np.empty(2), np.empty(2)
    angles = np.empty(1024)
    radius2 = radius * radius
    for i in range(len(indptr) - 1):
        if kind[i] != FLUID:
            continue
        role[i] = INNER
        if alpha[i] < thin:
            role[i] = SURFACE
            continue
        limit = leave if was[i] == SURFACE or was[i] == BALLISTIC else enter
        n, bound = _bound_of_gap(i, x, kind, radius2, indptr, indices)
        if n >= 4 and bound < limit:
            continue  # most particles: no angle has to be known
        n, walls = _angles(angles, i, x, kind, radius2, indptr, indices)
        if walls and mirrors:
            planes = near_planes(member, i, x, kind, corner, normal, indptr, indices, axes)
            n = _image_angles(angles, n, i, planes, member, image, x, kind, normal, radius2, indptr,
                              indices, axes)
        for k in range(element_indptr[i], element_indptr[i + 1]):
            e = element_indices[k]
            place[0], place[1] = x[i, 0], x[i, 1]
            nearest_point(foot, place, e, corners, axes)
            dx, dy = foot[0] - x[i, 0], foot[1] - x[i, 1]
            if present[e] > 0.0 and 0.0 < dx * dx + dy * dy < radius2 and n < len(angles):
                angles[n] = math.atan2(dy, dx)
                n += 1
        if n < 4 or _largest_gap(angles, n) > limit:
            role[i] = SURFACE


@inlined
def _bound_of_gap(i, x, kind, radius2, indptr, indices):
    """Return the number of neighbours, and an upper bound for the gaps between them [rad].

    A gap covers consecutive empty sectors, and at most the sectors at its two ends. The code has no
    branches, because the sector of a neighbour cannot be predicted.
    """
    n, occupied, cx, cy = 0, 0, x[i, 0], x[i, 1]
    for k in range(np.uint32(indptr[i]), np.uint32(indptr[i + 1])):
        j = np.uint32(indices[k])
        dx, dy = x[j, 0] - cx, x[j, 1] - cy
        r2 = dx * dx + dy * dy
        near = (0.0 < r2) & (r2 < radius2) & (kind[j] != ABSENT)  # one in the same place is in no direction
        n += near
        occupied |= near << _sector(dx, dy)
    empty = ((1 << 2 * SECTORS) - 1) & ~(occupied | occupied << SECTORS)  # twice around
    longest = 0
    while empty:
        empty &= empty >> 1  # what is left has one more empty sector behind it
        longest += 1
    return n, (longest + 2) * (2.0 * math.pi / SECTORS)


@inlined
def _sector(dx, dy):
    """Return the number of the sector that a direction is in, 0 to 15 counter-clockwise."""
    a, b = abs(dx), abs(dy)
    small = min(a, b) < (math.sqrt(2.0) - 1.0) * max(a, b)
    sector = 1 - small if a > b else 2 + small
    sector = 7 - sector if dx < 0.0 else sector
    return 15 - sector if dy < 0.0 else sector


@inlined
def _angles(angles, i, x, kind, radius2, indptr, indices):
    """Write the directions of the neighbours; return how many, and whether walls are among those listed."""
    n, walls = 0, False
    for k in range(indptr[i], indptr[i + 1]):
        j = indices[k]
        walls |= kind[j] == WALL
        dx, dy = x[j, 0] - x[i, 0], x[j, 1] - x[i, 1]
        if 0.0 < dx * dx + dy * dy < radius2 and kind[j] != ABSENT and n < len(angles):
            angles[n] = math.atan2(dy, dx)
            n += 1
    return n, walls


@subkernel
def _image_angles(angles, n, i, planes, member, image, x, kind, normal, radius2, indptr, indices, axes):
    for subset in range(1, 1 << planes):
        for k in range(indptr[i] - 1, indptr[i + 1]):
            j = i if k < indptr[i] else indices[k]
            if kind[j] != FLUID:
                continue
            reflect(image, j, subset, member, x, normal, axes)
            dx, dy = image[0] - x[i, 0], image[1] - x[i, 1]
            if 0.0 < dx * dx + dy * dy < radius2 and n < len(angles):
                angles[n] = math.atan2(dy, dx)
                n += 1
    return n


@subkernel
def _largest_gap(angles, n):
    if n == 0:
        return 2.0 * math.pi
    for m in range(1, n):  # insertion sort: a dozen angles
        value, k = angles[m], m - 1
        while k >= 0 and angles[k] > value:
            angles[k + 1] = angles[k]
            k -= 1
        angles[k + 1] = value
    gap = angles[0] + 2.0 * math.pi - angles[n - 1]
    for m in range(1, n):
        gap = max(gap, angles[m] - angles[m - 1])
    return gap


@kernel
def surface_by_auxiliary_functions(role: np.ndarray, was: np.ndarray, x: np.ndarray, kind: np.ndarray,
                                   corner: np.ndarray, normal: np.ndarray, alpha: np.ndarray, radius: float,
                                   limit: float, indptr: np.ndarray, indices: np.ndarray,
                                   axes: tuple[int, ...]) -> None:
    """Mark the surface by density ratio and three auxiliary functions (2D).

    Zheng, Ma & Duan (2014), Sec. 2.4.2, Eqs. 28-30, conditions (a) to (e), with limit = 0.90.
    Only particles on the surface at the previous step and their neighbours are candidates.
    Wall particles and mirror images count as occupants of a quadrant, as fluid does.
    """
    member, image = np.empty(2, np.int64), np.empty(2)
    radius2 = radius * radius
    for i in range(len(indptr) - 1):
        if kind[i] != FLUID:
            continue
        role[i] = INNER
        near_surface = was[i] == SURFACE or was[i] == BALLISTIC
        quadrants, shaded, inner, walls = 0, 0, 0, False
        for k in range(indptr[i], indptr[i + 1]):
            j = indices[k]
            walls |= kind[j] == WALL
            dx, dy = x[j, 0] - x[i, 0], x[j, 1] - x[i, 1]
            if not 0.0 < dx * dx + dy * dy < radius2 or kind[j] == ABSENT:  # one in the same place is in no direction
                continue
            near_surface |= kind[j] == FLUID and (was[j] == SURFACE or was[j] == BALLISTIC)
            inner += kind[j] == FLUID and was[j] == INNER
            quadrants |= _quadrant(dx, dy)
            shaded |= _shaded(dx, dy)
        if not near_surface:
            continue
        if walls:
            planes = near_planes(member, i, x, kind, corner, normal, indptr, indices, axes)
            for subset in range(1, 1 << planes):
                for k in range(indptr[i] - 1, indptr[i + 1]):
                    j = i if k < indptr[i] else indices[k]
                    if kind[j] != FLUID:
                        continue
                    reflect(image, j, subset, member, x, normal, axes)
                    dx, dy = image[0] - x[i, 0], image[1] - x[i, 1]
                    if 0.0 < dx * dx + dy * dy < radius2:
                        quadrants |= _quadrant(dx, dy)
                        shaded |= _shaded(dx, dy)
        b, c = _bits(quadrants), _bits(shaded)
        dense = alpha[i] > limit
        if (inner == 0 or not dense or b < 4 or c < 4):
            role[i] = SURFACE


@subkernel
def _quadrant(dx, dy):
    """Return the bits of the quadrants that a neighbour occupies; one on an axis lies in both."""
    bits = 0
    if dx >= 0.0 and dy >= 0.0:
        bits |= 1
    if dx <= 0.0 and dy >= 0.0:
        bits |= 2
    if dx <= 0.0 and dy <= 0.0:
        bits |= 4
    if dx >= 0.0 and dy <= 0.0:
        bits |= 8
    return bits


@subkernel
def _shaded(dx, dy):
    """Return the bits of the right-angled sectors about the axes that a neighbour occupies."""
    bits = 0
    if dx >= abs(dy):
        bits |= 1
    if dy >= abs(dx):
        bits |= 2
    if -dx >= abs(dy):
        bits |= 4
    if -dy >= abs(dx):
        bits |= 8
    return bits


@subkernel
def _bits(mask):
    return (mask & 1) + ((mask >> 1) & 1) + ((mask >> 2) & 1) + ((mask >> 3) & 1)


@kernel
def surface_by_density(role: np.ndarray, kind: np.ndarray, alpha: np.ndarray, limit: float, indptr: np.ndarray) -> None:
    """Mark the surface by the density ratio alone (any dimension), alpha < limit."""
    for i in range(len(indptr) - 1):
        if kind[i] == FLUID:
            role[i] = SURFACE if alpha[i] < limit else INNER
