"""Motions that tanks make: sway, heave and roll, harmonic or measured."""

from typing import TYPE_CHECKING, Annotated, Literal, Optional, cast

import numpy as np
from pydantic import Field, model_validator

from parisph.base.arrays import Floats
from parisph.case.motion.measured import (
    Amount,
    Series,
    between_knots,
    check_increasing,
    hash_of,
    law_of,
    top_rate_of,
    values_of,
)
from parisph.case.motion.rigid import SHARE, Centre, Direction, Rotation, Translation, evenly
from parisph.case.motion.splines import product, rise

Frequency = Annotated[Optional[float], Field(gt=0, description="angular frequency [rad/s]")]


class AtRest(Translation):
    """A body that does not move.

    Examples
    --------
    >>> AtRest().law(1.0)
    (0.0, 0.0, 0.0)
    """

    kind: Literal["at_rest"] = "at_rest"
    direction: Direction = (1.0, 0.0)

    def law(self, t: float) -> tuple[float, float, float]:
        """See Motion."""
        return 0.0, 0.0, 0.0


class _Harmonic(Translation):
    """X = amplitude (1 - cos(frequency t)), from rest."""

    if TYPE_CHECKING:    # see Translation
        amplitude: float
        frequency: float

    def law(self, t: float) -> tuple[float, float, float]:
        """See Motion."""
        a, w = self.amplitude, self.frequency
        return a * (1.0 - np.cos(w * t)), a * w * np.sin(w * t), a * w * w * np.cos(w * t)

    @property
    def longest_step(self) -> float:
        """See Motion: a share of the period; infinite where the amplitude is zero."""
        return SHARE * 2.0 * np.pi / self.frequency if self.amplitude else np.inf

    @property
    def top_rate(self) -> float:
        """See Motion."""
        return abs(self.amplitude) * self.frequency


    def instants(self, stop: float) -> Floats:
        """See Motion: one period shows all."""
        return evenly(self.longest_step / SHARE, min(stop, 2.0 * np.pi / self.frequency))


class Sway(_Harmonic):
    """Harmonic sway from rest: X = amplitude (1 - cos(frequency t)) (Z14, Sec. 3.2).

    amplitude [m], frequency [rad/s].

    Examples
    --------
    >>> print(f"{Sway(amplitude=0.03, frequency=2 * pi).law(0.5)[0]:.3f} m")    # after half a period
    0.060 m
    """

    kind: Literal["sway"] = "sway"
    amplitude: float = Field(description="amplitude a0 of X = a0 (1 - cos(frequency t)) [m]")
    frequency: float = Field(gt=0, description="angular frequency [rad/s]")
    direction: Direction = (1.0, 0.0)


class Heave(_Harmonic):
    """Harmonic heave from rest: Y = amplitude (1 - cos(frequency t)), upwards.

    amplitude [m], frequency [rad/s].

    Examples
    --------
    >>> print(f"{Heave(amplitude=0.03, frequency=2 * pi).law(0.5)[0]:.3f} m")
    0.060 m
    """

    kind: Literal["heave"] = "heave"
    amplitude: float = Field(description="amplitude a0 of Y = a0 (1 - cos(frequency t)) [m]")
    frequency: float = Field(gt=0, description="angular frequency [rad/s]")
    direction: Direction = (0.0, 1.0)


