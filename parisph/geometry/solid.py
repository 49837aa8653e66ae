"""Each body of a scene as a solid: its elements, with the fluid on their left, and its inside (2D)."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from parisph.base.arrays import Flags, Floats
from parisph.case.bodies import Obstacle, Plate, Profile
from parisph.case.ellipsoid import AnyShape, Ellipse, Ellipsoid
from parisph.case.shapes import Box, Disc, Tank
from parisph.geometry.columns import cross, meet
from parisph.geometry.distance import nearest

FACETS = 256    # straight pieces around a disc; they turn by less than a corner of a mesh

Wall = Tank | Profile | Obstacle | Plate


@dataclass(frozen=True)
class Solid:
    """One body, by its outline.

    points : (n, 2) [m], in order, with fluid on the left
    closed : whether the last point is joined to the first; an open outline continues beyond its ends, see `ways`
    two_sided : whether fluid is on both sides, as of a plate; its points then go there and back, and it has no inside
    beyond : "straight", "up" or "down": how an open outline continues
    """

    points: Floats
    closed: bool
    two_sided: bool = False
    beyond: str = "straight"

    @property
    def ways(self) -> tuple[Floats, Floats]:
        """Directions (2,) in which an open outline continues beyond its first and its last point."""
        return _ways(self.points, self.beyond)

    @property
    def elements(self) -> Floats:
        """The first and the last point of each straight piece, (pieces, 2, 2) [m]."""
        pairs = np.stack([self.points, np.roll(self.points, -1, axis=0)], axis=1)
        found: Floats = pairs if self.closed else pairs[:-1]
        return found

    def in_front(self, x: Floats) -> Flags:
        """Return which of the points x (n, 2) [m] lie on the fluid's side of this body, (n,) bool.

        The sum of the angles of the pieces seen from x differs by a full turn between the two sides.
        """
        front = np.full(len(x), self.two_sided or signed_area(self.points) < 0.0)
        if self.two_sided:
            return front
        near = np.ones(len(x), dtype=bool)
        if self.closed:    # only points in its bounding box can be inside
            near = ((x >= self.points.min(axis=0)) & (x <= self.points.max(axis=0))).all(axis=1)
        at = x[near]
        turn, whole = np.zeros(len(at)), 0.0 if front.all() else 2.0 * np.pi
        for a, b in self.elements if len(at) else ():
            turn += _angle(a - at, b - at)
        if not self.closed:
            first, last = self.ways
            turn += _angle(first[None], self.points[0] - at) + _angle(self.points[-1] - at, last[None])
            whole = _angle(first[None], last[None])[0] % (2.0 * np.pi)
            whole = whole if whole > 1e-9 else 2.0 * np.pi
        front[near] = turn > whole - np.pi
        return front

    def depth(self, x: Floats) -> Floats:
        """Return the depth (n,) [m] of points x (n, 2) [m] behind the elements, 0 in front of them."""
        behind = ~self.in_front(x)
        far = np.zeros(len(x))
        if behind.any():
            far[behind] = nearest(x[behind], self.elements)[0]
        return far


@lru_cache(maxsize=64)
def solid_of(body: Wall) -> Solid:
    """Return the Solid of a Tank, Profile, Obstacle or Plate. Cached: callers must not change it. Raises TypeError."""
    if isinstance(body, Tank):
        lower, upper = body.bounds
        left, right = (lower[0], upper[1]), (upper[0], upper[1])
        return Solid(np.array([left, tuple(lower), (upper[0], lower[1]), right]), body.closed)
    if isinstance(body, Profile):
        points = np.array(body.points, dtype=float)
        points = points if body.fluid_on_left else points[::-1].copy()
        return Solid(points, False, beyond=way_beyond(points) or "straight")
    if isinstance(body, Obstacle):
        return outline_of(body.shape)
    if isinstance(body, Plate):
        points = np.array(body.points, dtype=float)
        return Solid(np.concatenate([points, points[-2:0:-1]]), True, True)
    raise TypeError(f"{type(body).__name__} has no outline")


def outline_of(shape: AnyShape) -> Solid:
    """Return a shape as a Solid; unlike an Obstacle, it may touch itself, as fluid may."""
    points = corners_of(shape)
    return Solid(points[::-1].copy() if signed_area(points) > 0.0 else points, True)


def way_beyond(points: Floats) -> str | None:
    """Return how a line through points (n, 2) [m] can continue without crossing itself: "straight" if possible,
    else "up" (a bowl with overhanging ends), else "down", else None."""
    return next((how for how in ("straight", "up", "down") if not _meets_itself(points, *_ways(points, how))), None)


def _ways(points: Floats, beyond: str) -> tuple[Floats, Floats]:
    if beyond == "straight":
        return points[0] - points[1], points[-1] - points[-2]
    way = np.array([0.0, 1.0 if beyond == "up" else -1.0])
    return way, way


def _meets_itself(points: Floats, first: Floats, last: Floats) -> bool:
    """Return whether rays in these directions, from the ends of a line through points, meet the line or each other."""
    a, b = points[:-1], points[1:]
    way = b - a
    return (_ray_meets(points[0], first, a[1:], way[1:], 1.0) or _ray_meets(points[-1], last, a[:-1], way[:-1], 1.0)
            or _ray_meets(points[0], first, points[-1:], last[None], np.inf))


def _ray_meets(start: Floats, way: Floats, at: Floats, along: Floats, most: float) -> bool:
    """Return whether start + t way, t > 0, meets one of the pieces at + u along (n, 2), 0 <= u <= most."""
    t, u = meet(start, way, at, along)
    parallel = np.abs(cross(way, along)) <= 1e-12 * np.linalg.norm(way) * np.linalg.norm(along, axis=1)
    return bool(np.any(~parallel & (t > 0.0) & (u >= 0.0) & (u <= most)))


def corners_of(shape: AnyShape) -> Floats:
    """Return the corners (n, 2) [m] of a shape; a Disc or an Ellipse has FACETS corners and keeps its area."""
    if isinstance(shape, Box):
        (left, low), (right, high) = shape.bounds
        return np.array([(left, low), (right, low), (right, high), (left, high)])
    if isinstance(shape, (Disc, Ellipse)):
        angle = 2.0 * np.pi * np.arange(FACETS) / FACETS
        radius = np.array(shape.axes if isinstance(shape, Ellipse) else (shape.radius, shape.radius))
        radius *= np.sqrt(2.0 * np.pi / (FACETS * np.sin(2.0 * np.pi / FACETS)))
        found: Floats = np.array(shape.at) + radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        return found
    assert not isinstance(shape, Ellipsoid), "its sections are Ellipses"
    return np.array(shape.points, dtype=float)


def signed_area(points: Floats) -> float:
    """Return the area [m2] of the polygon through points (n, 2) [m], negative if they are in clockwise order."""
    x, y = (points - points[0]).T
    return 0.5 * float(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1)))


def in_fluid(walls: Sequence[Wall], x: Floats) -> Flags:
    """Return which points x (n, 2) [m] lie in front of all walls, (n,) bool. The cost is points times elements."""
    inside = np.ones(len(x), dtype=bool)
    for wall in walls:
        inside[inside] = solid_of(wall).in_front(x[inside])
    return inside


def _angle(a: Floats, b: Floats) -> Floats:
    """Return the angle from a to b (n, 2), anticlockwise, in [-pi, pi]."""
    return np.arctan2(cross(a, b), a[:, 0] * b[:, 0] + a[:, 1] * b[:, 1])
