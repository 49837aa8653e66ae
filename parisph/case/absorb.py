"""Zones of a tank in which the water's velocity is drawn to that of a wave, or to rest.

There the equation of motion has the further term (u_t - u)/tau. With u_t = 0 (Sponge) the zone takes up the waves that
come to it; with the velocity of a wave (Relaxation) it takes up all that differs from that wave, so that it makes this
wave and absorbs others.
"""

from collections.abc import Iterator, Sequence
from typing import Annotated, Literal, Union

import numpy as np
from pydantic import Field

from parisph.base.arrays import Floats
from parisph.case.model import Model
from parisph.case.waves import AnyWave, angular_frequency

# They take up waves of half a zone to a whole one in length best. A zone that makes a wave must take up the one that
# the wall behind it makes, which passes the zone only once.
SPONGE, RELAXATION = 17.0, 40.0


class Zone(Model):
    """What the zones have in common.

    1/tau rises with the square of the distance from the end where waves come in, to strength c/length at the other
    end, with the group velocity c of waves as long as the zone: what it takes up of a wave in one pass depends on the
    strength alone. Higher rates reflect waves themselves.
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
        """Return 1/tau over its greatest value, from 0 to 1, at x (n,) [m] in a tank between two ends x [m]."""
        along = (x - self.start) / self.length
        if self._leftward(ends):
            along = 1.0 - along
        return np.where((x >= self.start) & (x <= self.end), np.clip(along, 0.0, 1.0) ** 2, 0.0)

    def target(self, x: Floats, t: float, level: float) -> Floats | float:
        """Return u_t (n, dim) [m/s] at x (n, dim) [m] and t [s] in water of a still level [m]; 0.0 for rest."""
        return 0.0

    def _leftward(self, ends: tuple[float, float]) -> bool:
        if self.towards is None:
            return self.start - ends[0] < ends[1] - self.end
        return self.towards == "left"


class Sponge(Zone):
    """Takes up waves: the velocity is drawn to zero.

    start, length [m]: the zone reaches from x = start to start + length, and becomes stronger towards the nearer end of
    the tank. Waves as long as the zone come back with 1 to 2.5 % of their height, waves half as long with .3 %
    (kd = .8 to 3).

    >>> Sponge(start=8.0, length=2.0).end
    10.0
    """

    kind: Literal["sponge"] = Field(default="sponge", init=False)


class Relaxation(Zone):
    """Makes a wave, and takes up all other waves: the velocity is drawn to that of `wave`.

    For waves that carry no water with them: all of it comes from the zone, which a solitary wave of 0.1 depths leaves
    with 0.82 of its height.

    start, length [m] : as of a Sponge. It is as strong as waves of its length need to come out within 4 % of their
        height (kd = .8 to 3); such waves that come back are reflected by 8 %, waves half as long by .3 %
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
        return grown * np.stack(self.wave.velocity(x[:, 0], x[:, -1] - bed, t), axis=1)


AnyZone = Annotated[Union[Sponge, Relaxation], Field(discriminator="kind", description="a zone that absorbs waves")]


class Absorber:
    """The zones of a scene: what they do to water at any place.

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
    inward = 2.0 * k * depth / np.sinh(min(2.0 * k * depth, 700.0))    # of the sinh overflows what is zero
    return float(0.5 * angular_frequency(k, depth, g) / k * (1.0 + inward))


def problems(zones: Sequence[Zone], ends: tuple[float, float]) -> Iterator[str]:
    """Yield one line for each zone that does not lie between the ends x [m] of the tank, or over another one."""
    slack = 1e-6 * (ends[1] - ends[0])
    for number, zone in enumerate(zones):
        where = f"absorb[{number}]: {zone.kind} from x = {zone.start:g} to {zone.end:g}"
        if zone.start < ends[0] - slack or zone.end > ends[1] + slack:
            yield f"{where}: must lie within the walls, from x = {ends[0]:g} to {ends[1]:g}"
        for other in zones[:number]:
            if min(zone.end, other.end) - max(zone.start, other.start) > slack:
                yield f"{where}: lies over the {other.kind} from x = {other.start:g} to {other.end:g}; move one of them"
