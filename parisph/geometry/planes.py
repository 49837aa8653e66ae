"""Planes across a 3D scene where its section changes: their wall nodes, and the walls that lie in them.

On each side of the plane, the section is the same up to the next one. At a place on the plane, the fluid of a side is
all around, nowhere, or in the angles at its nodes there. Fluid of the two sides that meets across the plane is joined:
each joined part is one node. Where only one side is fluid, a wall lies in the plane.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from parisph.base.arrays import Array, Flags, Floats, Ints
from parisph.geometry.mesh import CONCAVE, CONVEX, FLAT, SMOOTH, WallMesh
from parisph.geometry.polygons import merged
from parisph.geometry.triangles import triangulated

CLOSE = 1e-4      # spacings: nodes of both sides nearer than this are at one place
ASIDE = 0.02      # spacings beside an element, where its sides are looked at
SAME = 1e-6       # [rad]: directions that differ by less are one
OPEN, SOLID = -1, -2    # in place of a node: the side is fluid, or solid, all around
TURN = 2.0 * np.pi


@dataclass(frozen=True)
class Side:
    """The section on one side of a plane.

    mesh : of its walls (2D); fluid : returns which points (n, 2) [m] are in fluid; step : [m] between its layers
    """

    mesh: WallMesh
    fluid: Callable[[Floats], Flags]
    step: float


@dataclass(frozen=True)
class Rim:
    """The upper end of the front or the back of an open container: a line above or between its ends.

    nodes : (n, 2) [m], from end to end; the first and the last are at nodes of the section
    """

    nodes: Floats


@dataclass(frozen=True)
class PlaneNodes:
    """The nodes of a plane, and the triangles of the walls in it.

    x : (n, 2) [m] in the section; normal : (n, 3); share, cell, edge, body : (n,), as of a WallMesh, but cell is NaN
    where it is the area; before, after : the nodes at those of the section at smaller and at greater y
    triangles : (m, 3), anticlockwise in the section; way : (m,) int, 1 where the fluid is at greater y, else -1
    """

    x: Floats
    normal: Floats
    share: Floats
    cell: Floats
    edge: Array
    body: Array
    before: Ints
    after: Ints
    triangles: Ints
    way: Ints


@dataclass
class _Part:
    """Fluid at one place that is one node: its nodes of both sides, and the angles in which a wall faces it.

    nodes : numbers on each side; open : whether each side is fluid all around; faces : (start, width, way) [rad]
    """

    nodes: tuple[list[int], list[int]] = field(default_factory=lambda: ([], []))
    open: list[bool] = field(default_factory=lambda: [False, False])
    faces: list[tuple[float, float, int]] = field(default_factory=list)
    convex: bool = False
    concave: bool = False


def plane_nodes(sides: tuple[Side | None, Side | None], spacing: float, where: str, rims: Sequence[Rim] = (),
                closed: bool = True) -> PlaneNodes:
    """Return the nodes and triangles of a plane between two sides, of which the first is at smaller y.

    sides : None beyond the front or the back of the scene; spacing : [m]; where : the plane, in messages; rims : of a
    front or back; closed : whether there is a front and back wall, of which these walls are a part. Raises CaseError.
    """
    if not closed and None in sides:
        return _open_end(sides)
    finder = _Finder(sides, spacing)
    nodes = [finder.node(part, at) for at, parts in enumerate(finder.parts) for part in parts]
    own = [len(parts) for parts in finder.parts]
    first = np.concatenate([[0], np.cumsum(own)]).astype(np.int64)
    number = [np.full(0 if side is None else len(side.mesh.x0), -1) for side in sides]
    for at, parts in enumerate(finder.parts):
        for k, part in enumerate(parts):
            for side in (0, 1):
                number[side][part.nodes[side]] = first[at] + k
    x, triangles, way = _faces(finder, rims, where)
    beyond = len(x) - len(finder.places)
    corner = _corners(finder, first, triangles, way, x)
    used = np.repeat(np.arange(len(finder.places)), own)
    facing = 1.0 if sides[0] is None else -1.0
    normal = np.concatenate([np.array([node[0] for node in nodes]).reshape(-1, 3), np.zeros((beyond, 3))])
    normal[len(nodes):, 1] = facing
    for k in (0, 1, 2):    # inner nodes of walls in the plane
        inner = corner[:, k] >= len(nodes)
        normal[corner[inner, k], 1] = way[inner]
    columns = [np.array([node[k] for node in nodes]) for k in (1, 2, 3, 4)]
    share, cell, edge, body = (np.concatenate([column, np.full(beyond, rest)]) for column, rest in zip(
        columns, (0.5, np.nan, FLAT, -1)))
    return PlaneNodes(np.concatenate([finder.places[used], x[len(finder.places):]]), normal, share, cell,
                      edge.astype(np.int8), body.astype(np.int64), number[0], number[1], corner, way)


def _open_end(sides: tuple[Side | None, Side | None]) -> PlaneNodes:
    """Return the nodes where walls with a motion of their own end at the front or the back, on which they slide."""
    side = sides[0] or sides[1]
    assert side is not None
    mesh, every, none = side.mesh, np.arange(len(side.mesh.x0)), np.empty(0, np.int64)
    return PlaneNodes(mesh.x0, lifted(mesh.normal0), mesh.share, 0.5 * side.step * mesh.cell, mesh.edge,
                      mesh.body.astype(np.int64), none if sides[0] is None else every,
                      none if sides[1] is None else every, np.empty((0, 3), np.int64), none)


def lifted(vectors: Floats, across: Floats | float = 0.0) -> Floats:
    """Return vectors or places (n, 3) of the section (n, 2), with a component `across`."""
    found: Floats = np.stack([vectors[:, 0], np.broadcast_to(across, len(vectors)), vectors[:, 1]], axis=1)
    return found


class _Finder:
    """The places of the nodes of both sides, and the parts of the fluid there.

    places : (n, 2) [m]; number : for each side, the place of each of its nodes; parts : of each place
    """

    def __init__(self, sides: tuple[Side | None, Side | None], spacing: float) -> None:
        self.sides, self.spacing = sides, spacing
        x = [np.empty((0, 2)) if side is None else side.mesh.x0 for side in sides]
        every, self.places = merged(np.concatenate(x), CLOSE * spacing)
        self.number = every[:len(x[0])], every[len(x[0]):]
        self._angles = [_sectors(side.mesh) if side is not None else (np.empty(0), np.empty(0)) for side in sides]
        self._normals = [_side_normals(side.mesh) if side is not None else np.empty((0, 2, 2)) for side in sides]
        around = [SOLID * np.ones(len(self.places), np.int64) if side is None else
                  np.where(side.fluid(self.places), OPEN, SOLID) for side in sides]
        here: list[list[list[int]]] = [[[] for _ in self.places] for _ in sides]
        for side in (0, 1):
            for node, at in enumerate(self.number[side].tolist()):
                here[side][at].append(node)
        self.parts = [self._parts((here[0][at], here[1][at]), (int(around[0][at]), int(around[1][at])))
                      for at in range(len(self.places))]

    def _parts(self, here: tuple[list[int], list[int]], around: tuple[int, int]) -> list[_Part]:
        """Return the parts of the fluid at one place, from the nodes of both sides there."""
        ends = [[(self._angles[k][0][node], self._angles[k][1][node]) for node in here[k]] for k in (0, 1)]
        walls = [np.array([angle % TURN for low, width in ends[k] for angle in (low, low + width)]) for k in (0, 1)]
        ways = _distinct(np.concatenate(walls))
        width = np.diff(np.append(ways, ways[0] + TURN))
        found: list[list[int]] = []    # in each angle between neighbouring ways: what is there on both sides
        for start, size in zip(ways, width):
            middle = start + 0.5 * size
            found.append([next((node for node, (low, wide) in zip(here[k], ends[k]) if (middle - low) % TURN < wide),
                               SOLID) if here[k] else around[k] for k in (0, 1)])
        label = _joined(found)
        parts = {name: _Part() for name in dict.fromkeys(label.values())}
        for (k, node), name in label.items():
            if node == OPEN:
                parts[name].open[k] = True
            else:
                parts[name].nodes[k].append(node)
        for m, (start, size) in enumerate(zip(ways, width)):
            last, next_ = found[m - 1], found[m]
            there = [any(_same(start, end) for end in walls[k]) for k in (0, 1)]
            for name, part in parts.items():
                full = [label.get((k, pair[k])) == name for pair in (last, next_) for k in (0, 1)]
                part.convex |= sum(full) == 3 or (all(full) and there[0] != there[1])
                part.concave |= sum(full) == 1
                if full[2] != full[3]:
                    part.faces.append((start, size, 1 if full[3] else -1))
        return list(parts.values())

    def node(self, part: _Part, at: int) -> tuple[Floats, float, float, int, int]:
        """Return normal (3,), share, cell, edge and body of a part of the fluid at a place."""
        planes, kinds, cells, bodies, shares, own = [], [], [], [], [0.0, 0.0], []
        for k, side in enumerate(self.sides):
            shares[k] = 1.0 if part.open[k] else 0.0
            for node in part.nodes[k]:
                assert side is not None
                mesh = side.mesh
                flat = mesh.edge[node] == FLAT
                planes += [mesh.normal0[node]] if flat else list(self._normals[k][node])
                own.append(mesh.normal0[node])
                kinds.append(mesh.edge[node])
                cells.append(mesh.cell[node])
                bodies.append(int(mesh.body[node]))
                shares[k] += mesh.share[node]
        normals = [*lifted(np.array(planes)), *(np.array([0.0, way, 0.0]) for way in {face[2] for face in part.faces})]
        steps = [side.step for side in self.sides if side is not None]
        edge = (CONVEX if part.convex or CONVEX in kinds else CONCAVE if part.concave or CONCAVE in kinds else FLAT)
        one_sided = not (part.nodes[0] and part.nodes[1])
        beyond = lifted(np.array(own)).sum(axis=0)
        if one_sided:    # the tip of a plate points ahead
            beyond = np.array([0.0, 1.0 if part.nodes[0] else -1.0, 0.0])
        return (_mean_normal(normals, beyond), 0.5 * sum(shares), float(np.mean(cells) * np.mean(steps)), edge,
                min(bodies))

    def kind(self, x: Floats) -> Ints:
        """Return, at points x (n, 2) [m], 1 where only the side at greater y is fluid, -1 where only the other is."""
        first, second = (np.zeros(len(x), bool) if side is None else side.fluid(x) for side in self.sides)
        found: Ints = second.astype(np.int64) - first.astype(np.int64)
        return found

    def bounds(self) -> Ints:
        """Return the pairs of places (m, 2) between which an element of a side bounds a wall in the plane."""
        pairs = [np.empty((0, 2), np.int64)]
        for side, number in zip(self.sides, self.number):
            if side is None or not len(side.mesh.elements):
                continue
            ends = side.mesh.x0[side.mesh.elements]
            along = ends[:, 1] - ends[:, 0]
            normal = np.stack([-along[:, 1], along[:, 0]], axis=1) / np.linalg.norm(along, axis=1)[:, None]
            aside = ASIDE * self.spacing * normal
            there = (self.kind(ends.mean(axis=1) + aside) != 0) | (self.kind(ends.mean(axis=1) - aside) != 0)
            pairs.append(number[side.mesh.elements[there]])
        return np.unique(np.sort(np.concatenate(pairs), axis=1), axis=0)


def _joined(found: list[list[int]]) -> dict[tuple[int, int], int]:
    """Return the part of each (side, node): those in the same angle of both sides are joined. OPEN is a node, too."""
    label: dict[tuple[int, int], int] = {}
    for pair in found:
        wet = [(k, node) for k, node in enumerate(pair) if node != SOLID]
        known = [label[key] for key in wet if key in label]
        name = min(known, default=len(label) + len(found))
        while not known and name in label.values():
            name += 1
        for key, old in list(label.items()):
            if old in known:
                label[key] = name
        label.update((key, name) for key in wet)
    return label


def _mean_normal(normals: list[Floats], beyond: Floats) -> Floats:
    """Return the normalised sum (3,) of the distinct normals; where they cancel, the direction of `beyond`."""
    kept: list[Floats] = []
    for normal in normals:
        if all(float(normal @ other) < np.cos(SMOOTH) for other in kept):
            kept.append(normal)
    total: Floats = np.sum(kept, axis=0)
    if np.linalg.norm(total) < 1e-6:
        total = beyond
    found: Floats = total / max(float(np.linalg.norm(total)), 1e-300)
    return found


def _sectors(mesh: WallMesh) -> tuple[Floats, Floats]:
    """Return start and width (n,) [rad] of the angle of the fluid at each node, anticlockwise."""
    after, before = _directions(mesh)
    start = np.arctan2(after[:, 1], after[:, 0])
    width = (np.arctan2(-before[:, 1], -before[:, 0]) - start) % TURN
    return start, np.where((width < SAME) | (width > TURN - SAME), TURN, width)


def _directions(mesh: WallMesh) -> tuple[Floats, Floats]:
    """Return the unit vectors (n, 2) of the elements after and before each node; at an end, both are its element's."""
    along = mesh.x0[mesh.elements[:, 1]] - mesh.x0[mesh.elements[:, 0]]
    along = along / np.linalg.norm(along, axis=1)[:, None]
    after, before = np.full((len(mesh.x0), 2), np.nan), np.full((len(mesh.x0), 2), np.nan)
    after[mesh.elements[:, 0]], before[mesh.elements[:, 1]] = along, along
    return np.where(np.isnan(after), before, after), np.where(np.isnan(before), after, before)


