"""Moving walls and other walls: whether they collide, and how near they come (2D).

A wall that moves beside walls at rest is followed by its displacement or angle, between the extremes of the run. Two
moving walls are followed in time. A step is at most half of the distance between two bodies, so nothing is missed.
"""

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from parisph.base.arrays import Floats, Ints
from parisph.case.bodies import Plate, Profile
from parisph.case.motion import AtRest, Motion, Rotation, course, leaves_section
from parisph.geometry.columns import meet
from parisph.geometry.distance import across, nearest, unit_normals
from parisph.geometry.solid import Solid, Wall, solid_of

CONTACT = 0.25    # spacings: nearer walls touch; a wall this far behind another is inside it
MOST = 5000       # positions of two moving walls that are checked, at most
DIVIDED = 400     # most parts of a straight piece
FACING = -0.9     # cosine between the normals of walls that face each other
ROUNDING = 1e-9


@dataclass(frozen=True)
class Encounter:
    """Two bodies, by their numbers, and their least distance [m], 0 if they collide; where (2,) [m], when [s], and the
    displacement [m] or angle [rad] of the first."""

    one: int
    other: int
    distance: float
    at: Floats
    time: float
    value: float


@lru_cache(maxsize=4)
def encounters(walls: tuple[Wall, ...], spacing: float, stop: float, below: float) -> tuple[Encounter, ...]:
    """Return the collisions of walls with different motions, and approaches below `below` [m], up to a time [s].

    One for each pair of bodies: the first collision, else the least distance. Contact that exists at the start, like a
    piston that slides on its bed or a flap on its hinge, does not count.
    """
    found = []
    for one, wall in enumerate(walls):
        for other, beside in enumerate(walls):
            if wall.motion == beside.motion or isinstance(wall.motion, AtRest):
                continue
            if leaves_section(wall.motion) or leaves_section(beside.motion):    # see case.motion_checks
                continue
            if isinstance(beside.motion, AtRest) or one < other:
                pair = _Pair(wall, beside, spacing, stop)
                touch = distance_between(*pair.pose(0.0))[0] <= CONTACT * spacing
                distance, u, at = _together(pair) if touch else _apart(pair)
                if distance < below:
                    time = pair.when(u)
                    value = wall.motion.law(time)[0] if pair.timed else u
                    found.append(Encounter(one, other, distance, at, time, value))
    return tuple(found)


class _Pair:
    """Two bodies in relative motion, followed by the value of the law of the first, or by the time if both move.

    ends : the values up to which they are followed, from 0; speed : greatest relative displacement [m] per unit of the
    value; timed : whether the value is the time
    """

    def __init__(self, one: Wall, other: Wall, spacing: float, stop: float) -> None:
        self.walls, self.outlines, self.spacing = (one, other), (solid_of(one), solid_of(other)), spacing
        self.timed = not isinstance(other.motion, AtRest)
        arms = [_arm(wall.motion, outline) for wall, outline in zip(self.walls, self.outlines)]
        if self.timed:
            self.ends: tuple[float, ...] = (stop,)
            self.speed = 1.2 * sum(wall.motion.top_rate * arm for wall, arm in zip(self.walls, arms))
        else:
            self._course = course(one.motion, stop)
            self.ends, self.speed = (float(self._course[1].max()), float(self._course[1].min())), arms[0]

    def when(self, u: float) -> float:
        """Return the first time [s] of a value."""
        return u if self.timed else _first(*self._course, u)

    def placed(self, k: int, x: Floats, u: float) -> Floats:
        """Return the positions of points x (n, 2) [m] of body k at a value."""
        motion = self.walls[k].motion
        return motion.placed(x, u) if self.timed else x if k else motion.placed_by(x, u)

    def pose(self, u: float) -> tuple[Solid, Solid]:
        """Return the outlines at a value."""
        one, other = (replace(outline, points=self.placed(k, outline.points, u))
                      for k, outline in enumerate(self.outlines))
        return one, other


def _arm(motion: Motion, outline: Solid) -> float:
    """Return the greatest displacement of points per unit of the law: 1, or the arm [m] of a rotation."""
    if not isinstance(motion, Rotation):
        return 1.0
    return float(np.linalg.norm(outline.points - np.array(motion.centre), axis=1).max())


def _first(times: Floats, values: Floats, value: float) -> float:
    """Return the first time [s] at which a law reaches a value."""
    beyond = values >= value - ROUNDING if value > 0.0 else values <= value + ROUNDING
    k = int(np.argmax(beyond))
    if k == 0:
        return float(times[0])
    share = (value - values[k - 1]) / (values[k] - values[k - 1])
    return float(times[k - 1] + np.clip(share, 0.0, 1.0) * (times[k] - times[k - 1]))


