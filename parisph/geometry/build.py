"""Walls and particles of a case at the start, for any scene. Not collective, needs no MPI.

Ids number the fluid first, body by body, then the nodes of the wall mesh in their order. So the mesh node of a wall
particle is its id minus the number of fluid particles at the start. Each rank makes its own slice only. It also reads
the lattice lines and the walls, about sqrt(N) of them.
"""

from collections.abc import Iterator, Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from parisph.base.arrays import Array, Flags, Floats, Ints
from parisph.base.errors import CaseError
from parisph.base.fields import CONTACT, DRY, FLUID, INNER, SURFACE, WALL, WET
from parisph.case.bodies import StillWater
from parisph.case.expressions import uniform_field
from parisph.case.fluids import Fluid
from parisph.case.methods import METHODS
from parisph.case.motion import Motion, Rotation, course, leaves_section
from parisph.case.motion.spatial import corners
from parisph.case.scene import Scene
from parisph.case.schema import Case
from parisph.case.shapes import Box, Lid, Tank
from parisph.geometry.extrusion import extruded
from parisph.geometry.feet import on_walls
from parisph.geometry.fill import Filling, filling_of
from parisph.geometry.layers import LayeredFilling, in_front, layered
from parisph.geometry.mesh import CONCAVE, CONVEX, WallMesh, motions_of, wall_mesh
from parisph.geometry.quadrature import fluid_area
from parisph.geometry.quadrature import samples as samples_of
from parisph.geometry.raised import highest, lowered, raised
from parisph.geometry.room_filling import room_fillings
from parisph.geometry.scene_room import in_room, room_mesh
from parisph.geometry.solid import in_fluid, solid_of
from parisph.geometry.spans import scene_walls
from parisph.geometry.standing import standing

CHUNK = 2**18   # particles treated at once; limits the memory of a large scene
BESIDE = 0.5    # spacings: a wall node within this distance of the surface is at the contact line
LIFT = 0.1      # spacings in front of a node, where its fluid is looked for
TURN = 0.02     # [rad] between two checked positions of a rotating wall

AnyFilling = Filling | LayeredFilling


@lru_cache(maxsize=2)
def scene_mesh(case: Scene) -> WallMesh | None:
    """Return the mesh of all walls of a case, or None without walls. Raises CaseError.

    Cached: callers must not change it. Nodes are at their positions at t = 0. `bodies[k].motion` numbers the motion in
    `scene_motions`, and `bodies` are the walls of geometry.spans.scene_walls.
    """
    if case.dim == 3:
        mesh = room_mesh(case) if case.surfaces else extruded(case) if case.bodies else None
    else:
        walls = standing(case)
        mesh = wall_mesh(walls, case.numerics.spacing) if walls else None
    return None if mesh is None else on_walls(mesh, case.numerics.spacing)


def scene_motions(case: Scene) -> tuple[Motion, ...]:
    """Return the motions of walls in the frame of the case; number 0 is rest."""
    return motions_of(scene_walls(case))


def build(case: Case, rank: int = 0, size: int = 1) -> dict[str, Array]:
    """Build this rank's slice of the particles at the start.

    rank, size : slice `rank` of `size`; the particles do not depend on `size`

    Returns arrays: id (n,) int64, in order; kind, corner, role (n,) int8; x [m], u [m/s], normal (n, dim);
    volume (n,) [m^dim], the lattice cell of fluid, 0 of walls (see `weighed`); p (n,) [Pa], of weakly compressible
    fluid that of still water, else 0 until the first solve; swirl (n,) [1/s]; start_role as role; no_slip (n,) int8;
    wall_u (n, dim) [m/s]. Wall normals are unit vectors into the fluid, in a corner the normalised sum of both walls'.
    Fluid is not jittered: see `jitter`.

    weight (n,), of fluid its cell over s^dim, of a node the part of a cell s^dim inside the fluid, area * share /
    s^(dim-1); area (n, dim), of a node its vector area over s^(dim-1), of fluid 0; edge (n,) int8 (geometry.mesh); body
    (n,) int16, of a node the number of its body in the mesh, of fluid -1.

    Raises CaseError where no fluid particle fits.
    """
    mesh, fills = scene_mesh(case), fillings(case)
    n_fluid, n_wall = sum(fill.count for fill in fills), 0 if mesh is None else len(mesh.x0)
    if n_fluid == 0:
        raise CaseError("fluid: no particle fits: it is thinner than the spacing, or behind the walls")
    total = n_fluid + n_wall
    start, stop = total * rank // size, total * (rank + 1) // size
    parts, first = [], 0
    for fluid, fill in zip(case.fluids, fills):
        low, high = (int(np.clip(end - first, 0, fill.count)) for end in (start, stop))
        parts.append(_fluid(case, fluid, fill, low, high))
        first += fill.count
    if mesh is not None:
        parts.append(wall_nodes(case, np.arange(max(start - n_fluid, 0), max(stop - n_fluid, 0))))
    arrays = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    arrays["id"] = np.arange(start, stop, dtype=np.int64)
    arrays["start_role"] = arrays["role"].copy()
    return arrays


