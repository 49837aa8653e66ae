"""The state of a scene that the parts of a method may read and change."""

from collections.abc import Callable
from typing import Any

import numpy as np

from parisph.base.fields import FLUID
from parisph.case.friction import Friction
from parisph.case.numerics import Numerics
from parisph.kernels import gradient, pairs, surface, wetness
from parisph.kernels.jit import axes_of
from parisph.kernels.potential_fit import Potential
from parisph.kernels.records import Cloud
from parisph.methods import lengths
from parisph.methods.budget import Budget, NoBudget
from parisph.methods.last_waves import LastWaves
from parisph.parallel.domain import Domain
from parisph.parallel.particles import Particles


class Flow:
    """Particles, their neighbours, and what a step has found out about them so far.

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
    time : of the operators of the step that begins [s]; dt : its length [s], 0 for a look at an instant
    usual : what that length would be if no step were shortened to meet a time [s]
    force : (n_all, dim) [m/s^2], of this step; body_force : the part of it by gravity and the inertia of the tank
    varies : whether the body force does in space, the same on all ranks; bends : whether the field laplacian is without
        its divergence
    absorbed : (n_owned, dim) the part of force by such zones
    by_pressure : (n_owned,) acceleration by pressure alone in this step [m/s^2]
    mean_acceleration : of fluid by pressure in the last steps (methods.straining.remember), on all ranks [m/s^2];
        0 before the first
    mean_strain : sqrt(2 S:S) of fluid in the last step, in the mean on all ranks [1/s]; 0 before the first, and in a
        method that measures no strain
    last_waves : the largest of it in the last waves
    strained, doubt, rapid : (n_owned,) or None, and whole, of methods.straining in this step
    beyond_fit : (n_owned, dim) [m/s] of kernels.strain.velocity_gradient, if straining.begin has found it, else None
    potential : methods.potential of the velocity at the start of the step, None if no part needs it
    accelerations : of fluid in the last step, on all ranks [m/s^2], the largest and the root of the mean square; known
        with an adaptive step
    top_speed : of fluid, on all ranks [m/s]; known in steps with a part that needs it
    stale : names of fields that have changed since the ghosts got them; the same on all ranks
    found : what regularisers have found out in this preparation, for others; cleared by regularising.prepare
    collisions : pairs of owned particles that have collided in this step
    rows, solver, pressure_gradient : PressureRows, PressureSolver, and a function of f (n_all,), of a projection; else
        None
    position_solve : SolveRecord of the position projection in this step, or None
    """

    def __init__(self, numerics: Numerics, density: float, body: Any, particles: Particles, domain: Domain, walls: Any,
                 timers: Any, closed: bool = False, budget: Budget | None = None, viscosity: float = 0.0,
                 spin: Callable[[float], float] | None = None, absorb: Any = None,
                 friction: Friction | None = None, wave_time: float = np.inf, vorticity: float = 0.0) -> None:
        self.numerics, self.density, self.body, self.viscosity = numerics, density, body, viscosity
        self.particles, self.domain, self.walls, self.timers = particles, domain, walls, timers
        self.closed, self.budget, self.spin, self.absorb = closed, budget or NoBudget(), spin, absorb
        self.friction, self.wave_time, self.vorticity = friction, wave_time, vorticity
        self.time = self.dt = self.usual = 0.0
        self.spacing: float = numerics.spacing
        self.axes = axes_of(particles.dim)
        self.full = surface.lattice_sum(self.spacing, lengths.DENSITY * self.spacing, self.axes)
        self.force = self.body_force = self.absorbed = np.zeros((0, particles.dim))
        self.varies, self.bends = False, True
        self._uneven = self.body_force, False
        self.by_pressure = np.zeros(particles.n_owned)
        self.strained: np.ndarray | None = None
        self.doubt: np.ndarray | None = None
        self.rapid: np.ndarray | None = None
        self.beyond_fit: np.ndarray | None = None
        self.potential: Potential | None = None
        self.accelerations = 0.0, 0.0
        self.mean_acceleration = self.mean_strain = self.top_speed = 0.0
        self.last_waves = LastWaves()
        self.whole = 1.0
        self.collisions = 0
        self.stale: set[str] = set()
        self.found: dict[str, Any] = {}
        # of a projection: its rows and solver, and what computes gradients with them
        self.rows: Any = None
        self.solver: Any = None
        self.pressure_gradient: Any = None
        self.position_solve: Any = None

    @property
    def viscous(self) -> bool:
        """Whether the fluid has any viscosity, of its own or of eddies."""
        return bool(self.viscosity or self.numerics.smagorinsky)

    @property
    def pull(self) -> np.ndarray:
        """The body force per volume (n_all, dim) [Pa/m], (0, dim) where it is uniform or the Laplacian holds it too."""
        return self.density * self.body_force if self.bends and self.uneven else self.body_force[:0]

    @property
    def uneven(self) -> bool:
        """Whether the body force varies among the particles of this rank. The array must not be changed afterwards."""
        force, (looked_at, found) = self.body_force, self._uneven
        if looked_at is not force:
            found = force.strides[0] != 0 and bool(np.any(force != force[:1]))    # one row for all is the usual force
            self._uneven = force, found
        return found

    @property
    def outer_pull(self) -> np.ndarray:
        """That of a force from outside, (0, dim) in a tank that turns: what its inertia bends belongs to the strain, as
        water in free flight shows."""
        return self.pull if self.spin is None else self.body_force[:0]

    @property
    def without_strain(self) -> np.ndarray:
        """The Laplacian of the pressure (n_all,) [Pa/m^2] by vorticity alone, rho w^2/2, seen from the tank as well."""
        return 0.5 * self.density * self.swirl()**2

    @property
    def bent_without_strain(self) -> bool:
        """Whether `outer_pull` or `without_strain` bends the pressure, the same on all ranks."""
        turns = self.viscous and self.spin is not None
        return turns or "swirl" in self.particles.fields or len(self.outer_pull) > 0

    @property
    def _turn(self):
        return 0.0 if self.spin is None else self.spin(self.time)

    @property
    def cloud(self) -> Cloud:
        """The particles as kernels need them, now."""
        return self.particles.cloud(self.domain.indptr, self.domain.indices, self.spacing)

    @property
    def cells(self) -> np.ndarray:
        """The volume (n_all,) that particles stand for over that of their cells at the start: 1/2 on a level surface,
        3/2 beside a wall."""
        p = self.particles
        cell = self.spacing**p.dim
        if "weight" not in p.fields:
            return p.volume_all / cell
        return p.volume_all / np.where(p.kind_all == FLUID, p.weight_all * cell, cell)

    def fresh(self, *names: str) -> None:
        """Send the fields that have changed to the ghosts, in one message, if any of `names` is among them. Collective.

        Without names, all that have changed.
        """
        if self.stale and (not names or self.stale.intersection(names)):
            self.domain.update(*sorted(self.stale))
            self.stale.clear()

    def seen(self, closing: int) -> np.ndarray:
        """Return kind (n_all,) with the walls ABSENT that are less than `closing` (kernels.wetness.FREE or CLOSING)."""
        p = self.particles
        if "closing" not in p.fields:    # a full closed tank, all of whose walls are wet
            return p.kind_all
        return wetness.without_walls(p.kind_all, p.closing_all, closing)

    def wall_shear(self) -> np.ndarray:
        """Return how the velocity of the flow along a wall changes with the distance from it: (n_owned, dim) [1/s].

        The wall's normal turns, in its own frame with the frame's spin W against the water, and the water with the
        vorticity w that it has had in the room since the start: - dn/dt - (2 W - w) x n. In viscous fluid, which walls
        set in rotation, this is unknown and taken as 0.
        """
        p = self.particles
        if self.viscous:
            return np.zeros_like(p.u)
        shear = self.walls.shear(self)
        turn = 2.0 * self._turn - self.swirl()[:p.n_owned]
        if np.any(turn):    # numpy is slow along a short last axis
            shear[:, 0] += turn * p.normal[:, 1]
            shear[:, 1] -= turn * p.normal[:, 0]
        return shear

    def swirl(self) -> np.ndarray:
        """Return the vorticity (n_all,) [1/s] in the room that particles carry, for owned walls that of the fluid
        beside them. Viscous fluid is taken to turn with its tank. Not collective."""
        p = self.particles
        if "swirl" not in p.fields:
            return np.full(p.n_all, 2.0 * self._turn if self.viscous else 0.0)
        gradient.mean_beside_walls(p.swirl_all, self.cloud, lengths.WALL * self.spacing)
        return p.swirl_all

    def close_pairs(self, distance: float) -> Cloud:
        """Return the cloud of fluid pairs nearer than a distance [spacings], kernels.pairs.close_pairs. Not collective.

        For `prepare` and `change` of regularisers, which see the same positions: lists are made once in a preparation.
        Limiters, which act when positions have changed, make their own.
        """
        name = f"pairs within {distance}"
        if name not in self.found:
            self.found[name] = pairs.close_pairs(self.cloud, distance * self.spacing)
        return self.found[name]

    def density_ratio(self, least: int) -> None:
        """Write the field alpha of owned fluid, with walls whose `closing` is at least so much. Not collective."""
        self.walls.density_ratio(self.particles.alpha, self, least)
