"""The state of a scene that the parts of a method may read and change."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from parisph.base.arrays import Array, Floats
from parisph.base.fields import FLUID
from parisph.base.log import Timers
from parisph.case.friction import Friction
from parisph.case.numerics import ResolvedNumerics
from parisph.kernels import gradient, pairs, surface, wetness
from parisph.kernels.curvature import Bending
from parisph.kernels.jit import axes_of
from parisph.kernels.records import Cloud
from parisph.methods import lengths
from parisph.methods.budget import Budget, NoBudget
from parisph.methods.step_state import Preparation, StepState
from parisph.parallel.domain import Domain
from parisph.parallel.particles import Particles

if TYPE_CHECKING:
    from parisph.pressure.rows import PressureRows
    from parisph.pressure.solver import PressureSolver


class Flow:
    """A scene for the parts of a method: particles, neighbours and walls, the step under way, and what steps remember.

    Parameters
    ----------
    numerics : ResolvedNumerics
    density : [kg/m^3]; viscosity : kinematic [m^2/s]
    body : callable (x (n, dim), t) -> (n, dim), not to be written, the body force per unit mass in the tank's frame
        [m/s^2]
    particles, domain, walls, timers : of this run; walls are a methods.boundary.Boundary
    spin : callable t -> angular velocity of the tank [rad/s], or None
    absorb : callable (x (n, dim), t) -> 1/tau (n,) [1/s] and u_t/tau (n, dim) [m/s^2] of zones (case.absorb), or None
    friction : case.friction.Friction, or None
    wave_time : sqrt(s/g), the time scale of the shortest waves on the lattice [s]
    vorticity : of the fluid in the room at the start, if all has the same, else 0 [1/s]; that of each particle is its
        field swirl, which scenes without any do not have
    budget : measures the energy that the fluid gains by each part of a step, or None

    Attributes
    ----------
    full : lattice value of the density ratio's sum
    open, ..., accelerated : whether the scene needs what the comments name
    rows, solver, pressure_gradient : of a projection, which sets them: PressureRows, PressureSolver, and a function of
        f (n_all,)
    bends : of a projection: whether the field laplacian is without the divergence of the body force
    mean_acceleration : of fluid by pressure in the last steps (methods.straining.remember), on all ranks [m/s^2];
        0 before the first
    stale : names of fields that have changed since the ghosts got them; the same on all ranks
    step : StepState of the step under way, or of the last one
    preparation : Preparation of the regularisers under way
    """

    rows: "PressureRows"
    solver: "PressureSolver"
    pressure_gradient: Callable[..., Floats]

    def __init__(self, numerics: ResolvedNumerics, density: float, body: Callable[[Floats, float], Floats],
                 particles: Particles, domain: Domain, walls: Any, timers: Timers,
                 budget: Budget | None = None, viscosity: float = 0.0, spin: Callable[[float], float] | None = None,
                 absorb: Callable[[Floats, float], tuple[Floats, Floats]] | None = None,
                 friction: Friction | None = None, wave_time: float = np.inf, vorticity: float = 0.0) -> None:
        self.numerics, self.density, self.body, self.viscosity = numerics, density, body, viscosity
        self.particles, self.domain, self.walls, self.timers = particles, domain, walls, timers
        self.budget, self.spin, self.absorb = budget or NoBudget(), spin, absorb
        self.friction, self.wave_time, self.vorticity = friction, wave_time, vorticity
        self.spacing: float = numerics.spacing
        self.axes = axes_of(particles.dim)
        self.full = surface.lattice_sum(self.spacing, lengths.DENSITY * self.spacing, self.axes)
        carried = particles.fields
        self._cloud = self.particles.cloud(domain.indptr, domain.indices, self.spacing)
        self.open = "closing" in carried    # a free surface: walls may be dry
        self.closed = not self.open         # fluid fills a closed tank
        self.rotational = "swirl" in carried    # the vorticity that fluid has from the start
        self.half_cells = "share" in carried    # for which part of the half cells at walls fluid stands
        self.weighed = "alpha" in carried    # the density ratio
        self.slides = "wall_u" in carried    # the velocity of walls themselves
        self.sticks = "no_slip" in carried    # the walls that fluid sticks to
        self.stressed = "surface_pressure" in carried    # the viscous stress at a free surface
        self.bent = "laplacian" in carried    # the Laplacian of the pressure
        self.returned = "left" in carried    # the divergence that a step leaves, to be given back
        self.accelerated = "acceleration" in carried    # the acceleration of the last step
        self.bends = True
        self.mean_acceleration = 0.0
        self.stale: set[str] = set()
        self.step, self.preparation = StepState(particles), Preparation()

    @property
    def viscous(self) -> bool:
        """Whether the fluid has any viscosity, of its own or of eddies."""
        return bool(self.viscosity or self.numerics.smagorinsky)

    @property
    def pull(self) -> Floats:
        """The body force per volume (n_all, dim) [Pa/m], (0, dim) where it is uniform or the Laplacian holds it too."""
        force = self.step.body_force
        return self.density * force if self.bends and self.step.uneven else force[:0]

    @property
    def bending(self) -> Bending | None:
        """What bends the pressure of fluid that is not strained, None if nothing does: a force from outside that is not
        uniform, and vorticity, by rho w^2/2. What the inertia of a tank that turns bends belongs to the strain, as
        water in free flight shows."""
        pull = self.pull if self.spin is None else self.step.body_force[:0]
        if not (self.rotational or len(pull) or (self.viscous and self.spin is not None)):
            return None
        return Bending(0.5 * self.density * self.swirl(self.step.time)**2, pull)

    def turn(self, time: float) -> float:
        """Return the angular velocity of the tank at a time [s]: [rad/s]."""
        return 0.0 if self.spin is None else self.spin(time)

    @property
    def cloud(self) -> Cloud:
        """The particles as kernels need them, now."""
        p, d, cloud = self.particles, self.domain, self._cloud
        if cloud.x is not p.x_all or cloud.indices is not d.indices:
            self._cloud = cloud = p.cloud(d.indptr, d.indices, self.spacing)
        return cloud

    @property
    def cells(self) -> Floats:
        """The volume (n_all,) that particles stand for over that of their cells at the start: 1/2 on a level surface,
        3/2 beside a wall."""
        p = self.particles
        cell = self.spacing**p.dim
        found: Floats = p.volume_all / np.where(p.kind_all == FLUID, p.weight_all * cell, cell)
        return found

    def fresh(self, *names: str) -> None:
        """Send the fields that have changed to the ghosts, in one message, if any of `names` is among them. Collective.

        Without names, all that have changed.
        """
        if self.stale and (not names or self.stale.intersection(names)):
            self.domain.update(*sorted(self.stale))
            self.stale.clear()

    def seen(self, closing: int) -> Array:
        """Return kind (n_all,) with the walls ABSENT that are less than `closing` (kernels.wetness.FREE or CLOSING)."""
        p = self.particles
        return wetness.without_walls(p.kind_all, p.closing_all, closing) if self.open else p.kind_all

    def wall_shear(self, time: float) -> Floats:
        """Return how the velocity of the flow along a wall changes with the distance from it at a time [s]: (n_owned,
        dim) [1/s].

        The wall's normal turns, in its own frame with the frame's spin W against the water, and the water with the
        vorticity w that it has had in the room since the start: - dn/dt - (2 W - w) x n. In viscous fluid, which walls
        set in rotation, this is unknown and taken as 0.
        """
        p = self.particles
        if self.viscous:
            return np.zeros_like(p.u)
        elements = self.walls.elements
        shear = -elements.of_particles(elements.turn, p) if elements.moving else np.zeros_like(p.u)
        turn = 2.0 * self.turn(time) - self.swirl(time)[:p.n_owned]
        if np.any(turn):    # numpy is slow along a short last axis
            shear[:, 0] += turn * p.normal[:, 1]
            shear[:, 1] -= turn * p.normal[:, 0]
        return shear

    def swirl(self, time: float) -> Floats:
        """Return the vorticity (n_all,) [1/s] in the room that particles carry at a time [s], for owned walls that of
        the fluid beside them. Viscous fluid is taken to turn with its tank. Not collective."""
        p = self.particles
        if not self.rotational:
            return np.full(p.n_all, 2.0 * self.turn(time) if self.viscous else 0.0)
        gradient.mean_beside_walls(p.swirl_all, self.cloud, lengths.WALL * self.spacing)
        return p.swirl_all

    def close_pairs(self, distance: float) -> Cloud:
        """Return the cloud of fluid pairs nearer than a distance [spacings], kernels.pairs.close_pairs. Not collective.

        For `prepare` and `change` of regularisers, which see the same positions: lists are made once in a preparation.
        Limiters, which act when positions have changed, make their own.
        """
        known = self.preparation.pairs
        if distance not in known:
            known[distance] = pairs.close_pairs(self.cloud, distance * self.spacing)
        return known[distance]
