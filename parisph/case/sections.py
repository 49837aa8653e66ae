"""Sections of a 3D scene: the 2D scenes of the planes across it, of which it is made.

All bodies of a 3D scene are prisms across it, so it is one 2D scene between two cuts.
"""

import re
from typing import Any, TypeVar

import numpy as np

from parisph.base.arrays import Floats
from parisph.case.bodies import Body, Obstacle, Profile
from parisph.case.breadth import Spread, flat
from parisph.case.ellipsoid import Ellipsoid
from parisph.case.fluids import Fluid
from parisph.case.lattice import FIT
from parisph.case.motion import AtRest, Motion, Spatial, Translation, leaves_section
from parisph.case.scene import Scene
from parisph.case.scenery import body_names
from parisph.case.shapes import ENDS, Box, Shape, Tank
from parisph.case.waves.wavefield import InSection

AnyScene = TypeVar("AnyScene", bound=Scene)


def cuts(case: Scene, fluids: bool = False) -> Floats:
    """Return the places (n + 1,) [m], ascending, that part a 3D scene across into n intervals of one section each.

    They are its ends y0 and y1 and the ends between them of bodies, and of fluids too if `fluids`. Ends nearer than FIT
    spacings count as one.
    """
    whole = case.breadth
    assert whole is not None
    parts: list[Spread | Fluid] = [*case.bodies, *(case.fluids if fluids else ())]
    if fluids:
        parts += [hole for fluid in case.fluids for hole in fluid.holes]
    slack, found = FIT * case.numerics.spacing, [whole[0]]
    for end in sorted(end for part in parts for end in part.extent or ()):
        if found[-1] + slack < end < whole[1] - slack:
            found.append(end)
    return np.array([*found, whole[1]])


def bodies_across(case: Scene, lower: float, upper: float) -> list[int]:
    """Return the numbers of the bodies whose extent contains lower to upper [m]."""
    return [number for number, body in enumerate(case.bodies) if _spans(case, body, lower, upper)]


def fluids_across(case: Scene, lower: float, upper: float) -> list[int]:
    """Return the numbers of the fluids whose extent contains lower to upper [m]."""
    return [number for number, fluid in enumerate(case.fluids) if _spans(case, fluid, lower, upper)]


def section(case: AnyScene, lower: float, upper: float) -> AnyScene:
    """Return the 2D scene of all bodies, holes and fluids whose extent contains lower to upper [m].

    With lower = upper it is that of the cut plane, in which bodies of both sides are present. Bodies have the names
    that they have in the whole scene. Expressions are those at the middle. There are no probes. Fluids may be missing.
    """
    y, names = 0.5 * (lower + upper), body_names(case.bodies)
    fluids = tuple(_fluid_in(case, case.fluids[number], lower, upper) for number in fluids_across(case, lower, upper))
    alone = len(fluids) == 1 and isinstance(case.fluid, Fluid)
    walls = tuple(_body_in(case.bodies[number]).model_copy(update={"name": names[number]})
                  for number in bodies_across(case, lower, upper))
    return case.model_copy(update={
        "fluid": fluids[0] if alone else fluids, "walls": walls or None, "frame": projected(case.frame), "probes": (),
        "gravity": tuple(in_section(part, y) for part in flat(case.gravity))})


def sections(case: AnyScene) -> list[tuple[float, float, AnyScene]]:
    """Return lower and upper end [m] and scene of each interval between the cuts of bodies and fluids."""
    ends = cuts(case, fluids=True).tolist()
    return [(low, high, section(case, low, high)) for low, high in zip(ends, ends[1:])]


def richest(case: AnyScene) -> tuple[float, float, AnyScene]:
    """Return lower and upper end [m] and scene of the section with fluid and most bodies; of these the broadest."""
    return max(sections(case), key=lambda part: (bool(part[2].fluids), len(part[2].bodies) + len(part[2].fluids),
                                                 part[1] - part[0]))


def in_section(component: float | str, y: float) -> float | str:
    """Return a number, or an expression of x, y, z in which z is called y and y is a number [m]."""
    if not isinstance(component, str):
        return component
    return re.sub(r"\bz\b", "y", re.sub(r"\by\b", f"({y!r})", component))


def projected(motion: Motion) -> Motion:
    """Return the part in the section of a motion of a 3D scene: at rest for one across, or out of the section."""
    if isinstance(motion, Spatial):
        return AtRest()
    if not isinstance(motion, Translation) or len(motion.direction) == 2:
        return motion
    way = flat(motion.direction)
    share = float(np.linalg.norm(way) / np.linalg.norm(motion.direction))
    if share == 0.0:
        return AtRest()
    sizes: dict[str, Any] = {}
    if getattr(motion, "series", None) is not None:
        series = motion.series    # type: ignore[attr-defined]
        sizes["series"] = series.model_copy(update={"values": tuple(share * value for value in series.values)})
    elif hasattr(motion, "amplitude"):
        sizes["amplitude"] = share * motion.amplitude
    elif hasattr(motion, "values"):
        sizes["values"] = tuple(share * value for value in motion.values)
    return motion.model_copy(update={"direction": way, **sizes})


def _spans(case: Scene, part: Spread | Fluid, lower: float, upper: float) -> bool:
    """Return whether a part reaches from lower to upper [m], within FIT spacings."""
    low, high = case.extent_of(part) or (lower, upper)
    slack = FIT * case.numerics.spacing
    return low <= lower + slack and upper <= high + slack


def _shape_in(shape: Any, y: float = 0.0) -> Any:
    """Return the section of a shape, of an Ellipsoid that at y [m]; StillWater is its own."""
    if isinstance(shape, Ellipsoid):
        return shape.section(y)
    if not isinstance(shape, Spread):
        return shape
    if isinstance(shape, Box):
        return shape.model_copy(update={"at": flat(shape.at), "breadth": None})
    return shape.model_copy(update={"across": None})


def _body_in(body: Body) -> Body:
    """Return the section of a body."""
    changes: dict[str, Any] = {}
    if isinstance(body, Tank):
        changes.update(at=flat(body.at), breadth=None)
        if isinstance(body.no_slip, tuple):
            changes["no_slip"] = tuple(side for side in body.no_slip if side not in ENDS)
    else:
        changes["across"] = None
    if isinstance(body, Obstacle):
        changes["shape"] = _shape_in(body.shape)
    if isinstance(body, Profile):
        changes["breadth"] = None
    if body.motion is not None and not leaves_section(body.motion):    # one that does keeps its motion, not its part
        changes["motion"] = projected(body.motion)
    return body.model_copy(update=changes)


def _fluid_in(case: Scene, fluid: Fluid, lower: float, upper: float) -> Fluid:
    """Return the section of a body of fluid, with its velocity and elevation at the middle of lower and upper [m]."""
    y = 0.5 * (lower + upper)
    elevation = fluid.elevation if fluid.elevation is None else in_section(fluid.elevation, y)
    velocity = tuple(in_section(part, y) for part in flat(fluid.velocity))
    holes: tuple[Shape, ...] = tuple(_shape_in(hole) for hole in fluid.holes if _spans(case, hole, lower, upper))
    wave = InSection(of=fluid.wave, y=y) if fluid.wave is not None and fluid.wave.varies_across else fluid.wave
    return fluid.model_copy(update={"shape": _shape_in(fluid.shape, y), "velocity": velocity, "elevation": elevation,
                                    "holes": holes, "wave": wave})
