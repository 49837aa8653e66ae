"""One time step of traditional, weakly compressible SPH (Zheng, Ma & Duan 2014, Sec. 2.1)."""

from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from typing import Any

import numpy as np
from mpi4py import MPI

from parisph.base.arrays import Floats
from parisph.base.fields import ABSENT, BALLISTIC, DRY, FLUID, INNER, SURFACE, WALL, WET
from parisph.kernels import surface, weakly
from parisph.methods import lengths
from parisph.methods.catalogue import CompressibleParts
from parisph.methods.flow import Flow
from parisph.methods.reports import StepReport

EQUATIONS = {"tait": (weakly.tait_pressure, weakly.tait_density),
             "linear": (weakly.linear_pressure, weakly.linear_density)}
SURFACE_EVERY = 20      # steps between searches for the free surface, which only probes and pictures need
OPEN = 1.5              # div r of 2 inside (3D: 3 and 2.25) below which a particle is on the surface


@dataclass(frozen=True)
class CompressibleReport(StepReport):
    """The results of one step of weakly compressible SPH.

    compression: largest |rho/rho0 - 1|; speed: of the fastest fluid [m/s].
    """

    compression: float = 0.0
    speed: float = 0.0

    @classmethod
    def columns(cls) -> dict[str, str]:
        """Return {column: unit} of its line, without energies."""
        return {"dt": "s", "surface": "", "compression": "", "speed": "m/s", "left": ""}

    def words(self) -> str:
        """Return its part of the progress line."""
        return f"compression {self.compression:.1e}  fastest {self.speed:.3g} m/s"


