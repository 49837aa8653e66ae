"""The highest point at which water touches a wall."""

from collections.abc import Iterator
from typing import Literal, Optional

import numpy as np
from pydantic import Field, model_validator

from parisph.base.arrays import Floats, Ints
from parisph.base.errors import CaseError
from parisph.base.fields import SURFACE
from parisph.base.probe_rows import BODY, HEIGHT, WIDTH
from parisph.base.text import point
from parisph.case import probe_checks
from parisph.case.bodies import motion_of
from parisph.case.breadth import section_of
from parisph.case.model import Several
from parisph.case.motion import AtRest, Motion, Rotation
from parisph.case.probes import AcrossProbe, Measure, Point, up
from parisph.case.scene import Scene
from parisph.case.scenery import body_names
from parisph.geometry.columns import cross, meet
from parisph.geometry.distance import nearest
from parisph.geometry.mesh import WallMesh, places_along, reaches
from parisph.geometry.probe_places import Places, on_side
from parisph.watch.gauges import COLUMN, COLUMN_GAP, ROUNDING, bodies, bodies_of_all, body_rows
from parisph.watch.probes.surface_gauge import surface, surface_rows
from parisph.watch.sampling import ProbeScene, View

# Lengths in spacings.
TOUCH = 2.0       # distance at which water touches the line: a stretched lattice begins up to 1.5 beside a slope
BESIDE = 4.0      # distance from the line of surface particles that may continue the surface
ASIDE = 0.1       # least difference of the distances of two such particles from the line
APART = (0.5, 2.6)    # range of the distance of these two
AHEAD = 1.0       # most height by which the surface is continued
STRAIGHT = 1e-9   # largest sine of the angle between two pieces of a straight line
LIFT = 0.1        # distance in front of a wall at which its fluid is sought
FLAT = 1e-9       # largest difference of equal heights, over the height of a body


