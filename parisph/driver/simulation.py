"""A scene in memory: particles, domain, solver and method, advanced step by step."""

from collections.abc import Callable, Iterable, Mapping
from contextlib import AbstractContextManager, nullcontext
from dataclasses import replace
from functools import wraps
from typing import Concatenate, ParamSpec, TypeVar

import numpy as np
from mpi4py import MPI

from parisph.base import log
from parisph.base.arrays import Array, Floats, sizes
from parisph.base.errors import CaseError, ParisphError, agree
from parisph.base.fields import FLUID, FieldSet
from parisph.case import scales
from parisph.case.numerics import ResolvedNumerics
from parisph.case.schema import Case
from parisph.case.time_scales import flow_length, sound_speed, wave_time
from parisph.driver import memory_check, solid_walls, wall_penetration, warmup
from parisph.driver.overflow import OpenTank, Overflow
from parisph.driver.schedule import ROUNDING, step_towards
from parisph.geometry import build
from parisph.io import room_file
from parisph.io.checkpoint import Checkpoint
from parisph.io.wall_cells import WallCells
from parisph.kernels import selfcheck
from parisph.methods import written
from parisph.methods.boundary import Boundary
from parisph.methods.budget import Budget
from parisph.methods.catalogue import CompressibleParts, Parts, parts_of
from parisph.methods.compressible import Compressible
from parisph.methods.flow import Flow
from parisph.methods.projection import Projection
from parisph.methods.reports import StepReport
from parisph.methods.timestep import first_step, longest_move, next_step, rest_step
from parisph.parallel.domain import Domain
from parisph.parallel.guard import Guard
from parisph.parallel.particles import Particles
from parisph.watch.passages import Passages
from parisph.watch.sampling import ProbeScene

# {dim: spacings a particle moves until particles are redistributed and sorted (parallel.domain)}; in 3D a wider halo
# would have too many ghosts
SKIN = {2: 2.0, 3: 1.0}
LIST_SKIN = 0.04  # spacings a particle moves until the neighbour lists are rebuilt
SAME_VORTICITY = 1e-6    # of the largest vorticity: greatest spread of fluid in rigid rotation
SETTLE = 10.0     # time in which weakly compressible water at rest settles before the start, over that of a fall
# of the step that fluid allows at the top speed of the case (scales.top_speed): a run that needs a shorter one has
# diverged. Dam breaks, falls against a box and free drops reach 1.7 times that speed; none reaches 50 times
SHORTEST = 0.02

Options = ParamSpec("Options")
Result = TypeVar("Result")


def _call(guard: Guard | None, name: str) -> AbstractContextManager[None]:
    return nullcontext() if guard is None else guard.call(name)


def _collective(method: Callable[Concatenate["Simulation", Options], Result]
                ) -> Callable[Concatenate["Simulation", Options], Result]:
    """Decorate a collective method of a Simulation: no rank waits in it for a failed or finished one."""
    @wraps(method)
    def call(self: "Simulation", /, *args: Options.args, **options: Options.kwargs) -> Result:
        with _call(self._guard, f"Simulation.{method.__name__}"):
            return method(self, *args, **options)
    return call


