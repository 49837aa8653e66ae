"""The particles at the start of a plain scene, one tank or none with one shape of fluid, or any slice of them.

All lie on one lattice, and nobody looks at more of it than the own slice. build.py has all other scenes.
"""

import numpy as np
from numpy.typing import NDArray

from parisph.base.arrays import Array, Floats, Ints
from parisph.base.errors import CaseError
from parisph.base.fields import CONTACT, DRY, FLUID, INNER, SURFACE, WALL, WET
from parisph.case.expressions import uniform_field
from parisph.case.lattice import Lattice
from parisph.case.methods import METHODS
from parisph.case.schema import Case
from parisph.case.shapes import Box, Lid, Tank


def lattice(case: Case) -> Lattice:
    """Return the Lattice on which the case starts."""
    shape = case.fluids[0].shape
    return Lattice(shape, case.tank, case.numerics.spacing, METHODS[case.numerics.method].wall_layers)


def still_pressure(case: Case, x: Floats) -> Floats:
    """Return the pressure [Pa] at x (n, dim) [m] of fluid below its level top in uniform gravity, 0 for other fluid.

    Only water that fills a Box has a level top; with an elevation, it is that above x.
    """
    gravity = uniform_field(case.gravity)
    if gravity is None or not isinstance(case.fluids[0].shape, Box):
        return np.zeros(len(x))
    top = case.fluids[0].shape.bounds[1][-1] + case.fluids[0].rise(x[:, 0])
    pressure: Floats = np.maximum(case.density * -gravity[-1] * (top - x[:, -1]), 0.0)
    return pressure


def plain_particles(case: Case, rank: int, size: int) -> dict[str, Array]:
    """Return this rank's slice of the particles of a plain scene at the start. Not collective, needs no MPI.

    Parameters
    ----------
    case : Case
    rank, size : which slice of how many; the particles do not depend on `size`

    Returns
    -------
    dict of arrays: id (n,) int64, fluid first and then walls, in order; kind, corner, role (n,) int8;
    x [m], u [m/s], normal (n, dim); volume (n,) [m^dim] (see Lattice.cells), 0 for walls; weight (n,), the cell of
    fluid over s^dim, 1 for walls; p (n,) [Pa], zero where the first solve finds it, else that of still water;
    start_role as role. Wall normals are unit vectors into the fluid, in a corner the normalised sum of both walls'.

    Raises
    ------
    CaseError : there is no fluid
    """
    points = lattice(case)
    n_fluid = points.count()
    if n_fluid == 0:    # the checks of a case count the fluid by its area where counting takes long
        raise CaseError("fluid.shape: no lattice point is in it: it is too thin for the spacing")
    total = n_fluid + points.wall_count()
    start, stop = total * rank // size, total * (rank + 1) // size
    fluid = _fluid(case, points, min(start, n_fluid), min(stop, n_fluid))
    solid = _walls(case, points, *points.wall_indices(max(start - n_fluid, 0), max(stop - n_fluid, 0)))
    arrays = {name: np.concatenate([fluid[name], solid[name]]) for name in fluid}
    arrays["id"] = np.arange(start, stop, dtype=np.int64)
    projected = METHODS[case.numerics.method].step == "projection"
    arrays["p"] = np.zeros(stop - start) if projected else still_pressure(case, arrays["x"])
    arrays["start_role"] = arrays["role"].copy()
    return arrays


def _stretched(case: Case, x: Floats) -> Floats:
    """Move points (n, dim) of the lattice up with the surface, linearly from the bottom of the Box."""
    if not case.fluids[0].raised:
        return x
    bottom = case.fluids[0].shape.bounds[0][-1]
    x = x.copy()
    x[:, -1] = bottom + (x[:, -1] - bottom) * _stretch(case, x)
    return x


def _stretch(case: Case, x: Floats) -> Floats:
    """Return the stretch factor of the columns at x (n, dim) [m], (n,)."""
    if not case.fluids[0].raised or not isinstance(case.fluids[0].shape, Box):
        return np.ones(len(x))
    return 1.0 + case.fluids[0].rise(x[:, 0]) / float(case.fluids[0].shape.size[-1])