class Compressible:
    """Weakly compressible SPH on the particles of one scene, in steps of velocity Verlet.

    A step advances u by half, x and rho, then p(rho) and the acceleration, then u by the other half: it evaluates
    forces once.

    Parameters
    ----------
    flow : Flow
    sound : speed of sound [m/s]
    settle : time [s] for which water at rest settles before the start, 0 for none. Sums over pairs lack half their
        neighbours at the surface, which sinks by a third of a spacing until the others balance gravity
    gravity : (dim,) [m/s^2], in which it settles, with the tank at rest
    """

    def __init__(self, flow: Flow, parts: CompressibleParts, sound: float, settle: float = 0.0,
                 gravity: Floats | None = None) -> None:
        self.flow, self.parts, self.sound, n = flow, parts, sound, flow.numerics
        self.settle, self.gravity = settle, np.zeros(flow.particles.dim) if gravity is None else gravity
        self.h = lengths.SPH * flow.spacing
        self.mass = flow.density * flow.spacing**flow.particles.dim
        self.pressure, self.density = EQUATIONS[n.equation_of_state]
        self.accelerations = 0.0, 0.0    # the mean stays 0, as the speed of sound limits these steps
        self.strain_rate = 0.0           # not measured
        self._steps, self._begun = 0, False
        self.pressure_time = None        # that of the particles
        self.pressure_window = None      # no means, as pressures follow from densities, not impulses

    # -- interface to the driver -----------------------------------------------------------

    def start(self, time: float) -> int:
        """Compute densities from the initial pressure, and the initial acceleration; return 0. Collective."""
        flow, p = self.flow, self.flow.particles
        self._begun = True
        flow.domain.refresh("u")
        p.rho[:] = self.density(p.p, self.sound, flow.density)
        if self.settle:
            self._settle(time)
        self._pull(time, flow.body)
        self._find_surface()
        return 0

    def step(self, time: float, dt: float, usual: float | None = None) -> CompressibleReport:
        """Advance one step of dt [s]. Collective."""
        if not self._begun:
            self.start(time)
        flow, p, timers = self.flow, self.flow.particles, self.flow.timers
        flow.budget.begin(p)
        self._advance(time + dt, dt, flow.body)
        flow.budget.mark(p, "pressure")
        self._steps += 1
        if self._steps % SURFACE_EVERY == 0:
            with timers("surface"):
                self._find_surface()
        with timers("record"):
            return self._report(dt)

    def acceleration(self, time: float) -> Floats:
        """Return the acceleration [m/s^2] of owned particles, 0 for walls."""
        return self.flow.particles.pull.copy()

    def longest_step(self) -> float:
        """Return the longest stable step [s]. Collective."""
        p = self.flow.particles
        speed = float(np.sqrt((p.u**2).sum(axis=1).max(initial=0.0)))
        strongest = float(np.sqrt((p.pull**2).sum(axis=1).max(initial=0.0)))
        speed, strongest = _largest(p.comm, speed, strongest)
        return weakly.longest_step(self.h, self.sound, speed, self.flow.numerics.artificial_viscosity, strongest)

    def shown(self) -> AbstractContextManager[None]:
        """Give particles the pressure that a snapshot shows, within this context: here their own."""
        return nullcontext()

    @property
    def columns(self) -> dict[str, str]:
        """Columns of steps.csv with their units."""
        return CompressibleReport.columns()

    def state(self) -> dict[str, float]:
        """Return the state for a checkpoint, besides the particles."""
        return {"acceleration": self.accelerations[0], "surface_steps": self._steps}

    def resume(self, state: dict[str, Any]) -> None:
        """Continue from the state in a checkpoint."""
        self._begun = True
        self.accelerations, self._steps = (state.get("acceleration", 0.0), 0.0), state.get("surface_steps", 0)

    def about(self) -> dict[str, str | None]:
        """Return the options of PETSc: none."""
        return {}

    def destroy(self) -> None:
        """Do nothing: there is nothing to free."""

    # -- the parts of the step, in order ---------------------------------------------------

    def _settle(self, time: float) -> None:
        """Let water come to rest, with its velocity damped within a hundredth of the settling time. Collective."""
        p, left = self.flow.particles, self.settle

        def still(x: Floats, t: float) -> Floats:
            return np.tile(self.gravity, (len(x), 1))
        self._pull(time, still)
        while left > 0.0:
            dt = min(self.longest_step(), left)
            p.u[:] *= max(0.0, 1.0 - 100.0 * dt / self.settle)
            self._advance(time, dt, still)
            left -= dt
        p.u[:] = 0.0
        self.flow.domain.refresh("u")

    def _advance(self, stop: float, dt: float, body: Callable[[Floats, float], Floats]) -> None:
        """Move fluid by a step of dt [s] that ends at `stop` [s]. Collective. body : as of Flow."""
        p, domain, timers = self.flow.particles, self.flow.domain, self.flow.timers
        p.x0[:] = p.x
        with timers("predict"):
            fluid = p.kind == FLUID
            p.u[fluid] += 0.5 * dt * p.pull[fluid]
            domain.update("u")
            p.x[fluid] += dt * self._moving()[fluid]
        with timers("redistribute"):
            domain.refresh("u")
        with timers("correct"):
            self._densities(dt)
            self._pull(stop, body)
            fluid = p.kind == FLUID
            p.u[fluid] += 0.5 * dt * p.pull[fluid]

    def _state(self, force: Floats | None = None) -> weakly.State:
        """Return the fields as kernels take them; force : (n_all, dim) [m/s^2], if needed."""
        p = self.flow.particles
        return weakly.State(p.u_all, p.p_all, p.rho_all, p.u_all if force is None else force, self.mass, self.h)

    def _moving(self) -> Floats:
        """Return the velocity with which particles move (n_owned, dim) [m/s] (Eq 9)."""
        p, n = self.flow.particles, self.flow.numerics
        if not n.xsph:
            return p.u
        out = np.empty_like(p.u)
        weakly.xsph_velocity(out, self.flow.cloud, self._state(), n.xsph)
        return out

    def _densities(self, dt: float) -> None:
        """Update the densities and pressures of fluid (Eqs 3 and 7)."""
        flow, p = self.flow, self.flow.particles
        rate = np.empty(p.n_owned)
        weakly.density_rate(rate, flow.cloud, flow.walls.elements.walls, self._state())
        fluid = p.kind == FLUID
        p.rho[fluid] += dt * rate[fluid]
        p.p[fluid] = self.pressure(p.rho[fluid], self.sound, flow.density)

    def _pull(self, time: float, body: Callable[[Floats, float], Floats]) -> None:
        """Extrapolate pressure to the walls, and write the acceleration of fluid (Eqs 6 and 8)."""
        flow = self.flow
        p, d = flow.particles, flow.domain
        d.update("p", "rho")
        # kernels cannot read the broadcast row of a uniform force
        state = self._state(np.array(body(p.x_all, time), order="C"))
        weakly.wall_pressure(p.p, flow.cloud, state)
        wall = p.kind == WALL
        p.rho[wall] = self.density(p.p[wall], self.sound, flow.density)
        p.role[wall] = np.where(p.p[wall] > 0.0, WET, DRY)
        d.update("p", "rho")
        weakly.acceleration(p.pull, flow.cloud, flow.walls.elements.walls, state, self.sound,
                            flow.numerics.artificial_viscosity)
        p.pull[~wall] += state.force[:p.n_owned][~wall]

    def _find_surface(self) -> None:
        """Write the role of fluid, for probes and pictures: the initial one, or by div r (Lee et al. 2008)."""
        flow = self.flow
        p, d, e = flow.particles, flow.domain, flow.walls.elements
        if self.parts.keeps_surface:
            p.role[p.kind == FLUID] = p.start_role[p.kind == FLUID]
            return
        spread = np.empty(p.n_owned)
        d.update("role")
        # walls above the water must not hide its surface
        seen = np.where(p.role_all == DRY, np.int8(ABSENT), p.kind_all)
        wet = e.walls._replace(present=e.mean_of_nodes((seen != ABSENT).astype(float)))
        surface.position_divergence(spread, flow.cloud._replace(kind=seen), wet, self.h)
        fluid = p.kind == FLUID
        found = np.where(spread[fluid] < OPEN * 0.5 * p.dim, SURFACE, INNER)
        p.role[fluid] = np.where(spread[fluid] == 0.0, BALLISTIC, found)
        d.update("role")

    def _report(self, dt: float) -> CompressibleReport:
        flow, p = self.flow, self.flow.particles
        fluid = p.kind == FLUID
        compression, speed, strongest = _largest(
            p.comm, np.abs(p.rho[fluid] / flow.density - 1.0).max(initial=0.0),
            np.sqrt((p.u[fluid] ** 2).sum(axis=1).max(initial=0.0)), np.sqrt((p.pull**2).sum(axis=1).max(initial=0.0)))
        self.accelerations = strongest, 0.0
        surface = p.comm.allreduce(int(np.count_nonzero(np.isin(p.role, (SURFACE, BALLISTIC)))))
        return CompressibleReport(dt, surface, 0, flow.budget.works(p.comm), compression, speed)


def _largest(comm: MPI.Comm, *values: float) -> list[float]:
    """Return the largest of each value on all ranks. Collective."""
    found = np.array(values, float)
    comm.Allreduce(MPI.IN_PLACE, found, op=MPI.MAX)
    return [float(value) for value in found]
