"""Checks of the Surfaces of a scene: their size and place, and what is too thin or too fine for the spacing."""

from collections.abc import Iterator

import numpy as np

from parisph.base.arrays import Flags, Floats, Ints
from parisph.base.errors import CaseError
from parisph.base.text import point, rounded_down
from parisph.case.bodies import motion_of
from parisph.case.motion import AtRest
from parisph.case.scene import Scene
from parisph.case.scenery import body_names
from parisph.case.surface_body import Surface
from parisph.geometry.distance import nearest, unit_normals
from parisph.geometry.inside import floors
from parisph.geometry.mesh import WallMesh
from parisph.geometry.scene_room import is_known, room_mesh, scene_room
from parisph.geometry.surface_files import Triangles, crossing, read

LARGE = 20.0     # sizes of the scene: a larger solid is probably in another unit
GAP = 2.0        # spacings that flow between two walls needs, and between two sides of a wall
FACING = -0.7    # cosine between the normals of walls that face each other
BESIDE = 0.6     # spacings: elements this far apart along the wall are opposite each other
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
    return [*found, *_crossings(case), *_lost(case), *_thin(case)]


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
    """Bodies that move into a closed Surface. What is inside it at the start, as the foot of a flap, does not count."""
    solids = [(one, read(one)) for one in case.surfaces if one.side != "inside" and read(one).closed]
    for name, body in zip(body_names(case.bodies), case.bodies):
        motion = motion_of(body)
        if isinstance(motion, AtRest) or not solids:
            continue
        x = mesh.x0[mesh.body == [own.name for own in mesh.bodies].index(name)]
        times = motion.instants(case.end_time)
        for surface, triangles in solids:
            free = ~_deep(x, triangles, case.numerics.spacing)
            for t in times[:: 1 + len(times) // MOST].tolist():
                reached = motion.placed(x[free], t)
                reached = reached[_deep(reached, triangles, case.numerics.spacing)]
                if len(reached):
                    yield (f"walls, {name}: its {type(motion).__name__} brings it into {surface.name} at t = {t:.3g} "
                           f"s, at {point(np.round(reached[0], 6))}; must stay clear of it: move less far, or move one "
                           "of them")
                    break


def _deep(x: Floats, solid: Triangles, spacing: float) -> Flags:
    """Return which points x (n, 3) [m] are in a solid, and farther than INSIDE spacings from its surface, (n,) bool."""
    found: Flags = floors(x, solid.places, spacing) != 0
    found[found] = np.isinf(nearest(x[found], solid.places, within=INSIDE * spacing)[0])
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
    facing = np.sum(normal[one] * normal[other], axis=1) < FACING
    pairs, way = pairs[facing], (middle[other] - middle[one])[facing]
    one, other = pairs.T
    ahead, back = np.sum(way * normal[one], axis=1), -np.sum(way * normal[other], axis=1)
    beside = np.linalg.norm(way - ahead[:, None] * normal[one], axis=1) < BESIDE * s
    for sign, text in ((1.0, "the fluid between them"), (-1.0, "the solid between two sides")):
        thin = np.flatnonzero(beside & (sign * ahead > 0.0) & (sign * back > 0.0))
        if len(thin):
            yield _thinnest(mesh.bodies, mesh.element_body, pairs[thin], np.abs(ahead[thin]), middle, s, text)


def _thinnest(bodies: tuple[object, ...], body: Ints, pairs: Ints, width: Floats, middle: Floats, spacing: float,
              text: str) -> str:
    """Return the line about pairs (n, 2) of elements that are too near, at distances width (n,) [m]."""
    k, places = int(np.argmin(width)), len(np.unique(pairs[:, 0]))
    names = " and ".join(dict.fromkeys(getattr(bodies[body[element]], "name") for element in pairs[k]))
    least = max(float(width[k]), 1e-3 * spacing)
    return (f"walls, {names}: {text} is less than {GAP:g} spacings thick at {places:,} elements, least at "
            f"{point(np.round(middle[pairs[k]].mean(axis=0), 6))}, {least:.3g} m or {least / spacing:.2g} spacings; "
            f"flow is computed well there with a spacing of at most {rounded_down(least / GAP)}")
