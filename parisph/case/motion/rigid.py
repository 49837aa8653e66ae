"""Motions of rigid bodies: positions, velocities and accelerations of their points.

A motion moves the tank, in whose frame the flow is computed, or a wall in the frame of the scene. Motions are data, so
a stored run can continue without its script. Angles are positive anticlockwise [rad].

In 3D a direction of two components (a, b) is one of the section, (a, 0, b), and a Rotation turns the section (x, z).
See spatial.py for other axes.
"""

from abc import abstractmethod
from functools import lru_cache
from typing import TYPE_CHECKING, Annotated

import numpy as np
from pydantic import AfterValidator, Field

from parisph.base.arrays import Floats
from parisph.base.text import shown
from parisph.case.model import Model
from parisph.case.values import SMALLEST

SHARE = 1 / 50    # of the period of a motion: the longest adaptive time step
FINE = 100        # samples in a period, for the range of a motion


def not_zero(direction: tuple[float, ...]) -> tuple[float, ...]:
    """Return a direction. Raises ValueError if it has no length."""
    if np.linalg.norm(direction) < SMALLEST:
        raise ValueError(f"{shown(direction)} must not be zero; give for example (1, 0{', 0' * (len(direction) - 2)})")
    return direction


Direction = Annotated[
    tuple[float, ...],
    Field(min_length=2, max_length=3, description="direction of the motion, (x, y), in 3D (x, y, z) or (x, z)"),
    AfterValidator(not_zero),
]
Centre = Annotated[
    tuple[float, ...], Field(min_length=2, max_length=2, description="centre (x, y) of the rotation, in 3D (x, z) [m]")
]


@lru_cache(maxsize=64)    # called several times in each step
def unit_vector(direction: tuple[float, ...], dim: int) -> Floats:
    """Return the read-only unit vector (dim,) of a nonzero direction."""
    unit: Floats = np.array(direction) / float(np.linalg.norm(direction))
    if len(unit) < dim:
        unit = np.insert(unit, 1, 0.0)
    unit.flags.writeable = False
    return unit


class Motion(Model):
    """The motion of a rigid body by a law of time: a displacement along a direction, or an angle about a centre."""

    if TYPE_CHECKING:    # a field of each subclass
        @property
        def kind(self) -> str: ...

    @abstractmethod
    def law(self, t: float) -> tuple[float, float, float]:
        """Return displacement [m] or angle [rad], its rate, and its second derivative at time t [s]."""

    def values_at(self, times: Floats) -> Floats:
        """Return the values (n,) of the law, [m] or [rad], at times (n,) [s]."""
        return np.array([self.law(float(t))[0] for t in times])

    @abstractmethod
    def placed_by(self, x: Floats, value: float) -> Floats:
        """Return the positions (n, dim) [m], at a value of the law, of points at x (n, dim) [m] in the body at rest."""

    def placed(self, x: Floats, t: float) -> Floats:
        """Return the positions (n, dim) [m] at time t [s] of points that are at x (n, dim) [m] in the body at rest."""
        return self.placed_by(x, self.law(t)[0])

    def taken_back(self, x: Floats, t: float) -> Floats:
        """Return the positions (n, dim) [m] in the body at rest of points that are at x (n, dim) [m] at time t [s]."""
        return self.placed_by(x, -self.law(t)[0])

    @abstractmethod
    def turned(self, vectors: Floats, t: float) -> Floats:
        """Return vectors (n, dim) of the body at rest, such as normals, turned to time t [s]."""

    @abstractmethod
    def velocity_at(self, x: Floats, t: float) -> Floats:
        """Return the velocity (n, dim) [m/s] of the points of the body that are at x (n, dim) [m] at time t [s]."""

    @abstractmethod
    def acceleration_at(self, x: Floats, t: float) -> Floats:
        """Return the acceleration (n, dim) [m/s2] of the body's points that are at x (n, dim) [m] at time t [s].

        x and the components are in the fixed frame.
        """

    def acceleration_within(self, x: Floats, t: float) -> Floats:
        """Return the acceleration (n, dim) [m/s2] of points of the body in its frame, where they are at x (n, dim) [m].

        It is minus the inertial force per mass of what rests in this frame. Of a translation or a rotation about a
        fixed axis it is the same function as `acceleration_at`.
        """
        return self.acceleration_at(x, t)

    @property
    def turns(self) -> bool:
        """Whether the body turns."""
        return False

    def spin_within(self, t: float) -> Floats:
        """Return the angular velocity (3,) [rad/s] at time t [s], in the frame of the body and in 3D."""
        return np.zeros(3)

    @abstractmethod
    def seen(self, vectors: Floats, t: float) -> Floats:
        """Return vectors (n, dim) of the fixed frame, such as gravity, in the frame of the body at time t [s].

        The result may be `vectors` itself.
        """

    @property
    def longest_step(self) -> float:
        """Longest time step [s] that resolves the motion; infinite if the motion has no time scale."""
        return np.inf

    @property
    def top_rate(self) -> float:
        """Greatest rate of the law, [m/s] or [rad/s]."""
        return 0.0

    def instants(self, stop: float) -> Floats:
        """Return times (n,) [s] in order, from 0 to at most `stop`, that sample the whole range of the motion."""
        return evenly(self.longest_step / SHARE, stop)

    @abstractmethod
    def top_speed(self, lower: Floats, upper: Floats) -> float:
        """Return the greatest speed [m/s] of points of a body in a box between two corners (dim,) [m]."""


