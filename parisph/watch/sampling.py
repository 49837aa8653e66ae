"""The evaluation of probes on particles that are distributed over ranks, with two messages for all probes.

Each rank reduces its own particles to sums and a few rows of numbers (the ends of its bodies of
water, the surface particles at a gauge). One Allreduce adds the sums of all probes, and one
Allgatherv collects their rows, for any number of probes.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from mpi4py import MPI

from parisph.base.errors import CaseError
from parisph.base.fields import BALLISTIC, DRY, FLUID, SURFACE, WALL
from parisph.case import expressions
from parisph.case.probes import AnyProbe, ProbeArray
from parisph.case.scenery import body_names
from parisph.case.schema import Case
from parisph.geometry import build
from parisph.geometry.mesh import CONVEX, WallMesh
from parisph.geometry.standing import standing
from parisph.parallel.domain import Domain
from parisph.parallel.particles import Particles
from parisph.watch.passages import Passages
from parisph.watch.walls_now import WallsNow

WIDTH = 5  # numbers of a row: its probe, what it is, and three more


def sample_all(samplers: "Sequence[Sampler]", particles: Particles, domain: Domain,
               time: float) -> dict[str, tuple[float, ...]]:
    """Return {name of the probe: tuple of floats, in the order of its `columns`}. Collective.

    Every rank gets the same values. Positions of ghosts are updated if a sampler needs them; nothing
    else changes. `domain` must have been refreshed since particles were assigned. A probe that finds
    nothing to measure gives nan.

    time : of the particles [s]
    """
    if not samplers:
        return {}
    stale = sorted({name for sampler in samplers for name in sampler.ghosts})
    if stale:
        domain.update(*stale)
    view = View(particles, domain)
    members = [member for sampler in samplers for member in sampler.members]
    for member in members:
        member.place(time)
    sums = [np.asarray(member.sums(view), float) for member in members]
    rows = [member.rows(view) for member in members]
    if particles.comm.size > 1:
        sums, rows = _together(particles.comm, sums, rows)
    found = iter([tuple(float(v) for v in member.values(*own)) for *own, member in zip(sums, rows, members)])
    return {sampler.name: sum((next(found) for _ in sampler.members), ()) for sampler in samplers}


def _together(comm: MPI.Comm, sums: Sequence[np.ndarray],
              rows: Sequence[np.ndarray]) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """Return the sums over all ranks (k,) and the rows of all ranks (n, 4), of each sampler. Collective."""
    table = np.concatenate([_numbered(number, own) for number, own in enumerate(rows)])
    ends = np.cumsum([len(own) for own in sums])
    # how many rows each rank has travels with the sums
    packed = np.concatenate([*sums, np.zeros(comm.size)])
    packed[ends[-1] + comm.rank] = len(table)
    comm.Allreduce(MPI.IN_PLACE, packed, op=MPI.SUM)
    counts = packed[ends[-1]:].astype(int)
    everyone = np.empty((counts.sum(), WIDTH))
    if len(everyone):
        comm.Allgatherv(table, [everyone, WIDTH * counts])
    return (np.split(packed[:ends[-1]], ends[:-1]),
            [everyone[everyone[:, 0] == number, 1:] for number in range(len(rows))])


def _numbered(number, rows):
    """Put the number of the sampler in front of its rows (n, 4)."""
    table = np.empty((len(rows), WIDTH))
    table[:, 0], table[:, 1:] = number, rows
    return table


@dataclass(frozen=True)
class Scene:
    """The data of a case that samplers need.

    spacing [m]; step (dim,) of the lattice [m]; density [kg/m3]; lower, upper (dim,) corners of
    the tank, or of the fluid without one [m]; tank : whether there is one; gravity (dim,) [m/s2],
    zero unless the body force is uniform and constant in the tank's frame; lid : whether the tank is closed above;
    now : the walls and where they are, None in a plain scene, whose walls are those of the tank; sides : x of both
    sides of the first tank as at t = 0 [m], () without one; kinds : {name: kind} of the bodies.
    """

    dim: int
    spacing: float
    step: np.ndarray
    density: float
    lower: np.ndarray
    upper: np.ndarray
    tank: bool
    gravity: np.ndarray
    lid: bool = False
    now: WallsNow | None = None
    sides: tuple[float, ...] = ()
    kinds: Mapping[str, str] = field(default_factory=dict)

    @classmethod
    def of(cls, case: Case) -> "Scene":
        """Return the Scene of a Case."""
        s, mesh = case.numerics.spacing, build.scene_mesh(case)
        sides = () if case.tank is None else tuple(float(corner[0]) for corner in case.tank.bounds)
        return cls(case.dim, s, build.lattice_step(case), case.density,
                   *build.domain(case), case.tank is not None, _uniform(case), case.lidded,
                   None if mesh is None else WallsNow(mesh, standing(case)), sides,
                   {name: body.kind for name, body in zip(body_names(case.bodies), case.bodies)})

    @property
    def mesh(self) -> WallMesh | None:
        """The mesh of the walls as at t = 0, None in a plain scene."""
        return None if self.now is None else self.now.mesh

    @property
    def walls(self) -> tuple[np.ndarray, np.ndarray]:
        """Where the walls are: lower, upper (dim,) [m], infinite where there is none."""
        if not self.tank:
            return np.full(self.dim, -np.inf), np.full(self.dim, np.inf)
        upper = self.upper.copy()
        upper[-1] = upper[-1] if self.lid else np.inf
        return self.lower, upper

    @property
    def bed(self) -> float | None:
        """Height of the tank's bed [m], or None."""
        return self.lower[-1] if self.tank else None

    def bed_at(self, x: np.ndarray, time: float = 0.0) -> np.ndarray | None:
        """Return the height (n,) [m] of the highest wall at x (n,) with fluid above it, or None without walls.

        Where there is none, as beyond the end of a bed, it is the lowest place of the scene.
        """
        if self.now is None:
            return None if self.bed is None else np.full(len(x), self.bed)
        return self.now.bed(x, time)

    def floors_at(self, at: float, time: float) -> np.ndarray:
        """Return the heights (n,) [m], upwards, of all walls with fluid above them at x = `at` [m]."""
        if self.now is None:
            return np.array([] if self.bed is None else [self.bed])
        return self.now.floors(at, time)

    def sides_at(self, time: float) -> tuple[float, ...]:
        """Return x of the upright sides of the first tank [m]."""
        if self.now is None or not self.sides:
            return self.sides
        tank = next(name for name, kind in self.kinds.items() if kind == "tank")
        number = self.now.number(tank)
        if not self.now.upright(number):
            return ()
        moved = self.now.motion_of(number).placed(np.array([(side, 0.0) for side in self.sides]), time)
        return tuple(float(x) for x in moved[:, 0])


