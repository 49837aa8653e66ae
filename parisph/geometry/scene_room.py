"""The room of a 3D scene with Surfaces: what its bodies limit and what its solids leave, and the mesh around it.

Bodies at rest are prisms across, as in their sections. Bodies that move are no part of the room: they are meshed as in
scenes without Surfaces, and slide along its walls.
"""

from collections.abc import Iterator
from functools import lru_cache

import numpy as np

from parisph.base.arrays import Flags, Floats, Ints
from parisph.base.errors import CaseError
from parisph.case.motion import AtRest
from parisph.case.scene import Scene
from parisph.case.shapes import Tank
from parisph.case.surface_body import Surface
from parisph.geometry.extrusion import extruded, moving_meshes
from parisph.geometry.inside import floors
from parisph.geometry.mesh import MeshBody, WallMesh, together
from parisph.geometry.room import Piece, Room, prism, room_of
from parisph.geometry.solid import Solid, Wall, solid_of
from parisph.geometry.spans import container, scene_walls, spans
from parisph.geometry.surface_files import Triangles, read
from parisph.geometry.triangle_mesh import edges_of, triangle_mesh

FAR = 10.0       # sizes of a scene, how far open outlines continue
ARC = np.pi / 4.0    # [rad] between the corners of the outline that closes an open one far away
ONTO = 0.01      # spacings: a bed that ends this close to a wall reaches it
BELOW = 1.0      # sizes of a scene, how far the solid under an open surface reaches down

_KNOWN: dict[tuple[object, float], Room] = {}    # rooms that were read from the files of a run


def know(case: Scene, room: Room) -> None:
    """Let `scene_room` return a room that was stored with a run, so that neither files nor libraries are needed."""
    _KNOWN[case.walls, case.numerics.spacing] = room


def is_known(case: Scene) -> bool:
    """Return whether the room of a scene was stored with its run."""
    return (case.walls, case.numerics.spacing) in _KNOWN


def scene_room(case: Scene) -> Room:
    """Return the Room of a scene with Surfaces. Cached. Not collective. Raises CaseError, MissingLibrary."""
    known = _KNOWN.get((case.walls, case.numerics.spacing))
    return _made(case) if known is None else known


@lru_cache(maxsize=2)
def _made(case: Scene) -> Room:
    return room_of([*_prisms(case), *_solids(case)], case.numerics.spacing)


@lru_cache(maxsize=2)
def room_mesh(case: Scene) -> WallMesh:
    """Return the mesh of all walls of a scene with Surfaces. Cached: callers must not change the arrays.

    Its bodies are those of geometry.spans.scene_walls, and then the Surfaces. Raises CaseError.
    """
    room = scene_room(case)
    bodies = (*extruded(case).bodies, *(MeshBody(surface.name, 0, surface.slip) for surface in case.surfaces))
    return together([triangle_mesh(room.nodes, room.triangles, room.body, bodies), *moving_meshes(case)], bodies)


def in_room(case: Scene, x: Floats) -> Flags:
    """Return which points x (n, 3) [m] are in the room of a scene with Surfaces, or above its rim, (n,) bool."""
    found: Flags = floors(x, scene_room(case).corners, case.numerics.spacing) == 1
    return found


def _prisms(case: Scene) -> Iterator[Piece]:
    """Yield the bodies at rest as Pieces; first the container, which limits the room."""
    walls, around = scene_walls(case), container(case)
    number = walls.index(around)
    if not isinstance(around, Tank):
        whole = case.breadth
        assert whole is not None
        yield _prism(case, _fluid_side(solid_of(around), _size(case)), whole, number, limits=True)
    yield _block(case, number, isinstance(around, Tank))
    for span in spans(case):
        for wall, body in zip(span.walls, span.body.tolist()):
            if body != number and isinstance(wall.motion, AtRest):
                yield _prism(case, _outline(wall, _size(case)), (span.lower, span.upper), body)


def _prism(case: Scene, outline: Floats, ends: tuple[float, float], body: int, limits: bool = False) -> Piece:
    points, corners = prism(outline, ends)
    return Piece(points, corners, np.full(len(corners), body), limits)


