"""Motion of the tank. The flow is computed in the tank's frame; the driver adds -acceleration to gravity.

Motions are data, so that a stored run can go on without the script that made it.
"""

from functools import lru_cache
from typing import TYPE_CHECKING, Annotated, Literal, Union

import numpy as np
from pydantic import AfterValidator, Field, model_validator

from parisph.base.arrays import Floats
from parisph.base.text import shown
from parisph.case.model import Model
from parisph.case.values import SMALLEST

SHARE = 1 / 50    # of the period of a sway: the longest adaptive time step


def _not_zero(direction: tuple[float, ...]) -> tuple[float, ...]:
    if np.linalg.norm(direction) < SMALLEST:
        raise ValueError(f"{shown(direction)} must not be zero; give for example (1, 0)")
    return direction


Direction = Annotated[
    tuple[float, ...],
    Field(min_length=2, max_length=3, description="direction (x, y) of the motion"),
    AfterValidator(_not_zero),
]


class Motion(Model):
    """A translation of the tank along one `direction`, a field of every kind of motion."""

    if TYPE_CHECKING:    # each kind has these; as a field of this class the direction would come first
        direction: tuple[float, ...]

        def _series(self, t: float) -> tuple[float, float, float]:
            """Displacement [m], velocity [m/s] and acceleration [m/s2] along the direction at t [s]."""

    def _along(self, value: float) -> Floats:
        direction = np.array(self.direction)
        return direction / float(np.linalg.norm(direction)) * value

    def displacement(self, t: float) -> Floats:
        """Displacement (dim,) [m] at time t [s]."""
        return self._along(self._series(t)[0])

    def velocity(self, t: float) -> Floats:
        """Velocity (dim,) [m/s] at time t [s]."""
        return self._along(self._series(t)[1])

    def acceleration(self, t: float) -> Floats:
        """Acceleration (dim,) [m/s2] at time t [s]."""
        return self._along(self._series(t)[2])


    @property
    def longest_step(self) -> float:
        """Longest time step [s] that resolves the motion; infinite if the motion has no time scale."""
        return np.inf

    @property
    def top_speed(self) -> float:
        """Greatest speed of the tank [m/s]."""
        return 0.0


class AtRest(Motion):
    """A tank that does not move."""

    kind: Literal["at_rest"] = "at_rest"
    direction: Direction = (1.0, 0.0)

    def _series(self, t: float) -> tuple[float, float, float]:
        return 0.0, 0.0, 0.0


class Sway(Motion):
    """Harmonic sway from rest: X = amplitude (1 - cos(frequency t)) (Z14, Sec. 3.2).

    amplitude [m], frequency [rad/s].
    """

    kind: Literal["sway"] = "sway"
    amplitude: float = Field(description="amplitude a0 of X = a0 (1 - cos(frequency t)) [m]")
    frequency: float = Field(gt=0, description="angular frequency [rad/s]")
    direction: Direction = (1.0, 0.0)

    def _series(self, t: float) -> tuple[float, float, float]:
        a, w = self.amplitude, self.frequency
        return a * (1.0 - np.cos(w * t)), a * w * np.sin(w * t), a * w * w * np.cos(w * t)

    @property
    def longest_step(self) -> float:
        """See Motion: a share of the period; infinite where the amplitude is zero."""
        return SHARE * 2.0 * np.pi / self.frequency if self.amplitude else np.inf

    @property
    def top_speed(self) -> float:
        """See Motion."""
        return abs(self.amplitude) * self.frequency


