"""From a case to its walls and its particles, for any scene. Not collective, needs no MPI.

Particles are numbered: fluid first, body after body, then the nodes of the wall mesh in their order, so that the
mesh node of a wall particle is its id less the number of fluid particles at the start. A rank makes its own slice, and
looks at the lines of the lattice and at the walls only, of which there are some sqrt(N).
"""

from collections.abc import Iterator, Sequence

import numpy as np

from parisph.base.arrays import Array, Floats, Ints
from parisph.base.errors import CaseError
from parisph.base.fields import CONTACT, DRY, FLUID, INNER, SURFACE, WALL, WET
from parisph.case import size as case_size
from parisph.case.bodies import StillWater
from parisph.case.fluids import Fluid
from parisph.case.lattice import FIT
from parisph.case.motion import Motion, Rotation, course
from parisph.case.scene import Scene
from parisph.case.schema import Case
from parisph.case.shapes import Box, Lid, Tank
from parisph.geometry.fill import Filling, Taken, taken
from parisph.geometry.mesh import CONCAVE, CONVEX, WallMesh, motions_of, wall_mesh
from parisph.geometry.outline import in_fluid, outline_of
from parisph.geometry.plain import lattice, plain_particles, uniform
from parisph.geometry.quadrature import fluid_area
from parisph.geometry.quadrature import samples as samples_of
from parisph.geometry.raised import raised
from parisph.geometry.standing import standing

BESIDE = 0.5    # spacings: a wall node this near to the surface is at the contact line
LIFT = 0.1      # spacings: so far in front of a node its fluid is looked for
TURN = 0.02     # [rad] between two places at which walls that turn are looked at


def scene_mesh(case: Scene) -> WallMesh | None:
    """Return the mesh of all walls of a case, None without walls. Raises CaseError.

    Its nodes are in the frames of their bodies, which is where they are at t = 0: `bodies[k].motion` is the number of
    the motion in `scene_motions`.
    """
    walls = standing(case)
    return wall_mesh(walls, case.numerics.spacing) if walls else None


def scene_motions(case: Scene) -> tuple[Motion, ...]:
    """Return the motions of walls in the frame of the case; number 0 is rest."""
    return motions_of(standing(case))


def build(case: Case, rank: int = 0, size: int = 1) -> dict[str, Array]:
    """Build this rank's slice of the particles at the start.

    Parameters
    ----------
    case : Case
    rank, size : which slice of how many; the particles do not depend on `size`

    Returns
    -------
    dict of arrays: id (n,) int64, fluid first and then walls, in order; kind, corner, role (n,) int8;
    x [m], u [m/s], normal (n, dim); volume (n,) [m^dim] (see Lattice.cells), 0 for walls; p (n,)
    [Pa], zero where the first solve finds it, else that of still water; start_role as role; no_slip (n,) int8, wall_u
    (n, dim) [m/s]. Wall normals are unit vectors into the fluid, in a corner the normalised sum of both walls'.

    In a scene that is not plain, all fluid has the volume of its lattice's cell: `samples` and kernels.packing.volumes
    give that which it stands for. It is not jittered: see `jitter`. All scenes have weight (n,), of fluid its cell over
    s^dim. If there are walls, it is for a node the part of a cell s^dim inside the fluid, area * share / s^(dim-1), and
    there are in addition, as kernels.density takes them: area (n, dim), its vector area over s^(dim-1), 0 for fluid;
    edge (n,) int8 (geometry.mesh); body (n,) int16, the number of the body in the mesh, 0 for fluid.

    Raises
    ------
    CaseError : there is no fluid
    """
    if case.plain:
        return plain_particles(case, rank, size)
    walls = standing(case)
    mesh = wall_mesh(walls, case.numerics.spacing) if walls else None
    fills = fillings(case, walls, mesh)
    n_fluid, n_wall = sum(fill.count for fill in fills), 0 if mesh is None else len(mesh.x0)
    if n_fluid == 0:
        raise CaseError("fluid: there is room for no particle: it is too thin for the spacing, or behind the walls")
    total = n_fluid + n_wall
    start, stop = total * rank // size, total * (rank + 1) // size
    parts, first = [], 0
    for fluid, fill in zip(case.fluids, fills):
        low, high = (int(np.clip(end - first, 0, fill.count)) for end in (start, stop))
        parts.append(_fluid(case, fluid, fill, fills, mesh, low, high))
        first += fill.count
    if mesh is not None:
        nodes = np.arange(max(start - n_fluid, 0), max(stop - n_fluid, 0))
        parts.append(_walls(case, walls, mesh, fills, nodes))
    arrays = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    arrays["id"] = np.arange(start, stop, dtype=np.int64)
    arrays["p"] = np.zeros(stop - start)
    arrays["start_role"] = arrays["role"].copy()
    return arrays


