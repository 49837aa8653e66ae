"""The output of `parisph check`: particles, resolution, stages, steps, time, memory."""

import math
from collections.abc import Iterator, Mapping
from typing import Any

from parisph.base import memory, vocabulary
from parisph.base.text import point
from parisph.case import scales, size
from parisph.case.bodies import motion_of
from parisph.case.motion import AtRest
from parisph.case.numerics import WORDS, ResolvedNumerics
from parisph.case.scenery import body_names
from parisph.case.schema import Case
from parisph.case.waves import Jonswap, SolitaryWave
from parisph.driver import cost, precheck
from parisph.driver.estimate import duration, estimated_steps, longest_of, rounded, stable_step, waves_of
from parisph.driver.sketch import sketch
from parisph.geometry import build, scene_checks

DRAWN = 10**7    # particles: a drawing of a larger scene takes too much memory for its walls


def describe(case: Case, parameters: Mapping[str, Any] | None = None) -> str:
    """Return the description of a case as text. Needs neither MPI nor compiled kernels.

    parameters : {name: value} of the case file (case.load.arguments)
    """
    precheck.check(case)
    numerics = case.numerics.resolved()
    count = build.counts(case)
    expected = scales.expected(case)
    steps = estimated_steps(case, numerics, expected)
    seconds, basis = cost.seconds_per_step(numerics, count["all"], case.dim)
    step = f"{rounded(1e3 * seconds)} ms" if seconds < 1.0 else duration(seconds)
    lines = [
        ("case", case.title),
        ("method", f"{numerics.method}, preset {numerics.preset}"),
        ("particles", f"{count['all']} ({count['fluid']} fluid, "
                      f"{count['wall']} wall), spacing {numerics.spacing:g} m"),
        ("resolution", _resolution(case)),
        *_waves(case, expected, steps),
        *_geometry(case),
        *_friction(case),
        ("stages", ", ".join(precheck.stages(case))),
        ("end time", f"{case.end_time:g} s"),
        ("steps", _steps(case, numerics, steps)),
        ("time", f"about {duration(steps * seconds)} on one rank, {step} a step (estimated from {basis})"),
        ("memory", _memory(count["all"], case.dim)),
        ("probes", ", ".join(probe.name for probe in case.probes) or "none"),
    ]
    lines += [("warning", text) for text in precheck.warnings(case, count, expected)]
    if count["all"] <= DRAWN:
        lines.append(("scene", sketch(case).replace("\n", f"\n{'':<12}")))
    if parameters:
        lines.append(("--set", ", ".join(f"{name}={_text(name, value)}" for name, value in parameters.items())))
    return "\n".join(f"{name:<12}{text}" for name, text in lines)


def _geometry(case: Case) -> Iterator[tuple[str, str]]:
    """Yield the lines about walls and filling of a scene."""
    moving = {name: type(motion_of(body)).__name__ for name, body in zip(body_names(case.bodies), case.bodies)
              if not isinstance(motion_of(body), AtRest)}
    known = scene_checks.facts(case)
    if known is None:
        return
    names = [f"{name} ({moving[name]})" if name in moving else name for name in body_names(case.bodies)]
    names += [surface.name for surface in case.surfaces]
    yield "walls", f"{', '.join(names)}: {known.elements} elements"
    s = case.numerics.spacing
    between = " and ".join(dict.fromkeys(known.between))
    between += f", at {point(known.at)} m" if known.at else ""
    gap = (f"thinnest gap {known.gap:.3g} m, {known.gap / s:.3g} spacings, between {between}"
           if math.isfinite(known.gap) else "no wall faces another")
    yield "gaps", gap + (f"; sharpest wedge {known.wedge:.3g} degrees" if known.wedge < 180.0 else "")
    yield "volume", (f"{known.volume:.6g} m{case.dim} exactly; the lattice has {known.lattice:.6g} "
                     f"({100.0 * (known.lattice / known.volume - 1.0):+.1f} %) before its particles get their own")


def _friction(case: Case) -> Iterator[tuple[str, str]]:
    """Yield the values of the friction on walls."""
    if case.friction is not None:
        law = case.friction
        yield "friction", (f"on free-slip walls: viscosity {law.viscosity:g} m2/s, "
                           f"roughness {law.roughness:g} m")


def _memory(particles: int, dim: int) -> str:
    need, there = size.memory(particles, 1, dim), memory.total()
    text = f"about {memory.amount(need)} on one rank"
    if there is not None and need > there:
        text += f", more than the {memory.amount(there)} of this machine: the case needs a larger one, or several"
    return text


def _text(name: str, value: Any) -> str:
    """Return the value of a parameter in the form that --set accepts."""
    if isinstance(value, (tuple, list)):
        return ",".join(_text(name, item) for item in value)
    if value is None:    # for some fields "none" is a name
        return "" if name in WORDS and "none" in vocabulary.known(WORDS[name]) else "none"
    return f"{value:.15g}" if isinstance(value, float) else str(value)


def _steps(case: Case, n: ResolvedNumerics, steps: int) -> str:
    if n.time_step is not None:
        shorter = stable_step(case) < n.time_step
        step = min(n.time_step, stable_step(case))
        return f"{'about ' * shorter}{steps} of {step:.3g} s" + ", which is stable" * shorter
    longest = longest_of(case, n)
    limits = f"at most {n.cfl:g} spacings a step" + (f" and {longest:.3g} s" if longest < math.inf else "")
    return f"about {rounded(steps)}, adaptive: {limits}"


def _resolution(case: Case) -> str:
    """Return the lengths of the scene in spacings, as text."""
    s = case.numerics.spacing
    lower, upper = case.fluid_bounds
    lengths = upper - lower
    found = [f"fluid {' x '.join(f'{length / s:.3g}' for length in lengths)} spacings"]
    if case.tank is not None and case.tank.width != lengths[0]:
        found.append(f"tank {case.tank.width / s:.3g} wide")
    if case.breadth is not None:
        found.append(f"breadth {(case.breadth[1] - case.breadth[0]) / s:.3g}")
    return ", ".join(found)


def _waves(case: Case, expected: scales.Scales, steps: int) -> Iterator[tuple[str, str]]:
    """Yield the sizes of the waves in spacings, and their steps per period."""
    s = case.numerics.spacing
    for wave in waves_of(case, expected):
        irregular, alone = isinstance(wave.wave, Jonswap), isinstance(wave.wave, SolitaryWave)
        yield "wave", (f"{wave.name}, {'significant ' * irregular}height {wave.height:.3g} m ({wave.height / s:.2g} "
                       f"spacings), {'peak ' * irregular}length {wave.length:.3g} m ({wave.length / s:.3g}), depth "
                       f"{wave.depth:.3g} m ({wave.depth / s:.3g}), about "
                       f"{rounded(wave.period * steps / case.end_time)} steps "
                       f"{'while it travels its length' if alone else f'in a period of {wave.period:.3g} s'}")
