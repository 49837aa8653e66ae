"""One scene in memory: particles, domain, solver and method, advanced step by step."""

from contextlib import nullcontext
from dataclasses import replace
from functools import wraps

import numpy as np
from mpi4py import MPI

from parisph.base.errors import CaseError, ParisphError, agree
from parisph.base.fields import FLUID
from parisph.case import geometry
from parisph.case.checks import stable_time_step
from parisph.driver import room, warmup
from parisph.driver.phases import PhaseTimers
from parisph.driver.rim import Left, OpenTank
from parisph.driver.schedule import ROUNDING, step_towards
from parisph.kernels import selfcheck
from parisph.methods import schemes
from parisph.methods.projection import Projection
from parisph.methods.timestep import first_step, next_step, rest_step
from parisph.parallel.guard import Guard
from parisph.parallel.neighbours import Domain
from parisph.parallel.particles import Particles
from parisph.pressure.solver import PressureSolver

SKIN = 1.0        # spacings a particle moves until particles are redistributed and sorted
LIST_SKIN = 0.04  # spacings a particle moves until the neighbour lists are rebuilt
SHORTEST = 1e-5   # of the step that the case itself asks for: what needs a shorter one is out of hand


def _call(guard, name):
    return nullcontext() if guard is None else guard.call(name)


def _collective(method):
    """A method of a Simulation that all ranks call together: no rank waits in it for one that has failed or ended."""
    @wraps(method)
    def call(self, *args, **options):
        with _call(self._guard, f"Simulation.{method.__name__}"):
            return method(self, *args, **options)
    return call


class Simulation:
    """A scene that can be advanced; for scripts and notebooks as for the command line.

    Parameters
    ----------
    case : Case
    comm : mpi4py communicator; it is duplicated
    petsc_options : list of str, PETSc's options with the prefix pressure_
    start : Checkpoint or None
        Where to go on from.

    Attributes
    ----------
    particles : Particles, fields as numpy arrays (particles.x, .u, .p, .role, ...) of this rank
    time [s], steps, dt [s] : of the last step, dt None before the first
    timers : PhaseTimers
    bad_force : float or None, the first time [s] at which the body force was no finite number here

    All methods are collective. Raises CaseError where the case cannot be run as it is. What fails on one
    rank only, such as sys.exit in a function of the user, ends all ranks (parallel.guard).
    """

    def __init__(self, case, comm, petsc_options=None, start=None):
        self._guard = Guard.of(comm)
        with _call(self._guard, "Simulation"):
            self._make(case, comm, petsc_options, start)

    def _make(self, case, comm, petsc_options, start):
        room.check(case, comm)
        self.numerics = _numerics(case)
        # what is stored is what was computed, whatever a preset becomes later
        self.case = case.resolved(self.numerics)
        self.comm, self.domain, self.solver = comm.Dup(), None, None
        try:
            self._build(petsc_options, start)
        except BaseException as error:
            if self.agreed(error):
                self.destroy()
            raise

    def _build(self, petsc_options, start):
        """Make the parts of the scene. Collective; what is made here `destroy` frees."""
        case = self.case
        agree(self.comm, _other_than_first(self.comm, case, petsc_options))
        if self.comm.size > 1:
            warmup.on_one_rank_first(self.comm, Simulation, case, self.numerics)
        agree(self.comm, _wrong_code())
        self.timers = PhaseTimers()
        self.particles = Particles(self.comm, case.dim)
        self.particles.assign(_arrays(case, self.comm) if start is None else start.arrays)
        self.time, self.steps, self.dt = (0.0, 0, None) if start is None else (start.time, start.step, start.dt or None)
        s = self.numerics.spacing
        lower, upper = geometry.domain(case)
        self.domain = Domain(self.particles, lower, upper, schemes.reach(self.numerics) * s,
                             SKIN * s, LIST_SKIN * s, closed=case.walls is not None and case.walls.lid)
        self.solver = PressureSolver(self.comm, petsc_options, self.numerics.rtol, closed=case.closed)
        self.method = Projection(self.numerics, case.fluid.density, self._force, self.particles, self.domain,
                                 self.solver, self.timers, closed=case.closed)
        self.bad_force = None
        self._has_pressure = start is not None
        self._shortest = SHORTEST * min(stable_time_step(case)[0], rest_step(self.numerics))
        self._chosen = None     # (limit, step, time after it) of the next step
        self._open_tank = OpenTank.of(case, self.domain, start.state.get("left") if start is not None else None)

    @_collective
    def solve_start(self):
        """Give the particles of the start a pressure, which no step has done yet; nothing moves.

        Returns how many particles no free surface anchors, on all ranks: they have p = 0.
        """
        with self.timers("start"):
            isolated = self.method.pressure_now(self.time)
        self._has_pressure = True
        return isolated

    @_collective
    def choose_step(self, until=None):
        """Settle how long the next `advance` is, and return the time [s] after it, the same on all ranks.

        until : a time [s] to meet exactly, None for none. As soon as it is less than two steps away the
            steps to it are shortened; nothing else changes, and the growth of an adaptive step goes on
            from the step that was not shortened.

        Raises SolverDiverged.
        """
        limit = self._limit()
        self._chosen = (limit, *step_towards(self._target(until), self.time, limit))
        return self._chosen[-1]

    @_collective
    def advance(self, until=None):
        """Take one step of the case's size, or of what `choose_step` has chosen; return its StepReport.

        until : as of choose_step, where that has not been called.

        Raises SolverDiverged or ParticleLost.
        """
        if self._chosen is None:
            self.choose_step(until)
        (limit, dt, after), self._chosen = self._chosen, None
        report = self.method.step(self.time, dt)
        self.time = after
        self.steps += 1
        self.dt = limit     # not a shorter one that meets a time: who goes on from there shall not notice
        if self._open_tank is None:
            return report
        self._open_tank.let_leave(self.domain)
        return replace(report, left=self.left.particles)

    @property
    def left(self):
        """What has left an open tank over its rim so far (driver.rim.Left), the same on all ranks; nothing leaves a closed one."""
        return Left() if self._open_tank is None else self._open_tank.left

    @property
    def reached(self):
        """Time [s] up to which things due are due now: what the sum of many steps may be off by is forgiven."""
        return self.time + ROUNDING * (self.dt or 0.0)

    def finished(self):
        """Return whether the end time is reached, to within half a fixed step."""
        return finished(self.case, self.time)

    @_collective
    def gather(self, *names):
        """Return {name: array over all particles, in the order of their ids} on rank 0, None elsewhere."""
        p = self.particles
        parts = self.comm.gather([np.array(getattr(p, name)) for name in ("id", *names)])
        if parts is None:
            return None
        columns = [np.concatenate(column) for column in zip(*parts)]
        order = np.argsort(columns[0])
        return {name: column[order] for name, column in zip(names, columns[1:])}

    def agreed(self, error):
        """Return whether an error is one that all ranks have, so that what follows may be collective."""
        return self.comm.size == 1 or (isinstance(error, ParisphError) and self._guard.on_all())

    @_collective
    def destroy(self):
        """Free what MPI and PETSc hold for this scene; once more does nothing."""
        for part in (self.domain, self.solver):
            if part is not None:
                part.destroy()
        if self.comm != MPI.COMM_NULL:
            self.comm.Free()

    def _limit(self):
        """Return the time step that the case and the flow allow [s], the same on all ranks."""
        dt = next_step(self.comm, self.particles, self.numerics, self._strongest_force(), self.dt, self._shortest)
        if self.numerics.time_step is not None:
            return dt
        dt = min(dt, self.case.frame.longest_step)    # a small force between two turns says nothing of what comes
        return dt if self.dt is not None else self._first(dt)

    def _first(self, dt):
        """Return the first step [s]; the pressure of the start is found if nobody has asked for it yet."""
        if not self._has_pressure:
            self.solve_start()
        p = self.particles
        fluid = p.x[p.kind == FLUID]

        def force_at(after):
            return float(np.linalg.norm(self.case.body_force(fluid, self.time + after), axis=1).max(initial=0.0))
        return first_step(self.comm, p, self.numerics, self.method.acceleration_now(self.time), dt, force_at)

    def _target(self, until):
        """Return the time [s] that steps must meet next, infinity if there is none.

        An adaptive run meets its end too, a fixed step comes to within half of it.
        """
        target = np.inf if until is None else until
        if self.numerics.time_step is None and not self.finished():
            target = self.case.end_time if finished(self.case, target) else target
        return target

    def _force(self, x, t):
        """Body force (n, dim) [m/s^2] at x (n, dim) and t; remembers when it was no number."""
        force = self.case.body_force(x, t)
        if self.bad_force is None and not np.isfinite(force).all():
            self.bad_force = t
        return force

    def _strongest_force(self):
        """Return the largest body force on this rank's fluid, for the time step [m/s^2]."""
        p = self.particles
        force = np.linalg.norm(self._force(p.x[p.kind == FLUID], self.time), axis=1)
        return float(force.max(initial=0.0))


