"""Where probes are on walls of any shape: the element of a tap, the line of a run-up, wrong places (2D)."""

from collections.abc import Iterator, Sequence

import numpy as np

from parisph.case.bodies import Plate
from parisph.case.motion import AtRest
from parisph.case.probes import (
    ColumnHeight,
    Force,
    PressureTap,
    RunUp,
    SurfaceGauge,
    VelocityPoint,
    VelocityProfile,
    singles,
)
from parisph.case.scene import Scene
from parisph.case.scenery import body_names
from parisph.geometry.build import domain
from parisph.geometry.distance import nearest
from parisph.geometry.mesh import WallMesh, area_vectors, wall_mesh
from parisph.geometry.outline import Wall, in_fluid, outline_of

# Sides of a tank: the axis across them, and the sign of the normal into the fluid.
SIDES = {"left": (0, 1.0), "right": (0, -1.0), "bed": (1, 1.0), "lid": (1, -1.0)}
TAP = 0.25      # spacings: a pressure tap this near to a wall is on it, as discs have flat elements
TIE = 1e-6      # spacings: walls nearer to each other than this are at one place
LIFT = 0.1      # spacings: so far in front of a wall its fluid is looked for
FACE = 0.5      # spacings: nodes this near to the plane of a tap lie on its face
FLAT = 1e-9     # of the height of a body: what is no more above or below a node is as high
SQUARE = 0.9    # cosine of the angle between an element's normal and that of the side it belongs to
HEIGHTS = 400   # places along an upright line at which fluid is looked for


def tap_element(mesh: WallMesh, walls: Sequence[Wall], probe: PressureTap, spacing: float) -> int:
    """Return the number of the element that a tap is on, as at t = 0.

    At a plate it is one of the given side; where a wall that moves stands at another, it is one of the first.
    """
    at, corners, allowed = np.array([probe.at]), mesh.corners(), np.ones(len(mesh.elements), dtype=bool)
    for number, wall in enumerate(walls):
        if isinstance(wall, Plate) and probe.side is not None:
            own = np.flatnonzero(mesh.element_body == number)
            allowed[own] = _on_left(corners[own], np.array(wall.points)) == (probe.side == "left")
    allowed = np.flatnonzero(allowed)
    moving = allowed[np.array([body.motion > 0 for body in mesh.bodies])[mesh.element_body[allowed]]]
    apart, element, _ = nearest(at, corners[allowed])
    first, moves, _ = nearest(at, corners[moving], within=apart[0] + TIE * spacing)
    return int(moving[moves[0]] if np.isfinite(first[0]) else allowed[element[0]])


def _on_left(corners, points):
    """Return which elements (M, 2, 2) of a plate are those of its left side, as seen along its points, (M,) bool."""
    piece = nearest(corners.mean(axis=1), np.stack([points[:-1], points[1:]], axis=1))[1]
    along = np.diff(points, axis=0)[piece]
    return np.sum((corners[:, 1] - corners[:, 0]) * along, axis=1) > 0.0


def force_elements(mesh: WallMesh, probe: Force) -> np.ndarray:
    """Return the elements (n, 2) whose pressure a Force adds up: those of its body, or of one side of it."""
    mine = mesh.element_body == [body.name for body in mesh.bodies].index(probe.on)
    if probe.side is not None:
        axis, inward = SIDES[probe.side]
        normal = area_vectors(mesh.corners())
        mine &= inward * normal[:, axis] > SQUARE * np.linalg.norm(normal, axis=1)
    return mesh.elements[mine]


def run_up_line(mesh: WallMesh, number: int, kind: str, side: str | None) -> np.ndarray:
    """Return the nodes (n, 2) [m], as at t = 0, of the line from the lowest place of a body's wall upwards.

    number : of the body; kind : of a case; side : of it, or of a profile the end to which the line goes
    Raises ValueError with what is wrong.
    """
    own = mesh.elements[mesh.element_body == number]
    if not len(own):
        raise ValueError("no fluid touches it; give another wall")
    x = mesh.x0
    if kind == "tank":
        normal = area_vectors(x[own])
        inward = (1.0 if side == "left" else -1.0) * normal[:, 0] > SQUARE * np.linalg.norm(normal, axis=1)
        nodes = np.unique(own[inward])
        path = nodes[np.argsort(x[nodes, 1])]
    elif kind in ("obstacle", "plate"):
        path = _flank(own, x, side == "left")
    else:
        path = np.append(own[:, 0], own[-1, 1])    # with the fluid on the left, from left to right
        if kind == "profile":
            path = path if side == "right" else path[::-1]
        else:
            path = path if x[path[-1], 1] > x[path[0], 1] else path[::-1]
        path = path[_lowest(x[path, 1])[-1]:]
    if len(path) < 2:
        raise ValueError(f"{mesh.bodies[number].name} is lowest at this end; choose the other one")
    return x[path]


