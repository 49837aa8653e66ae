"""Linear waves, travelling and standing, as records."""

from typing import Annotated, Literal

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field, model_validator

from parisph.base.arrays import Floats
from parisph.case.waves.linear import angular_frequency, wave_number
from parisph.case.waves.wavefield import (
    Depth,
    Gravity,
    Height,
    Leftward,
    Period,
    Place,
    Travelling,
    WaveField,
    no_higher,
    steepest,
)


def transfer(k: float, y: Floats, depth: float) -> tuple[Floats, Floats]:
    """Return cosh(k y)/sinh(k depth) and sinh(k y)/sinh(k depth) without overflow in deep water."""
    up, down = np.exp(k * (y - depth)), np.exp(-k * (y + depth))
    scale = -1.0 / np.expm1(-2.0 * k * depth)
    return scale * (up + down), scale * (up - down)


class Airy(Travelling):
    """A regular wave of linear theory: eta = (height/2) cos(k (x - at) - omega t).

    height [m], period [s], depth [m]. Velocities are extrapolated above the still surface. Errors are of the order of
    steepness.

    >>> wave = Airy(height=0.05, period=1.2, depth=0.5)
    >>> print(f"{wave.length:.2f} m, {wave.elevation(0.0, 0.6):+.3f} m")    # half a period after the crest
    2.05 m, -0.025 m
    """

    kind: Literal["airy"] = Field(default="airy", init=False)
    height: Height
    period: Period
    depth: Depth
    at: Place = 0.0
    leftward: Leftward = False
    g: Gravity = 9.81

    @model_validator(mode="after")
    def _does_not_break(self) -> "Airy":
        no_higher(
            self.height,
            steepest(self.depth, self.length),
            "that of the highest steady wave",
            "use a lower or a longer one",
        )
        return self

    @property
    def k(self) -> float:
        """Wave number [1/m]."""
        return float(wave_number(2.0 * np.pi / self.period, self.depth, self.g))

    @property
    def length(self) -> float:
        """Length of the wave [m]."""
        return 2.0 * np.pi / self.k

    @property
    def celerity(self) -> float:
        """Speed of the crests [m/s]."""
        return self.length / self.period

    def _profile(self, ahead: Floats) -> Floats:
        eta: Floats = 0.5 * self.height * np.cos(self.k * ahead)
        return eta

    def _flow(self, ahead: Floats, y: Floats) -> tuple[Floats, Floats]:
        cosh, sinh = transfer(self.k, y, self.depth)
        scale = np.pi * self.height / self.period
        return scale * cosh * np.cos(self.k * ahead), scale * sinh * np.sin(self.k * ahead)


class StandingWave(WaveField):
    """A linear standing wave: eta = amplitude cos(k (x - at)) sin(omega t + phase), k = 2 pi/length (Z17 Eqs 36-38).

    amplitude, length, depth [m]; an antinode is `at` [m]. With phase = 0 the surface is flat at the start, with phase =
    pi/2 the water is at rest. High waves should start flat: a linear elevation makes free waves.

    >>> wave = StandingWave(amplitude=0.02, length=2.0, depth=1.0, phase=pi / 2)
    >>> print(f"{wave.elevation(0.0, 0.0):.3f} m, {wave.omega:.2f} rad/s")
    0.020 m, 5.54 rad/s
    """

    kind: Literal["standing"] = Field(default="standing", init=False)
    amplitude: Annotated[float, Field(gt=0, description="amplitude of the elevation [m]")]
    length: Annotated[float, Field(gt=0, description="length of the wave [m], twice that of a tank with one node")]
    depth: Depth
    phase: Annotated[float, Field(description="phase at the start [rad]")] = 0.0
    at: Annotated[float, Field(description="position x of an antinode [m]")] = 0.0
    g: Gravity = 9.81

    @property
    def k(self) -> float:
        """Wave number [1/m]."""
        return 2.0 * np.pi / self.length

    @property
    def omega(self) -> float:
        """Angular frequency [rad/s]."""
        return float(angular_frequency(self.k, self.depth, self.g))

    def elevation(self, x: ArrayLike, t: ArrayLike) -> Floats:
        along, swing = np.cos(self.k * (np.asarray(x) - self.at)), np.sin(self.omega * np.asarray(t) + self.phase)
        eta: Floats = self.amplitude * along * swing
        return eta

    def velocity(self, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> tuple[Floats, Floats]:
        x, y, t = np.broadcast_arrays(np.asarray(x, dtype=float), y, t)
        cosh, sinh = transfer(self.k, y, self.depth)
        scale = self.amplitude * self.omega * np.cos(self.omega * t + self.phase)
        return -scale * cosh * np.sin(self.k * (x - self.at)), scale * sinh * np.cos(self.k * (x - self.at))
