"""Wall particles that touch the fluid, in any dimension."""

import math

import numpy as np

from parisph.base.fields import ABSENT, CONTACT, DRY, FLUID, INNER, SURFACE, WALL, WET
from parisph.kernels.edges import edge_direction
from parisph.kernels.elements import element_normal, nearest_point
from parisph.kernels.halves import LAYER, deeper
from parisph.kernels.jit import kernel, subkernel
from parisph.kernels.records import Cloud, Walls

# Lengths in spacings.
TOUCH = 0.55    # tuned 0.275 to 1: fluid that touches a wall; the guard stops it at half a spacing; judged
BESIDE = 0.75   # tuned 0.5 to 1.5: along the wall, from a wall particle to fluid in front of it; judged
# Fluid within LAYER in front of a wall particle covers it.
FAR = 2.5       # tuned 1.6 to 5: fluid in front of a wall particle that no longer covers it; judged
FELT = 0.75     # tuned 0.5 to 1.5: fluid that feels the friction of a wall particle, wet or not; judged
NEARBY = 1.6    # tuned 0.8 to 3.2: inner fluid behind an advancing water line; judged
NEXT = 1.5      # tuned 1 to 3: from a wall particle to the next on its wall, or beyond a corner; judged
INSIDE = 2.1    # tuned 1.05 to 4.2: from a wet wall particle to inner fluid; judged
STANDS = 0.55   # tuned 0.275 to 1: along the wall, from the contact line to a surface particle; judged
BOTH = 0.3      # tuned 0.15 to 0.6: along the wall, to fluid that covers one of its sides; judged
# Without a unit:
ALIKE = 0.5     # tuned 0.25 to 1: cosine of normals above which wall particles belong to one wall; judged
FACES = 0.5     # tuned 0.25 to 1: component of a normal along a wall above which another wall ends it; judged
ACROSS = 0.25   # tuned 0.125 to 0.5: sine^2 of the angle of an axis to the normal, for a tangent along it; judged

# Values of the field `closing`, the relation of a wall particle to the fluid in front of it.
APART, FREE, CLOSING = 0, 1, 2


@kernel
def without_walls(kind: np.ndarray, closing: np.ndarray, least: int) -> np.ndarray:
    """Return kind (n,), with ABSENT for walls whose `closing` (n,) is less than `least`."""
    seen = kind.copy()
    for i in range(len(kind)):
        if kind[i] == WALL and closing[i] < least:
            seen[i] = ABSENT
    return seen


@kernel
def known_slopes(cloud: Cloud, closing: np.ndarray, force: np.ndarray) -> np.ndarray:
    """Return which particles (n_all,) are walls with one normal, except APART ones that the force points away from.

    force : (n_all, dim) [m/s^2], without rows before any step; closing : without rows where no wall is apart
    """
    known = np.zeros(len(cloud.kind), np.bool_)
    for i in range(len(known)):
        if cloud.kind[i] != WALL or cloud.corner[i]:
            continue
        off = 0.0
        if len(force) > 0 and len(closing) > 0 and closing[i] == APART:
            for a in range(cloud.normal.shape[1]):
                off += cloud.normal[i, a] * force[i, a]
        known[i] = not off > 0.0
    return known


@kernel
def closing_walls(closing: np.ndarray, cloud: Cloud, u: np.ndarray, force: np.ndarray, dt: float) -> None:
    """Classify owned wall particles: CLOSING the fluid off, APART from it, or FREE.

    Positions alone do not distinguish water at rest one spacing below a lid from water that fills the tank, because
    wall particles replace its neighbours. The history does. A wall particle closes the fluid off if it was wet, if the
    water line reaches it (next to a wet one, with inner fluid within NEARBY, on edges of 3D `deeper`), or if fluid hits
    it: closer than TOUCH at the end of the step, and then moving towards it.

    A wall particle is apart if fluid is in front of it and on both sides but does not touch it or the wall beside it,
    as below a lid: it must not repel this fluid. All others are free. Those of a side wall above the water line act on
    the water as those below do, so that water at rest has no gradient of concentration there.

    closing : (n_all,) output; roles are those of the previous step; u : (n_all, dim) [m/s]
    force : (n_all, dim), body force per unit mass [m/s^2]; dt : step [s]
    """
    x, kind, role, normal, spacing = cloud.x, cloud.kind, cloud.role, cloud.normal, cloud.spacing
    indptr, indices, dim = cloud.indptr, cloud.indices, len(cloud.axes)
    for i in range(len(indptr) - 1):
        if kind[i] != WALL:
            closing[i] = APART
            continue
        beside_wet, beside_inner, opposite, near, hit = False, False, False, False, False
        nearby = NEARBY * spacing * (deeper(cloud.corner[i]) if dim == 3 else 1.0)
        for k in range(indptr[i], indptr[i + 1]):
            j = indices[k]
            r2, away, towards, pull, cosine = 0.0, 0.0, 0.0, 0.0, 0.0
            for a in range(dim):
                r2 += (x[j, a] - x[i, a]) ** 2
                away += (x[j, a] - x[i, a]) * normal[i, a]
                towards -= u[j, a] * normal[i, a]
                pull -= force[j, a] * normal[i, a]
                cosine += normal[j, a] * normal[i, a]
            if kind[j] == WALL:
                beside_wet |= role[j] == WET and cosine > ALIKE and r2 < (NEXT * spacing) ** 2
                continue
            beside_inner |= role[j] == INNER and r2 < nearby * nearby
            if away > 0.0 and r2 - away * away < (BESIDE * spacing) ** 2:
                opposite = True
                near |= away < TOUCH * spacing
                hit |= towards + pull * dt > 0.0 and away - (towards + max(pull, 0.0) * dt) * dt < TOUCH * spacing
        facing = opposite and not near and not beside_wet and _covered_on_both_sides(i, closing, APART, cloud)
        closing[i] = APART if facing else FREE
        if role[i] == WET or hit or (beside_wet and beside_inner):
            closing[i] = CLOSING