def _uniform(case):
    """Return the body force (dim,) [m/s2] if it is uniform and constant, else zeros (no potential)."""
    found = None if case.turns else expressions.uniform_field(case.gravity)
    return np.zeros(case.dim) if found is None else found


class View:
    """This rank's particles in the forms that samplers need; each is computed at most once."""

    def __init__(self, particles: Particles, domain: Domain) -> None:
        self.particles, self.domain = particles, domain

    @cached_property
    def fluid(self) -> np.ndarray:
        """Bool (n_owned,)."""
        return self.particles.kind == FLUID

    @cached_property
    def fluid_places(self) -> np.ndarray:
        """Positions (n, dim) of all fluid, that in free flight, too [m]."""
        return self.particles.x.compress(self.fluid, axis=0)

    @cached_property
    def body(self) -> tuple[np.ndarray, np.ndarray]:
        """Along and up: x and the vertical coordinate of fluid that is not in free flight, (n,) each [m]."""
        return self._along_and_up(self.fluid & (self.particles.role != BALLISTIC))

    @cached_property
    def surface(self) -> tuple[np.ndarray, np.ndarray]:
        """x and the vertical coordinate of fluid particles on the free surface, (n,) each [m]."""
        return self._along_and_up(self.fluid & (self.particles.role == SURFACE))

    def _along_and_up(self, chosen):
        x = self.particles.x.compress(chosen, axis=0)    # a fifth of the time that an index takes
        return x[:, 0], x[:, -1]

    @cached_property
    def walls(self) -> tuple[np.ndarray, np.ndarray]:
        """Positions (n, dim) [m] and pressures (n,) [Pa] of the wall particles; dry ones have none.

        Those on convex edges are left out, and dry ones with water beside them but no room for any in front
        (WallElements.without_room): they carry no row, and so no pressure.
        """
        p, wall = self.particles, self._wall
        return p.x.take(wall, axis=0), np.where(p.role.take(wall) == DRY, 0.0, p.p.take(wall))

    @property
    def wall_faces(self) -> tuple[np.ndarray, np.ndarray]:
        """Normals (n, dim) of the particles of `walls`, and the numbers of their bodies (n,), where these have any."""
        return self.particles.normal[self._wall], self.particles.body[self._wall]

    @cached_property
    def _wall(self):
        p = self.particles
        there = p.kind == WALL
        if "edge" in p.fields:
            there &= p.edge != CONVEX
        there &= ~self.domain.elements.without_room(p)
        return np.flatnonzero(there)


