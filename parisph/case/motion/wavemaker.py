"""Motions of pistons and flaps that make a given wave.

A solitary wave: Goring (1978), Tsunamis: the propagation of long waves onto a shelf, W. M. Keck Laboratory KH-R-38. The
piston moves with the mean velocity of the wave at its position, X' = c eta/(d + eta), here with the exact elevation.

Regular and irregular waves: the linear transfer functions of Biesel and Suquet, as in Dean & Dalrymple (1991), Water
wave mechanics, Sec. 6.2. Regular waves get a second harmonic, see second_order.py.
"""

from abc import abstractmethod
from collections.abc import Callable
from functools import lru_cache
from typing import TYPE_CHECKING, Annotated, Literal, Union, cast

import numpy as np
from pydantic import Field, model_validator

from parisph.base.arrays import Floats
from parisph.case.motion.rigid import SHARE, Centre, Motion, Rotation, Translation, evenly
from parisph.case.motion.second_order import second_harmonic
from parisph.case.motion.splines import Law, Quintic, product, rise
from parisph.case.waves.airy import Airy
from parisph.case.waves.jonswap import Jonswap, components_of
from parisph.case.waves.solitary import SolitaryWave
from parisph.case.waves.stokes import Stokes
from parisph.case.waves.stream_function import StreamFunction

BLOCK = 1000    # times evaluated together
MANY = 1000     # peak periods of irregular waves that sample the range of their maker
KNOTS = 600    # of the motion for a solitary wave
LONGEST = 8.0 * np.pi**2 / 3.0    # of height length^2/depth^3: beyond, a second-order wave has a second crest

Ramp = Annotated[float | None, Field(ge=0, description="time [s] in which the motion grows; default one period")]
WaveTrain = Union[Airy, Stokes, StreamFunction, Jonswap]
Profile = tuple[Callable[[Floats], Floats], float]    # displacement at y above the bed, 1 at the surface; lowest y


def piston_ratio(k: float, depth: float) -> float:
    """Return the height of waves over the stroke of a piston, 4 sinh^2(kd)/(sinh(2kd) + 2kd)."""
    kd = k * depth
    return float(2.0 * np.expm1(-2.0 * kd) ** 2 / (-np.expm1(-4.0 * kd) + 4.0 * kd * np.exp(-2.0 * kd)))


def flap_ratio(k: float, depth: float, hinge: float) -> float:
    """Return the height of waves over the stroke of a flap at the still surface; hinge : its height above the bed [m].

    Below a hinge above the bed the wall is fixed. If the hinge is below the bed, the flap begins at the bed.
    """
    kd, low = k * depth, max(hinge, 0.0)
    arm = depth - hinge
    # integral of (y - hinge)/arm cosh(k y) over the part of the flap in the water, times k/sinh(kd)
    first = 1.0 - (low - hinge) / arm * np.sinh(k * low) / np.sinh(kd)
    second = (np.cosh(kd) - np.cosh(k * low)) / (k * arm * np.sinh(kd))
    return piston_ratio(k, depth) * float(first - second)


@lru_cache(maxsize=16)
def _solitary(wave: SolitaryWave, tail: float) -> tuple[Quintic, float]:
    """Return the motion of the piston, and the distance [m] of the crest behind it at the start."""
    d, c = wave.depth, wave.celerity
    # far away the wave is about 4 height exp(-rate x)
    far = np.linspace(0.0, np.log(10.0 / tail) / wave.rate, KNOTS)
    ahead = np.interp(-np.log(tail), -np.log(wave.shape(far)[0] / wave.height), far)
    xi = np.linspace(ahead, -ahead, KNOTS)
    eta, slope, area = wave.shape(xi)
    moved = (area - area[0]) / d
    rate, second = c * eta / (d + eta), -((c * d) ** 2) * slope / (d + eta) ** 3
    for values in (rate, second):
        values[[0, -1]] = 0.0    # from and to rest within the first and the last piece
    return Quintic((ahead - xi + moved) / c, moved, rate, second), float(ahead)


def _check_length(wave: WaveTrain | SolitaryWave, words: str) -> None:
    """Raise ValueError if a regular wave is too long for the second order. words : the record"""
    if isinstance(wave, (Airy, Stokes, StreamFunction)):
        ursell = wave.height * wave.length**2 / wave.depth**3
        if ursell > LONGEST:
            raise ValueError(
                f"wave: height length^2/depth^3 = {ursell:.3g}, the second order holds up to {LONGEST:.3g}; "
                f"use a shorter or lower wave, or as motion a {words} with second_order=False"
            )


