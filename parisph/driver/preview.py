"""The output of `parisph check`: particles, resolution, stages, steps, time, memory."""

import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from parisph.base import memory, vocabulary
from parisph.case import scales, size
from parisph.case.bodies import motion_of
from parisph.case.checks import flow_length, sound_speed, stable_time_step
from parisph.case.methods import METHODS
from parisph.case.motion import AtRest
from parisph.case.numerics import WORDS, Numerics
from parisph.case.scenery import body_names, longest_step, wall_speed
from parisph.case.schema import Case
from parisph.driver import cost
from parisph.driver.sketch import sketch
from parisph.geometry import build, plain, scene_checks
from parisph.kernels import viscous, weakly
from parisph.methods import catalogue, lengths, velocities

DRAWN = 10**7    # particles: larger scenes are not drawn, which takes memory for all their walls
BRISK, IMPACT = 1.5, 1.25    # as in methods.timestep, which needs MPI
LONG = 1.25    # times the estimated limit: a fixed step that is warned of


def describe(case: Case, parameters: Mapping[str, Any] | None = None) -> str:
    """Return the description as text. Needs neither MPI nor compiled kernels.

    parameters : {name: value} of the case file (case.load.arguments), which --set can change
    """
    scene_checks.check(case)
    _parts(case).check(case.dim, case.plain)
    numerics = case.numerics.resolved()
    count = build.counts(case)
    expected = scales.expected(case)
    steps = estimated_steps(case, numerics, expected)
    seconds, basis = cost.seconds_per_step(numerics, count["all"])
    lines = [
        ("case", case.title),
        ("method", f"{numerics.method}, preset {numerics.preset}"),
        ("particles", f"{'' if count['exact'] else 'about '}{count['all']} ({count['fluid']} fluid, "
                      f"{count['wall']} wall), spacing {numerics.spacing:g} m"),
        ("resolution", _resolution(case, expected)),
        *_geometry(case),
        *_friction(case),
        ("stages", ", ".join(stages(case))),
        ("end time", f"{case.end_time:g} s"),
        ("steps", _steps(case, numerics, steps)),
        ("time", f"about {duration(steps * seconds)} on one rank, {_rounded(1e3 * seconds)} ms a step (estimated "
                 f"from {basis})"),
        ("memory", _memory(count["all"])),
        ("probes", ", ".join(probe.name for probe in case.probes) or "none"),
    ]
    lines += [("warning", text) for text in _warnings(case, count)]
    if count["all"] <= DRAWN:
        lines.append(("scene", sketch(case).replace("\n", f"\n{'':<12}")))
    if parameters:
        lines.append(("--set", ", ".join(f"{name}={_text(name, value)}" for name, value in parameters.items())))
    return "\n".join(f"{name:<12}{text}" for name, text in lines)


def _geometry(case: Case) -> Iterator[tuple[str, str]]:
    """Yield what there is to say about walls and filling of a scene that is not plain."""
    if case.plain:
        return
    moving = {name: type(motion_of(body)).__name__ for name, body in zip(body_names(case.bodies), case.bodies)
              if not isinstance(motion_of(body), AtRest)}
    known = scene_checks.facts(case)
    if known is None:
        return
    names = [f"{name} ({moving[name]})" if name in moving else name for name in body_names(case.bodies)]
    yield "walls", f"{', '.join(names)}: {known.elements} elements"
    s = case.numerics.spacing
    gap = (f"thinnest gap {known.gap:.3g} m, {known.gap / s:.3g} spacings, between {' and '.join(known.between)}"
           if math.isfinite(known.gap) else "no wall faces another")
    yield "gaps", gap + (f"; sharpest wedge {known.wedge:.3g} degrees" if known.wedge < 180.0 else "")
    yield "volume", (f"{known.volume:.6g} m2 exactly; the lattice has {known.lattice:.6g} "
                     f"({100.0 * (known.lattice / known.volume - 1.0):+.1f} %) before its particles get their own")


def _friction(case: Case) -> Iterator[tuple[str, str]]:
    """Yield the values of the friction on walls."""
    if case.friction is not None:
        law = case.friction
        yield "friction", (f"on walls that fluid slips along: viscosity {law.viscosity:g} m2/s, "
                           f"roughness {law.roughness:g} m")


def _warnings(case: Case, count: Mapping[str, int]) -> Iterator[str]:
    """Warn of a method's limits, and of water without a free surface, which the initial lattice already shows."""
    if catalogue.warning(case.numerics):
        yield f"method {case.numerics.method}: {catalogue.warning(case.numerics)}"
    yield from catalogue.unread(case.numerics)
    yield from scene_checks.warnings(case)
    yield from _about_the_step(case)
    yield from _about_flaps(case)
    if not case.closed and count["exact"] and case.plain and not plain.lattice(case).has_surface():
        yield (f"none of the {count['fluid']} fluid particles is on a free surface, "
               "so p = 0 is set only at the highest one; leave a spacing of air, "
               "or fill the tank with a Box of its size, without elevation")


def _about_the_step(case: Case) -> Iterator[str]:
    """Warn of a fixed step clearly longer than waves or the fastest fluid allow, unless it is shortened in the run."""
    (limit, reason), dt = stable_time_step(case), case.numerics.time_step
    if dt is not None and LONG * limit < min(dt, stable_step(case)):
        yield (f"numerics.time_step = {dt:.3g} s is {dt / limit:.3g} times the step of {limit:.3g} s that {reason}: "
               "the flow may be wrong or diverge; give a shorter one, or None to adapt it")


