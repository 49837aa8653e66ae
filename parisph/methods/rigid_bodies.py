"""Bodies in the flow: their motion in a step, and the load of the pressure on them."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from parisph.base.arrays import Floats, Ints
from parisph.base.fields import DRY, WALL
from parisph.case.motion import Motion
from parisph.geometry.distance import area_vectors
from parisph.geometry.mesh import CONVEX, WallMesh
from parisph.geometry.movers import MovedNodes

if TYPE_CHECKING:    # machines without MPI describe probes
    from parisph.parallel.particles import Particles
    from parisph.parallel.wall_elements import WallElements


@dataclass(frozen=True)
class Prescribed:
    """The Mover of a body whose motion is a function of time. It keeps no state."""

    motion: Motion

    def moved(self, mesh: WallMesh, own: Ints, at: float, start: float, stop: float) -> MovedNodes:
        """See Mover."""
        motion, x0, normal0 = self.motion, mesh.x0[own], mesh.normal0[own]
        before, after = motion.placed(x0, start), motion.placed(x0, stop)
        u = motion.velocity_at(before, start)
        tip = before + motion.turned(normal0, start)
        if stop > start:
            mean, a = (after - before) / (stop - start), (motion.velocity_at(after, stop) - u) / (stop - start)
        else:
            mean, a = u, motion.acceleration_at(before, start)
        return MovedNodes(x=motion.placed(x0, at), normal=motion.turned(normal0, at),
                          vector_area=motion.turned(mesh.vector_area[own], at), u=u,
                          turn=motion.velocity_at(tip, start) - u, mean=mean, a=a)

    def longest_step(self, x0: Floats, time: float, room: float) -> float:
        """See Mover: the step also resolves the law."""
        x = self.motion.placed(x0, time)
        speed = np.linalg.norm(self.motion.velocity_at(x, time), axis=1).max()
        push = np.linalg.norm(self.motion.acceleration_at(x, time), axis=1).max()
        return float(min(self.motion.longest_step, room / max(speed, 1e-300), np.sqrt(2.0 * room / max(push, 1e-300))))


def node_pressures(particles: "Particles", elements: "WallElements") -> tuple[Ints, Ints, Floats]:
    """Return the wall particles of this rank (n,), their mesh nodes (n,) and their pressures (n,) [Pa]. Not collective.

    The pressure is inf at a dry node, and NaN on a convex edge, which has no row, and where fluid has no room in front
    (WallElements.without_room).
    """
    p = particles
    wall = np.flatnonzero(p.kind == WALL)
    found = np.where(p.role[wall] == DRY, np.inf, p.p[wall])
    found[(p.edge[wall] == CONVEX) | elements.without_room(p)[wall]] = np.nan
    return wall, p.id[wall] - elements.first, found


class PressureLoad:
    """Force of the pressure on elements of a body, -sum p n A, and its moment about a point (2D). Not collective.

    The pressure is linear along each element, and the integrals are exact. Dry nodes have p = 0. At a node without
    pressure, that of the element's side of the edge is extrapolated linearly, or as a constant beside a dry node. At
    the end of a line of elements, as at the foot of a wavemaker, it is at least 0.

    mesh : WallMesh, elements : (M, 2) its elements, by nodes
    """

    def __init__(self, mesh: WallMesh, elements: Ints) -> None:
        self.elements, self._ends = elements, mesh.ends
        # for each end of an element: the node beyond the other end on the same body, or that end itself
        self._beyond = np.stack([_next(elements, end) for end in (0, 1)], axis=1)

    def of(self, x: Floats, p: Floats, about: Floats) -> tuple[float, float, float]:
        """Return force [N/m] and moment [N m/m] about a point (2,) [m] from the pressures of all nodes of the mesh.

        x : (N, 2) [m], p : (N,) [Pa] as of `node_pressures`
        """
        ends, pressure = x[self.elements], self._pressures(x, p)
        area = area_vectors(ends)
        force = (-pressure.mean(axis=1)[:, None] * area).sum(axis=0)
        # the integral of (x - about) p over an element, with a constant normal
        (a, b), (p, q) = np.moveaxis(ends - about, 1, 0), pressure.T
        arm = ((2.0 * p + q)[:, None] * a + (p + 2.0 * q)[:, None] * b) / 6.0
        moment = -(arm[:, 0] * area[:, 1] - arm[:, 1] * area[:, 0]).sum()
        return force[0], force[1], moment

    def _pressures(self, x: Floats, p: Floats) -> Floats:
        """Return the pressures at both ends of each element (M, 2)."""
        found = np.empty(self.elements.shape)
        wet = np.isfinite(p)
        for end in (0, 1):
            own, other, beyond = self.elements[:, end], self.elements[:, 1 - end], self._beyond[:, end]
            length = np.linalg.norm(x[own] - x[other], axis=1)
            share = length / np.maximum(np.linalg.norm(x[other] - x[beyond], axis=1), np.finfo(float).tiny)
            there = np.where(wet, p, 0.0)
            linear = wet[other] & wet[beyond] & (other != beyond)
            continued = there[other] + np.where(linear, share * (there[other] - there[beyond]), 0.0)
            continued = np.where(self._ends[own], np.maximum(continued, 0.0), continued)
            found[:, end] = np.where(np.isnan(p[own]), continued, there[own])
        return found


def _next(elements: Ints, end: int) -> Ints:
    """Return, for each element, the node beyond its end 1 - `end`, or that end itself."""
    after = {element[end]: element[1 - end] for element in elements.tolist()}
    return np.array([after.get(element[1 - end], element[1 - end]) for element in elements.tolist()])