@lru_cache(maxsize=16)
def _harmonics(stroke: "_Stroke") -> tuple[Floats, Floats, Floats]:
    """Return amplitude [m], angular frequency [rad/s] and phase of X = sum a sin(w t - phase), (n,) each."""
    wave = stroke.train
    sign = -1.0 if wave.leftward else 1.0
    if isinstance(wave, Jonswap):
        a, w, k, phase = components_of(wave)
        return a / np.array([stroke.ratio(value) for value in k]), w, k * sign * stroke.place + phase
    first, f = 0.5 * wave.height / stroke.ratio(wave.k), 2.0 * np.pi / wave.period
    start = wave.k * sign * (stroke.place - wave.at)
    if not stroke.second_order:
        return np.array([first]), np.array([f]), np.array([start])
    shape, low = stroke.moved
    second = second_harmonic(wave.height, f, wave.depth, shape, low, wave.g)
    phases = np.array([start, 2.0 * start + 0.5 * np.pi - np.angle(second)])    # there X = X1 cos(w t - start - pi/2)
    return np.array([first, abs(second)]), np.array([f, 2.0 * f]), phases


class _Stroke(Motion):
    """The motion of a wavemaker: a sum of harmonics growing from rest."""

    if TYPE_CHECKING:    # see Translation
        @property
        def wave(self) -> WaveTrain | SolitaryWave: ...
        @property
        def place(self) -> float: ...
        @property
        def ramp(self) -> float | None: ...
        @property
        def second_order(self) -> bool: ...

    @abstractmethod
    def ratio(self, k: float) -> float:
        """Return the height of waves of a wave number [1/m] over the stroke at the still surface."""

    @property
    @abstractmethod
    def moved(self) -> Profile:
        """Displacement over that at the still surface, as a function of y above the bed [m], and the lowest such y."""

    @property
    @abstractmethod
    def _scale(self) -> float:
        """Value of the law for a displacement of 1 m towards the waves."""

    @property
    def train(self) -> WaveTrain:
        """The wave, which is not solitary."""
        return cast(WaveTrain, self.wave)

    @property
    def _growth(self) -> float:
        return self.train.period if self.ramp is None else self.ramp

    def law(self, t: float) -> Law:
        a, w, phase = _harmonics(self)
        sine, cosine = a * np.sin(w * t - phase), a * np.cos(w * t - phase)
        wave = float(sine.sum()), float((w * cosine).sum()), float(-(w * w * sine).sum())
        return _scaled(self._scale, product(rise(t, self._growth), wave))

    def values_at(self, times: Floats) -> Floats:
        a, w, phase = _harmonics(self)
        duration = self._growth
        found = [np.sin(np.outer(part, w) - phase) @ a for part in np.array_split(times, 1 + len(times) // BLOCK)]
        grown = np.minimum(np.maximum(times, 0.0) / duration, 1.0) if duration else np.ones(len(times))
        values: Floats = np.concatenate(found) * grown**3 * (10.0 - 15.0 * grown + 6.0 * grown**2)
        return self._scale * values

    def instants(self, stop: float) -> Floats:
        """See Motion: until one period after the growth of a regular motion, MANY of an irregular one.

        An irregular motion hardly exceeds its range in MANY periods.
        """
        many = MANY if isinstance(self.train, Jonswap) else 1
        return evenly(self.train.period, min(stop, self._growth + many * self.train.period))

    @property
    def longest_step(self) -> float:
        return SHARE * self.train.period

    @property
    def top_rate(self) -> float:
        """See Motion; of irregular motion, four standard deviations."""
        a, w, _ = _harmonics(self)
        return abs(self._scale) * float(4.0 * np.sqrt(0.5 * ((a * w) ** 2).sum()) if len(a) > 2
                                        else np.abs(a * w).sum())


def _scaled(scale: float, law: Law) -> Law:
    value, rate, second = law
    return scale * value, scale * rate, scale * second


class PistonStroke(_Stroke, Translation):
    """The motion of a vertical wall that makes a wave: a SolitaryWave, a regular wave, or a Jonswap.

    wave : the wave; `at` and phases are those in the scene. For a solitary wave `at` is ignored: the piston starts at
        t = 0, and `made` is the wave in the scene
    place : x [m] of the wall at rest
    second_order : whether regular waves get the second harmonic that avoids free waves of twice the frequency
    ramp : [s] in which regular and irregular motion grows; default one period
    tail : elevation over height at the piston when its motion for a solitary wave starts

    >>> stroke = PistonStroke(SolitaryWave(height=0.05, depth=0.25), place=0.0)
    >>> print(f"{stroke.made.celerity:.2f} m/s")
    1.71 m/s
    """

    kind: Literal["piston_stroke"] = Field(default="piston_stroke", init=False)
    wave: Annotated[
        Union[SolitaryWave, Airy, Stokes, StreamFunction, Jonswap], Field(discriminator="kind", description="a wave")
    ]
    place: Annotated[float, Field(description="position x of the wall at rest [m]")] = 0.0
    second_order: bool = True
    ramp: Ramp = None
    tail: Annotated[float, Field(gt=0, le=0.1, description="elevation over height when the motion starts")] = 1e-3

    @model_validator(mode="after")
    def _possible(self) -> "PistonStroke":
        wave = self.wave
        if isinstance(wave, SolitaryWave):
            if self.ramp is not None:
                raise ValueError(
                    f"ramp = {self.ramp:g}: is for regular and irregular waves; leave it out for a solitary wave"
                )
        elif self.second_order:
            _check_length(wave, "PistonStroke")
        return self

    @property
    def direction(self) -> tuple[float, float]:
        """The piston moves along x."""
        return 1.0, 0.0

    def ratio(self, k: float) -> float:
        return piston_ratio(k, self.wave.depth)

    @property
    def moved(self) -> Profile:
        """The same displacement at all heights."""
        return np.ones_like, 0.0

    @property
    def made(self) -> WaveTrain | SolitaryWave:
        """The wave in the scene; the crest of a solitary wave is behind the wall at t = 0."""
        if not isinstance(self.wave, SolitaryWave):
            return self.wave
        ahead = _solitary(self.wave, self.tail)[1]
        return self.wave.model_copy(update={"at": self.place - self._scale * ahead})

    @property
    def _scale(self) -> float:
        return -1.0 if self.wave.leftward else 1.0

    def law(self, t: float) -> Law:
        if isinstance(self.wave, SolitaryWave):
            return _scaled(self._scale, _solitary(self.wave, self.tail)[0].at(t))
        return super().law(t)

    def values_at(self, times: Floats) -> Floats:
        return Motion.values_at(self, times) if isinstance(self.wave, SolitaryWave) else super().values_at(times)

    def instants(self, stop: float) -> Floats:
        if isinstance(self.wave, SolitaryWave):    # monotonic
            knots: Floats = np.unique(np.minimum(_solitary(self.wave, self.tail)[0].t, stop))
            return knots
        return super().instants(stop)

    @property
    def longest_step(self) -> float:
        if isinstance(self.wave, SolitaryWave):
            return SHARE * 2.0 * np.pi / (self.wave.rate * self.wave.celerity)
        return super().longest_step

    @property
    def top_rate(self) -> float:
        if isinstance(self.wave, SolitaryWave):
            return float(np.abs(_solitary(self.wave, self.tail)[0].points[:, 1]).max())
        return super().top_rate


class FlapStroke(_Stroke, Rotation):
    """The motion of a hinged wall that makes a regular wave or a Jonswap.

    wave : the wave; centre : the hinge (x, y) [m]; bed : height y of the bed [m]; ramp, second_order : as of a
        PistonStroke

    >>> stroke = FlapStroke(Airy(height=0.05, period=1.2, depth=0.5), centre=(0.0, 0.1))
    >>> print(f"{abs(stroke.law(0.0)[0]):.3f} rad")    # at rest at the start
    0.000 rad
    """

    kind: Literal["flap_stroke"] = Field(default="flap_stroke", init=False)
    wave: Annotated[Union[Airy, Stokes, StreamFunction, Jonswap], Field(discriminator="kind", description="a wave")]
    centre: Centre = (0.0, 0.0)
    bed: Annotated[float, Field(description="height y of the bed [m]")] = 0.0
    ramp: Ramp = None
    second_order: bool = True

    @model_validator(mode="after")
    def _hinge_is_under_water(self) -> "FlapStroke":
        top = self.bed + self.wave.depth
        if not self.centre[1] < top:
            raise ValueError(f"centre = {self.centre}: the hinge must be below the still surface at y = {top:g}")
        if self.second_order:
            _check_length(self.wave, "FlapStroke")
        return self

    @property
    def place(self) -> float:
        """Position x of the wall at rest [m]."""
        return self.centre[0]

    @property
    def _arm(self) -> float:
        return self.bed + self.wave.depth - self.centre[1]

    def ratio(self, k: float) -> float:
        return flap_ratio(k, self.wave.depth, self.centre[1] - self.bed)

    @property
    def moved(self) -> Profile:
        """Displacement proportional to the height above the hinge, from the hinge or the bed up."""
        hinge = self.centre[1] - self.bed
        return lambda y: (y - hinge) / self._arm, max(hinge, 0.0)

    @property
    def _scale(self) -> float:    # a displacement towards +x is a clockwise turn
        return (1.0 if self.wave.leftward else -1.0) / self._arm
