"""The load of the pressure on the triangles of a body (3D)."""

from typing import NamedTuple

import numpy as np

from parisph.base.arrays import Floats, Ints
from parisph.geometry.distance import area_vectors, unit_normals
from parisph.geometry.mesh import WallMesh

# [lengths of an edge] of the nodes from which the pressure at an edge is extrapolated; with 2.6, slopes were lost on
# faces three spacings wide, where a hydrostatic pressure gave a sideways force of 2 % of the buoyancy
RADIUS = 3.3
ALIKE = 0.9     # least cosine between the normals of the faces of two such nodes
LEVEL = 0.02    # least share of the smaller eigenvalue of the moments of such nodes: below it, they lie on a line
TIE = 1e-6      # of the radius: distances that differ by less are equal
FINE = 1e3      # steps of a unit normal: elements whose normals round to the same belong to one face at a node


class _Faces(NamedTuple):
    """Nodes with the faces that meet there: a node of an edge counts once for each of both sides.

    node (n,) of the mesh; of (M, 3) the number of each corner of each element; and for the pairs of one and another
    near it on the same face: one, other (k,), offset (k, 2) along the face over the radius, weight (k,)
    """

    node: Ints
    of: Ints
    one: Ints
    other: Ints
    offset: Floats
    weight: Floats


class SurfaceLoad:
    """Force of the pressure on elements of a body, -sum p n A, and its moment about a point (3D). Not collective.

    The pressure is linear on each element, and the integrals are exact. Dry nodes have p = 0. At a node without
    pressure, that of the element's side of the edge is extrapolated: linearly by least squares from wet nodes of this
    side, along the line on which they lie if there is only one; as 0 if the nearest nodes of this side are dry. On the
    rim of an open surface it is at least 0.

    The distances of nodes of a body do not change.

    mesh : WallMesh, elements : (M, 3) its elements, by nodes
    """

    def __init__(self, mesh: WallMesh, elements: Ints) -> None:
        self.elements = elements
        self._faces = _faces(mesh.x0, elements)
        self._rim = mesh.ends[self._faces.node]

    def of(self, x: Floats, p: Floats, about: Floats) -> tuple[float, ...]:
        """Return force (3) [N] and moment (3) [N m] about a point (3,) [m] from the pressures of all nodes of the mesh.

        x : (N, 3) [m], p : (N,) [Pa] as of `rigid_bodies.node_pressures`
        """
        corners, pressure = x[self.elements], self._pressures(p)
        area = area_vectors(corners)
        force = (-pressure.mean(axis=1)[:, None] * area).sum(axis=0)
        # the integral of (x - about) p over an element: each product of corners i, j has the weight (1 + [i = j])/12
        own = pressure + pressure.sum(axis=1)[:, None]
        arm = np.einsum("ek,eka->ea", own, corners - about) / 12.0
        moment = -np.cross(arm, area).sum(axis=0)
        return (*force.tolist(), *moment.tolist())

    def _pressures(self, p: Floats) -> Floats:
        """Return the pressures at the corners of each element (M, 3)."""
        faces, there = self._faces, p[self._faces.node]
        missing, wet = np.isnan(there), np.isfinite(there)
        found = np.where(wet, there, 0.0)
        if missing.any():
            number = np.full(len(there), -1)
            number[missing] = np.arange(np.count_nonzero(missing))
            pair = np.flatnonzero(missing[faces.one])
            values = _extrapolated(number[faces.one[pair]], faces.offset[pair], faces.weight[pair],
                                   there[faces.other[pair]], int(missing.sum()))
            found[missing] = np.where(self._rim[missing], np.maximum(values, 0.0), values)
        at_corners: Floats = found[faces.of]
        return at_corners


def _faces(x: Floats, elements: Ints) -> _Faces:
    """Return the faces at the nodes of elements (M, 3) of a mesh with nodes x (N, 3) [m]."""
    from scipy.spatial import cKDTree  # as geometry.triangles, only with walls in 3D

    normal = unit_normals(x[elements])
    keys = np.column_stack([elements.ravel(), np.repeat(np.rint(FINE * normal).astype(np.int64), 3, axis=0)])
    first, of = np.unique(keys, axis=0, return_index=True, return_inverse=True)[1:]
    node, facing = elements.ravel()[first], normal[first // 3]
    radius = RADIUS * float(np.sqrt(2.0 * np.median(np.linalg.norm(area_vectors(x[elements]), axis=1))))
    pairs = cKDTree(x[node]).query_pairs(radius, output_type="ndarray")
    one, other = np.concatenate([pairs, pairs[:, ::-1]]).T
    alike = (node[one] != node[other]) & (np.sum(facing[one] * facing[other], axis=1) > ALIKE)
    one, other = one[alike], other[alike]
    axes = np.stack([_along(facing), np.cross(facing, _along(facing))], axis=1)
    offset = np.einsum("kia,ka->ki", axes[one], x[node[other]] - x[node[one]]) / radius
    weight = np.clip(1.0 - (offset**2).sum(axis=1), 0.0, None) ** 2
    return _Faces(node, of.reshape(elements.shape), one, other, offset, weight)


def _along(normal: Floats) -> Floats:
    """Return a unit vector (n, 3) across each unit vector (n, 3)."""
    found: Floats = np.cross(normal, np.eye(3)[np.argmin(np.abs(normal), axis=1)])
    found /= np.linalg.norm(found, axis=1)[:, None]
    return found


def _extrapolated(own: Ints, offset: Floats, weight: Floats, p: Floats, many: int) -> Floats:
    """Return the values (many,) at places, from values p (k,) at nodes at an offset (k, 2) from the place own (k,)."""
    away, nearest = np.hypot(offset[:, 0], offset[:, 1]), np.full(many, np.inf)
    usable = ~np.isnan(p)
    np.minimum.at(nearest, own[usable], away[usable])
    # the nearest nodes that have a pressure or are dry: where one is wet, the wall is wet
    beside = usable & (away <= nearest[own] + TIE)
    wet_beside = np.bincount(own[beside & np.isfinite(p)], minlength=many) > 0
    use = np.isfinite(p) & (weight > 0.0) & wet_beside[own]
    own, offset, weight, p = own[use], offset[use], weight[use], p[use]
    total = np.maximum(np.bincount(own, weight, many), np.finfo(float).tiny)

    def mean(values: Floats) -> Floats:
        found: Floats = np.bincount(own, weight * values, many) / total
        return found

    level, centre = mean(p), np.stack([mean(offset[:, 0]), mean(offset[:, 1])], axis=1)
    off: Floats = offset - centre[own]
    rise: Floats = p - level[own]
    moments = np.stack([[mean(off[:, a] * off[:, b]) for b in (0, 1)] for a in (0, 1)]).transpose(2, 0, 1)
    right = np.stack([mean(off[:, 0] * rise), mean(off[:, 1] * rise)], axis=1)
    slope = np.linalg.pinv(moments, rcond=LEVEL, hermitian=True) @ right[:, :, None]
    found: Floats = level - np.sum(slope[:, :, 0] * centre, axis=1)
    return found
