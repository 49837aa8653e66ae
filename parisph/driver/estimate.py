"""Estimates of the number and length of the steps of a case."""

import math
from collections.abc import Iterator

import numpy as np

from parisph.case import scales
from parisph.case.methods import METHODS
from parisph.case.numerics import ResolvedNumerics
from parisph.case.scenery import longest_step, wall_speed
from parisph.case.schema import Case
from parisph.case.time_checks import MOST_STEPS
from parisph.case.time_scales import flow_length, sound_speed
from parisph.case.wave_sizes import Size, sizes, strain_rate
from parisph.kernels import viscous, weakly
from parisph.methods import lengths
from parisph.methods.step_numbers import BRISK, IMPACT, WAVE_LEAST, WAVE_STRAIN


def waves_of(case: Case, expected: scales.Scales) -> list[Size]:
    """Return the Size of each wave of a case, else of the expected wave by linear theory."""
    found = sizes(case)
    return found + ([expected.wave] if expected.wave is not None and not found else [])


def faults(case: Case) -> Iterator[str]:
    """Yield a fault if the steps of viscous fluid make a run endless (see also case.time_checks)."""
    n, limit = case.numerics.resolved(), stable_step(case)
    if METHODS[n.method].step != "compressible" and case.end_time > MOST_STEPS * limit:
        most = 0.95 * viscous.STABLE * n.spacing**2 * MOST_STEPS / case.end_time    # allows for rounding
        yield (f"fluid.viscosity = {case.viscosity:g} m2/s: takes steps of {limit:.2g} s to be stable, some "
               f"{case.end_time / limit:.1e} of them until end_time = {case.end_time:g} s, at most {MOST_STEPS:g} can "
               f"be computed; use at most {most:.2g} (water has 1e-6), a larger spacing, or run shorter")


def estimated_steps(case: Case, numerics: ResolvedNumerics, expected: scales.Scales) -> int:
    """Return the number of steps: exact for a fixed step, else an estimate within a factor of about two."""
    if numerics.time_step is not None:
        return round(case.end_time / min(numerics.time_step, stable_step(case)))
    move = numerics.cfl * numerics.spacing
    fall = math.sqrt(2.0 * move / expected.force) if expected.force else math.inf
    longest = min(longest_of(case, numerics), fall, case.end_time)
    if numerics.wave_step and expected.force:
        longest = min(longest, numerics.wave_step * math.sqrt(numerics.spacing / expected.force))
    # see methods.timestep.next_step; in a flow without a force, the mean acceleration is about a third of the largest
    brisk = np.minimum(BRISK * expected.accelerations, expected.force or IMPACT / 3.0 * expected.accelerations)
    least = max(1.0 / longest, _by_strain(case, numerics, expected))
    rates = [expected.speeds / move, np.full(len(expected.times), least)]
    if numerics.fall:
        rates.append(np.sqrt(brisk / flow_length(case)) / numerics.fall)
    return math.ceil(case.end_time * float(np.mean(np.max(rates, axis=0))))


def _by_strain(case: Case, n: ResolvedNumerics, expected: scales.Scales) -> float:
    """Return the steps per second [1/s] that the strain of waves requires (methods.timestep)."""
    if not n.wave_step:
        return 0.0
    lower, upper = case.fluid_bounds
    rate = max((strain_rate(size, float(upper[0] - lower[0])) for size in waves_of(case, expected)), default=0.0)
    least = WAVE_LEAST * n.wave_step * math.sqrt(n.spacing / expected.force) if expected.force else 0.0
    return 1.0 / max(WAVE_STRAIN / rate, least) if rate else 0.0


def stable_step(case: Case) -> float:
    """Return the longest step [s] for viscosity, or for the sound of weakly compressible fluid; infinite without
    them."""
    n, s = case.numerics, case.numerics.spacing
    if METHODS[n.method].step == "compressible":
        return weakly.longest_step(lengths.SPH * s, sound_speed(case), 0.0, n.artificial_viscosity, 0.0)
    return viscous.STABLE * s * s / case.viscosity if case.viscosity else math.inf


def longest_of(case: Case, n: ResolvedNumerics) -> float:
    """Return the longest step [s] of a case that does not depend on the flow."""
    by_walls = n.cfl * n.spacing / wall_speed(case) if n.cfl and wall_speed(case) > 0.0 else math.inf
    return min(longest_step(case), by_walls, n.max_time_step or math.inf, stable_step(case))


def rounded(number: float) -> str:
    """Return a number rounded to two digits, as text."""
    return f"{float(f'{number:.1e}'):.10g}"


def duration(seconds: float) -> str:
    """Return a time [s] as text in a suitable unit, with two digits."""
    for unit, length in (("days", 86400.0), ("h", 3600.0), ("min", 60.0)):
        if seconds >= 2.0 * length:
            return f"{rounded(seconds / length)} {unit}"
    return f"{rounded(seconds)} s"
