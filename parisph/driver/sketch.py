"""A text drawing of a scene, for `parisph check`."""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from parisph.base.arrays import Floats
from parisph.case.motion import AtRest
from parisph.case.probes import AnyProbe
from parisph.case.scene import Scene
from parisph.case.sections import richest, sections
from parisph.geometry.build import domain, fillings
from parisph.geometry.solid import in_fluid, solid_of
from parisph.geometry.standing import standing

Picture = NDArray[np.str_]

ACROSS, MOST_UP, LEAST_UP = 84, 20, 6    # characters
TALL = 2.0                               # height over width of a character
WATER, AIR, SOLID, WALL = "~", " ", "#", "+"


def sketch(case: Scene) -> str:
    """Return the scene at the start as lines of text: water ~, solid #, thin and moving walls +, probes 1, 2, ...

    x and y have the same scale unless the scene is too long; the last line gives the vertical scale then. Of a 3D scene
    the section with most bodies is drawn, with all probes, and its place across is told.
    """
    if case.breadth is None:
        return _drawn(case, case.probes, "y")
    low, high, scene = richest(case)
    (front, back), many = case.breadth, len(sections(case))
    whole = f"breadth {back - front:g} m, from y = {front:g} to {back:g} m"
    left_out = f", without {', '.join(surface.name for surface in case.surfaces)}" if case.surfaces else ""
    return "\n".join([_drawn(scene, case.probes, "z"), whole + (
        f"; this is the section from y = {low:g} to {high:g} m, one of {many}" if many > 1 else
        ", alike all across" if not left_out and not any(fluid.varies_across for fluid in case.fluids) else "")
        + left_out])


def _drawn(case: Scene, probes: Sequence[AnyProbe], upwards: str) -> str:
    """Return the drawing of a 2D scene. upwards : name of the axis that points up"""
    lower, upper = (corner.copy() for corner in domain(case))
    upper[1] = max(upper[1], case.fluid_bounds[1][1])
    wide, high = upper - lower
    across = int(np.clip(round(MOST_UP * TALL * wide / high), LEAST_UP, ACROSS))
    up = int(np.clip(round(across * high / (TALL * wide)), LEAST_UP, MOST_UP))
    x = lower[0] + wide * (np.arange(across) + 0.5) / across
    y = upper[1] - high * (np.arange(up) + 0.5) / up
    picture = _filled(case, x, y)
    _thin(case, picture, lower, upper)
    marks = _probes(probes, picture, lower, upper)
    stretch = (high / up) / (TALL * wide / across)
    scale = "" if abs(stretch - 1.0) < 0.15 else f", vertical scale x{1.0 / stretch:.2g}"
    ends = f"x from {lower[0]:g} to {upper[0]:g} m, {upwards} from {lower[1]:g} to {upper[1]:g} m{scale}"
    return "\n".join(["|" + "".join(row) + "|" for row in picture] + [ends, *marks])


def _filled(case: Scene, x: Floats, y: Floats) -> Picture:
    """Return rows of characters for fluid, solid and air."""
    places = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    walls = standing(case)
    free = in_fluid([wall for wall in walls if isinstance(wall.motion, AtRest)], places)
    wet = in_fluid(walls, places)
    wet &= np.any([fill.holds(places) for fill in fillings(case)], axis=0)
    return np.where(wet, WATER, np.where(free, AIR, SOLID)).reshape(len(y), len(x))


def _cell(picture: Picture, lower: Floats, upper: Floats, at: Sequence[float] | Floats) -> tuple[int, int]:
    """Return the row and the column of a place, the nearest ones if it is outside of the picture."""
    up, across = picture.shape
    row = math.floor((upper[1] - at[1]) / (upper[1] - lower[1]) * up)
    column = math.floor((at[0] - lower[0]) / (upper[0] - lower[0]) * across)
    row, column = min(max(row, 0), up - 1), min(max(column, 0), across - 1)
    return row, column


def _thin(case: Scene, picture: Picture, lower: Floats, upper: Floats) -> None:
    """Draw plates and moving walls."""
    for wall in standing(case):
        outline = solid_of(wall)
        if outline.two_sided or not isinstance(wall.motion, AtRest):
            for a, b in outline.elements:
                for part in np.linspace(0.0, 1.0, 4 * ACROSS):
                    picture[_cell(picture, lower, upper, a + part * (b - a))] = WALL


def _probes(probes: Sequence[AnyProbe], picture: Picture, lower: Floats, upper: Floats) -> list[str]:
    """Draw the probes that have a place, and return the legend."""
    found: list[str] = []
    for probe in probes:
        at = getattr(probe, "at", None)
        if at is None:
            continue
        number = len(found) + 1
        mark = str(number) if number < 10 else chr(ord("a") + (number - 10) % 26)
        place = (at, upper[1]) if isinstance(at, float) else (at[0], at[-1])
        picture[_cell(picture, lower, upper, place)] = mark
        found.append(f"{mark} {probe.name}")
    return [", ".join(found)] if found else []
