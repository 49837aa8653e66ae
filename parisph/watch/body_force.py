"""Force and moment of the pressure on a body of elements (2D)."""

from collections.abc import Sequence

import numpy as np

from parisph.base.fields import DRY, WALL
from parisph.case import probes
from parisph.geometry.mesh import CONVEX, WallMesh, area_vectors
from parisph.geometry.outline import outline_of
from parisph.geometry.probe_places import force_elements
from parisph.watch.sampling import WIDTH, OfPressure, Sampler, Scene, View
from parisph.watch.wall_pressure import Force, about, at_rest, force_columns

DRY_BEHIND = "piston", "flap"    # bodies behind which walls are never wet
FOOT = 1.0      # spacings in front of a wavemaker: dry nodes of other walls there are at its foot, not above the water
LAST = -1.0     # the first number of a row that tells the greatest number of a wall particle; else that of a node


class BodyForce(OfPressure):
    """As Force, for a body of any shape, which may move: its nodes are where they are now.

    On each element the pressure is linear between its nodes, and the integrals are exact. A node on a convex edge has
    no pressure: there that along the element's side of the edge is continued linearly, or as it is beside a dry node.
    So it is at the end of a line of elements, as the foot of a wavemaker, which no row belongs to, but not below 0.
    """

    dims = (2,)

    def __init__(self, probe: probes.Force, scene: Scene, mesh: WallMesh) -> None:
        self.columns = force_columns(probe)
        super().__init__(probe, scene)
        self.about, self._mesh, self._ends = np.array(probe.about), mesh, mesh.ends
        self._elements = force_elements(mesh, probe)
        self._faces = _faces(scene, probe.on) if probe.still is not None else []
        self._bodies = np.unique(mesh.body[[*self._elements.flat, *(node for face in self._faces for node in face)]])
        # of each end of an element: the node beyond its other end on the same body, or that end itself
        self._beyond = np.stack([_next(self._elements, end) for end in (0, 1)], axis=1)
        self.title = (f"Force of the pressure on {probe.on}{f', {probe.side} side' * bool(probe.side)}, and its moment "
                      f"about {about(probe)}")

    def rows(self, view: View) -> np.ndarray:
        """Return a row (its number, x, y, pressure) for each wall particle here that may be a node of the body.

        The pressure is that of a node with one, inf at a dry one, nan on a convex edge.
        """
        p = view.particles
        wall = np.flatnonzero(p.kind == WALL)
        last = p.id[wall].max(initial=-1)
        wall = wall[np.isin(p.body[wall], self._bodies)]
        rows = np.empty((len(wall) + 1, WIDTH - 1))
        rows[0] = LAST, last, 0.0, 0.0
        rows[1:, 0], rows[1:, 1:3] = p.id[wall], p.x[wall]
        rows[1:, 3] = np.where(p.edge[wall] == CONVEX, np.nan, np.where(p.role[wall] == DRY, np.inf, p.p[wall]))
        return rows

    def acting(self, sums: np.ndarray, rows: np.ndarray) -> Sequence[float]:
        nodes, last = rows[rows[:, 0] != LAST], rows[rows[:, 0] == LAST, 1].max()
        x, p = np.zeros_like(self._mesh.x0), np.full(len(self._mesh.x0), np.inf)
        number = (nodes[:, 0] - (last + 1 - len(x))).astype(int)    # nodes are the last particles, in their order
        x[number], p[number] = nodes[:, 1:3], nodes[:, 3]
        p[self._ends & np.isposinf(p)] = np.nan
        found = self._load(x, p)
        if self.probe.still is None:
            return found
        rest = at_rest(self.probe, self.scene, x)
        wet = (rest > 0.0) & ~(np.isposinf(p) & self._behind(x))
        rest = self._load(x, np.where(np.isnan(p), np.nan, np.where(wet, rest, np.inf)))
        return (*found, *np.subtract(found, rest))

    def _behind(self, x):
        """Return which nodes x (n, 2) [m] lie behind a wavemaker, on its dry side, or at its foot."""
        found = np.zeros(len(x), dtype=bool)
        for start, end in self._faces:
            way, off = x[end] - x[start], x - x[start]
            found |= way[0] * off[:, 1] - way[1] * off[:, 0] < FOOT * self.scene.spacing * np.linalg.norm(way)
        return found

    def _load(self, x, p):
        """Return the force and the moment of pressures p at nodes x: inf at dry ones, nan on convex edges."""
        ends, pressure = x[self._elements], self._pressures(x, p)
        area = area_vectors(ends)
        force = -pressure.mean(axis=1)[:, None] * area
        # the integral of (x - about) p over an element, whose normal is the same all along
        (a, b), (p, q) = np.moveaxis(ends - self.about, 1, 0), pressure.T
        arm = ((2.0 * p + q)[:, None] * a + (p + 2.0 * q)[:, None] * b) / 6.0
        moment = -(arm[:, 0] * area[:, 1] - arm[:, 1] * area[:, 0]).sum()
        return (*force.sum(axis=0), moment)

    def _pressures(self, x, p):
        """Return the pressures at both ends of each element (M, 2)."""
        found = np.empty(self._elements.shape)
        wet = np.isfinite(p)
        for end in (0, 1):
            own, other, beyond = self._elements[:, end], self._elements[:, 1 - end], self._beyond[:, end]
            length = np.linalg.norm(x[own] - x[other], axis=1)
            share = length / np.maximum(np.linalg.norm(x[other] - x[beyond], axis=1), np.finfo(float).tiny)
            there = np.where(wet, p, 0.0)
            linear = wet[other] & wet[beyond] & (other != beyond)
            continued = there[other] + np.where(linear, share * (there[other] - there[beyond]), 0.0)
            continued = np.where(self._ends[own], np.maximum(continued, 0.0), continued)
            found[:, end] = np.where(np.isnan(p[own]), continued, there[own])
        return found


def _next(elements, end):
    """Return, for each element, the node beyond its end 1 - `end`; that end itself if there is none."""
    after = {element[end]: element[1 - end] for element in elements.tolist()}
    return np.array([after.get(element[1 - end], element[1 - end]) for element in elements.tolist()])


def _faces(scene, on):
    """Return the nodes at the first and the last point of the face of each wavemaker but the body `on` itself.

    Fluid is left of the way from one to the other.
    """
    mesh, found = scene.mesh, []
    for number, body in enumerate(mesh.bodies):
        if body.name != on and scene.kinds.get(body.name) in DRY_BEHIND:
            own = np.unique(mesh.elements[mesh.element_body == number])
            ends = outline_of(scene.now.walls[number]).points[[0, -1]]
            found.append(tuple(own[np.argmin(np.linalg.norm(mesh.x0[own] - end, axis=1))] for end in ends))
    return found


def force_on(probe: probes.Force, scene: Scene) -> Sampler:
    """Return the sampler of a Force: on the tank of a plain scene, or on a body of elements."""
    return Force(probe, scene) if scene.mesh is None else BodyForce(probe, scene, scene.mesh)
