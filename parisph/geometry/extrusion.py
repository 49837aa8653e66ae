"""The boundary mesh of a 3D scene: its sections, extruded across, and the walls in the planes between them.

Between two cuts, each element of the section's chains is a row of rectangles of two triangles, one in each layer. In
the planes of the cuts lie the ends of bodies, and in those of the front and the back the walls of the container
(geometry.planes). Chains are also divided where another section has a corner, so that all sections have the same nodes
where they have the same wall.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from parisph.base.arrays import Flags, Floats, Ints
from parisph.base.errors import CaseError
from parisph.case.lattice import Lattice
from parisph.case.motion import AtRest, Motion
from parisph.case.scene import Scene
from parisph.case.scenery import body_names
from parisph.case.shapes import Box, Tank
from parisph.geometry.columns import cross
from parisph.geometry.distance import area_vectors, nearest, unit_normals
from parisph.geometry.mesh import (
    MeshBody,
    WallMesh,
    block_mesh,
    breaks,
    chain_mesh,
    divisions,
    motion_numbers,
    no_mesh,
    slip_of,
    together,
)
from parisph.geometry.planes import PlaneNodes, Rim, Side, lifted, plane_nodes
from parisph.geometry.polygons import CLOSE, Chain, joined
from parisph.geometry.raised import highest
from parisph.geometry.scene_cache import cached
from parisph.geometry.solid import Wall, solid_of
from parisph.geometry.spans import Span, container, scene_walls, spans
from parisph.geometry.triangles import corner_parts

FREE = 0.5    # of the depth of the water: least height of the front above it, where a Profile gives the breadth
OVER = 1.0    # spacings of the front above the highest body that reaches its rim

LEVEL = 1e-6  # spacings: points less behind a wall are in front of it


@dataclass(frozen=True)
class _Group:
    """The walls with one motion in one part of the scene, and their chains, with bodies as in `scene_walls`."""

    walls: tuple[Wall, ...]
    chains: tuple[Chain, ...]


def _in_front(section: WallMesh, spacing: float) -> Callable[[Floats], Flags]:
    """Return the function that says which points x (n, 2) [m] lie in front of the elements of a section."""
    corners = section.corners()
    normal = unit_normals(corners) if len(corners) else corners

    def fluid(x: Floats) -> Flags:
        if not len(corners):
            return np.ones(len(x), dtype=bool)
        _, element, foot = nearest(x, corners)
        found: Flags = np.sum((x - foot) * normal[element], axis=1) > -LEVEL * spacing    # 0 beyond the tip of a plate
        return found
    return fluid


@cached(2)
def extruded(case: Scene) -> WallMesh:
    """Return the mesh of a 3D scene with walls. Cached: callers must not change the arrays. Raises CaseError."""
    walls = scene_walls(case)
    numbers = motion_numbers(walls)
    bodies = tuple(MeshBody(wall.name, motion, slip_of(wall)) for wall, motion in zip(walls, numbers))
    if (tank := _lone(case)) is not None:
        box = Box(width=tank.width, height=tank.height, breadth=tank.breadth, at=tank.at)
        return replace(block_mesh(Lattice(box, tank, case.numerics.spacing)), bodies=bodies)
    meshes = [_group_mesh(case, motion) for motion in dict.fromkeys([walls[k].motion for k in np.argsort(
        numbers, kind="stable")])]
    meshes = [mesh for mesh in meshes if len(mesh.x0)]
    if not meshes:
        raise CaseError(f"walls: no fluid touches any of {', '.join(body_names(case.bodies))}: each lies inside "
                        "another")
    return together(meshes, bodies)


def moving_meshes(case: Scene) -> list[WallMesh]:
    """Return the meshes of the walls of a 3D scene that move in its frame, with bodies as in `extruded`."""
    motions = dict.fromkeys(wall.motion for wall in scene_walls(case) if not isinstance(wall.motion, AtRest))
    return [_group_mesh(case, motion) for motion in motions]


def _lone(case: Scene) -> Tank | None:
    """Return the tank if it is the only wall, or None."""
    return case.tank if len(case.bodies) == 1 else None


def _group_mesh(case: Scene, motion: Motion) -> WallMesh:
    """Return the mesh of all walls with one motion."""
    s, parts = case.numerics.spacing, spans(case)
    groups = [_group(span, motion, s) for span in parts]
    sections = _sections(groups, s)
    closed = container(case).motion == motion
    rims: list[list[Rim]] = [[] for _ in range(len(parts) + 1)]
    fluids = [_in_front(section, s) for section in sections]
    bounded = list(fluids)
    if closed:
        for end, k in ((0, 0), (-1, len(parts) - 1)):
            rims[end], bounded[k] = _rims(case, groups[k], fluids[k])
    ends = [None, *range(len(parts)), None]
    places = [parts[0].lower, *(span.upper for span in parts)]
    planes = []
    for cut, pair in enumerate(zip(ends, ends[1:])):
        fluid = bounded if None in pair else fluids
        sides = [None if k is None else Side(sections[k], fluid[k], _step(parts[k])) for k in pair]
        plane = plane_nodes((sides[0], sides[1]), s, f"at y = {places[cut]:g}", rims[cut], closed)
        planes.append(_Plane(plane, places[cut], _owners(case, plane, [None if k is None else parts[k] for k in pair],
                                                         motion)))
    return _assembled(planes, sections, parts)


@dataclass(frozen=True)
class _Plane:
    """A plane across: its nodes, its place y [m], and the body (m,) of each of its triangles."""

    nodes: PlaneNodes
    y: float
    body: Ints


def _owners(case: Scene, plane: PlaneNodes, pair: Sequence[Span | None], motion: Motion) -> Ints:
    """Return the body (m,) of each triangle: of those on the solid's side the one there, at the ends the container."""
    found = np.full(len(plane.triangles), scene_walls(case).index(container(case)))
    middle = plane.x[plane.triangles].mean(axis=1)
    for way, span in ((1, pair[0]), (-1, pair[1])):
        if span is None:
            continue
        rest = plane.way == way
        for wall, number in zip(span.walls, span.body):
            if wall.motion == motion:
                behind = np.flatnonzero(rest)[~solid_of(wall).in_front(middle[rest])]
                found[behind], rest[behind] = number, False
    return found


