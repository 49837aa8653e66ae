"""Pitch, yaw and rotations about any axis, and several motions at once (3D)."""

from typing import TYPE_CHECKING, Annotated, Literal, Union

import numpy as np
from pydantic import AfterValidator, Field

from parisph.base.arrays import Floats
from parisph.case.model import Several
from parisph.case.motion.measured import Amount, Series
from parisph.case.motion.oscillations import Angular, Frequency, Heave, Moved, Period, Ramp, Roll, Sway, Tabulated
from parisph.case.motion.rigid import FINE, SHARE, Motion, Rotation, evenly, not_zero
from parisph.case.motion.spatial import ROLL, Pose, Spatial, arm, pose_of, turned_about
from parisph.case.motion.splines import Law

MOST = 100_000    # times that sample the range of several motions

Pivot = Annotated[tuple[float, float, float], Field(description="a point (x, y, z) of the axis [m]")]
Axis = Annotated[tuple[float, float, float], Field(description="axis (x, y, z) of the rotation, of any length"),
                 AfterValidator(not_zero)]


class _Turning(Angular, Spatial):
    """A rotation about `axis`, a field or property of each subclass, through `centre`."""

    amplitude: Amount = Field(description="amplitude [rad], or a Series")
    frequency: Frequency = None
    centre: Pivot = (0.0, 0.0, 0.0)
    ramp: Ramp = None
    period: Period = None

    if TYPE_CHECKING:    # see Translation
        @property
        def axis(self) -> tuple[float, ...]: ...

    @property
    def turns(self) -> bool:
        return True

    def pose(self, t: float) -> Pose:
        return turned_about(self.axis, self.centre, self.law(t))

    def _pose_by(self, value: float) -> Pose:
        return turned_about(self.axis, self.centre, (value, 0.0, 0.0))

    def top_speed(self, lower: Floats, upper: Floats) -> float:
        return self.top_rate * arm(self.axis, self.centre, lower, upper)


class Pitch(_Turning):
    """A pitch, about an axis along x through `centre` (x, y, z); angles are positive from y to z (3D).

    amplitude, frequency or period, ramp : as of a Roll, harmonic or measured

    >>> Pitch(amplitude=0.1, period=2.0, centre=(0.0, 0.5, 0.0)).placed([[0.0, 1.5, 0.0]], 2.5).round(3).tolist()
    [[0.0, 1.495, 0.1]]
    """

    kind: Literal["pitch"] = Field(default="pitch", init=False)

    @property
    def axis(self) -> tuple[float, ...]:
        """Along x."""
        return 1.0, 0.0, 0.0


class Yaw(_Turning):
    """A yaw, about an axis along z through `centre` (x, y, z); angles are positive from x to y (3D).

    amplitude, frequency or period, ramp : as of a Roll, harmonic or measured

    >>> Yaw(amplitude=0.1, period=2.0, centre=(0.5, 0.5, 0.0)).placed([[1.5, 0.5, 0.3]], 2.5).round(3).tolist()
    [[1.495, 0.6, 0.3]]
    """

    kind: Literal["yaw"] = Field(default="yaw", init=False)

    @property
    def axis(self) -> tuple[float, ...]:
        """Upwards."""
        return 0.0, 0.0, 1.0


class Turn(_Turning):
    """A rotation about an `axis` (x, y, z) through `centre`, right-handed about it (3D).

    amplitude, frequency or period, ramp : as of a Roll, harmonic or measured. Turn(axis=(0, -1, 0)) is a Roll.

    >>> turn = Turn(amplitude=0.1, period=2.0, axis=(1.0, 1.0, 0.0), centre=(0.5, 0.5, 0.0))
    >>> turn.spin_within(2.0).round(3).tolist()
    [0.222, 0.222, 0.0]
    """

    kind: Literal["turn"] = Field(default="turn", init=False)
    axis: Axis = Field(kw_only=True)


Part = Annotated[
    Union[Sway, Heave, Roll, Pitch, Yaw, Turn, Moved, Tabulated],
    Field(discriminator="kind", description="Sway, Heave, Roll, Pitch, Yaw, Turn, Moved or Tabulated"),
]


class Combined(Spatial):
    """Several motions at once, up to all six of a ship (3D).

    parts : Sway, Heave, Roll, Pitch, Yaw, Turn, Moved or Tabulated, harmonic or measured. The body moves by the first
    part, all of that by the second, and so on: later parts have axes and centres at rest, and move those of earlier
    ones. Give rotations first, and translations last: the centre of rotation then moves along.

    The value of its law is the time.

    >>> path = Series(times=(0.0, 1.0, 2.0, 3.0), values=(0.0, 0.1, 0.1, 0.0))
    >>> both = Combined([Yaw(path, centre=(0.5, 0.5, 0.0)), Moved(path, direction=(0.0, 1.0, 0.0))])
    >>> both.placed([[0.5, 0.5, 0.0]], 1.0).round(3).tolist()
    [[0.5, 0.6, 0.0]]
    """

    kind: Literal["combined"] = Field(default="combined", init=False)
    parts: Annotated[Several[Part], Field(min_length=1, description="motions, the innermost first")]

    def law(self, t: float) -> Law:
        """Return (t, 1, 0): the value of the law is the time."""
        return t, 1.0, 0.0

    @property
    def turns(self) -> bool:
        return any(part.turns for part in self.parts)

    def pose(self, t: float) -> Pose:
        found = pose_of(self.parts[0], t)
        for part in self.parts[1:]:
            found = pose_of(part, t).after(found)
        return found

    def _pose_by(self, value: float) -> Pose:
        return pose_of(self, value)

    @property
    def longest_step(self) -> float:
        return min(part.longest_step for part in self.parts)

    @property
    def top_rate(self) -> float:
        """See Motion: 1, as its value is the time."""
        return 1.0

    def instants(self, stop: float) -> Floats:
        """See Motion: up to `stop`, as periods may differ."""
        own = [part.instants(stop) for part in self.parts]
        period = max(self.longest_step / SHARE, FINE * stop / MOST)
        found: Floats = np.unique(np.concatenate([*own, evenly(period, stop), [stop]]))
        return found

    def top_speed(self, lower: Floats, upper: Floats) -> float:
        """See Motion: an upper bound, the sum of those of its parts.

        The arm of a part grows by the displacements of the parts before it.
        """
        found, reach = 0.0, 0.0
        low, high = np.asarray(lower, dtype=float), np.asarray(upper, dtype=float)
        for part in self.parts:
            found += part.top_speed(low - reach, high + reach)
            reach += _displacement(part, low - reach, high + reach)
        return found


def _displacement(part: Motion, lower: Floats, upper: Floats) -> float:
    """Return the greatest displacement [m] of points of a box by a part. lower, upper : (3,) [m]"""
    amount = getattr(part, "series", getattr(part, "amplitude", part))
    stop = amount.times[-1] if isinstance(amount, (Series, Tabulated)) else np.inf
    value = float(np.abs(part.values_at(part.instants(stop))).max())
    if isinstance(part, _Turning):
        return min(value, 2.0) * arm(part.axis, part.centre, lower, upper)
    if isinstance(part, Rotation):
        return min(value, 2.0) * arm(ROLL, (part.centre[0], 0.0, part.centre[1]), lower, upper)
    return value