class Sampler:
    """One probe of a run.

    Attributes
    ----------
    name, title : str
    columns : dict of column name -> unit
    ghosts : fields of the ghosts that must be up to date
    of_pressure : whether its values are those of the pressure alone, and so of the time for which that was solved; they
        are linear in it
    acted : names of columns with the pressure that acts in a step, also where others are means in time
    """

    columns: dict[str, str] = {}
    ghosts: tuple[str, ...] = ()
    of_pressure = False
    acted: frozenset[str] = frozenset()
    dims: tuple[int, ...] = (2, 3)
    title: str

    def __init__(self, probe: AnyProbe, scene: Scene) -> None:
        if scene.dim not in self.dims:
            raise CaseError(f"probe {probe.name!r}: {probe.kind} exists in 2D only; "
                            f"leave it out of a scene in {scene.dim}D")
        self.name, self.probe, self.scene = probe.name, probe, scene

    @property
    def members(self) -> "Sequence[Sampler]":
        """The samplers of which its columns are: itself, but for an array of probes."""
        return (self,)

    def follow(self, passages: "Passages") -> None:
        """Take what is counted in every step of a run from here on. Not collective."""

    def sample(self, particles: Particles, domain: Domain, time: float) -> tuple[float, ...]:
        """Return the values, a tuple of floats in the order of `columns`. Collective; as sample_all."""
        return sample_all([self], particles, domain, time)[self.name]

    def place(self, time: float) -> None:
        """Put what moves with a wall to where it is at a time [s], before each sample. Not collective."""

    def sums(self, view: "View") -> Sequence[float] | np.ndarray:
        """Return the numbers to be added over the ranks. Not collective."""
        return ()

    def rows(self, view: "View") -> np.ndarray:
        """Return the rows (n, 4) for all ranks: a kind and three numbers each. Not collective."""
        return np.empty((0, WIDTH - 1))

    def values(self, sums: np.ndarray, rows: np.ndarray | None) -> Sequence[float] | np.ndarray:
        """Return the values from the sums and the rows of all ranks. Not collective."""
        raise NotImplementedError


class OfPressure(Sampler):
    """A probe of pressure alone. Its columns are means in time in a run (watch.means).

    With `acted` they come twice, the second time as what acts in the step.
    """

    of_pressure = True

    def __init__(self, probe: AnyProbe, scene: Scene) -> None:
        super().__init__(probe, scene)
        if probe.acted:
            self.acted = frozenset(f"{name}_acted" for name in self.columns)
            self.columns = self.columns | {f"{name}_acted": unit for name, unit in self.columns.items()}

    def values(self, sums: np.ndarray, rows: np.ndarray | None) -> Sequence[float]:
        """See Sampler: at an instant, both are what acts then."""
        found = tuple(self.acting(sums, rows))
        return found + found if self.acted else found

    def acting(self, sums: np.ndarray, rows: np.ndarray | None) -> Sequence[float] | np.ndarray:
        """Return the values as `values` does, once. Not collective."""
        raise NotImplementedError


class Several(Sampler):
    """An array of probes: its columns are those of all of them, one after the other."""

    def __init__(self, probe: ProbeArray, scene: Scene, members: Sequence[Sampler]) -> None:
        super().__init__(probe, scene)
        self._members = tuple(members)
        names = [(member, column, member.name if len(member.columns) == 1 else f"{member.name}_{column}")
                 for member in members for column in member.columns]
        self.columns = {name: member.columns[column] for member, column, name in names}
        self.acted = frozenset(name for member, column, name in names if column in member.acted)
        self.ghosts = tuple(sorted({name for member in members for name in member.ghosts}))
        self.of_pressure = all(member.of_pressure for member in members)
        self.title = "; ".join(f"{member.name}: {member.title}" for member in members)

    @property
    def members(self) -> Sequence[Sampler]:
        """See Sampler."""
        return self._members