class Translation(Motion):
    """A motion along one `direction`, a field of each subclass."""

    if TYPE_CHECKING:    # a field of each subclass; as a field of this class it would come first
        @property
        def direction(self) -> tuple[float, ...]: ...

    def _along(self, value: float, x: Floats) -> Floats:
        """Return the vector (dim,) of a length `value`. x : points (n, dim)"""
        return unit_vector(self.direction, np.shape(x)[-1]) * value

    def placed_by(self, x: Floats, value: float) -> Floats:
        return x + self._along(value, x)

    def turned(self, vectors: Floats, t: float) -> Floats:
        """See Motion: unchanged."""
        return vectors

    def velocity_at(self, x: Floats, t: float) -> Floats:
        return np.broadcast_to(self._along(self.law(t)[1], x), np.shape(x))

    def acceleration_at(self, x: Floats, t: float) -> Floats:
        return np.broadcast_to(self._along(self.law(t)[2], x), np.shape(x))

    def seen(self, vectors: Floats, t: float) -> Floats:
        return vectors

    def top_speed(self, lower: Floats, upper: Floats) -> float:
        return self.top_rate


class Rotation(Motion):
    """A rotation in the plane, in 3D that of the section, about a fixed `centre`, a field of each subclass."""

    if TYPE_CHECKING:    # see Translation
        @property
        def centre(self) -> tuple[float, ...]: ...

    @property
    def turns(self) -> bool:
        return True

    def spin_within(self, t: float) -> Floats:
        return np.array([0.0, -self.law(t)[1], 0.0])    # from x to z

    def placed_by(self, x: Floats, value: float) -> Floats:
        return self._on_axis(x) + rotated(self._from_axis(x), value)

    def _on_axis(self, x: Floats) -> Floats:
        """Return the centre (dim,) [m]. x : points (n, dim)"""
        return np.array(self.centre if np.shape(x)[-1] == 2 else (self.centre[0], 0.0, self.centre[1]))

    def _from_axis(self, x: Floats) -> Floats:
        """Return the vectors (n, dim) [m] from the centre, or from the axis in 3D, to points x (n, dim) [m]."""
        return np.asarray(x) - self._on_axis(x)

    def turned(self, vectors: Floats, t: float) -> Floats:
        return rotated(vectors, self.law(t)[0])

    def velocity_at(self, x: Floats, t: float) -> Floats:
        return self.law(t)[1] * quarter(self._from_axis(x))

    def acceleration_at(self, x: Floats, t: float) -> Floats:
        _, rate, second = self.law(t)
        arm = self._from_axis(x)
        if arm.shape[-1] == 3:
            arm[..., 1] = 0.0    # along the axis
        return second * quarter(arm) - rate**2 * arm

    def seen(self, vectors: Floats, t: float) -> Floats:
        return rotated(vectors, -self.law(t)[0])

    def top_speed(self, lower: Floats, upper: Floats) -> float:
        low, high = (np.asarray(corner)[[0, -1]] for corner in (lower, upper))
        arm = np.maximum(np.abs(low - self.centre), np.abs(high - self.centre))
        return self.top_rate * float(np.linalg.norm(arm))


def evenly(period: float, stop: float) -> Floats:
    """Return times [s] from 0 to `stop`, FINE in a period [s], which may be infinite."""
    if not np.isfinite(period):
        return np.array([0.0])
    times: Floats = np.append(np.arange(0.0, stop, period / FINE), stop)
    return times


@lru_cache(maxsize=64)
def course(motion: Motion, stop: float) -> tuple[Floats, Floats]:
    """Return times [s] up to `stop` and the values of the law, [m] or [rad], that sample its whole range."""
    times = motion.instants(stop)
    return times, motion.values_at(times)


def rotated(vectors: Floats, angle: float) -> Floats:
    """Return vectors (n, dim) turned anticlockwise by an angle [rad], in 3D from x to z."""
    cosine, sine = np.cos(angle), np.sin(angle)
    flat = np.asarray(vectors)
    if flat.shape[-1] == 3:
        turned: Floats = flat.copy()
        turned[..., [0, 2]] = flat[..., [0, 2]] @ np.array([[cosine, sine], [-sine, cosine]])
        return turned
    turned = flat @ np.array([[cosine, sine], [-sine, cosine]])
    return turned


def quarter(vectors: Floats) -> Floats:
    """Return vectors (n, dim) turned anticlockwise by a right angle, in 3D from x to z, without their parts along y."""
    vectors = np.asarray(vectors)
    if vectors.shape[1] == 3:
        return np.stack([-vectors[:, 2], np.zeros(len(vectors)), vectors[:, 0]], axis=1)
    return np.stack([-vectors[:, 1], vectors[:, 0]], axis=1)
