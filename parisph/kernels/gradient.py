"""Forms of the pressure gradient."""

import math

import numpy as np

from parisph.base.fields import BALLISTIC, INNER, SURFACE, WALL
from parisph.kernels import harmonic
from parisph.kernels.edges import edge_direction
from parisph.kernels.elements import element_normal, nearest_point
from parisph.kernels.jit import inlined, kernel, subkernel
from parisph.kernels.mls import moment_count
from parisph.kernels.moments import invert, pair_weight
from parisph.kernels.near import Form, dot, fill_up, gather, room_for, sum_changes, sum_moments, weigh, weights
from parisph.kernels.records import Cloud, Walls
from parisph.kernels.roles import outside
from parisph.kernels.smoothing import cubic_spline_slope

TOO_FEW = -1.0      # quality of a moment of fewer than dim + 1 neighbours
# Damping of velocity slopes at walls, in squares of the radius. Along the wall it matters only where a few neighbours
# lie on one side.
ACROSS = 0.1        # tuned 0.05 to 0.2: damping of the slope of the velocity across a wall; judged
ALONG = 0.01        # tuned 0.005 to 0.02: damping of that slope along a wall; judged
SOFTENING = 0.25    # tuned 0.125 to 0.5: part of its mean added to a flat moment, times its lack of quality; judged
# In the tip of water on a flat beach the surface is the only layer, up to 1.5 spacings above the bed, and nodes below
# it have no row.
DATUM = 1.4    # tuned 0.7 to 2.8: spacings from a wall within which its datum helps a gradient; judged


@kernel
def least_squares_gradient(out: np.ndarray, known: np.ndarray, cloud: Cloud, f: np.ndarray, form: Form) -> None:
    """Write the first-order least-squares gradient of f at fluid particles.

    power 2: SFDI (Zheng et al. 2017, Eqs. 29-32); power 0: the mixed symmetric form (Eq. 28, where the printed volumes
    cancel). SPLINE (of `near`) is Eq. 28 with the papers' cubic spline instead of the quartic weight. SPLINE_SLOPE is
    the corrected kernel gradient of Eqs. 26-27: grad W = (W'/r) r_ij makes it a least-squares fit with the weight
    -W'/r. Eq. 27, and L in Eq. 28, lack m_j/rho_j; with it the volumes cancel. Exact for linear f on any particles.

    Particles with fewer than dim + 1 neighbours, or with all of them in one place, get the role BALLISTIC.

    out : (n_owned, dim) [unit of f per m]; zero at walls and BALLISTIC particles; below the floor of the form, the
        slope across the line (3D: line or plane) of the neighbours is damped
    known : (n_owned,) bool, where out stays; f : (n_all,)
    """
    role, indptr, axes, radius = cloud.role, cloud.indptr, cloud.axes, form.radius
    dim, room = len(axes), room_for(indptr)
    near, weighted, difference = np.empty((dim, room)), np.empty((1, room)), np.empty((1, room))
    member = np.empty(room, np.int32)
    m, inverse = np.empty((dim, dim)), np.empty((dim, dim))
    moments, sums = np.empty((moment_count(axes), 1)), np.empty(1 + dim)
    for i in range(len(indptr) - 1):
        if known[i]:
            continue
        for a in range(dim):
            out[i, a] = 0.0
        if role[i] != INNER and role[i] != SURFACE:
            continue
        n = gather(near, member, 0, i, cloud, radius)
        columns = fill_up(near, n, axes)
        quality = fitted(m, inverse, moments, weighted, near, form.power, columns, axes)
        if quality == TOO_FEW or (quality < form.floor and not _soften(m, inverse, form.floor - quality, axes)):
            role[i] = BALLISTIC
            continue
        for k in range(n):
            difference[0, k] = f[np.uint32(member[k])] - f[i]
        for k in range(n, columns):
            difference[0, k] = 0.0
        sum_changes(sums, weighted, near, difference, 0, columns, axes)
        for b in range(dim):
            right = sums[1 + b] / radius
            for a in range(dim):
                out[i, a] += inverse[a, b] * right


@inlined
def fitted(m: np.ndarray, inverse: np.ndarray, moments: np.ndarray, weighted: np.ndarray, near: np.ndarray, power: int,
           columns: int, axes: tuple[int, ...]) -> float:
    """Write the weights in row 0 and invert the neighbours' moment; return the same quality as `support`.

    It is faster, because it needs no products of weights and coordinates. moments : (moment_count, 1) output
    """
    dim = len(axes)
    weights(weighted, near, power, columns, axes)
    found = sum_moments(moments, 0, weighted, near, columns, axes)
    r = 1 + dim
    for a in range(dim):
        for b in range(a + 1):
            m[a, b] = m[b, a] = moments[r, 0]
            r += 1
    quality = invert(m, inverse, axes)
    return quality if found > dim else TOO_FEW