def fillings(case: Scene, walls: Sequence, mesh: WallMesh | None) -> list[Filling]:
    """Return the Filling of each body of fluid, which gives way to other fluid; see `fill.taken`."""
    s = case.numerics.spacing
    return [Filling(fluid.shape, walls, mesh, s, fluid.holes, others,
                    fluid.rise if fluid.raised and isinstance(fluid.shape, StillWater) else None)
            for fluid, others in _with_others(case)]


def _with_others(case: Scene) -> list[tuple[Fluid, list[Taken]]]:
    """Return each body of fluid and the other fluid to which it gives way."""
    shapes, holes = [fluid.shape for fluid in case.fluids], [fluid.holes for fluid in case.fluids]
    return [(fluid, taken(shapes, holes, number)) for number, fluid in enumerate(case.fluids)]


def counts(case: Scene) -> dict[str, int]:
    """Return {"fluid": n, "wall": n, "all": n, "exact": bool}, the numbers of particles of any scene."""
    if case.plain:
        return case_size.counts(case)
    mesh = scene_mesh(case)
    fluid = sum(fill.count for fill in fillings(case, standing(case), mesh))
    wall = 0 if mesh is None else len(mesh.x0)
    return {"fluid": fluid, "wall": wall, "all": fluid + wall, "exact": True}


def samples(case: Scene, lower: Sequence[float], upper: Sequence[float]) -> Iterator[tuple[Array, Array]]:
    """Yield places (m, dim) [m] all over the fluid at the start, and the volume (m,) [m^dim] around each of them.

    For kernels.packing.volumes, in a scene that is not plain. lower, upper : (dim,) [m], the part of the scene to look
    at; the places do not depend on it
    """
    walls, s = standing(case), case.numerics.spacing
    mesh = wall_mesh(walls, s) if walls else None
    box = domain(case)
    for fluid, others in _with_others(case):
        low, high = np.array(lower, float), np.array(upper, float)
        part = [low.copy(), high.copy()]
        if fluid.raised:    # before they are raised, places may be anywhere above and below
            part[0][-1], part[1][-1] = box[0][-1], np.inf
        for places, volume in samples_of(fluid.shape, walls, *box, s, fluid.holes, part, others):
            places, factor = raised(fluid, mesh, case.bounds_of(fluid), places)
            near = np.all((places >= low) & (places < high), axis=1)
            yield places[near], (volume * factor)[near]


def volume(case: Scene) -> float:
    """Return the exact volume [m^dim] of all fluid at the start, in a scene that is not plain."""
    walls, mesh, box, s = standing(case), scene_mesh(case), domain(case), case.numerics.spacing
    return sum(fluid_area(fluid.shape, walls, *box, s, fluid.holes,
                          lambda x, own=fluid: raised(own, mesh, case.bounds_of(own), x)[1], others)
               for fluid, others in _with_others(case))


def jitter(case: Scene, number: Ints, surface: Array) -> Floats:
    """Return the displacement (n, dim) [m] by which the case jitters fluid particles of these numbers.

    surface : (n,) bool, whether they are on the surface. A plain scene is built with it; others are packed first.
    """
    n = case.numerics
    move: Floats = n.spacing * n.jitter * (uniform(n.seed, number, case.dim) - 0.5)
    if not n.jitter_surface:
        move[surface] = 0.0
    return move


