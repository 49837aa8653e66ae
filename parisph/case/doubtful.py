"""Warnings about a case before it is run: unresolved waves, and values that are probably mistakes.

Each check yields one line per warning, with field, value, limit and remedy. None of them refuses a case.
"""

import math
from collections.abc import Iterator, Sequence

import numpy as np

from parisph.base.text import rounded_down
from parisph.case import scenery
from parisph.case.absorb import Relaxation, Sponge
from parisph.case.bodies import Obstacle, Plate, StillWater, motion_of
from parisph.case.expressions import uniform_field
from parisph.case.motion import Angular, AtRest, Combined, Heave, Motion, Series, Sway
from parisph.case.scene import Scene
from parisph.case.scenery import fluid_names
from parisph.case.shapes import Box
from parisph.case.wave_sizes import Size
from parisph.case.waves import Airy, Sloshing, SolitaryWave, StandingWave, TankMode

# {preset: length in spacings below which a standing wave with kd = pi loses 5 % of its height or more in a period}. In
# three periods with `gentle`, H/s = .1 to 1, it loses 40 to 47 % at L/s = 6, 15 to 25 % at 8, 5 to 15 % at 10, 1 to 4 %
# at 16, 1 to 2.4 % at 20; with `violent` 2 to 26 % at 10 with a frequency up to 1.5 % off, 7 to 15 % at 20, 2 to 9 % at
# 40. The height in spacings does not matter: H/s = .1 loses no more than others of its length.
SHORTEST = {"gentle": 10.0, "solitary": 10.0, "violent": 20.0}
# second harmonic over the first. A start without it has free waves of twice the wave number: .04, .08 and .13 of the
# amplitude were measured where this is .04, .08 and .16 (kd = pi, start at the highest), and none at a flat start
HARMONIC = 0.1
# the same, above which no linear wave lasts: heights of .91 to .97 in three periods at .6, within 1 % at .15. In deep
# water it is a height of .19 of the length, and the highest standing wave has .2 to .22
MOST_HARMONIC = 0.3
FURTHEST = 0.5 * math.pi    # [rad]: a greater angle of a roll is probably in degrees
HARDEST = 10.0      # acceleration of a tank or a wall over gravity: a greater one is probably a mistake of units
# greatest displacement of water past a body, over its height, with the numerics of waves. Solitary waves over discs on
# the bed and a box, d = .3 m: forces are smooth at .9 and 1.3; at 1.8 with s = .02 m, but not with .013 m. They have
# spikes of 1.6 to 70 times their size at 1.5 (the box), 1.8, 2.5 and 3.6, and one of these runs doubles its energy.
# Regular waves over boxes, .2 to .3, run well for 40 periods (tests/lasting)
PAST = 1.3
TILTED = 0.5        # tuned 0.1 to 0.9: part of gravity along the vertical below which it points sideways; judged
FITS = 1e-6         # of half a length: how near to an antinode a wall must be
THIN = 1.5          # spacings: thinner fluid is one layer of particles


def doubts(case: Scene, waves: Sequence[Size]) -> Iterator[str]:
    """Yield one line for each warning.

    waves : the sizes of the case's waves
    """
    for wave in waves:
        yield from _short(case, wave)
    yield from _started(case, waves)
    yield from _standing(case)
    yield from _sponges(case, waves)
    yield from _motions(case)
    yield from _small_bodies(case, waves)
    yield from _gravity(case)
    yield from _thin(case)


def _short(case: Scene, wave: Size) -> Iterator[str]:
    s, preset = case.numerics.spacing, case.numerics.preset
    least = SHORTEST.get(preset)
    if least is not None and wave.length < least * s * (1.0 - 1e-9):
        yield (f"{wave.name}: its length of {wave.length:.3g} m is {wave.length / s:.2g} spacings: waves of less than "
               f"{least:g} lose 5 % of their height or more in each period with preset {preset}; use a spacing of at "
               f"most {rounded_down(wave.length / least)}")


