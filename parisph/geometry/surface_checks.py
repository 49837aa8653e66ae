"""Checks of the Surfaces of a scene: their size and place, and what is too thin or too fine for the spacing."""

from collections.abc import Iterator

import numpy as np

from parisph.base.arrays import Flags, Floats, Ints
from parisph.base.errors import CaseError
from parisph.base.text import point, rounded_down
from parisph.case.bodies import Flap, Piston, motion_of
from parisph.case.motion import AtRest, Motion
from parisph.case.scene import Scene
from parisph.case.scenery import body_names
from parisph.case.surface_body import Surface
from parisph.geometry.distance import nearest, unit_normals
from parisph.geometry.inside import floors
from parisph.geometry.mesh import WallMesh
from parisph.geometry.scene_room import is_known, room_mesh, scene_room, under
from parisph.geometry.surface_files import Triangles, crossing, read

LARGE = 20.0     # sizes of the scene: a larger solid is probably in another unit
GAP = 2.0        # spacings that flow between two walls needs, and between two sides of a wall
FACING = -0.7    # cosine between the normals of walls that face each other
BESIDE = 0.6     # spacings: elements this far apart along the wall are opposite each other
SEEN = 20        # spacings: walls farther apart are no gap
TOUCH = 0.3      # spacings: walls nearer than this should overlap
FOOT = 1.0       # spacings: what a wavemaker has nearer to a bed stands on it
INSIDE = 0.25    # spacings: a wall this far inside a solid has run into it, as in geometry.encounters
MOST = 200       # times at which a moving body is looked at


def faults(case: Scene) -> list[str]:
    """Return the faults of the Surfaces of a scene, one line each with a remedy. Not collective."""
    if not case.surfaces or is_known(case):
        return []
    found: list[str] = []
    for surface in case.surfaces:
        try:
            found += _misplaced(case, surface, read(surface))
        except CaseError as error:
            found.append(str(error))
    if not found:
        try:
            found += _run_into(case, room_mesh(case))
        except CaseError as error:
            found.append(str(error))
    return found


def warnings(case: Scene) -> list[str]:
    """Return what was mended, and what is too thin or too fine for the spacing, one line each."""
    if not case.surfaces or is_known(case):
        return []
    found = [note for surface in case.surfaces for note in read(surface).notes]
    return [*found, *_vast(case), *_crossings(case), *_lost(case), *_thin(case)]


def thinnest_gap(case: Scene) -> tuple[float, tuple[str, str], Floats]:
    """Return the least distance [m] across fluid between a Surface and a wall, both names, and the place (3,) [m].

    The distance is inf if none is nearer than SEEN spacings. Not collective. Raises CaseError.
    """
    # other scenes do not load it
    from scipy.spatial import cKDTree

    s, mesh = case.numerics.spacing, room_mesh(case)
    corners = mesh.corners()
    middle, normal = corners.mean(axis=1), unit_normals(corners)
    own = np.flatnonzero(mesh.element_body >= len(mesh.bodies) - len(case.surfaces))
    walls = cKDTree(middle)
    for k in range(SEEN):    # what is opposite by k to k + 1 spacings is in a ball around the middle between them
        ball = cKDTree(middle[own] + (k + 0.5) * s * normal[own])
        near = ball.sparse_distance_matrix(walls, float(np.hypot(0.5, BESIDE)) * s, output_type="ndarray")
        one, other = own[near["i"]], near["j"]
        ahead = _opposite(middle, normal, one, other, s, 1.0)
        ahead[ahead > (k + 1) * s] = np.inf
        if np.isfinite(ahead).any():
            pair = [at[np.argmin(ahead)] for at in (one, other)]
            names = [mesh.bodies[number].name for number in mesh.element_body[pair]]
            return float(ahead.min()), (names[0], names[1]), middle[pair].mean(axis=0)
    return np.inf, ("", ""), np.zeros(3)


