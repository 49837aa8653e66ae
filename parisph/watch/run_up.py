"""The highest point at which water touches a wall (2D)."""

from collections.abc import Sequence

import numpy as np

from parisph.base.errors import CaseError
from parisph.case import probes
from parisph.geometry.mesh import WallMesh
from parisph.watch.elevation import bodies
from parisph.watch.gauges import BODY, COLUMN_GAP, HEIGHT, SurfaceGauge, bodies_of_all, body_rows
from parisph.watch.sampling import WIDTH, Sampler, Scene, View

# Lengths in spacings.
TOUCH = 2.0       # water as near to the line as this touches it: a stretched lattice begins up to 1.5 beside a slope
BESIDE = 4.0      # surface particles that may serve to continue the surface
ASIDE = 0.1       # the second of two such particles is farther from the line than the first by more than this
APART = (0.5, 2.6)    # and as far from it
AHEAD = 1.0       # the surface is continued by this height at most

FLAT = 1e-9       # of the height of a profile: what is no more above its lowest node is as low

COLUMNS = {"y": "m", "x": "m"}


def run_up(probe: probes.RunUp, scene: Scene) -> Sampler:
    """Return the sampler of a RunUp.

    Raises CaseError for a profile that moves, or is not there.
    """
    if probe.points is not None:
        return LineRunUp(probe, scene, np.array(probe.points, dtype=float))
    if scene.mesh is not None and scene.kinds.get(probe.on) == "profile":
        return LineRunUp(probe, scene, _slope(probe, scene.mesh))
    return SideRunUp(probe, scene, float((scene.lower if probe.side == "left" else scene.upper)[0]))


def _slope(probe: probes.RunUp, mesh: WallMesh) -> np.ndarray:
    """Return the nodes (n, 2) [m] of a profile from its lowest one to one of its ends."""
    number = [body.name for body in mesh.bodies].index(probe.on)
    mine = mesh.elements[mesh.element_body == number]
    if mesh.bodies[number].motion or not len(mine):
        raise CaseError(f"probe {probe.name!r}: on = {probe.on!r}: moves, or no fluid touches it; give another wall")
    x = mesh.x0[np.append(mine[:, 0], mine[-1, 1])]    # with the fluid on the left, from left to right
    x = x if probe.side == "right" else x[::-1]
    lowest = np.flatnonzero(x[:, 1] <= x[:, 1].min() + FLAT * (x[:, 1].max() - x[:, 1].min()))[-1]
    if lowest == len(x) - 1:
        raise CaseError(f"probe {probe.name!r}: side = {probe.side!r}: {probe.on} is lowest at this end; "
                        "choose the other one")
    return x[lowest:]


class SideRunUp(SurfaceGauge):
    """The surface at a vertical side of the tank, as of a SurfaceGauge there."""

    columns = COLUMNS

    def __init__(self, probe: probes.RunUp, scene: Scene, at: float) -> None:
        super().__init__(probe, scene, at)
        self.title = f"Highest water at the {probe.side} side of the {probe.on}"

    def values(self, sums: np.ndarray, rows: np.ndarray) -> Sequence[float]:
        return (*super().values(sums, rows), self.at)


class LineRunUp(Sampler):
    """The upper end of the water along a line that begins in it.

    The end is that of the fluid within TOUCH that is connected with the beginning. From there, the straight line
    through two surface particles is continued to the wall: thin water ends where its particles are still some way below
    its tip. On a line that is dry, it is the first point.
    """

    columns = COLUMNS
    dims = (2,)

    def __init__(self, probe: probes.RunUp, scene: Scene, points: np.ndarray) -> None:
        super().__init__(probe, scene)
        self.points = points
        self.ends = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
        self.title = (f"Highest water along the line from ({points[0, 0]:g}, {points[0, 1]:g}) to "
                      f"({points[-1, 0]:g}, {points[-1, 1]:g}) m")

    def rows(self, view: View) -> np.ndarray:
        s = self.scene.spacing
        along, away = self._onto(np.stack(view.body, axis=1))
        surface = np.stack(view.surface, axis=1)
        surface = surface[self._onto(surface)[1] <= BESIDE * s]
        heights = np.zeros((len(surface), WIDTH - 1))
        heights[:, 0], heights[:, 1:3] = HEIGHT, surface
        return np.concatenate([heights, body_rows(bodies(along[away <= TOUCH * s], COLUMN_GAP * s))])

    def values(self, sums: np.ndarray, rows: np.ndarray) -> Sequence[float]:
        s = self.scene.spacing
        found = bodies_of_all(rows[rows[:, 0] == BODY], COLUMN_GAP * s)
        if not len(found) or found[0, 0] > COLUMN_GAP * s:
            return self.points[0, ::-1]
        end = found[0, 1]
        tip = np.array([np.interp(end, self.ends, self.points[:, axis]) for axis in (0, 1)])
        continued = self._continued(rows[rows[:, 0] == HEIGHT, 1:3], end)
        return (tip if continued is None else continued)[::-1]

    def _continued(self, surface, end):
        """Return where the surface beside the end meets the line, (2,) [m], or None."""
        s = self.scene.spacing
        along, away = self._onto(surface)
        first = np.flatnonzero((away <= TOUCH * s) & (along <= end + 1e-9 * s) & (along >= end - TOUCH * s))
        if not len(first):
            return None
        first = first[np.argmax(along[first])]
        gap = np.linalg.norm(surface - surface[first], axis=1)
        second = np.flatnonzero((gap >= APART[0] * s) & (gap <= APART[1] * s) & (away > away[first] + ASIDE * s))
        if not len(second):
            return None
        second = second[np.argmin(gap[second])]
        return self._met(surface[first], surface[first] - surface[second])

    def _met(self, x, direction):
        """Return where the ray from x first meets the line, None if it does not within AHEAD in height."""
        a, b = self.points[:-1] - x, np.diff(self.points, axis=0)
        cross = direction[0] * b[:, 1] - direction[1] * b[:, 0]
        with np.errstate(divide="ignore", invalid="ignore"):
            ahead = (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) / cross
            within = (a[:, 0] * direction[1] - a[:, 1] * direction[0]) / cross
        met = ahead[(ahead >= 0.0) & (within >= 0.0) & (within <= 1.0)]
        if not len(met) or abs(met.min() * direction[1]) > AHEAD * self.scene.spacing:
            return None
        return x + met.min() * direction

    def _onto(self, x):
        """Return how far along the line the places nearest to x (n, 2) are, and how far away: (n,) each [m]."""
        along, away = np.zeros(len(x)), np.full(len(x), np.inf)
        for low, start, side in zip(self.ends, self.points, np.diff(self.points, axis=0)):
            share = np.clip((x - start) @ side / (side @ side), 0.0, 1.0)
            distance = np.linalg.norm(x - start - share[:, None] * side, axis=1)
            nearer = distance < away
            along[nearer], away[nearer] = low + share[nearer] * np.linalg.norm(side), distance[nearer]
        return along, away
