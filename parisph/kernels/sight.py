"""Lines of sight past walls, and the lists of elements near particles.

Every owned particle has a list of the elements near it (`seen_elements`), mostly an empty one. Many elements lie in one
plane: a line crosses none of these if both ends are on one side of it.
"""

import numpy as np

from parisph.base.fields import WALL
from parisph.kernels.cells import nearby
from parisph.kernels.elements import crosses, is_within, nearest_point
from parisph.kernels.jit import inlined, kernel, subkernel
from parisph.kernels.records import Cloud, Shapes, Walls

LIFT = 0.1       # tuned 0.05 to 0.2: spacings in front of its wall from which a node sees; judged
PLANES = 16      # largest number of planes near a particle that are told apart
ROUNDING = 1e-6  # uncertainty of the distance to a plane, over the lift
INSET = 1e-3     # in 3D, part of the way from an element's nearest point to its centroid at which it is looked at

Lists = tuple[np.ndarray, np.ndarray]    # CSR: indptr (n + 1,) int32, indices (nnz,) int32


def near_lists(x: np.ndarray, shapes: Shapes, radius: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the elements within the radius [m] of points x (n, dim) [m], and perhaps others, as CSR.

    Returns indptr (n + 1,) int32, indices (nnz,) int32. Raises ValueError as `cells.nearby`.
    """
    if len(shapes.size) == 0:
        return np.zeros(len(x) + 1, np.int32), np.zeros(0, np.int32)
    return nearby(x, shapes.middle, radius + shapes.size.max())


@kernel
def replaced(indptr: np.ndarray, indices: np.ndarray, which: np.ndarray, starts: np.ndarray, found: np.ndarray
             ) -> tuple[np.ndarray, np.ndarray]:
    """Return the CSR lists with those of some particles replaced, as CSR.

    which : (m,), these particles, ascending; starts (m + 1,), found : their lists, CSR
    """
    ends, m, n = np.empty_like(indptr), 0, len(indices) + len(found)
    left, count = np.empty(n, indices.dtype), 0
    ends[0] = 0
    for i in range(len(indptr) - 1):
        if m < len(which) and which[m] == i:
            for k in range(starts[m], starts[m + 1]):
                left[count] = found[k]
                count += 1
            m += 1
        else:
            for k in range(indptr[i], indptr[i + 1]):
                left[count] = indices[k]
                count += 1
        ends[i + 1] = count
    return ends, left[:count]


def no_lists(n: int) -> Lists:
    """Return n empty lists."""
    return np.zeros(n + 1, np.int32), np.zeros(0, np.int32)


def seen_elements(cloud: Cloud, walls: Walls, radius: float, nothing_hidden: bool, known: Lists | None = None
                  ) -> Walls:
    """Return the walls with lists of the elements within the radius [m] that are not hidden by others.

    walls : with the lists of `near_lists`
    nothing_hidden : as in a tank, of `is_open`
    known : lists by an earlier call, if no wall has moved since; those of wall particles are taken from them
    """
    indptr = np.empty_like(walls.indptr)
    indices = np.empty(len(walls.indices) + (0 if known is None else len(known[1])), np.int32)
    count = keep_unhidden(indptr, indices, cloud, walls, radius, nothing_hidden,
                          (np.empty(0, np.int32), indices) if known is None else known)
    return walls._replace(indptr=indptr, indices=indices[:count])


def seen_neighbours(cloud: Cloud, walls: Walls) -> tuple[np.ndarray, np.ndarray]:
    """Return the lists of neighbours without those behind a wall, as CSR.

    walls : with lists of `seen_elements` that reach as far as the neighbour lists do
    """
    indptr, indices = np.empty_like(cloud.indptr), np.empty_like(cloud.indices)
    return indptr, indices[:keep_visible(indptr, indices, cloud, walls)]


@kernel
def keep_visible(indptr: np.ndarray, indices: np.ndarray, cloud: Cloud, walls: Walls) -> int:
    """Write the visible neighbours, those whose connecting line crosses no element; return their number.

    Ends at nodes are lifted off the wall along the normal. A line through a solid passes its front once, in one of the
    two directions, so that both particles of a pair agree.

    indptr, indices : outputs, as long as the lists of the cloud
    """
    axes, lift = cloud.axes, LIFT * cloud.spacing
    p, q, sight = np.empty(len(axes)), np.empty(len(axes)), _sight(walls.indptr)
    n = indptr[0] = 0
    for i in range(len(indptr) - 1):
        if walls.indptr[i] == walls.indptr[i + 1]:
            for k in range(cloud.indptr[i], cloud.indptr[i + 1]):
                indices[n] = cloud.indices[k]
                n += 1
        else:
            _lifted(p, i, cloud, lift)
            planes = _find_planes(sight, p, i, walls, axes)
            for k in range(cloud.indptr[i], cloud.indptr[i + 1]):
                j = cloud.indices[k]
                _lifted(q, j, cloud, lift)
                indices[n] = j
                n += _is_free(p, q, sight, planes, (i, -1, axes), walls, lift)
        indptr[i + 1] = n
    return n


@kernel
def keep_unhidden(indptr: np.ndarray, indices: np.ndarray, cloud: Cloud, walls: Walls, radius: float,
                  nothing_hidden: bool, known: Lists) -> int:
    """Write the visible elements within the radius [m] of owned particles; return their number.

    The centroid or the nearest point, lifted off, must be visible: a moving wall hides the part of an element that it
    covers. In 3D the nearest point is moved a little inside: it may be on the edge of a body, where a line to it would
    end in another element, and rounding would decide. Elements in front of which the particle is not are kept, so that
    fluid cannot pass them.

    indptr, indices : outputs, with room for the lists of walls and the known ones
    known : lists of wall particles, without rows if they are not known
    """
    axes, lift, shapes = cloud.axes, LIFT * cloud.spacing, walls.shapes
    p, q, foot, sight = np.empty(len(axes)), np.empty(len(axes)), np.empty(len(axes)), _sight(walls.indptr)
    left, inset = 0, INSET if len(axes) == 3 else 0.0
    indptr[0] = 0
    for i in range(len(indptr) - 1):
        if cloud.kind[i] == WALL and len(known[0]) > 0:
            for k in range(known[0][i], known[0][i + 1]):
                indices[left] = known[1][k]
                left += 1
        elif walls.indptr[i] < walls.indptr[i + 1]:
            _lifted(p, i, cloud, lift)
            planes = 0 if nothing_hidden else _find_planes(sight, p, i, walls, axes)
            for k in range(walls.indptr[i], walls.indptr[i + 1]):
                e = walls.indices[k]
                free = is_within(p, e, foot, radius, walls, axes)
                if free and not nothing_hidden:
                    _lifted_middle(q, e, shapes, lift, axes)
                    free = _is_free(p, q, sight, planes, (i, k, axes), walls, lift)
                    if not free:
                        nearest_point(foot, p, e, walls.corners, axes)
                        for a in range(len(axes)):
                            q[a] = foot[a] + inset * (shapes.middle[e, a] - foot[a]) + lift * shapes.plane[e, a]
                        free = (_above(p, e, shapes, axes) <= 0.0
                                or _is_free(p, q, sight, planes, (i, k, axes), walls, lift))
                indices[left] = e
                left += free
        indptr[i + 1] = left
    return left


@kernel
def is_open(cloud: Cloud, walls: Walls) -> bool:
    """Return whether all particles and elements are in front of the planes of all elements, so that none hides another.

    It is so for water in a tank, and the places of nodes and elements are lifted off their walls.
    """
    axes, lift, shapes, found = cloud.axes, LIFT * cloud.spacing, walls.shapes, 0
    q, element = np.empty(len(axes)), np.empty(PLANES, np.int64)
    for e in range(len(shapes.number)):
        known = False
        for m in range(found):
            known = known or shapes.number[element[m]] == shapes.number[e]
        if not known:
            if found == PLANES:
                return False
            element[found] = e
            found += 1
    for e in range(len(shapes.number)):
        _lifted_middle(q, e, shapes, lift, axes)
        if not _before(q, element, found, shapes, lift, axes):
            return False
    for i in range(len(cloud.kind)):
        _lifted(q, i, cloud, lift)
        if not _before(q, element, found, shapes, lift, axes):
            return False
    return True


@subkernel
def _sight(indptr):
    """Return the scratch of `_find_planes`.

    For each plane near a particle: an element, the height of the particle, and whether a line crosses it; then the
    place among these of the plane of each entry in the particle's list.
    """
    longest = 0
    for i in range(len(indptr) - 1):
        longest = max(longest, indptr[i + 1] - indptr[i])
    return np.empty(longest, np.int64), np.empty(longest), np.empty(longest, np.bool_), np.empty(longest, np.int64)


@inlined
def _find_planes(sight, p, i, walls, axes):
    """Write the planes of the elements listed for particle i, and the height of p; return their number.

    After PLANES different ones, each further element counts as another plane.
    """
    (element, height, _, member), shapes, found, first = sight, walls.shapes, 0, walls.indptr[i]
    for k in range(first, walls.indptr[i + 1]):
        e, place = walls.indices[k], found
        for m in range(min(found, PLANES)):
            if shapes.number[element[m]] == shapes.number[e]:
                place = m
        member[k - first] = place
        if place == found:
            element[found], height[found] = e, _above(p, e, shapes, axes)
            found += 1
    return found


@inlined
def _above(p, e, shapes, axes):
    """Return the height of a point above the plane of an element [m]."""
    height = -shapes.plane[e, len(axes)]
    for a in range(len(axes)):
        height += shapes.plane[e, a] * p[a]
    return height


@inlined
def _is_free(p, q, sight, planes, which, walls, lift):
    """Return whether the line from p to q crosses none of the elements listed for a particle, except one entry.

    It crosses none if no plane is between p and q. which : the particle, the entry, and the axes
    """
    (element, height, crossed, member), (i, own, axes), shapes = sight, which, walls.shapes
    margin, between, first = ROUNDING * lift, False, walls.indptr[i]
    for m in range(planes):
        other = _above(q, element[m], shapes, axes)
        crossed[m] = min(height[m], other) <= margin and max(height[m], other) >= -margin
        between = between or crossed[m]
    if between:
        for k in range(first, walls.indptr[i + 1]):
            if crossed[member[k - first]] and k != own and crosses(p, q, walls.indices[k], walls.corners, axes):
                return False
    return True


@inlined
def _before(p, element, planes, shapes, lift, axes):
    """Return whether a point is in front of all planes by more than rounding."""
    before = True
    for m in range(planes):
        before = before and _above(p, element[m], shapes, axes) > ROUNDING * lift
    return before


@inlined
def _lifted(p, i, cloud, lift):
    for a in range(len(cloud.axes)):
        p[a] = cloud.x[i, a] + lift * cloud.normal[i, a]


@inlined
def _lifted_middle(q, e, shapes, lift, axes):
    """Write the place that is the lift [m] in front of the centroid of element e."""
    for a in range(len(axes)):
        q[a] = shapes.middle[e, a] + lift * shapes.plane[e, a]