def lattice_step(case: Case) -> Floats:
    """Return the step (dim,) [m] of the lattice of a plain scene, the spacing in others."""
    return lattice(case).step if case.plain else np.full(case.dim, case.numerics.spacing)


def uneven(case: Scene) -> bool:
    """Return whether particles of a scene without elements stand for other cells than s^dim inside the fluid."""
    s = case.numerics.spacing
    if any(fluid.raised and isinstance(fluid.shape, Box) for fluid in case.fluids):
        return True
    steps = [lattice(case).step] if case.plain else [fill.step for fill in fillings(case, (), None)]
    return any(abs(step.prod() / s**case.dim - 1.0) > FIT for step in steps)


def domain(case: Scene) -> tuple[Floats, Floats]:
    """Return the lower and the upper corner (dim,) [m] of the walls, wherever they move, or of the fluid without any.

    A scene without a lid is open above: the box then also holds the fluid at the start.
    """
    if case.plain or case.wall_bounds is None:
        return case.fluid_bounds if case.wall_bounds is None else case.wall_bounds
    lower, upper = (corner.copy() for corner in case.wall_bounds)
    for wall in standing(case):
        x = outline_of(wall).points
        for value in _visited(wall.motion, case.end_time):
            at = wall.motion.placed_by(x, value)
            lower, upper = np.minimum(lower, at.min(axis=0)), np.maximum(upper, at.max(axis=0))
    if not case.lidded:
        upper[-1] = max(upper[-1], *(_highest(case, fluid) for fluid in case.fluids))
    return lower, upper


def _visited(motion: Motion, stop: float) -> Floats:
    """Return values of the law of a motion: at least its least and its greatest up to a time [s]."""
    values = course(motion, stop)[1]
    least, greatest = float(values.min()), float(values.max())
    if not isinstance(motion, Rotation):    # corners go straight
        return np.array([least, greatest])
    places: Floats = np.linspace(least, greatest, 2 + int(min(greatest - least, 2.0 * np.pi) / TURN))
    return places


def _highest(case: Scene, fluid: Fluid) -> float:
    """Return the height [m] of the highest fluid of a body at the start."""
    lower, upper = case.bounds_of(fluid)
    if not fluid.raised:
        return float(upper[-1])
    many = 8 + int(8 * (upper - lower)[0] / case.numerics.spacing)
    return float(upper[-1] + fluid.rise(np.linspace(lower[0], upper[0], min(many, 10000))).max())


def _fluid(case: Case, fluid: Fluid, fill: Filling, fills: Sequence[Filling], mesh: WallMesh | None,
           start: int, stop: int) -> dict[str, Array]:
    """Return points number start to stop of one body of fluid."""
    index = fill.indices(start, stop)
    surface = fill.is_surface(index, [other for other in fills if other is not fill])
    x, factor = fill.position(index), np.ones(len(index))
    if not isinstance(fluid.shape, StillWater):
        x, factor = raised(fluid, mesh, case.bounds_of(fluid), x)
    n, dim = x.shape
    cell = factor * fill.step.prod()
    return _with_area(mesh, {
        "kind": np.full(n, FLUID, dtype=np.int8), "corner": np.zeros(n, dtype=np.int8),
        "role": np.where(surface, SURFACE, INNER).astype(np.int8), "x": x, "u": fluid.start_velocity(x),
        "swirl": case.start_vorticity(fluid, x),
        "volume": cell, "normal": np.zeros((n, dim)), "no_slip": np.zeros(n, dtype=np.int8),
        "wall_u": np.zeros((n, dim)), "weight": cell / case.numerics.spacing**dim, "area": np.zeros((n, dim)),
        "edge": np.zeros(n, dtype=np.int8), "body": np.zeros(n, dtype=np.int16)})


