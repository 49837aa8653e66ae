"""One scene in memory: particles, domain, solver and method, advanced step by step."""

import numpy as np

from parisph.base.errors import CaseError, agree
from parisph.base.fields import FLUID
from parisph.base.log import Timers
from parisph.case import geometry
from parisph.case.schema import Box, Case, Fluid, Tank
from parisph.methods import schemes
from parisph.methods.projection import Projection
from parisph.methods.timestep import next_step
from parisph.parallel.neighbours import Domain
from parisph.parallel.particles import Particles
from parisph.pressure.solver import PressureSolver

SKIN = 0.4        # spacings a particle moves until particles are redistributed and sorted
LIST_SKIN = 0.04  # spacings a particle moves until the neighbour lists are rebuilt
WORK = ("surface", "assemble", "correct", "regularise")  # phases whose time is this rank's own


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
    time [s], steps, dt [s] : of the last step
    timers : Timers

    All methods are collective. Raises CaseError where the case cannot be run as it is.
    """

    def __init__(self, case, comm, petsc_options=None, start=None):
        self.case, self.numerics = case, case.numerics.resolved()
        self.comm = comm.Dup()
        if self.comm.size > 1:
            self._compile_on_one_rank_first()
        self.timers = Timers()
        self.particles = Particles(self.comm, case.dim)
        self.particles.assign(_arrays(case, self.comm) if start is None else start.arrays)
        self.time, self.steps, self.dt = (0.0, 0, None) if start is None else (start.time, start.step, start.dt)
        s = self.numerics.spacing
        lower, upper = geometry.domain(case)
        self.domain = Domain(self.particles, lower, upper, schemes.SCHEMES[self.numerics.method].reach * s,
                             SKIN * s, LIST_SKIN * s, closed=case.walls is not None and case.walls.lid)
        self.solver = PressureSolver(self.comm, petsc_options, self.numerics.rtol, closed=case.closed)
        self.method = Projection(self.numerics, case.fluid.density, case.body_force, self.particles, self.domain,
                                 self.solver, self.timers, closed=case.closed)
        self._recorded = 0.0

    def advance(self):
        """Take one step of the case's size; return its StepReport."""
        dt = next_step(self.comm, self.particles, self.numerics, self._gravity(), self.dt)
        # a scene that rests in no field has no time scale of its own
        dt = min(dt, self.case.end_time / 20.0)
        if self.numerics.time_step is None and self.time < self.case.end_time < self.time + 1.001 * dt:
            dt = self.case.end_time - self.time
        report = self.method.step(self.time, dt)
        self.time += dt
        self.steps += 1
        self.dt = dt
        self._record_load()
        return report

    def finished(self):
        """Return whether the end time is reached, to within half a fixed step."""
        slack = 0.5 * (self.numerics.time_step or 1e-9 * self.case.end_time)
        return self.time > self.case.end_time - slack

    def gather(self, *names):
        """Return {name: array over all particles, in the order of their ids} on rank 0, None elsewhere."""
        p = self.particles
        parts = self.comm.gather([np.array(getattr(p, name)) for name in ("id", *names)])
        if parts is None:
            return None
        columns = [np.concatenate(column) for column in zip(*parts)]
        order = np.argsort(columns[0])
        return {name: column[order] for name, column in zip(names, columns[1:])}

    def destroy(self):
        """Free what MPI and PETSc hold for this scene."""
        self.domain.destroy()
        self.solver.destroy()
        self.comm.Free()

    def _gravity(self):
        """Return the largest body force on this rank's fluid, for the time step [m/s^2]."""
        p = self.particles
        fluid = p.kind == FLUID
        force = np.linalg.norm(self.case.body_force(p.x[fluid], self.time), axis=1)
        return float(force.max(initial=0.0))

    def _record_load(self):
        total = sum(self.timers.seconds.get(name, 0.0) for name in WORK)
        self.domain.record_load(total - self._recorded)
        self._recorded = total

    def _compile_on_one_rank_first(self):
        """Let rank 0 fill the cache of compiled kernels before the others load it."""
        if self.comm.rank == 0:
            from mpi4py import MPI

            small = Simulation(_small(self.case, self.numerics), MPI.COMM_SELF)
            small.advance()
            small.destroy()
        self.comm.Barrier()


def _arrays(case, comm):
    """Build this rank's share of the particles; an error on one rank is raised on all."""
    arrays, error = None, None
    try:
        arrays = geometry.build(case, comm.rank, comm.size)
    except Exception as problem:
        error = CaseError(str(problem))
    agree(comm, error)
    return arrays


def _small(case, numerics):
    """Return a scene of a few particles that needs the same kernels."""
    s = numerics.spacing
    tank = Tank(width=12 * s, height=12 * s, lid=True)
    return Case(title="small", fluid=Fluid(Box(width=6 * s, height=6 * s), density=1000.0), walls=tank,
                gravity=(0.0, -9.81), end_time=1.0,
                numerics=numerics.model_copy(update={"time_step": 1e-3 * np.sqrt(s), "max_time_step": None}))