def fillings(case: Scene) -> tuple[AnyFilling, ...]:
    """Return the filling of each body of fluid. Cached. `fill.taken` says which fluid gives way to which."""
    if case.dim == 3:
        return room_fillings(case) if case.surfaces else layered(case)
    return tuple(filling_of(case.fluids, number, standing(case), case.numerics.spacing)
                 for number in range(len(case.fluids)))


def even(case: Scene) -> bool:
    """Return whether all fluid starts on the lattice of the tank as the only wall, or without walls."""
    return all(fill.even for fill in fillings(case))


def weighed(case: Scene) -> bool:
    """Return whether `build` gives the volumes of the particles: if all fluid is one even Box.

    For other scenes, `samples` and kernels.packing.volumes give them.
    """
    fluid = case.fluids[0]
    return len(case.fluids) == 1 and isinstance(fluid.shape, Box) and not fluid.holes and even(case)


def counts(case: Scene) -> dict[str, int]:
    """Return {"fluid": n, "wall": n, "all": n}, the numbers of particles of a scene."""
    mesh, fluid = scene_mesh(case), sum(fill.count for fill in fillings(case))
    wall = 0 if mesh is None else len(mesh.x0)
    return {"fluid": fluid, "wall": wall, "all": fluid + wall}


def has_surface(case: Scene) -> bool:
    """Return whether any fluid of a scene is on the surface at the start."""
    fills = fillings(case)
    return any(_on_surface(fill, fill.indices(low, low + CHUNK), fills).any()
               for fill in fills for low in range(0, fill.count, CHUNK))


def _on_surface(fill: AnyFilling, index: Ints, fills: Sequence[AnyFilling]) -> Flags:
    """Return which points of a body of fluid (n,) are on the surface."""
    if isinstance(fill, LayeredFilling):
        return fill.is_surface(index, [other for other in fills if isinstance(other, LayeredFilling)])
    return fill.is_surface(index, [other for other in fills if isinstance(other, Filling)])


def samples(case: Scene, lower: Sequence[float], upper: Sequence[float]) -> Iterator[tuple[Array, Array]]:
    """Yield sample places (m, dim) [m] of the fluid at the start, with the volume (m,) [m^dim] of each.

    For kernels.packing.volumes. lower, upper : (dim,) [m], the part of the scene whose places are returned
    """
    for fluid, fill in zip(case.fluids, fillings(case)):
        if isinstance(fill, LayeredFilling):
            yield from fill.samples(np.asarray(lower), np.asarray(upper), domain(case))
            continue
        for places, volume in samples_of(fill, *domain(case), (lower[0], upper[0])):
            places, factor = raised(fluid, scene_mesh(case), case.bounds_of(fluid), places)
            near = np.all((places >= lower) & (places < upper), axis=1)
            yield places[near], (volume * factor)[near]


def volume(case: Scene) -> float:
    """Return the exact volume [m^dim] of all fluid at the start."""
    return sum(fill.volume(domain(case)) if isinstance(fill, LayeredFilling) else fluid_area(
        fill, *domain(case), lambda x: raised(fluid, scene_mesh(case), case.bounds_of(fluid), x)[1])
        for fluid, fill in zip(case.fluids, fillings(case)))


def jitter(case: Scene, number: Ints, surface: Array) -> Floats:
    """Return the displacement (n, dim) [m] by which the case jitters the numbered fluid particles.

    surface : (n,) bool, whether they are on the surface
    """
    n = case.numerics
    move: Floats = n.spacing * n.jitter * (uniform(n.seed, number, case.dim) - 0.5)
    if not n.jitter_surface:
        move[surface] = 0.0
    return move


def uniform(seed: int, number: Ints, columns: int) -> Floats:
    """Return random numbers (n, columns) in [0, 1) that depend only on the seed and the particle's number.

    They are a hash of a counter (splitmix64's finaliser), so the same on any number of ranks.
    """
    with np.errstate(over="ignore"):
        column: NDArray[np.uint64] = np.arange(columns, dtype=np.uint64)
        counter: NDArray[np.uint64] = np.asarray(number, dtype=np.uint64)[:, None] * np.uint64(columns) + column
        bits = _mix(counter + _mix(np.array([seed], dtype=np.uint64))) >> np.uint64(11)
        return bits.astype(np.float64) * 2.0**-53


