"""Checks of what makes a scene 3D: its breadth, the extents of bodies and fluids in it, and its directions."""

from collections.abc import Iterator

import numpy as np

from parisph.base.text import rounded_down, shown
from parisph.case import motion_checks
from parisph.case.bodies import Body, Flap, Piston, Profile
from parisph.case.breadth import Spread, section_of
from parisph.case.ellipsoid import Ellipsoid
from parisph.case.lattice import FIT
from parisph.case.scene import Scene
from parisph.case.scenery import body_names, fluid_names
from parisph.case.sections import bodies_across, cuts
from parisph.case.shapes import Box, Tank
from parisph.case.wave_sizes import waves
from parisph.case.waves import TankMode

LEAST = 4.0     # spacings of breadth: in a narrower scene all fluid is beside the front or the back
NARROW = 2.0    # spacings: particles between nearer ends are beside both
TOGETHER = 0.5  # spacings: no elements fit between nearer ends
ACROSS = 1e-9   # of a direction: a smaller part along y is rounding


def problems(case: Scene) -> list[str]:
    """Return the problems of the dimensions of a case, one line each."""
    if case.breadth is None:
        return [*_without(case), *_expressions(case), *motion_checks.problems(case), *_directions(case)]
    found = [*_breadths(case), *_expressions(case), *motion_checks.problems(case), *_directions(case)]
    return found or [*_narrow(case), *_outside(case)] or [*_near(case), *_makers(case), *_fluids(case),
                                                          *motion_checks.clearances(case)]


def warnings(case: Scene) -> list[str]:
    """Return the warnings about the extents of bodies across a scene, one line each."""
    s = case.numerics.spacing
    return [f"walls, {' and '.join(between)}: only {gap:.3g} m are between their ends across, {gap / s:.2g} spacings: "
            f"flow between them needs {NARROW:g}; use a spacing of at most {rounded_down(gap / NARROW)}, or let them "
            "touch" for gap, between in gaps(case) if gap < NARROW * s * (1.0 - FIT)]


def gaps(case: Scene) -> list[tuple[float, tuple[str, str]]]:
    """Return the distances across [m] between facing ends of bodies, with their names, the shortest first; none in 2D.

    The front and the back of the scene face all bodies and each other.
    """
    slack = FIT * case.numerics.spacing
    if case.breadth is None:
        return []
    ends: list[tuple[str, Body | None, tuple[float, float]]] = [
        ("the front", None, (-np.inf, case.breadth[0])), ("the back", None, (case.breadth[1], np.inf)),
        *((name, body, extent) for name, body in zip(body_names(case.bodies), case.bodies)
          if (extent := body.extent) is not None and not isinstance(body, Tank))]
    found = [(high[0] - low[1], (one, other)) for one, body, low in ends for other, beside, high in ends
             if high[0] - low[1] > slack and _beside(body, beside)]
    return sorted(found) if case.bodies else []


def _beside(one: Body | None, other: Body | None) -> bool:
    """Return whether the boxes of two bodies overlap in the section; None and wavemakers are beside all."""
    if one is None or other is None or isinstance(one, (Piston, Flap)) or isinstance(other, (Piston, Flap)):
        return True
    (low, high), (lower, upper) = (map(section_of, body.bounds) for body in (one, other))
    return bool(np.all((low <= upper) & (lower <= high)))


def _without(case: Scene) -> Iterator[str]:
    """What only 3D scenes have."""
    for name, part in _parts(case):
        if isinstance(part, Ellipsoid):
            yield (f"{name}: an Ellipsoid is for a 3D scene, and this one is 2D; give a Tank or a Profile a breadth, "
                   "or use a Disc")
        elif part.extent is not None or getattr(part, "breadth", None) is not None:
            field = "breadth" if isinstance(part, Box) or getattr(part, "breadth", None) is not None else "across"
            yield (f"{name}: {field} is for a 3D scene, and this one is 2D; leave it out, or "
                   + ("give a Tank or a Profile a breadth" if case.bodies else "give a Box of fluid a breadth"))


def _parts(case: Scene) -> Iterator[tuple[str, Spread]]:
    """Yield all bodies and all shapes of fluids and holes, with their names in messages."""
    for name, body in zip(body_names(case.bodies), case.bodies):
        yield f"walls, {name}", body
    for name, fluid in fluid_names(case):
        if isinstance(fluid.shape, Spread):
            yield f"{name}.shape", fluid.shape
        yield from ((f"{name}.holes[{number}]", hole) for number, hole in enumerate(fluid.holes))


def _directions(case: Scene) -> Iterator[str]:
    """Waves with a direction or across, where waves run along x only."""
    for name, wave in waves(case):
        if isinstance(wave, TankMode):
            if case.dim == 2:
                yield f"{name}: a TankMode is for a 3D scene, and this one is 2D; use StandingWave(length=, amplitude=)"
        elif wave.direction is not None and case.dim == 2:
            yield f"{name}.direction: is for a 3D scene, and this one is 2D; leave it out, or use leftward=True"
        elif wave.direction is not None and name.startswith("walls"):
            yield (f"{name}.direction = {shown(wave.direction)}: a wavemaker makes waves along x only; leave it out, "
                   "or make the wave by a Relaxation zone")


