"""Walls that move against others: whether they reach them, and how near they come (2D).

A wall that moves beside walls at rest is followed by its displacement or angle, up to the least and the greatest of the
run: each place is looked at once, however often it is passed. Two that both move are followed in time. They are moved
on by no more than half of what is between them, so that nothing is missed.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from parisph.base.arrays import Floats
from parisph.case.bodies import Plate, Profile
from parisph.case.motion import AtRest, Motion, Rotation, course
from parisph.geometry.columns import meet
from parisph.geometry.distance import across, nearest
from parisph.geometry.mesh import unit_normals
from parisph.geometry.outline import Outline, Wall, outline_of

CONTACT = 0.25    # spacings: walls that are nearer touch; so far behind a wall another is in it
MOST = 5000       # places at which two walls that both move are looked at
DIVIDED = 400     # parts of a straight piece at most
FACING = -0.9     # cosine between the normals of walls that face each other
ROUNDING = 1e-9


@dataclass(frozen=True)
class Encounter:
    """Two bodies, and how near they come: numbers of walls, distance [m], 0 if they reach each other, where (2,) [m],
    when [s], and the displacement [m] or angle [rad] of the first."""

    one: int
    other: int
    distance: float
    at: Floats
    time: float
    value: float


@lru_cache(maxsize=4)
def encounters(walls: tuple[Wall, ...], spacing: float, stop: float, below: float) -> tuple[Encounter, ...]:
    """Return where walls that move against each other reach each other, or come nearer than `below` [m], up to a time.

    One for each pair of bodies, each of which is what comes first, or else the nearest. Walls that slide along each
    other, as a piston on its bed, or turn on each other, as a flap, do not count as near.
    """
    found = []
    for one, wall in enumerate(walls):
        for other, beside in enumerate(walls):
            if wall.motion == beside.motion or isinstance(wall.motion, AtRest):
                continue
            if isinstance(beside.motion, AtRest) or one < other:
                pair = _Pair.of(wall, beside, spacing, stop)
                met = _apart(pair) if pair.distance(0.0)[0] > CONTACT * spacing else _together(pair)
                if met is not None and met[0] < below:
                    distance, u, at = met
                    found.append(Encounter(one, other, distance, at, pair.when(u),
                                           wall.motion.law(pair.when(u))[0] if pair.timed else u))
    return tuple(found)


@dataclass(frozen=True)
class _Pair:
    """Two bodies that move against each other.

    pose : their outlines at a value of what they are followed by; ends : the values up to which, from 0; speed : how
    far their points move against each other per unit of it [m]; when : the time [s] of a value; timed : whether it is
    the time
    """

    pose: Callable[[float], tuple[Outline, Outline]]
    ends: tuple[float, ...]
    speed: float
    when: Callable[[float], float]
    timed: bool
    spacing: float
    walls: tuple[Wall, Wall]

    @classmethod
    def of(cls, one: Wall, other: Wall, spacing: float, stop: float) -> "_Pair":
        a, b = outline_of(one), outline_of(other)
        if isinstance(other.motion, AtRest):
            times, values = course(one.motion, stop)
            return cls(lambda u: (_moved(a, one.motion, u), b), (float(values.max()), float(values.min())),
                       _arm(one.motion, a), lambda u: _first(times, values, u), False, spacing, (one, other))
        speed = 1.2 * sum(wall.motion.top_rate * _arm(wall.motion, outline)
                          for wall, outline in ((one, a), (other, b)))
        return cls(lambda u: (_moved(a, one.motion, one.motion.law(u)[0]), _moved(b, other.motion,
                   other.motion.law(u)[0])), (stop,), speed, lambda u: u, True, spacing, (one, other))

    def distance(self, u: float) -> tuple[float, Floats]:
        """Return how far the bodies are apart [m], 0 if they cross, and where."""
        a, b = self.pose(u)
        return distance_between(a, b)

    def steps(self, length: float) -> Iterator[float]:
        """Yield values, in both directions from 0, between which points move by about a length [m]."""
        for end in self.ends:
            yield from np.linspace(0.0, end, 2 + min(int(abs(end) * self.speed / length), DIVIDED))


def _moved(outline: Outline, motion: Motion, value: float) -> Outline:
    return replace(outline, points=motion.placed_by(outline.points, value))


def _arm(motion: Motion, outline: Outline) -> float:
    """Return by how much points move for a unit of the law: 1, or the arm [m] of a rotation."""
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


def distance_between(a: Outline, b: Outline) -> tuple[float, Floats]:
    """Return the distance of two outlines [m], 0 where pieces cross, and the place (2,) [m]."""
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


def _apart(pair: _Pair) -> tuple[float, float, Floats] | None:
    """Return what two bodies that are apart at the start come to: distance, 0 if they reach each other, value, place.

    They reach each other where they come nearer than CONTACT.
    """
    met: list[tuple[float, float, Floats]] = []
    close = CONTACT * pair.spacing
    for end in pair.ends:
        u, best = 0.0, (np.inf, 0.0, np.zeros(2))
        shortest = abs(end) / MOST if pair.timed else 0.0
        while True:
            distance, at = pair.distance(u)
            if distance < best[0]:
                best = distance, u, at
            if distance < close or u == end:
                break
            on = max(0.5 * distance / max(pair.speed, 1e-300), shortest)
            u = min(u + on, end) if end > 0.0 else max(u - on, end)
        met.append((0.0 if best[0] < close else best[0], best[1], best[2]))
    return min(met, key=lambda found: (found[0], pair.when(found[1])))


def _together(pair: _Pair) -> tuple[float, float, Floats] | None:
    """Return what two bodies that touch at the start come to, as `_apart`, or None.

    They reach each other where one gets into the other that was not in it. What slides along another does not.
    """
    first = pair.pose(0.0)
    checks = [(k, _places(first[k].elements, pair.spacing)) for k in _solid_against(pair)]
    kept = [(k, places[~_behind(places, first[1 - k], pair.spacing)]) for k, places in checks]
    # a body that is in the other at the start, as an obstacle that goes through its bed, moves in it
    kept = [(k, places) for k, places in kept if k == 0 or len(places) == len(dict(checks)[k])]
    found = []
    for u in pair.steps(0.5 * pair.spacing):
        pose = pair.pose(u)
        for k, places in kept:
            at = places if k and not pair.timed else _carried(places, pair.walls[k].motion, u, pair.timed)
            inside = _behind(at, pose[1 - k], pair.spacing)
            if inside.any():
                found.append((0.0, u, at[inside][0]))
    if found:
        return min(found, key=lambda met: pair.when(met[1]))
    return min((_squeezed(pair, u) for u in pair.ends), key=lambda met: met[0])


def _squeezed(pair: _Pair, u: float) -> tuple[float, float, Floats]:
    """Return the least distance [m] at a value of two bodies that slide along each other, where they face each other
    across fluid at the start, the value, and the place."""
    close = CONTACT * pair.spacing
    before, _ = _facing(*pair.pose(0.0), pair.spacing)
    after, places = _facing(*pair.pose(u), pair.spacing)
    after = np.where(np.isfinite(before) & (before > close), after, np.inf)
    k = int(np.argmin(after))
    return (0.0 if after[k] < close else float(after[k])), u, places[k]


def _solid_against(pair: _Pair) -> list[int]:
    """Return which of the two bodies may get into the other: a plate has no inside, and behind a face is its bed."""
    thin = [isinstance(wall, (Plate, Profile)) for wall in pair.walls]
    return [k for k in (0, 1) if not isinstance(pair.walls[1 - k], Plate) and (k == 0 or not thin[0])]


def _carried(places: Floats, motion: Motion, u: float, timed: bool) -> Floats:
    return motion.placed(places, u) if timed else motion.placed_by(places, u)


def _places(elements: Floats, spacing: float) -> Floats:
    """Return the middles (n, 2) [m] of parts of elements (M, 2, 2) [m], of about a spacing."""
    found = []
    for a, b in elements:
        many = int(np.clip(np.linalg.norm(b - a) / spacing + ROUNDING, 1, DIVIDED))    # as many where it is turned
        found.append(a + ((np.arange(many) + 0.5) / many)[:, None] * (b - a))
    return np.concatenate(found)


def _behind(x: Floats, outline: Outline, spacing: float) -> np.ndarray:
    """Return which points (n, 2) [m] are behind an outline by more than CONTACT, (n,) bool."""
    behind = ~outline.in_front(x)
    if behind.any():
        far, _, _ = nearest(x[behind], outline.elements)
        behind[behind] = far > CONTACT * spacing
    return behind


def _facing(a: Outline, b: Outline, spacing: float) -> tuple[Floats, Floats]:
    """Return the distance (n,) [m] along the normals from places (n, 2) [m] of one outline to the other, where this
    faces it, inf elsewhere, and these places."""
    places = [_places(element[None], spacing) for element in a.elements]
    way = np.repeat(unit_normals(a.elements), [len(some) for some in places], axis=0)
    x = np.concatenate(places)
    return across(x, way, b.elements, FACING, -CONTACT * spacing)[0], x