def _mix(z: NDArray[np.uint64]) -> NDArray[np.uint64]:
    z = z + np.uint64(0x9E3779B97F4A7C15)
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return z ^ (z >> np.uint64(31))


def started(case: Scene, number: Ints, x: Floats) -> dict[str, Floats]:
    """Return u (n, dim) [m/s], swirl (n,) [1/s] and p (n,) [Pa] at the start, of numbered fluid at x (n, dim) [m]."""
    found, first = {"u": np.zeros_like(x), "swirl": np.zeros(len(x)), "p": np.zeros(len(x))}, 0
    for fluid, fill in zip(case.fluids, fillings(case)):
        own = (number >= first) & (number < first + fill.count)
        for name, values in _started(case, fluid, x[own]).items():
            found[name][own] = values
        first += fill.count
    return found


def _started(case: Scene, fluid: Fluid, x: Floats) -> dict[str, Floats]:
    compressible = METHODS[case.numerics.method].step == "compressible"
    return {"u": fluid.start_velocity(x), "swirl": case.start_vorticity(fluid, x),
            "p": _still_pressure(case, fluid, x) if compressible else np.zeros(len(x))}


def domain(case: Scene) -> tuple[Floats, Floats]:
    """Return the corners (dim,) [m] of a box around the walls in all positions, or without walls around the fluid.

    Without a lid, the box also contains the fluid at the start.
    """
    if case.wall_bounds is None:
        return case.fluid_bounds
    lower, upper = (corner.copy() for corner in case.wall_bounds)
    part = [0, -1] if case.dim == 3 else slice(None)    # bodies move in the section
    for wall in scene_walls(case):
        x = solid_of(wall).points
        if leaves_section(wall.motion):
            continue
        for value in _visited(wall.motion, case.end_time):
            at = wall.motion.placed_by(x, value)
            lower[part], upper[part] = np.minimum(lower[part], at.min(axis=0)), np.maximum(upper[part], at.max(axis=0))
    if case.dim == 3:    # a front is higher than its Profile
        mesh = extruded(case)
        for motion, own in _out_of_section(case, mesh):
            for time in motion.instants(case.end_time):
                at = motion.placed(own, float(time))
                lower, upper = np.minimum(lower, at.min(axis=0)), np.maximum(upper, at.max(axis=0))
        upper[-1] = max(upper[-1], mesh.x0[:, -1].max())
    if not case.lidded:
        upper[-1] = max(upper[-1], *(highest(case, fluid) for fluid in case.fluids))
    return lower, upper


def _out_of_section(case: Scene, mesh: WallMesh) -> Iterator[tuple[Motion, Floats]]:
    """Yield the motions that leave the section of a 3D scene, each with the corners (8, 3) [m] around its nodes."""
    motions, number = scene_motions(case), np.array([body.motion for body in mesh.bodies])[mesh.body]
    for k, motion in enumerate(motions):
        own = mesh.x0[number == k]
        if len(own) and leaves_section(motion):
            yield motion, corners(own.min(axis=0), own.max(axis=0))


def _visited(motion: Motion, stop: float) -> Floats:
    """Return values of the law of a motion up to a time [s], including its minimum and its maximum."""
    values = course(motion, stop)[1]
    least, greatest = float(values.min()), float(values.max())
    if not isinstance(motion, Rotation):    # corners move along straight lines
        return np.array([least, greatest])
    places: Floats = np.linspace(least, greatest, 2 + int(min(greatest - least, 2.0 * np.pi) / TURN))
    return places


def _still_pressure(case: Scene, fluid: Fluid, x: Floats) -> Floats:
    """Return the pressure [Pa] at x (n, dim) [m] of still fluid in uniform gravity, 0 for other shapes or forces."""
    gravity = uniform_field(case.gravity)
    if gravity is None or not isinstance(fluid.shape, (Box, StillWater)):
        return np.zeros(len(x))
    pressure: Floats = np.maximum(case.density * -gravity[-1] * (fluid.top + fluid.rise(*x.T[:-1]) - x[:, -1]), 0.0)
    return pressure


def _fluid(case: Case, fluid: Fluid, fill: AnyFilling, start: int, stop: int) -> dict[str, Array]:
    """Return the arrays of points start to stop of one body of fluid."""
    index = fill.indices(start, stop)
    surface = _on_surface(fill, index, fillings(case))
    x, factor = fill.position(index), np.ones(len(index))
    if not isinstance(fluid.shape, StillWater):
        x, factor = fill.moved(index) if isinstance(fill, LayeredFilling) else raised(
            fluid, scene_mesh(case), case.bounds_of(fluid), x)
    n, dim = x.shape
    cell = factor * fill.cell(index)
    return {
        "kind": np.full(n, FLUID, dtype=np.int8), "corner": np.zeros(n, dtype=np.int8),
        "role": np.where(surface, SURFACE, INNER).astype(np.int8), "x": x, **_started(case, fluid, x),
        "volume": factor * fill.cells(index) if weighed(case) else cell, "normal": np.zeros((n, dim)),
        "no_slip": np.zeros(n, dtype=np.int8), "wall_u": np.zeros((n, dim)),
        "weight": cell / case.numerics.spacing**dim, "area": np.zeros((n, dim)),
        "edge": np.zeros(n, dtype=np.int8), "body": np.full(n, -1, dtype=np.int16)}