class Tabulated(Motion):
    """A measured motion: displacement [m] at increasing times [s], joined by a cubic spline.

    The spline has no knot at the second and the last but one time; before the first and after the
    last time the tank rests. Its second derivative is the acceleration that the water feels, so
    rough data should be smoothed before.
    """

    kind: Literal["tabulated"] = "tabulated"
    times: Annotated[tuple[float, ...], Field(min_length=4, description="increasing times [s], at least four")]
    values: Annotated[tuple[float, ...], Field(min_length=4, description="displacements [m], one for each time")]
    direction: Direction = (1.0, 0.0)

    @model_validator(mode="after")
    def _series_is_sound(self) -> "Tabulated":
        if len(self.times) != len(self.values):
            raise ValueError(f"values: {len(self.values)} displacements for {len(self.times)} times; give one for each")
        late = np.flatnonzero(np.diff(self.times) < SMALLEST)
        if len(late):
            raise ValueError(f"times[{late[0] + 1}] = {self.times[late[0] + 1]}: "
                             f"must be later than the time before it, by {SMALLEST:g} s at least")
        return self

    @property
    def top_speed(self) -> float:
        """See Motion: that of the straight lines between the times."""
        return float(np.max(np.abs(np.diff(self.values) / np.diff(self.times))))

    def _series(self, t: float) -> tuple[float, float, float]:
        knots, y, m = _spline(self.times, self.values)
        if t < knots[0]:
            return y[0], 0.0, 0.0
        if t > knots[-1]:
            return y[-1], 0.0, 0.0
        k = min(int(np.searchsorted(knots, t, side="right")) - 1, len(knots) - 2)
        h = knots[k + 1] - knots[k]
        b = (t - knots[k]) / h
        a = 1.0 - b
        value = a * y[k] + b * y[k + 1] + ((a**3 - a) * m[k] + (b**3 - b) * m[k + 1]) * h * h / 6.0
        slope = (y[k + 1] - y[k]) / h + ((3 * b * b - 1) * m[k + 1] - (3 * a * a - 1) * m[k]) * h / 6.0
        return value, slope, a * m[k] + b * m[k + 1]


@lru_cache(maxsize=8)
def _spline(times: tuple[float, ...], values: tuple[float, ...]) -> tuple[Floats, Floats, Floats]:
    """Return knots, values and second derivatives (n,) of the spline; cached for each series."""
    t, y = np.array(times), np.array(values)
    return t, y, _spline_second_derivatives(t, y)


def _spline_second_derivatives(t: Floats, y: Floats) -> Floats:
    """Second derivatives (n,) at the knots of the not-a-knot cubic spline through (t, y), n >= 4."""
    h = np.diff(t)
    rhs = 6.0 * np.diff(np.diff(y) / h)
    diagonal = 2.0 * (h[:-1] + h[1:])
    lower, upper = h[:-1].copy(), h[1:].copy()
    # Not-a-knot: the third derivative is continuous at the second and the last but one knot. This
    # gives the outer unknowns as combinations of their two neighbours, put into the outer rows.
    diagonal[0] += h[0] * (h[0] + h[1]) / h[1]
    upper[0] -= h[0] ** 2 / h[1]
    diagonal[-1] += h[-1] * (h[-1] + h[-2]) / h[-2]
    lower[-1] -= h[-1] ** 2 / h[-2]
    inner = _solve_tridiagonal(lower, diagonal, upper, rhs)
    first = ((h[0] + h[1]) * inner[0] - h[0] * inner[1]) / h[1]
    last = ((h[-1] + h[-2]) * inner[-1] - h[-1] * inner[-2]) / h[-2]
    return np.concatenate([[first], inner, [last]])


def _solve_tridiagonal(lower: Floats, diagonal: Floats, upper: Floats, rhs: Floats) -> Floats:
    """Solve by elimination; lower[0] and upper[-1] are not used."""
    diagonal, rhs = diagonal.copy(), rhs.copy()
    for k in range(1, len(rhs)):
        factor = lower[k] / diagonal[k - 1]
        diagonal[k] -= factor * upper[k - 1]
        rhs[k] -= factor * rhs[k - 1]
    for k in range(len(rhs) - 1, -1, -1):
        if k + 1 < len(rhs):
            rhs[k] -= upper[k] * rhs[k + 1]
        rhs[k] /= diagonal[k]
    return rhs


Frame = Annotated[Union[AtRest, Sway, Tabulated], Field(discriminator="kind", description="AtRest, Sway or Tabulated")]
