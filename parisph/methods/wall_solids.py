"""Walls of any shape, as elements with solid behind them."""

from typing import TYPE_CHECKING

import numpy as np

from parisph.base.fields import ABSENT, DRY, WALL
from parisph.case.friction import Friction
from parisph.geometry.mesh import CONVEX
from parisph.kernels import density, gradient, solids, wall_law, wetness
from parisph.kernels.moving_mirrors import GONE, SLIPS, STICKS, Solids
from parisph.kernels.near import Form
from parisph.kernels.records import no_walls
from parisph.methods import lengths
from parisph.methods.boundary import Boundary, Directions
from parisph.parallel.wall_elements import NO_ROOM, WallElements

if TYPE_CHECKING:
    from parisph.methods.flow import Flow


class WallSolids(Boundary):
    """Walls of any shape. Fluid does not see through elements, and the solid behind them completes sums of kernels.

    elements : those of the domain
    """

    fields, shapes = ("weight", "area", "edge", "body", "half", "covered"), True

    def __init__(self, elements: WallElements, spacing: float) -> None:
        self.elements = elements
        self.table = density.table(spacing, lengths.DENSITY * spacing, elements.mesh.dim)

    def cover(self, flow: "Flow") -> tuple[str, ...]:
        p = flow.particles
        wetness.covered_walls(p.covered, flow.cloud)
        if self.elements.moving:
            p.covered *= np.clip(0.5 + self.elements.before_moving(p) / flow.spacing, 0.0, 1.0)
        return ("covered",)

    def counted(self, flow: "Flow", least: int) -> np.ndarray:
        """Return the part of each particle (n_all,) that counts: of walls `least` what is covered."""
        p = flow.particles
        if "closing" not in p.fields:    # a full closed tank
            return np.ones(p.n_all)
        return np.where((p.kind_all == WALL) & (p.closing_all < least), 0.0, p.covered_all)

    def frictional(self, flow: "Flow", seen: np.ndarray) -> tuple[np.ndarray, Solids]:
        p, e = flow.particles, self.elements
        here = e.nodes >= 0
        there = (here & (seen[e.nodes] != ABSENT)).any(axis=1)
        sticks = (p.no_slip_all[e.nodes] == 1).all(axis=1)
        u = np.where(sticks[:, None], p.u_all[e.nodes].mean(axis=1), e.velocity)
        state = np.where(there, np.where(sticks, STICKS, SLIPS), GONE).astype(np.int8)
        # the velocity of free water is not known on a convex edge, whose nodes carry no row
        unknown = (p.kind_all == WALL) & (p.edge_all == CONVEX) & (p.no_slip_all == 0)
        return np.where(unknown, np.int8(ABSENT), seen), Solids(e.corners, u, state, e.indptr, e.indices)

    def density_ratio(self, out: np.ndarray, flow: "Flow", least: int) -> None:
        self._complete(density.completed_density, out, flow, least)

    def concentration(self, alpha: np.ndarray, gradient: np.ndarray, flow: "Flow", least: int) -> None:
        self._complete(density.completed_density, alpha, flow, least)
        self._complete(density.completed_gradient, gradient, flow, least)

    def _complete(self, kernel, out, flow, least):
        p, d, e = flow.particles, flow.domain, self.elements
        counted = self.counted(flow, least)
        kernel(out, p.x_all, p.kind_all, p.weight_all * counted, p.area_all * counted[:, None], e.corners,
               e.mean_of_nodes(counted), *self.table, e.indptr, e.indices, d.indptr, d.indices, flow.axes)

    def surplus(self, ratio: np.ndarray, gradient: np.ndarray, share: np.ndarray, flow: "Flow",
                further: np.ndarray | None = None, other: np.ndarray | None = None) -> None:
        if further is not None and other is not None:
            self.surplus(further, np.zeros_like(gradient), other, flow)
        p, d, e = flow.particles, flow.domain, self.elements
        counted = self.counted(flow, wetness.FREE)
        weight, area = p.weight_all * counted, p.area_all * counted[:, None]
        filled, lean = density.node_terms(weight, area, share)
        density.node_sums(ratio, gradient, p.x_all, p.kind_all, weight - filled, area - lean, self.table.values,
                          self.table.h, self.table.full, e.indptr, d.indptr, d.indices, flow.axes)

    def keep_off(self, move: np.ndarray, flow: "Flow") -> None:
        p, e = flow.particles, self.elements
        solids.keep_off_solids(move, p.x_all, p.kind_all, e.corners, flow.numerics.wall_guard * flow.spacing,
                               e.indptr, e.indices, flow.axes)

    def guard(self, u: np.ndarray, flow: "Flow", dt: float) -> None:
        p, e = flow.particles, self.elements
        solids.guard_solids(u, p.x_all, p.kind_all, e.corners, e.velocity, flow.numerics.wall_guard * flow.spacing, dt,
                            e.indptr, e.indices, flow.axes)

    def rub(self, out: np.ndarray, flow: "Flow", law: Friction) -> None:
        p, e = flow.particles, self.elements
        # walls at rest may slide, as a lid does; those that move have their velocity from their motion
        u = np.where((e.motion == 0)[:, None], p.wall_u_all[e.nodes].mean(axis=1), e.velocity)
        sticks = (p.no_slip_all[e.nodes] == 1).all(axis=1)
        wall_law.rub_elements(out, p.u_all, u, sticks, p.volume_all, p.x_all, p.kind_all, e.corners, flow.spacing,
                              flow.dt, law.viscosity, law.roughness, e.indptr, e.indices, flow.axes)

    def directions(self, flow: "Flow", least: int) -> Directions:
        e = self.elements
        return Directions(False, e.corners, e.mean_of_nodes(self.counted(flow, least)), e.indptr, e.indices)

    def cells(self, flow: "Flow") -> np.ndarray:
        p = flow.particles
        return np.where(p.half_all == 1, 0.5, flow.cells)

    def leave_out(self, flow: "Flow") -> None:
        p = flow.particles
        p.role[(p.kind == WALL) & (p.edge == CONVEX)] = DRY
        if self.elements.moving:
            p.role[self.elements.before_moving(p) < NO_ROOM * flow.spacing] = DRY

    def move(self, flow: "Flow", at: float, start: float, stop: float) -> None:
        if self.elements.moving:
            self.elements.place(at, start, stop)
            self.elements.put(flow.particles)

    def acceleration(self, flow: "Flow") -> np.ndarray | None:
        e = self.elements
        return e.of_particles(e.a, flow.particles) if e.moving else None

    def normal_acceleration(self, flow: "Flow") -> np.ndarray | None:
        p, e = flow.particles, self.elements
        if not e.moving:
            return None
        along = np.einsum("ia,ia->i", p.normal, e.of_particles(e.a, p))
        return along - 2.0 * np.einsum("ia,ia->i", e.of_particles(e.turn, p), p.u - p.wall_u)

    def shear(self, flow: "Flow") -> np.ndarray:
        return -self.elements.of_particles(self.elements.turn, flow.particles)

    def longest_step(self, flow: "Flow", time: float) -> float:
        return self.elements.longest_step(time, flow.numerics.cfl)

    def known_slopes(self, flow: "Flow") -> np.ndarray:
        return super().known_slopes(flow) & (flow.particles.edge_all != CONVEX)

    def slope(self, flow: "Flow", along: np.ndarray | None) -> np.ndarray:
        found, p, e = super().slope(flow, along), flow.particles, self.elements
        if e.moving and along is not None:
            here, a, turn, u = e.of_walls(p)
            turned = np.einsum("ia,ia->i", turn, p.u_all[here] - u)
            found[here] -= flow.density * (np.einsum("ia,ia->i", p.normal_all[here], a) - 2.0 * turned)
        return found

    def mend_gradient(self, out: np.ndarray, known: np.ndarray, f: np.ndarray, slope: np.ndarray | None, flow: "Flow",
                      form: Form) -> None:
        e = self.elements
        here, less = np.zeros_like(flow.particles.x_all), np.zeros_like(e.acceleration)
        if slope is not None:
            here, less = slope, flow.density * e.acceleration
        walls = no_walls(0, len(flow.axes))._replace(corners=e.corners, indptr=e.indptr, indices=e.indices)
        gradient.gradient_at_walls(out, known, flow.cloud, walls, f, here, less, form)