def _opposite(middle: Floats, normal: Floats, one: Ints, other: Ints, spacing: float, side: float) -> Floats:
    """Return the distances (n,) [m] of elements that face each other, inf for other pairs.

    side : 1 across the fluid, -1 through the solid
    """
    facing = np.sum(normal[one] * normal[other], axis=1) < FACING
    way = middle[other] - middle[one]
    ahead, back = side * np.sum(way * normal[one], axis=1), -side * np.sum(way * normal[other], axis=1)
    beside = np.linalg.norm(way - side * ahead[:, None] * normal[one], axis=1) < BESIDE * spacing
    found: Floats = np.where(facing & beside & (ahead > 0.0) & (back > 0.0), ahead, np.inf)
    return found


def _vast(case: Scene) -> Iterator[str]:
    """Open beds that are probably in another unit. Those that are too small do not cover the scene."""
    lower, upper = case.wall_bounds or (np.zeros(3), np.zeros(3))
    for surface in case.surfaces:
        bed = read(surface)
        times = float(np.ptp(bed.points, axis=0).max() / np.max(upper - lower))
        if not bed.closed and times > LARGE:
            yield (f"walls, {surface.name}: is {times:.3g} times as large as the scene, and cut by it; give "
                   f"scale={0.001 * surface.scale:g} if its file is in mm")


def _misplaced(case: Scene, surface: Surface, triangles: Triangles) -> Iterator[str]:
    lower, upper = case.wall_bounds or (np.zeros(3), np.zeros(3))
    low, high = triangles.points.min(axis=0), triangles.points.max(axis=0)
    size, scene, s = float(np.max(high - low)), float(np.max(upper - lower)), case.numerics.spacing
    what = f"walls, {surface.name}: reaches from {point(low)} to {point(high)} m"
    unit = f"scale={0.001 * surface.scale:g} if its file is in mm"
    if triangles.closed and size > LARGE * scene:
        yield (f"{what}, {size / scene:.3g} times the size of the scene, which reaches from {point(lower)} to "
               f"{point(upper)}; give {unit}")
    elif np.any(high < lower) or np.any(low > upper):
        yield f"{what}: lies outside the scene, from {point(lower)} to {point(upper)}; move it by at=, or give {unit}"
    elif size < s:
        yield (f"{what}: is smaller than a spacing, {s:g} m, and would be left out; use a smaller spacing, or give "
               f"scale={1000.0 * surface.scale:g} if its file is in km")
    elif not triangles.closed:
        yield from _bare(case, surface, triangles)


def _bare(case: Scene, surface: Surface, bed: Triangles) -> Iterator[str]:
    """Places of the plan that an open surface does not cover."""
    (left, front, _), (right, back, _) = case.wall_bounds or (np.zeros(3), np.zeros(3))
    s, above = case.numerics.spacing, float(bed.points[:, 2].max()) + 1.0
    axes = [np.linspace(a + 0.02 * s, b - 0.02 * s, max(int((b - a) / s), 1) + 1) for a, b in ((left, right),
                                                                                              (front, back))]
    plan = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
    bare = plan[floors(np.insert(plan, 2, above, axis=1), bed.places, s) == 0]
    if len(bare):
        low, high = bed.points.min(axis=0), bed.points.max(axis=0)
        yield (f"walls, {surface.name}: is open, a bed with fluid above it, but has none below {len(bare):,} of "
               f"{len(plan):,} places of the scene, the first at {point(bare[0])}: it must cover x from {left:g} to "
               f"{right:g} and y from {front:g} to {back:g}, and reaches from {point(low[:2])} to {point(high[:2])}; "
               "extend it, make the scene smaller, or close it if it is a solid")


def _run_into(case: Scene, mesh: WallMesh) -> Iterator[str]:
    """Bodies that move into a Surface. What is inside it at the start, as the foot of a flap, does not count.

    Nor does what a wavemaker has near an open bed: its foot stands on it.
    """
    moving = [(name, body) for name, body in zip(body_names(case.bodies), case.bodies)
              if not isinstance(motion_of(body), AtRest)]
    s = case.numerics.spacing
    for surface in case.surfaces if moving else ():
        if surface.side == "inside":
            continue
        found = read(surface)
        solid = found.places
        if not found.closed:
            points, corners = under(case, surface, found)
            solid = points[corners]
        for name, body in moving:
            x = mesh.x0[mesh.body == [own.name for own in mesh.bodies].index(name)]
            free = ~_deep(x, solid, s)
            if not found.closed and isinstance(body, (Piston, Flap)):
                free &= np.isinf(nearest(x, found.places, within=FOOT * s)[0])
            yield from _met(motion_of(body), x[free], solid, case, f"walls, {name}", surface.name)


