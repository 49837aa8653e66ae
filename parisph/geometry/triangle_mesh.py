"""The WallMesh of triangles that any closed or open surface is made of (3D).

All follows from the angles between neighbouring triangles: which edges are creases, on which side of them the fluid is,
and the solid angle of the fluid at each node.
"""

from dataclasses import dataclass

import numpy as np

from parisph.base.arrays import Array, Flags, Floats, Ints
from parisph.geometry.distance import area_vectors, unit_normals
from parisph.geometry.mesh import CONCAVE, CONVEX, FLAT, MeshBody, WallMesh

# Degrees between two triangles that meet in a crease; less is a smooth surface in facets about a
# spacing long. A sphere of two spacings radius turns by 25 in one facet.
CREASE = 30.0


@dataclass(frozen=True)
class Edges:
    """The edges (E,) of triangles, each once, from the lower number of its nodes to the greater.

    nodes : (E, 2) int; beside : (E, 2) int, its triangles, of a rim -1 in place of the second
    """

    nodes: Ints
    beside: Ints

    @property
    def rim(self) -> Flags:
        """Which edges (E,) belong to one triangle only."""
        found: Flags = self.beside[:, 1] < 0
        return found


def edges_of(triangles: Array) -> Edges:
    """Return the Edges of triangles (M, 3) int of a surface that at most two triangles meet at. Raises ValueError."""
    one, other = triangles.ravel().astype(np.int64), np.roll(triangles, -1, axis=1).ravel().astype(np.int64)
    pair = np.stack([np.minimum(one, other), np.maximum(one, other)], axis=1)
    order = np.lexsort([pair[:, 1], pair[:, 0]])
    first = np.flatnonzero(np.append(True, np.any(np.diff(pair[order], axis=0) != 0, axis=1))[: len(order)])
    many = np.diff(np.append(first, len(order)))
    if np.any(many > 2):
        raise ValueError(f"{np.count_nonzero(many > 2)} edges belong to more than two triangles")
    beside = np.full((len(first), 2), -1)
    beside[:, 0] = order[first] // 3
    beside[many == 2, 1] = order[first[many == 2] + 1] // 3
    return Edges(pair[order[first]], beside)


def dihedral(corners: Floats, triangles: Array, edges: Edges) -> Floats:
    """Return the angle of the fluid (E,) [rad] between the two triangles at each edge, pi at a rim.

    corners : (M, 3, 3) [m], with the fluid on the side from which they are in anticlockwise order
    """
    angle, inner = np.full(len(edges.nodes), np.pi), ~edges.rim
    one, other = edges.beside[inner].T
    normal = area_vectors(corners)
    a, b = normal[one], normal[other]
    turn = np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), np.sum(a * b, axis=1))
    # the corner of the other triangle that is not on the edge: in front of the first one in a concave crease
    apart = triangles[other][:, :, None] != edges.nodes[inner][:, None, :]
    far = corners[other, np.argmax(apart.all(axis=2), axis=1)]
    front = np.sum((far - corners[one, 0]) * a, axis=1) > 0.0
    angle[inner] = np.pi - np.where(front, turn, -turn)
    return angle


def triangle_mesh(nodes: Floats, triangles: Array, body: Array, bodies: tuple[MeshBody, ...]) -> WallMesh:
    """Return the WallMesh of a surface of triangles.

    nodes : (N, 3) [m]; triangles : (M, 3) int, anticlockwise as the fluid sees them; body : (M,) int, of each

    At a rim, the wall continues as if mirrored. Nodes on any convex crease are CONVEX, even where it meets a wall.

    Raises ValueError where more than two triangles meet at an edge.
    """
    corners, edges = nodes[triangles], edges_of(triangles)
    vectors = area_vectors(corners)
    size = np.linalg.norm(vectors, axis=1)
    angle = dihedral(corners, triangles, edges)
    normal, planes = _normals(corners, triangles, edges, angle)
    half, area = np.zeros((len(nodes), 3)), np.zeros(len(nodes))
    for corner in triangles.T:
        np.add.at(half, corner, vectors / 3.0)
        np.add.at(area, corner, size / 3.0)
    return WallMesh(
        x0=nodes, normal0=normal, area=area, vector_area=half, share=_shares(len(nodes), triangles, edges, angle),
        cell=area * np.where(planes > 2, 4.0 / 3.0, 1.0), body=_bodies(len(nodes), triangles, body, size),
        edge=_edges(len(nodes), edges, angle), elements=triangles.astype(np.int32), element_body=body.astype(np.int32),
        bodies=bodies)


