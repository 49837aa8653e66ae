"""Motions of rigid bodies in space: rotations about any axis, and several motions at once (3D).

Axes are right-handed, x along the section, y across it, z up. An angle is positive from y to z about x, and from x to y
about z. A Roll, as in 2D, is positive from x to z, which is about the axis (0, -1, 0).

The pose of a body takes a point x of the body at rest to R x + d. Its points at y have the velocity v + W x y and the
acceleration a + W' x y + W x (W x y), with the angular velocity W.
"""

from abc import abstractmethod
from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from parisph.base.arrays import Floats
from parisph.case.motion.rigid import Motion, Rotation, Translation, unit_vector
from parisph.case.motion.splines import Law

ROLL = (0.0, -1.0, 0.0)    # axis of a Roll, which turns x to z
AFTER, BEFORE = [1, 2, 0], [2, 0, 1]    # axes
ACROSS = 1e-9              # of a direction: a smaller part along y is rounding


class Pose(NamedTuple):
    """Place and motion of a rigid body at a time: see the module. turn : R (3, 3), all others (3,), SI units."""

    turn: Floats
    shift: Floats
    spin: Floats
    speed: Floats
    second: Floats        # W' [1/s2]
    acceleration: Floats

    def after(self, inner: "Pose") -> "Pose":
        """Return the pose of a body that moves by `inner` in a space that itself moves by this pose."""
        r, d, w = self.turn, self.shift, self.spin
        spin, second = r @ inner.spin, r @ inner.second
        within = r @ inner.speed - cross(spin, d)    # velocity at the origin within the moved space
        own = r @ inner.acceleration - cross(second, d) - cross(spin, cross(spin, d))
        return Pose(r @ inner.turn, r @ inner.shift + d, w + spin, self.speed + within,
                    self.second + second + cross(w, spin), self.acceleration + own + 2.0 * cross(w, within))


def cross(a: Floats, b: Floats) -> Floats:
    """Return the cross products of vectors (..., 3), many times faster than by numpy's function."""
    a, b = np.asarray(a), np.asarray(b)
    found: Floats = a[..., AFTER] * b[..., BEFORE] - a[..., BEFORE] * b[..., AFTER]
    return found


def turned_about(axis: Sequence[float], centre: Sequence[float], law: Law) -> Pose:
    """Return the pose of a rotation. axis : (3,), of any length; centre : (3,) [m]; law : [rad, rad/s, rad/s2]"""
    angle, rate, second = law
    unit, c = unit_vector(tuple(axis), 3), np.asarray(centre, dtype=float)
    turn, w, change = rotation(unit, angle), rate * unit, second * unit
    return Pose(turn, c - turn @ c, w, -cross(w, c), change, -cross(change, c) - cross(w, cross(w, c)))


def rotation(unit: Floats, angle: float) -> Floats:
    """Return the matrix (3, 3) of the rotation about a unit vector (3,) by an angle [rad] (Rodrigues)."""
    cosine, sine = np.cos(angle), np.sin(angle)
    found: Floats = cosine * np.eye(3) + sine * cross_matrix(unit) + (1.0 - cosine) * np.outer(unit, unit)
    return found


def cross_matrix(w: Floats) -> Floats:
    """Return the matrix (3, 3) of x -> w x x."""
    return cross(w, np.eye(3)).T


@lru_cache(maxsize=64)    # called several times in each step
def pose_of(motion: Motion, t: float) -> Pose:
    """Return the pose of any motion in space at time t [s]."""
    if isinstance(motion, Spatial):
        return motion.pose(t)
    if isinstance(motion, Rotation):
        return turned_about(ROLL, (motion.centre[0], 0.0, motion.centre[1]), motion.law(t))
    assert isinstance(motion, Translation)
    unit, none = unit_vector(motion.direction, 3), np.zeros(3)
    shift, speed, acceleration = (value * unit for value in motion.law(t))
    return Pose(np.eye(3), shift, none, speed, none, acceleration)


class Spatial(Motion):
    """A motion that is known by its pose. All points and vectors are (n, 3)."""

    @abstractmethod
    def pose(self, t: float) -> Pose:
        """Return the pose at time t [s]."""

    def placed_by(self, x: Floats, value: float) -> Floats:
        return _placed(self._pose_by(value), x)

    @abstractmethod
    def _pose_by(self, value: float) -> Pose:
        """Return the pose at a value of the law, with any velocity."""

    def placed(self, x: Floats, t: float) -> Floats:
        return _placed(pose_of(self, t), x)

    def taken_back(self, x: Floats, t: float) -> Floats:
        pose = pose_of(self, t)
        found: Floats = (np.asarray(x) - pose.shift) @ pose.turn
        return found

    def turned(self, vectors: Floats, t: float) -> Floats:
        found: Floats = np.asarray(vectors) @ pose_of(self, t).turn.T
        return found

    def seen(self, vectors: Floats, t: float) -> Floats:
        found: Floats = np.asarray(vectors) @ pose_of(self, t).turn
        return found

    def velocity_at(self, x: Floats, t: float) -> Floats:
        pose = pose_of(self, t)
        found: Floats = pose.speed + cross(pose.spin, x)
        return found

    def acceleration_at(self, x: Floats, t: float) -> Floats:
        pose = pose_of(self, t)
        found: Floats = pose.acceleration + cross(pose.second, x) + cross(pose.spin, cross(pose.spin, x))
        return found

    def acceleration_within(self, x: Floats, t: float) -> Floats:
        return self.seen(self.acceleration_at(self.placed(x, t), t), t)

    def spin_within(self, t: float) -> Floats:
        return self.seen(pose_of(self, t).spin, t)


def _placed(pose: Pose, x: Floats) -> Floats:
    found: Floats = np.asarray(x) @ pose.turn.T + pose.shift
    return found


def corners(lower: Floats, upper: Floats) -> Floats:
    """Return the corners (8, 3) of a box between two corners (3,)."""
    grid = np.meshgrid(*np.stack([lower, upper], axis=1), indexing="ij")
    found: Floats = np.stack(grid, axis=-1).reshape(-1, 3)
    return found


def arm(axis: Sequence[float], centre: Sequence[float], lower: Floats, upper: Floats) -> float:
    """Return the greatest distance [m] of points of a box (see `corners`) from an axis through a centre (3,) [m]."""
    away = cross(corners(lower, upper) - np.asarray(centre), unit_vector(tuple(axis), 3))
    return float(np.linalg.norm(away, axis=1).max())


def leaves_section(motion: Motion) -> bool:
    """Return whether a motion in 3D takes a body out of its planes across, so that its sections change."""
    if isinstance(motion, Translation):
        way = unit_vector(motion.direction, 3)
        return bool(abs(way[1]) > ACROSS)
    return isinstance(motion, Spatial)
