"""Faults and warnings of a scene's geometry, one sentence each, for `parisph check` (2D)."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from heapq import merge
from operator import itemgetter

import numpy as np

from parisph.base.arrays import Floats, Ints
from parisph.base.text import rounded_down
from parisph.case.bodies import Obstacle, Plate, Profile, StillWater
from parisph.case.ellipsoid import AnyShape
from parisph.case.lattice import FIT
from parisph.geometry.distance import across, area_vectors, nearest, on_segments, unit_normals
from parisph.geometry.encounters import distance_between
from parisph.geometry.fill import Filling, taken
from parisph.geometry.mesh import WallMesh, chains_of, motion_numbers, stretches, wall_mesh
from parisph.geometry.polygons import Chain
from parisph.geometry.solid import Solid, Wall, in_fluid, outline_of, signed_area, solid_of, way_beyond
from parisph.geometry.tips import Filled

GAP = 2.0        # spacings: in a narrower gap each particle is beside both walls
THIN = 0.1       # spacings: the front and the back of a thinner solid cannot be told apart
WEDGE = 15.0     # degrees: in a sharper corner particles see too little fluid
FLAT = 10.0      # degrees: on a flatter slope, the tip of the water is one particle deep over many spacings
RESTLESS = ", and waves that reach it may gain energy; to absorb them, use a Sponge instead of the slope"
POINTED = np.radians(210.0)    # angle of the fluid: walls see past a blunter corner what it faces
SHORT = 0.6      # spacings: a shorter element crowds its nodes
ROUNDING = 1e-6  # of a length: values that a message proposes are accepted


def faults(walls: tuple[Wall, ...], fluids: Sequence[AnyShape | StillWater], spacing: float,
           holes: Sequence[Sequence[AnyShape]], titles: Sequence[str]) -> list[str]:
    """Return the faults of a scene that cannot be computed, each with a remedy. The same on all ranks.

    walls : Tank, Profile, Obstacle and Plate; fluids : Box, Disc, Polygon and StillWater; spacing : [m]
    holes : of each body of fluid; titles : their names in messages
    """
    if walls and not chains_of(walls, spacing):
        return ["no wall touches fluid: each body lies inside another"]
    found = []
    if walls:
        chains, mesh = chains_of(walls, spacing), wall_mesh(walls, spacing)
        names = [body.name for body in mesh.bodies]
        clear = [*_turned_in(walls, names), *_thin(walls, names, spacing), *_parted(walls, names, spacing)]
        if clear:    # further messages about these walls would mislead
            return clear
        found += [*_hidden(chains, walls, names), *_open_ends(chains, mesh, walls, fluids, spacing)]
    return [*found, *_filled(walls, fluids, spacing, holes, titles)]


def warnings(walls: tuple[Wall, ...], fluids: Sequence[AnyShape | StillWater], spacing: float) -> list[str]:
    """Return what will be computed with larger errors, one sentence each; arguments as of `faults`."""
    chains, mesh = chains_of(walls, spacing), wall_mesh(walls, spacing)
    names = [body.name for body in mesh.bodies]
    return [*_wedges(chains, names), *_beaches(mesh, names, fluids),
            *_narrow(*resting(mesh, chains), walls, names, spacing), *_short(chains, walls, names, spacing)]


def resting(mesh: WallMesh, chains: Sequence[Chain]) -> tuple[WallMesh, list[Chain]]:
    """Return the mesh with only the elements of bodies at rest, and the chains of these bodies."""
    rests = np.array([body.motion == 0 for body in mesh.bodies])
    keep = rests[mesh.element_body]
    return (replace(mesh, elements=mesh.elements[keep], element_body=mesh.element_body[keep]),
            [chain for chain in chains if rests[chain.body].all()])


def thinnest_gap(mesh: WallMesh, chains: Sequence[Chain], walls: Sequence[Wall] = ()) -> tuple[float, Floats, int, int]:
    """Return the least distance [m] across fluid between walls that do not join there, its place, and the two bodies.

    It is measured along the normal from the middle of each element, and from corners that point into the fluid, such
    as the end of a Plate. Returns (inf, nan, -1, -1) if no wall faces another.
    walls : bodies beside a Filled among them are left out, as their distance falls with the spacing
    """
    if chains and len(mesh.elements):
        pieces, owner = (np.concatenate(parts) for parts in zip(*((chain.elements, chain.body) for chain in chains)))
        middle, way = mesh.corners().mean(axis=1), unit_normals(mesh.corners())
        filled = {number: wall.beside for number, wall in enumerate(walls) if isinstance(wall, Filled)}
        gap, piece = across(middle, way, pieces)
        faced = ((float(gap[k]), middle[k] + 0.5 * gap[k] * way[k], int(mesh.element_body[k]), int(owner[piece[k]]))
                 for k in np.argsort(gap, kind="stable")[: np.count_nonzero(np.isfinite(gap))]
                 if not _meet(pieces, piece[k], middle[k]))
        pointed = sorted(_before_corners(chains, pieces, owner), key=itemgetter(0))
        for found in merge(faced, pointed, key=itemgetter(0)):
            pair = found[2:]
            if not any(number in pair or set(pair) == set(own) for number, own in filled.items()):
                return found
    return np.inf, np.full(2, np.nan), -1, -1


def _before_corners(chains: Sequence[Chain], pieces: Floats, owner: Ints) -> Iterator[tuple[float, Floats, int, int]]:
    """Yield, as of `thinnest_gap`, the least distance from each corner that points into the fluid to a facing piece."""
    normal = unit_normals(pieces)
    for chain in chains:
        for k in np.flatnonzero(chain.angle > POINTED):
            x, sides = chain.points[k], chain.points[[k - 1, (k + 1) % len(chain.points)]] - chain.points[k]
            way = on_segments(x, pieces[:, 0], pieces[:, 1]) - x
            ahead = (way @ sides.T <= ROUNDING * np.linalg.norm(way, axis=1)[:, None] * np.linalg.norm(sides, axis=1)
                     ).all(axis=1) & (np.sum(way * normal, axis=1) < 0.0)
            if ahead.any():
                gap = np.where(ahead, np.linalg.norm(way, axis=1), np.inf)
                near = int(np.argmin(gap))
                yield float(gap[near]), x + 0.5 * way[near], int(chain.body[k % len(chain.body)]), int(owner[near])


def _meet(pieces: Floats, piece: int, m: Floats) -> bool:
    """Return whether a piece shares an end with the one through the place m: they form a wedge, not a gap."""
    a, b = pieces[:, 0], pieces[:, 1]
    own = np.argmin(np.linalg.norm(m - on_segments(m, a, b), axis=1))
    close = 1e-6 * np.linalg.norm(b[own] - a[own])
    return bool((np.linalg.norm(a[own] - b[piece]) < close) or (np.linalg.norm(b[own] - a[piece]) < close))


def _at(x: Floats) -> str:
    return f"({x[0]:g}, {x[1]:g})"


def _thin(walls: Sequence[Wall], names: Sequence[str], spacing: float) -> Iterator[str]:
    """Solids too thin to tell their inside from the fluid."""
    for wall, name in zip(walls, names):
        if isinstance(wall, Obstacle) and not isinstance(wall, Filled):
            thick = _thickness(solid_of(wall))
            if thick < (1.0 - ROUNDING) * THIN * spacing:
                yield (f"walls, {name}: is {thick:.2g} m thick, {thick / spacing:.2g} spacings, must be at least "
                       f"{THIN:g}, {THIN * spacing:.2g} m; give a Plate, which has no thickness, make it thicker, or "
                       f"use a spacing of at most {rounded_down(thick / THIN)}")


def _thickness(outline: Solid) -> float:
    """Return the shorter side [m] of the rectangle with the area and the circumference of an outline."""
    quarter = 0.25 * float(np.linalg.norm(area_vectors(outline.elements), axis=1).sum())
    return quarter - math.sqrt(max(quarter**2 - abs(signed_area(outline.points)), 0.0))


def _parted(walls: Sequence[Wall], names: Sequence[str], spacing: float) -> Iterator[str]:
    """Profiles with a shared end or in one line, each behind the continuation of the other."""
    profiles = [(wall, name, solid_of(wall).points) for wall, name in zip(walls, names) if isinstance(wall, Profile)]
    for number, (wall, name, one) in enumerate(profiles):
        for beside, also, other in profiles[number + 1 :]:
            pairs = [(p, q) for p in (one, one[::-1]) for q in (other, other[::-1])] if (
                wall.motion == beside.motion) else []
            for (end, back), (start, on) in ((p[:2], q[:2]) for p, q in pairs):
                if np.linalg.norm(start - end) < 1e-6 * spacing:
                    middles = 0.5 * np.array([[end + on], [start + back]])
                    if not all(solid_of(w).in_front(x)[0] for w, x in zip((wall, beside), middles)):
                        yield (f"walls, {name} and {also}: both end at {_at(end)}, and each goes on straight beyond "
                               "its end, where the other lies; give them as one Profile, or correct the side of their "
                               "fluid")
                elif _in_line(end - back, start - end, spacing) and _in_line(end - back, on - end, spacing):
                    yield (f"walls, {name} and {also}: they lie in one line with a gap from {_at(end)} to "
                           f"{_at(start)}; give them as one Profile")


def _in_line(way: Floats, other: Floats, spacing: float) -> bool:
    """Return whether two directions (2,) [m] are the same."""
    across = abs(way[0] * other[1] - way[1] * other[0])
    return bool(across < 1e-6 * spacing * np.linalg.norm(way) and way @ other > 0.0)


def _hidden(chains: Sequence[Chain], walls: Sequence[Wall], names: Sequence[str]) -> Iterator[str]:
    seen = set(np.concatenate([chain.body for chain in chains]).tolist())
    for number, (wall, name) in enumerate(zip(walls, names)):
        if number not in seen and not isinstance(wall, Filled):
            yield f"{name}: no fluid touches it, because it lies inside or behind another body; leave it out or move it"


def _turned_in(walls: Sequence[Wall], names: Sequence[str]) -> Iterator[str]:
    """Profiles whose continuation beyond their ends always crosses them."""
    for wall, name in zip(walls, names):
        if isinstance(wall, Profile) and way_beyond(solid_of(wall).points) is None:
            yield (f"walls, {name}: its ends lead back to it, so that neither side is outside; lead both ends up above "
                   "the water beside each other, or give an Obstacle(Polygon(...)), which is closed")


def _wedges(chains: Sequence[Chain], names: Sequence[str]) -> Iterator[str]:
    for chain in chains:
        for k in np.flatnonzero(np.degrees(chain.angle) < (1.0 - ROUNDING) * WEDGE):
            body = names[chain.body[min(k, len(chain.body) - 1)]]
            yield (f"{body}: at {_at(chain.points[k])} the fluid ends in a wedge of "
                   f"{np.degrees(chain.angle[k]):.1f} degrees; below {WEDGE:g} its tip is not resolved at any spacing")


def shores(mesh: WallMesh, levels: Sequence[float]) -> list[tuple[float, Floats, int]]:
    """Return where walls below fluid cross levels [m]: angle between both [degrees], place (2,) [m], and body."""
    corners, found = mesh.corners(), []
    normal = area_vectors(corners)
    for level in levels:
        low, high = corners[:, :, 1].min(axis=1), corners[:, :, 1].max(axis=1)
        for k in np.flatnonzero((low < level) & (high >= level) & (normal[:, 1] > 0.0)):
            a, b = corners[k]
            t = (level - a[1]) / (b[1] - a[1])
            found.append((float(np.degrees(np.arctan2(abs(b[1] - a[1]), abs(b[0] - a[0])))), a + t * (b - a),
                          int(mesh.element_body[k])))
    return found


def _beaches(mesh: WallMesh, names: Sequence[str], fluids: Sequence[AnyShape | StillWater]) -> Iterator[str]:
    levels = [fluid.level for fluid in fluids if isinstance(fluid, StillWater)]
    for angle, at, body in shores(mesh, levels):
        if angle < (1.0 - ROUNDING) * WEDGE:
            yield (f"{names[body]}: at {_at(at)} the water ends in a wedge of {angle:.1f} degrees; below {WEDGE:g} its "
                   f"tip is not resolved at any spacing{RESTLESS if angle <= FLAT else ''}")


def _narrow(mesh: WallMesh, chains: Sequence[Chain], walls: Sequence[Wall], names: Sequence[str],
            spacing: float) -> Iterator[str]:
    gap, at, one, other = thinnest_gap(mesh, chains, walls)
    if gap < GAP * spacing:
        between = f"{names[one]} and {names[other]}" if one != other else f"two walls of {names[one]}"
        yield (f"the gap between {between} at {_at(at)} is {gap:g} m, {gap / spacing:.2g} spacings: flow through it "
               f"needs {GAP:g}; use a spacing of at most {rounded_down(gap / GAP)}, or close it")


def _short(chains: Sequence[Chain], walls: Sequence[Wall], names: Sequence[str], spacing: float) -> Iterator[str]:
    """Edges between corners that are shorter than SHORT; the shortest of each body."""
    least: dict[int, tuple[float, Floats]] = {}
    for chain in chains:
        for start, way in stretches(chain):
            body, pieces = int(chain.body[start % len(chain.body)]), len(chain.body)
            beside = [chain.body[k % pieces] for k in (start - 1, start, start + len(way) - 1)]
            if any(isinstance(walls[k], Filled) for k in beside):    # cut by a filled tip
                continue
            length = float(np.linalg.norm(np.diff(way, axis=0), axis=1).sum())
            if length < least.get(body, (SHORT * spacing, None))[0]:
                least[body] = length, 0.5 * (way[0] + way[-1])
    for body, (length, at) in sorted(least.items()):
        yield (f"{names[body]}: an edge of {length:.3g} m at {_at(at)} is shorter than {SHORT:g} spacings; leave out "
               f"the step, or use a spacing of at most {rounded_down(length / SHORT)}")


def _open_ends(chains: Sequence[Chain], mesh: WallMesh, walls: Sequence[Wall], fluids: Sequence[AnyShape | StillWater],
               spacing: float) -> Iterator[str]:
    """Open ends of walls below the top of the fluid, through which it would leave.

    Moving bodies may have gaps beside them, as there is no fluid behind them.
    """
    tops = [fluid.level if isinstance(fluid, StillWater) else fluid.bounds[1][1] for fluid in fluids]
    top = max(tops, default=-np.inf)
    moving = np.array(motion_numbers(walls)) != 0
    movers = [wall for wall, moves in zip(walls, moving) if moves]
    for chain in chains:
        if chain.closed or moving[chain.body].any():
            continue
        for k, body in ((0, chain.body[0]), (-1, chain.body[-1])):
            end = chain.points[k]
            near = any(isinstance(fluid, StillWater) or fluid.inside(end[None], 1.5 * spacing)[0] for fluid in fluids)
            beside = near and in_fluid(movers, end[None])[0]
            if end[1] < top - 1e-6 * spacing and beside:
                yield (f"{mesh.bodies[body].name}: it ends in the fluid at {_at(end)}, {top - end[1]:g} m below its "
                       "top; extend it above the water, or end it on another body")


def _filled(walls: Sequence[Wall], fluids: Sequence[AnyShape | StillWater], spacing: float,
            holes: Sequence[Sequence[AnyShape]], titles: Sequence[str]) -> Iterator[str]:
    """Bodies of fluid without particles, or separated by less than a spacing."""
    for number, (fluid, own, title) in enumerate(zip(fluids, holes, titles)):
        if isinstance(fluid, StillWater) and not walls:
            yield f"{title}: still water at level {fluid.level:g}: there are no walls around it; give walls, or a Box"
            continue
        if isinstance(fluid, StillWater) and any(isinstance(other, StillWater) for other in fluids[:number]):
            yield f"{title}: there is still water before it; give one, with the higher level"
            continue
        others = taken(fluids, holes, number)
        fill = Filling(fluid, walls, spacing, own, others)
        if fill.count == 0:
            if own and Filling(fluid, walls, spacing, (), others).count:
                yield f"{title}.holes: they leave none of its particles; make them smaller, or leave this fluid out"
            elif others and Filling(fluid, walls, spacing, own).count:
                yield f"{title} ({fluid.kind}): it has no particles, because it lies in other fluid; leave it out"
            else:
                yield (f"{title} ({fluid.kind}): it has no particles: it is thinner than a spacing, or behind the "
                       "walls; use a smaller spacing, or move it")
        else:
            yield from _slits(walls, fluids, spacing, titles, number)


def _slits(walls: Sequence[Wall], fluids: Sequence[AnyShape | StillWater], spacing: float, titles: Sequence[str],
           number: int) -> Iterator[str]:
    """Bodies of fluid less than a spacing apart: their particles would be too close."""
    fluid = fluids[number]
    if isinstance(fluid, StillWater):
        return
    one = outline_of(fluid)
    for other, title in zip(fluids[:number], titles):
        if isinstance(other, StillWater) or _boxes_apart(fluid, other, spacing):
            continue
        beside = outline_of(other)
        gap, at = distance_between(one, beside)
        at = sum(nearest(at[None], outline.elements)[2][0] for outline in (one, beside)) / 2.0
        within = ~one.in_front(beside.points[:1]) | ~beside.in_front(one.points[:1])
        if not within.any() and FIT * spacing < gap < (1.0 - FIT) * spacing and not _wall_at(walls, at, gap):
            yield (f"{titles[number]} and {title}: they are {gap:.3g} m apart at {_at(at)}, {gap / spacing:.2g} "
                   f"spacings; let them touch, leave a spacing between them, {spacing:g} m, or use a spacing of "
                   f"at most {rounded_down(gap)}")


def _boxes_apart(one: AnyShape, other: AnyShape, spacing: float) -> bool:
    """Return whether the bounding boxes of two shapes are at least a spacing apart."""
    (low, high), (lower, upper) = one.bounds, other.bounds
    return bool(np.any((low > upper + spacing) | (lower > high + spacing)))


def _wall_at(walls: Sequence[Wall], at: Floats, gap: float) -> bool:
    """Return whether a wall lies in the slit of width `gap` [m] at a place (2,) [m]."""
    return not in_fluid(walls, at[None])[0] or any(
        nearest(at[None], solid_of(wall).elements)[0][0] < gap for wall in walls if isinstance(wall, Plate))
