"""Zones of a tank that force the velocity of the water towards that of a wave, or to rest.

The equation of motion has the additional term (u_t - u)/tau there. A Sponge (u_t = 0) absorbs incoming waves. A
Relaxation zone, with the velocity of a wave, absorbs every difference from it: it makes this wave and absorbs others.
"""

from collections.abc import Iterator, Sequence
from typing import Annotated, Literal, Union

import numpy as np
from pydantic import Field

from parisph.base.arrays import Floats
from parisph.case.model import Model
from parisph.case.waves import AnyWave, angular_frequency

# Strengths that best absorb waves of half to one zone length. A zone that makes a wave must also absorb the reflection
# from the wall behind it, which passes the zone only once.
SPONGE, RELAXATION = 17.0, 40.0


class Zone(Model):
    """Base of the zones.

    1/tau rises with the square of the distance from the end where waves enter, to strength c/length at the other end. c
    is the group velocity of waves as long as the zone, so the part of a wave that one pass absorbs depends on the
    strength alone. Higher rates reflect waves.
    """

    kind: str = Field(init=False)
    start: float = Field(description="lower end x of the zone [m]")
    length: float = Field(gt=0, description="length of the zone [m], at least that of the waves")
    strength: float = Field(default=SPONGE, gt=0, le=1000, description="greatest length / tau over group velocity")
    towards: Literal["left", "right"] | None = Field(
        default=None, description="end at which it is strongest; default the one nearer to an end of the tank")

    @property
    def end(self) -> float:
        """Upper end x of the zone [m]."""
        return self.start + self.length

    def shape(self, x: Floats, ends: tuple[float, float]) -> Floats:
        """Return 1/tau over its maximum, 0 to 1, at x (n,) [m] in a tank between two ends x [m]."""
        along = (x - self.start) / self.length
        if self._leftward(ends):
            along = 1.0 - along
        return np.where((x >= self.start) & (x <= self.end), np.clip(along, 0.0, 1.0) ** 2, 0.0)

    def target(self, x: Floats, t: float, level: float) -> Floats | float:
        """Return u_t (n, dim) [m/s] at x (n, dim) [m] and t [s]; 0.0 for rest. level : of still water [m]"""
        return 0.0

    def _leftward(self, ends: tuple[float, float]) -> bool:
        if self.towards is None:
            return self.start - ends[0] < ends[1] - self.end
        return self.towards == "left"


class Sponge(Zone):
    """Absorbs waves: forces the velocity towards zero.

    start, length [m]: the zone reaches from x = start to start + length, and is strongest at the end nearer to an end
    of the tank. It reflects 1 to 2.5 % of the height of waves of its length, .3 % of waves half as long (kd = .8 to 3).

    >>> Sponge(start=8.0, length=2.0).end
    10.0
    """

    kind: Literal["sponge"] = Field(default="sponge", init=False)


class Relaxation(Zone):
    """Makes a wave and absorbs all others: forces the velocity towards that of `wave`.

    For waves without mass transport. A solitary wave of 0.1 depths would leave the zone with 0.82 of its height.

    start, length [m] : as of a Sponge. Waves as long as the zone leave it within 4 % of their height (kd = .8 to 3). It
        reflects 8 % of the height of such waves, .3 % of waves half as long
    ramp : time [s] over which the wave grows from rest; 0 for a scene that starts with the wave
    level : height y of the still surface [m], by default the top of the fluid's shape

    >>> from parisph.case.waves import Airy
    >>> zone = Relaxation(start=0.0, length=2.0, wave=Airy(height=0.02, period=1.2, depth=0.5), ramp=2.4)
    >>> zone.wave.depth
    0.5
    """

    kind: Literal["relaxation"] = Field(default="relaxation", init=False)
    strength: float = Field(default=RELAXATION, gt=0, le=1000, description="greatest length / tau over group velocity")
    wave: AnyWave = Field(kw_only=True)
    ramp: float = Field(default=0.0, kw_only=True, ge=0, description="time over which the wave grows from rest [s]")
    level: float | None = Field(default=None, kw_only=True, description="height y of the still surface [m]")

    def target(self, x: Floats, t: float, level: float) -> Floats | float:
        bed = (level if self.level is None else self.level) - self.wave.depth
        grown = float(np.sin(0.5 * np.pi * np.clip(t / self.ramp, 0.0, 1.0)) ** 2) if self.ramp else 1.0
        return grown * self.wave.flow(x, bed, t)


AnyZone = Annotated[Union[Sponge, Relaxation], Field(discriminator="kind", description="a zone that absorbs waves")]


class Absorber:
    """The zones of a scene and their effect on the fluid.

    zones : of the case
    ends : x of both ends of the tank [m]
    level, depth : height y of the still surface, and depth of the water [m]; g : [m/s2]
    """

    def __init__(self, zones: Sequence[Zone], ends: tuple[float, float], level: float, depth: float, g: float) -> None:
        self._zones, self._ends, self._level = zones, ends, level
        self._most = [zone.strength * group_velocity(zone.length, depth, g) / zone.length for zone in zones]

    def __call__(self, x: Floats, t: float) -> tuple[Floats, Floats]:
        """Return 1/tau (n,) [1/s] and u_t/tau (n, dim) [m/s2] at x (n, dim) [m] and t [s], sums over the zones."""
        rate, pull = np.zeros(len(x)), np.zeros_like(x)
        for zone, most in zip(self._zones, self._most):
            own = most * zone.shape(x[:, 0], self._ends)
            here = np.flatnonzero(own)
            rate += own
            pull[here] += own[here, None] * zone.target(x[here], t, self._level)
        return rate, pull


def group_velocity(length: float, depth: float, g: float) -> float:
    """Return the group velocity [m/s] of linear waves of a length [m] in water of a depth [m]."""
    k = 2.0 * np.pi / length
    inward = 2.0 * k * depth / np.sinh(min(2.0 * k * depth, 700.0))    # beyond 700 the sinh overflows
    return float(0.5 * angular_frequency(k, depth, g) / k * (1.0 + inward))


def problems(zones: Sequence[Zone], ends: tuple[float, float]) -> Iterator[str]:
    """Yield one line for each zone outside of the ends x [m] of the tank, or over another one."""
    slack = 1e-6 * (ends[1] - ends[0])
    for number, zone in enumerate(zones):
        where = f"absorb[{number}]: {zone.kind} from x = {zone.start:g} to {zone.end:g}"
        if zone.start < ends[0] - slack or zone.end > ends[1] + slack:
            yield f"{where}: must lie within the walls, from x = {ends[0]:g} to {ends[1]:g}"
        for other in zones[:number]:
            if min(zone.end, other.end) - max(zone.start, other.start) > slack:
                yield f"{where}: lies over the {other.kind} from x = {other.start:g} to {other.end:g}; move one of them"