def _started(case: Scene, waves: Sequence[Size]) -> Iterator[str]:
    """Waves of linear theory that are too high to start without their second order."""
    made = {f"{name}.wave" for name, _ in fluid_names(case)}
    made |= {f"absorb[{number}].wave" for number, zone in enumerate(case.zones) if isinstance(zone, Relaxation)}
    for size in waves:
        wave, part = size.wave, size.second_order
        if size.name not in made:
            continue
        if isinstance(wave, Airy) and part > HARMONIC:
            yield (f"{size.name}: a linear wave of this height lacks its second harmonic, {part:.0%} of its amplitude, "
                   "which becomes a free wave; use Stokes, or StreamFunction for a long one")
        elif isinstance(wave, (StandingWave, TankMode)) and part > MOST_HARMONIC:
            yield (f"{size.name}: it is too high for linear theory, by which its second harmonic has {part:.0%} of its "
                   f"amplitude, at most {MOST_HARMONIC:.0%}; use an amplitude of at most "
                   f"{rounded_down(0.5 * size.height * MOST_HARMONIC / part)}")
        elif isinstance(wave, (StandingWave, TankMode)) and (missed := part * math.sin(wave.phase) ** 2) > HARMONIC:
            yield (f"{size.name}: with phase = {wave.phase:.3g} it starts raised by linear theory, without its second "
                   f"harmonic, {missed:.0%} of its amplitude: as much becomes free waves of twice the wave "
                   "number; start with phase = 0, when the surface is flat and the second harmonic is least")


def _sponges(case: Scene, waves: Sequence[Size]) -> Iterator[str]:
    """Zones shorter than their incoming waves. Nothing was measured for solitary waves."""
    longest = max((wave for wave in waves if not isinstance(wave.wave, (SolitaryWave, Sloshing))),
                  key=lambda wave: wave.length, default=None)
    for number, zone in enumerate(case.zones):
        own = getattr(zone, "wave", None)
        if longest is not None and zone.length < longest.length * (1.0 - 1e-6):
            told = ("more than 2.5 % of it is reflected (0.3 % by a sponge of twice its length)"
                    if isinstance(zone, Sponge)
                    else "it leaves the zone lower" if longest.wave == own else "more than 8 % of it is reflected")
            yield (f"absorb[{number}]: the {zone.kind} is {zone.length:.3g} m long, and {longest.name} has a wave of "
                   f"{longest.length:.3g} m: {told}; use a length of at least {longest.length:.3g}")


def _motions(case: Scene) -> Iterator[str]:
    """Angles probably in degrees, and amplitudes in millimetres."""
    given = [("frame", case.frame), *((f"walls, {name}: motion", motion_of(body)) for name, body
                                      in zip(scenery.body_names(case.bodies), case.bodies))]
    named = [(name, part) for name, motion in given
             for part in (motion.parts if isinstance(motion, Combined) else (motion,))]
    gravity = uniform_field(case.gravity)
    g = 0.0 if gravity is None else float(np.linalg.norm(gravity))
    for name, motion in named:
        angle = _angle(motion, name == "frame")
        if angle > FURTHEST:
            yield (f"{name}: the angle of the {type(motion).__name__} reaches {angle:.3g} rad, "
                   f"{math.degrees(angle):.3g} degrees: did you mean {_radians(motion)}?")
        pull = abs(motion.amplitude) * motion.omega**2 if isinstance(motion, (Sway, Heave)) else 0.0    # [m/s2]
        if 0.0 < HARDEST * g < pull:
            yield (f"{name}: its acceleration reaches {pull:.3g} m/s2, {pull / g:.2g} times gravity: did you mean "
                   "another unit? An amplitude is in m, a frequency in rad/s")


def _angle(motion: Motion, frame: bool) -> float:
    """Return the greatest angle [rad] of an oscillation, else 0: by a Series, a wall may turn without limit."""
    if not isinstance(motion, Angular):
        return 0.0
    if isinstance(motion.amplitude, Series):
        return float(np.max(np.abs(motion.amplitude.values))) if frame and not motion.amplitude.rate else 0.0
    return float(abs(motion.amplitude))


def _radians(motion: Motion) -> str:
    assert isinstance(motion, Angular)
    if isinstance(motion.amplitude, Series):
        return "degrees, Series(..., scale=radians(1.0))"
    return f"radians({motion.amplitude!r}), {math.radians(motion.amplitude):.3g} rad"


