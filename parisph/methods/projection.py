"""One time step of the projection methods."""

import math
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
from mpi4py import MPI

from parisph.base.arrays import Flags, Floats, Ints
from parisph.base.fields import BALLISTIC, DRY, FLUID, SURFACE, WALL
from parisph.kernels import balance, curvature, movement, record
from parisph.methods import lengths, potential, regularising, straining, surfaces
from parisph.methods.catalogue import Parts
from parisph.methods.flow import Flow
from parisph.methods.guesses import Guesses
from parisph.methods.last_waves import LastWaves
from parisph.methods.reports import ProjectionReport
from parisph.methods.sliding import write_wall_velocity
from parisph.methods.spins import squared
from parisph.methods.step_state import StepState
from parisph.methods.stepping import SHORT, STEPPINGS, Accelerations
from parisph.methods.timestep import resolved_time
from parisph.methods.velocities import keep_in_tank
from parisph.pressure import groups
from parisph.pressure.rows import PressureRows
from parisph.pressure.solver import PressureSolver, SolveRecord

FEW = 10             # largest group of particles without a surface that gets no equation
BODIES = 4           # most bodies of fluid without a surface that get one
ROUNDING = 1e-3      # spacings within which two particles have the same height
Matrix = tuple[Ints, Ints, Floats]    # CSR
Equation = tuple[Matrix, Floats, int]    # the matrix, the right-hand side, and the number of isolated particles