def _lowest(y):
    return np.flatnonzero(y <= y.min() + FLAT * np.ptp(y))


def _flank(elements, x, left):
    """Return the nodes from the foot of a body, or its lowest node, along one flank to its highest, in order.

    With the fluid on its left, the way leads up on the left of a body and down on its right.
    """
    ends = elements if left else elements[:, ::-1]
    step = dict(ends.tolist())
    nodes = np.unique(elements)
    feet = nodes[~np.isin(nodes, ends[:, 1])]
    feet = feet if len(feet) else nodes
    low = feet[_lowest(x[feet, 1])]
    path = [int(low[np.argmin(x[low, 0]) if left else np.argmax(x[low, 0])])]
    while path[-1] in step and step[path[-1]] != path[0]:
        path.append(step[path[-1]])
    y = x[path, 1]
    return np.array(path[: int(np.argmax(y >= y.max() - FLAT * np.ptp(y))) + 1])


def faults(case: Scene, walls: tuple[Wall, ...]) -> Iterator[str]:
    """Yield the probes of a scene that is not plain that are not on a wall, or where no fluid comes."""
    mesh, s = (wall_mesh(walls, case.numerics.spacing) if walls else None), case.numerics.spacing
    outlines = [outline_of(wall) for wall in walls]
    resting = [outline for outline, wall in zip(outlines, walls) if isinstance(wall.motion, AtRest)]
    probes = list(singles(case.probes))
    upright = any(isinstance(probe, (SurfaceGauge, ColumnHeight)) for _, probe in probes)
    heights = _heights(case) if upright else np.empty(0)
    for name, probe in probes:
        what = f"probe {name!r}"
        if isinstance(probe, PressureTap) and mesh is not None:
            yield from _tap(case, probe, what, mesh, walls)
        elif isinstance(probe, Force) and mesh is not None:
            if not len(force_elements(mesh, probe)):
                side = "" if probe.side is None else f"the {probe.side} side of "
                yield f"{what}: no fluid touches {side}{probe.on}; choose another side or body, or leave the probe out"
        elif isinstance(probe, RunUp) and mesh is not None:
            yield from _run_up(case, probe, what, mesh, outlines)
        elif isinstance(probe, (SurfaceGauge, ColumnHeight)) and not _has_room(outlines, heights, probe.at, s):
            yield f"{what}: at = {probe.at:g}: there is no room for fluid above or below it; move it"
        elif isinstance(probe, VelocityProfile) and not in_fluid(outlines, probe.places).any():
            yield f"{what}: no point from {probe.start} to {probe.end} is in front of the walls; move it"
        elif isinstance(probe, VelocityPoint):
            around = TIE * s * np.array([(0, 0), (1, 1), (-1, 1), (1, -1), (-1, -1)])    # it may be at a wall
            if not in_fluid(resting, probe.at + around).any():
                yield f"{what}: at = {probe.at} is not in front of the walls, where fluid comes; move it"