def wall_nodes(case: Case, nodes: Ints) -> dict[str, Array]:
    """Return nodes (n,) of the mesh of a case as particles: the arrays of `build` without ids."""
    walls, mesh, s, n = scene_walls(case), scene_mesh(case), case.numerics.spacing, len(nodes)
    assert mesh is not None
    x, no_slip, wall_u = mesh.x0[nodes], np.zeros(n, dtype=np.int8), np.zeros((n, mesh.dim))
    motions = motions_of(walls)
    for number, (body, wall) in enumerate(zip(mesh.bodies, walls)):
        own = mesh.body[nodes] == number
        wall_u[own] = motions[body.motion].velocity_at(x[own], 0.0)
        if isinstance(wall, Tank):
            assert case.tank is not None
            no_slip[own], along = _sides(case.tank, x[own], s)
            wall_u[own] += along
        else:
            no_slip[own] = body.slip == "none"
    for number, body in list(enumerate(mesh.bodies))[len(walls):]:    # Surfaces
        no_slip[mesh.body[nodes] == number] = body.slip == "none"
    scale = s ** (mesh.dim - 1)
    corner = (mesh.edge == CONCAVE) | mesh.ends    # or an open end, like the foot of a piston
    return {
        "kind": np.full(n, WALL, dtype=np.int8), "corner": corner[nodes].astype(np.int8),
        "role": _roles(case, x, mesh.normal0[nodes], mesh.edge[nodes]), "x": x, "u": np.zeros_like(x),
        "p": np.zeros(n), "swirl": np.zeros(n), "volume": np.zeros(n), "normal": mesh.normal0[nodes],
        "no_slip": no_slip, "wall_u": wall_u, "weight": mesh.cell[nodes] * mesh.share[nodes] / scale,
        "area": mesh.vector_area[nodes] / scale,
        "edge": mesh.edge[nodes], "body": mesh.body[nodes].astype(np.int16)}


def _roles(case: Scene, x: Floats, normal: Floats, edge: Array) -> Array:
    """Return the roles (n,) of nodes: WET in fluid, CONTACT near its surface, else DRY.

    Nodes behind another body, like those of a bed behind a piston, are DRY, and so are convex edges, which have no row.
    """
    s = case.numerics.spacing

    def held(at: Floats) -> Array:
        fills = zip(case.fluids, fillings(case))
        return np.asarray(np.any([fill.holds(at, lower=True) if isinstance(fill, LayeredFilling) else
                                  fill.holds(lowered(fluid, at)) for fluid, fill in fills], axis=0))

    def clear(at: Floats) -> Array:
        if case.dim == 2:
            return in_fluid(standing(case), at)
        return in_front(case, at) & in_room(case, at) if case.surfaces else in_front(case, at)

    before = x + LIFT * s * normal
    wet, free = held(x) & clear(before), np.zeros(len(x), dtype=bool)
    for axis in range(x.shape[1]):
        for side in (-1.0, 1.0):
            beside = before + side * BESIDE * s * np.eye(x.shape[1])[axis]
            facing = side * normal[:, axis] > -LIFT    # not on the other side of a plate
            free |= ~held(beside) & clear(beside) & facing
    role = np.where(wet, np.where(free, CONTACT, WET), DRY)
    return np.where(edge == CONVEX, DRY, role).astype(np.int8)


def _sides(tank: Tank, x: Floats, spacing: float) -> tuple[Array, Floats]:
    """Return 1 for nodes on no-slip sides of a tank, else 0, (n,), and the velocity of its lid (n, dim)."""
    near, names = 1e-6 * spacing, {0: ("left", "right"), 1: ("front", "back"), x.shape[1] - 1: ("bottom", "top")}
    on = {name: np.abs(x[:, axis] - corner[axis]) < near
          for axis, pair in names.items() for name, corner in zip(pair, tank.bounds)}
    sticky = np.any([np.zeros(len(x), dtype=bool), *(on[side] for side in tank.sticky)], axis=0)
    along = np.zeros_like(x)
    if isinstance(tank.lid, Lid):
        along[on["top"] & ~on["left"] & ~on["right"], 0] = tank.lid.velocity
    return sticky.astype(np.int8), along
