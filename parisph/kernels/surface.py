"""Divergence of position, and the particles on the free surface.

The gap rule and the auxiliary functions divide the plane into angles and work in 2D only (in 3D: kernels.cone). The
density ratio and the divergence of position work in any dimension. The caller gives walls that do not touch the fluid
(wetness.py) the kind ABSENT, so that they are not neighbours.
"""

import math
from typing import NamedTuple

import numpy as np

from parisph.base.fields import ABSENT, BALLISTIC, FLUID, INNER, SURFACE
from parisph.kernels.across import gather_across, room_across
from parisph.kernels.elements import nearest_point
from parisph.kernels.jit import inlined, kernel, subkernel
from parisph.kernels.records import Cloud, Walls
from parisph.kernels.smoothing import cubic_spline, cubic_spline_slope

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
def position_divergence(div: np.ndarray, cloud: Cloud, walls: Walls, h: float) -> None:
    """Write the kernel estimate of div r at fluid particles: the number of dimensions where neighbours are all around.

    div r_i = sum_j V (x_j - x_i) . grad_i W_ij over fluid, wall particles and reflections in walls (Lee et al. 2008, J.
    Comput. Phys. 227, 8417-8436, completed at walls). It is about half of that on a plane surface. Unlike in the
    density ratio, a particle itself does not count, and near ones count less than those at h.

    div : (n_owned,) output, dim at walls; ABSENT particles do not count
    h : smoothing length of the cubic spline [m]
    """
    across, dim = room_across(cloud), len(cloud.axes)
    for i in range(len(div)):
        div[i] = dim
        if cloud.kind[i] != FLUID:
            continue
        total = 0.0
        for k in range(gather_across(across, i, cloud, walls, cloud.corner, True, h)):
            q2 = 0.0
            for a in range(dim):
                q2 += across.near[a, k] ** 2
            total -= cubic_spline_slope(h * math.sqrt(q2), h, dim) * q2
        div[i] = cloud.spacing**dim * h * h * total


class Gap(NamedTuple):
    """The gap rule: a particle joins the surface if its gap exceeds `enter` [rad], and stays on it above `leave`.

    The two thresholds keep a particle from alternating between p = 0 and an equation, which would cause pressure
    pulses. Below the density ratio `thin` it is always on the surface.
    """

    enter: float
    leave: float
    thin: float


@kernel
def surface_by_gap(role: np.ndarray, was: np.ndarray, cloud: Cloud, walls: Walls, alpha: np.ndarray, radius: float,
                   gap: Gap) -> None:
    """Mark fluid particles on the surface by the largest angle free of neighbours (2D).

    An element that is present counts as the particle's reflection in it: in the direction of its nearest point, twice
    as far away. ABSENT particles do not count.

    role : output for owned fluid; was : role at the previous step (owned and ghost); alpha : (n_owned,)
    """
    place, foot = np.empty(2), np.empty(2)
    angles = np.empty(1024)
    radius2 = radius * radius
    for i in range(len(alpha)):
        if cloud.kind[i] != FLUID:
            continue
        role[i] = INNER
        if alpha[i] < gap.thin:
            role[i] = SURFACE
            continue
        limit = gap.leave if was[i] == SURFACE or was[i] == BALLISTIC else gap.enter
        if _bound_of_gap(i, cloud, radius2) < limit:
            continue  # most particles need no angles
        n = _angles(angles, i, cloud, radius2)
        for k in range(walls.indptr[i], walls.indptr[i + 1]):
            e = walls.indices[k]
            place[0], place[1] = cloud.x[i, 0], cloud.x[i, 1]
            nearest_point(foot, place, e, walls.corners, cloud.axes)
            dx, dy = foot[0] - cloud.x[i, 0], foot[1] - cloud.x[i, 1]
            if walls.present[e] > 0.0 and 0.0 < 4.0 * (dx * dx + dy * dy) < radius2 and n < len(angles):
                angles[n] = math.atan2(dy, dx)
                n += 1
        if _largest_gap(angles, n) > limit:
            role[i] = SURFACE