def _assembled(planes: Sequence[_Plane], sections: Sequence[WallMesh], parts: Sequence[Span]) -> WallMesh:
    """Return the mesh of all planes, with the layers between them."""
    meshes, first = [], 0
    start = []    # of each plane
    inner = []    # of the nodes between the planes: first node
    for k, plane in enumerate(planes):
        meshes.append(_plane_mesh(plane))
        start.append(first)
        first += len(plane.nodes.x)
        if k < len(parts):
            meshes.append(_between(sections[k], parts[k]))
            inner.append(first)
            first += len(meshes[-1].x0)
    mesh = together(meshes, ())
    elements, owner, area, vectors = [mesh.elements], [mesh.element_body], mesh.area.copy(), mesh.vector_area.copy()
    for k, (section, span) in enumerate(zip(sections, parts)):
        many = len(section.x0)
        layers = inner[k] + np.arange((len(span.layers) - 2) * many).reshape(len(span.layers) - 2, many)
        nodes = np.concatenate([start[k] + planes[k].nodes.after[None], layers,
                                start[k + 1] + planes[k + 1].nodes.before[None]])
        rows = nodes[:, section.elements]    # (planes, elements, 2)
        quads = np.concatenate([rows[:-1], rows[1:]], axis=2).reshape(-1, 4)
        size = lifted(area_vectors(section.corners())) * _step(span)
        size = np.tile(size, (len(span.layers) - 1, 1))
        for corner in quads.T:
            np.add.at(vectors, corner, 0.25 * size)
            np.add.at(area, corner, 0.25 * np.linalg.norm(size, axis=1))
        elements += [quads[:, [0, 1, 2]], quads[:, [1, 3, 2]]]
        owner += 2 * [np.tile(section.element_body, len(span.layers) - 1)]
    return replace(mesh, elements=np.concatenate(elements).astype(np.int32), area=area, vector_area=vectors,
                   element_body=np.concatenate(owner).astype(np.int32),
                   cell=np.where(np.isnan(mesh.cell), area, mesh.cell))