@kernel
def covered_walls(covered: np.ndarray, cloud: Cloud) -> None:
    """Write the part of each owned wall particle that fluid covers, 0 to 1; fluid gets 1.

    covered_i = min(1, sum_j (1 - t_ij/s) a_ij), with the distance t_ij < s along the wall. a_ij is 1 for fluid up to
    LAYER in front of it, and falls to 0 at FAR, in corners of 3D at `deeper` times that. The solid behind dry walls
    completes no kernel sums: above the water line there is no fluid to continue.
    """
    x, normal, spacing = cloud.x, cloud.normal, cloud.spacing
    for i in range(len(cloud.indptr) - 1):
        covered[i] = 1.0
        if cloud.kind[i] != WALL:
            continue
        total = 0.0
        for k in range(cloud.indptr[i], cloud.indptr[i + 1]):
            j = cloud.indices[k]
            if cloud.kind[j] != FLUID:
                continue
            away, r2 = 0.0, 0.0
            for a in range(len(cloud.axes)):
                away += (x[j, a] - x[i, a]) * normal[i, a]
                r2 += (x[j, a] - x[i, a]) ** 2
            along = math.sqrt(max(r2 - away * away, 0.0)) / spacing
            if len(cloud.axes) == 3:
                away /= deeper(cloud.corner[i])
            if 0.0 < away < FAR * spacing and along < 1.0:
                total += (1.0 - along) * min((FAR - away / spacing) / (FAR - LAYER), 1.0)
        covered[i] = min(total, 1.0)


@kernel
def counted(part: np.ndarray, cloud: Cloud, closing: np.ndarray, covered: np.ndarray, least: int) -> None:
    """Write the part of each particle that counts (n_all,): of walls below `least` 0, of other walls the covered part.

    closing : (n_all,), or without rows to count all walls fully; covered : (n_all,) of `covered_walls`
    """
    for i in range(len(part)):
        part[i] = 1.0
        if cloud.kind[i] == WALL and len(closing) > 0:
            part[i] = covered[i] if closing[i] >= least else 0.0


@kernel
def mean_of_nodes(mean: np.ndarray, nodes: np.ndarray, values: np.ndarray) -> None:
    """Write the means (M,) of values (n_all,) over the nodes (M, dim) of elements; -1 is a node of another rank."""
    for e in range(len(nodes)):
        total, here = 0.0, 0
        for c in range(nodes.shape[1]):
            if nodes[e, c] >= 0:
                total += values[nodes[e, c]]
                here += 1
        mean[e] = total / max(here, 1)


@kernel
def before_moving_walls(apart: np.ndarray, x: np.ndarray, own: np.ndarray, walls: Walls, motion: np.ndarray,
                        axes: tuple[int, ...]) -> None:
    """Write the distance [m] of wall particles from the walls that move against them, 0 behind these.

    A wall whose motion has a higher number passes over the nodes of others, as a piston over those of the bed.

    apart : (n_owned,), changed where such a wall is near; x : (n_owned, dim) [m]
    own : (n_owned,), motion : (M,), the numbers of the motions of particles and of elements
    """
    corners, dim = walls.corners, len(axes)
    place, foot, n = np.empty(dim), np.empty(dim), np.empty(dim)
    for i in range(len(walls.indptr) - 1):
        for k in range(walls.indptr[i], walls.indptr[i + 1]):
            e = walls.indices[k]
            if motion[e] <= own[i]:
                continue
            for a in range(dim):
                place[a] = x[i, a]
            nearest_point(foot, place, e, corners, axes)
            element_normal(n, e, corners, axes)
            r2, height = 0.0, 0.0
            for a in range(dim):
                r2 += (place[a] - foot[a]) ** 2
                height += (place[a] - foot[a]) * n[a]
            apart[i] = min(apart[i], math.sqrt(r2) if height > 0.0 else 0.0)


