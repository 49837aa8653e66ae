"""Checks of the speeds, time steps and outputs of a case: absurd speeds, endless runs, full disks.

Each yields one line per problem, with field, value, limit and remedy.
"""

from collections.abc import Iterator

import numpy as np

from parisph.case import scenery, time_scales
from parisph.case.methods import METHODS
from parisph.case.motion import SHARE
from parisph.case.scene import Scene
from parisph.case.shapes import Lid

LEAP = 0.5          # spacings that a wall may move in a fixed time step
ABSURD = 10.0       # a fixed time step this many times the stable one counts as a mistake
FASTEST = 1480.0    # [m/s], speed of sound in water: faster flow is compressible
MOST_STEPS = 1e8    # of a run: far more than a machine computes in a year
MOST_FILES = 1e6    # of one kind that a run writes
MOST_SAMPLES = 1e8  # of a probe


def problems(case: Scene) -> list[str]:
    """Return the problems of speeds, or else those of times, steps and files."""
    return [*_speeds(case)] or [*_times(case), *_steps(case), *_files(case)]


def _speeds(case: Scene) -> Iterator[str]:
    """Nothing may be as fast as sound in water, or the water would be compressible."""
    u, g = time_scales.start(case)
    lower, upper = case.fluid_bounds
    high = float((upper - lower)[-1])
    bounds = (lower, upper) if case.wall_bounds is None else case.wall_bounds
    for speed, what, remedy in (
        (u, "fluid.velocity", "use a lower one"),
        (case.frame.top_speed(*bounds), f"frame = {case.frame.kind}", "use a smaller amplitude or frequency"),
        (scenery.wall_speed(case), "the fastest of the walls", "use a smaller amplitude or frequency"),
        (abs(case.tank.lid.velocity) if case.tank is not None and isinstance(case.tank.lid, Lid) else 0.0,
         "walls.lid.velocity", "use a lower one"),
        (float(np.sqrt(2.0 * g * high)), f"gravity = {g:.3g} m/s2: a fall of {high:.3g} m, the height of the fluid,",
         "use a smaller gravity, or lower fluid"),
    ):
        if speed > FASTEST:
            yield (f"{what} reaches {speed:.3g} m/s, must be below {FASTEST:g}, the speed of sound in water, beyond "
                   f"which no water is incompressible; lengths are in m, times in s, frequencies in rad/s; {remedy}")
    if METHODS[case.numerics.method].step == "compressible" and not time_scales.sound_speed(case):
        yield ("numerics.sound_speed: is not set, and without gravity and fluid.velocity nothing says how fast the "
               f"flow will be; set it to {time_scales.SOUND:g} times the highest speed [m/s] that you expect")


def _times(case: Scene) -> Iterator[str]:
    limit, reason = time_scales.stable_time_step(case)
    dt = case.numerics.time_step
    if dt is not None and dt > ABSURD * limit:
        yield (
            f"numerics.time_step = {dt:g} s: is {dt / limit:.0f} times the step of {limit:.3g} s that {reason}; "
            "use a smaller one, or None to adapt it"
        )
    speed = scenery.wall_speed(case)
    if dt is not None and speed * dt > LEAP * case.numerics.spacing:
        yield (f"numerics.time_step = {dt:g} s: a wall at its greatest speed of {speed:.3g} m/s moves "
               f"{speed * dt / case.numerics.spacing:.2g} spacings in a step, at most {LEAP:g}; use at most "
               f"{LEAP * case.numerics.spacing / speed:.2g} s, or None to adapt it")
    for name, value in (("numerics.time_step", dt), ("numerics.max_time_step", case.numerics.max_time_step)):
        if value is not None and value > case.end_time:
            yield f"{name} = {value:g} s: is longer than the run, end_time = {case.end_time:g} s"
    for time in case.output.times:
        if time > case.end_time:
            yield (
                f"output.times: {time:g} s is after the end of the run, end_time = {case.end_time:g} s; "
                "leave it out or run longer"
            )


def _steps(case: Scene) -> Iterator[str]:
    """A run of more than MOST_STEPS steps is a mistake."""
    dt, why = min(_time_steps(case), key=lambda item: item[0])
    if case.end_time > MOST_STEPS * dt:
        yield (
            f"{why} takes steps of {dt:.2g} s: some {case.end_time / dt:.1e} of them until end_time "
            f"= {case.end_time:g} s, at most {MOST_STEPS:g} can be computed; change that, or run shorter"
        )


def _time_steps(case: Scene) -> Iterator[tuple[float, str]]:
    """Yield the time steps [s] that a case requires, each with the field that requires it and the reason."""
    n, frame = case.numerics.resolved(), case.frame
    if n.time_step is not None:
        yield n.time_step, f"numerics.time_step = {n.time_step:g} s"
        return
    limit, reason = time_scales.stable_time_step(case)
    yield limit, f"gravity, fluid.velocity and numerics.spacing: a step that {reason}"
    longest = scenery.longest_step(case)
    yield longest, (f"{'frame' if longest == frame.longest_step else 'walls'}: {1 / SHARE:.0f} steps in a period of "
                    f"{longest / SHARE:.2g} s")
    speed = frame.top_speed(*case.wall_bounds) if case.wall_bounds is not None else 0.0
    if speed > 0.0:
        yield n.cfl * n.spacing / speed, f"frame: a tank that moves at {speed:.2g} m/s"
    wall = scenery.wall_speed(case)
    if wall > 0.0:
        yield n.cfl * n.spacing / wall, f"walls: one that moves at {wall:.2g} m/s"
    if n.max_time_step is not None:
        yield n.max_time_step, f"numerics.max_time_step = {n.max_time_step:g} s"


def _files(case: Scene) -> Iterator[str]:
    for name, every in (("every", case.output.every), ("checkpoint_every", case.output.checkpoint_every)):
        if every is not None and case.end_time > MOST_FILES * every:
            yield (
                f"output.{name} = {every:g} s: makes {case.end_time / every:.1e} files until end_time "
                f"= {case.end_time:g} s, at most {MOST_FILES:g} are written; use a longer time"
            )
    interval = case.output.probe_interval
    if interval is not None and case.end_time > MOST_SAMPLES * interval:
        yield (
            f"output.probe_interval = {interval:g} s: takes {case.end_time / interval:.1e} samples until "
            f"end_time = {case.end_time:g} s, at most {MOST_SAMPLES:g} are written; use a longer time"
        )