def _side_normals(mesh: WallMesh) -> Floats:
    """Return the normals (n, 2, 2) of the elements before and after each node."""
    after, before = _directions(mesh)
    return np.stack([np.stack([-way[:, 1], way[:, 0]], axis=1) for way in (before, after)], axis=1)


def _distinct(angles: Floats) -> Floats:
    """Return different angles in [0, 2 pi), ascending."""
    angles = np.sort(angles % TURN)
    kept = np.append(True, np.diff(angles) > SAME)
    kept[0] = len(angles) == 1 or not _same(angles[0], angles[-1]) or not kept[1:].any()
    found: Floats = angles[kept]
    return found


def _same(one: float, other: float) -> bool:
    return bool(min((one - other) % TURN, (other - one) % TURN) <= SAME)


def _faces(finder: _Finder, rims: Sequence[Rim], where: str) -> tuple[Floats, Ints, Ints]:
    """Return the places (n, 2) [m], with those of the finder first, and the triangles (m, 3) and ways (m,)."""
    places, edges = [finder.places], [finder.bounds()]
    for rim in rims:
        inner, count = rim.nodes[1:-1], sum(map(len, places))
        ends = [int(np.argmin(np.linalg.norm(finder.places - end, axis=1))) for end in rim.nodes[[0, -1]]]
        line = np.array([ends[0], *range(count, count + len(inner)), ends[1]])
        places.append(inner)
        edges.append(np.stack([line[:-1], line[1:]], axis=1))
    x, pairs = np.concatenate(places), np.concatenate(edges)
    none = np.empty(0, np.int64)
    if not len(pairs):
        return x, np.empty((0, 3), np.int64), none
    used, edge = np.unique(pairs, return_inverse=True)
    inner, triangles = triangulated(x[used], edge.reshape(-1, 2), lambda at: finder.kind(at) != 0, finder.spacing,
                                    where)
    corners = np.concatenate([used, np.arange(len(x), len(x) + len(inner))])[triangles]
    x = np.concatenate([x, inner])
    return x, corners, finder.kind(x[corners].mean(axis=1))


def _corners(finder: _Finder, first: Ints, triangles: Ints, way: Ints, x: Floats) -> Ints:
    """Return the nodes (m, 3) of triangles of places: of several nodes at one place the one that they face."""
    many = len(finder.places)
    found = np.where(triangles < many, first[np.minimum(triangles, many - 1)] if many else 0,
                     triangles - many + first[-1])
    several = np.array([len(parts) > 1 for parts in finder.parts] + [False])
    middle = x[triangles].mean(axis=1)
    for m, k in np.argwhere(several[np.minimum(triangles, many)]).tolist():
        at = int(triangles[m, k])
        angle = np.arctan2(*(middle[m] - x[at])[::-1])
        found[m, k] += next((number for number, part in enumerate(finder.parts[at])
                             if any(side == way[m] and (angle - start) % TURN <= width
                                    for start, width, side in part.faces)), 0)
    return found
