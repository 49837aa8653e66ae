"""State of a scene that the parts of a method may read and change."""

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
from parisph.methods.spins import add_cross, centrifugal
from parisph.methods.step_state import Preparation, StepState
from parisph.parallel.domain import Domain
from parisph.parallel.particles import Particles

if TYPE_CHECKING:
    from parisph.pressure.rows import PressureRows
    from parisph.pressure.solver import PressureSolver


class Flow:
    """A scene for the parts of a method: particles, neighbours and walls, the current step, and memory across steps.

    Parameters
    ----------
    numerics : ResolvedNumerics
    density : [kg/m^3]; viscosity : kinematic [m^2/s]
    body : callable (x (n, dim), t) -> (n, dim), read-only, the body force per unit mass in the tank's frame [m/s^2]
    particles, domain, walls, timers : of this run; walls are a methods.boundary.Boundary
    spin : callable t -> angular velocity of the tank, in 2D () and in 3D (3,) [rad/s], or None
    absorb : callable (x (n, dim), t) -> 1/tau (n,) [1/s] and u_t/tau (n, dim) [m/s^2] of zones (case.absorb), or None
    friction : case.friction.Friction, or None
    wave_time : sqrt(s/g), the time scale of the shortest waves on the lattice [s]
    vorticity : initial vorticity of the fluid in the room if it is uniform, else 0 [1/s]; the field swirl, if the scene
        has vorticity, holds that of each particle. In 3D both are along `axis`, and the attribute is the vector (3,)
    axis : unit vector (3,) of the vorticity in 3D, None if there is none
    budget : measures the energy that the fluid gains by each part of a step, or None

    Attributes
    ----------
    full : lattice value of the density ratio's sum
    open, ..., accelerated : whether the scene needs what the comments name
    rows, solver, pressure_gradient : set by a projection: PressureRows, PressureSolver, and a function of f (n_all,)
    bends : set by a projection: whether the field laplacian excludes the divergence of the body force
    mean_acceleration : by pressure in the last steps (methods.straining.remember), on all ranks [m/s^2], at first 0
    stale : names of fields that have changed since the last update of ghosts; the same on all ranks
    step : StepState of the current or last step
    preparation : Preparation of the current regularisers
    """

    rows: "PressureRows"
    solver: "PressureSolver"
    pressure_gradient: Callable[..., Floats]

    def __init__(self, numerics: ResolvedNumerics, density: float, body: Callable[[Floats, float], Floats],
                 particles: Particles, domain: Domain, walls: Any, timers: Timers,
                 budget: Budget | None = None, viscosity: float = 0.0, spin: Callable[[float], Floats] | None = None,
                 absorb: Callable[[Floats, float], tuple[Floats, Floats]] | None = None,
                 friction: Friction | None = None, wave_time: float = np.inf, vorticity: float = 0.0,
                 axis: Floats | None = None) -> None:
        self.numerics, self.density, self.body, self.viscosity = numerics, density, body, viscosity
        self.particles, self.domain, self.walls, self.timers = particles, domain, walls, timers
        self.budget, self.spin, self.absorb = budget or NoBudget(), spin, absorb
        self.friction, self.wave_time, self.axis = friction, wave_time, axis
        self.vorticity: Floats = np.asarray(vorticity if axis is None else vorticity * axis)
        self.spacing: float = numerics.spacing
        self.axes = axes_of(particles.dim)
        self._still: Floats = np.zeros(3 if particles.dim == 3 else ())    # no angular velocity
        self.full = surface.lattice_sum(self.spacing, lengths.DENSITY * self.spacing, self.axes)
        carried = particles.fields
        self._cloud = self.particles.cloud(domain.indptr, domain.indices, self.spacing)
        self.open = "closing" in carried    # a free surface: walls may be dry
        self.closed = not self.open    # fluid fills a closed tank
        self.rotational = "swirl" in carried    # initial vorticity of the fluid
        self.half_cells = "share" in carried    # the part of half cells at walls that fluid represents
        self.weighed = "alpha" in carried    # density ratio
        self.slides = "wall_u" in carried    # the walls' own velocity
        self.sticks = "no_slip" in carried    # no-slip walls
        self.stressed = "surface_pressure" in carried    # viscous stress at a free surface
        self.bent = "laplacian" in carried    # Laplacian of the pressure
        self.returned = "left" in carried    # residual divergence of a step, to be given back
        self.accelerated = "acceleration" in carried    # acceleration of the last step
        self.bends = True
        self.mean_acceleration = 0.0
        self.stale: set[str] = set()
        self.step, self.preparation = StepState(particles), Preparation()

    @property
    def viscous(self) -> bool:
        """Whether the fluid has a viscosity, its own or an eddy viscosity."""
        return bool(self.viscosity or self.numerics.smagorinsky)

    @property
    def pull(self) -> Floats:
        """Body force per volume (n_all, dim) [Pa/m], or (0, dim) if it is uniform or included in the Laplacian."""
        force = self.step.body_force
        return self.density * force if self.bends and self.step.uneven else force[:0]

    @property
    def bending(self) -> Bending | None:
        """Known second differences of the pressure of unstrained fluid, or None.

        They come from a non-uniform external force, and from vorticity w: in 2D alike in both directions, by the
        Laplacian rho w^2/2, in 3D by the force on water that rotates with w/2, which is none along the axis. Those by
        the inertia of a rotating tank belong to the strain, as water in free flight shows.
        """
        pull = self.pull if self.spin is None else self.step.body_force[:0]
        if not (self.rotational or len(pull) or (self.viscous and self.spin is not None)):
            return None
        swirl = self.swirl(self.step.time)
        if self.particles.dim == 2:
            return Bending(0.5 * self.density * swirl**2, pull)
        outwards = self.density * centrifugal(0.5 * swirl, self.particles.x_all)
        return Bending(np.zeros(len(outwards)), outwards + pull if len(pull) else outwards)

    def turn(self, time: float) -> Floats:
        """Return the angular velocity of the tank at a time [s]: in 2D (), in 3D (3,) [rad/s]."""
        return self._still if self.spin is None else self.spin(time)

    @property
    def cloud(self) -> Cloud:
        """The current particles as kernels take them."""
        p, d, cloud = self.particles, self.domain, self._cloud
        if cloud.x is not p.x_all or cloud.indices is not d.indices:
            self._cloud = cloud = p.cloud(d.indptr, d.indices, self.spacing)
        return cloud

    @property
    def cells(self) -> Floats:
        """Volume (n_all,) of particles over that of their initial cells: 1/2 on a level surface, 3/2 beside a wall."""
        p = self.particles
        cell = self.spacing**p.dim
        found: Floats = p.volume_all / np.where(p.kind_all == FLUID, p.weight_all * cell, cell)
        return found

    def fresh(self, *names: str) -> None:
        """Send all changed fields to the ghosts, in one message, if any of `names` is among them. Collective.

        Without names, it sends them in any case.
        """
        if self.stale and (not names or self.stale.intersection(names)):
            self.domain.update(*sorted(self.stale))
            self.stale.clear()

    def seen(self, closing: int) -> Array:
        """Return kind (n_all,), with ABSENT for walls below `closing` (kernels.wetness.FREE or CLOSING)."""
        p = self.particles
        return wetness.without_walls(p.kind_all, p.closing_all, closing) if self.open else p.kind_all

    def wall_shear(self, time: float) -> Floats:
        """Return the change of the velocity along a wall per distance from it, at a time [s]: (n_owned, dim) [1/s].

        It is - dn/dt - (2 W - w) x n, with the normal n and the spin W of the wall's frame, and the initial vorticity w
        of the water in the room. In viscous fluid, which walls set in rotation, it is unknown and taken as 0.
        """
        p = self.particles
        if self.viscous:
            return np.zeros_like(p.u)
        elements = self.walls.elements
        shear = -elements.of_particles(elements.turn, p) if elements.moving else np.zeros_like(p.u)
        turn = 2.0 * self.turn(time) - self.swirl(time)[:p.n_owned]
        if np.any(turn):
            add_cross(shear, turn, p.normal, -1.0)
        return shear

    def swirl(self, time: float) -> Floats:
        """Return the vorticity of particles in the room at a time [s]: (n_all,), in 3D (n_all, 3) [1/s].

        Owned walls have that of the fluid beside them. Viscous fluid is taken to rotate with its tank. Not collective.
        """
        p = self.particles
        if not self.rotational:
            shape = p.n_all if p.dim == 2 else (p.n_all, 3)
            return np.full(shape, 2.0 * self.turn(time) if self.viscous else self._still)
        gradient.mean_beside_walls(p.swirl_all, self.cloud, lengths.WALL * self.spacing)
        return p.swirl_all if self.axis is None else p.swirl_all[:, None] * self.axis

    def close_pairs(self, distance: float) -> Cloud:
        """Return the cloud of fluid pairs within a distance [spacings], kernels.pairs.close_pairs. Not collective.

        For `prepare` and `change` of regularisers, which see the same positions, so that a preparation makes the lists
        once. Limiters, which act after moves, make their own.
        """
        known = self.preparation.pairs
        if distance not in known:
            known[distance] = pairs.close_pairs(self.cloud, distance * self.spacing)
        return known[distance]