@inlined
def support(m: np.ndarray, inverse: np.ndarray, weighted: np.ndarray, near: np.ndarray, power: int, n: int,
            columns: int, axes: tuple[int, ...]) -> float:
    """Write the weights and invert the neighbours' moment; return det/(trace/dim)^dim, or TOO_FEW for at most dim."""
    dim = len(axes)
    weigh(weighted, near, power, columns, axes)
    for a in range(dim):
        for b in range(a + 1):
            m[a, b] = m[b, a] = dot(weighted, 1 + a, near, b, columns)
    found = 0
    for k in range(n):
        found += weighted[0, k] > 0.0
    quality = invert(m, inverse, axes)
    return quality if found > dim else TOO_FEW


@inlined
def _soften(m, inverse, lack, axes):
    """Invert the moment plus an isotropic part, so that neighbours on a line give a slope along it only.

    Returns False if the moment is zero.
    """
    dim, trace = len(axes), 0.0
    for a in range(dim):
        trace += m[a, a]
    for a in range(dim):
        m[a, a] += SOFTENING * lack * trace / dim
    return invert(m, inverse, axes) > 0.0


@kernel
def regain_role(start_role: np.ndarray, cloud: Cloud, form: Form) -> None:
    """Give ballistic owned fluid its initial role again once its neighbours support a gradient.

    For rules that keep the initial surface, where nothing else ends free flight. A floor above that of
    least_squares_gradient keeps particles from alternating between the two roles.

    start_role : (n_owned,)
    """
    indptr, axes = cloud.indptr, cloud.axes
    dim, room = len(axes), room_for(indptr)
    near, weighted, member = np.empty((dim, room)), np.empty((1, room)), np.empty(room, np.int32)
    m, inverse, moments = np.empty((dim, dim)), np.empty((dim, dim)), np.empty((moment_count(axes), 1))
    for i in range(len(indptr) - 1):
        if cloud.role[i] != BALLISTIC:
            continue
        columns = fill_up(near, gather(near, member, 0, i, cloud, form.radius), axes)
        if fitted(m, inverse, moments, weighted, near, form.power, columns, axes) >= form.floor:
            cloud.role[i] = start_role[i]


@kernel
def harmonic_gradient(out: np.ndarray, cloud: Cloud, f: np.ndarray, radius: float, sure: float,
                      most: float) -> np.ndarray:
    """Replace the gradient at surface particles by that of the harmonic fit; return where it is unsure (n_owned,) bool.

    `out` stays unchanged where the neighbours do not span the harmonic basis, or where the harmonic terms raise the
    variance of the slope to more than `most` times that of a linear fit. The fit is unsure where they raise it to more
    than `sure` times.
    """
    indptr, indices, dim = cloud.indptr, cloud.indices, len(cloud.axes)
    c, work, b = harmonic.scratch(indptr, cloud.axes)
    unsure = np.zeros(len(indptr) - 1, np.bool_)
    for i in range(len(indptr) - 1):
        if cloud.role[i] != SURFACE:
            continue
        if not harmonic.coefficients(c, i, cloud, radius, min(sure, most), work, b):
            unsure[i] = most > sure and harmonic.coefficients(c, i, cloud, radius, most, work, b)
            if not unsure[i]:
                continue
        out[i, :] = 0.0
        for k in range(indptr[i], indptr[i + 1]):
            for a in range(dim):
                out[i, a] += c[k - indptr[i], a] * (f[indices[k]] - f[i])
    return unsure