class Simulation:
    """A scene that can be advanced step by step, for scripts, notebooks and the command line.

    comm : mpi4py communicator; it is duplicated
    petsc_options : PETSc's options with the prefix pressure_
    start : Checkpoint to continue from, or None

    Attributes:
    particles : Particles, fields as numpy arrays (particles.x, .u, .p, .role, ...) of this rank
    time [s], steps, dt [s] : of the last step, dt None before the first
    timers : base.log.Timers
    passages : Passages, the water through the lines of probes
    bad_force : float or None, the first time [s] at which the body force was not finite on this rank

    All methods are collective. Raises CaseError if the case cannot be run. A failure on one rank, such as sys.exit in a
    user's function, ends all ranks (parallel.guard).
    """

    def __init__(self, case: Case, comm: MPI.Comm, petsc_options: list[str] | None = None,
                 start: Checkpoint | None = None) -> None:
        self._guard = Guard.of(comm)
        with _call(self._guard, "Simulation"):
            self._make(case, comm, petsc_options, start)

    def _make(self, case: Case, comm: MPI.Comm, petsc_options: list[str] | None, start: Checkpoint | None) -> None:
        room_file.share(comm, case)
        memory_check.check(case, comm)
        self.numerics = case.complete_numerics()
        # store the values in use: presets may change later
        self.case = case.resolved(self.numerics)
        self.comm = comm.Dup()
        self._made: list[Domain | Projection | Compressible] = []    # for `destroy`
        try:
            self._build(petsc_options, start)
        except BaseException as error:
            if self.agreed(error):
                self.destroy()
            raise

    def _build(self, petsc_options: list[str] | None, start: Checkpoint | None) -> None:
        """Make the parts of the scene. Collective."""
        case = self.case
        agree(self.comm, _other_than_first(self.comm, case, petsc_options))
        if self.comm.size > 1:
            warmup.on_one_rank_first(self.comm, Simulation, case, self.numerics)
        agree(self.comm, _wrong_code())
        self.timers = log.Timers()
        parts = _parts(case, self.comm)
        flow = self._flow(parts, start)
        self.method = _method(case, flow, parts, petsc_options)
        self._made.append(self.method)
        state = {} if start is None else start.state
        if start is not None:
            self.method.resume(state)
        self.time = 0.0 if start is None else start.time
        self.steps = 0 if start is None else start.step
        self.dt: float | None = None if start is None else start.dt or None
        self.bad_force: float | None = None
        self._length = flow_length(case)
        self._has_pressure = start is not None
        self._shortest = SHORTEST * _step_of_top_speed(case, self.numerics)
        self._chosen: tuple[float, float, float] | None = None     # (limit, step, time after it) of the next step
        self.passages = Passages(case, self.comm, state.get("passed"))
        self._open_tank = OpenTank.of(case, self.domain, state.get("left"))

    def _flow(self, parts: Parts | CompressibleParts, start: Checkpoint | None) -> Flow:
        """Return the Flow of the scene, with particles, domain and walls at the start. Collective."""
        case, s = self.case, self.numerics.spacing
        arrays = _arrays(case, self.comm) if start is None else start.arrays
        vorticity, carried = _vorticity(case, arrays, self.comm)
        self.particles = Particles(self.comm, case.dim, FieldSet((*parts.fields, *solid_walls.fields(case), *carried,
                                                                  *case.output.fields)))
        self.particles.assign({name: values for name, values in arrays.items() if name in self.particles.fields})
        elements = solid_walls.elements_of(case, self.particles)
        self.domain = Domain(self.particles, *build.domain(case), parts.reach * s, SKIN[case.dim] * s, LIST_SKIN * s,
                             closed=case.lidded, elements=elements)
        self._made.append(self.domain)
        self._same_force, self._constant_force = case.same_force_everywhere, case.constant_force
        budget = Budget(case.density, ProbeScene.of(case).gravity, parts.causes) if case.output.budget else None
        flow = Flow(self.numerics, case.density, self._force, self.particles, self.domain,
                    Boundary(elements, s), self.timers,
                    budget=budget, viscosity=case.viscosity, spin=case.spin if case.turns else None,
                    absorb=case.absorber, friction=case.friction, wave_time=wave_time(case), vorticity=vorticity,
                    axis=case.spin_axis)
        if start is None:
            solid_walls.fill(case, flow)
        else:
            solid_walls.complete(case, flow, start.arrays)
        return flow

    @property
    def wall_cells(self) -> WallCells | None:
        """The triangles of the walls for snapshots in 3D, by the ids of their nodes; None in 2D and without walls."""
        elements = self.domain.elements
        if elements is None or elements.mesh.dim == 2:
            return None
        return WallCells(elements.first + elements.mesh.elements.astype(np.int64), elements.mesh.element_body)

    @_collective
    def solve_start(self) -> int:
        """Compute the pressure at the start, without motion.

        Returns the number of particles on all ranks without contact with a free surface, which have p = 0.
        """
        with self.timers("start"):
            isolated = self.method.start(self.time)
        self._has_pressure = True
        return isolated

    @_collective
    def choose_step(self) -> float:
        """Choose the length of the next step, and return the time [s] after it, the same on all ranks.

        Output does not change it. An adaptive run meets its end: the last ten steps are shortened equally.

        Raises SolverDiverged.
        """
        self._chosen = self._choose()
        return self._chosen[-1]

    @_collective
    def advance(self) -> StepReport:
        """Take one step, of the length from `choose_step` if that was called; return its StepReport.

        Raises SolverDiverged or ParticleLost.
        """
        limit, dt, after = self._chosen or self._choose()
        self._chosen = None
        report = self.method.step(self.time, dt, limit)
        self.time = after
        self.steps += 1
        self.dt = limit     # not shortened to meet the end: a continued run must not depend on it
        self.passages.look(self.particles)    # before water leaves the scene
        if self._open_tank is not None:
            self._open_tank.let_leave(self.domain, self.time)
        if self.steps % wall_penetration.EVERY == 0:
            wall_penetration.check(self.domain)
        if self._open_tank is None:
            return report
        return replace(report, left=self.left.particles)

    @property
    def columns(self) -> dict[str, str]:
        """Columns of steps.csv with their units."""
        unit = "J/m" if self.case.dim == 2 else "J"
        return self.method.columns | {f"work_{cause}": unit for cause in self.method.flow.budget.causes}

    @property
    def left(self) -> Overflow:
        """Fluid that has left an open tank over its rim, the same on all ranks."""
        return Overflow() if self._open_tank is None else self._open_tank.left

    @property
    def reached(self) -> float:
        """Time [s] up to which output is due, with a tolerance for the rounding of many steps."""
        return self.time + self.rounding

    @property
    def nearest(self) -> float:
        """Time [s] up to which output at ends of steps is due: this end is nearer to it than the next one.

        So output changes no step. The next step is assumed to be as long as the last one.
        """
        return self.time + 0.5 * (self.dt or 0.0)

    @property
    def rounding(self) -> float:
        """Rounding error of the sum of many steps [s]."""
        return ROUNDING * (self.dt or 0.0)

    @property
    def pressure_time(self) -> float:
        """Time [s] of the pressures: in a projection, the middle of the last step."""
        found: float | None = self.method.pressure_time
        return self.time if found is None else found

    @property
    def pressure_window(self) -> float | None:
        """Averaging time [s] of pressures for steps like the last one, None if pressures are not averaged."""
        return self.method.pressure_window

    def finished(self) -> bool:
        """Return whether the end time is reached, to within half a fixed step."""
        return finished(self.case, self.time)

    @_collective
    def complete(self, names: Iterable[str]) -> None:
        """Compute the output fields among `names` that no step needs, such as "vorticity", for the current particles.

        The case must request them: Output(fields=("vorticity", ...)).
        """
        if not self.domain.n_lists:    # before the first step
            self.domain.refresh()
        written.compute(self.method.flow, [name for name in names if name in self.particles.fields], self.time)

    @_collective
    def gather(self, *names: str) -> dict[str, Array] | None:
        """Return {name: array over all particles, sorted by id} on rank 0, None elsewhere."""
        p = self.particles
        parts = self.comm.gather([np.array(getattr(p, name)) for name in ("id", *names)])
        if parts is None:
            return None
        columns = [np.concatenate(column) for column in zip(*parts)]
        order = np.argsort(columns[0])
        return {name: column[order] for name, column in zip(names, columns[1:])}

    def agreed(self, error: BaseException) -> bool:
        """Return whether all ranks have this error, so collective calls may follow."""
        return self._guard is None or (isinstance(error, ParisphError) and self._guard.on_all())

    @_collective
    def destroy(self) -> None:
        """Free the MPI and PETSc objects of this scene. A second call does nothing."""
        for part in self._made:
            part.destroy()
        if self.comm != MPI.COMM_NULL:
            self.comm.Free()

    def _choose(self) -> tuple[float, float, float]:
        """Return the limit of the step [s], the next step [s], and the time [s] after it. Collective.

        An adaptive run meets its end; with a fixed step it ends within half a step of it.
        """
        limit = self._limit()
        adaptive = self.numerics.time_step is None and not self.finished()
        return (limit, *step_towards(self.case.end_time if adaptive else np.inf, self.time, limit))

    def _limit(self) -> float:
        """Return the limit of the time step [s] by case and flow, the same on all ranks."""
        flow = self.method.flow
        dt = next_step(flow, self._strongest_force(), self.dt, self._shortest, self.method.accelerations,
                       self.method.strain_rate, self._length)
        dt = min(dt, self.method.longest_step())
        if self.numerics.time_step is not None:
            return dt
        dt = min(dt, flow.walls.longest_step(flow, self.time))
        dt = min(dt, self.case.frame.longest_step)    # a force that is small now may soon grow
        return dt if self.dt is not None else self._first(dt)

    def _first(self, dt: float) -> float:
        """Return the first step [s]; computes the pressure at the start if that is missing."""
        if not self._has_pressure:
            self.solve_start()
        p = self.particles
        fluid = p.x[p.kind == FLUID]

        def force_at(after: float) -> float:
            return _largest(self.case.body_force(fluid, self.time + after))
        return first_step(self.comm, p, self.numerics, self.method.acceleration(self.time), dt, force_at,
                          self._length)

    def _force(self, x: Floats, t: float) -> Floats:
        """Return the read-only body force (n, dim) [m/s^2] at x (n, dim) [m] and t [s].

        Record the first time at which it is not finite.
        """
        if self._constant_force is not None:    # checked by the case
            return np.broadcast_to(self._constant_force, x.shape)
        force = self.case.body_force(x[:1] if self._same_force else x, t)
        if self.bad_force is None and not np.isfinite(force).all():
            self.bad_force = t
        return np.broadcast_to(force, x.shape)

    def _strongest_force(self) -> float:
        """Return the largest body force on this rank's fluid, for an adaptive time step [m/s^2].

        A uniform force is evaluated at any one particle.
        """
        if self.numerics.time_step is not None:    # not used
            return 0.0
        p = self.particles
        where = p.x[:1] if self._same_force else p.x.compress(p.kind == FLUID, axis=0)
        return _largest(self._force(where, self.time))