def _tap(case: Scene, probe: PressureTap, what: str, mesh: WallMesh, walls: tuple[Wall, ...]) -> Iterator[str]:
    s, at = case.numerics.spacing, np.array([probe.at])
    element = tap_element(mesh, walls, probe, s)
    number = mesh.element_body[element]
    name, plate = mesh.bodies[number].name, isinstance(walls[number], Plate)
    corners = mesh.corners()[[element]]
    apart, _, foot = nearest(at, corners)
    normal = area_vectors(corners)[0]
    normal /= np.linalg.norm(normal)
    if apart[0] > TAP * s:
        yield (f"{what}: at = {probe.at} is not on a wall; the nearest place on one is "
               f"({foot[0, 0]:.6g}, {foot[0, 1]:.6g}) on {name}")
    elif plate and probe.side is None:
        yield (f'{what}: {name} has two sides; give side="left" or side="right", as seen along its points from '
               f"{walls[number].points[0]} to {walls[number].points[-1]}")
    elif not plate and probe.side is not None:
        yield f"{what}: side = {probe.side!r}: only a plate has two sides, {name} has one; leave it out"
    else:
        before = foot + LIFT * s * normal
        hidden = [wall.name for wall in walls if not in_fluid([outline_of(wall)], before)[0]]
        if hidden:
            yield f"{what}: at = {probe.at} is behind {hidden[0]}, where no fluid comes; move it"
        elif probe.diameter is not None and not _on_face(mesh, element, foot[0], normal, 0.5 * probe.diameter, s):
            yield (f"{what}: a disc of diameter = {probe.diameter:g} around {probe.at} does not lie on one wall; "
                   "move it away from the corner, or give a smaller one")


def _on_face(mesh, element, at, normal, radius, spacing):
    """Return whether the wall is as good as flat as far as the radius [m] to both sides of a place on it."""
    corners, along = mesh.corners() - at, np.array([-normal[1], normal[0]])
    motion = np.array([body.motion for body in mesh.bodies])[mesh.element_body]
    own = (np.abs(corners @ normal) < FACE * spacing).all(axis=1) & (area_vectors(corners) @ normal > 0.0)
    ends = np.sort((corners @ along)[own & (motion == motion[element])], axis=1)
    low = high = 0.0
    for _ in range(len(ends)):    # as far as elements join on
        joined = (ends[:, 0] <= high + TIE * spacing) & (ends[:, 1] >= low - TIE * spacing)
        if not joined.any() or (ends[joined, 0].min() >= low and ends[joined, 1].max() <= high):
            break
        low, high = min(low, ends[joined, 0].min()), max(high, ends[joined, 1].max())
    return min(high, -low) >= radius - TIE * spacing


def _run_up(case: Scene, probe: RunUp, what: str, mesh: WallMesh, outlines: Sequence) -> Iterator[str]:
    names, s = body_names(case.bodies), case.numerics.spacing
    if probe.points is not None:
        points, corners = np.array(probe.points, dtype=float), mesh.corners()
        for number, body in enumerate(mesh.bodies):
            apart = nearest(points, corners[mesh.element_body == number], within=s)[0]
            if body.motion and probe.on != body.name and np.isfinite(apart).all():
                yield (f"{what}: its points lie on {body.name}, which moves; give on={body.name!r} for the line to "
                       "move with it")
        return
    number = names.index(probe.on)
    try:
        run_up_line(mesh, number, case.bodies[number].kind, probe.side)
    except ValueError as error:
        side = "" if probe.side is None else f", side = {probe.side!r}"
        yield f"{what}: on = {probe.on!r}{side}: {error}"
        return
    if case.bodies[number].kind == "tank":
        own = mesh.corners()[mesh.element_body == number]
        normal = area_vectors(own)
        normal /= np.linalg.norm(normal, axis=1)[:, None]
        own, normal = (part[(1.0 if probe.side == "left" else -1.0) * normal[:, 0] > SQUARE] for part in (own, normal))
        if not in_fluid(outlines, own.mean(axis=1) + LIFT * s * normal).any():
            yield (f"{what}: no fluid comes to the {probe.side} side of {probe.on}, which is behind another body; "
                   "give on= the name of that body")


def _heights(case: Scene) -> np.ndarray:
    """Return heights (HEIGHTS,) [m] from the bottom to the top of the scene."""
    lower, upper = domain(case)
    heights: np.ndarray = np.linspace(lower[1], max(upper[1], case.fluid_bounds[1][1]), HEIGHTS)
    return heights


def _has_room(outlines: Sequence, heights: np.ndarray, x: float, spacing: float) -> bool:
    beside = 0.01 * spacing    # it may be at a wall
    return any(in_fluid(outlines, np.stack([np.full(len(heights), at), heights], axis=1)).any()
               for at in (x - beside, x + beside))
