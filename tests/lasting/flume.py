"""Flumes: a maker of waves, gauges along the tank, and a sponge of one and a half wavelengths at its end."""

from dataclasses import dataclass

import numpy as np

from parisph.case.absorb import Relaxation, Sponge, Zone
from parisph.case.schema import Box, Case, Flap, Fluid, Heave, Numerics, Obstacle, Piston, Profile, StillWater, Tank
from parisph.case.waves import StreamFunction, angular_frequency
from parisph.case.waves.wavefield import WaveField
from tests.hard.table import Line
from tests.lasting.harmonics import by_period
from tests.lasting.long import DENSITY, DEPTH, G, Record, Setting, gauges, of_level

TOP = 1.6           # of the walls / d
BEHIND = 0.5        # bed behind a wavemaker / d
SPONGE = 1.5        # wavelengths: a wave comes back with less than a hundredth of its height
ALONG = 12          # gauges in the middles of equal parts of the flume, for its mean level
SETTLED = 3.0       # periods after the ramp and the front at group velocity, from when on waves are regular
BODY, DRAFT = 2.0, 0.5    # of the heaving body: breadth and draft / d


def wave_of(kd: float, height: float) -> StreamFunction:
    """Return the regular wave of height [d] whose period linear theory gives for kd, in a closed flume."""
    period = 2.0 * np.pi / float(angular_frequency(kd / DEPTH, DEPTH, G))
    return StreamFunction(height=height * DEPTH, period=period, depth=DEPTH, closed=True)


def fronts(kd: float, places: np.ndarray) -> np.ndarray:
    """Return when waves from x = 0 are regular at places (n,) [m], in periods."""
    twice = 2.0 * kd
    group = 0.5 * (1.0 + twice / np.sinh(twice))    # over the speed of the crests
    return 1.0 + SETTLED + places * kd / (2.0 * np.pi * DEPTH) / group


@dataclass(frozen=True)
class Flume:
    """A flume for a wave of a length [m]; waves come from x = 0 and run to x = reach [m], where the sponge begins.

    maker : "piston", "flap", "zone" or "body"
    further : walls beside those of the flume and its maker
    """

    maker: str
    wave: WaveField
    length: float
    reach: float
    further: tuple = ()

    @property
    def begin(self) -> float:
        """Where the tank begins, x [m]."""
        return {"piston": 0.0, "flap": 0.0, "zone": -self.length}.get(self.maker, -BODY - 1.5 * self.length)

    @property
    def end(self) -> float:
        """Where it ends, x [m]."""
        return self.reach + SPONGE * self.length

    @property
    def along(self) -> np.ndarray:
        """Places of the gauges for the mean level, x (n,) [m]; none is in the body."""
        return self.begin + (np.arange(ALONG) + 0.5) * (self.end - self.begin) / ALONG

    @property
    def level(self) -> float:
        """Its mean level beside that of its start [m]: a body that heaves is above its place at the start."""
        return 0.0 if self.maker != "body" else -self._heave * BODY * DEPTH / (self.end - self.begin - BODY * DEPTH)

    @property
    def _heave(self) -> float:
        """Amplitude of a body that displaces as much water as waves of the height to both sides [m]."""
        return self.wave.height * self.length / (2.0 * np.pi * BODY * DEPTH)

    def case(self, depth: float, places: np.ndarray, setting: Setting, end_time: float, preset: str = "gentle") -> Case:
        """Return the case with a depth [s] and gauges at places x (n,) [m], and `along` after them."""
        preset = setting.preset or preset
        return Case(
            title="A flume", fluid=Fluid(StillWater(level=DEPTH), density=DENSITY), gravity=(0.0, -G),
            walls=(*self._walls(), *self.further), absorb=self._zones(),
            numerics=Numerics(preset=preset, spacing=DEPTH / depth, time_step=setting.time_step(DEPTH, G)),
            probes=gauges([*places, *self.along]), end_time=end_time)

    def _walls(self):
        if self.maker in ("zone", "body"):
            tank = Tank(width=self.end - self.begin, height=TOP * DEPTH, at=(self.begin, 0.0))
            return (tank,) if self.maker == "zone" else (tank, self._body())
        bed = [(-BEHIND * DEPTH, 0.0), (self.end, 0.0), (self.end, TOP * DEPTH)]
        made = (Piston(at=0.0, wave=self.wave, name="piston") if self.maker == "piston"
                else Flap(hinge=(0.0, 0.0), wave=self.wave, name="flap"))
        return Profile(bed, name="bed"), made

    def _body(self):
        heave = Heave(amplitude=self._heave, frequency=2.0 * np.pi / self.wave.period)
        shape = Box(width=BODY * DEPTH, height=2.0 * DRAFT * DEPTH, at=(-BODY * DEPTH, (1.0 - DRAFT) * DEPTH))
        return Obstacle(shape, name="body", motion=heave)

    def _zones(self) -> tuple[Zone, ...]:
        sponge = Sponge(self.reach, SPONGE * self.length)
        if self.maker == "zone":
            zone = Relaxation(start=self.begin, length=self.length, wave=self.wave, ramp=2.0 * self.wave.period)
            return zone, sponge
        return (Sponge(self.begin, self.length), sponge) if self.maker == "body" else (sponge,)


def level_lines(record: Record, period: float, height: float, due: float = 0.0) -> list[Line]:
    """Return lines for the mean level over a wave height [m], of the last gauges, which are ALONG the flume.

    due : the level that it has without error [m], after the first period
    """
    level = by_period(record.time, record.gauges[:, -ALONG:].mean(axis=1), period)
    if not len(level.mean):
        return []
    return of_level(level.mean - due, height, "H", 0.03)
