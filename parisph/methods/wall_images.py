"""Flat walls, in which fluid is mirrored."""

from typing import TYPE_CHECKING

import numpy as np

from parisph.case.friction import Friction
from parisph.kernels import collisions, halves, mirrors, shifting, surface, wall_law
from parisph.kernels.wetness import FREE
from parisph.methods import lengths
from parisph.methods.boundary import Boundary, Directions

if TYPE_CHECKING:
    from parisph.methods.flow import Flow


class WallImages(Boundary):
    """The walls of a tank alone: its particles know planes, and neighbours have images in them."""

    def __init__(self) -> None:
        self._lists: np.ndarray | None = None
        self._found: tuple[np.ndarray, np.ndarray, np.ndarray]

    def _beside(self, flow):
        """Return which owned fluid has walls in its lists, and the CSR lists of these walls.

        Others are most, and kernels leave them out.
        """
        d = flow.domain
        if self._lists is not d.indices:
            self._lists, self._found = d.indices, mirrors.beside_walls(flow.particles.kind_all, d.indptr, d.indices)
        return self._found

    def density_ratio(self, out: np.ndarray, flow: "Flow", least: int) -> None:
        p, d = flow.particles, flow.domain
        surface.density_ratio(out, p.x_all, flow.seen(least), p.corner_all, p.normal_all,
                              lengths.DENSITY * flow.spacing, flow.full, d.indptr, d.indices, flow.axes)
        self._add_weights(out, np.empty_like(p.x), flow, least)

    def concentration(self, alpha: np.ndarray, gradient: np.ndarray, flow: "Flow", least: int) -> None:
        p, d = flow.particles, flow.domain
        shifting.concentration(alpha, gradient, p.x_all, flow.seen(least), p.corner_all, p.normal_all,
                               lengths.DENSITY * flow.spacing, flow.full, d.indptr, d.indices, flow.axes)
        self._add_weights(alpha, gradient, flow, least)

    def _add_weights(self, alpha, gradient, flow, least):
        """Add what the cells of the fluid were larger than those of the lattice at the start, if any were."""
        p, d = flow.particles, flow.domain
        if "weight" not in p.fields:
            return
        beside, walls, _ = self._beside(flow)
        more, h = p.weight_all - 1.0, lengths.DENSITY * flow.spacing
        halves.add_parts_inside(alpha, gradient, p.x_all, p.kind_all, more, h, flow.full, walls, d.indptr, d.indices,
                                flow.axes)
        none = np.empty(0)
        halves.add_parts(alpha, gradient, none, beside, p.x_all, flow.seen(least), more, none, p.corner_all,
                         p.normal_all, h, flow.full, d.indptr, d.indices, flow.axes)

    def surplus(self, ratio: np.ndarray, gradient: np.ndarray, share: np.ndarray, flow: "Flow",
                further: np.ndarray | None = None, other: np.ndarray | None = None) -> None:
        p = flow.particles
        beside, *walls = self._beside(flow)
        none = np.empty(0)
        halves.add_parts(ratio, gradient, none if further is None else further, beside, p.x_all, flow.seen(FREE),
                         1.0 - share, none if other is None else 1.0 - other, p.corner_all, p.normal_all,
                         lengths.DENSITY * flow.spacing, flow.full, *walls, flow.axes)

    def keep_off(self, move: np.ndarray, flow: "Flow") -> None:
        p = flow.particles
        beside, *walls = self._beside(flow)
        collisions.keep_off_walls(move, beside, p.x_all, p.kind_all, p.corner_all, p.normal_all,
                                  flow.numerics.wall_guard * flow.spacing, *walls, flow.axes)

    def guard(self, u: np.ndarray, flow: "Flow", dt: float) -> None:
        p = flow.particles
        beside, *walls = self._beside(flow)
        collisions.wall_guard(u, beside, p.x_all, p.kind_all, p.corner_all, p.normal_all,
                              flow.numerics.wall_guard * flow.spacing, dt, *walls, flow.axes)

    def rub(self, out: np.ndarray, flow: "Flow", law: Friction) -> None:
        p = flow.particles
        beside, *walls = self._beside(flow)
        wall_law.rub_planes(out, beside, p.u_all, p.wall_u_all, p.volume_all, p.x_all, p.kind_all,
                            p.corner_all, p.normal_all, p.no_slip_all, flow.spacing, flow.dt, law.viscosity,
                            law.roughness, *walls, flow.axes)

    def directions(self, flow: "Flow", least: int) -> Directions:
        dim, none = len(flow.axes), np.zeros(0, np.int32)
        return Directions(True, np.empty((0, dim, dim)), np.empty(0), np.zeros(len(flow.domain.indptr), np.int32), none)