class RunUp(AcrossProbe):
    """Height [m] of the highest point at which water touches a wall, and its x [m].

    Only water counts that is connected, along the wall, with the lower end of the wall. At a vertical side of a tank it
    is the height of a SurfaceGauge; along a line, the surface is continued straight to the line. The line moves with
    its body.

    on : name of the body
    side : of a Tank, an Obstacle or a Plate; or the end of a Profile, to which the line goes from its lowest point. A
        Piston and a Flap need none
    points : the line itself at t = 0 [m], from below the water upwards, in place of a side
    film : along a line, thickness of the thinnest film that counts [m]. In a film of thickness h, particles of spacing
        s are s^2/h apart. None for half a spacing, at which particles are 2.1 spacings apart, without spray
    y : of the section of a 3D scene in which it is measured, with the water within 1.5 spacings. `points` are (x, z)

    >>> RunUp("wall", side="right").on
    'tank'
    >>> RunUp("beach", points=[(4.0, 0.0), (6.0, 0.5)]).points[1]
    (6.0, 0.5)
    """

    columns = {"y": "m", "x": "m"}
    quantity = "highest contact"

    kind: Literal["run_up"] = Field(default="run_up", init=False)
    on: str = Field(default="tank", description="name of the body")
    side: Literal["left", "right"] | None = Field(default=None, description="side of the body, or end of the profile")
    points: Optional[Several[Point]] = Field(default=None, min_length=2, max_length=10_000,
                                                description="line along the wall, from below the water upwards [m]")
    film: Optional[float] = Field(default=None, gt=0.0, description="thinnest film that counts [m]")

    @model_validator(mode="after")
    def _one_line(self) -> "RunUp":
        neither = self.side is None and self.points is None and self.on == "tank"
        if neither or (self.side is not None and self.points is not None):
            raise ValueError("give either a side of the tank, side='left' or 'right', or the points of a line")
        return self

    def title(self, scene: ProbeScene) -> str:
        found = self.begin(scene)
        if isinstance(found, LineRunUp):
            ends = f"{point(found.points[0])} to {point(found.points[-1])} m"
            return f"Highest water along the line from {ends}{self._where}"
        return f"Highest water at the {self.side} side of the {self.on}{self._where}"

    @property
    def _where(self) -> str:
        return "" if self.y is None else f", at y = {self.y:g} m"

    def columns_in(self, scene: ProbeScene) -> dict[str, str]:
        return {up(scene.dim): "m", "x": "m"}

    def problems(self, case: Scene) -> Iterator[str]:
        if case.dim == 3 and self.y is None:
            yield "a run-up of a 3D scene is measured in one section; give its place across: y=..."
            return
        wrong = [*self.wrong_y(case), *(f"point = {x} must have 2 components, of the section"
                                        for x in self.points or () if len(x) != 2)]
        yield from wrong
        if self.points is not None:
            if wrong:
                return
            if any(one == other for one, other in zip(self.points, self.points[1:])):
                yield "points: two neighbouring points are equal; leave one out"
            else:
                yield from probe_checks.inside(case, "points", [self._lifted(x) for x in self.points])
            if self.on != "tank":
                yield from probe_checks.body(case, self.on)
        elif missing := list(probe_checks.body(case, self.on)):
            yield from missing
        else:
            body = case.bodies[body_names(case.bodies).index(self.on)]
            yield from self._wrong_side(body.kind, isinstance(motion_of(body), Rotation))

    def _lifted(self, x: Point) -> Point:
        """Return the place in the scene of a point of the section."""
        return x if self.y is None else (x[0], self.y, x[-1])

    def _wrong_side(self, kind: str, rolls: bool) -> Iterator[str]:
        one_sided = kind in ("piston", "flap")
        if self.side is None and not one_sided:
            yield f"on = {self.on!r}: give its side, side='left' or 'right', or the points of a line"
        elif self.side is not None and one_sided:
            yield f"side = {self.side!r}: {self.on} has fluid on one side only; leave it out"
        elif self.film is not None and kind == "tank" and not rolls:
            yield (f"film = {self.film:g} m has no effect at a vertical side, where the height is that of a "
                   "SurfaceGauge; leave it out, or give the points of a line")

    def misplaced(self, places: Places) -> Iterator[str]:
        """See Probe: its line is on a wall that fluid reaches, and moves with that wall."""
        mesh = places.plane(self.y)
        if mesh is None:
            return
        if self.points is not None:
            points, corners = np.array(self.points, dtype=float), mesh.corners()
            for number, body in enumerate(mesh.bodies):
                apart = nearest(points, corners[mesh.element_body == number], within=places.spacing)[0]
                if body.motion and self.on != body.name and np.isfinite(apart).all():
                    yield (f"its points are on {body.name}, which moves; give on={body.name!r} for the line to move "
                           "with it")
            return
        kind = places.case.bodies[body_names(places.case.bodies).index(self.on)].kind
        names = [body.name for body in mesh.bodies]
        if self.on not in names:
            yield f"y = {self.y:g}: {self.on} does not reach there; move it"
            return
        number = names.index(self.on)
        try:
            run_up_line(mesh, number, kind, self.side)
        except ValueError as error:
            side = "" if self.side is None else f", side = {self.side!r}"
            yield f"on = {self.on!r}{side}: {error}"
            return
        if kind == "tank":
            middles = mesh.x0[on_side(mesh, number, self.side)].mean(axis=1)
            inward = (LIFT if self.side == "left" else -LIFT) * places.spacing
            places_there = np.array([self._lifted(tuple(x)) for x in middles + np.array([inward, 0.0])])
            if not places.in_front(places_there):
                yield (f"no fluid reaches the {self.side} side of {self.on}, which is behind another body; "
                       "give the name of that body with on=")

    def begin(self, scene: ProbeScene) -> Measure:
        """See Probe. Raises CaseError for a line that does not exist."""
        kind, now = scene.kinds.get(self.on), scene.plane(self.y)
        line = None if self.points is None else np.array(self.points, dtype=float)
        if now is None or kind is None:
            at = float((scene.lower if self.side == "left" else scene.upper)[0])
            return SideRunUp(at, self.y) if line is None else LineRunUp(self, scene, line)
        number = now.number(self.on)
        motion = now.motion_of(number)
        if kind == "tank" and line is None and now.upright(number):
            return SideRunUp(scene.sides_at(0.0)[self.side == "right"], self.y, motion)
        try:
            line = run_up_line(now.mesh, number, kind, self.side) if line is None else line
        except ValueError as error:
            raise CaseError(f"probe {self.name!r}: on = {self.on!r}, side = {self.side!r}: {error}") from None
        return LineRunUp(self, scene, line, motion)


class SideRunUp(Measure):
    """The surface at a vertical side of the tank, as of a SurfaceGauge there.

    at : x of the side at t = 0 [m]; y : place across a 3D scene [m]
    """

    def __init__(self, at: float, y: float | None = None, motion: Motion = AtRest()) -> None:
        self._start, self._across, self._motion = np.array([(at, 0.0)]), () if y is None else (y,), motion

    def _place(self, view: View) -> tuple[float, ...]:
        return float(self._motion.placed(self._start, view.time)[0, 0]), *self._across

    def rows(self, view: View) -> Floats:
        return surface_rows(view, self._place(view))

    def values(self, sums: Floats, rows: Floats, view: View) -> tuple[float, ...]:
        return surface(rows, view, self._place(view)), self._place(view)[0]