def distance_between(a: Solid, b: Solid) -> tuple[float, Floats]:
    """Return the distance of two outlines [m], 0 if they cross, and the place (2,) [m]."""
    p, q = a.elements[:, 0], b.elements[:, 0]
    d, e = a.elements[:, 1] - p, b.elements[:, 1] - q
    t, u = meet(p[:, None], d[:, None], q, e)
    crossed = np.argwhere((t >= 0.0) & (t <= 1.0) & (u >= 0.0) & (u <= 1.0))
    if len(crossed):
        i, j = crossed[0]
        return 0.0, p[i] + t[i, j] * d[i]
    best: tuple[float, Floats] = (np.inf, np.full(2, np.nan))
    for points, outline in ((a.points, b), (b.points, a)):
        near, _, foot = nearest(points, outline.elements)
        k = int(np.argmin(near))
        if near[k] < best[0]:
            best = float(near[k]), foot[k]
    return best


def _apart(pair: _Pair) -> tuple[float, float, Floats]:
    """Return least distance, value and place of two bodies that are apart at the start.

    The distance is 0 if they collide: if they come nearer than CONTACT.
    """
    met: list[tuple[float, float, Floats]] = []
    close = CONTACT * pair.spacing
    for end in pair.ends:
        u, best = 0.0, (np.inf, 0.0, np.zeros(2))
        shortest = abs(end) / MOST if pair.timed else 0.0
        while True:
            distance, at = distance_between(*pair.pose(u))
            if distance < best[0]:
                best = distance, u, at
            if distance < close or u == end:
                break
            on = max(0.5 * distance / max(pair.speed, 1e-300), shortest)
            u = min(u + on, end) if end > 0.0 else max(u - on, end)
        met.append((0.0 if best[0] < close else best[0], best[1], best[2]))
    return min(met, key=lambda found: (found[0], pair.when(found[1])))


def _together(pair: _Pair) -> tuple[float, float, Floats]:
    """Return least distance, value and place of two bodies that touch at the start.

    They collide where a part of one enters the other that was outside at the start.
    """
    first, kept, found = pair.pose(0.0), [], []
    for k in _solid_against(pair):
        places, _ = _places(first[k].elements, pair.spacing)
        behind = first[1 - k].depth(places) > CONTACT * pair.spacing
        # a body inside the other at the start, like an obstacle through its bed, may move in it
        if k == 0 or not behind.any():
            kept.append((k, places[~behind]))
    for end in pair.ends:
        for u in np.linspace(0.0, end, 2 + min(int(2.0 * abs(end) * pair.speed / pair.spacing), DIVIDED)).tolist():
            pose = pair.pose(u)
            for k, places in kept:
                at = pair.placed(k, places, u)
                inside = pose[1 - k].depth(at) > CONTACT * pair.spacing
                if inside.any():
                    found.append((0.0, u, at[inside][0]))
    if found:
        return min(found, key=lambda met: pair.when(met[1]))
    return min((_squeezed(pair, u) for u in pair.ends), key=lambda met: met[0])


def _squeezed(pair: _Pair, u: float) -> tuple[float, float, Floats]:
    """Return the least distance [m] at a value, the value, and the place, of two bodies that slide along each other,
    where they face each other across fluid at the start."""
    close = CONTACT * pair.spacing
    before, _ = _facing(*pair.pose(0.0), pair.spacing)
    after, places = _facing(*pair.pose(u), pair.spacing)
    after = np.where(np.isfinite(before) & (before > close), after, np.inf)
    k = int(np.argmin(after))
    return (0.0 if after[k] < close else float(after[k])), u, places[k]


def _solid_against(pair: _Pair) -> list[int]:
    """Return the bodies that can enter the other one: a plate has no inside, and behind a face is its bed."""
    thin = [isinstance(wall, (Plate, Profile)) for wall in pair.walls]
    return [k for k in (0, 1) if not isinstance(pair.walls[1 - k], Plate) and (k == 0 or not thin[0])]


def _places(elements: Floats, spacing: float) -> tuple[Floats, Ints]:
    """Return the middles (n, 2) [m] of parts of elements (M, 2, 2) [m], of about a spacing, and their elements (n,)."""
    along = elements[:, 1] - elements[:, 0]
    # ROUNDING: the same number where it is turned
    many = (np.linalg.norm(along, axis=1) / spacing + ROUNDING).astype(np.int64).clip(1, DIVIDED)
    own: Ints = np.repeat(np.arange(len(many)), many)
    share = (np.arange(len(own)) - np.repeat(np.cumsum(many) - many, many) + 0.5) / many[own]
    places: Floats = elements[own, 0] + share[:, None] * along[own]
    return places, own


def _facing(a: Solid, b: Solid, spacing: float) -> tuple[Floats, Floats]:
    """Return distances (n,) [m] along normals from places (n, 2) [m] on a to b where it faces them, else inf;
    places."""
    places, own = _places(a.elements, spacing)
    return across(places, unit_normals(a.elements)[own], b.elements, FACING, -CONTACT * spacing)[0], places