def _unstretched(case: Case, x: Floats) -> Floats:
    """Undo _stretched for points (n, dim) [m]."""
    if not case.fluids[0].raised:
        return x
    bottom = case.fluids[0].shape.bounds[0][-1]
    x = x.copy()
    x[:, -1] = bottom + (x[:, -1] - bottom) / _stretch(case, x)
    return x


def _fluid(case: Case, points: Lattice, start: int, stop: int) -> dict[str, Array]:
    index = points.fluid_indices(start, stop)
    n, dim = index.shape
    surface = points.is_surface(index)
    x = _stretched(case, points.position(index))
    cell = _stretch(case, points.position(index)) * points.step.prod()
    numerics = case.numerics
    if numerics.jitter > 0.0:
        move = numerics.spacing * numerics.jitter * (uniform(numerics.seed, np.arange(start, stop), dim) - 0.5)
        if not numerics.jitter_surface:
            move[surface] = 0.0
        x = x + move
    return {
        "kind": np.full(n, FLUID, dtype=np.int8),
        "corner": np.zeros(n, dtype=np.int8),
        "role": np.where(surface, SURFACE, INNER).astype(np.int8),
        "x": x,
        "u": case.fluids[0].start_velocity(x),
        "swirl": case.start_vorticity(case.fluids[0], x),
        "volume": points.cells(index) * cell,
        "weight": cell / numerics.spacing**dim,
        "normal": np.zeros((n, dim)),
        "no_slip": np.zeros(n, dtype=np.int8),
        "wall_u": np.zeros((n, dim)),
    }


def _walls(case: Case, points: Lattice, index: Ints, inward: Ints) -> dict[str, Array]:
    """Wall particles; their role is that of the lattice point one step inward, diagonally in a corner.

    A wall that the fluid does not reach, such as a lid less than a spacing above it, is not wet.
    """
    n = len(index)
    x = points.position(index)
    beside = points.index(_unstretched(case, x + inward * points.step))
    role = np.full(n, DRY, dtype=np.int8)
    there = points.is_fluid(beside)
    wet = points.shape.inside(_unstretched(case, x[there]), points.tolerance) & ~points.is_surface(beside[there])
    role[there] = np.where(wet, WET, CONTACT)
    length = np.linalg.norm(inward, axis=1)
    return {
        "kind": np.full(n, WALL, dtype=np.int8),
        "corner": (length > 1.1).astype(np.int8),
        "role": role,
        "x": x,
        "u": np.zeros_like(x),
        "swirl": np.zeros(n),
        "volume": np.zeros(n),
        "weight": np.ones(n),
        "normal": inward / length[:, None] if n else np.zeros_like(x),
        "no_slip": _sticky(case.tank, inward),
        "wall_u": _lid_velocity(case.tank, inward),
    }


def _sticky(tank: Tank | None, inward: Ints) -> NDArray[np.int8]:
    """Return 1 for wall particles to which fluid sticks, 0 for others, (n,) int8; in a corner, one such wall suffices.

    inward : (n, dim) int, the sum of the inward unit vectors of the walls that a particle lies on
    """
    found = np.zeros(len(inward), dtype=np.int8)
    faces = {"left": (0, 1), "right": (0, -1), "bottom": (-1, 1), "top": (-1, -1)}
    for side in tank.sticky if tank is not None else ():
        axis, sign = faces[side]
        found[inward[:, axis] == sign] = 1
    return found


def _lid_velocity(tank: Tank | None, inward: Ints) -> Floats:
    """Return the velocity of wall particles in their own plane (n, dim) [m/s]; the ends of a lid rest with the side
    walls."""
    found = np.zeros(inward.shape)
    if tank is not None and isinstance(tank.lid, Lid):
        found[(inward[:, -1] == -1) & (inward[:, 0] == 0), 0] = tank.lid.velocity
    return found


def uniform(seed: int, number: Ints, columns: int) -> Floats:
    """Return random numbers (n, columns) in [0, 1) that depend only on the seed and the particle's number.

    They are a hash (splitmix64's finaliser) of a counter: without state, so the same on any number of ranks.
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