def _between(section: WallMesh, span: Span) -> WallMesh:
    """Return the nodes of a part between its ends, layer by layer, without elements."""
    inside = span.layers[1:-1]
    many, n = len(inside), len(section.x0)
    x0 = lifted(np.tile(section.x0, (many, 1)), np.repeat(inside, n))
    return WallMesh(
        x0=x0, normal0=lifted(np.tile(section.normal0, (many, 1))), area=np.zeros(many * n),
        vector_area=np.zeros((many * n, 3)), share=np.tile(section.share, many),
        cell=np.tile(section.cell, many) * _step(span), body=np.tile(section.body, many),
        edge=np.tile(section.edge, many), elements=np.empty((0, 3), np.int32), element_body=np.empty(0, np.int32))


def _plane_mesh(plane: _Plane) -> WallMesh:
    """Return the nodes of a plane, with its triangles."""
    nodes, x0 = plane.nodes, lifted(plane.nodes.x, plane.y)
    # anticlockwise in the section, seen from the front, where y is smaller
    elements = np.where(nodes.way[:, None] > 0, nodes.triangles[:, ::-1], nodes.triangles)
    body, vectors, area = nodes.body.copy(), np.zeros_like(x0), np.zeros(len(x0))
    size = area_vectors(x0[elements]) if len(elements) else np.empty((0, 3))
    for corner, part in zip(elements.T, corner_parts(x0[elements]).T):
        np.add.at(vectors, corner, part[:, None] * size)
        np.add.at(area, corner, part * np.linalg.norm(size, axis=1))
        body[corner] = np.where(body[corner] < 0, plane.body, body[corner])
    return WallMesh(x0=x0, normal0=nodes.normal, area=area, vector_area=vectors, share=nodes.share, cell=nodes.cell,
                    body=body.astype(np.int32), edge=nodes.edge, elements=elements.astype(np.int32),
                    element_body=plane.body.astype(np.int32))


def _step(span: Span) -> float:
    return float(span.layers[1] - span.layers[0])


def _group(span: Span, motion: Motion, spacing: float) -> _Group:
    members = [k for k, wall in enumerate(span.walls) if wall.motion == motion]
    walls = tuple(span.walls[k] for k in members)
    chains = joined([solid_of(wall) for wall in walls], spacing) if walls else []
    return _Group(walls, tuple(replace(chain, body=span.body[members][chain.body]) for chain in chains))


def _sections(groups: Sequence[_Group], spacing: float) -> list[WallMesh]:
    """Return the mesh of the section of each part (2D), with the same nodes where the walls are the same."""
    corners = [np.concatenate([np.empty((0, 2)), *(chain.points[breaks(chain)] for chain in group.chains)])
               for group in groups]
    every = np.unique(np.concatenate(corners), axis=0)
    marked = [[_marked(chain, every, CLOSE * spacing) for chain in group.chains] for group in groups]
    most: dict[object, int] = {}
    for chain in (chain for chains in marked for chain in chains):
        for _, way, many in divisions(chain, spacing):
            key = _stretch(way, spacing)
            most[key] = max(many, most.get(key, 0))
    found = []
    for chains in marked:
        meshes = [chain_mesh(chain, spacing, [most[_stretch(way, spacing)] for _, way, _ in divisions(chain, spacing)])
                  for chain in chains]
        found.append(together(meshes, ()) if meshes else no_mesh(2))
    return found


def _stretch(way: Floats, spacing: float) -> object:
    """Return what a line through points (n, 2) has in common with the same line in the other direction."""
    ends = np.round(way[[0, -1]] / (100.0 * CLOSE * spacing)).astype(np.int64).tolist()
    length = np.linalg.norm(np.diff(way, axis=0), axis=1).sum()
    return frozenset(map(tuple, ends)), round(float(length / (100.0 * CLOSE * spacing)))


