"""Faults and warnings of a case before it is run, for `parisph check` and for a run."""

from collections.abc import Iterator, Mapping
from typing import Any

from parisph.base.errors import CaseError
from parisph.case import doubtful, scales
from parisph.case.bodies import Flap
from parisph.case.faults import first_lines
from parisph.case.schema import Case
from parisph.case.time_scales import stable_time_step
from parisph.driver import cost, estimate
from parisph.geometry import scene_checks
from parisph.methods import catalogue, velocities

LONG = 1.25              # times the estimated limit: a longer fixed step gets a warning
MONTH = 30.0 * 86400.0   # [s]: a longer run gets a warning


def check(case: Case) -> None:
    """Raise CaseError if the geometry or the method of a case cannot be computed. Not collective."""
    scene_checks.check(case)
    found = [*estimate.faults(case)]
    if found:
        raise CaseError(first_lines(found))
    parts_of(case).check(case.dim)


def parts_of(case: Case) -> Any:
    """Return the parts of the method of a case. Raises CaseError."""
    return catalogue.parts_of(case.complete_numerics(), case.physics)


def stages(case: Case) -> list[str]:
    """Return the names of the stages that a step of this case has, in order."""
    names: list[str] = parts_of(case).stages(case.closed)
    return names


def warnings(case: Case, count: Mapping[str, int], expected: scales.Scales) -> Iterator[str]:
    """Yield the warnings of `parisph check`, one line each: about the method, the scene, and doubtful values.

    count : geometry.build.counts of the case; expected : its case.scales.Scales
    """
    if catalogue.warning(case.numerics):
        yield f"method {case.numerics.method}: {catalogue.warning(case.numerics)}"
    yield from catalogue.unread(case.numerics)
    yield from scene_checks.warnings(case)
    yield from _about_the_step(case)
    yield from _about_flaps(case)
    yield from early_warnings(case, count, expected)


def _about_the_step(case: Case) -> Iterator[str]:
    """Warn of a fixed step that is too long for waves or the fastest fluid, unless viscosity or sound shortens it."""
    (limit, reason), dt = stable_time_step(case), case.numerics.time_step
    if dt is not None and LONG * limit < min(dt, estimate.stable_step(case)):
        yield (f"numerics.time_step = {dt:.3g} s is {dt / limit:.3g} times the step of {limit:.3g} s that {reason}: "
               "the flow may be wrong or diverge; give a shorter one, or None to adapt it")


def _about_flaps(case: Case) -> Iterator[str]:
    """Warn of a flap without collisions of pairs, in whose corner particles are caught."""
    flaps = any(isinstance(body, Flap) for body in case.bodies)
    if flaps and velocities.Collisions.words not in stages(case):
        yield ("walls: particles are caught in the corner between a Flap and the bed, and burst out of it, if no pairs "
               "of them collide; set numerics.collision_distance=0.7 and restitution=0.2, and leave collisions in "
               "numerics.regularisers")


def early_warnings(case: Case, count: Mapping[str, int], expected: scales.Scales, ranks: int = 1) -> Iterator[str]:
    """Yield warnings of doubtful values and of a long run, one line each.

    ranks : number of ranks that share the work
    """
    yield from doubtful.doubts(case, estimate.waves_of(case, expected))
    yield from scene_checks.airless(case)
    numerics = case.numerics.resolved()
    steps = estimate.estimated_steps(case, numerics, expected)
    seconds = steps * cost.seconds_per_step(numerics, count["all"], case.dim)[0] / ranks
    if seconds > MONTH:
        yield (f"the run would take about {estimate.duration(seconds)} on {ranks} rank{'s' * (ranks > 1)}, "
               f"{estimate.rounded(steps)} steps of {count['all']:,} particles: use a larger spacing, a shorter "
               "end_time, or more ranks")
    step, every = case.end_time / max(steps, 1), case.output.every
    if every is not None and every < step:
        yield (f"output.every = {every:g} s: is shorter than a step, about {estimate.rounded(step)} s: "
               f"{case.end_time / every:.2g} snapshots would show one of each step at most; use a longer time")