def _with_area(mesh, arrays):
    """Leave out what only scenes with walls have."""
    only = ("area", "edge", "body") if mesh is None else ()
    return {name: values for name, values in arrays.items() if name not in only}


def _walls(case: Case, walls: Sequence, mesh: WallMesh, fills: Sequence[Filling], nodes: Ints) -> dict[str, Array]:
    """Return these nodes of the mesh as particles."""
    x, s, n = mesh.x0[nodes], case.numerics.spacing, len(nodes)
    no_slip, wall_u = np.zeros(n, dtype=np.int8), np.zeros_like(x)
    motions = motions_of(walls)
    for number, body in enumerate(mesh.bodies):
        own = mesh.body[nodes] == number
        wall_u[own] = motions[body.motion].velocity_at(x[own], 0.0)
        if isinstance(walls[number], Tank):
            no_slip[own], along = _sides(walls[number], x[own], s)
            wall_u[own] += along
        else:
            no_slip[own] = body.slip == "none"
    scale = s ** (mesh.dim - 1)
    return {
        "kind": np.full(n, WALL, dtype=np.int8), "corner": _in_corner(mesh)[nodes],
        "role": _roles(case, walls, fills, x, mesh.normal0[nodes], mesh.edge[nodes]), "x": x, "u": np.zeros_like(x),
        "swirl": np.zeros(n), "volume": np.zeros(n), "normal": mesh.normal0[nodes], "no_slip": no_slip,
        "wall_u": wall_u, "weight": mesh.area[nodes] * mesh.share[nodes] / scale,
        "area": mesh.vector_area[nodes] / scale,
        "edge": mesh.edge[nodes], "body": mesh.body[nodes].astype(np.int16)}


def _in_corner(mesh):
    """Return 1 for nodes in a concave corner, and at the end of an open line, as at the foot of a piston, (N,) int8."""
    ends = (np.bincount(mesh.elements.ravel(), minlength=len(mesh.x0)) == 1) & (mesh.dim == 2)
    return ((mesh.edge == CONCAVE) | ends).astype(np.int8)


def _roles(case, walls, fills, x, normal, edge):
    """Return the roles (n,) of nodes: wet where fluid comes to them, in contact near its surface, else dry.

    Dry are also nodes behind another body, as those of a bed behind a piston, and convex edges, which carry no row.
    """
    s, outlines = case.numerics.spacing, [outline_of(wall) for wall in walls]

    def held(at: Floats) -> Array:
        return np.any([fill.holds(at) for fill in fills], axis=0)
    before = x + LIFT * s * normal
    wet, free = held(x) & in_fluid(outlines, before), np.zeros(len(x), dtype=bool)
    for axis in range(x.shape[1]):
        for side in (-1.0, 1.0):
            beside = before + side * BESIDE * s * np.eye(x.shape[1])[axis]
            in_front = side * normal[:, axis] > -LIFT    # not on the other side of a plate
            free |= ~held(beside) & in_fluid(outlines, beside) & in_front
    role = np.where(wet, np.where(free, CONTACT, WET), DRY)
    return np.where(edge == CONVEX, DRY, role).astype(np.int8)


def _sides(tank: Tank, x: Floats, spacing: float) -> tuple[Array, Floats]:
    """Return 1 for nodes of sticky sides of a tank and 0 for others, (n,), and the velocity of its lid (n, dim)."""
    (left, bottom), (right, top) = tank.bounds
    near = 1e-6 * spacing
    on = {"left": np.abs(x[:, 0] - left) < near, "right": np.abs(x[:, 0] - right) < near,
          "bottom": np.abs(x[:, 1] - bottom) < near, "top": np.abs(x[:, 1] - top) < near}
    sticky = np.any([np.zeros(len(x), dtype=bool), *(on[side] for side in tank.sticky)], axis=0)
    along = np.zeros_like(x)
    if isinstance(tank.lid, Lid):
        along[on["top"] & ~on["left"] & ~on["right"], 0] = tank.lid.velocity
    return sticky.astype(np.int8), along