def _about_flaps(case: Case) -> Iterator[str]:
    """Warn of a flap in whose corner particles are caught, as nothing keeps pairs of them apart."""
    flaps = [body for body in case.bodies if body.kind == "flap"]
    if flaps and velocities.Collisions.words not in stages(case):
        yield ("walls: particles are caught in the corner between a Flap and the bed, and burst out of it, if no pairs "
               "of them collide; set numerics.collision_distance=0.7 and restitution=0.2, and leave collisions in "
               "numerics.regularisers")


def _memory(particles: int) -> str:
    need, there = size.memory(particles), memory.total()
    text = f"about {memory.amount(need)} on one rank"
    if there is not None and need > there:
        text += f", more than the {memory.amount(there)} of this machine: the case needs a larger one, or several"
    return text


def stages(case: Case) -> list[str]:
    """Return the names of the stages that a step of this case has, in order."""
    names: list[str] = _parts(case).stages(case.closed)
    return names


def _parts(case: Case) -> Any:
    return catalogue.parts_of(case.complete_numerics(), case.physics)


def _text(name: str, value: Any) -> str:
    """Return the value of a parameter in the form that --set accepts."""
    if isinstance(value, (tuple, list)):
        return ",".join(_text(name, item) for item in value)
    if value is None:    # "none" is a word where it is one
        return "" if name in WORDS and "none" in vocabulary.known(WORDS[name]) else "none"
    return f"{value:.15g}" if isinstance(value, float) else str(value)


def estimated_steps(case: Case, numerics: Numerics, expected: scales.Scales) -> int:
    """Return the number of steps: exact if the step is fixed, else an estimate, good to a factor of two or so.

    numerics : resolved Numerics; expected : scales.Scales of the case
    """
    if numerics.time_step is not None:
        return round(case.end_time / min(numerics.time_step, stable_step(case)))
    assert numerics.cfl is not None    # it is resolved
    move = numerics.cfl * numerics.spacing
    fall = math.sqrt(2.0 * move / expected.force) if expected.force else math.inf
    longest = min(_longest_step(case, numerics), fall, case.end_time)
    if numerics.wave_step and expected.force:
        longest = min(longest, numerics.wave_step * math.sqrt(numerics.spacing / expected.force))
    # see methods.timestep.next_step; in a flow without a force, the mean acceleration is about a third of the largest
    brisk = np.minimum(BRISK * expected.accelerations, expected.force or IMPACT / 3.0 * expected.accelerations)
    rates = [expected.speeds / move, np.full(len(expected.times), 1.0 / longest)]
    if numerics.fall:
        rates.append(np.sqrt(brisk / flow_length(case)) / numerics.fall)
    return math.ceil(case.end_time * float(np.mean(np.max(rates, axis=0))))


def stable_step(case: Case) -> float:
    """Return the longest step [s] that viscosity, or the sound of weakly compressible fluid, allows; infinite without
    them."""
    n, s = case.numerics, case.numerics.spacing
    if METHODS[n.method].step == "compressible":
        return weakly.longest_step(lengths.SPH * s, sound_speed(case), 0.0, n.artificial_viscosity, 0.0)
    return viscous.STABLE * s * s / case.viscosity if case.viscosity else math.inf


def _longest_step(case: Case, n: Numerics) -> float:
    """Return the longest step [s] that the case allows, whatever the flow."""
    by_walls = n.cfl * n.spacing / wall_speed(case) if n.cfl and wall_speed(case) > 0.0 else math.inf
    return min(longest_step(case), by_walls, n.max_time_step or math.inf, stable_step(case))


def _steps(case: Case, n: Numerics, steps: int) -> str:
    if n.time_step is not None:
        shorter = stable_step(case) < n.time_step
        step = min(n.time_step, stable_step(case))
        return f"{'about ' * shorter}{steps} of {step:.3g} s" + ", which is stable" * shorter
    longest = _longest_step(case, n)
    limits = f"at most {n.cfl:g} spacings a step" + (f" and {longest:.3g} s" if longest < math.inf else "")
    return f"about {_rounded(steps)}, adaptive: {limits}"


def _resolution(case: Case, expected: scales.Scales) -> str:
    """Return the lengths of the scene in spacings, as text."""
    s = case.numerics.spacing
    lower, upper = case.fluid_bounds
    width, depth = (upper - lower)[[0, -1]]
    found = [f"fluid {width / s:.3g} x {depth / s:.3g} spacings"]
    if case.tank is not None and case.tank.width != width:
        found.append(f"tank {case.tank.width / s:.3g} wide")
    if expected.wave is not None:
        found.append(f"wave amplitude {expected.wave / s:.2g} spacings (about {expected.wave:.2g} m by linear theory)")
    return ", ".join(found)


def _rounded(number: float) -> str:
    """Return a number rounded to two digits, as text."""
    return f"{float(f'{number:.1e}'):.10g}"


def duration(seconds: float) -> str:
    """Return a time [s] for people, with two digits."""
    for unit, length in (("days", 86400.0), ("h", 3600.0), ("min", 60.0)):
        if seconds >= 2.0 * length:
            return f"{_rounded(seconds / length)} {unit}"
    return f"{_rounded(seconds)} s"