def _largest(force: Floats) -> float:
    """Return the largest finite size of forces (n, dim), 0 if there is none.

    A force that is not finite does not limit the step; the step itself reports it.
    """
    size = sizes(force)
    return float(size.max(initial=0.0, where=np.isfinite(size)))


def _step_of_top_speed(case: Case, numerics: ResolvedNumerics) -> float:
    """Return the step [s] in which the fastest expected fluid, or a fall from rest, moves as far as allowed."""
    speed, rest = scales.top_speed(case), rest_step(numerics)
    return min(rest, longest_move(numerics) / speed) if 0.0 < speed < np.inf else rest


def finished(case: Case, time: float) -> bool:
    """Return whether `time` [s] is the end of the case, to within half a fixed step. Not collective."""
    slack = 0.5 * (case.numerics.time_step or 1e-9 * case.end_time)
    return time > case.end_time - slack


def _wrong_code() -> ParisphError | None:
    """Return a ParisphError if the compiler translates kernels wrongly, else None. Not collective."""
    if selfcheck.stores_hold():
        return None
    return ParisphError("numba generates wrong machine code on this processor. "
                        "Unset NUMBA_CPU_FEATURES and NUMBA_CPU_NAME, import parisph's kernels before others compile, "
                        "or install another release of numba")