def finished(case, time):
    """Return whether `time` [s] is the end of the case, to within half a fixed step. Not collective."""
    slack = 0.5 * (case.numerics.time_step or 1e-9 * case.end_time)
    return time > case.end_time - slack


def _wrong_code():
    """Return a ParisphError if kernels do not compute what they say, else None. Not collective."""
    if selfcheck.stores_hold():
        return None
    return ParisphError("numba makes wrong machine code on this processor. Unset NUMBA_CPU_FEATURES and NUMBA_CPU_NAME, "
                        "import parisph's kernels before others compile, or install another release of numba")


def _other_than_first(comm, case, petsc_options):
    """Return a CaseError if this rank has another case or other options than rank 0, else None. Collective."""
    mine = (case.model_dump(mode="json"), list(petsc_options or ()))
    first = comm.bcast(mine) if comm.size > 1 else mine
    if mine == first:
        return None
    parts = [name for name, value in mine[0].items() if value != first[0].get(name)] or ["petsc_options"]
    return CaseError(f"another case than on rank 0, in {', '.join(parts)}: make it on one rank and give it to all, "
                     "as in case = comm.bcast(case)")


def _numerics(case):
    """Return the resolved numerics; a closed case has no free surface to look for."""
    numerics = case.numerics.resolved()
    if case.closed and case.numerics.surface_rule is None:
        return numerics.model_copy(update={"surface_rule": "none"})
    return numerics


def _arrays(case, comm):
    """Build this rank's share of the particles; an error on one rank is raised on all."""
    arrays, error = None, None
    try:
        arrays = geometry.build(case, comm.rank, comm.size)
    except Exception as problem:
        error = CaseError(str(problem))
    agree(comm, error)
    return arrays