def _met(motion: Motion, x: Floats, solid: Floats, case: Scene, where: str, name: str) -> Iterator[str]:
    """The first time at which points x (n, 3) [m] of a body are in a solid of triangles (M, 3, 3) [m]."""
    times = motion.instants(case.end_time)
    for t in times[:: 1 + len(times) // MOST].tolist():
        reached = motion.placed(x, t)
        reached = reached[_deep(reached, solid, case.numerics.spacing)]
        if len(reached):
            yield (f"{where}: its {type(motion).__name__} brings it into {name} at t = {t:.3g} s, at "
                   f"{point(np.round(reached[0], 6))}; must stay clear of it: move less far, or move one of them")
            return


def _deep(x: Floats, solid: Floats, spacing: float) -> Flags:
    """Return which points x (n, 3) [m] are in a solid of triangles (M, 3, 3) [m], (n,) bool.

    They are farther than INSIDE spacings from its surface.
    """
    found: Flags = floors(x, solid, spacing) != 0
    found[found] = np.isinf(nearest(x[found], solid, within=INSIDE * spacing)[0])
    return found


def _crossings(case: Scene) -> Iterator[str]:
    for surface in case.surfaces:
        many, at = crossing(surface)
        if many:
            yield (f"walls, {surface.name}: {many:,} triangles of the file cross others, the first at {point(at)}; the "
                   "solid may be wrong there: repair it, for instance with MeshLab, or compare the picture of "
                   "`parisph check`")


def _lost(case: Scene) -> Iterator[str]:
    lost = scene_room(case).lost
    if len(lost):
        yield (f"walls: {len(lost):,} points of surfaces are more than 0.3 spacings from the mesh, the first at "
               f"{point(lost[0])}: details smaller than the spacing are lost; use a smaller one if they matter")


def _thin(case: Scene) -> Iterator[str]:
    """Fluid between walls, and walls between fluid, thinner than GAP spacings, one of them a Surface's."""
    # other scenes do not load it
    from scipy.spatial import cKDTree

    s, mesh = case.numerics.spacing, room_mesh(case)
    corners = mesh.corners()
    middle, normal = corners.mean(axis=1), unit_normals(corners)
    first = len(mesh.bodies) - len(case.surfaces)
    pairs = cKDTree(middle).query_pairs(GAP * s, output_type="ndarray")
    pairs = pairs[np.any(mesh.element_body[pairs] >= first, axis=1)]
    one, other = pairs.T
    for side, text, remedy in ((1.0, "the fluid between them", "let them overlap, or move them apart"),
                               (-1.0, "the solid between two sides", "make it thicker, or leave it out")):
        width = _opposite(middle, normal, one, other, s, side)
        thin = np.isfinite(width)
        if thin.any():
            yield _thinnest(mesh, pairs[thin], width[thin], s, text, remedy)


def _thinnest(mesh: WallMesh, pairs: Ints, width: Floats, spacing: float, text: str, remedy: str) -> str:
    """Return the line about pairs (n, 2) of elements that are too near, at distances width (n,) [m].

    remedy : where they are nearer than TOUCH spacings, and no spacing would be small enough
    """
    k, places = int(np.argmin(width)), len(np.unique(pairs[:, 0]))
    names = " and ".join(dict.fromkeys(mesh.bodies[mesh.element_body[element]].name for element in pairs[k]))
    least = float(width[k])
    if least >= TOUCH * spacing:
        remedy = f"flow is computed well there with a spacing of at most {rounded_down(least / GAP)}"
    return (f"walls, {names}: {text} is less than {GAP:g} spacings thick at {places:,} elements, least at "
            f"{point(np.round(mesh.corners()[pairs[k]].mean(axis=(0, 1)), 6))}, {least:.3g} m or "
            f"{least / spacing:.2g} spacings; {remedy}")