def _other_than_first(comm: MPI.Comm, case: Case, petsc_options: list[str] | None) -> CaseError | None:
    """Return a CaseError if this rank has another case or other options than rank 0, else None. Collective."""
    mine = (case.model_dump(mode="json"), list(petsc_options or ()))
    first = comm.bcast(mine) if comm.size > 1 else mine
    if mine == first:
        return None
    parts = [name for name, value in mine[0].items() if value != first[0].get(name)] or ["petsc_options"]
    return CaseError(f"another case than on rank 0, in {', '.join(parts)}: make it on one rank and send it to all, "
                     "as in case = comm.bcast(case)")


def _parts(case: Case, comm: MPI.Comm) -> Parts | CompressibleParts:
    """Return the parts of the case's method. Collective. Raises CaseError for a part that does not suit the scene."""
    parts = parts_of(case.complete_numerics(), case.physics)
    error = None
    try:
        parts.check(case.dim)
        written.check(case.output.fields, case.dim)
    except CaseError as problem:
        error = problem
    agree(comm, error)
    return parts


def _method(case: Case, flow: Flow, parts: Parts | CompressibleParts,
            petsc_options: list[str] | None) -> Projection | Compressible:
    """Return the method of the case, ready to start. Collective."""
    if isinstance(parts, CompressibleParts):
        return Compressible(flow, parts, sound_speed(case), SETTLE * scales.fall_time(case),
                            ProbeScene.of(case).gravity)
    return Projection(flow, parts, petsc_options)


def _vorticity(case: Case, arrays: Mapping[str, Array], comm: MPI.Comm) -> tuple[float, tuple[str, ...]]:
    """Return the uniform vorticity [1/s] of the fluid, else 0, and its field if it has vorticity. Collective.

    Viscous fluid, or fluid with an eddy viscosity, does not keep its vorticity and has none here.
    """
    if case.viscosity or case.numerics.smagorinsky or "swirl" not in arrays:
        return 0.0, ()
    swirl = arrays["swirl"][arrays["kind"] == FLUID]
    found = comm.allgather((swirl.min(initial=np.inf), swirl.max(initial=-np.inf)))
    low, high = min(one for one, _ in found), max(one for _, one in found)
    same = high - low < SAME_VORTICITY * max(abs(low), abs(high))
    return (0.5 * (low + high) if same else 0.0, ("swirl",) if max(abs(low), abs(high)) > 0.0 else ())


def _arrays(case: Case, comm: MPI.Comm) -> dict[str, Array]:
    """Make this rank's share of the particles; an error on one rank is raised on all."""
    arrays: dict[str, Array] = {}
    error = None
    try:
        arrays = build.build(case, comm.rank, comm.size)
    except Exception as problem:
        error = CaseError(str(problem))
    agree(comm, error)
    return arrays
