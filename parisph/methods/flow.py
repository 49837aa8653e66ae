"""The state of a scene that the parts of a method may read and change."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from parisph.base.arrays import Array, Floats
from parisph.base.fields import FLUID
from parisph.base.log import Timers
from parisph.case.friction import Friction
from parisph.case.numerics import Numerics
from parisph.kernels import gradient, pairs, surface, wetness
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

# the fields that only some scenes have, in the order of Flow's attributes that say so
CARRIED = ("closing", "swirl", "share", "alpha", "wall_u", "no_slip", "surface_pressure", "laplacian", "left",
           "acceleration")


class Flow:
    """A scene for the parts of a method: particles, neighbours and walls, the step under way, and what steps remember.

    Parameters
    ----------
    numerics : resolved Numerics
    density : [kg/m^3]; viscosity : kinematic [m^2/s]
    body : callable (x (n, dim), t) -> (n, dim), not to be written, the body force per unit mass in the tank's frame
        [m/s^2]
    particles, domain, walls, timers : of this run; walls are a methods.boundary.Boundary
    closed : whether the fluid fills a closed tank: no free surface
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
    Whether particles carry what only some scenes need, the same on all ranks:
        open : what closes gaps of air, as walls may be dry: the method looks for a free surface
        rotational : vorticity from the start
        half_cells : for which part of the half cells at walls fluid stands
        weighed : the density ratio
        slides, sticks : the velocity of walls themselves, and which of them fluid sticks to
        stressed : the pressure of the viscous stress at a free surface
        bent : the Laplacian of the pressure
        returned : the divergence that the last step has left, which is given back
        accelerated : the acceleration in the last step
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

    def __init__(self, numerics: Numerics, density: float, body: Callable[[Floats, float], Floats],
                 particles: Particles, domain: Domain, walls: Any, timers: Timers, closed: bool = False,
                 budget: Budget | None = None, viscosity: float = 0.0, spin: Callable[[float], float] | None = None,
                 absorb: Callable[[Floats, float], tuple[Floats, Floats]] | None = None,
                 friction: Friction | None = None, wave_time: float = np.inf, vorticity: float = 0.0) -> None:
        self.numerics, self.density, self.body, self.viscosity = numerics, density, body, viscosity
        self.particles, self.domain, self.walls, self.timers = particles, domain, walls, timers
        self.closed, self.budget, self.spin, self.absorb = closed, budget or NoBudget(), spin, absorb
        self.friction, self.wave_time, self.vorticity = friction, wave_time, vorticity
        self.spacing: float = numerics.spacing
        self.axes = axes_of(particles.dim)
        self.full = surface.lattice_sum(self.spacing, lengths.DENSITY * self.spacing, self.axes)
        (self.open, self.rotational, self.half_cells, self.weighed, self.slides, self.sticks, self.stressed, self.bent,
         self.returned, self.accelerated) = (name in particles.fields for name in CARRIED)
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
    def outer_pull(self) -> Floats:
        """That of a force from outside, (0, dim) in a tank that turns: what its inertia bends belongs to the strain, as
        water in free flight shows."""
        return self.pull if self.spin is None else self.step.body_force[:0]

    @property
    def without_strain(self) -> Floats:
        """The Laplacian of the pressure (n_all,) [Pa/m^2] by vorticity alone, rho w^2/2, seen from the tank as well."""
        return 0.5 * self.density * self.swirl(self.step.time)**2

    @property
    def bent_without_strain(self) -> bool:
        """Whether `outer_pull` or `without_strain` bends the pressure, the same on all ranks."""
        turns = self.viscous and self.spin is not None
        return turns or self.rotational or len(self.outer_pull) > 0

    def turn(self, time: float) -> float:
        """Return the angular velocity of the tank at a time [s]: [rad/s]."""
        return 0.0 if self.spin is None else self.spin(time)

    @property
    def cloud(self) -> Cloud:
        """The particles as kernels need them, now."""
        return self.particles.cloud(self.domain.indptr, self.domain.indices, self.spacing)

    @property
    def cells(self) -> Floats:
        """The volume (n_all,) that particles stand for over that of their cells at the start: 1/2 on a level surface,
        3/2 beside a wall."""
        p = self.particles
        cell = self.spacing**p.dim
        return p.volume_all / np.where(p.kind_all == FLUID, p.weight_all * cell, cell)

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
        shear = self.walls.shear(self)
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

    def density_ratio(self, least: int) -> None:
        """Write the field alpha of owned fluid, with walls whose `closing` is at least so much. Not collective."""
        self.walls.density_ratio(self.particles.alpha, self, least)
