"""One time step of the projection methods, ISPH and ISPH_R."""

from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from mpi4py import MPI

from parisph.base.fields import ABSENT, BALLISTIC, DRY, FLUID, INNER, SURFACE, WALL, WET
from parisph.kernels import gradient as gradients
from parisph.kernels import surface as surfaces
from parisph.kernels import wetness
from parisph.kernels.jit import axes_of
from parisph.methods import regularise, schemes
from parisph.methods.budget import NoBudget
from parisph.methods.timestep import resolved_time
from parisph.pressure import groups
from parisph.pressure.rows import PressureRows

REGAIN = 1.5         # times the floor of the gradient: when free flight of a kept surface ends
FEW = 10             # particles without a surface that are not worth an equation
BODIES = 4           # bodies of fluid without a surface, at most, that get one
ROUNDING = 1e-3      # spacings within which two particles are equally high
STRAIN_LIMIT = 0.01  # largest change of volume in a step that the strain source answers


@dataclass(frozen=True)
class StepReport:
    """The results of one step: a line of steps.csv.

    dt [s]; iterations, residual, reason, fallback, rebuilt, setup_seconds and solve_seconds of
    the pressure solve; divergence: rms of div u after the step times dt; surface: number of fluid
    particles with p = 0; isolated: particles in groups without contact with a free surface; collisions:
    pairs that collided; position_iterations, position_residual, position_fallback: of the second
    solve, for the position projection; 0, 0 and "" without one; left: particles that have left an
    open tank over its rim since the start of the run; works: None, or the energy that the fluid gained by each
    part of the step, {column: J, in 2D J/m} (methods.budget).
    """

    dt: float
    iterations: int
    residual: float
    reason: int
    fallback: str
    rebuilt: bool
    setup_seconds: float
    solve_seconds: float
    divergence: float
    surface: int
    isolated: int
    collisions: int
    position_iterations: int = 0
    position_residual: float = 0.0
    position_fallback: str = ""
    left: int = 0
    works: dict[str, float] | None = None

    def line(self) -> dict[str, Any]:
        """Return {column: value} of its line in steps.csv."""
        found = {field.name: getattr(self, field.name) for field in fields(self)}
        return found | (found.pop("works") or {})


