"""Rough estimates of the waves and speeds of a scene before it is run, for `parisph check`.

They use the first mode of linear waves, free fall, and the initial velocity.
"""

from dataclasses import dataclass

import numpy as np

from parisph.base.arrays import Floats
from parisph.case.bodies import StillWater
from parisph.case.expressions import uniform_field, vector_field
from parisph.case.motion import AtRest
from parisph.case.scenery import wall_speed
from parisph.case.schema import Case
from parisph.case.shapes import Box
from parisph.case.time_scales import LOOKS
from parisph.case.values import SMALLEST
from parisph.case.wave_sizes import LINEAR, Size, size_of
from parisph.case.waves import StandingWave, angular_frequency

SAMPLES = 400        # points, or times, at which a field of the case is evaluated
PER_PERIOD = 40      # steps of the oscillator per period of the first mode
RUN_UP = 2.0         # speed of waves at a wall or a beach over that of their wavemaker, or of the start
MOST_STEPS = 20_000  # of the oscillator; of a longer run it takes the beginning


@dataclass(frozen=True)
class Scales:
    """Expected scales of a scene.

    wave : the wave of level water, by linear theory, or None
    times : (n,) [s], from 0 to the end of the run
    speeds : (n,) largest speed of a particle at these times [m/s]
    accelerations : (n,) largest acceleration of a particle at these times [m/s^2]
    force : largest body force per unit mass at the start [m/s^2]
    """

    wave: Size | None
    times: Floats
    speeds: Floats
    accelerations: Floats
    force: float


def expected(case: Case) -> Scales:
    """Return the Scales of a case.

    In level water between two walls the speed is the initial speed plus that of waves: those of the initial elevation,
    and the first mode, an oscillator driven by the horizontal body force (which includes the motion of the tank). As
    waves break, their amplitude is at most the depth, and their speed at most that of a fall from this height plus the
    work of the tank's acceleration along its length. Still water between other walls moves as its wave or its
    wavemaker. All other fluid gains the energy of a fall from its top to the tank's bed (Z14 Sec. 3.1.2). The
    acceleration of level water is the frequency of its motion times the speed, that of other fluid the body force, that
    of fluid without a surface or a force the one of its own flow.
    """
    times = np.linspace(0.0, case.end_time, SAMPLES)
    force, down = _gravity(case)
    speeds = np.full(SAMPLES, _start_speed(case))
    wave = None
    lower, upper = case.fluid_bounds
    accelerations = np.pi / float(np.min(upper - lower)) * speeds**2    # of vortices as wide as the fluid
    if case.closed or force == 0.0:
        return Scales(wave, times, speeds, accelerations, force)
    level = _level(case, down)
    if _calm(case):
        speeds = np.full(SAMPLES, RUN_UP * (_start_speed(case) + wall_speed(case)))
        lower, upper = case.fluid_bounds
        accelerations = np.minimum(force, np.sqrt(force / float((upper - lower)[-1])) * speeds)
    elif level is not None:
        wave, moving, accelerations = _waves(case, level, force, times, speeds)
        speeds += moving
    else:
        accelerations = np.full(SAMPLES, force)
        speeds = np.hypot(speeds, np.minimum(force * times, np.sqrt(2.0 * force * _fall(case, down))))
    return Scales(wave, times, speeds, accelerations, force)


def _calm(case: Case) -> bool:
    """Return whether all fluid is still water, with or without a wave, in a frame at rest."""
    return isinstance(case.frame, AtRest) and all(isinstance(fluid.shape, StillWater) for fluid in case.fluids)


def top_speed(case: Case) -> float:
    """Return the greatest speed [m/s] of fluid without jets: of its start, of walls and frame, and of a fall.

    The fall is through the whole scene along each axis, by the largest body force; without walls it lasts until the
    end.
    """
    x, bounds = np.concatenate(_sample(case)), case.wall_bounds
    force = np.max([np.abs(case.body_force(x, t)).max(axis=0) for t in np.linspace(0.0, case.end_time, LOOKS)], axis=0)
    if bounds is None:
        return _start_speed(case) + float(np.linalg.norm(force)) * case.end_time
    fall = float(np.sqrt(2.0 * force @ (np.asarray(bounds[1]) - np.asarray(bounds[0]))))
    return _start_speed(case) + wall_speed(case) + case.frame.top_speed(*bounds) + fall


