"""The highest point at which water touches a wall (2D)."""

from collections.abc import Sequence

import numpy as np

from parisph.base.errors import CaseError
from parisph.case import probes
from parisph.case.motion import AtRest, Motion
from parisph.geometry.probe_places import run_up_line
from parisph.watch.elevation import bodies
from parisph.watch.gauges import BODY, COLUMN_GAP, HEIGHT, SurfaceGauge, bodies_of_all, body_rows
from parisph.watch.sampling import WIDTH, Sampler, Scene, View

# Lengths in spacings.
TOUCH = 2.0       # water as near to the line as this touches it: a stretched lattice begins up to 1.5 beside a slope
BESIDE = 4.0      # surface particles that may serve to continue the surface
ASIDE = 0.1       # the second of two such particles is farther from the line than the first by more than this
APART = (0.5, 2.6)    # and as far from it
AHEAD = 1.0       # the surface is continued by this height at most
STRAIGHT = 1e-9   # sine of the angle between two pieces of a line that are one

COLUMNS = {"y": "m", "x": "m"}


def run_up(probe: probes.RunUp, scene: Scene) -> Sampler:
    """Return the sampler of a RunUp.

    Raises CaseError for a line that does not exist.
    """
    kind, now, line = scene.kinds.get(probe.on), scene.now, probe.points
    if now is None or kind is None:
        at = float((scene.lower if probe.side == "left" else scene.upper)[0])
        return _side(probe, scene, at) if line is None else LineRunUp(probe, scene, np.array(line, dtype=float))
    number = now.number(probe.on)
    if kind == "tank" and line is None and now.upright(number):
        return _side(probe, scene, scene.sides_at(0.0)[probe.side == "right"], now.motion_of(number))
    try:
        points = run_up_line(now.mesh, number, kind, probe.side) if line is None else np.array(line, dtype=float)
    except ValueError as error:
        raise CaseError(f"probe {probe.name!r}: on = {probe.on!r}, side = {probe.side!r}: {error}") from None
    return LineRunUp(probe, scene, points, now.motion_of(number))


def _side(probe: probes.RunUp, scene: Scene, at: float, motion: Motion = AtRest()) -> "SideRunUp":
    return SideRunUp(probe, scene, at, motion)


class SideRunUp(SurfaceGauge):
    """The surface at a vertical side of the tank, as of a SurfaceGauge there."""

    columns = COLUMNS

    def __init__(self, probe: probes.RunUp, scene: Scene, at: float, motion: Motion = AtRest()) -> None:
        self._start, self._motion = at, motion
        super().__init__(probe, scene, at)
        self.title = f"Highest water at the {probe.side} side of the {probe.on}"

    def place(self, time: float) -> None:
        self.at = float(self._motion.placed(np.array([(self._start, 0.0)]), time)[0, 0])
        super().place(time)

    def values(self, sums: np.ndarray, rows: np.ndarray) -> Sequence[float]:
        return (*super().values(sums, rows), self.at)


class LineRunUp(Sampler):
    """The upper end of the water along a line that begins in it.

    The end is that of the fluid within TOUCH that is connected with the beginning: by particles not farther apart than
    COLUMN_GAP, or than in a film as thin as `film` of the probe. From there, the straight line through two surface
    particles is continued to the wall: thin water ends where its particles are still some way below its tip. On a line
    that is dry, it is the first point.
    """

    columns = COLUMNS
    dims = (2,)

    def __init__(self, probe: probes.RunUp, scene: Scene, points: np.ndarray, motion: Motion = AtRest()) -> None:
        super().__init__(probe, scene)
        points = _corners(points)
        self.points, self._start, self._motion = points, points, motion
        s = scene.spacing
        self.gap = COLUMN_GAP * s if probe.film is None else max(COLUMN_GAP * s, s * s / probe.film)
        self.ends = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
        self.title = (f"Highest water along the line from ({points[0, 0]:g}, {points[0, 1]:g}) to "
                      f"({points[-1, 0]:g}, {points[-1, 1]:g}) m")

    def place(self, time: float) -> None:
        self.points = self._motion.placed(self._start, time)

    def rows(self, view: View) -> np.ndarray:
        s = self.scene.spacing
        # in a torn film, particles have too few neighbours to be anything but spray
        along, away = self._onto(np.stack(view.body, axis=1) if self.probe.film is None else view.fluid_places)
        surface = np.stack(view.surface, axis=1)
        surface = surface[self._onto(surface)[1] <= BESIDE * s]
        heights = np.zeros((len(surface), WIDTH - 1))
        heights[:, 0], heights[:, 1:3] = HEIGHT, surface
        return np.concatenate([heights, body_rows(bodies(along[away <= TOUCH * s], self.gap))])

    def values(self, sums: np.ndarray, rows: np.ndarray) -> Sequence[float]:
        found = bodies_of_all(rows[rows[:, 0] == BODY], self.gap)
        if not len(found) or found[0, 0] > COLUMN_GAP * self.scene.spacing:
            return self.points[0, ::-1]
        end = found[0, 1]
        tip = np.array([np.interp(end, self.ends, self.points[:, axis]) for axis in (0, 1)])
        continued = self._continued(rows[rows[:, 0] == HEIGHT, 1:3], end)
        if continued is None or (self.probe.film is not None and self._onto(continued[None])[0][0] < end):
            return tip[::-1]    # spray ahead of the surface is part of a film
        return continued[::-1]

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
        """Return how far along the line the places nearest to x (n, 2) are, and how far away: (n,) each [m].

        Where that is more than BESIDE, the latter may be infinite.
        """
        along, away = np.zeros(len(x)), np.full(len(x), np.inf)
        order, reach = np.argsort(x[:, 0]), BESIDE * self.scene.spacing
        places = x[order, 0]
        for low, start, side in zip(self.ends, self.points, np.diff(self.points, axis=0)):
            left, right = sorted((start[0], start[0] + side[0]))
            own = order[slice(*np.searchsorted(places, (left - reach, right + reach)))]
            share = np.clip((x[own] - start) @ side / (side @ side), 0.0, 1.0)
            distance = np.linalg.norm(x[own] - start - share[:, None] * side, axis=1)
            nearer = distance < away[own]
            along[own[nearer]], away[own[nearer]] = low + share[nearer] * np.linalg.norm(side), distance[nearer]
        return along, away


def _corners(points):
    """Return the points (n, 2) of a line without those on the straight line between their neighbours."""
    a, b = np.diff(points, axis=0)[:-1], np.diff(points, axis=0)[1:]
    turns = np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) > STRAIGHT * np.hypot(*a.T) * np.hypot(*b.T)
    return points[np.concatenate([[True], turns, [True]])]