def _expressions(case: Scene) -> Iterator[str]:
    for name, fluid in fluid_names(case):
        yield from (f"{name}: {fault}" for fault in fluid.faults(case.dim))


def _breadths(case: Scene) -> Iterator[str]:
    """All bodies that give the breadth must give the same."""
    low, high = case.breadth or (0.0, 0.0)
    for name, body in zip(body_names(case.bodies), case.bodies):
        own = body.breadth if isinstance(body, (Tank, Profile)) else None
        if own is None and isinstance(body, Tank):
            yield (f"walls, {name}: has no breadth, and the scene has one of {high - low:g} m; give it "
                   f"breadth={high - low:g}")
        elif own is not None and abs(own - (high - low)) > FIT * case.numerics.spacing:
            other = ", or give its ends across=(ya, yb) instead" if isinstance(body, Profile) else ""
            yield (f"walls, {name}: breadth = {own:g}: must be that of the scene, {high - low:g} m; change one of "
                   f"them{other}")


def _narrow(case: Scene) -> Iterator[str]:
    low, high = case.breadth or (0.0, 0.0)
    s = case.numerics.spacing
    if high - low < LEAST * s * (1.0 - FIT):
        yield (f"breadth = {high - low:g} m: is {(high - low) / s:.2g} spacings, must be at least {LEAST:g}; use a "
               f"spacing of at most {rounded_down((high - low) / LEAST)}, or leave the breadth out for a scene in 2D")


def _outside(case: Scene) -> Iterator[str]:
    low, high = case.breadth or (0.0, 0.0)
    slack = FIT * case.numerics.spacing
    for name, part in _parts(case):
        own = part.extent
        if own is None or ".holes" in name or (own[0] >= low - slack and own[1] <= high + slack):
            continue
        yield (f"{name}: reaches across from y = {own[0]:g} to {own[1]:g}: must lie within the scene, from {low:g} to "
               f"{high:g}; move it, make it narrower, or enlarge the breadth")


def _near(case: Scene) -> Iterator[str]:
    """Ends of bodies too near for elements between them, but not together."""
    s, ends = case.numerics.spacing, cuts(case)
    for low, high in zip(ends[:-1], ends[1:]):
        if high - low < TOGETHER * s * (1.0 - FIT):
            yield (f"walls, {' and '.join(_ending(case, low, high))}: only {high - low:.3g} m are between the ends y = "
                   f"{low:g} and {high:g}, {(high - low) / s:.2g} spacings, and no wall elements fit there; let them "
                   f"end at the same y, or use a spacing of at most {rounded_down((high - low) / TOGETHER)}")


def _makers(case: Scene) -> Iterator[str]:
    """Wavemakers beside which fluid would come behind them: those of a side must reach across together."""
    named, ends = list(zip(body_names(case.bodies), case.bodies)), cuts(case).tolist()
    for on_left in (False, True):
        own = [(name, number) for number, (name, body) in enumerate(named)
               if isinstance(body, (Piston, Flap)) and body.fluid_on_left is on_left]
        free = [(low, high) for low, high in zip(ends, ends[1:])
                if own and not {number for _, number in own} & set(bodies_across(case, low, high))]
        for low, high in free[:1]:
            yield (f"walls, {own[0][0]}: a wavemaker has no fluid behind it, and beside this one, from y = {low:g} to "
                   f"{high:g}, fluid would come there; let it reach across the whole scene, or put others beside it")


def _fluids(case: Scene) -> Iterator[str]:
    """Bodies of fluid less than a spacing broad, or apart across, so that their particles would be too near."""
    s, named = case.numerics.spacing, list(fluid_names(case))
    for number, (name, fluid) in enumerate(named):
        own = fluid.extent
        if own is None:
            continue
        if own[1] - own[0] < s * (1.0 - FIT):
            yield (f"{name}.shape: is {own[1] - own[0]:.3g} m broad, {(own[1] - own[0]) / s:.2g} spacings, must be at "
                   f"least one; use a spacing of at most {rounded_down(own[1] - own[0])}, or make it broader")
        for title, other in named[:number]:
            beside = case.extent_of(other) or own
            gap = max(beside[0] - own[1], own[0] - beside[1])
            (low, high), (lower, upper) = (map(section_of, case.bounds_of(one)) for one in (fluid, other))
            if FIT * s < gap < s * (1.0 - FIT) and np.all((low <= upper) & (lower <= high)):
                yield (f"{name} and {title}: they are {gap:.3g} m apart across, {gap / s:.2g} spacings; let them "
                       f"touch, leave a spacing between them, {s:g} m, or use a spacing of at most {rounded_down(gap)}")


def _ending(case: Scene, low: float, high: float) -> list[str]:
    """Return the names of bodies with an end at one of two places [m]."""
    slack = FIT * case.numerics.spacing
    return [name for name, body in zip(body_names(case.bodies), case.bodies)
            if body.extent is not None and not isinstance(body, Tank)
            and min(abs(end - at) for end in body.extent for at in (low, high)) <= slack]