def fall_time(case: Case) -> float:
    """Return sqrt(depth/g) [s] of level water at rest without waves, 0 for other fluid."""
    force, down = _gravity(case)
    level = _level(case, down)
    if force == 0.0 or uniform_field(case.gravity) is None or case.closed or level is None:
        return 0.0
    if _start_speed(case) > 0.0 or case.fluids[0].raised:
        return 0.0
    return float(np.sqrt(level.size[-1] / force))


def _sample(case: Case) -> list[Floats]:
    """Return points (n, dim) [m] in each body of fluid at the start, without its elevation."""
    count = max(3, round(SAMPLES ** (1.0 / case.dim)))
    return case.points(count, count)


def _gravity(case: Case) -> tuple[float, Floats]:
    """Return the largest body force of the start [m/s^2], and the unit vector of its mean (zero if there is none)."""
    force = vector_field(case.gravity, with_time=True)(np.concatenate(_sample(case)))
    mean = force.mean(axis=0)
    size = float(np.linalg.norm(mean))
    largest = float(np.linalg.norm(force, axis=1).max(initial=0.0))
    return largest, mean / size if size > 1e-9 * largest > 0.0 else np.zeros(case.dim)


def _start_speed(case: Case) -> float:
    return max(float(np.linalg.norm(fluid.start_velocity(x), axis=1).max(initial=0.0))
               for fluid, x in zip(case.fluids, _sample(case)))


def _level(case: Case, down: Floats) -> Box | None:
    """Return the fluid if it is a Box between the tank's walls, on its bed, under gravity downwards; else None."""
    box = case.fluids[0].shape
    tank = case.lone_tank
    if tank is None or len(case.fluids) > 1 or not isinstance(box, Box) or down[-1] > -0.99:
        return None
    (lower, upper), (low, high) = case.box_of(box), tank.bounds
    slack = 0.5 * case.numerics.spacing
    fills = np.all(np.abs(lower - low) < slack) and np.all(np.abs(upper - high)[:-1] < slack)
    return box if fills else None


def _fall(case: Case, down: Floats) -> float:
    """Return the greatest fall of fluid [m]: across the tank; without walls infinite, or to the centre of a force."""
    lower, upper = case.fluid_bounds
    if case.wall_bounds is None:
        return np.inf if uniform_field(case.gravity) is not None else 0.25 * float(np.max(upper - lower))
    low, high = case.wall_bounds
    top = np.where(down > 0.0, lower, upper) @ -down
    return float(top - np.where(down > 0.0, high, low) @ -down)


def _standing(amplitude: float, k: float, depth: float, g: float) -> Size:
    wave = StandingWave(amplitude=amplitude, length=2.0 * np.pi / k, depth=depth, g=g)
    return size_of(LINEAR, wave, 0.0)


def _of_start(case: Case, level: Box, g: float) -> tuple[float, float]:
    """Return amplitude [m] and wave number [1/m] of the linear wave of level water at the start."""
    found, depth = [], level.size[-1]
    for axis, surface in enumerate(_lines(case, level)):
        amplitude, k = _elevation(case, axis, surface)
        speed, own = _harmonic(surface[:, axis], case.fluids[0].start_velocity(surface)[:, -1])
        rise = speed / float(angular_frequency(own, depth, g))
        found.append((float(np.hypot(amplitude, rise)), (k if amplitude >= rise else own)))
    return max(found, key=lambda wave: wave[0])


def _lines(case: Case, level: Box) -> list[Floats]:
    """Return points (SAMPLES, dim) [m] of lines on level water: along x, in 3D in its middle, and across there."""
    (lower, upper), found = case.box_of(level), []
    for axis in range(case.dim - 1):
        line = np.tile(0.5 * (lower + upper), (SAMPLES, 1))
        line[:, -1], line[:, axis] = upper[-1], np.linspace(lower[axis], upper[axis], SAMPLES)
        found.append(line)
    return found


