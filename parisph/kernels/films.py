"""Films: fluid one particle deep on a wall, whose depth the pressure equation does not couple to the velocity."""

import numpy as np

from parisph.base.fields import BALLISTIC, FLUID, SURFACE, WALL
from parisph.kernels.halves import LAYER
from parisph.kernels.jit import inlined, kernel
from parisph.kernels.moments import invert
from parisph.kernels.near import height, room_for
from parisph.kernels.records import Cloud
from parisph.kernels.smoothing import quartic_weight

# f is the force into the wall. With .5, P2 of dam breaks scatters more.
CALM = 0.1    # tuned 0.05 to 0.2: speed along the wall over sqrt(f s) above which films stay unchanged; judged
FLAT = 0.5    # tuned 0.25 to 1: part of the trace across the wall above which neighbours are not a layer; judged


@kernel
def settle(change: np.ndarray, cloud: Cloud, u: np.ndarray, force: np.ndarray, radius: float, floor: float,
           dt: float) -> None:
    """Write the velocity change that makes the depth h of a film obey continuity, dh/dt = -h div u along the wall.

    All particles of a film are surface particles, so no equation knows how much fluid lies between them. On an inclined
    wall, still water would start to move at the rate sqrt(g k sin(a)/2), with the wave number k and the slope angle a:
    a particle that moves up would raise the surface, but two that approach each other would not. The normal velocity
    therefore becomes that of the whole film, limited to what the force that holds the film on the wall can change in a
    step. Films that flow, and fluid that is not a single layer, stay unchanged.

    change : (n_owned, dim) output [m/s]
    u : (n_all, dim) [m/s], of walls only the normal part counts; force : (n_all, dim) per unit mass [m/s^2]
    radius : of the least squares [m]; dt : of the step [s]
    floor : value of det/(trace/dim)^dim of the neighbours' moment above which they are not one layer
    """
    normal, dim, room = cloud.normal, len(cloud.axes), room_for(cloud.indptr)
    member, m, inverse = np.empty(room, np.int64), np.empty((dim, dim)), np.empty((dim, dim))
    for i in range(len(cloud.indptr) - 1):
        change[i, :] = 0.0
        if cloud.kind[i] != FLUID or cloud.role[i] != SURFACE:
            continue
        wall = _wall_below(i, cloud, force)
        if wall < 0:
            continue
        n = _layer(member, i, cloud, radius)
        layered = 1.0 - _moment(m, inverse, member, n, i, wall, cloud, radius) / floor
        if layered <= 0.0:
            continue
        across, approach, held, square = 0.0, 0.0, 0.0, 0.0
        for a in range(dim):
            across += u[i, a] * normal[wall, a]
            approach += u[wall, a] * normal[wall, a]
            held -= force[i, a] * normal[wall, a]
            square += u[i, a] ** 2
        spread = _divergence(inverse, member, n, i, wall, u, cloud, radius)
        missing = approach - height(i, wall, cloud.x, normal, cloud.axes) * spread - across
        most = held * dt
        calm = 1.0 - (square - across * across) / (CALM * CALM * held * cloud.spacing)
        if calm <= 0.0:
            continue
        missing = min(calm, 1.0) * layered * min(max(missing, -most), most)
        for a in range(dim):
            change[i, a] = missing * normal[wall, a]


@inlined
def _wall_below(i, cloud, force):
    """Return the nearest wall particle onto which the force presses particle i, -1 if i is not in the first layer."""
    x, normal, axes = cloud.x, cloud.normal, cloud.axes
    nearest, found = np.inf, -1
    for k in range(cloud.indptr[i], cloud.indptr[i + 1]):
        j = cloud.indices[k]
        if cloud.kind[j] != WALL or cloud.corner[j]:
            continue
        held, r2 = 0.0, 0.0
        for a in range(len(axes)):
            held -= force[i, a] * normal[j, a]
            r2 += (x[j, a] - x[i, a]) ** 2
        if held > 0.0 and r2 < nearest and 0.0 < height(i, j, x, normal, axes) < LAYER * cloud.spacing:
            nearest, found = r2, j
    return found


@inlined
def _layer(member, i, cloud, radius):
    """Write the fluid neighbours within the radius that are not in free flight; return their number."""
    n = 0
    for k in range(cloud.indptr[i], cloud.indptr[i + 1]):
        j = cloud.indices[k]
        r2 = 0.0
        for a in range(len(cloud.axes)):
            r2 += (cloud.x[j, a] - cloud.x[i, a]) ** 2
        member[n] = j
        n += (cloud.kind[j] == FLUID) & (cloud.role[j] != BALLISTIC) & (r2 < radius * radius)
    return n


@inlined
def _moment(m, inverse, member, n, i, wall, cloud, radius):
    """Write the inverse of the neighbours' moment along the wall; return det/(trace/dim)^dim of the whole moment.

    It is 1 if the fluid is not a layer: without neighbours, or with all of them above particle i.
    """
    x, normal, axes, dim, trace = cloud.x, cloud.normal, cloud.axes, len(cloud.axes), 0.0
    m[:, :] = 0.0
    for k in range(n):
        j, r2 = member[k], 0.0
        for a in range(dim):
            r2 += (x[j, a] - x[i, a]) ** 2
        weight = quartic_weight(r2, radius * radius)
        for a in range(dim):
            for b in range(dim):
                m[a, b] += weight * (x[j, a] - x[i, a]) * (x[j, b] - x[i, b])
    across = 0.0
    for a in range(dim):
        trace += m[a, a]
        for b in range(dim):
            across += normal[wall, a] * m[a, b] * normal[wall, b]
    if not across < FLAT * trace:
        return 1.0
    quality = invert(m, inverse, axes)
    for a in range(dim):
        for b in range(dim):
            m[a, b] += trace * normal[wall, a] * normal[wall, b]
    return quality if invert(m, inverse, axes) > 0.0 else 1.0


@inlined
def _divergence(inverse, member, n, i, wall, u, cloud, radius):
    """Return the divergence [1/s] of the velocity along the wall, by linear least squares."""
    x, normal, dim, found = cloud.x, cloud.normal, len(cloud.axes), 0.0
    for k in range(n):
        j, r2, across = member[k], 0.0, 0.0
        for a in range(dim):
            r2 += (x[j, a] - x[i, a]) ** 2
            across += (u[j, a] - u[i, a]) * normal[wall, a]
        weight = quartic_weight(r2, radius * radius)
        for a in range(dim):
            along = u[j, a] - u[i, a] - across * normal[wall, a]
            for b in range(dim):
                found += weight * along * inverse[a, b] * (x[j, b] - x[i, b])
    return found
