"""Sway, heave and roll, harmonic or measured."""

from abc import abstractmethod
from functools import lru_cache
from typing import TYPE_CHECKING, Annotated, Any, Literal, cast

import numpy as np
from pydantic import Field, model_validator

from parisph.base.arrays import Floats
from parisph.case.model import Several
from parisph.case.motion.measured import Amount, Sampled, Series
from parisph.case.motion.rigid import FINE, SHARE, Centre, Direction, Motion, Rotation, Translation, evenly
from parisph.case.motion.splines import Law, product, rise

if TYPE_CHECKING:
    from typing_extensions import Self

Frequency = Annotated[float | None, Field(gt=0, description="angular frequency [rad/s], or period [s]")]
Period = Annotated[float | None, Field(gt=0, description="period [s], in place of frequency")]
Ramp = Annotated[float | None, Field(ge=0, description="time [s] in which the motion grows to its amplitude")]
SAME = 1e-9    # of a frequency: tolerance if frequency and period are given, as in some stored cases


@lru_cache(maxsize=64)
def _top_rate(motion: "_Oscillation") -> float:
    """Return the greatest rate of an oscillation with a ramp, in which it may occur."""
    ramp, period = cast(float, motion.ramp), 2.0 * np.pi / motion.omega
    times = np.concatenate([np.linspace(0.0, ramp, FINE), ramp + np.linspace(0.0, period, FINE)])
    return max(abs(motion.law(float(t))[1]) for t in times)


class AtRest(Translation):
    """A body that does not move.

    >>> AtRest().law(1.0)
    (0.0, 0.0, 0.0)
    """

    kind: Literal["at_rest"] = Field(default="at_rest", init=False)
    direction: Direction = (1.0, 0.0)

    def law(self, t: float) -> Law:
        return 0.0, 0.0, 0.0


class _Oscillation(Motion):
    """A harmonic motion that grows to its amplitude over a ramp."""

    if TYPE_CHECKING:    # see Translation
        @property
        def amplitude(self) -> Any: ...
        @property
        def frequency(self) -> float | None: ...
        @property
        def period(self) -> float | None: ...
        @property
        def ramp(self) -> float | None: ...

    def _check_frequency(self, missing: str) -> None:
        """Raise ValueError unless there is a frequency, a period, or both and equal. missing : message"""
        frequency, period = self.frequency, self.period
        if frequency is None and period is None:
            raise ValueError(missing)
        if frequency is not None and period is not None and abs(frequency * period / (2.0 * np.pi) - 1.0) > SAME:
            raise ValueError(f"frequency = {frequency:g} rad/s and period = {period:g} s: the period of this frequency "
                             f"is {2.0 * np.pi / frequency:g} s; give one of the two")

    @abstractmethod
    def _wave(self, t: float) -> Law:
        """Return the law at time t [s] without a ramp."""

    @property
    def _growth(self) -> float:
        """Time [s] in which the motion grows."""
        return self.ramp or 0.0

    @property
    def omega(self) -> float:
        """Angular frequency [rad/s]."""
        return 2.0 * np.pi / cast(float, self.period) if self.frequency is None else self.frequency

    def law(self, t: float) -> Law:
        return product(rise(t, self._growth), self._wave(t)) if self._growth else self._wave(t)

    @property
    def longest_step(self) -> float:
        """See Motion: a fraction of the period, infinite for a zero amplitude."""
        return SHARE * 2.0 * np.pi / self.omega if self.amplitude else np.inf

    @property
    def top_rate(self) -> float:
        """See Motion. A roll with the default ramp of one period is less than a tenth faster."""
        return _top_rate(self) if self.ramp else abs(self.amplitude) * self.omega

    def instants(self, stop: float) -> Floats:
        """See Motion: until one period after its growth."""
        return evenly(self.longest_step / SHARE, min(stop, self._growth + 2.0 * np.pi / self.omega))


class _Harmonic(_Oscillation, Translation):
    """X = amplitude (1 - cos(frequency t)) from rest, times a ramp if there is one."""

    @model_validator(mode="after")
    def _one_frequency(self) -> "Self":
        self._check_frequency(f"{type(self).__name__}.frequency is missing: give angular frequency [rad/s], or period "
                              "[s]")
        return self

    def _wave(self, t: float) -> Law:
        a, w = self.amplitude, self.omega
        return a * (1.0 - np.cos(w * t)), a * w * np.sin(w * t), a * w * w * np.cos(w * t)


class Sway(_Harmonic):
    """Harmonic sway from rest: X = amplitude (1 - cos(frequency t)) (Z14, Sec. 3.2).

    amplitude : [m]
    frequency : angular [rad/s], or `period` [s]
    direction : (x, y); in 3D (x, y, z), of which y runs across, such as (1, 1, 0) along a diagonal
    ramp : [s] in which it grows to its amplitude; default 0

    >>> print(f"{Sway(amplitude=0.03, frequency=2 * pi).law(0.5)[0]:.3f} m")    # after half a period
    0.060 m
    >>> print(f"{Sway(amplitude=0.03, period=1.0, ramp=3.0).law(3.5)[0]:.3f} m")
    0.060 m
    """

    kind: Literal["sway"] = Field(default="sway", init=False)
    amplitude: float = Field(description="amplitude a0 of X = a0 (1 - cos(frequency t)) [m]")
    frequency: Frequency = None
    direction: Direction = (1.0, 0.0)
    period: Period = None
    ramp: Ramp = None


