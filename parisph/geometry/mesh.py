"""The boundary mesh of a scene: wall nodes, and the elements between them, about a spacing long.

Nodes are particles and have rows of the pressure equation; elements define the walls. A lone tank keeps the nodes of
its lattice, in their order (any dimension). Other outlines are divided piece by piece into round(length / s) elements
(2D).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np

from parisph.base.arrays import Array, Flags, Floats, Ints
from parisph.base.errors import CaseError
from parisph.case.lattice import Lattice
from parisph.case.motion import AtRest, Motion
from parisph.case.scenery import body_names
from parisph.case.shapes import Box, Tank
from parisph.geometry.distance import area_vectors
from parisph.geometry.polygons import CLOSE, Chain, joined
from parisph.geometry.solid import Wall, solid_of

SMOOTH = 0.1    # rad: a point where an outline turns by less is no corner
# rad: most turn of a smooth line in one element, so a disc has at least eight elements. With three to six, still water
# beside discs of .7 to .9 spacings moves.
BEND = np.pi / 4.0
FLAT, CONCAVE, CONVEX = 0, 1, 2    # values of `edge`


@dataclass(frozen=True)
class MeshBody:
    """One body of a mesh: its name, the number of its motion (0 rests in the tank's frame), and its slip."""

    name: str
    motion: int = 0
    slip: str = "free"


@dataclass(frozen=True)
class WallMesh:
    """Nodes and elements of all walls, in the frames of their bodies.

    x0 : (N, dim) nodes [m]; normal0 : (N, dim) unit normals into the fluid, on edges the normalised sum of both sides'
    area : (N,) of each node's part of the wall [m^(dim-1)]; vector_area : (N, dim), the integral of the normal over it
    share : (N,) part of the node's cell inside the fluid: the angle of the fluid over the whole angle
    cell : (N,) size of this cell over its thickness [m^(dim-1)]: the area, but in 3D not where three planes meet
    body : (N,) int; edge : (N,) int8, FLAT, CONCAVE, or CONVEX, which carries no row
    elements : (M, dim) int, nodes; in 2D the fluid is on the left of the way from the first to the second, in 3D on the
        side from which they are in anticlockwise order
    element_body : (M,) int; bodies : MeshBody number 0, 1, ...
    """

    x0: Floats
    normal0: Floats
    area: Floats
    vector_area: Floats
    share: Floats
    cell: Floats
    body: Array
    edge: Array
    elements: Array
    element_body: Array
    bodies: tuple[MeshBody, ...] = field(default=())

    @property
    def dim(self) -> int:
        """2 or 3."""
        return self.x0.shape[1]

    @property
    def ends(self) -> Flags:
        """Which nodes (N,) lie at the ends of open lines, in 3D on the rims of open surfaces."""
        if self.dim == 2:
            ends: Flags = np.bincount(self.elements.ravel(), minlength=len(self.x0)) == 1
            return ends
        found = np.zeros(len(self.x0), dtype=bool)
        found[rim_edges(self.elements)] = True
        return found

    def corners(self, x: Floats | None = None) -> Floats:
        """Return the corners (M, dim, dim) [m] of the elements, with the nodes at x (N, dim) [m], or at rest."""
        return (self.x0 if x is None else x)[self.elements]


def rim_edges(triangles: Array) -> Ints:
    """Return the edges (m, 2), as pairs of nodes, that belong to one of the triangles (M, 3) only."""
    edges = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    edges, many = np.unique(edges, axis=0, return_counts=True)
    found: Ints = edges[many == 1]
    return found


def no_mesh(dim: int) -> WallMesh:
    """Return the mesh of a scene without walls."""
    none, vectors, numbers = np.empty(0), np.empty((0, dim)), np.empty(0, np.int32)
    return WallMesh(vectors, vectors, none, vectors, none, none, numbers, np.empty(0, np.int8),
                    np.empty((0, dim), np.int32), numbers)


def wall_mesh(walls: Sequence[Wall], spacing: float) -> WallMesh:
    """Return the mesh of the walls of a scene (2D), each in its own frame, as at t = 0.

    walls : Tank, Profile, Obstacle and Plate; spacing : [m]. Bodies with the same motion are joined where they touch.

    Raises CaseError where no body touches fluid.

    Cached: callers must not change the arrays.
    """
    return _wall_mesh(tuple(walls), spacing)


@lru_cache(maxsize=32)    # one for each section of a 3D scene
def _wall_mesh(walls: tuple[Wall, ...], spacing: float) -> WallMesh:
    bodies = tuple(map(MeshBody, body_names(walls), motion_numbers(walls), map(slip_of, walls)))
    chains = chains_of(walls, spacing)
    if not chains:
        names = ", ".join(body.name for body in bodies)
        raise CaseError(f"walls: no fluid touches any of {names}: each lies inside another")
    meshes, tank = [], _lone_tank(walls, chains)
    if tank is not None and isinstance(wall := walls[tank], Tank):
        mesh = block_mesh(Lattice(Box(width=wall.width, height=wall.height, at=wall.at), wall, spacing))
        meshes.append(replace(mesh, body=mesh.body + np.int32(tank), element_body=mesh.element_body + np.int32(tank)))
    meshes += [chain_mesh(chain, spacing) for chain in chains if tank is None or not np.all(chain.body == tank)]
    return together(meshes, bodies)


def slip_of(wall: Wall) -> str:
    """Return "none" if viscous fluid sticks to a body, or to a side of a tank, else "free"."""
    return ("none" if wall.sticky else "free") if isinstance(wall, Tank) else wall.slip


@lru_cache(maxsize=32)
def chains_of(walls: tuple[Wall, ...], spacing: float) -> tuple[Chain, ...]:
    """Return the chains of all walls, those with the same motion joined, in the order of the motions. Cached."""
    numbers, chains = np.array(motion_numbers(walls), dtype=np.int64), []
    for motion in np.unique(numbers):
        members = np.flatnonzero(numbers == motion)
        for chain in joined([solid_of(walls[k]) for k in members], spacing):
            chains.append(replace(chain, body=members[chain.body]))
    return tuple(chains)


def motions_of(walls: Sequence[Wall]) -> tuple[Motion, ...]:
    """Return the different motions of walls; number 0 is rest."""
    return AtRest(), *dict.fromkeys(wall.motion for wall in walls if not isinstance(wall.motion, AtRest))


def motion_numbers(walls: Sequence[Wall]) -> list[int]:
    """Return for each wall the number of its motion in `motions_of`."""
    motions = motions_of(walls)
    return [0 if isinstance(wall.motion, AtRest) else motions.index(wall.motion) for wall in walls]


def _lone_tank(walls: Sequence[Wall], chains: Sequence[Chain]) -> int | None:
    """Return the number of the tank whose outline no other body touches, or None."""
    for number, wall in enumerate(walls):
        if isinstance(wall, Tank):
            own = [chain for chain in chains if np.any(chain.body == number)]
            whole = len(own) == 1 and np.all(own[0].body == number) and len(own[0].points) == 4
            return number if whole else None
    return None


def block_mesh(lattice: Lattice) -> WallMesh:
    """Return the mesh of a tank whose nodes are the wall points of its lattice, in their order. Any dimension."""
    index, inward = lattice.wall_indices()
    dim, top, step = index.shape[1], lattice.top, lattice.step
    planes = np.abs(inward).sum(axis=1)
    order = np.ravel_multi_index(tuple(index.T), tuple(top + 1))    # ascending
    faces, simplices = [], []
    for axis in range(dim):
        for sign in (1, -1):
            there = index[inward[:, axis] == sign]
            if len(there):
                cells = np.moveaxis(_cells(there, axis, top), -1, 0)
                corners = np.searchsorted(order, np.ravel_multi_index(tuple(cells), tuple(top + 1)))
                faces.append((corners, np.eye(dim)[axis] * sign * np.delete(step, axis).prod()))
                simplices.append(_simplices(corners, axis, sign))
    vectors, area = np.zeros((len(index), dim)), np.zeros(len(index))
    for corners, vector in faces:
        np.add.at(vectors, corners, vector / corners.shape[1])
        np.add.at(area, corners, np.abs(vector).sum() / corners.shape[1])
    length = np.linalg.norm(inward, axis=1)
    elements = np.concatenate(simplices)
    return WallMesh(
        x0=lattice.position(index), normal0=inward / length[:, None], area=area, vector_area=vectors, share=0.5**planes,
        cell=area * np.where((dim == 3) & (planes == 3), 4.0 / 3.0, 1.0),
        body=np.zeros(len(index), np.int32), edge=np.where(planes > 1, CONCAVE, FLAT).astype(np.int8),
        elements=elements.astype(np.int32), element_body=np.zeros(len(elements), np.int32))


def _cells(index: Ints, axis: int, top: Ints) -> Ints:
    """Return the corner indices (cells, 2^(dim-1), dim) of the cells on one face of a block."""
    others = [a for a in range(index.shape[1]) if a != axis]
    lowest = index[(index[:, others] < top[others]).all(axis=1)]
    steps = np.zeros((2 ** len(others), index.shape[1]), dtype=np.int64)
    steps[:, others] = np.indices((2,) * len(others)).reshape(len(others), -1).T
    found: Ints = lowest[:, None, :] + steps
    return found


def _simplices(corners: Ints, axis: int, sign: int) -> Ints:
    """Divide cells into elements with the fluid in the direction sign * axis."""
    if corners.shape[1] == 2:    # fluid above is on the left along x; fluid at greater x is on the right along y
        return corners if (axis == 1) == (sign == 1) else corners[:, ::-1]
    a, b, c, d = corners.T       # (0, 0), (0, 1), (1, 0), (1, 1) of the two other axes
    turn = (axis == 1) == (sign == 1)    # whether the order of the other axes is clockwise, seen from the fluid
    triangles = [(a, c, d), (a, d, b)] if not turn else [(a, d, c), (a, b, d)]
    return np.concatenate([np.stack(triangle, axis=1) for triangle in triangles])


def chain_mesh(chain: Chain, spacing: float, pieces: Sequence[int] | None = None) -> WallMesh:
    """Return the mesh of one chain: each stretch between corners divided into equal elements (2D).

    pieces : their number in each stretch, None for those of `divisions`
    """
    x, body, corner = _nodes(chain, [many for _, _, many in divisions(chain, spacing)] if pieces is None else pieces)
    n = len(x)
    pairs = np.stack([np.arange(n), np.arange(1, n + 1) % n], axis=1)[: n if chain.closed else n - 1]
    vectors = area_vectors(x[pairs])
    half, area, total = np.zeros((n, 2)), np.zeros(n), np.zeros((n, 2))
    length = np.linalg.norm(vectors, axis=1)
    for end in pairs.T:
        np.add.at(half, end, 0.5 * vectors)
        np.add.at(area, end, 0.5 * length)
        np.add.at(total, end, vectors / length[:, None])
    angle = np.where(corner >= 0, chain.angle[corner], np.pi)
    edge = np.where(angle < np.pi - SMOOTH, CONCAVE, np.where(angle > np.pi + SMOOTH, CONVEX, FLAT))
    tip = angle > 2.0 * np.pi - SMOOTH    # the normals of both sides cancel; the tip points ahead
    ahead = x - np.roll(x, 1, axis=0)
    total = np.where(tip[:, None], ahead, total)
    return WallMesh(
        x0=x, normal0=total / np.linalg.norm(total, axis=1)[:, None], area=area, vector_area=half,
        share=np.where(edge == FLAT, 0.5, angle / (2.0 * np.pi)), cell=area,
        body=body[np.minimum(np.arange(n), len(body) - 1)],
        edge=edge.astype(np.int8), elements=pairs.astype(np.int32), element_body=body)


def divisions(chain: Chain, spacing: float) -> Iterator[tuple[int, Floats, int]]:
    """Yield first point, points (n, 2) [m] and number of elements, round(length / s), of each stretch of a chain.

    A stretch between two convex corners has at least two, so that one node has a row. Otherwise particles beside a
    small body would treat its place as air.
    """
    points, convex = chain.points, chain.angle > np.pi + SMOOTH
    for start, way in stretches(chain):
        stop = start + len(way) - 1
        both = convex[start % len(points)] and convex[stop % len(points)]
        turn = float(np.sum(chain.angle[np.arange(start + 1, stop) % len(points)] - np.pi))
        least = max(2 if both else 1, int(np.ceil(abs(turn) / BEND - CLOSE)))
        yield start, way, max(round(reaches(way)[-1] / spacing), least)


def _nodes(chain: Chain, pieces: Sequence[int]) -> tuple[Floats, Ints, Ints]:
    """Return the nodes (n, 2) of a chain, the body of each element, and each node's corner of the chain or -1, (n,)."""
    points = chain.points
    x, body, corner = [], [], []
    for (start, way), many in zip(stretches(chain), pieces):
        x.append(_divided(way, many)[:-1])
        body.append(np.full(many, chain.body[start % len(chain.body)]))
        corner += [start % len(points)] + [-1] * (many - 1)
    if not chain.closed:
        x.append(points[-1:])
        corner.append(len(points) - 1)
    return np.concatenate(x), np.concatenate(body).astype(np.int32), np.array(corner)


def stretches(chain: Chain) -> Iterator[tuple[int, Floats]]:
    """Yield the stretches of a chain between its corners: number of the first point, points (n, 2) [m]."""
    starts = breaks(chain)
    stops = [*starts[1:], starts[0] + len(chain.body)] if chain.closed else starts[1:]
    for start, stop in zip(starts, stops):
        yield start, chain.points[np.arange(start, stop + 1) % len(chain.points)]


def breaks(chain: Chain) -> list[int]:
    """Return the numbers of the points where a new stretch begins: corners, ends, marks, and changes of the body."""
    sharp = np.abs(chain.angle - np.pi) >= SMOOTH
    sharp[list(chain.marks)] = True
    if chain.closed:
        sharp |= chain.body != np.roll(chain.body, 1)
        return np.flatnonzero(sharp).tolist() or [0]
    sharp[1:-1] |= chain.body[1:] != chain.body[:-1]
    sharp[[0, -1]] = True
    found: list[int] = np.flatnonzero(sharp).tolist()
    return found


def _divided(way: Floats, pieces: int) -> Floats:
    """Divide a line through points (n, 2) into pieces of equal length."""
    reach = reaches(way)
    if len(way) == 2:
        inner = way[0] + np.arange(1, pieces)[:, None] * ((way[1] - way[0]) / pieces)
    else:
        inner = places_along(way, reach, reach[-1] * np.arange(1, pieces) / pieces)
    return np.concatenate([way[:1], inner, way[-1:]])


def reaches(way: Floats) -> Floats:
    """Return the length (n,) [m] along a line through points (n, dim) [m] up to each of them."""
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(way, axis=0), axis=1))])


def places_along(way: Floats, reach: Floats, along: Floats) -> Floats:
    """Return the places (m, dim) [m] at lengths `along` (m,) [m] on a line whose points are at lengths `reach` [m]."""
    return np.stack([np.interp(along, reach, column) for column in way.T], axis=1)


def together(meshes: Sequence[WallMesh], bodies: tuple[MeshBody, ...]) -> WallMesh:
    """Return meshes as one."""
    joint = {name: np.concatenate([getattr(mesh, name) for mesh in meshes]) for name in vars(meshes[0])
             if name not in ("elements", "bodies")}
    before = np.cumsum([0, *[len(mesh.x0) for mesh in meshes]])
    elements = np.concatenate([mesh.elements + np.int32(start) for mesh, start in zip(meshes, before)])
    return WallMesh(**joint, elements=elements, bodies=bodies)