@kernel
def touched_walls(touched: np.ndarray, cloud: Cloud) -> None:
    """Mark the owned wall particles whose friction fluid can feel: 1, else 0; fluid gets 1.

    They are wet, have a wet neighbour on the same wall (which continues above the water line), or have fluid within
    FELT. Others, as of a lid above the water, are behind air.

    touched : (n_owned,) output; roles are those of the previous step
    """
    x, kind, role, normal, spacing = cloud.x, cloud.kind, cloud.role, cloud.normal, cloud.spacing
    for i in range(len(cloud.indptr) - 1):
        touched[i] = kind[i] != WALL or role[i] == WET
        if touched[i]:
            continue
        for k in range(cloud.indptr[i], cloud.indptr[i + 1]):
            j = cloud.indices[k]
            r2, cosine = 0.0, 0.0
            for a in range(len(cloud.axes)):
                r2 += (x[j, a] - x[i, a]) ** 2
                cosine += normal[j, a] * normal[i, a]
            touched[i] |= (role[j] == WET and cosine > ALIKE) or (kind[j] == FLUID and r2 < (FELT * spacing) ** 2)


@kernel
def wet_walls(cloud: Cloud, closing: np.ndarray) -> None:
    """Write which wall particles touch the fluid: WET, DRY, or CONTACT at the contact line.

    A wet one closes the fluid off (closing_walls), has an inner particle within INSIDE (on edges of 3D `deeper`), and
    has fluid, or beside a corner the other wall, on both sides along the wall. In the corner itself the inner particle
    is enough, and on an edge of 3D fluid or another wall on both sides along the edge. A contact particle is not wet,
    but has a surface particle beside it. Roles of fluid are read, those of owned walls written.

    closing : (n_all,) of `closing_walls`
    """
    x, kind, role, normal, spacing = cloud.x, cloud.kind, cloud.role, cloud.normal, cloud.spacing
    indptr, indices, dim = cloud.indptr, cloud.indices, len(cloud.axes)
    edge = np.empty(dim)
    for i in range(len(indptr) - 1):
        if kind[i] != WALL:
            continue
        inner, beside, inside = False, False, INSIDE * spacing * (deeper(cloud.corner[i]) if dim == 3 else 1.0)
        for k in range(indptr[i], indptr[i + 1]):
            j = indices[k]
            if kind[j] != FLUID:
                continue
            r2 = 0.0
            away = 0.0
            for a in range(dim):
                r2 += (x[j, a] - x[i, a]) ** 2
                away += (x[j, a] - x[i, a]) * normal[i, a]
            inner |= role[j] == INNER and r2 < inside * inside
            beside |= (role[j] == SURFACE and 0.0 < away < LAYER * spacing
                       and r2 - away * away < (STANDS * spacing) ** 2)
        wet = inner and closing[i] == CLOSING
        if wet and not cloud.corner[i]:
            wet = _covered_on_both_sides(i, closing, CLOSING, cloud)
        elif wet and dim == 3 and edge_direction(edge, i, cloud):
            wet = _covered_along(i, edge, closing, CLOSING, cloud)
        if wet:
            role[i] = WET
        else:
            role[i] = CONTACT if beside else DRY


@subkernel
def _covered_on_both_sides(i, closing, least, cloud):
    """Return whether fluid, or another wall with `closing` >= `least`, is beside wall particle i on both sides."""
    x, normal, spacing, dim = cloud.x, cloud.normal, cloud.spacing, len(cloud.axes)
    for b in range(dim):  # the tangent along axis b is e_b - n_b n
        if 1.0 - normal[i, b] ** 2 < ACROSS:
            continue
        ahead, behind = False, False
        for k in range(cloud.indptr[i], cloud.indptr[i + 1]):
            j = cloud.indices[k]
            along, away, cosine = x[j, b] - x[i, b], 0.0, 0.0
            for a in range(dim):
                away += (x[j, a] - x[i, a]) * normal[i, a]
                cosine += normal[j, a] * normal[i, a]
            along -= away * normal[i, b]
            # one spacing from a corner the other wall replaces the fluid
            facing = normal[j, b] - cosine * normal[i, b]
            covers = (cloud.kind[j] == FLUID
                      or (closing[j] >= least and along * facing < -FACES * abs(along) and abs(along) < NEXT * spacing))
            ahead |= covers and along > BOTH * spacing
            behind |= covers and along < -BOTH * spacing
        if not (ahead and behind):
            return False
    return True


@subkernel
def _covered_along(i, edge, closing, least, cloud):
    """Return the same for both sides along an edge, of the direction `edge` (3,)."""
    ahead, behind = False, False
    for k in range(cloud.indptr[i], cloud.indptr[i + 1]):
        j = cloud.indices[k]
        along, facing = 0.0, 0.0
        for a in range(3):
            along += (cloud.x[j, a] - cloud.x[i, a]) * edge[a]
            facing += cloud.normal[j, a] * edge[a]
        covers = (cloud.kind[j] == FLUID or (closing[j] >= least and along * facing < -FACES * abs(along)
                                             and abs(along) < NEXT * cloud.spacing))
        ahead |= covers and along > BOTH * cloud.spacing
        behind |= covers and along < -BOTH * cloud.spacing
    return ahead and behind
