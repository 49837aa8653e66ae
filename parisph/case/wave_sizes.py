"""The waves of a case: their heights, lengths and periods, and their rates of strain."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from parisph.base.arrays import Floats
from parisph.base.errors import CaseError
from parisph.case import absorb, scenery
from parisph.case.bodies import Body, Flap, Piston, motion_of
from parisph.case.expressions import uniform_field
from parisph.case.motion import FlapStroke, PistonStroke, Roll, Sway
from parisph.case.motion.measured import Series
from parisph.case.motion.wavemaker import flap_ratio, piston_ratio
from parisph.case.scene import Scene
from parisph.case.scenery import fluid_names
from parisph.case.values import SMALLEST
from parisph.case.waves import (
    Airy,
    AnyWave,
    Jonswap,
    Sloshing,
    SolitaryWave,
    StandingWave,
    Stokes,
    StreamFunction,
    TankMode,
    wave_number,
)

LINEAR = "the start or the motion of the tank"    # cause of the waves of level water, in place of a field's name
TIMES = 600     # in a run, at which the greatest elevation of a Sloshing is searched
AROUND = 1.5    # lengths of a wave to both sides of its crest, over which the rate of strain is averaged
ACROSS, UP, PHASES = 48, 12, 16    # places and times of this mean
APART = 1e-3    # of the depth: half the distance of central differences


@dataclass(frozen=True)
class Size:
    """The size of a wave: of irregular waves the significant height, and length and period of the peak.

    name : of the field of the wave, for messages; wave : the record; height, length, depth [m]; period [s]

    The length of a solitary wave is 2 pi/m, where its elevation falls as exp(-m x) far from the crest, and its
    period is the time in which it runs this length.
    """

    name: str
    wave: AnyWave
    height: float
    length: float
    period: float
    depth: float

    @property
    def second_order(self) -> float:
        """Amplitude of the second harmonic of a regular wave of this size over that of the first, by Stokes' theory."""
        k = 2.0 * np.pi / self.length
        sigma = float(np.tanh(k * self.depth))
        return 0.5 * k * self.height * (3.0 - sigma**2) / (4.0 * sigma**3)


def waves(case: Scene) -> Iterator[tuple[str, AnyWave]]:
    """Yield the waves of a case with their names in messages: those at the start, of wavemakers and of zones."""
    for name, fluid in fluid_names(case):
        if fluid.wave is not None:
            yield f"{name}.wave", fluid.wave
    for name, body in zip(scenery.body_names(case.bodies), case.bodies):
        motion = motion_of(body)
        if isinstance(motion, (PistonStroke, FlapStroke)):
            yield f"walls, {name}: {'wave' if getattr(body, 'wave', None) else 'motion.wave'}", motion.wave
        made = _made_by(body, case)
        if made is not None:
            yield f"walls, {name}: motion", made
    for number, zone in enumerate(case.zones):
        if isinstance(zone, absorb.Relaxation):
            yield f"absorb[{number}].wave", zone.wave


def _made_by(body: Body, case: Scene) -> Airy | None:
    """Return the wave of a harmonic piston or flap by linear theory, if gravity points down; else None."""
    motion, gravity = getattr(body, "motion", None), uniform_field(case.gravity)
    if not isinstance(body, (Piston, Flap)) or not isinstance(motion, (Sway, Roll)) or gravity is None:
        return None
    if isinstance(motion.amplitude, Series) or gravity[:-1].any() or not gravity[-1] < 0.0:
        return None
    lower, upper = case.fluid_bounds
    depth, g = float(upper[-1] - lower[-1]), -float(gravity[-1])
    k = float(wave_number(motion.omega, depth, g))
    height = 2.0 * abs(motion.amplitude)
    if isinstance(motion, Sway):
        height *= piston_ratio(k, depth)
    else:
        hinge = motion.centre[1] - float(lower[-1])
        height *= (depth - hinge) * flap_ratio(k, depth, hinge)
    try:
        return Airy(height=height, period=2.0 * np.pi / motion.omega, depth=depth, g=g)
    except CaseError:    # it would break
        return None


def sizes(case: Scene) -> list[Size]:
    """Return the Size of each wave of a case."""
    return [size_of(name, wave, case.end_time) for name, wave in waves(case)]


def size_of(name: str, wave: AnyWave, stop: float) -> Size:
    """Return the Size of a wave until a time [s]."""
    if isinstance(wave, (Airy, Stokes, StreamFunction)):
        return Size(name, wave, wave.height, wave.length, wave.period, wave.depth)
    if isinstance(wave, SolitaryWave):
        length = 2.0 * np.pi / wave.rate
        return Size(name, wave, wave.height, length, length / wave.celerity, wave.depth)
    if isinstance(wave, Jonswap):
        k = float(wave_number(2.0 * np.pi / wave.period, wave.depth, wave.g))
        return Size(name, wave, wave.height, 2.0 * np.pi / k, wave.period, wave.depth)
    if isinstance(wave, Sloshing):
        standing = StandingWave(amplitude=1.0, length=2.0 * wave.length, depth=wave.depth, g=wave.g)
        eta = np.abs(wave.elevation(wave.at, np.linspace(0.0, stop, TIMES))).max()
        return Size(name, wave, 2.0 * float(eta), standing.length, 2.0 * np.pi / standing.omega, wave.depth)
    length = wave.wavelength if isinstance(wave, TankMode) else wave.length
    return Size(name, wave, 2.0 * wave.amplitude, length, 2.0 * np.pi / wave.omega, wave.depth)


def strain_rate(size: Size, width: float) -> float:
    """Return the greatest spatial mean of the rate of strain sqrt(2 S:S) [1/s] of a wave.

    width : of the water [m], over which all waves except solitary ones extend
    """
    wave, d = size.wave, size.depth
    middle = getattr(wave, "at", 0.0)
    if 0.5 * size.height < SMALLEST:
        return 0.0
    if isinstance(wave, (Sloshing, TankMode)):
        wave, middle = StandingWave(amplitude=0.5 * size.height, length=size.length, depth=d, g=wave.g), 0.0
    x, y = (part.ravel() for part in np.meshgrid(
        middle + AROUND * size.length * np.linspace(-1.0, 1.0, ACROSS), d * (np.arange(UP) + 0.5) / UP))
    lasting = isinstance(wave, (Airy, Stokes, StreamFunction, SolitaryWave))    # its shape stays
    times = [0.0] if lasting else size.period * np.arange(PHASES) / PHASES
    share = min(1.0, 2.0 * AROUND * size.length / width) if isinstance(wave, SolitaryWave) else 1.0
    return share * max(_mean_rate(wave, x, y, float(t), APART * d) for t in times)


def _mean_rate(wave: AnyWave, x: Floats, y: Floats, t: float, h: float) -> float:
    """Return the mean of sqrt(2 S:S) [1/s] at places x, y (n,) [m] in an irrotational flow without divergence."""
    right, left = wave.velocity(x + h, y, t), wave.velocity(x - h, y, t)
    along, across = (right[0] - left[0]) / (2.0 * h), (right[1] - left[1]) / (2.0 * h)
    return float(np.mean(2.0 * np.hypot(along, across)))