class Projection:
    """A projection method on the particles of one scene.

    Parameters
    ----------
    flow : Flow
    parts : Parts of the method
    petsc_options : list of str, or None

    The driver uses `start`, `step`, `columns`, `state` and `destroy`, as of any method.

    Attributes
    ----------
    accelerations : of fluid on all ranks in an adaptive step [m/s^2]: the largest, and the root of the mean square
    mean_strain : sqrt(2 S:S) of fluid in the last step, on all ranks [1/s], 0 if no part needs it
    last_waves : its largest value in the last waves
    """

    def __init__(self, flow: Flow, parts: Parts, petsc_options: list[str] | None = None) -> None:
        self.flow, self.parts, n = flow, parts, flow.numerics
        self.stepping = STEPPINGS[n.stepping]
        self.guesses = Guesses(self.stepping.corrected)
        self.earlier_accelerations = Accelerations()
        self.accelerations, self.mean_strain, self.last_waves = (0.0, 0.0), 0.0, LastWaves()
        self.pressure_window: float | None = 0.0
        self._shear = np.empty((0, flow.particles.dim))
        self.rows = PressureRows(flow.particles.dim, parts.laplacian, parts.divergence, parts.wall_rows,
                                 n.surface_offset, lengths.MLS)
        self.solver = PressureSolver(flow.particles.comm, petsc_options, n.rtol, closed=flow.closed)
        flow.rows, flow.solver, flow.pressure_gradient = self.rows, self.solver, self.pressure_gradient
        flow.bends = not (parts.gradient.whole or parts.surface_gradient.whole)

    def step(self, time: float, dt: float, usual: float | None = None) -> ProjectionReport:
        """Advance one projection step of dt [s]: predict, solve for pressure, correct. Collective.

        usual : length of the step [s] if it were not shortened to meet a time; default dt
        """
        flow, p, timers, middle = self.flow, self.flow.particles, self.flow.timers, time + 0.5 * dt
        flow.budget.begin(p)
        with timers("predict"):
            self._predict(time, dt)
        with timers("redistribute"):
            renumbered = flow.domain.refresh("u")
        with timers("surface"):
            self._look(middle, dt, dt if usual is None else usual)
        with timers("assemble"):
            matrix, right, isolated = self._assemble(dt)
        with timers("solve"):
            guesses = self.guesses.at(p, middle)
            self.guesses.remember(p, middle)
            p.p[:], solve = self.solver.solve(*matrix, right, guesses, renumbered=renumbered)
            flow.domain.update("p")
        with timers("correct"):
            self._correct(time, dt)
        if self.parts.position_regularisers:
            with timers("regularise"):
                flow.fresh("x")
                regularising.prepare(flow, self.parts.position_regularisers, dt)
                regularising.change(flow, self.parts.position_regularisers, dt)
        with timers("record"):
            flow.fresh("u", "p")
            return self._report(dt, solve, isolated)

    def start(self, time: float) -> int:
        """Solve for the pressure at the current positions, at `time` [s]; return how many are isolated. Collective.

        This gives the pressure before the first step. An incompressible flow has lap p = rho (div g - tr((grad u)^2))
        at every instant, the divergence of Euler's equation. In a step, half of the second term comes from the strain
        source and half from div u* at positions half a step later. Here nothing moves, and the time step and its
        weights do not matter.
        """
        flow, p = self.flow, self.flow.particles
        flow.walls.move(flow, time, time, time)
        flow.domain.refresh()
        self._look(time)
        self.rows.fill(flow.step.force, flow.cloud, flow.walls.cells(flow))
        target = flow.density * (self.rows.div - self.rows.gradient_invariants(p.u_all).square)
        matrix, right, isolated = self._equation(target)
        p.p[:], _ = self.solver.solve(*matrix, right, p.p, renumbered=True)
        self.guesses.restart(time)
        return isolated

    def acceleration(self, time: float) -> Floats:
        """Return g - grad p/rho [m/s^2] of owned particles with their current pressure, 0 for walls. Collective.

        Particles stay unchanged, including the roles of those with too few neighbours.
        """
        flow, p = self.flow, self.flow.particles
        flow.walls.move(flow, time, time, time)
        flow.domain.refresh()
        flow.domain.update("p")
        role = p.role.copy()
        self._sum_forces(time)
        self._find_potential()
        found = flow.step.force[:p.n_owned] - self.gradient_of_pressure() / flow.density
        p.role[:] = role
        found[p.kind != FLUID] = 0.0
        return found

    @contextmanager
    def shown(self) -> Iterator[None]:
        """Give particles the pressure that a snapshot shows, within this context. Not collective.

        After a step far shorter than usual it is the mean over the usual time, because the residual divergence is
        removed in one step of any length, with a pressure that grows as 1/dt.
        """
        p, step = self.flow.particles, self.flow.step
        share = step.dt / max(step.usual, float(np.finfo(float).tiny))
        acted = p.p.copy()
        if 0.0 < share < SHORT:
            p.p[:] = p.p_before + share * (p.p - p.p_before)
        try:
            yield
        finally:
            p.p[:] = acted

    def longest_step(self) -> float:
        """Return the longest step [s] that the parts of the method allow, infinite without a limit. Collective."""
        limiting = [part for part in self.parts if part.limits_step]
        if not limiting:
            return np.inf
        mine = min(part.longest_step(self.flow) for part in limiting)
        found: float = self.flow.particles.comm.allreduce(mine, op=MPI.MIN)
        return found

    @property
    def pressure_time(self) -> float | None:
        """Time [s] of the last pressure: the middle of its step. None before the first."""
        return self.guesses.times[0] if self.guesses.times else None

    @property
    def strain_rate(self) -> float:
        """Mean sqrt(2 S:S) of fluid in the last step, on all ranks [1/s]; with `wave_step` the largest of the last
        waves."""
        return self.last_waves.largest if self.flow.numerics.wave_step else self.mean_strain

    @property
    def columns(self) -> dict[str, str]:
        """Columns of steps.csv with their units."""
        return ProjectionReport.columns()

    def state(self) -> dict[str, Any]:
        """Return the state for a checkpoint, besides the particles. Not collective."""
        largest, mean = self.accelerations
        return {"acceleration": largest, "rms_acceleration": mean, "mean_acceleration": self.flow.mean_acceleration,
                "mean_strain": self.mean_strain, "last_waves": self.last_waves.state(),
                "pressure_times": self.guesses.times,
                "acceleration_times": self.earlier_accelerations.times}

    def resume(self, state: dict[str, Any]) -> None:
        """Continue from the state in a checkpoint. Not collective."""
        self.accelerations = state.get("acceleration", 0.0), state.get("rms_acceleration", 0.0)
        self.flow.mean_acceleration = state.get("mean_acceleration", 0.0)
        self.mean_strain = state.get("mean_strain", 0.0)
        self.last_waves.resume(state.get("last_waves", self.last_waves.state()))
        self.guesses.times = list(state.get("pressure_times", ()))
        if self.stepping.corrected:
            self.earlier_accelerations.times = list(state.get("acceleration_times", ()))

    def about(self) -> dict[str, str | None]:
        """Return the options of PETSc in use."""
        return self.solver.options

    def destroy(self) -> None:
        """Free the PETSc objects. Collective."""
        self.solver.destroy()

    # -- the parts of the step, in order ---------------------------------------------------

    def _predict(self, time: float, dt: float) -> None:
        """Move particles and walls to the positions at which operators are evaluated."""
        p = self.flow.particles
        p.x0[:] = p.x
        if self.stepping.ahead:
            ahead = self.stepping.ahead * dt * p.u
            if self.stepping.corrected:
                ahead += self.earlier_accelerations.ahead(p, time + 0.5 * dt, dt, self.flow.wave_time)
            movement.add_to_fluid(p.x, ahead, p.kind)
        self.flow.walls.move(self.flow, time + self.stepping.ahead * dt, time, time + dt)

    def _look(self, time: float, dt: float = 0.0, usual: float = 0.0) -> None:
        """Compute the forces, the surface, the velocity of walls and the potential; arguments as of `_sum_forces`."""
        self._sum_forces(time, dt, usual)
        surfaces.classify(self.flow, self.parts.surface, dt)
        self._wall_velocity()
        self.flow.domain.update("role", "u")
        self._find_potential()

    def _sum_forces(self, time: float, dt: float = 0.0, usual: float = 0.0) -> None:
        """Begin a StepState with the forces at a time [s], in the middle of a step of dt [s]. usual : see `step`"""
        flow, comm = self.flow, self.flow.particles.comm
        flow.step = step = StepState(flow.particles, time, dt, usual)
        for force in self.parts.forces:
            force.add(step.force, flow, time)
        if not flow.bends:
            step.varies = step.uneven if comm.size == 1 else comm.allreduce(step.uneven, op=MPI.LOR)

    def _wall_velocity(self, later: float = 0.0) -> None:
        """Write the velocity of walls at a time [s] after the start of the step.

        Their shear is that of the first call in a step, as places, normals and rotations stay until `_move`.
        """
        if not later:
            self._shear = self.flow.wall_shear(self.flow.step.time)
        write_wall_velocity(self.flow, self._shear, later)

    def _find_potential(self) -> None:
        """Fit a potential flow to the velocity if a part needs it and the fluid is inviscid."""
        flow = self.flow
        needed = any(part.needs_potential for part in self.parts.velocity_regularisers) and not flow.viscous
        flow.step.potential = potential.find(flow) if needed else None

    def _assemble(self, dt: float) -> Equation:
        """Return the equation with the source at inner particles, and Eq. 25 (2014 paper) at wet walls. Collective."""
        flow = self.flow
        self.rows.fill(flow.particles.u_all + dt * flow.step.force, flow.cloud, flow.walls.cells(flow))
        return self._equation(self.parts.source.target(flow, dt))

    def _equation(self, target: Floats) -> Equation:
        """Return (CSR matrix, right-hand side, isolated) for lap p = target (n_owned,) [Pa/m^2]. Collective.

        At wet walls n . grad p = rho n . (force - a) replaces the target, with the acceleration a of fluid that slides
        along the wall in the step.
        """
        p, force, rows, cloud = self.flow.particles, self.flow.step.force, self.rows.rows, self.rows.cloud
        if not self.parts.laplacian.linear:
            balance.add_linear_part(target, rows, cloud, force, self.flow.density)
        moved = self.flow.walls.normal_acceleration(self.flow)
        balance.wall_targets(target, cloud, force, np.empty(0) if moved is None else moved, self.flow.density)
        right = self.rows.right_hand_side(target)
        self._balance_walls(right, moved)
        self._find_laplacian()
        matrix, isolated = self._matrix()
        balance.without_equation(right, p.role)
        self.parts.wall_rows.complete(right, rows, cloud, self.flow)
        if self.flow.stressed:
            self.rows.add_surface_values(right, p.surface_pressure_all)
        return matrix, right, isolated

    def _find_laplacian(self) -> None:
        """Write the Laplacian of the pressure, for parts that need it. Collective.

        It is rho (div F - tr(G^2)) with the force F and the velocity gradient G at inner particles, and their mean at
        walls and the surface. F excludes the body force, which parts know (Flow.pull), unless a part wants the whole.
        In a potential flow tr(G^2) is known everywhere; a tank rotating with W adds W x to G, minus half of the fluid's
        uniform vorticity.
        """
        flow = self.flow
        if not flow.bent:
            return
        p, step, fit = flow.particles, flow.step, flow.step.potential
        p.laplacian[:] = 0.0
        if flow.bends or len(self.parts.forces) > 1 or step.varies:
            self.rows.divergence(p.laplacian, step.force - step.body_force if flow.bends else step.force)
        if fit is None:
            p.laplacian -= self.rows.gradient_invariants(p.u_all).square
        p.laplacian *= flow.density
        if fit is None or len(self.parts.forces) > 1 or step.varies:
            flow.domain.update("laplacian")
            curvature.continue_laplacian(p.laplacian_all, flow.cloud, lengths.WALL * flow.spacing)
        if fit is not None:
            p.laplacian -= flow.density * (fit.square - 2.0 * squared(potential.turning_rate(flow), p.dim))

    def _balance_walls(self, right: Floats, moved: Floats | None) -> None:
        """Make wall rows that are not normal derivatives exact for water that moves with the wall.

        The pressure then has the normal derivative of other rows, on a rotating wall too.

        moved : (n_owned,) normal acceleration of the wall's fluid [m/s^2], None if no wall moves
        """
        p = self.flow.particles
        pull, wall = self.flow.step.force[:p.n_owned], self.flow.walls.acceleration(self.flow)
        if wall is not None:
            pull = pull - wall - (moved - np.einsum("ia,ia->i", p.normal, wall))[:, None] * p.normal
        balance.add_linear_part_at_walls(right, self.rows.rows, self.rows.cloud, pull, self.flow.density)

    def _matrix(self) -> tuple[Matrix, int]:
        """Return the CSR matrix, and the number of rows without a link to a free surface. Collective.

        The level of their pressure is arbitrary. If water has closed its last air gap below a lid, no row has such a
        link: then p = 0 at the highest particle. A few isolated rows all get p = 0.
        """
        flow = self.flow
        p, d = flow.particles, flow.domain
        self.solver.release()
        if flow.closed:
            return self.rows.csr(d.global_rows)[:3], 0
        matrix, alone, count = self._anchored()
        left = count
        for _ in range(BODIES):
            if left <= FEW:
                break
            top = groups.highest(p.comm, alone & (p.kind == FLUID), p.x, flow.step.force[:p.n_owned], p.id,
                                 ROUNDING * flow.spacing)
            p.role[top] = SURFACE
            self.rows.pin(top)
            d.update("role")
            del matrix    # saves memory
            matrix, alone, left = self._anchored()
        if left:
            p.role[alone] = np.where(p.kind[alone] == WALL, DRY, BALLISTIC)
            d.update("role")
            del matrix
            matrix = self.rows.csr(d.global_rows)[:3]
        return matrix, count

    def _anchored(self) -> tuple[Matrix, Flags, int]:
        """Return the rows as CSR, those without a link to p = 0, and their number on all ranks. Collective."""
        p = self.flow.particles
        indptr, indices, values, anchored = self.rows.csr(self.flow.domain.global_rows)
        return (indptr, indices, values), *groups.isolated_rows(p.comm, p.offset, indptr, indices, anchored)

    def _correct(self, time: float, dt: float) -> None:
        """Correct the velocity by the pressure, regularise it, and move with it. Collective."""
        flow, p, budget = self.flow, self.flow.particles, self.flow.budget
        start = p.u.copy()
        self._correct_velocity(dt)
        budget.mark(p, "pressure")
        for force in self.parts.forces:
            if force.cause and budget.causes:
                budget.move("pressure", force.cause, force.work(flow, start))
        self._regularise_velocity(dt)
        if flow.returned:
            self._write_residual(dt)
        self._move(start, time, dt)
        budget.mark(p, "pressure")

    def _correct_velocity(self, dt: float) -> None:
        """Add dt (g - grad p/rho) to u, Eqs. 14 and 15 (2014 paper)."""
        flow, step = self.flow, self.flow.step
        p, grad = flow.particles, self.gradient_of_pressure()
        acceleration = np.empty_like(grad)
        movement.accelerate(p.u, acceleration, step.by_pressure, grad, step.force, flow.density, dt, p.kind)
        moved = flow.walls.acceleration(flow)
        if moved is not None:
            p.u += dt * moved
        if self.stepping.corrected:
            self.earlier_accelerations.remember(p, acceleration, step.time, dt, step.usual)
        elif flow.accelerated:
            movement.give_to_fluid(p.acceleration, acceleration, p.kind)
        flow.stale.add("u")
        if flow.numerics.time_step is None:
            self.accelerations = _of_all(p.comm, *record.fluid_sizes(acceleration, p.kind))

    def _regularise_velocity(self, dt: float) -> None:
        """Regularise the velocity, and measure the strain of the step if a part needs it, with the same message."""
        flow, regularisers, strains = self.flow, self.parts.velocity_regularisers, self.parts.measures_strain
        flow.fresh("role", "u")
        if strains:
            straining.begin(flow, any(part.needs_fit for part in regularisers))
        regularising.prepare(flow, regularisers, dt)
        if strains:
            straining.finish(flow, dt)
        regularising.change(flow, regularisers, dt)

    def _window(self, acceleration: float) -> float:
        """Return the time [s] over which probes average the pressure around a step. Collective.

        A step of usual length has its own mean. A step shortened to meet a time may share one.

        It is twice `pressure_mean`, as fluid comes to a wall in layers, a spacing apart instead of the .3 spacings of
        the resolved time (`timestep`). P2 of the dam break at H/s = 40, three starts: errors of .057 and .056 with
        adaptive steps and half of them; .061 and .058 with 1 instead of 2, .057 and .057 with 4.

        acceleration : mean acceleration of fluid by pressure in this step, on all ranks [m/s^2]
        """
        flow = self.flow
        p, mean = flow.particles, flow.numerics.pressure_mean
        time = mean * resolved_time(p.comm, p, flow.spacing, flow.step.force[:p.n_owned], acceleration,
                                    flow.walls.acceleration(flow)) if mean else 0.0
        return max(2.0 * time, SHORT * flow.step.usual)

    def pressure_gradient(self, f: Floats, slope: Floats | None = None,
                          laplacian: Floats | None = None) -> Floats:
        """Return the gradient of a pressure-like field (n_all,) at owned fluid particles: (n_owned, dim). Collective.

        A particle with too few neighbours gets a zero gradient, and becomes ballistic.

        slope : (n_all, dim), gradient across walls; laplacian : (n_owned,) of f; default 0
        """
        out = np.empty_like(self.flow.particles.u)
        self.parts.gradient.write(out, f, self.flow, slope, laplacian)
        self.parts.surface_gradient.write(out, f, self.flow, slope, laplacian)
        self.flow.stale.add("role")
        return out

    def gradient_of_pressure(self) -> Floats:
        """Return the gradient of the flow's pressure at owned fluid particles (n_owned, dim) [Pa/m]. Collective."""
        flow = self.flow
        bent = flow.particles.laplacian if flow.bent else None
        out = self.pressure_gradient(flow.particles.p_all, flow.density * flow.step.force, bent)
        self.parts.gradient.complete(out, flow)
        self.parts.surface_gradient.complete(out, flow)
        return out

    def _write_residual(self, dt: float) -> None:
        """Write the divergence of the new velocity with the operators of the step. Collective.

        Walls have their velocity at the end of the step. With that at its start, water beside a moving wall seems to
        change its volume in proportion to dt: waves in a tank that sways then differ by .8 % from those computed in
        the frame of the tank, instead of by .02 %.
        """
        flow = self.flow
        flow.fresh("u")
        self._wall_velocity(dt)
        flow.domain.update("u")
        self.rows.divergence(flow.particles.left, flow.particles.u_all)

    def _move(self, start: Floats, time: float, dt: float) -> None:
        """Move particles by the trapezoid of Eq. 16, or by the new velocity, and walls to the end of the step."""
        p = self.flow.particles
        u = p.u if self.stepping.new else keep_in_tank(self.flow, 0.5 * (start + p.u), dt)
        movement.give_to_fluid(p.x, p.x0 + dt * u, p.kind)
        self.flow.walls.move(self.flow, time + dt, time, time + dt)
        self.flow.stale.add("x")

    def _report(self, dt: float, solve: SolveRecord, isolated: int) -> ProjectionReport:
        flow = self.flow
        p, step = flow.particles, flow.step
        div = p.left if flow.returned else np.empty(p.n_owned)
        if not flow.returned:    # otherwise `left` holds it
            self.rows.divergence(div, p.u_all)
        sums = np.array([*record.step_sums(div, p.role, p.kind, step.by_pressure, step.strained), step.collisions])
        if p.comm.size > 1:
            p.comm.Allreduce(MPI.IN_PLACE, sums, op=MPI.SUM)
        squares, count, surface, roots, particles, strain, collisions = sums
        self.mean_strain = float(strain / max(particles, 1.0)) / dt
        acceleration = float(roots / max(particles, 1.0)) ** 2
        self.last_waves.take(self.mean_strain, dt, flow.wave_time)
        straining.remember(flow, acceleration, dt)
        self.pressure_window = self._window(acceleration)
        second = step.position_solve
        again: dict[str, Any] = {} if second is None else {"position_iterations": second.iterations,
                                           "position_residual": second.residual, "position_fallback": second.fallback}
        return ProjectionReport(dt, int(surface), 0, flow.budget.works(p.comm), solve.iterations, solve.residual,
                                solve.reason, solve.fallback, solve.rebuilt, solve.setup_seconds, solve.solve_seconds,
                                float(np.sqrt(squares / max(count, 1.0))) * dt, isolated, int(collisions), **again)


def _of_all(comm: MPI.Comm, largest: float, squares: float, count: float) -> tuple[float, float]:
    """Return the largest size on all ranks, and the root of the mean square. Collective.

    largest, squares, count : of this rank: the largest size, the sum of squares, and the number
    """
    if comm.size > 1:
        top, sums = np.array([largest]), np.array([squares, count])
        comm.Allreduce(MPI.IN_PLACE, top, op=MPI.MAX)
        comm.Allreduce(MPI.IN_PLACE, sums, op=MPI.SUM)
        largest, (squares, count) = float(top[0]), sums
    return largest, math.sqrt(squares / max(count, 1.0))
