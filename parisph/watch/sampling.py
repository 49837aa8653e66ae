"""The data of a scene and of this rank's particles for probes, and the samplers of a run.

Each rank reduces its own particles to sums and a few rows of numbers (the ends of its bodies of water, the surface
particles at a gauge). instruments.sample_all combines those of all ranks.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from parisph.base.arrays import Flags, Floats, Ints
from parisph.base.errors import CaseError
from parisph.base.fields import BALLISTIC, DRY, FLUID, WALL
from parisph.case import expressions
from parisph.case.probes import OfPressure, Probe, ProbeArray
from parisph.case.scenery import body_names
from parisph.case.schema import Case
from parisph.geometry import build
from parisph.geometry.mesh import CONVEX
from parisph.geometry.standing import standing
from parisph.watch.passages import Passages
from parisph.watch.walls_now import WallsNow

if TYPE_CHECKING:    # a case is described without MPI and numba
    from parisph.parallel.domain import Domain
    from parisph.parallel.particles import Particles


@dataclass(frozen=True)
class ProbeScene:
    """The data of a case that samplers need.

    spacing [m]; step (dim,) of the lattice [m]; density [kg/m3]; lower, upper (dim,) corners of the tank, or of the
    fluid without one [m]; tank : whether there is one; gravity (dim,) [m/s2], zero unless the body force is uniform and
    constant in the tank's frame; now : the walls at any time, None without walls and in 3D; sides : x of both sides of
    the first tank at t = 0 [m], () without one; kinds : {name: kind} of the bodies.
    """

    dim: int
    spacing: float
    step: Floats
    density: float
    lower: Floats
    upper: Floats
    tank: bool
    gravity: Floats
    now: WallsNow | None = None
    sides: tuple[float, ...] = ()
    kinds: Mapping[str, str] = field(default_factory=dict)

    @classmethod
    def of(cls, case: Case) -> "ProbeScene":
        """Return the ProbeScene of a Case."""
        s, mesh = case.numerics.spacing, build.scene_mesh(case)
        gravity = None if case.turns else expressions.uniform_field(case.gravity)
        sides = () if case.tank is None else tuple(float(corner[0]) for corner in case.tank.bounds)
        return cls(case.dim, s, build.fillings(case)[0].step, case.density, *build.domain(case), case.tank is not None,
                   np.zeros(case.dim) if gravity is None else gravity,
                   None if mesh is None or case.dim == 3 else WallsNow(mesh, standing(case)), sides,
                   {name: body.kind for name, body in zip(body_names(case.bodies), case.bodies)})

    def bed_at(self, x: Floats, time: float = 0.0) -> Floats | None:
        """Return the height (n,) [m] of the highest wall at x (n,) with fluid above it, None without walls.

        Where there is none, as beyond the end of a bed, it is that of the lowest wall.
        """
        return None if self.now is None else self.now.bed(x, time)

    def floors_at(self, at: float, time: float) -> Floats:
        """Return the heights (n,) [m], upwards, of all walls with fluid above them at x = `at` [m]."""
        return np.empty(0) if self.now is None else self.now.floors(at, time)

    def sides_at(self, time: float) -> tuple[float, ...]:
        """Return x of the vertical sides of the first tank [m], () without one or if they turn."""
        if self.now is None or not self.sides or not self.now.moving:
            return self.sides
        tank = next(name for name, kind in self.kinds.items() if kind == "tank")
        number = self.now.number(tank)
        if not self.now.upright(number):
            return ()
        moved = self.now.motion_of(number).placed(np.array([(side, 0.0) for side in self.sides]), time)
        return tuple(float(x) for x in moved[:, 0])


class View:
    """This rank's particles and their scene; derived arrays are computed at most once.

    time : of the particles [s]; passages : volumes that have passed lines, None outside a run
    """

    def __init__(self, particles: "Particles", domain: "Domain", scene: ProbeScene, time: float,
                 passages: Passages | None = None) -> None:
        self.particles, self.domain, self.scene, self.time, self.passages = particles, domain, scene, time, passages

    @cached_property
    def fluid(self) -> Flags:
        """Whether particles are fluid, (n_owned,) bool."""
        found: Flags = self.particles.kind == FLUID
        return found

    @cached_property
    def body(self) -> Floats:
        """Positions (n, dim) [m] of fluid that is not in free flight."""
        return self.places(self.fluid & (self.particles.role != BALLISTIC))

    def places(self, chosen: Flags) -> Floats:
        """Return the positions (n, dim) [m] of the chosen particles, (n_owned,) bool."""
        return self.particles.x.compress(chosen, axis=0)    # five times faster than an index

    @cached_property
    def walls(self) -> tuple[Floats, Floats]:
        """Positions (n, dim) [m] and pressures (n,) [Pa] of the wall particles, 0 for dry ones.

        Those on convex edges are left out, and dry ones beside water without room in front of them
        (WallElements.without_room): they have no row, and so no pressure.
        """
        p, wall = self.particles, self._wall
        return p.x.take(wall, axis=0), np.where(p.role.take(wall) == DRY, 0.0, p.p.take(wall))

    @property
    def wall_faces(self) -> tuple[Floats, Ints]:
        """Normals (n, dim) of the particles of `walls`, and the numbers of their bodies (n,)."""
        return self.particles.normal[self._wall], self.particles.body[self._wall]

    @cached_property
    def _wall(self) -> Ints:
        p = self.particles
        return np.flatnonzero((p.kind == WALL) & (p.edge != CONVEX) & ~self.domain.elements.without_room(p))


class Sampler:
    """One probe of a run, or an array of them, with the columns of all.

    columns : {name: unit}; ghosts : fields of the ghosts that must be up to date
    measure : computes its values
    of_pressure : whether its values are linear in the pressure alone. They belong to the time for which it was solved,
        and are means in time in a run (watch.means)
    acted : names of the second set of columns, with the pressures that act in a step, which are not means in time
    members : the samplers of an array, else itself

    Raises CaseError if the probe, or its place, does not exist in the dimensions of the scene.
    """

    def __init__(self, probe: Probe, scene: ProbeScene) -> None:
        if scene.dim not in probe.dims:
            raise CaseError(f"probe {probe.name!r}: {getattr(probe, 'kind', '')} exists in 2D only; "
                            f"leave it out of a scene in {scene.dim}D")
        self.name, self.probe, self.scene = probe.name, probe, scene
        self.members: Sequence[Sampler] = (self,)
        self.title, self.columns, self.ghosts = probe.title(scene), probe.columns_in(scene), probe.ghosts()
        self.measure = probe.begin(scene)
        self.of_pressure, self.acted = isinstance(probe, OfPressure), frozenset[str]()
        if isinstance(probe, OfPressure) and probe.acted:
            again = {f"{name}_acted": unit for name, unit in self.columns.items()}
            self.columns, self.acted = self.columns | again, frozenset(again)
        if isinstance(probe, ProbeArray):
            self._take([Sampler(one, scene) for one in probe.probes])

    def _take(self, members: "Sequence[Sampler]") -> None:
        self.members = members
        names = [(member, column, member.name if len(member.columns) == 1 else f"{member.name}_{column}")
                 for member in members for column in member.columns]
        self.columns = {name: member.columns[column] for member, column, name in names}
        self.acted = frozenset(name for member, column, name in names if column in member.acted)
        self.ghosts = tuple(sorted({name for member in members for name in member.ghosts}))
        self.of_pressure = all(member.of_pressure for member in members)
        self.title = "; ".join(f"{member.name}: {member.title}" for member in members)

    def values(self, sums: Floats, rows: Floats, view: View) -> tuple[float, ...]:
        """Return the values of all columns of one probe. At an instant, `acted` columns repeat the others."""
        found = tuple(map(float, self.measure.values(sums, rows, view)))
        return found + found if self.acted else found