@kernel
def gradient_at_walls(out: np.ndarray, known: np.ndarray, cloud: Cloud, walls: Walls, f: np.ndarray, here: np.ndarray,
                      less: np.ndarray, form: Form) -> None:
    """Repeat `least_squares_gradient` where neighbours are too few, with the slope at the nearest wall as a datum.

    M becomes M + w n n^T, and b becomes b + w n (n . slope), w = tr M, with the normal n of the nearest element.
    Without it, a particle at a contact line in a wedge of water may fall freely and disturb the flow. Exact for linear
    f with this slope at the wall. BALLISTIC particles that get a slope become SURFACE.

    here : (n_all, dim), less : (M, dim), of elements; the gradient of f at a wall has the normal part of here - less
    """
    role, indptr, axes, radius = cloud.role, cloud.indptr, cloud.axes, form.radius
    dim, room = len(axes), room_for(indptr)
    near, weighted, difference = np.empty((dim, room)), np.empty((dim + 1, room)), np.empty((1, room))
    member = np.empty(room, np.int32)
    m, inverse = np.empty((dim, dim)), np.empty((dim, dim))
    normal, places = np.empty(dim), (np.empty(dim), np.empty(dim))
    for i in range(len(indptr) - 1):
        if known[i] or walls.indptr[i] == walls.indptr[i + 1] or role[i] not in (INNER, SURFACE, BALLISTIC):
            continue
        n = gather(near, member, 0, i, cloud, radius)
        columns = fill_up(near, n, axes)
        if support(m, inverse, weighted, near, form.power, n, columns, axes) >= form.floor:
            continue
        e = _nearest_element(normal, places, i, cloud, walls)
        if e < 0:
            continue
        trace, across = _add_wall(m, normal, i, e, here, less, axes)
        quality = invert(m, inverse, axes)
        if not quality > 0.0 or (quality < form.floor and not _soften(m, inverse, form.floor - quality, axes)):
            continue
        for k in range(columns):
            difference[0, k] = (f[member[k]] - f[i]) / radius if k < n else 0.0
        out[i, :] = 0.0
        for b in range(dim):
            right = dot(weighted, 1 + b, difference, 0, columns) + trace * normal[b] * across
            for a in range(dim):
                out[i, a] += inverse[a, b] * right
        if role[i] == BALLISTIC:
            role[i] = SURFACE


@subkernel
def _nearest_element(normal, places, i, cloud, walls):
    """Return the nearest element seen from i, -1 if it is too far for a datum, and write its normal.

    places : ((dim,), (dim,)) scratch
    """
    (place, foot), dim, within = places, len(cloud.axes), DATUM * cloud.spacing
    least, nearest = within * within, -1
    for k in range(walls.indptr[i], walls.indptr[i + 1]):
        e = walls.indices[k]
        for a in range(dim):
            place[a] = cloud.x[i, a]
        nearest_point(foot, place, e, walls.corners, cloud.axes)
        r2 = 0.0
        for a in range(dim):
            r2 += (place[a] - foot[a]) ** 2
        if r2 < least:
            least, nearest = r2, e
            element_normal(normal, e, walls.corners, cloud.axes)
    return nearest


@inlined
def _add_wall(m, normal, i, e, here, less, axes):
    """Add the datum of element e to the moment m; return its weight and the slope across the wall."""
    trace, across = 0.0, 0.0
    for a in range(len(axes)):
        trace += m[a, a]
        across += normal[a] * (here[i, a] - less[e, a])
    for a in range(len(axes)):
        for b in range(len(axes)):
            m[a, b] += trace * normal[a] * normal[b]
    return trace, across


@kernel
def symmetric_gradient(out: np.ndarray, cloud: Cloud, p: np.ndarray, h: float, volume: float) -> None:
    """Write the momentum-conserving gradient (Zheng et al. 2017, Eq. 25, with the missing m_j).

    grad p_i = sum_j V (p_i + p_j) grad_i W_ij, at equal densities.

    h : smoothing length of the cubic spline [m]; volume : V, of every particle [m^dim]
    """
    x, role, indptr, indices, dim = cloud.x, cloud.role, cloud.indptr, cloud.indices, len(cloud.axes)
    for i in range(len(indptr) - 1):
        out[i, :] = 0.0
        if role[i] != INNER and role[i] != SURFACE:
            continue
        for k in range(indptr[i], indptr[i + 1]):
            j = indices[k]
            if outside(role[j]):
                continue
            r2 = 0.0
            for a in range(dim):
                r2 += (x[i, a] - x[j, a]) ** 2
            slope = volume * cubic_spline_slope(math.sqrt(r2), h, dim) * (p[i] + p[j])
            for a in range(dim):
                out[i, a] += slope * (x[i, a] - x[j, a])


@kernel
def wall_velocity(u: np.ndarray, cloud: Cloud, wall_u: np.ndarray, shear: np.ndarray, radius: float) -> None:
    """Write the velocity of wall particles: normal part from the wall, tangential part from the fluid.

    The tangential part is the value at the wall of a linear fit through the fluid within the radius. ACROSS radius^2,
    added to the variance of the distances, damps the slope across the wall: an undamped fit through one or two layers
    amplifies their disorder. The known part of the slope, the shear of irrotational flow beside a rotating wall, is not
    damped. Corners move with the wall, in 3D all edges until `slip_along_edges`.

    u : (n_all, dim), rows of owned walls are written; wall_u : (n_owned, dim) [m/s]
    shear : (n_owned, dim) [1/s], change of the tangential part per distance from the wall; radius : of the weight [m]
    """
    dim = len(cloud.axes)
    work = np.empty((dim, dim)), np.empty((dim, dim)), np.empty(dim)
    for i in range(len(cloud.indptr) - 1):
        if cloud.kind[i] != WALL:
            continue
        for a in range(dim):
            u[i, a] = wall_u[i, a]
        if not (cloud.corner[i] or outside(cloud.role[i])):
            _extrapolate(u, i, cloud, wall_u, shear, work, radius * radius)


