"""Walls as elements with solid behind them, which complete kernel sums, keep fluid off, and close angular gaps."""

from typing import TYPE_CHECKING, ClassVar

import numpy as np

from parisph.base.arrays import Array, Flags, Floats, sizes
from parisph.base.fields import ABSENT, DRY, FLUID, WALL, WET
from parisph.case.friction import Friction
from parisph.geometry.mesh import CONVEX
from parisph.kernels import density, gradient, movement, nearest_walls, wall_law, wetness
from parisph.kernels.near import Form
from parisph.kernels.records import Walls
from parisph.methods import lengths
from parisph.methods.step_state import Completion
from parisph.parallel.wall_elements import NO_ROOM, WallElements

if TYPE_CHECKING:
    from parisph.methods.flow import Flow

HANGS = 0.1    # tuned 0.01 to 0.5: sine of the slope of a wall from which gravity pulls fluid, a lid; judged
ALL_WET = np.empty(0, np.int8)    # in place of `closing` in scenes without a surface


class Boundary:
    """The walls of a scene. Fluid does not see through elements. No method is collective.

    elements : of the domain, none in a scene without walls
    fields : needed by walls
    In arguments, `least` is the smallest `closing` of walls that count (kernels.wetness.FREE or CLOSING).
    """

    fields: ClassVar[tuple[str, ...]] = ("weight", "area", "edge", "body", "half", "covered")

    def __init__(self, elements: WallElements, spacing: float) -> None:
        self.elements = elements
        self.table = density.table(spacing, lengths.DENSITY * spacing, elements.mesh.dim)

    # -- completion of kernel sums ---------------------------------------------------------

    def cover(self, flow: "Flow") -> tuple[str, ...]:
        """Write the part of each wall particle that fluid covers; return the fields that ghosts need."""
        p = flow.particles
        wetness.covered_walls(p.covered, flow.cloud)
        if self.elements.moving:
            p.covered *= np.clip(0.5 + self.elements.before_moving(p) / flow.spacing, 0.0, 1.0)
        return ("covered",)

    def claimed_at_start(self, flow: "Flow") -> Floats:
        """Return the weights (n_all,) of particles, 0 for nodes whose half cells fluid at the start does not represent.

        They are dry, like a lid above the water, or at a water line. Convex edges are dry everywhere.
        """
        p = flow.particles
        fluid = (p.kind_all == FLUID) | (p.role_all == WET) | (p.edge_all == CONVEX)
        return np.where(fluid, p.weight_all, 0.0)

    def claimed(self, flow: "Flow") -> Floats:
        """Return the same in a step, when fluid takes up the half cells of all walls but lids that it does not touch.

        Gravity pulls it from these. With the walls that were wet in the last step alone, P2 of the dam break at H/s =
        80 errs by .06 to .07 instead of .03.
        """
        p = flow.particles
        off = np.einsum("ia,ia->i", p.normal_all, flow.step.body_force)
        hangs = off > HANGS * sizes(flow.step.body_force)
        return np.where(hangs, self.claimed_at_start(flow), p.weight_all)

    def completion(self, flow: "Flow", least: int) -> Completion:
        """Return the completion of sums by the covered parts of walls. Computed once in a step, after the surface.

        Half cells count where they are (kernels.halves). Where no fluid represents that of a node, the first particles
        are half a spacing from the wall, and the sum is that of the midpoint rule, whose end correction is -1/2 of the
        trapezoidal one.
        """
        p, known = flow.particles, flow.step.completions
        if least not in known:
            part = np.empty(p.n_all)
            wetness.counted(part, flow.cloud, p.closing_all if flow.open else ALL_WET, p.covered_all, least)
            present, weight, area = self.elements.mean_of_nodes(part), p.weight_all * part, p.area_all * part[:, None]
            if flow.half_cells:
                held = np.where(p.kind_all == WALL, p.share_all, 1.0)
                weight = weight * held + p.spare_all
                area *= (1.5 * held * held - 0.5)[:, None]
            known[least] = Completion(present, weight, area)
        return known[least]

    def present(self, flow: "Flow", least: int) -> Walls:
        """Return the elements with the part of each that counts."""
        return self.elements.walls._replace(present=self.completion(flow, least).present)

    def density(self, ratio: Floats, flow: "Flow", least: int) -> Floats:
        """Write the density ratio (n_owned,), 1 at walls; return its gradient (n_owned, dim) [1/m], 0 at walls."""
        found, gradient = self.completion(flow, least), np.empty_like(flow.particles.x)
        density.completed_density(ratio, gradient, flow.cloud, self.present(flow, least), found.weight, found.area,
                                  self.table)
        return gradient

    def cells(self, flow: "Flow") -> Floats:
        """Return the part (n_all,) of its cell that each particle fills, as for kernels.surface_rows."""
        return np.where(flow.particles.half_all == 1, 0.5, flow.cells)

    # -- limits of moves and velocities ----------------------------------------------------

    def keep_off(self, move: Floats, flow: "Flow", distance: float | None = None) -> None:
        """Keep moves (n_owned, dim) [m] of fluid a distance [spacings] off walls, by default that of the wall guard."""
        distance = flow.numerics.wall_guard if distance is None else distance
        nearest_walls.keep_off(move, flow.cloud, self.elements.walls, distance * flow.spacing)

    def guard(self, u: Floats, flow: "Flow", dt: float) -> None:
        """Limit velocities u (n_all, dim) [m/s] of owned fluid, so that a step of dt [s] ends before a wall."""
        nearest_walls.guard(u, flow.cloud, self.elements.walls, flow.numerics.wall_guard * flow.spacing, dt)

    # -- friction --------------------------------------------------------------------------

    def viscous(self, flow: "Flow", seen: Array) -> tuple[Array, Walls]:
        """Return the particles that the viscous force sees, kind (n_all,) or ABSENT, and the elements of walls.

        seen : (n_all,) kind, ABSENT for walls behind air
        """
        p, e = flow.particles, self.elements
        there = ((e.nodes < 0) | (seen[e.nodes] != ABSENT)).all(axis=1)    # a lid above the water ends at wet walls
        sticks = (p.no_slip_all[e.nodes] == 1).all(axis=1)
        u = np.where(sticks[:, None], p.u_all[e.nodes].mean(axis=1), e.velocity)
        # slip velocities are unknown on a convex edge, whose nodes have no row
        unknown = (p.kind_all == WALL) & (p.edge_all == CONVEX) & (p.no_slip_all == 0)
        walls = e.walls._replace(velocity=u, sticks=sticks, present=there.astype(float))
        return np.where(unknown, np.int8(ABSENT), seen), walls

    def rub(self, out: Floats, flow: "Flow", law: Friction) -> None:
        """Add the friction of free-slip walls to out (n_owned, dim) [m/s^2]."""
        p, e = flow.particles, self.elements
        # walls without a motion may still slide, as a lid does
        u = np.where((e.motion == 0)[:, None], p.wall_u_all[e.nodes].mean(axis=1), e.velocity)
        walls = e.walls._replace(velocity=u, sticks=(p.no_slip_all[e.nodes] == 1).all(axis=1))
        wall_law.rub(out, flow.cloud, walls, p.u_all, wall_law.Law(law.viscosity, law.roughness, flow.step.dt))

    # -- walls that move -------------------------------------------------------------------

    def leave_out(self, flow: "Flow") -> None:
        """Write the role of wall particles that no stencil uses."""
        p = flow.particles
        p.role[(p.kind == WALL) & (p.edge == CONVEX)] = DRY
        if self.elements.moving:
            p.role[self.elements.before_moving(p) < NO_ROOM * flow.spacing] = DRY

    def move(self, flow: "Flow", at: float, start: float, stop: float) -> None:
        """Move walls to their places at a time [s] in a step from start to stop [s]."""
        if self.elements.moving:
            self.elements.place(at, start, stop)
            self.elements.put(flow.particles)

    def acceleration(self, flow: "Flow") -> Floats | None:
        """Return the acceleration of owned wall particles (n_owned, dim) [m/s^2], 0 for fluid; None if walls rest."""
        e = self.elements
        return e.of_particles(e.a, flow.particles) if e.moving else None

    def normal_acceleration(self, flow: "Flow") -> Floats | None:
        """Return the normal acceleration (n_owned,) [m/s^2] of fluid that slides along walls; None if all walls rest.

        It is n . a of the wall - 2 dn/dt . (u - u_w), the Coriolis force in the frame of the wall.
        """
        p, e = flow.particles, self.elements
        if not e.moving:
            return None
        along = np.einsum("ia,ia->i", p.normal, e.of_particles(e.a, p))
        found: Floats = along - 2.0 * np.einsum("ia,ia->i", e.of_particles(e.turn, p), p.u - p.wall_u)
        return found

    def longest_step(self, flow: "Flow", time: float) -> float:
        """Return the longest step [s] after a time [s] that resolves the motion of walls, infinite if none moves."""
        return self.elements.longest_step(time, flow.numerics.cfl)

    # -- pressure slopes at walls ----------------------------------------------------------

    def known_slopes(self, flow: "Flow") -> Flags:
        """Return which particles (n_all,) are walls with one normal and a known normal derivative of pressure.

        They include dry ones: the pressure of a wave continues above its surface within reach of a stencil. Walls that
        are apart and from which gravity pulls the water, as a lid above it, do not count.
        """
        p = flow.particles
        closing = p.closing_all if flow.open else ALL_WET
        known = wetness.known_slopes(flow.cloud, closing, flow.step.body_force)
        found: Flags = known & (p.edge_all != CONVEX)
        return found

    def slope(self, flow: "Flow", along: Floats | None) -> Floats:
        """Return the normal derivative (n_all,) of a field with the gradient `along` (n_all, dim) in water at rest.

        None stands for a zero gradient. For pressure it is rho times the force; moving walls subtract their inertia.
        """
        p, e = flow.particles, self.elements
        if along is None:
            return np.zeros(p.n_all)
        found = movement.along(p.normal_all, along)
        if e.moving:
            here, a, turn, u = e.of_walls(p)
            turned = np.einsum("ia,ia->i", turn, p.u_all[here] - u)
            found[here] -= flow.density * (np.einsum("ia,ia->i", p.normal_all[here], a) - 2.0 * turned)
        return found

    def mend_gradient(self, out: Floats, known: Flags, f: Floats, slope: Floats | None, flow: "Flow",
                      form: Form) -> None:
        """Repeat a linear fit out (n_owned, dim) of f (n_all,) where neighbours are too few but a wall is near.

        known : (n_owned,) bool, where out stays; slope : (n_all, dim), gradient across walls at rest, None for 0
        """
        e = self.elements
        here = np.zeros_like(flow.particles.x_all) if slope is None else slope
        less = e.acceleration * (0.0 if slope is None else flow.density)
        gradient.gradient_at_walls(out, known, flow.cloud, e.walls, f, here, less, form)
