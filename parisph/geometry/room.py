"""The room of the fluid between solids of any form, and the triangles of its boundary, about a spacing long (3D).

Solids are cut out of each other exactly (manifold3d), so that none overlaps and no gap is left where they meet. Then
the boundary of what is left is meshed anew (pymeshlab). Not collective; the same input gives the same triangles.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from parisph.base import libraries
from parisph.base.arrays import Array, Floats, Ints
from parisph.base.errors import CaseError
from parisph.geometry.distance import nearest
from parisph.geometry.surface_files import components, signed_volume
from parisph.geometry.triangle_mesh import CREASE, edges_of

# Spacings: length of the edges of equal triangles of which each node has the area s^2.
EDGE = (4.0 / 3.0) ** 0.25
OFF = 0.1        # spacings: largest distance of the new mesh from the surface
ROUNDS = 10      # of splitting, collapsing, swapping and smoothing edges; more change little
FINE = 1e-4      # spacings: smaller details are left out before
NEAR = 1.0       # spacings: within this distance of the middle of a new triangle is that whose body it has
LOST = 0.3       # spacings: points of the surface this far from its mesh are details that are lost
TIE = 1e-6       # spacings: of equally near bodies the first counts
SMALL = 1.0      # spacings^3: smaller rooms and solids apart from others are left out, such as slivers of a cut


@dataclass(frozen=True)
class Piece:
    """A closed solid, or what limits the room from outside.

    points : (N, 3) [m]; corners : (M, 3) int, with normals outward
    body : (M,) int, number of the body of each triangle, -1 where there is no wall, like on the top of an open tank
    limits : whether the room lies inside it, not outside
    """

    points: Floats
    corners: Array
    body: Array
    limits: bool = False


@dataclass(frozen=True)
class Room:
    """The walls around the fluid.

    nodes : (N, 3) [m]; triangles : (M, 3) int, anticlockwise as the fluid sees them; body : (M,) int32, of each
    volume : [m3], exact, before it was meshed
    lost : (n, 3) [m], points of the surface from which the mesh is far, so that details are lost there
    """

    nodes: Floats
    triangles: Array
    body: Array
    volume: float
    lost: Floats = field(default_factory=lambda: np.empty((0, 3)))

    @property
    def corners(self) -> Floats:
        """The corners (M, 3, 3) [m] of the triangles."""
        found: Floats = self.nodes[self.triangles]
        return found


def room_of(pieces: Sequence[Piece], spacing: float) -> Room:
    """Return the Room inside all pieces that limit it and outside all others, meshed to a spacing [m].

    Raises CaseError where nothing is left or the boundary cannot be meshed; MissingLibrary.
    """
    libraries.require(*libraries.SURFACES)
    points, corners = _left(pieces, spacing)
    nodes, triangles = _meshed(points, corners, spacing)
    triangles = triangles[:, ::-1]    # from now on with normals into the fluid
    body = _bodies(nodes[triangles], pieces, spacing)
    lost = ~np.isfinite(nearest(points, nodes[triangles], LOST * spacing)[0])
    walls = body >= 0
    used, own = np.unique(triangles[walls], return_inverse=True)
    return Room(nodes[used], own.reshape(-1, 3).astype(np.int32), body[walls].astype(np.int32),
                signed_volume(points[corners]), points[lost])


def prism(outline: Floats, ends: tuple[float, float]) -> tuple[Floats, Ints]:
    """Return the solid between two planes across as points (2 n, 3) [m] and triangles (m, 3), with normals outward.

    outline : (n, 2) [m] in the section, anticlockwise; ends : [m], least and greatest y
    """
    libraries.require(*libraries.SURFACES)
    import manifold3d

    n, number = len(outline), np.arange(len(outline))
    points = np.concatenate([np.insert(outline, 1, end, axis=1) for end in ends])
    front = np.array(manifold3d.triangulate([outline]), dtype=np.int64).reshape(-1, 3)
    after = np.roll(number, -1)
    sides = [np.stack([number, after + n, after], axis=1), np.stack([number, number + n, after + n], axis=1)]
    return points, np.concatenate([front, front[:, ::-1] + n, *sides])


def _left(pieces: Sequence[Piece], spacing: float) -> tuple[Floats, Ints]:
    """Return the surface of what the pieces leave: points (N, 3) [m] and triangles (M, 3), with normals outward."""
    import manifold3d

    around = [_manifold(piece) for piece in pieces if piece.limits]
    solids = [_manifold(piece) for piece in pieces if not piece.limits]
    left = manifold3d.Manifold.batch_boolean(around, manifold3d.OpType.Intersect)
    if solids:
        left = left - manifold3d.Manifold.batch_boolean(solids, manifold3d.OpType.Add)
    mesh = left.simplify(FINE * spacing).to_mesh64()
    points, corners = np.array(mesh.vert_properties)[:, :3], np.array(mesh.tri_verts, dtype=np.int64)
    # a solid that touches no other has a surface of its own, around a negative volume
    part = components(len(points), np.concatenate([corners[:, :2], corners[:, 1:]]))[corners[:, 0]]
    number, place = np.unique(part, return_inverse=True)
    sizes = np.array([signed_volume(points[corners[place == one]]) for one in range(len(number))])
    if not np.any(sizes > SMALL * spacing**3):
        raise CaseError("walls: no room is left for the fluid between them; make the solids smaller, move them, or "
                        "check the scale of their files")
    return points, corners[(np.abs(sizes) > SMALL * spacing**3)[place]]


def _manifold(piece: Piece) -> Any:
    import manifold3d

    made = manifold3d.Manifold(manifold3d.Mesh64(vert_properties=np.ascontiguousarray(piece.points, dtype=float),
                                                 tri_verts=np.ascontiguousarray(piece.corners, dtype=np.uint64)))
    if made.status() != manifold3d.Error.NoError:
        raise CaseError(f"walls: a surface is not that of a solid ({made.status().name})")
    return made


def _meshed(points: Floats, corners: Ints, spacing: float) -> tuple[Floats, Array]:
    """Return nodes and triangles of about equal size on the surface of triangles. Creases keep their places."""
    pymeshlab = libraries.loaded("pymeshlab")
    meshes = pymeshlab.MeshSet(verbose=False)
    meshes.add_mesh(pymeshlab.Mesh(vertex_matrix=points, face_matrix=corners.astype(np.int32)))
    meshes.meshing_isotropic_explicit_remeshing(
        iterations=ROUNDS, adaptive=False, targetlen=pymeshlab.PureValue(EDGE * spacing), featuredeg=CREASE,
        checksurfdist=True, maxsurfdist=pymeshlab.PureValue(OFF * spacing))
    found = meshes.current_mesh()
    nodes, triangles = np.array(found.vertex_matrix()), np.array(found.face_matrix(), dtype=np.int64)
    try:
        edges = edges_of(triangles)
    except ValueError as error:
        raise CaseError(f"walls: surfaces cannot be meshed at this spacing ({error}); use a smaller spacing") from None
    if edges.rim.any():
        at = nodes[edges.nodes[edges.rim][0, 0]]
        raise CaseError(f"walls: surfaces cannot be meshed at this spacing: the mesh has a hole at ({at[0]:.3g}, "
                        f"{at[1]:.3g}, {at[2]:.3g}); use a smaller spacing")
    return nodes, triangles


def _bodies(corners: Floats, pieces: Sequence[Piece], spacing: float) -> Ints:
    """Return the body (M,) of each triangle of the mesh: that of the nearest triangle of all pieces."""
    least, found = np.full(len(corners), np.inf), np.full(len(corners), -1)
    for piece in pieces:    # one by one: large triangles beside small ones make the search slow
        apart, element, _ = nearest(corners.mean(axis=1), piece.points[piece.corners], NEAR * spacing)
        nearer = apart < least - TIE * spacing
        least[nearer], found[nearer] = apart[nearer], piece.body[element[nearer]]
    return found