class LineRunUp(Measure):
    """The upper end of the water along a line that begins in it; the first point of a dry line.

    The water within TOUCH counts that is connected with the beginning: by particles not farther apart than COLUMN_GAP,
    or than in a film as thin as `film` of the probe. From its end, the straight line through two surface particles is
    continued to the wall, because the last particles of thin water are some distance below its tip. In 3D the water of
    one section is within COLUMN of it.
    """

    def __init__(self, probe: RunUp, scene: ProbeScene, points: Floats, motion: Motion = AtRest()) -> None:
        self.probe, self.scene, points = probe, scene, _corners(points)
        self.points, self._start, self._motion = points, points, motion
        s = scene.spacing
        self.gap = COLUMN_GAP * s if probe.film is None else max(COLUMN_GAP * s, s * s / probe.film)
        self.ends = reaches(points)

    def rows(self, view: View) -> Floats:
        s, self.points = self.scene.spacing, self._motion.placed(self._start, view.time)
        # particles of a torn film are spray, because they have too few neighbours
        along, away = self._onto(self._in_section(view.body if self.probe.film is None else view.places(view.fluid)))
        surface = self._in_section(view.places(view.fluid & (view.particles.role == SURFACE)))
        surface = surface[self._onto(surface)[1] <= BESIDE * s]
        heights = np.zeros((len(surface), WIDTH))
        heights[:, 0], heights[:, 1:3] = HEIGHT, surface
        return np.concatenate([heights, body_rows(bodies(along[away <= TOUCH * s], self.gap))])

    def _in_section(self, x: Floats) -> Floats:
        """Return the places (m, 2) [m] in the section of the points x (n, dim) near it."""
        y = self.probe.y
        return x if y is None else section_of(x[np.abs(x[:, 1] - y) <= COLUMN * self.scene.spacing * ROUNDING])

    def values(self, sums: Floats, rows: Floats, view: View) -> Floats | tuple[float, ...]:
        found = bodies_of_all(rows[rows[:, 0] == BODY], self.gap)
        if not len(found) or found[0, 0] > COLUMN_GAP * self.scene.spacing:
            return self.points[0, ::-1]
        end = found[0, 1]
        tip: Floats = places_along(self.points, self.ends, np.array([end]))[0]
        continued = self._continued(rows[rows[:, 0] == HEIGHT, 1:3], end)
        if continued is None or (self.probe.film is not None and self._onto(continued[None])[0][0] < end):
            return tip[::-1]    # a film includes spray ahead of the surface
        return continued[::-1]

    def _continued(self, surface: Floats, end: float) -> Floats | None:
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

    def _met(self, x: Floats, direction: Floats) -> Floats | None:
        """Return where the ray from x first meets the line, None if it does not within AHEAD in height."""
        ahead, within = meet(x, direction, self.points[:-1], np.diff(self.points, axis=0))
        met = ahead[(ahead >= 0.0) & (within >= 0.0) & (within <= 1.0)]
        if not len(met) or abs(met.min() * direction[1]) > AHEAD * self.scene.spacing:
            return None
        found: Floats = x + met.min() * direction
        return found

    def _onto(self, x: Floats) -> tuple[Floats, Floats]:
        """Return places along the line nearest to x (n, 2), and distances from it: (n,) each [m].

        Distances of more than BESIDE may be infinite.
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


def _corners(points: Floats) -> Floats:
    """Return the points (n, 2) of a line without those on the straight line between their neighbours."""
    a, b = np.diff(points, axis=0)[:-1], np.diff(points, axis=0)[1:]
    turns = np.abs(cross(a, b)) > STRAIGHT * np.hypot(*a.T) * np.hypot(*b.T)
    found: Floats = points[np.concatenate([[True], turns, [True]])]
    return found


def run_up_line(mesh: WallMesh, number: int, kind: str, side: str | None) -> Floats:
    """Return the nodes (n, 2) [m] at t = 0 of the line from the lowest place of a body's wall upwards.

    number, kind : of the body; side : of it, or the end of a profile to which the line goes

    Raises ValueError with fault and remedy.
    """
    own = mesh.elements[mesh.element_body == number]
    if not len(own):
        raise ValueError("no fluid touches it; give another wall")
    x = mesh.x0
    if kind == "tank":
        nodes = np.unique(on_side(mesh, number, side))
        path = nodes[np.argsort(x[nodes, 1])]
    elif kind in ("obstacle", "plate"):
        path = _flank(own, x, side == "left")
    else:
        path = np.append(own[:, 0], own[-1, 1])    # with the fluid on the left, from left to right
        if kind == "profile":
            path = path if side == "right" else path[::-1]
        else:
            path = path if x[path[-1], 1] > x[path[0], 1] else path[::-1]
        path = path[_lowest(x[path, 1])[-1]:]
    if len(path) < 2:
        raise ValueError(f"{mesh.bodies[number].name} is lowest at this end; choose the other one")
    found: Floats = x[path]
    return found


def _lowest(y: Floats) -> Ints:
    return np.flatnonzero(y <= y.min() + FLAT * np.ptp(y))


def _flank(elements: Ints, x: Floats, left: bool) -> Ints:
    """Return the nodes from the foot of a body, or its lowest node, along one flank to its highest, in order.

    Elements have the fluid on their left, so they lead up on the left of a body and down on its right.
    """
    ends = elements if left else elements[:, ::-1]
    step = dict(ends.tolist())
    nodes = np.unique(elements)
    feet = nodes[~np.isin(nodes, ends[:, 1])]
    feet = feet if len(feet) else nodes
    low = feet[_lowest(x[feet, 1])]
    path = [int(low[np.argmin(x[low, 0]) if left else np.argmax(x[low, 0])])]
    while path[-1] in step and step[path[-1]] != path[0]:
        path.append(step[path[-1]])
    y = x[path, 1]
    return np.array(path[: int(np.argmax(y >= y.max() - FLAT * np.ptp(y))) + 1])