class Projection:
    """A projection method on the particles of one scene.

    Parameters
    ----------
    numerics : resolved Numerics (every option has a value)
    density : float [kg/m^3]
    acceleration : callable (x (n, dim), t) -> (n, dim)
        The body force per unit mass in the tank's frame [m/s^2].
    particles, domain, solver, timers : the state of this run
    closed : bool
        Whether the fluid fills a closed tank: no free surface.
    budget : Budget or None
        Measures the energy that the fluid gains by each part of a step.
    """

    def __init__(self, numerics, density, acceleration, particles, domain, solver, timers, closed=False, budget=None):
        self.numerics, self.density, self.acceleration = numerics, density, acceleration
        self.particles, self.domain, self.solver, self.timers = particles, domain, solver, timers
        self.closed, self.budget = closed, budget or NoBudget()
        self.spacing = numerics.spacing
        self.axes = axes_of(particles.dim)
        scheme = schemes.SCHEMES[numerics.method]
        radii = {"circle": schemes.CIRCLE, "mls": schemes.MLS, "wall": schemes.WALL, "sph": schemes.SPH}
        self.top_acceleration = 0.0     # of fluid in the last step, on all ranks [m/s^2]; known with an adaptive step
        self.by_pressure = 0.0          # acceleration of owned particles by pressure alone, in this step [m/s^2]
        self.doubt = None               # of owned particles in their density error near the surface, in this step
        self.rapid = None               # how rapid the strain around owned particles is in this step, 0 to 1
        self.knows_pressure = False     # whether particles have the pressure of an earlier step, or of the start
        self.rows = PressureRows(particles.dim, scheme, numerics.wall_rows, numerics.surface_offset,
                                 self.spacing, radii)
        self.full = surfaces.lattice_sum(self.spacing, schemes.DENSITY * self.spacing, self.axes)
        self.needs_alpha = (numerics.surface_rule in ("gap", "auxiliary", "density")
                            or numerics.gamma > 0.0 or numerics.kappa > 0.0)

    def step(self, time, dt, usual=None):
        """Advance one projection step of dt [s]: predict, solve for pressure, correct. Collective.

        usual : float, the step [s] that would be taken if none were shortened to meet a time; default dt
        """
        p, timers, budget = self.particles, self.timers, self.budget
        budget.begin(p)
        with timers("predict"):
            self._predict(dt)
        with timers("redistribute"):
            renumbered = self.domain.refresh()
            self.domain.update("u")
        with timers("surface"):
            force = self.acceleration(p.x_all, time + 0.5 * dt)
            self._classify(force, dt)
            self._wall_velocity()
            self.domain.update("role", "u")
        with timers("assemble"):
            matrix, right, isolated = self._assemble(force, dt)
        with timers("solve"):
            earlier = p.p.copy()
            p.p[:], solve = self.solver.solve(*matrix, right, p.p, renumbered=renumbered)
            self.domain.update("p")
        with timers("correct"):
            start = p.u.copy()
            self._correct_velocity(force, dt)
            budget.mark(p, "pressure")
            strained = regularise.strain_of_step(self, dt)
            collisions = regularise.velocity(self, dt, strained)
            self._move(start, dt)
            budget.mark(p, "pressure")
        positions = None
        if self.numerics.kappa > 0.0 or self.numerics.shift > 0.0:
            with timers("regularise"):
                positions = regularise.positions(self, strained)
        over = self._mean_time(force, dt, usual)
        if dt < over and self.knows_pressure:
            self._average_pressure(earlier, dt / over)
        self.knows_pressure = True
        with timers("record"):
            divergence = self._divergence() * dt
        return self._report(dt, solve, divergence, isolated, collisions, positions)

    def pressure_now(self, time):
        """Solve for the pressure at the current positions, at `time` [s]; return the number of isolated particles. Collective.

        This gives the pressure at the start of a run, before any step. An incompressible flow has lap p =
        rho (div g - tr((grad u)^2)) at every instant, the divergence of Euler's equation. In a step, half
        of the second term comes from the strain source and half from div u* at positions half a step
        later. Here nothing moves, and neither a time step nor its weights matter.
        """
        p = self.particles
        self.domain.refresh()
        force = self.acceleration(p.x_all, time)
        self._classify(force, 0.0)
        self._wall_velocity()
        self.domain.update("role", "u")
        self._fill(force)
        invariant = np.empty(p.n_owned)
        self.rows.second_invariant(invariant, p.u_all, p.role_all)
        target = self.density * (self.rows.div[:p.n_owned] - invariant)
        matrix, right, isolated = self._equation(target, force)
        p.p[:], _ = self.solver.solve(*matrix, right, p.p, renumbered=True)
        self.knows_pressure = True
        return isolated

    def acceleration_now(self, time):
        """Return g - grad p/rho [m/s^2] of owned particles with their current pressure, 0 for walls. Collective.

        Nothing changes, not even the role of a particle with too few neighbours.
        """
        p = self.particles
        self.domain.refresh()
        self.domain.update("p")
        role = p.role.copy()
        found = self.acceleration(p.x_all, time)[:p.n_owned] - self.pressure_gradient(p.p_all) / self.density
        p.role[:] = role
        self.domain.update("role")
        found[p.kind != FLUID] = 0.0
        return found

    # -- the parts of the step, in order ---------------------------------------------------

    def _predict(self, dt):
        """Move to the positions at which operators are evaluated (midpoint: r^n + dt/2 u^n is neutral)."""
        p, stepping = self.particles, self.numerics.stepping
        p.x0[:] = p.x
        ahead = {"midpoint": 0.5 * dt, "start": 0.0, "predicted": dt, "symplectic": 0.0}[stepping]
        if ahead:
            fluid = p.kind == FLUID
            p.x[fluid] += ahead * p.u[fluid]

    def _classify(self, force, dt):
        """Find the free surface, unless it keeps its particles, and the wet walls.

        force : (n_all, dim) [m/s^2], dt [s]: of the step that begins
        """
        p, d, n = self.particles, self.domain, self.numerics
        if n.surface_rule == "none":
            p.role[:] = np.where(p.kind == FLUID, INNER, WET)
            return
        wetness.closing_walls(p.closing_all, p.role_all, p.x_all, p.u_all, force, p.kind_all, p.normal_all,
                              self.spacing, dt, d.indptr, d.indices, self.axes)
        d.update("closing")
        seen = self.seen(wetness.CLOSING)
        if self.needs_alpha:
            surfaces.density_ratio(p.alpha, p.x_all, seen, p.corner_all, p.normal_all,
                                   schemes.DENSITY * self.spacing, self.full, d.indptr, d.indices, self.axes)
        if n.surface_rule == "frozen":
            self._keep_surface()
        else:
            self._find_surface(seen)
        d.update("role")
        # also for a frozen surface: it falls and rises past the nodes of the walls
        wetness.wet_walls(p.role_all, p.closing_all, p.x_all, p.kind_all, p.corner_all, p.normal_all, self.spacing,
                          d.indptr, d.indices, self.axes)

    def seen(self, closing):
        """Return kind (n_all,) with the walls ABSENT that are less than `closing` (wetness.FREE or CLOSING)."""
        p = self.particles
        return np.where((p.kind_all == WALL) & (p.closing_all < closing), np.int8(ABSENT), p.kind_all)

    def _keep_surface(self):
        """Give fluid its initial role, also particles that have flown freely and have neighbours again."""
        p, d = self.particles, self.domain
        radius, power, floor = self._gradient_form()
        p.role[:] = np.where((p.kind == FLUID) & (p.role != BALLISTIC), p.start_role, p.role)
        gradients.regain_role(p.role_all, p.start_role, p.x_all, radius, power, REGAIN * floor, d.indptr, d.indices, self.axes)

    def _find_surface(self, kind):
        p, d, n = self.particles, self.domain, self.numerics
        was = p.role_all.copy()
        where = (p.x_all, kind, p.corner_all, p.normal_all, p.alpha)
        if n.surface_rule == "gap":
            surfaces.surface_by_gap(p.role_all, was, *where, schemes.SURFACE_GAP * self.spacing, 2.3, 1.4, 0.55,
                                    d.indptr, d.indices, self.axes)
        elif n.surface_rule == "auxiliary":
            surfaces.surface_by_auxiliary_functions(p.role_all, was, *where, schemes.WALL * self.spacing, 0.9,
                                                    d.indptr, d.indices, self.axes)
        else:
            surfaces.surface_by_density(p.role_all, p.kind_all, p.alpha, 0.9, d.indptr)

    def _wall_velocity(self):
        p, d = self.particles, self.domain
        gradients.wall_velocity(p.u_all, p.x_all, p.kind_all, p.corner_all, p.normal_all, p.role_all,
                                np.zeros_like(p.u), schemes.WALL * self.spacing, d.indptr, d.indices, self.axes)

    def _assemble(self, force, dt):
        """Rows and right-hand side: Eq. 19 at inner particles, Eq. 25 at wet walls (2014 paper)."""
        p, n = self.particles, self.numerics
        self._fill(p.u_all + dt * force)
        zeta = min(1.0, dt / n.zeta_time) if n.zeta_time else n.zeta
        strain = self._strain(dt) if n.strain > 0.0 or n.residual_strain > 0.0 else 0.0
        divergence = self.rows.div[:p.n_owned]
        if n.residual_strain > 0.0:
            divergence = divergence - self._put_off(force, dt, strain)
        target = self.density / dt * zeta * divergence
        if n.gamma > 0.0:
            target -= n.gamma * self.density / dt**2 * regularise.compression(self, p.alpha, np.zeros(p.n_owned))
        target -= n.strain * self.density * strain
        return self._equation(target, force)

    def _put_off(self, force, dt, strain):
        """Return the part of the divergence that is left to later steps (n_owned,) [1/s].

        Rows and gradients do not match exactly: a pressure solve leaves a part of the divergence, near the surface
        most of it, and in some stencils it makes it grow. Regularisation and changes of role add to it. Taken
        out anew in each step, the residual acts per step and not per time: as dt -> 0 its pressure grows as 1/dt,
        and damping in proportion to strain can no longer stop it. So it is removed at a rate in time, in proportion to
        the fluid's velocity gradient or to its free fall; a step of usual length still removes all of it. Forces and
        the strain of the flow itself, thus also impacts, act at once.

        strain : (n_owned,) of `_strain`; the step before has aimed at a divergence of `numerics.strain` dt times it, which the
            flow since then has reduced by 2 dt times it. Exact also after a step of another length if strain is 1
        """
        p, n = self.particles, self.numerics
        residual, rate = np.empty(p.n_owned), np.empty(p.n_owned)
        self.rows.divergence(residual, p.u_all, p.role_all)
        residual += (2.0 - n.strain) * dt * strain
        self.rows.turnover(rate, p.u_all, p.role_all)
        fall = np.sqrt(np.linalg.norm(force[:p.n_owned], axis=1) / self.spacing)
        return (1.0 - np.minimum(1.0, n.residual_strain * dt * np.maximum(rate, fall))) * residual

    def _fill(self, velocity):
        """Fill the rows, and the flux divergence of a velocity or body force (n_all, dim)."""
        p, d = self.particles, self.domain
        self.rows.fill(velocity, p.x_all, p.kind_all, p.role_all, p.volume_all, p.normal_all, d.indptr, d.indices)

    def _equation(self, target, force):
        """Return (CSR matrix, right-hand side, isolated) for lap p = target (n_owned,) [Pa/m^2]. Collective.

        At wet walls n . grad p = rho n . force, and the target is ignored.
        """
        p = self.particles
        walls = p.role == WET
        target[walls] = self.density * np.einsum("ia,ia->i", p.normal[walls], force[:p.n_owned][walls])
        right = self.rows.right_hand_side(target)
        matrix, isolated = self._matrix(force)
        right[(p.role != INNER) & (p.role != WET)] = 0.0
        return matrix, right, isolated

    def _strain(self, dt):
        """Return tr((grad u)^2)/2 [1/s^2], the effect of a step in straight lines on volume.

        Particles move from one set of operators to the next by dt u, which changes a volume by the factor
        det(1 + dt grad u) = 1 + dt div u - dt^2/2 tr((grad u)^2) + ... With div u = 0 a straining flow
        shrinks: the dam break loses 4 % of its volume until the impact. div u = dt/2 tr((grad u)^2)
        conserves it. The value is limited to the range in which the expansion is valid.
        """
        p = self.particles
        out = np.empty(p.n_owned)
        self.rows.second_invariant(out, p.u_all, p.role_all)
        return np.clip(0.5 * out, -STRAIN_LIMIT / dt**2, STRAIN_LIMIT / dt**2)

    def _matrix(self, force):
        """Return the CSR matrix, and the number of rows without a link to a free surface. Collective.

        The level of their pressure is arbitrary. If water has closed its last gap of air below a lid, no
        row has such a link: then p = 0 at the highest particle. If they are only a few, they all get p = 0.
        """
        p, d = self.particles, self.domain
        if self.closed:
            return self.rows.csr(p.role_all, d.global_rows)[:3], 0
        matrix, alone, count = self._anchored()
        left = count
        for _ in range(BODIES):
            if left <= FEW:
                break
            top = groups.highest(p.comm, alone & (p.kind == FLUID), p.x, force[:p.n_owned], p.id, ROUNDING * self.spacing)
            p.role[top] = SURFACE
            self.rows.pin(top)
            d.update("role")
            matrix, alone, left = self._anchored()
        if left:
            p.role[alone] = np.where(p.kind[alone] == WALL, DRY, BALLISTIC)
            d.update("role")
            matrix = self.rows.csr(p.role_all, d.global_rows)[:3]
        return matrix, count

    def _anchored(self):
        """Compress the rows to CSR; return it, its rows without a link to p = 0, and their number on all ranks. Collective."""
        p = self.particles
        *matrix, anchored = self.rows.csr(p.role_all, self.domain.global_rows)
        alone = groups.isolated_rows(p.comm, p.offset, matrix[0], matrix[1], anchored)
        return matrix, alone, p.comm.allreduce(int(alone.sum()))

    def _correct_velocity(self, force, dt):
        """u = u + dt (g - grad p/rho), Eqs. 14 and 15 (2014 paper)."""
        p = self.particles
        grad = self.pressure_gradient(p.p_all)
        fluid = p.kind == FLUID
        acceleration = force[:p.n_owned][fluid] - grad[fluid] / self.density
        self.by_pressure = np.linalg.norm(grad, axis=1) / self.density
        p.u[fluid] += dt * acceleration
        if self.numerics.time_step is None:
            mine = float(np.sqrt((acceleration**2).sum(axis=1).max(initial=0.0)))
            self.top_acceleration = p.comm.allreduce(mine, op=MPI.MAX)

    def _mean_time(self, force, dt, usual):
        """Return the time [s] over which the pressure of a step of dt is averaged; 0 for its own pressure. Collective."""
        p, n = self.particles, self.numerics
        shortened = usual if usual is not None and dt < 0.5 * usual else 0.0
        if not n.pressure_mean:
            return shortened
        return max(shortened, n.pressure_mean * resolved_time(p.comm, p, self.spacing, force[:p.n_owned][p.kind == FLUID]))

    def _average_pressure(self, earlier, share):
        """Leave a mean over time as the pressure after a short step, of which this step has the given share. Collective.

        The pulse of a particle that comes to a wall or to the surface acts in one step of any length. The velocity
        needs its whole impulse, but as a pressure it would grow without bound as dt -> 0.
        """
        p = self.particles
        solved = (p.role == INNER) | (p.role == WET) | ((p.role == SURFACE) & (self.numerics.surface_offset > 0.0))
        p.p[solved] = earlier[solved] + share * (p.p[solved] - earlier[solved])
        self.domain.update("p")

    def pressure_gradient(self, f):
        """Return the gradient of a pressure-like field (n_all,) at owned fluid particles: (n_owned, dim). Collective.

        A particle with too few neighbours has a zero gradient, and becomes ballistic.
        """
        p, d = self.particles, self.domain
        out = np.empty_like(p.u)
        if self.numerics.gradient == "symmetric":
            gradients.symmetric_gradient(out, f, p.x_all, p.role_all, schemes.SPH * self.spacing,
                                         self.spacing**p.dim, d.indptr, d.indices, self.axes)
        else:
            gradients.least_squares_gradient(out, f, p.x_all, p.role_all, *self._gradient_form(),
                                             d.indptr, d.indices, self.axes)
        if self.numerics.surface_gradient == "harmonic":
            gradients.harmonic_gradient(out, f, p.x_all, p.role_all, schemes.WALL * self.spacing,
                                        d.indptr, d.indices, self.axes)
        d.update("role")
        return out

    def _gradient_form(self):
        """Return the arguments (radius [m], power, floor) of the least-squares gradient's kernel."""
        name = self.numerics.gradient
        return schemes.GRADIENT[name] * self.spacing, *((2, 0.2) if name == "sfdi" else (0, 0.05))

    def _move(self, start, dt):
        """Move particles by the trapezoid of Eq. 16, or by u^{n+1} for symplectic Euler."""
        p = self.particles
        fluid = p.kind == FLUID
        u = p.u if self.numerics.stepping == "symplectic" else regularise.keep_in_tank(self, 0.5 * (start + p.u), dt)
        p.x[fluid] = p.x0[fluid] + dt * u[fluid]

    def _divergence(self):
        p = self.particles
        self.domain.update("u")
        div = np.empty(p.n_owned)
        self.rows.divergence(div, p.u_all, p.role_all)
        inner = p.role == INNER
        total = np.array([div[inner] @ div[inner], inner.sum()])
        total = p.comm.allreduce(total)
        return float(np.sqrt(total[0] / max(total[1], 1.0)))

    def _report(self, dt, solve, divergence, isolated, collisions, positions):
        p = self.particles
        counts = p.comm.allreduce(np.array([np.count_nonzero(np.isin(p.role, (SURFACE, BALLISTIC))), collisions]))
        second = (positions.iterations, positions.residual, positions.fallback) if positions else ()
        return StepReport(dt, solve.iterations, solve.residual, solve.reason, solve.fallback, solve.rebuilt,
                          solve.setup_seconds, solve.solve_seconds, divergence, int(counts[0]), isolated,
                          int(counts[1]), *second, works=self.budget.works(p.comm))