class Heave(_Harmonic):
    """Harmonic heave from rest: Y = amplitude (1 - cos(frequency t)), upwards.

    amplitude, frequency or period, ramp : as of a Sway

    >>> print(f"{Heave(amplitude=0.03, period=1.0).law(0.5)[0]:.3f} m")
    0.060 m
    """

    kind: Literal["heave"] = Field(default="heave", init=False)
    amplitude: float = Field(description="amplitude a0 of Y = a0 (1 - cos(frequency t)) [m]")
    frequency: Frequency = None
    direction: Direction = (0.0, 1.0)
    period: Period = None
    ramp: Ramp = None


class Angular(_Oscillation):
    """An angle about an axis: harmonic, amplitude sin(frequency t), or a measured one."""

    @model_validator(mode="after")
    def _harmonic_or_measured(self) -> "Self":
        if isinstance(self.amplitude, Series):
            given = [name for name in ("period", "frequency", "ramp") if getattr(self, name) is not None]
            if given:
                raise ValueError(
                    f"{given[0]} = {getattr(self, given[0]):g}: is that of a harmonic {type(self).__name__.lower()}; "
                    "leave it out with a Series"
                )
        else:
            self._check_frequency("frequency is missing: give the angular frequency [rad/s], or period [s], or a "
                                  "Series as amplitude")
        return self

    def _wave(self, t: float) -> Law:
        a, w = cast(float, self.amplitude), self.omega
        return a * np.sin(w * t), a * w * np.cos(w * t), -a * w * w * np.sin(w * t)

    @property
    def _growth(self) -> float:
        return 2.0 * np.pi / self.omega if self.ramp is None else self.ramp

    def law(self, t: float) -> Law:
        return self.amplitude.law(t) if isinstance(self.amplitude, Series) else super().law(t)

    def values_at(self, times: Floats) -> Floats:
        return self.amplitude.values_at(times) if isinstance(self.amplitude, Series) else super().values_at(times)

    @property
    def longest_step(self) -> float:
        return np.inf if isinstance(self.amplitude, Series) else super().longest_step

    @property
    def top_rate(self) -> float:
        return self.amplitude.top_rate if isinstance(self.amplitude, Series) else super().top_rate

    def instants(self, stop: float) -> Floats:
        return self.amplitude.instants(stop) if isinstance(self.amplitude, Series) else super().instants(stop)


class Roll(Angular, Rotation):
    """A roll about `centre`: harmonic, amplitude sin(frequency t), or a measured one.

    amplitude : [rad], or a Series of angles [rad] or of their rate; its earlier name, angle, is accepted too
    frequency : angular [rad/s], or `period` [s], of a harmonic roll
    centre : (x, y) [m]; in 3D (x, z), as the section turns: about y, with angles positive from x to z
    ramp : [s] in which a harmonic roll grows to its amplitude; default one period, 0 for a sudden start

    >>> print(f"{Roll(amplitude=0.07, frequency=2 * pi, centre=(0.45, 0.0)).law(10.25)[0]:.3f} rad")
    0.070 rad
    >>> measured = Roll(Series(times=(0.0, 1.0, 2.0, 3.0), values=(0.0, 0.1, 0.1, 0.0)), centre=(0.45, 0.0))
    """

    kind: Literal["roll"] = Field(default="roll", init=False)
    amplitude: Amount = Field(description="amplitude [rad], or a Series")
    frequency: Frequency = None
    centre: Centre = (0.0, 0.0)
    ramp: Ramp = None
    period: Period = None

    @model_validator(mode="before")
    @classmethod
    def _amplitude_or_angle(cls, data: Any) -> Any:
        if isinstance(data, dict) and "angle" in data:
            if "amplitude" in data:
                raise ValueError("angle is the earlier name of amplitude; give one of the two")
            return {"amplitude" if name == "angle" else name: value for name, value in data.items()}
        return data

    @property
    def angle(self) -> Amount:
        """Its amplitude, under an earlier name."""
        return self.amplitude


class Moved(Translation):
    """A measured translation, series, along a direction, (x, y), in 3D (x, y, z) or (x, z).

    >>> path = Series(times=(0.0, 1.0, 2.0, 3.0), values=(0.0, 0.1, 0.1, 0.0))
    >>> print(f"{Moved(path, direction=(0.0, 1.0)).law(2.0)[0]:.3f} m")
    0.100 m
    """

    kind: Literal["moved"] = Field(default="moved", init=False)
    series: Series
    direction: Direction = (1.0, 0.0)

    def law(self, t: float) -> Law:
        return self.series.law(t)

    def values_at(self, times: Floats) -> Floats:
        return self.series.values_at(times)

    @property
    def top_rate(self) -> float:
        return self.series.top_rate

    def instants(self, stop: float) -> Floats:
        return self.series.instants(stop)


class Tabulated(Sampled, Translation):
    """A measured motion: displacement [m] at increasing times [s], joined as in a Series.

    With rate=True the values are velocities [m/s]; the motion is their integral, from rest at x = 0. For a column of a
    file use Moved(Series("paddle.csv", time="t", value="velocity", rate=True)).

    >>> print(f"{Tabulated(times=(0.0, 1.0, 2.0, 3.0), values=(0.0, 0.1, 0.1, 0.0)).law(1.0)[0]:.3f} m")
    0.100 m
    """

    kind: Literal["tabulated"] = Field(default="tabulated", init=False)
    times: Annotated[Several[float], Field(min_length=4, description="increasing times [s], at least four")]
    values: Annotated[Several[float], Field(min_length=4, description="a displacement [m] or velocity for each")]
    direction: Direction = (1.0, 0.0)
    rate: bool = Field(default=False, description="whether the values are velocities [m/s]")

    @model_validator(mode="after")
    def _series_is_sound(self) -> "Tabulated":
        self._check_increasing("velocities" if self.rate else "displacements")
        return self