class Roll(Rotation):
    """A roll about `centre`: harmonic, angle sin(frequency t), or a measured one.

    angle : amplitude [rad], or a Series of angles [rad] or of their rate
    frequency : [rad/s], of a harmonic roll
    centre : (x, y) [m]
    ramp : [s] in which a harmonic roll grows to its amplitude; default one period. With 0 the body turns from the start

    Examples
    --------
    >>> print(f"{Roll(angle=0.07, frequency=2 * pi, centre=(0.45, 0.0)).law(10.25)[0]:.3f} rad")
    0.070 rad
    >>> measured = Roll(Series(times=(0.0, 1.0, 2.0, 3.0), values=(0.0, 0.1, 0.1, 0.0)), centre=(0.45, 0.0))
    """

    kind: Literal["roll"] = "roll"
    angle: Amount = Field(description="amplitude [rad], or a Series")
    frequency: Frequency = None
    centre: Centre = (0.0, 0.0)
    ramp: Optional[float] = Field(None, ge=0, description="time [s] in which a harmonic roll grows")

    @model_validator(mode="after")
    def _harmonic_or_measured(self) -> "Roll":
        if isinstance(self.angle, Series):
            given = [name for name in ("frequency", "ramp") if getattr(self, name) is not None]
            if given:
                raise ValueError(
                    f"{given[0]} = {getattr(self, given[0]):g}: is that of a harmonic roll; leave it out with a Series"
                )
        elif self.frequency is None:
            raise ValueError(
                "frequency is missing: give the angular frequency [rad/s], or a Series in place of the angle"
            )
        return self

    def law(self, t: float) -> tuple[float, float, float]:
        """See Motion."""
        if isinstance(self.angle, Series):
            return self.angle.law(t)
        a, w = self.angle, self._omega
        wave = a * np.sin(w * t), a * w * np.cos(w * t), -a * w * w * np.sin(w * t)
        return product(rise(t, 2.0 * np.pi / w if self.ramp is None else self.ramp), wave)

    def values_at(self, times: Floats) -> Floats:
        """See Motion."""
        return self.angle.at(times) if isinstance(self.angle, Series) else super().values_at(times)

    @property
    def longest_step(self) -> float:
        """See Motion."""
        return np.inf if isinstance(self.angle, Series) or not self.angle else SHARE * 2.0 * np.pi / self._omega

    @property
    def top_rate(self) -> float:
        """See Motion; while it grows, a roll is less than a tenth faster."""
        return self.angle.top_rate if isinstance(self.angle, Series) else abs(self.angle) * self._omega

    def instants(self, stop: float) -> Floats:
        """See Motion: one period after its growth shows all."""
        if isinstance(self.angle, Series):
            return self.angle.knots(stop)
        period = 2.0 * np.pi / self._omega
        return evenly(self.longest_step / SHARE, min(stop, (period if self.ramp is None else self.ramp) + period))

    @property
    def _omega(self) -> float:
        return cast(float, self.frequency)    # _harmonic_or_measured has seen that a harmonic roll has it


class Moved(Translation):
    """A measured translation, series, along a direction.

    Examples
    --------
    >>> path = Series(times=(0.0, 1.0, 2.0, 3.0), values=(0.0, 0.1, 0.1, 0.0))
    >>> print(f"{Moved(path, direction=(0.0, 1.0)).law(2.0)[0]:.3f} m")
    0.100 m
    """

    kind: Literal["moved"] = "moved"
    series: Series
    direction: Direction = (1.0, 0.0)

    def law(self, t: float) -> tuple[float, float, float]:
        """See Motion."""
        return self.series.law(t)

    def values_at(self, times: Floats) -> Floats:
        """See Motion."""
        return self.series.at(times)

    @property
    def top_rate(self) -> float:
        """See Motion."""
        return self.series.top_rate

    def instants(self, stop: float) -> Floats:
        """See Motion."""
        return self.series.knots(stop)


class Tabulated(Translation):
    """A measured motion: displacement [m] at increasing times [s], joined as a Series of numbers is.

    With rate=True the values are velocities [m/s]; the motion is their integral, from rest at x = 0. A column of a file
    is read by a Moved: Moved(Series("paddle.csv", time="t", value="velocity", rate=True)).

    Examples
    --------
    >>> print(f"{Tabulated(times=(0.0, 1.0, 2.0, 3.0), values=(0.0, 0.1, 0.1, 0.0)).law(1.0)[0]:.3f} m")
    0.100 m
    """

    kind: Literal["tabulated"] = "tabulated"
    times: Annotated[tuple[float, ...], Field(min_length=4, description="increasing times [s], at least four")]
    values: Annotated[tuple[float, ...], Field(min_length=4, description="a displacement [m] or velocity for each")]
    direction: Direction = (1.0, 0.0)
    rate: bool = Field(False, description="whether the values are velocities [m/s]")

    @model_validator(mode="after")
    def _series_is_sound(self) -> "Tabulated":
        check_increasing(self.times, self.values, "velocities" if self.rate else "displacements")
        return self

    @property
    def top_rate(self) -> float:
        """See Motion: that of the straight lines between the times."""
        return top_rate_of(self.times, self.values, self.rate)

    def law(self, t: float) -> tuple[float, float, float]:
        """See Motion."""
        return law_of(self.times, self.values, self.rate, t)

    def values_at(self, times: Floats) -> Floats:
        """See Motion."""
        return values_of(self.times, self.values, self.rate, times)

    def __hash__(self) -> int:
        return hash_of(self.times, self.values)

    def instants(self, stop: float) -> Floats:
        """See Motion."""
        return between_knots(self.times, stop)