def _elevation(case: Case, axis: int, line: Floats) -> tuple[float, float]:
    """Return amplitude [m] and wave number [1/m] of the elevation at the start, along an axis on one of `_lines`."""
    return _harmonic(line[:, axis], case.fluids[0].rise(line[:, 0], line[:, 1] if case.dim == 3 else None))


def _waves(case: Case, level: Box, g: float, times: Floats, start: Floats) -> tuple[Size | None, Floats, Floats]:
    """Return the largest wave on level water, or None, and speed [m/s] and acceleration [m/s^2] of its particles, (n,).

    start : (n,) initial speed [m/s], which the returned speed does not include
    """
    depth, lengths = level.size[-1], [float(level.size[0]), *(np.diff(case.breadth) if case.breadth else ())]
    modes = [_sloshing(case, g, np.pi / length, depth, times, axis) for axis, length in enumerate(lengths)]
    axis = int(np.argmax([eta for eta, _ in modes]))
    length, eta = lengths[axis], modes[axis][0]
    speed = modes[0][1] if case.dim == 2 else np.hypot(*(speed for _, speed in modes))
    acceleration = angular_frequency(np.pi / length, depth, g) * speed
    amplitude, k = max((_elevation(case, axis, line) for axis, line in enumerate(_lines(case, level))),
                       key=lambda wave: wave[0])
    omega = angular_frequency(k, depth, g)
    speed = speed + amplitude * omega / np.tanh(k * depth)
    acceleration = acceleration + amplitude * omega**2 / np.tanh(k * depth)
    of_start, own = _of_start(case, level, g)
    acceleration = acceleration + angular_frequency(own, depth, g) * start
    amplitude = min(eta + of_start, depth)
    cap = np.sqrt(2.0 * (g * depth + _push(case) * length))
    k = own if of_start > eta else np.pi / length
    wave = _standing(amplitude, k, depth, g) if amplitude >= SMALLEST else None
    return wave, np.minimum(speed, cap), acceleration


def _push(case: Case) -> float:
    """Return the largest horizontal body force [m/s^2] in the middle of the fluid in the frame of the tank."""
    centre = np.concatenate(_sample(case)).mean(axis=0, keepdims=True)
    return max(float(np.abs(case.body_force(centre, t)[0, :-1]).max())
               for t in np.linspace(0.0, case.end_time, SAMPLES))


def _sloshing(case: Case, g: float, k: float, depth: float, times: Floats, axis: int = 0) -> tuple[float, Floats]:
    """Amplitude [m] and speed (n,) [m/s] of the first mode on an axis, eta'' + omega^2 eta = -(omega^2/g) f 4L/pi^2.

    f is the body force along the axis; the linear potential problem of a tank, projected on cos(pi x/L).
    """
    omega = float(angular_frequency(k, depth, g))
    count = int(np.clip(case.end_time * omega / (2.0 * np.pi) * PER_PERIOD, SAMPLES, MOST_STEPS))
    dt = min(case.end_time / count, 2.0 * np.pi / omega / PER_PERIOD)
    centre = np.concatenate(_sample(case)).mean(axis=0, keepdims=True)
    share = -4.0 * omega**2 / (g * np.pi * k)
    eta, rate, largest, size = 0.0, 0.0, 0.0, np.zeros(count)
    for step in range(count):
        force = float(case.body_force(centre, step * dt)[0, axis])
        rate += dt * (share * force - omega**2 * eta)
        eta += dt * rate
        largest = max(largest, abs(eta))
        size[step] = np.hypot(eta, rate / omega)
    speed = omega * size / np.tanh(k * depth)
    return largest, np.interp(times, dt * np.arange(1, count + 1), speed)


def _harmonic(x: Floats, values: Floats) -> tuple[float, float]:
    """Return amplitude and wave number [1/m] of a cosine similar to the values (n,) at x (n,), at least half a wave."""
    amplitude, longest = float(np.ptp(values)) / 2.0, np.pi / (x[-1] - x[0])
    if amplitude == 0.0:
        return 0.0, longest
    return amplitude, max(float(np.std(np.diff(values) / np.diff(x)) / np.std(values)), longest)