def _block(case: Scene, body: int, tank: bool) -> Piece:
    """Return the box of the scene, whose sides are walls of a tank; of others only the front and the back are walls.

    The top is one if it is a lid.
    """
    lower, upper = case.wall_bounds or (np.zeros(3), np.zeros(3))
    upper = np.append(upper[:2], upper[2] if tank else extruded(case).x0[:, 2].max())
    lower = lower - [0.0, 0.0, 0.0 if tank else BELOW * _size(case)]
    (left, low), (right, high) = lower[[0, 2]], upper[[0, 2]]
    points, corners = prism(np.array([(left, low), (right, low), (right, high), (left, high)]), (lower[1], upper[1]))
    normal = np.cross(points[corners[:, 1]] - points[corners[:, 0]], points[corners[:, 2]] - points[corners[:, 0]])
    axis = np.argmax(np.abs(normal), axis=1)
    top = (axis == 2) & (normal[:, 2] > 0.0)
    walled = ~top | case.lidded if tank else axis == 1
    return Piece(points, corners, np.where(walled, body, -1), limits=True)


def _size(case: Scene) -> float:
    lower, upper = case.wall_bounds or (np.zeros(3), np.ones(3))
    return float(np.linalg.norm(upper - lower))


def _outline(wall: Wall, size: float) -> Floats:
    """Return the outline (n, 2) [m] of a solid in the section, anticlockwise; an open one is closed far away."""
    solid = solid_of(wall)
    return solid.points[::-1] if solid.closed else _closed(solid, size)[::-1]


def _fluid_side(solid: Solid, size: float) -> Floats:
    """Return the outline of the fluid's side of an open Profile, anticlockwise."""
    return _closed(solid, size, fluid=True)


def _closed(solid: Solid, size: float, fluid: bool = False) -> Floats:
    """Return the outline of one side of an open Solid, closed by an arc far away.

    It is in the order of its points, so anticlockwise around the fluid, and clockwise around the rest.
    """
    points, centre = solid.points, solid.points.mean(axis=0)
    ends = [end + FAR * size * way / np.linalg.norm(way) for end, way in zip(points[[0, -1]], solid.ways)]
    first, last = (float(np.arctan2(*(end - centre)[::-1])) for end in ends)
    turn = (first - last) % (2.0 * np.pi) if fluid else -((last - first) % (2.0 * np.pi))
    many = max(int(np.ceil(abs(turn) / ARC)), 1)
    angle = last + turn * np.arange(1, many) / many
    radius = max(float(np.linalg.norm(end - centre)) for end in ends)
    arc = centre + radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return np.concatenate([ends[:1], points, ends[1:], arc])


def _solids(case: Scene) -> Iterator[Piece]:
    """Yield the Surfaces as Pieces."""
    first = len(scene_walls(case))
    for number, surface in enumerate(case.surfaces, first):
        found = read(surface)
        if found.closed:
            yield Piece(found.points, found.corners, np.full(len(found.corners), number), surface.side == "inside")
        else:
            points, corners = under(case, surface, found)
            yield Piece(points, corners, np.full(len(corners), number))


def under(case: Scene, surface: Surface, bed: Triangles) -> tuple[Floats, Ints]:
    """Return the solid under an open surface as points (2 N, 3) [m] and triangles (M, 3), with normals outward.

    Points of its rim on a wall of the scene, to rounding of its file, are moved just beyond it.

    Raises CaseError if fluid is to be inside it.
    """
    if surface.side is not None:
        raise CaseError(f"walls, {surface.name}: side = {surface.side}: is for a closed surface, and this one is open, "
                        "a bed with fluid above it; leave it out, or close the surface")
    lower, upper = case.wall_bounds or (np.zeros(3), np.zeros(3))
    points, corners = bed.points.copy(), bed.corners.astype(np.int64)
    edges = edges_of(corners)
    rim, slack = np.unique(edges.nodes[edges.rim]), ONTO * case.numerics.spacing
    for axis in (0, 1):
        for side, place in ((-1.0, lower[axis]), (1.0, upper[axis])):
            on = rim[np.abs(points[rim, axis] - place) < slack]
            points[on, axis] = place + side * slack
    floor = points.copy()
    floor[:, 2] = min(float(points[:, 2].min()), lower[2]) - BELOW * _size(case)
    directed = np.stack([corners, np.roll(corners, -1, axis=1)], axis=2).reshape(-1, 2)
    many = len(points)
    known = np.sort(edges.nodes[edges.rim], axis=1) @ [many, 1]
    a, b = directed[np.isin(np.sort(directed, axis=1) @ [many, 1], known)].T
    sides = [np.stack([b, a, a + many], axis=1), np.stack([b, a + many, b + many], axis=1)]
    return np.concatenate([points, floor]), np.concatenate([corners, corners[:, ::-1] + many, *sides])