@kernel
def slip_along_edges(u: np.ndarray, cloud: Cloud, wall_u: np.ndarray, radius: float) -> None:
    """Add to the velocity of wall particles on edges that of the fluid along the edge (3D).

    It is the weighted mean of the fluid within the radius, relative to the wall, without its parts across the two walls
    that meet. What is left of it at the edges of 2D, and in corners where three walls meet, is nothing.

    u : (n_all, dim) [m/s] of `wall_velocity`, rows of owned walls change; others as there
    """
    along, axes = np.empty(len(cloud.axes)), cloud.axes
    for i in range(len(cloud.indptr) - 1):
        if cloud.kind[i] != WALL or not cloud.corner[i] or outside(cloud.role[i]):
            continue
        if not edge_direction(along, i, cloud):
            continue
        total, slip = 0.0, 0.0
        for k in range(cloud.indptr[i], cloud.indptr[i + 1]):
            j = cloud.indices[k]
            if cloud.kind[j] != WALL:
                w, _ = pair_weight(i, j, cloud.x, radius * radius, 0, axes)
                total += w
                for a in range(len(axes)):
                    slip += w * (u[j, a] - wall_u[i, a]) * along[a]
        if total > 0.0:
            for a in range(len(axes)):
                u[i, a] += slip / total * along[a]


@kernel
def mean_beside_walls(f: np.ndarray, cloud: Cloud, radius: float) -> None:
    """Write the weighted mean of the fluid within the radius at owned wall particles, 0 without fluid.

    f : (n_all,); radius : of the weight [m]
    """
    kind, indptr, indices = cloud.kind, cloud.indptr, cloud.indices
    for i in range(len(indptr) - 1):
        if kind[i] != WALL:
            continue
        total, weight = 0.0, 0.0
        for k in range(indptr[i], indptr[i + 1]):
            j = indices[k]
            if kind[j] != WALL:
                w, _ = pair_weight(i, j, cloud.x, radius * radius, 0, cloud.axes)
                total += w * f[j]
                weight += w
        f[i] = total / weight if weight > 0.0 else 0.0


@subkernel
def _extrapolate(u, i, cloud, wall_u, shear, work, radius2):
    """Fit u linearly, and set the tangential value at the wall. work : (dim, dim), (dim, dim) and (dim,) scratch"""
    x, kind, normal, indptr, indices, axes = cloud.x, cloud.kind, cloud.normal, cloud.indptr, cloud.indices, cloud.axes
    (m, inverse, mean), dim = work, len(axes)
    total = 0.0
    mean[:] = 0.0
    m[:, :] = 0.0
    for k in range(indptr[i], indptr[i + 1]):
        j = indices[k]
        if kind[j] == WALL:
            continue
        w, _ = pair_weight(i, j, x, radius2, 0, axes)
        total += w
        for a in range(dim):
            mean[a] += w * (x[j, a] - x[i, a])
            for c in range(dim):
                m[a, c] += w * (x[j, a] - x[i, a]) * (x[j, c] - x[i, c])
    if total == 0.0:
        return
    for a in range(dim):
        mean[a] /= total
    for a in range(dim):
        for c in range(dim):
            m[a, c] = m[a, c] / total - mean[a] * mean[c] + (ACROSS - ALONG) * radius2 * normal[i, a] * normal[i, c]
        m[a, a] += ALONG * radius2
    invert(m, inverse, axes)
    for k in range(indptr[i], indptr[i + 1]):
        j = indices[k]
        if kind[j] == WALL:
            continue
        w, _ = pair_weight(i, j, x, radius2, 0, axes)
        y, share = _height(i, j, x, normal, axes), 1.0
        for a in range(dim):
            for c in range(dim):
                share -= mean[a] * inverse[a, c] * (x[j, c] - x[i, c] - mean[c])
        share *= w / total
        slip = 0.0
        for a in range(dim):
            slip += (u[j, a] - wall_u[i, a]) * normal[i, a]
        for a in range(dim):
            u[i, a] += share * (u[j, a] - wall_u[i, a] - slip * normal[i, a] - y * shear[i, a])


@subkernel
def _height(i, j, x, normal, axes):
    y = 0.0
    for a in range(len(axes)):
        y += (x[j, a] - x[i, a]) * normal[i, a]
    return y