@inlined
def _bound_of_gap(i, cloud, radius2):
    """Return an upper bound of the gaps between neighbours [rad].

    A gap consists of empty consecutive sectors and at most the sectors at its ends. The code has no branches, because
    the sector of a neighbour is unpredictable.
    """
    x, kind = cloud.x, cloud.kind
    occupied, cx, cy = 0, x[i, 0], x[i, 1]
    for k in range(np.uint32(cloud.indptr[i]), np.uint32(cloud.indptr[i + 1])):
        j = np.uint32(cloud.indices[k])
        dx, dy = x[j, 0] - cx, x[j, 1] - cy
        r2 = dx * dx + dy * dy
        near = (0.0 < r2) & (r2 < radius2) & (kind[j] != ABSENT)  # a coincident one has no direction
        occupied |= near << _sector(dx, dy)
    empty = ((1 << 2 * SECTORS) - 1) & ~(occupied | occupied << SECTORS)  # twice around
    longest = 0
    while empty:
        empty &= empty >> 1  # remaining bits have one more empty sector behind them
        longest += 1
    return (longest + 2) * (2.0 * math.pi / SECTORS)


@inlined
def _sector(dx, dy):
    """Return the sector of a direction, 0 to 15 counter-clockwise."""
    a, b = abs(dx), abs(dy)
    small = min(a, b) < (math.sqrt(2.0) - 1.0) * max(a, b)
    sector = 1 - small if a > b else 2 + small
    sector = 7 - sector if dx < 0.0 else sector
    return 15 - sector if dy < 0.0 else sector


@inlined
def _angles(angles, i, cloud, radius2):
    """Write the directions of the neighbours; return their number."""
    n = 0
    for k in range(cloud.indptr[i], cloud.indptr[i + 1]):
        j = cloud.indices[k]
        dx, dy = cloud.x[j, 0] - cloud.x[i, 0], cloud.x[j, 1] - cloud.x[i, 1]
        if 0.0 < dx * dx + dy * dy < radius2 and cloud.kind[j] != ABSENT and n < len(angles):
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
def surface_by_auxiliary_functions(role: np.ndarray, was: np.ndarray, cloud: Cloud, walls: Walls, alpha: np.ndarray,
                                   radius: float, limit: float) -> None:
    """Mark the surface by density ratio and three auxiliary functions (2D).

    Zheng, Ma & Duan (2014), Sec. 2.4.2, Eqs. 28-30, conditions (a) to (e), with limit = 0.90. Only particles on the
    surface at the previous step and their neighbours are candidates. Wall particles and reflections in walls occupy
    quadrants as fluid does.
    """
    across = room_across(cloud)
    for i in range(len(alpha)):
        if cloud.kind[i] != FLUID:
            continue
        role[i] = INNER
        near_surface, inner = was[i] == SURFACE or was[i] == BALLISTIC, False
        for k in range(cloud.indptr[i], cloud.indptr[i + 1]):
            j = cloud.indices[k]
            dx, dy = cloud.x[j, 0] - cloud.x[i, 0], cloud.x[j, 1] - cloud.x[i, 1]
            if cloud.kind[j] == FLUID and 0.0 < dx * dx + dy * dy < radius * radius:
                near_surface |= was[j] == SURFACE or was[j] == BALLISTIC
                inner |= was[j] == INNER
        if not near_surface:
            continue
        quadrants, shaded = 0, 0
        for k in range(gather_across(across, i, cloud, walls, cloud.corner, True, radius)):
            dx, dy = across.near[0, k], across.near[1, k]
            if 0.0 < dx * dx + dy * dy < 1.0:    # a coincident one has no direction
                quadrants |= _quadrant(dx, dy)
                shaded |= _shaded(dx, dy)
        if not inner or not alpha[i] > limit or _bits(quadrants) < 4 or _bits(shaded) < 4:
            role[i] = SURFACE


@subkernel
def _quadrant(dx, dy):
    """Return the bits of the quadrants that a neighbour occupies; on an axis, both."""
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
def surface_by_density(role: np.ndarray, cloud: Cloud, alpha: np.ndarray, limit: float) -> None:
    """Mark the surface by the density ratio alone (any dimension), alpha < limit."""
    for i in range(len(alpha)):
        if cloud.kind[i] == FLUID:
            role[i] = SURFACE if alpha[i] < limit else INNER