def _marked(chain: Chain, places: Floats, close: float) -> Chain:
    """Return a chain with marks at places (n, 2) [m] on it, with further points where it has none."""
    points: list[Floats] = []
    body: list[int] = []
    angle: list[float] = []
    marks: list[int] = []
    for k, (a, b) in enumerate(chain.elements):
        marks += [len(points)] if (np.linalg.norm(places - a, axis=1) <= close).any() else []
        points, angle, body = [*points, a], [*angle, chain.angle[k]], [*body, chain.body[k]]
        length = float(np.linalg.norm(b - a))
        along = (places - a) @ (b - a) / length
        on = (np.abs(cross(b - a, places - a)) <= close * length) & (along > close) & (along < length - close)
        for t in np.sort(along[on]):
            if np.linalg.norm(points[-1] - (a + t / length * (b - a))) > close:
                marks.append(len(points))
                points, angle, body = [*points, a + t / length * (b - a)], [*angle, np.pi], [*body, chain.body[k]]
    if not chain.closed:
        points, angle = [*points, chain.points[-1]], [*angle, chain.angle[-1]]
    return Chain(np.array(points), np.array(body), np.array(angle), chain.closed, tuple(marks))


def _rims(case: Scene, group: _Group, fluid: Callable[[Floats], Flags]) -> tuple[list[Rim], Callable[[Floats], Flags]]:
    """Return the upper end of a front or back of the container, and the function that says where it is."""
    lines = [chain for chain in group.chains if not chain.closed]
    if not lines:
        return [], fluid
    if len(lines) > 1:
        raise CaseError("walls: the front and the back of a 3D scene need one bed from end to end, and the bodies at "
                        f"rest make {len(lines)}; join them, or give a Tank")
    first, last = lines[0].points[0], lines[0].points[-1]
    top = front_top(case, group.walls)
    path = [last, np.array([last[0], top]), np.array([first[0], top]), first]
    path = [path[0], *(b for a, b in zip(path, path[1:]) if np.linalg.norm(b - a) > CLOSE * case.numerics.spacing)]
    nodes = [_line(a, b, case.numerics.spacing) for a, b in zip(path, path[1:])]
    outline = np.concatenate([lines[0].points, np.array(path[1:-1]).reshape(-1, 2)])
    rim = Rim(np.concatenate([*(line[:-1] for line in nodes), first[None]]))
    return [rim], lambda x: _inside(outline, x) & fluid(x)


def front_top(case: Scene, walls: Sequence[Wall]) -> float:
    """Return the height [m] of the front and the back of a 3D scene: that of the walls, and above a Profile's water.

    walls : of the container and others at rest in it, in the section
    """
    points = np.concatenate([solid_of(wall).points for wall in walls])
    ends = [solid_of(wall).points[k, -1] for wall in walls if not solid_of(wall).closed for k in (0, -1)]
    top, s = float(max(ends, default=points[:, -1].max())), case.numerics.spacing
    if not isinstance(container(case), Tank):
        level = max(highest(case, fluid) for fluid in case.fluids)
        top = max(top, level + FREE * (level - float(case.fluid_bounds[0][-1])))
    solids = [float(solid_of(wall).points[:, -1].max()) for wall in walls if solid_of(wall).closed]
    over = max(solids, default=-np.inf)
    return over + OVER * s if over > top - FREE * s else top


def _line(a: Floats, b: Floats, spacing: float) -> Floats:
    many = max(round(float(np.linalg.norm(b - a)) / spacing), 1)
    found: Floats = a + np.arange(many + 1)[:, None] / many * (b - a)
    return found


def _inside(outline: Floats, x: Floats) -> Flags:
    """Return which points x (n, 2) [m] are in a polygon with the corners outline (m, 2) [m]."""
    found: Flags = np.zeros(len(x), dtype=bool)
    for a, b in zip(outline, np.roll(outline, -1, axis=0)):
        if a[1] != b[1]:
            at = a[0] + (x[:, 1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
            found ^= ((a[1] > x[:, 1]) != (b[1] > x[:, 1])) & (x[:, 0] < at)
    return found