def _standing(case: Scene) -> Iterator[str]:
    """A standing wave has an antinode at each wall of its tank, where water cannot pass."""
    tank = case.lone_tank
    if tank is None:
        return
    walls = np.array([float(corner[0]) for corner in tank.bounds])
    for name, fluid in fluid_names(case):
        wave = fluid.wave
        if not isinstance(wave, StandingWave) or wave.direction is not None or not isinstance(fluid.shape, StillWater):
            continue
        halves = 2.0 * (walls - wave.at) / wave.length
        if np.abs(halves - np.rint(halves)).max() > FITS:
            many = max(round(float(np.ptp(halves))), 1)
            yield (f"{name}.wave: length = {wave.length:g} with at = {wave.at:g} has no antinode at both walls of the "
                   f"tank, x = {walls[0]:g} and {walls[1]:g}: other waves will start; use "
                   f"length = {2.0 * float(np.ptp(walls)) / many:.6g} and at = {walls[0]:g}")


def _small_bodies(case: Scene, waves: Sequence[Size]) -> Iterator[str]:
    """Bodies at rest that water passes far, with the numerics of waves, which fill voids at edges too slowly."""
    if not case.numerics.resolved().wave_step:
        return
    bed = float(case.fluid_bounds[0][-1])
    for name, body in zip(scenery.body_names(case.bodies), case.bodies):
        if not isinstance(body, (Obstacle, Plate)) or not isinstance(motion_of(body), AtRest):
            continue
        lower, upper = body.bounds
        found = []
        for wave in waves:
            top = min(float(upper[-1]), bed + wave.depth)
            high = top - max(float(lower[-1]), bed)
            if isinstance(body, Plate):    # a level plate has no height
                high = max(high, float((upper - lower)[0])) if high >= 0.0 else 0.0
            if high > 0.0:
                move = _moved(wave, top - bed)
                found.append((move / high, move, high, wave.name))
        ratio, move, high, wave_name = max(found, default=(0.0, 0.0, 0.0, ""))
        if ratio > PAST:
            yield (f"walls, {name}: {wave_name} moves water by {move:.3g} m there, {ratio:.2g} times the {high:.3g} m "
                   f"that the body measures in the water: beyond {PAST:g} times, preset {case.numerics.preset} gives "
                   'forces with spikes, and the flow may explode; use preset="violent"')


def _moved(wave: Size, y: float) -> float:
    """Return the horizontal displacement [m] of water by a wave in half a period, at a height y [m] above the bed.

    A solitary wave displaces it once; the mean over the depth is returned.
    """
    if isinstance(wave.wave, SolitaryWave):
        return wave.wave.area / wave.depth
    k = 2.0 * math.pi / wave.length
    return wave.height * (math.exp(k * (y - wave.depth)) + math.exp(-k * (y + wave.depth))) / -math.expm1(
        -2.0 * k * wave.depth)


def _gravity(case: Scene) -> Iterator[str]:
    gravity = uniform_field(case.gravity)
    if gravity is None or case.walls is None or case.lidded or case.turns:
        return
    up, axis = float(gravity[-1]), "xyz"[case.dim - 1]
    shown = f"gravity = ({', '.join(f'{value:g}' for value in gravity)})"
    earth = f"on earth it is ({', '.join(['0'] * (case.dim - 1) + ['-9.81'])})"
    if up > 0.0:
        yield f"{shown}: it points upwards, out of an open tank, because {axis} points up; {earth}"
    elif not gravity.any():
        yield f"{shown}: nothing keeps the water in an open tank; {earth}, or give the tank a lid"
    elif -up < TILTED * float(np.linalg.norm(gravity)):
        yield f"{shown}: it points sideways, out of an open tank, because {axis} points up; {earth}"


def _thin(case: Scene) -> Iterator[str]:
    s = case.numerics.spacing
    for name, fluid in fluid_names(case):
        lower, upper = case.bounds_of(fluid)
        deep = float((upper - lower)[-1])
        if isinstance(fluid.shape, (Box, StillWater)) and 0.0 < deep < THIN * s * (1.0 - 1e-9):
            yield (f"{name}: it is {deep:.3g} m deep, {deep / s:.2g} spacings: all of it is surface, and the pressure "
                   f"on its bed is 0; use a spacing of at most {rounded_down(0.5 * deep)}")