def creases(angle: Floats) -> tuple[Flags, Flags]:
    """Return which edges (E,) are concave and which are convex creases, by the angle of the fluid (E,) [rad]."""
    turn = np.radians(CREASE)
    return angle < np.pi - turn, angle > np.pi + turn


def _edges(count: int, edges: Edges, angle: Floats) -> Array:
    found = np.full(count, FLAT, dtype=np.int8)
    for which, value in zip(creases(angle), (CONCAVE, CONVEX)):
        found[edges.nodes[which]] = value    # convex last: it wins
    return found


def _shares(count: int, triangles: Array, edges: Edges, angle: Floats) -> Floats:
    """Return the solid angle of the fluid at each node, over 4 pi (N,).

    That of n triangles around a node is the sum of the angles between them less (n - 2) pi (the area of a spherical
    polygon, by Girard). At a rim, the triangles and their mirror image are around the node.
    """
    inner = ~edges.rim
    open_ended = np.zeros(count, dtype=bool)
    open_ended[edges.nodes[~inner]] = True
    number = np.bincount(triangles.ravel(), minlength=count)
    total = np.bincount(edges.nodes[inner].ravel(), weights=np.repeat(angle[inner], 2), minlength=count)
    twice = np.where(open_ended, 2, 1)
    solid = twice * total + np.where(open_ended, 2.0 * np.pi, 0.0) - (twice * number - 2) * np.pi
    found: Floats = np.clip(solid / (4.0 * np.pi), 0.0, 1.0)
    return found


def _normals(corners: Floats, triangles: Array, edges: Edges, angle: Floats) -> tuple[Floats, Ints]:
    """Return the normalised sums (N, 3) of the normals of the smooth parts of surface at each node, and their number.

    The normal of a part is the mean of those of its triangles, weighted by their angles at the node.
    """
    count, flat = int(triangles.max(initial=-1)) + 1, triangles.ravel().astype(np.int64)
    part = _parts(triangles, edges, ~np.any(creases(angle), axis=0))
    weighted = np.repeat(unit_normals(corners), 3, axis=0) * _corner_angles(corners).ravel()[:, None]
    number, place = np.unique(part, return_inverse=True)
    mean = np.stack([np.bincount(place, weights=column) for column in weighted.T], axis=1)
    mean = mean / np.linalg.norm(mean, axis=1)[:, None]
    node = np.empty(len(number), dtype=np.int64)
    node[place] = flat
    total = np.stack([np.bincount(node, weights=column, minlength=count) for column in mean.T], axis=1)
    length = np.linalg.norm(total, axis=1)
    # the parts of a thin edge may cancel; it then has the normal of one of them
    total[node] = np.where((length[node] < 1e-6)[:, None], mean, total[node])
    return total / np.maximum(np.linalg.norm(total, axis=1), 1e-300)[:, None], np.bincount(node, minlength=count)


def _parts(triangles: Array, edges: Edges, smooth: Flags) -> Ints:
    """Return the number of the smooth part of surface at its node to which each corner belongs, (3 M,) int.

    Corners of two triangles at the same node are in the same part if a smooth edge joins them. The least number spreads
    over the part, in as many rounds as the part has triangles around the node at most.
    """
    part = np.arange(triangles.size, dtype=np.int64)
    joined = np.flatnonzero(smooth & ~edges.rim)
    one, other = edges.beside[joined].T
    pairs = []
    for end in edges.nodes[joined].T:
        pairs.append([3 * side + np.argmax(triangles[side] == end[:, None], axis=1) for side in (one, other)])
    left, right = np.concatenate(pairs, axis=1) if len(joined) else (np.empty(0, np.int64), np.empty(0, np.int64))
    while True:
        before = part.copy()
        least = np.minimum(part[left], part[right])
        np.minimum.at(part, left, least)
        np.minimum.at(part, right, least)
        if np.array_equal(part, before):
            return part


def _corner_angles(corners: Floats) -> Floats:
    """Return the angles (M, 3) [rad] of triangles at their corners."""
    one, other = np.roll(corners, -1, axis=1) - corners, np.roll(corners, 1, axis=1) - corners
    found: Floats = np.arctan2(np.linalg.norm(np.cross(one, other), axis=2), np.sum(one * other, axis=2))
    return found


def _bodies(count: int, triangles: Array, body: Array, size: Floats) -> Array:
    """Return the body (N,) that has the largest part of the wall at each node."""
    numbers = np.unique(body)
    parts = np.stack([np.bincount(triangles[body == number].ravel(), weights=np.repeat(size[body == number], 3),
                                  minlength=count) for number in numbers], axis=1)
    largest = parts > (1.0 - 1e-9) * parts.max(axis=1, keepdims=True)
    found: Array = numbers[np.argmax(largest, axis=1)].astype(np.int32)
    return found
