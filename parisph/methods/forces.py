"""Forces per unit mass, which add up to the acceleration of a step."""

from typing import TYPE_CHECKING

import numpy as np

from parisph.base.arrays import Array, Floats
from parisph.base.fields import ABSENT, FLUID, WALL
from parisph.case.numerics import ResolvedNumerics
from parisph.kernels import gradient, surface_stress, turbulence, viscous, wetness
from parisph.kernels.records import Walls
from parisph.methods import lengths, straining
from parisph.methods.parts import FORCES, SURFACES, ForceTerm
from parisph.methods.spins import add_cross

if TYPE_CHECKING:
    from parisph.methods.flow import Flow


class GivenForce(ForceTerm):
    """Gravity, and the inertia of a moving tank.

    If the divergence of the force varies as a sine, and the force lifts the surface by .17 d, the level of water at
    rest errs by up to 3 % within 4 s at d/s = 9. A force that is linear in space keeps it at rest.
    """

    name = "body"

    def add(self, out: Floats, flow: "Flow", time: float) -> None:
        force = flow.step.body_force = flow.body(flow.particles.x_all, time)
        for axis in range(out.shape[1]):    # numpy is slow along a short last axis
            out[:, axis] += force[:, axis]


class Coriolis(ForceTerm):
    """-2 Omega x u in a rotating tank, with the velocity in the middle of the step.

    That is u + dt/2 a, with the acceleration a of the last step. It is of second order both for water in free flight,
    whose speed it keeps, and for water in which pressure balances the force. A rotation of u by -2 Omega dt would be
    exact for the former and shrink the latter by cos(2 Omega dt) in each step, as pressure removes the component normal
    to u. At walls, the velocity is that of the water along them.
    """

    name, source, reach, only, words = "coriolis", "", lengths.WALL, "turning", "Coriolis force"
    fields = ("acceleration", "halfway")

    def add(self, out: Floats, flow: "Flow", time: float) -> None:
        p, d = flow.particles, flow.domain
        p.halfway[:] = p.u + 0.5 * flow.step.dt * p.acceleration
        d.update("halfway", "role")
        gradient.wall_velocity(p.halfway_all, flow.cloud, np.zeros_like(p.u), flow.wall_shear(time),
                               lengths.WALL * flow.spacing)
        d.update("halfway")
        add_cross(out, flow.turn(time), p.halfway_all, -2.0)


class Viscous(ForceTerm):
    """nu lap u by a quadratic fit, exact for quadratic velocities; at walls, its normal part is that of the fluid.

    A free surface has no stress: no shear, and the pressure `surface_pressure`. A new surface particle has p = 0 in its
    first step.
    """

    name, source, reach, only, words = "viscous", "Z14 Eq 2", lengths.WALL, "viscous", "viscous force"
    fields = "no_slip", "wall_u", "nu", "viscous"
    open_fields: tuple[str, ...] = ("touched", "surface_pressure")    # additional ones with a free surface

    def needs(self, numerics: ResolvedNumerics) -> tuple[str, ...]:
        open_ones = self.open_fields if SURFACES[numerics.surface_rule].open else ()
        return (*self.fields, *open_ones, *(straining.FIELDS if numerics.smagorinsky else ()))

    def add(self, out: Floats, flow: "Flow", time: float) -> None:
        p, d = flow.particles, flow.domain
        wall = p.kind == WALL
        p.u[wall & (p.no_slip == 1)] = p.wall_u[wall & (p.no_slip == 1)]
        self._write_viscosity(flow)
        self.laplacian(p.viscous, flow, *self._update(flow))
        d.update("viscous", *(("surface_pressure",) if flow.stressed else ()))
        viscous.continue_to_walls(p.viscous_all, flow.cloud, lengths.WALL * flow.spacing)
        d.update("viscous")
        out += p.viscous_all

    def laplacian(self, out: Floats, flow: "Flow", seen: Array, walls: Walls) -> None:
        """Write nu lap u of owned fluid to out (n_owned, dim) [m/s^2], and surface_pressure if there is a free surface.

        seen : (n_all,) kind, ABSENT for walls behind air
        """
        p, s, cloud = flow.particles, flow.spacing, flow.cloud._replace(kind=seen)
        flowing = viscous.Flowing(p.u_all, p.nu_all, p.no_slip_all)
        viscous.corrected(out, cloud, walls, flowing, lengths.WALL * s, lengths.DENSITY * s)
        if flow.open:
            surface_stress.stress_free(out, p.surface_pressure, cloud, walls, flowing, lengths.WALL * s)
            p.surface_pressure *= flow.density

    def longest_step(self, flow: "Flow") -> float:
        p = flow.particles
        nu = flow.viscosity + (p.nu.max(initial=0.0) if flow.numerics.smagorinsky else 0.0)
        return viscous.STABLE * flow.spacing**2 / nu if nu > 0.0 else np.inf

    def _update(self, flow: "Flow") -> tuple[Array, Walls]:
        """Send fields to the ghosts; return kind (n_all,), ABSENT for walls behind air, and the walls. Collective."""
        p, d = flow.particles, flow.domain
        if flow.open:    # otherwise all walls are wet
            wetness.touched_walls(p.touched, flow.cloud)
        d.update("u", "nu", "role", *(("touched",) if flow.open else ()))
        seen = np.where(p.touched_all == 0, np.int8(ABSENT), p.kind_all) if flow.open else p.kind_all
        found: tuple[Array, Walls] = flow.walls.viscous(flow, seen)
        return found

    def _write_viscosity(self, flow: "Flow") -> None:
        """Write nu of owned particles, including the eddy viscosity by the velocity gradient of the previous step."""
        p, n = flow.particles, flow.numerics
        if n.smagorinsky:
            turbulence.eddy_viscosity(p.nu, p.grad_u, p.kind, n.smagorinsky * flow.spacing, flow.axes)
            p.nu[p.kind == FLUID] += flow.viscosity
            p.nu[p.kind != FLUID] = flow.viscosity
        else:
            p.nu[:] = flow.viscosity


class MorrisViscous(Viscous):
    """nu lap u by the form of Morris, which conserves momentum; on a free surface n . grad u = 0 and p = 0.

    It converges only while particles stay on their lattice.
    """

    name, source, words = "viscous_morris", "Morris et al. 1997, Eq 22", "viscous force of Morris"
    open_fields = ("touched",)

    def laplacian(self, out: Floats, flow: "Flow", seen: Array, walls: Walls) -> None:
        p = flow.particles
        viscous.morris(out, flow.cloud._replace(kind=seen), walls, viscous.Flowing(p.u_all, p.nu_all, p.no_slip_all),
                       lengths.DENSITY * flow.spacing)


for part in (GivenForce(), Coriolis(), Viscous(), MorrisViscous()):
    FORCES.register(part)
